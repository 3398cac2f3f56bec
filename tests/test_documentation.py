"""The pages written by hand agree with each other and with the code."""

import re
from pathlib import Path

import pytest

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


def test_the_index_lists_every_page_of_the_folder() -> None:
    listed = {link for link in links(DOCS / "README.md") if not link.startswith("..")}
    pages = {page.relative_to(DOCS).as_posix() for page in DOCS.rglob("*.md")}
    assert listed == pages - {"README.md", "index.md"}


def test_the_site_lists_every_page_once() -> None:
    entries = re.findall(r"^([\w/-]+)$", (DOCS / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    pages = {page.relative_to(DOCS).with_suffix("").as_posix() for page in DOCS.rglob("*.md")}
    assert sorted(entries) == sorted(pages - {"README", "index"})


def test_the_readme_names_every_package() -> None:
    inside = (ROOT / "README.md").read_text(encoding="utf-8").partition("## Inside")[2]
    packages = {part.name for part in PACKAGE.iterdir() if (part / "__init__.py").exists()}
    assert packages <= set(re.findall(r"`(\w+)`", inside))


def test_the_glossary_explains_each_term_once() -> None:
    rows = [
        line for line in (DOCS / "glossary.md").read_text(encoding="utf-8").splitlines() if line.startswith("|")
    ]
    terms = [row.split("|")[1].strip() for row in rows if not row.startswith(("|---", "| term |"))]
    assert len(terms) > 40
    assert len(terms) == len(set(terms))
