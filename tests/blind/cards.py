"""The cards of the blind test: few, so that null flights are shared, but of each data system and of either air."""

from pitotbench.records.case import Case
from pitotbench.sense import data_system

_FLOWN = (
    ("rapid_decel", "50/50", "light"),
    ("rapid_decel", "20/1", "none"),
    ("decel_circle", "100/100", "light"),
    ("circle", "50/50", "none"),
)

CARDS = {
    f"{maneuver} {das} {air}": Case(maneuver=maneuver, das=data_system(das), turbulence=air)
    for maneuver, das, air in _FLOWN
}
