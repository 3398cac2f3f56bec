"""Every command and every piece of Python of the pages for users runs, from top to bottom of the
page.
"""

import re
import shlex
from pathlib import Path

import pytest

from pitotbench.cli.app import main

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [
    page
    for page in [*(DOCS / "tutorials").glob("*.md"), *(DOCS / "howto").glob("*.md")]
    if page.name
    # They show no command that runs here and ends.
    not in ("read-the-page.md", "correct-a-model.md", "open-a-log.md")
] + [DOCS / name for name in ("api.md", "case.md", "reconcile.md", "scale.md")]
# They fly and judge for ten seconds and more each: `make test-lab` runs them.
LONG = ("student", "engineer", "case", "reconcile", "scale")
# What a page tells of what its commands print.
PRINTED = {
    "drone": "disagree: column 'air_temperature_degc': an air temperature does not rise with"
}
_BLOCK = re.compile(r"^```(console|toml|python|csv)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_README_BLOCK = re.compile(r"^```(?:toml)?\n(.*?)^```", re.MULTILINE | re.DOTALL)
_NUMBER = re.compile(r"\d+(?:\.\d+)?")
_SEEDS = re.compile(r"--seeds \d+")
_NAME = re.compile(r"# (\S+\.(?:toml|csv))\n")


def _run(command: str) -> None:
    program, *words = shlex.split(command, comments=True)
    assert program == "pitotbench", command
    assert main(words) == 0, command


def run_page(page: Path, folder: Path) -> None:
    """Run the commands and the Python of a page in a folder, from top to bottom."""
    blocks = _BLOCK.findall(page.read_text(encoding="utf-8"))
    assert blocks
    for kind, text in blocks:
        if kind == "console":
            for line in text.splitlines():
                if line.startswith("$ "):
                    # One seed of many runs the command; its figures are the laboratory's.
                    _run(_SEEDS.sub("--seeds 1", line.removeprefix("$ ")))
        elif kind == "python":
            exec(compile(text, page.name, "exec"), {})
        elif name := _NAME.match(text):
            (folder / name[1]).write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.stem not in LONG], ids=lambda page: page.stem
)
def test_a_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run_page(page, tmp_path)
    assert PRINTED.get(page.stem, "") in capsys.readouterr().out


def are_alike(told: str, printed: str) -> bool:
    """Whether two lines have the same words, and numbers within a tenth of one another."""
    if _NUMBER.sub("#", told) != _NUMBER.sub("#", printed):
        return False
    pairs = zip(_NUMBER.findall(told), _NUMBER.findall(printed), strict=True)
    return all(float(a) == pytest.approx(float(b), rel=0.1) for a, b in pairs)


def readme_blocks() -> list[str]:
    """The first commands of the README, their case, and what they end in with the last line of the
    case, an effect, and without it.
    """
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    return _README_BLOCK.findall(readme)[:4]


def test_the_readme_ends_as_it_says(tmp_path, monkeypatch, capsys):
    """With the null table of its card that is shipped: no null flight is flown."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("pitotbench.bench.null_flights.open_fleet", None)
    commands, case, told, _ = readme_blocks()
    Path("case.toml").write_text(case, encoding="utf-8")
    for command in commands.splitlines():
        _run(command.replace(" --out gap", ""))
    printed = capsys.readouterr().out.splitlines()
    assert any(are_alike(told.strip(), line) for line in printed), (told, printed)
