"""The table of maneuvers: a newcomer is one file and one line here."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.simulate.maneuvers import (
    circle,
    cloverleaf,
    decel_circle,
    figure_eight,
    four_leg,
    race_track,
    rapid_decel,
    step_both_ways,
    step_decrease,
)
from pitotbench.simulate.maneuvers.card import Card
from pitotbench.simulate.maneuvers.cockpit import Cockpit
from pitotbench.simulate.maneuvers.phases import Ticks


@dataclass(frozen=True, slots=True)
class Maneuver:
    """A maneuver: its card and the logic that flies it.

    `fly(cockpit, card)` yields once a tick. `minutes` is the paper's simulator time (Martos et al. 2011,
    Table 2), None for a maneuver that is not the paper's. `kind` is the label of its on-condition segments.
    """

    name: str
    card: Card
    fly: Callable[[Cockpit, Any], Ticks]
    minutes: float | None
    kind: str

    @property
    def description(self) -> str:
        """The card's docstring: how the paper flies it, with the source, and what is ours."""
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
)

MANEUVERS = Catalog("maneuver", {maneuver.name: maneuver for maneuver in _TABLE})
PAPER_MANEUVERS = tuple(maneuver.name for maneuver in _TABLE if maneuver.minutes is not None)
"""The five of Martos et al. (2011): what `all` means, and what is held against the paper."""
