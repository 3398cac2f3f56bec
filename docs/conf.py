"""The settings of the documentation's site, which `make docs` builds. The pages are Markdown."""

from pitotbench import __version__

project = "pitotbench"
author = "The pitotbench developers"
copyright = f"2026, {author}"  # Sphinx asks for this name
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_copybutton"]
myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
# README.md is the same list for readers of the folder; index.md includes it.
exclude_patterns = ["README.md", "_build"]
suppress_warnings = ["myst.xref_missing"]  # links to files of the repository; a test checks that each exists

autodoc_typehints = "description"
autodoc_member_order = "bysource"
copybutton_prompt_text = "$ "

html_theme = "furo"
html_title = f"pitotbench {version}"
html_copy_source = False
