"""Write the table of effects in words, for the documentation and the command line."""

from collections.abc import Iterable

from pitotbench.effects.effect import Effect, Parameter

_HEADING = (
    "| effect | family | acts on | parameter | typical | range | what it is | best shown by | source |\n"
    "|---|---|---|---|---|---|---|---|---|\n"
)


def effects_table(effects: Iterable[Effect]) -> str:
    """Return a Markdown table with one line a parameter; the cells of the effect stand on its first line."""
    return _HEADING + "".join(line for effect in effects for line in _lines(effect))


def _lines(effect: Effect) -> list[str]:
    form = f" (another form of `{effect.variant_of}`)" if effect.variant_of else ""
    of_effect = [f"`{effect.name}`: {effect.what.rstrip('.')}{form}", effect.family, effect.acts_on]
    lines = []
    for parameter in effect.parameters:
        last = [str(effect.shows_in), effect.source] if of_effect[0] else ["", ""]
        lines.append("| " + " | ".join([*of_effect, *_cells(parameter), *last]) + " |\n")
        of_effect = ["", "", ""]
    return lines


def _cells(parameter: Parameter) -> list[str]:
    optional = " (optional)" if parameter.shape else ""
    return [
        f"`{parameter.name}`{optional}",
        f"{parameter.typical:g}",
        f"{parameter.low:g} to {parameter.high:g}",
        parameter.what,
    ]
