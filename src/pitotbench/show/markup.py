"""Templates to HTML. Text is escaped; the templates mark drawings and finished parts as safe."""

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
