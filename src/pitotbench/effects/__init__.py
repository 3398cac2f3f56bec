"""The table of physical effects that a case may name: one small file an effect, one line here."""

from collections.abc import Iterable

from pitotbench.catalog import Catalog
from pitotbench.effects.airframe.belly_pod import BELLY_POD
from pitotbench.effects.choice import Choice as Choice
from pitotbench.effects.choice import Named, choose
from pitotbench.effects.das.gps_latency import GPS_LATENCY
from pitotbench.effects.effect import AircraftEffect as AircraftEffect
from pitotbench.effects.effect import AirEffect as AirEffect
from pitotbench.effects.effect import Effect as Effect
from pitotbench.effects.effect import Parameter as Parameter
from pitotbench.effects.effect import SensorEffect as SensorEffect
from pitotbench.effects.overlay import Baseline as Baseline
from pitotbench.effects.overlay import Overlay as Overlay
from pitotbench.effects.pneumatic.line_lag import PITOT_LAG, STATIC_LAG
from pitotbench.effects.signals import Signals as Signals

_ALL: tuple[Effect, ...] = (
    PITOT_LAG,
    STATIC_LAG,
    GPS_LATENCY,
    BELLY_POD,
)

EFFECTS: Catalog[Effect] = Catalog("effect", {effect.name: effect for effect in _ALL})


def chosen(entries: Iterable[Named]) -> tuple[Choice, ...]:
    """The effects that a case's entries name, with their sizes, without those of zero size.

    Raises UnknownNameError for an unknown effect, BadInputError for parameters that cannot be.
    """
    return choose(entries, EFFECTS)
