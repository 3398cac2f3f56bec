"""Templates to HTML; text is escaped, drawings and finished parts are passed through by the templates. Tables to
Markdown."""

from collections.abc import Iterable, Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined


def render(template: str, **content: object) -> str:
    """The HTML of a template of this package."""
    environment = Environment(
        loader=PackageLoader("pitotbench.show"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    return environment.get_template(template).render(**content)


def markdown_table(headings: Sequence[str], rows: Iterable[Iterable[str]]) -> str:
    """A Markdown table of headings and cells."""
    lines = ("| " + " | ".join(cells) + " |" for cells in rows)
    return "\n".join(["| " + " | ".join(headings) + " |", "|" + "---|" * len(headings), *lines])
