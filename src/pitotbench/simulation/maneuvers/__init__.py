"""The table of maneuvers.

A new maneuver is an entry on the page of its family, one line here, and its name in
`records/case.py`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.records import BadInputError
from pitotbench.simulation.card import Card
from pitotbench.simulation.maneuvers import (
    decelerations,
    diagnostic,
    straight_legs,
    turns,
)
from pitotbench.simulation.pilot import ALL, Cockpit, Ticks


@dataclass(frozen=True, slots=True)
class Maneuver:
    """A maneuver: its card and the function that flies it.

    `fly(cockpit, card)` yields once a tick. `minutes` is the time in the paper's simulator (Martos
    et al. 2011, Table 2), None for a maneuver that is not the paper's. `kind` begins the label of
    its on-condition segments, for example `leg`; `judged` are the quantities that these hold within
    the card's tolerances. A maneuver that turns on condition does not judge its heading.
    """

    name: str
    card: Card
    fly: Callable[[Cockpit, Any], Ticks]
    minutes: float | None
    kind: str
    judged: tuple[str, ...] = ALL


_TABLE = (
    Maneuver("four_leg", straight_legs.FourLegCard(), straight_legs.fly_four_leg, 21.0, "leg"),
    Maneuver(
        "race_track", straight_legs.RaceTrackCard(), straight_legs.fly_race_track, 15.0, "leg"
    ),
    Maneuver(
        "step_decrease",
        decelerations.StepDecreaseCard(),
        decelerations.fly_step_decrease,
        6.0,
        "step",
        decelerations.JUDGED,
    ),
    Maneuver(
        "rapid_decel",
        decelerations.RapidDecelCard(),
        decelerations.fly_rapid_decel,
        5.0,
        "decel",
        decelerations.JUDGED,
    ),
    Maneuver("circle", turns.CircleCard(), turns.fly_circle, 6.0, "circle", turns.JUDGED),
    Maneuver(
        "step_both_ways",
        decelerations.StepBothWaysCard(),
        decelerations.fly_step_both_ways,
        None,
        "step",
        decelerations.JUDGED,
    ),
    Maneuver(
        "decel_circle",
        turns.DecelCircleCard(),
        turns.fly_decel_circle,
        None,
        "circle",
        turns.JUDGED,
    ),
    Maneuver(
        "figure_eight",
        turns.FigureEightCard(),
        turns.fly_figure_eight,
        None,
        "circle",
        turns.JUDGED,
    ),
    Maneuver(
        "cloverleaf", straight_legs.CloverleafCard(), straight_legs.fly_cloverleaf, None, "leg"
    ),
    Maneuver("diagnostic", diagnostic.DiagnosticCard(), diagnostic.fly_diagnostic, None, "leg"),
)

MANEUVERS = Catalog("maneuver", {maneuver.name: maneuver for maneuver in _TABLE})
PAPER_MANEUVERS = tuple(maneuver.name for maneuver in _TABLE if maneuver.minutes is not None)
"""The five maneuvers of Martos et al. (2011), which are compared with the paper."""
GROUPS: dict[str, tuple[str, ...]] = {"all": PAPER_MANEUVERS, "every": tuple(MANEUVERS)}
"""Words that stand for several maneuvers, the same in every command."""


def maneuvers_named(text: str) -> tuple[str, ...]:
    """Return the names in a list with commas, each once.

    `all` stands for the paper's five, `every` for all.

    Raises UnknownNameError for a name that is not in the table, BadInputError for an empty list.
    """
    chosen = [part.strip() for part in text.split(",") if part.strip()]
    if not chosen:
        raise BadInputError(
            "no maneuver is named: give one, several with commas, all (the paper's five) or every"
        )
    names = [name for part in chosen for name in GROUPS.get(part, (part,))]
    for name in names:
        _ = MANEUVERS[name]  # raises for an unknown name
    return tuple(dict.fromkeys(names))
