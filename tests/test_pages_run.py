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
    not in ("read-the-page.md", "correct-a-model.md")  # they show no command that runs here
] + [DOCS / name for name in ("api.md", "case.md", "reconcile.md", "scale.md")]
_BLOCK = re.compile(r"^```(console|toml|python|csv)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_NAME = re.compile(r"# (\S+\.(?:toml|csv))\n")
_SEEDS = re.compile(r"--seeds \d+")


def run(command: str) -> None:
    """Run a command line of a page."""
    program, *words = shlex.split(command, comments=True)
    assert program == "pitotbench", command
    assert main(words) == 0, command


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_page_runs_from_top_to_bottom(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = _BLOCK.findall(page.read_text(encoding="utf-8"))
    assert blocks
    for kind, text in blocks:
        if kind == "console":
            for line in text.splitlines():
                if line.startswith("$ "):
                    # One seed of many runs the command; its figures are the laboratory's.
                    run(_SEEDS.sub("--seeds 1", line.removeprefix("$ ")))
        elif kind == "python":
            exec(compile(text, page.name, "exec"), {})
        elif name := _NAME.match(text):
            (tmp_path / name[1]).write_text(text, encoding="utf-8")
