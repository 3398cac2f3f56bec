"""Templates to HTML. Text is escaped; the templates mark drawings and finished parts as safe."""

from jinja2 import Environment, PackageLoader, StrictUndefined

from pitotbench.show.quantity_words import heading, words


def render(template: str, **content: object) -> str:
    """The HTML of a template of this package."""
    return environment().get_template(template).render(**content)


def environment() -> Environment:
    """The templates of this package; their filters `words` and `heading` turn names into words."""
    found = Environment(
        loader=PackageLoader("pitotbench.show"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    found.filters |= {"heading": heading, "words": words}
    return found
