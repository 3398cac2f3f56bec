"""The table of physical effects that a case may name. A new effect is one file and one line here."""

from collections.abc import Iterable

from pitotbench.catalog import Catalog
from pitotbench.effects.air import (
    HUMID_AIR,
    NONSTANDARD_TEMPERATURE,
    SEA_BREEZE_FRONT,
    TURBULENCE_LEVEL,
    TURBULENCE_SCALE,
    UPDRAFT,
    WIND_DRIFT,
    WIND_OSCILLATION,
    WIND_SHEAR,
)
from pitotbench.effects.airframe import (
    BELLY_POD,
    CENTER_OF_GRAVITY,
    CONTROL_EFFECTIVENESS,
    FLAP_NOT_UP,
    GEAR_NOT_UP,
    INCLINED_POD,
    INDUCED_DRAG,
    MASS,
    POLAR_BEND,
    TRIM_OFFSET,
    TURN_DRAG,
    TURN_RATE_DRAG,
)
from pitotbench.effects.choice import Choice as Choice
from pitotbench.effects.choice import Named, choose, forms_in_time
from pitotbench.effects.choice import share_of_size as share_of_size
from pitotbench.effects.effect import AircraftEffect as AircraftEffect
from pitotbench.effects.effect import AirEffect as AirEffect
from pitotbench.effects.effect import Effect as Effect
from pitotbench.effects.effect import Excitation as Excitation
from pitotbench.effects.effect import Parameter as Parameter
from pitotbench.effects.effect import SensorEffect as SensorEffect
from pitotbench.effects.formula import FORMULAS as FORMULAS
from pitotbench.effects.overlay import Baseline as Baseline
from pitotbench.effects.overlay import Overlay as Overlay
from pitotbench.effects.pneumatic import (
    ALPHA_STATIC_ERROR,
    CREEP,
    HEIGHT_DEPENDENT_LAG,
    HYSTERESIS,
    IMPACT_PRESSURE_SCALE,
    IMPACT_ZERO_OFFSET,
    INCLINED_PITOT_LOSS,
    LINE_LEAK,
    LOCAL_STATIC_BUMP,
    PITOT_LAG,
    PROPWASH_ERROR,
    SECOND_ORDER_LINE,
    SIDESLIP_STATIC_ERROR,
    STATIC_HYSTERESIS,
    STATIC_LAG,
    STATIC_PRESSURE_SCALE,
    STATIC_SOURCE_CHANGE,
    STATIC_ZERO_OFFSET,
    TEMPERATURE_DRIFT,
    TIME_DRIFT,
    TOTAL_PRESSURE_LOSS,
    WARM_UP_DRIFT,
    WATER_IN_LINE,
)
from pitotbench.effects.propulsion import (
    FRICTION_LOSS,
    GOVERNOR_SPEED,
    MANIFOLD_PRESSURE_GAUGE,
    MANIFOLD_PRESSURE_SCALE,
    POWER_DEFICIT,
    PROPELLER_EFFICIENCY,
    THROTTLE_PICKUP,
    THROTTLE_RIGGING,
)
from pitotbench.effects.recorder import (
    AIR_DATA_LATENCY,
    ALPHA_VANE_CALIBRATION,
    ANTENNA_LEVER_ARM,
    CLOCK_DRIFT,
    COMPASS_DEVIATION,
    DROPPED_SAMPLES,
    GPS_LATENCY,
    GPS_SMOOTHING,
    GPS_VELOCITY_SCALE,
    INERTIAL_UNIT_MISALIGNMENT,
    QUADRANTAL_DEVIATION,
    QUANTIZATION,
    RECOVERY_DEFICIT,
    SAMPLE_AND_HOLD,
    SATURATION,
    SIDESLIP_VANE_CALIBRATION,
    TEMPERATURE_BIAS,
    VANE_FRICTION,
)
from pitotbench.effects.response import Signals as Signals

_ALL: tuple[Effect, ...] = (
    # pneumatic
    ALPHA_STATIC_ERROR,
    SIDESLIP_STATIC_ERROR,
    CREEP,
    HEIGHT_DEPENDENT_LAG,
    HYSTERESIS,
    STATIC_HYSTERESIS,
    PITOT_LAG,
    STATIC_LAG,
    LINE_LEAK,
    LOCAL_STATIC_BUMP,
    PROPWASH_ERROR,
    SECOND_ORDER_LINE,
    STATIC_SOURCE_CHANGE,
    TOTAL_PRESSURE_LOSS,
    INCLINED_PITOT_LOSS,
    TIME_DRIFT,
    TEMPERATURE_DRIFT,
    WARM_UP_DRIFT,
    WATER_IN_LINE,
    IMPACT_ZERO_OFFSET,
    STATIC_ZERO_OFFSET,
    IMPACT_PRESSURE_SCALE,
    STATIC_PRESSURE_SCALE,
    # das
    AIR_DATA_LATENCY,
    ANTENNA_LEVER_ARM,
    CLOCK_DRIFT,
    COMPASS_DEVIATION,
    QUADRANTAL_DEVIATION,
    DROPPED_SAMPLES,
    GPS_LATENCY,
    GPS_SMOOTHING,
    GPS_VELOCITY_SCALE,
    INERTIAL_UNIT_MISALIGNMENT,
    QUANTIZATION,
    SAMPLE_AND_HOLD,
    SATURATION,
    RECOVERY_DEFICIT,
    TEMPERATURE_BIAS,
    ALPHA_VANE_CALIBRATION,
    SIDESLIP_VANE_CALIBRATION,
    VANE_FRICTION,
    # air
    HUMID_AIR,
    NONSTANDARD_TEMPERATURE,
    SEA_BREEZE_FRONT,
    TURBULENCE_LEVEL,
    TURBULENCE_SCALE,
    UPDRAFT,
    WIND_DRIFT,
    WIND_OSCILLATION,
    WIND_SHEAR,
    # airframe
    BELLY_POD,
    CONTROL_EFFECTIVENESS,
    INCLINED_POD,
    INDUCED_DRAG,
    MASS,
    CENTER_OF_GRAVITY,
    FLAP_NOT_UP,
    GEAR_NOT_UP,
    POLAR_BEND,
    TRIM_OFFSET,
    TURN_DRAG,
    TURN_RATE_DRAG,
    # propulsion
    FRICTION_LOSS,
    GOVERNOR_SPEED,
    MANIFOLD_PRESSURE_GAUGE,
    MANIFOLD_PRESSURE_SCALE,
    POWER_DEFICIT,
    PROPELLER_EFFICIENCY,
    THROTTLE_PICKUP,
    THROTTLE_RIGGING,
)

EFFECTS: Catalog[Effect] = Catalog("effect", {effect.name: effect for effect in _ALL})

# The table, and every effect of it from a time on and for a time.
FORMS: Catalog[Effect] = Catalog(
    "effect", {form.name: form for effect in _ALL for form in (effect, *forms_in_time(effect))}
)


def effect_of(name: str) -> Effect:
    """Return an effect of the table in any form, or a formula, by its name. Raises UnknownNameError."""
    return FORMULAS[name] if name in FORMULAS else FORMS[name]


def chosen(entries: Iterable[Named]) -> tuple[Choice, ...]:
    """Return the effects that a case names, with their sizes. Effects of size zero are omitted.

    Raises UnknownNameError for an unknown effect, BadInputError for impossible parameters.
    """
    return choose(entries, Catalog("effect", {**EFFECTS, **FORMULAS}))
