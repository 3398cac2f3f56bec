"""The table of effects in words, for the documentation and the command line."""

from collections.abc import Iterable

from pitotbench.effects.effect import Effect, Parameter

_HEADING = (
    "| effect | family | acts on | parameter | typical | range | what it is | best shown by | source |\n"
    "|---|---|---|---|---|---|---|---|---|\n"
)


def effects_table(effects: Iterable[Effect]) -> str:
    """A Markdown table with a line a parameter; the effect's own cells stand on its first line."""
    return _HEADING + "".join(line for effect in effects for line in _lines(effect))


def _lines(effect: Effect) -> list[str]:
    form = f" (another form of `{effect.variant_of}`)" if effect.variant_of else ""
    own = [f"`{effect.name}`: {effect.what.rstrip('.')}{form}", effect.family, effect.acts_on]
    lines = []
    for parameter in effect.parameters:
        last = [str(effect.shows_in), effect.source] if own[0] else ["", ""]
        lines.append("| " + " | ".join([*own, *_cells(parameter), *last]) + " |\n")
        own = ["", "", ""]
    return lines


def _cells(parameter: Parameter) -> list[str]:
    optional = " (optional)" if parameter.shape else ""
    return [
        f"`{parameter.name}`{optional}",
        f"{parameter.typical:g}",
        f"{parameter.low:g} to {parameter.high:g}",
        parameter.what,
    ]
