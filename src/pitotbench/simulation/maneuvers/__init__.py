"""The table of maneuvers. A new maneuver is one file and one line here."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.records import BadInputError
from pitotbench.simulation.card import Card
from pitotbench.simulation.maneuvers import (
    circle,
    cloverleaf,
    decel_circle,
    diagnostic,
    figure_eight,
    four_leg,
    race_track,
    rapid_decel,
    step_both_ways,
    step_decrease,
)
from pitotbench.simulation.pilot import Cockpit, Ticks


@dataclass(frozen=True, slots=True)
class Maneuver:
    """A maneuver: its card and the function that flies it.

    `fly(cockpit, card)` yields once a tick. `minutes` is the time in the paper's simulator (Martos et al. 2011,
    Table 2), None for a maneuver that is not the paper's. `kind` begins the label of its on-condition segments,
    for example `leg`.
    """

    name: str
    card: Card
    fly: Callable[[Cockpit, Any], Ticks]
    minutes: float | None
    kind: str

    @property
    def description(self) -> str:
        """The card's docstring on one line: how the paper flies the maneuver, the source, and what is ours."""
        return " ".join((type(self.card).__doc__ or "").split())


_TABLE = (
    Maneuver("four_leg", four_leg.FourLegCard(), four_leg.fly, 21.0, "leg"),
    Maneuver("race_track", race_track.RaceTrackCard(), race_track.fly, 15.0, "leg"),
    Maneuver("step_decrease", step_decrease.StepDecreaseCard(), step_decrease.fly, 6.0, "step"),
    Maneuver("rapid_decel", rapid_decel.RapidDecelCard(), rapid_decel.fly, 5.0, "decel"),
    Maneuver("circle", circle.CircleCard(), circle.fly, 6.0, "circle"),
    Maneuver("step_both_ways", step_both_ways.StepBothWaysCard(), step_both_ways.fly, None, "step"),
    Maneuver("decel_circle", decel_circle.DecelCircleCard(), decel_circle.fly, None, "circle"),
    Maneuver("figure_eight", figure_eight.FigureEightCard(), figure_eight.fly, None, "circle"),
    Maneuver("cloverleaf", cloverleaf.CloverleafCard(), cloverleaf.fly, None, "leg"),
    Maneuver("diagnostic", diagnostic.DiagnosticCard(), diagnostic.fly, None, "leg"),
)

MANEUVERS = Catalog("maneuver", {maneuver.name: maneuver for maneuver in _TABLE})
PAPER_MANEUVERS = tuple(maneuver.name for maneuver in _TABLE if maneuver.minutes is not None)
"""The five maneuvers of Martos et al. (2011), which are compared with the paper."""
GROUPS: dict[str, tuple[str, ...]] = {"all": PAPER_MANEUVERS, "every": tuple(MANEUVERS)}
"""Words that stand for several maneuvers, the same in every command."""


def maneuvers_named(text: str) -> tuple[str, ...]:
    """Return the names in a list with commas, each once. `all` stands for the paper's five, `every` for all.

    Raises UnknownNameError for a name that is not in the table, BadInputError for an empty list.
    """
    chosen = [part.strip() for part in text.split(",") if part.strip()]
    if not chosen:
        raise BadInputError("no maneuver is named: give one, several with commas, all (the paper's five) or every")
    names = [name for part in chosen for name in GROUPS.get(part, (part,))]
    for name in names:
        _ = MANEUVERS[name]  # raises for an unknown name
    return tuple(dict.fromkeys(names))
