"""The settings of the documentation's site, which `make docs` builds. The pages are Markdown."""

import re

from pitotbench import __version__

project = "pitotbench"
author = "The pitotbench developers"
copyright = f"2026, {author}"  # Sphinx asks for this name
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton"]
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
root_doc = "README"
exclude_patterns = ["_build"]
suppress_warnings = [
    "myst.xref_missing"
]  # links to files of the repository; a test checks that each exists

autodoc_typehints = "description"
autodoc_member_order = "bysource"
copybutton_prompt_text = "$ "

html_theme = "furo"
html_title = f"pitotbench {version}"
html_copy_source = False


def toctrees(index: str) -> str:
    """The site's navigation: for each heading of the index, the pages that the list below it links to."""
    parts = [part.partition("\n") for part in index.split("\n## ")[1:]]
    return "".join(
        f"\n```{{toctree}}\n:hidden:\n:caption: {heading}\n\n" + "\n".join(pages) + "\n```\n"
        for heading, _, text in parts
        if (pages := re.findall(r"\]\(([\w/-]+)\.md\)", text))
    )


def _add_navigation(app, page: str, source: list[str]) -> None:
    if page == root_doc:
        source[0] += toctrees(source[0])


def setup(app) -> None:
    """Give the index its navigation while Sphinx reads it: readers of the folder see the lists alone."""
    app.connect("source-read", _add_navigation)
