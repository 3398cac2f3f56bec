"""Templates to HTML; text is escaped, drawings and finished parts are passed through by the templates."""

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
