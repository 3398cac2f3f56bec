"""The pages written by hand agree with each other and with the code."""

import re
import runpy
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from pitotbench import Case, __version__
from pitotbench.reconciliation.thresholds import Thresholds
from pitotbench.records import USUAL_ACCURACIES
from pitotbench.records.case_file import case_table
from pitotbench.simulation.card import Card
from pitotlab.tables import TABLES, card_numbers, pages

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
PACKAGE = ROOT / "src" / "pitotbench"
_LINK = re.compile(r"\]\(([^)#\s]+)(?:#[^)]*)?\)")


def links(page: Path) -> list[str]:
    return [link for link in _LINK.findall(page.read_text(encoding="utf-8")) if "://" not in link]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_every_link_of_a_page_leads_to_a_file(page: Path) -> None:
    missing = [link for link in links(page) if not (page.parent / link).exists()]
    assert not missing


def test_the_index_and_the_site_list_every_page_of_the_folder_once() -> None:
    listed = {link for link in links(DOCS / "README.md") if link.endswith(".md")}
    pages = {page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md")} - {"README.md"}
    assert listed == pages
    index = (DOCS / "README.md").read_text(encoding="utf-8")
    entries = re.findall(
        r"^([\w/-]+)$", runpy.run_path(str(DOCS / "conf.py"))["toctrees"](index), re.MULTILINE
    )
    assert sorted(entries) == sorted(page.removesuffix(".md") for page in pages)


def test_changelog_citation_and_code_name_one_version() -> None:
    sections = re.findall(r"^## (\S+)", (DOCS / "CHANGELOG.md").read_text("utf-8"), re.M)
    assert sections[0] in ("Unreleased", __version__)
    assert next(name for name in sections if name != "Unreleased") == __version__
    assert f"\nversion: {__version__}\n" in (DOCS / "CITATION.cff").read_text("utf-8")


def test_the_workflow_of_each_system_gives_the_commands_of_the_readme() -> None:
    """Those without make, in the environment that the system brings in place of `.venv`."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    _, *commands = readme.partition("Without `make`:\n\n```\n")[2].partition("```")[0].splitlines()
    workflow = (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")
    given = re.findall(r"- run: (.+)", workflow)
    assert given == [command.removeprefix(".venv/bin/") for command in commands]


def test_every_number_of_the_paper_is_one_of_the_page_of_numbers() -> None:
    number = re.compile(r"\d+(?:,\d{3})*(?:\.\d+)?")
    page = re.sub("<!--.*?-->", "", (DOCS / "how-good-is-it.md").read_text(encoding="utf-8"))
    paper = (DOCS / "paper.md").read_text(encoding="utf-8").partition("## References")[0]
    plain = re.sub(r"\b(19|20)\d\d\b|±2σ", "", paper)  # without the years of what is cited
    assert set(number.findall(plain)) <= set(number.findall(page))


def test_every_picture_is_shown() -> None:
    shown = {(page.parent / link).resolve() for page in PAGES for link in links(page)}
    assert set(DOCS.rglob("*.png")) <= shown


def test_the_page_for_contributors_names_every_package() -> None:
    inside = (
        (DOCS / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("## Where things are")[2]
    )
    packages = {part.name for part in PACKAGE.iterdir() if (part / "__init__.py").exists()}
    assert packages <= set(re.findall(r"`(\w+)`", inside))


def test_each_step_to_a_probability_stands_where_the_page_says() -> None:
    page = (DOCS / "howto" / "extend.md").read_text(encoding="utf-8")
    steps = re.findall(r"^\| [^|]+ \| ([^|]+) \| `([\w/]+\.py)` \|([^|]*)\|", page, re.MULTILINE)
    assert steps
    for functions, file, numbers in steps:
        code = (PACKAGE / file).read_text(encoding="utf-8")
        for name in re.findall(r"`(\w+)`", functions):
            assert f"def {name}(" in code, (name, file)
        assert set(re.findall(r"`(\w+)`", numbers)) <= {each.name for each in fields(Thresholds)}


def test_the_glossary_explains_each_term_once() -> None:
    rows = [
        line
        for line in (DOCS / "glossary.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("|")
    ]
    terms = [row.split("|")[1].strip() for row in rows if not row.startswith(("|---", "| term |"))]
    assert len(terms) > 40
    assert len(terms) == len(set(terms))


def entries_of(text: str) -> dict[str, Any]:
    """The entries of a table of the page on cases, with their defaults; `none` is an empty list."""
    rows = re.findall(r"^\| (`[^|]+`) \| ([^|]+) \|", text, re.MULTILINE)
    told = {}
    for names, default in rows:
        for name in re.findall(r"`(\w+)`", names):
            written = default.strip().strip("`")
            told[name] = [] if written == "none" else tomllib.loads(f"a = {written}")["a"]
    return told


def test_the_page_on_cases_holds_every_entry_with_its_default() -> None:
    parts = dict(
        part.split("\n", 1)
        for part in (DOCS / "case.md").read_text(encoding="utf-8").split("\n## ")[1:]
    )
    case = case_table(Case())
    sections = {name: case.pop(name) for name in ("wind", "pressure_error", "das")}
    del case["card"], case["accuracy"]
    assert entries_of(parts["The flight"]) == case
    for name, section in sections.items():
        assert entries_of(parts[f"`[{name}]`"]) == section
    assert entries_of(parts["`[card]`"].partition("| maneuver |")[0]) == card_numbers(Card())


@pytest.mark.parametrize("page", sorted({page for page, _ in TABLES}))
def test_the_tables_that_repeat_the_code_are_written_from_it(page: str) -> None:
    """Where this fails, `make docs-tables` writes them anew."""
    assert (DOCS / page).read_text(encoding="utf-8") == pages()[page]


@pytest.mark.parametrize(
    ("page", "told"),
    [
        ("docs/method.md", "temperature {temperature_k} K, recovery factor {recovery_factor}, "
                           "static pressure "
         "{static_pressure_pa} Pa, GPS velocity {velocity_mps} m/s"),
        ("docs/log.md", "`temperature_k` {temperature_k} K, `recovery_factor` {recovery_factor}, "
         "`static_pressure_pa` {static_pressure_pa} Pa, `velocity_mps` {velocity_mps} m/s"),
        ("docs/CHANGELOG.md", "{temperature_k} K, {recovery_factor} of recovery factor, "
                              "{static_pressure_pa} Pa, "
         "{velocity_mps} m/s"),
        ("docs/which-maneuver.md", "({temperature_k} K, {static_pressure_pa} Pa, {velocity_mps} "
                                   "m/s, 2σ)"),
    ],
)  # fmt: skip
def test_a_page_tells_the_usual_accuracies(page: str, told: str) -> None:
    usual = {name: f"{value:g}" for name, value in USUAL_ACCURACIES.items()}
    assert told.format(**usual) in " ".join((ROOT / page).read_text(encoding="utf-8").split())
