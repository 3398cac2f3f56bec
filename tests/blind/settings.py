"""The settings of the blind test: what was flown, and what the header of a log tells of it.

The header tells the card, the data system, the air and a planned height, as a card of a flight test does. It tells
neither the day's temperature nor the pilot nor the loading: the mass column holds the mass. So most null flights
that a tool flies for a log are of another day, pilot, fuel or height than the log.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pitotbench.records.case import Case
from pitotbench.sense import data_system
from pitotbench.units import FOOT

RAPID = {"dwell_s": 20.0, "settle_s": 10.0}
SHORT_CIRCLE = {"speeds_kt": [150.0, 110.0]}
SHORT_TURN = {"dwells_s": [25.0, 40.0, 25.0]}


@dataclass(frozen=True, slots=True)
class Setting:
    """`flown` is the case without wind, error curve, effects and seeds; `told` is that of the header."""

    flown: Case
    told: Case


def _setting(
    maneuver: str,
    card: Mapping[str, Any],
    das: str,
    air: str,
    feet: float,
    planned: float = 0.0,
    **day: Any,
) -> Setting:
    """`planned` is the height [ft] of the header where it is not the one flown; `day` is what no header tells."""
    told = Case(
        maneuver=maneuver,
        card=card,
        das=data_system(das),
        turbulence=air,
        altitude=(planned or feet) * FOOT,
    )
    return Setting(replace(told, altitude=feet * FOOT, **day), told)


SETTINGS: Mapping[str, Setting] = {
    "A": _setting("rapid_decel", RAPID, "50/50", "light", 6000, temperature_offset=8.0, pilot="good", fuel=0.62),
    "B": _setting("rapid_decel", RAPID, "20/5", "none", 4000, temperature_offset=-12.0),
    "C": _setting("decel_circle", SHORT_TURN, "50/10", "light", 6000, fuel=0.81),
    "D": _setting(
        "decel_circle", {**SHORT_TURN, "bank_deg": 40.0}, "100/100", "none", 8000, 6000, temperature_offset=14.0
    ),
    "E": _setting("circle", SHORT_CIRCLE, "50/50", "light", 5000, pilot="busy", temperature_offset=-8.0),
    "F": _setting("circle", SHORT_CIRCLE, "20/1", "none", 6000, temperature_offset=5.0, fuel=0.5),
    "G": _setting("rapid_decel", RAPID, "25/5", "moderate", 6000, 7000, ballast=120.0),
    "H": _setting("decel_circle", SHORT_TURN, "20/10", "moderate", 7000, pilot="good", fuel=0.7),
    "I": _setting("circle", SHORT_CIRCLE, "50/10", "light", 4500, 6000, temperature_offset=11.0),
    "J": _setting("rapid_decel", RAPID, "100/20", "none", 9000, pilot="busy", fuel=0.42),
    "K": _setting("decel_circle", SHORT_TURN, "20/1", "none", 5000, ballast=-100.0, temperature_offset=-5.0),
    "L": _setting("figure_eight", {"speeds_kt": [150.0, 110.0]}, "50/10", "light", 6000),
    "M": _setting("race_track", {"speeds_kt": [150.0, 110.0], "dwell_s": 25.0}, "50/50", "light", 6000, fuel=0.55),
    "N": _setting("four_leg", {"speeds_kt": [140.0, 105.0]}, "20/5", "light", 5500, 5000, pilot="good"),
    "O": _setting("diagnostic", {}, "50/10", "light", 6000, temperature_offset=-10.0, fuel=0.75),
}
DEVELOPMENT = ("A", "B", "C", "D", "F", "G")
