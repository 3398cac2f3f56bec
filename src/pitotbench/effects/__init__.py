"""The table of physical effects that a case may name. A new effect is one file and one line here."""

from collections.abc import Iterable

from pitotbench.catalog import Catalog
from pitotbench.effects.air.humid_air import HUMID_AIR
from pitotbench.effects.air.nonstandard_temperature import NONSTANDARD_TEMPERATURE
from pitotbench.effects.air.sea_breeze_front import SEA_BREEZE_FRONT
from pitotbench.effects.air.turbulence_level import TURBULENCE_LEVEL
from pitotbench.effects.air.turbulence_scale import TURBULENCE_SCALE
from pitotbench.effects.air.updraft import UPDRAFT
from pitotbench.effects.air.wind_drift import WIND_DRIFT
from pitotbench.effects.air.wind_oscillation import WIND_OSCILLATION
from pitotbench.effects.air.wind_shear import WIND_SHEAR
from pitotbench.effects.airframe.belly_pod import BELLY_POD
from pitotbench.effects.airframe.control_effectiveness import CONTROL_EFFECTIVENESS
from pitotbench.effects.airframe.inclined_pod import INCLINED_POD
from pitotbench.effects.airframe.induced_drag import INDUCED_DRAG
from pitotbench.effects.airframe.loading import CENTER_OF_GRAVITY, MASS
from pitotbench.effects.airframe.not_retracted import FLAP_NOT_UP, GEAR_NOT_UP
from pitotbench.effects.airframe.polar_bend import POLAR_BEND
from pitotbench.effects.airframe.trim_offset import TRIM_OFFSET
from pitotbench.effects.airframe.turn_drag import TURN_DRAG
from pitotbench.effects.airframe.turn_rate_drag import TURN_RATE_DRAG
from pitotbench.effects.choice import Choice as Choice
from pitotbench.effects.choice import Named, choose
from pitotbench.effects.das.air_data_latency import AIR_DATA_LATENCY
from pitotbench.effects.das.antenna_lever_arm import ANTENNA_LEVER_ARM
from pitotbench.effects.das.clock_drift import CLOCK_DRIFT
from pitotbench.effects.das.compass_deviation import COMPASS_DEVIATION, QUADRANTAL_DEVIATION
from pitotbench.effects.das.dropped_samples import DROPPED_SAMPLES
from pitotbench.effects.das.gps_latency import GPS_LATENCY
from pitotbench.effects.das.gps_smoothing import GPS_SMOOTHING
from pitotbench.effects.das.gps_velocity_scale import GPS_VELOCITY_SCALE
from pitotbench.effects.das.inertial_unit_misalignment import INERTIAL_UNIT_MISALIGNMENT
from pitotbench.effects.das.quantization import QUANTIZATION
from pitotbench.effects.das.sample_and_hold import SAMPLE_AND_HOLD
from pitotbench.effects.das.saturation import SATURATION
from pitotbench.effects.das.temperature_probe import RECOVERY_DEFICIT, TEMPERATURE_BIAS
from pitotbench.effects.das.vane_calibration import ALPHA_VANE_CALIBRATION, SIDESLIP_VANE_CALIBRATION
from pitotbench.effects.das.vane_friction import VANE_FRICTION
from pitotbench.effects.effect import AircraftEffect as AircraftEffect
from pitotbench.effects.effect import AirEffect as AirEffect
from pitotbench.effects.effect import Effect as Effect
from pitotbench.effects.effect import Parameter as Parameter
from pitotbench.effects.effect import SensorEffect as SensorEffect
from pitotbench.effects.excitation import Excitation as Excitation
from pitotbench.effects.formula import FORMULAS as FORMULAS
from pitotbench.effects.overlay import Baseline as Baseline
from pitotbench.effects.overlay import Overlay as Overlay
from pitotbench.effects.part_of_flight import forms_in_time
from pitotbench.effects.part_of_flight import share_of_size as share_of_size
from pitotbench.effects.pneumatic.attitude_static_error import ALPHA_STATIC_ERROR, SIDESLIP_STATIC_ERROR
from pitotbench.effects.pneumatic.creep import CREEP
from pitotbench.effects.pneumatic.height_dependent_lag import HEIGHT_DEPENDENT_LAG
from pitotbench.effects.pneumatic.hysteresis import HYSTERESIS, STATIC_HYSTERESIS
from pitotbench.effects.pneumatic.line_lag import PITOT_LAG, STATIC_LAG
from pitotbench.effects.pneumatic.line_leak import LINE_LEAK
from pitotbench.effects.pneumatic.local_static_bump import LOCAL_STATIC_BUMP
from pitotbench.effects.pneumatic.propwash_error import PROPWASH_ERROR
from pitotbench.effects.pneumatic.second_order_line import SECOND_ORDER_LINE
from pitotbench.effects.pneumatic.static_source_change import STATIC_SOURCE_CHANGE
from pitotbench.effects.pneumatic.total_pressure_loss import INCLINED_PITOT_LOSS, TOTAL_PRESSURE_LOSS
from pitotbench.effects.pneumatic.transducer_drift import TEMPERATURE_DRIFT, TIME_DRIFT
from pitotbench.effects.pneumatic.transducer_scale import IMPACT_PRESSURE_SCALE, STATIC_PRESSURE_SCALE
from pitotbench.effects.pneumatic.warm_up_drift import WARM_UP_DRIFT
from pitotbench.effects.pneumatic.water_in_line import WATER_IN_LINE
from pitotbench.effects.pneumatic.zero_offset import IMPACT_ZERO_OFFSET, STATIC_ZERO_OFFSET
from pitotbench.effects.propulsion.friction_loss import FRICTION_LOSS
from pitotbench.effects.propulsion.governor_speed import GOVERNOR_SPEED
from pitotbench.effects.propulsion.manifold_pressure_gauge import MANIFOLD_PRESSURE_GAUGE, MANIFOLD_PRESSURE_SCALE
from pitotbench.effects.propulsion.power_deficit import POWER_DEFICIT
from pitotbench.effects.propulsion.propeller_efficiency import PROPELLER_EFFICIENCY
from pitotbench.effects.propulsion.throttle_pickup import THROTTLE_PICKUP
from pitotbench.effects.propulsion.throttle_rigging import THROTTLE_RIGGING
from pitotbench.effects.signals import Signals as Signals

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
