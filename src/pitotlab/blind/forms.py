"""Forms of known causes that no hypothesis holds: written here, flown by the generator, and known
to nobody else.

Each is `variant_of` the effect of the table whose cause it shares.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import pi
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import (
    ELAPSED,
    AircraftEffect,
    AirEffect,
    Effect,
    Parameter,
    SensorEffect,
    elapsed,
)
from pitotbench.effects.overlay import (
    AxisFunction,
    Baseline,
    Overlay,
    PropertySetting,
    Term,
    WindTerm,
    operation,
    product,
    quotient,
    size,
)
from pitotbench.effects.propulsion import left_and_right
from pitotbench.effects.response import Signals, delayed, first_order, first_order_varying
from pitotbench.units import FOOT, Array

Sizes = Mapping[str, float]
Sensed = Callable[[Signals, Sizes], Signals]
Built = Callable[[Sizes, Baseline], Overlay]
MACH = 0.2  # at which a growing recovery deficit is what its size says
SWING = 90.0  # s, of the load of a data system that makes its latency wander
BEGINS = 100.0  # s, when a late drift begins
REFERENCE = 3000.0  # Pa of impact pressure, 136 KCAS
GROUND = ("velocity_north", "velocity_east", "velocity_down", "altitude")
AIR_DATA = ("impact_pressure", "static_pressure", "total_temperature")


def delayed_by(signals: Signals, seconds: float | Array, *names: str) -> Signals:
    """Return signals of which those with these names that are there come later."""
    late = {}
    for name in filter(signals.__contains__, names):
        late[name] = delayed(signals, signals[name], seconds, angle=name == "heading")
    return signals.with_channels(**late)


def _moved(signals: Signals, moved: Array) -> Signals:
    return signals.with_channels(impact_pressure=signals["impact_pressure"] + moved)


def _one_way_lag(signals: Signals, sizes: Sizes) -> Signals:
    """A flap of dirt: the line fills more slowly than it empties."""
    static = signals["static_pressure"]
    total = signals["impact_pressure"] + static
    fast, slow = (first_order(signals, total, share * sizes["lag_s"]) for share in (0.6, 1.4))
    rising = np.gradient(total, signals.time) > 0.0
    share = first_order(signals, rising.astype(np.float64), 2.0)
    return signals.with_channels(impact_pressure=share * slow + (1.0 - share) * fast - static)


def _wandering_latency(signals: Signals, sizes: Sizes) -> Signals:
    """A latency that goes with the load of the data system."""
    late = sizes["latency_s"] * (1.0 + 0.5 * np.sin(2.0 * pi * elapsed(signals) / SWING))
    return delayed_by(signals, late, *GROUND)


def _late_drift(signals: Signals, sizes: Sizes) -> Signals:
    """A zero that stands still at first and then drifts."""
    return _moved(
        signals, sizes["rate_pa_per_min"] * (np.maximum(0.0, elapsed(signals) - BEGINS) / 60.0)
    )


def _growing_recovery(signals: Signals, sizes: Sizes) -> Signals:
    """A recovery deficit that grows with Mach number."""
    mach = air.mach_from_impact_pressure(
        signals["impact_pressure"].clip(min=0.0), signals["static_pressure"]
    )
    static = air.air_temperature(signals["total_temperature"], mach)
    felt = static * (1.0 + 0.2 * (1.0 - sizes["deficit"] * mach / MACH) * mach**2)
    return signals.with_channels(total_temperature=np.asarray(felt))


def _curved(signals: Signals, sizes: Sizes) -> tuple[Array, Array, Array]:
    minutes = elapsed(signals) / 60.0
    bent = minutes * minutes
    north, east = (sizes[f"{axis}_mps_per_min2"] * bent for axis in ("north", "east"))
    return north, east, np.zeros_like(bent)


def _curving(sizes: Sizes, baseline: Baseline) -> Overlay:
    minutes = product(1.0 / 60.0, ELAPSED)
    paths = {key: size("curved_wind_drift", key) for key in sizes}
    winds = tuple(
        WindTerm(toward, product(path, 1.0 / FOOT, minutes, minutes))
        for toward, path in zip(("north", "east"), paths.values(), strict=True)
    )
    return Overlay(sizes=tuple((path, sizes[key]) for key, path in paths.items()), winds=winds)


def _sensed(name: str, function: Sensed, parent: str, *parameters: Parameter) -> SensorEffect:
    """A form of an effect on the sensors; by default with the first size of the plain effect."""
    known = EFFECTS[parent]
    assert isinstance(known, SensorEffect)
    return replace(known, **_own(name, known, parameters), function=function)


def _felt(name: str, build: Built, parent: str, *parameters: Parameter) -> AircraftEffect:
    """The same of an effect on the airplane."""
    known = EFFECTS[parent]
    assert isinstance(known, AircraftEffect)
    own = replace(known, **_own(name, known, parameters))
    return replace(own, build=lambda _, sizes, baseline: build(sizes, baseline))


def _own(name: str, known: Effect, parameters: tuple[Parameter, ...]) -> dict[str, Any]:
    sizes = parameters or tuple(p for p in known.parameters if not p.shape)[:1]
    return {"name": name, "parameters": sizes, "variant_of": known.cause, "what": "hidden"}


def _dragging(
    name: str, parent: str, key: str, *factors: Term, parameters: tuple[Parameter, ...] = ()
) -> Effect:
    """A form of an effect on drag: the size `key` times dynamic pressure and these factors."""

    def build(sizes: Sizes, baseline: Baseline) -> Overlay:
        path = size(name, key)
        drag = AxisFunction("DRAG", product("aero/qbar-psf", path, *factors))
        return Overlay(sizes=((path, sizes[key]),), functions=(drag,))

    return _felt(name, build, parent, *parameters)


def _wind() -> AirEffect:
    known = EFFECTS["wind_drift"]
    assert isinstance(known, AirEffect)
    parameters = (
        Parameter("north_mps_per_min2", 0.04, -1.0, 1.0, "hidden"),
        Parameter("east_mps_per_min2", -0.03, -1.0, 1.0, "hidden"),
    )
    own = replace(known, **_own("curved_wind_drift", known, parameters))
    return replace(own, build=lambda _, sizes, baseline: _curving(sizes, baseline), wind=_curved)


_FIRST_FORMS: tuple[Effect, ...] = (
    _sensed("one_way_lag", _one_way_lag, "pitot_lag", Parameter("lag_s", 0.4, 0.01, 3.0, "hidden")),
    _sensed(
        "wandering_latency", _wandering_latency, "gps_latency", Parameter("latency_s", 0.3, 0.01, 3.0, "hidden")
    ),
    _sensed("late_drift", _late_drift, "time_drift", Parameter("rate_pa_per_min", 10.0, -200.0, 200.0, "hidden")),
    _sensed(
        "growing_recovery", _growing_recovery, "recovery_deficit", Parameter("deficit", 0.2, -0.2, 1.0, "hidden")
    ),
    _wind(),
    # Drag due to lift that grows with the cube of lift.
    _dragging(
        "cubed_induced_drag", "induced_drag", "factor",
        "metrics/Sw-sqft", "aero/cl-squared", operation("sqrt", "aero/cl-squared"),
        parameters=(Parameter("factor", 0.012, -0.06, 0.1, "hidden"),),
    ),
    # A blunt pod whose drag area falls with Reynolds number, V^-0.6.
    _dragging(
        "slow_pod", "belly_pod", "drag_area_m2", 1.0 / FOOT**2,
        operation("pow", operation("max", 0.1, product(1.0 / 220.0, "velocities/vt-fps")), -0.6),
        parameters=(Parameter("drag_area_m2", 0.1, -0.2, 0.8, "hidden"),),
    ),
)  # fmt: skip
FORMS: Mapping[str, Effect] = {effect.name: effect for effect in _FIRST_FORMS}


def _speed_lag(signals: Signals, sizes: Sizes) -> Signals:
    """A line whose lag falls with the pressure in it."""
    static, impact = signals["static_pressure"], signals["impact_pressure"]
    lag = sizes["lag_s"] * np.clip(REFERENCE / np.maximum(impact, 300.0), 0.3, 3.0)
    late = first_order_varying(signals, impact + static, lag)
    return signals.with_channels(impact_pressure=late - static)


def _two_chamber(signals: Signals, sizes: Sizes) -> Signals:
    """A static line with a bottle in it: two equal lags in a row."""
    static, lag = signals["static_pressure"], 0.5 * sizes["lag_s"]
    late = first_order(signals, first_order(signals, static, lag), lag)
    return signals.with_channels(
        static_pressure=late, impact_pressure=signals["impact_pressure"] + static - late
    )


def _filling_buffer(signals: Signals, sizes: Sizes) -> Signals:
    """Air data from a buffer that fills over 40 s: between 0.6 and 1.4 of the latency."""
    late = sizes["latency_s"] * (0.6 + 0.8 * np.mod(elapsed(signals) / 40.0, 1.0))
    return delayed_by(signals, late, *AIR_DATA)


def _straining_receiver(signals: Signals, sizes: Sizes) -> Signals:
    """A receiver that opens its tracking loop as the airplane accelerates, and is then less late."""
    accelerated = np.hypot(*(np.gradient(signals[n], signals.time) for n in GROUND[:2]))
    late = sizes["lag_s"] * (1.2 - 0.9 * np.tanh(first_order(signals, accelerated, 1.0) / 2.0))
    return delayed_by(signals, late, *GROUND)


def _backlash_growing(signals: Signals, sizes: Sizes) -> Signals:
    """A bellows whose reading lags by a share of the range gone through, its turns rounded."""
    pressure = signals["impact_pressure"]
    rate = np.gradient(first_order(signals, pressure, 3.0), signals.time)
    side = np.tanh(rate / 6.0)
    return signals.with_channels(impact_pressure=pressure - 0.5 * sizes["width_pa"] * side)


def _bent_temperature_drift(signals: Signals, sizes: Sizes) -> Signals:
    """A zero that follows the temperature of its case, 25 s behind the air, and bends."""
    warm = signals["total_temperature"] - signals["total_temperature"][0]
    case = first_order(signals, warm, 25.0)
    return _moved(signals, sizes["shift_pa_per_k"] * case * (1.0 + 0.1 * np.abs(case)))


def _curved_alpha(signals: Signals, sizes: Sizes) -> Signals:
    """A static error with the square of angle of attack above 1.5°."""
    over = np.maximum(0.0, signals["angle_of_attack"] - 0.026)
    return _displaced(
        signals, sizes["slope_per_rad"] * over * (1.0 + over / 0.1) * signals["impact_pressure"]
    )


def _displaced(signals: Signals, error: Array) -> Signals:
    return signals.with_channels(
        static_pressure=signals["static_pressure"] + error,
        impact_pressure=signals["impact_pressure"] - error,
    )


def _leak_by_speed(signals: Signals, sizes: Sizes) -> Signals:
    """A leak that is turbulent: its loss grows with the square root of the pressure only."""
    impact = signals["impact_pressure"]
    lost = sizes["fraction"] * np.sqrt(np.maximum(impact, 0.0) * REFERENCE)
    return signals.with_channels(
        impact_pressure=impact - lost, static_pressure=signals["static_pressure"] + 0.5 * lost
    )


def _lean_power(sizes: Sizes, baseline: Baseline) -> Overlay:
    """Engines that lose a share that grows with the throttle."""
    settings = []
    engines = left_and_right("lean_power", baseline)
    for engine, side, lever in zip(engines, ("left", "right"), ("", "[1]"), strict=True):
        fuel = baseline.engines[engine].fuel_per_power
        size_of = size("lean_power", f"{side}_fraction")
        lost = product(size_of, 1.5, f"fcs/throttle-pos-norm{lever}")
        burnt = quotient(fuel, operation("difference", 1.0, lost))
        settings.append(PropertySetting(f"propulsion/engine[{engine}]/bsfc-lbs_hphr", burnt))
    told = tuple((size("lean_power", key), value) for key, value in sizes.items())
    return Overlay(sizes=told, settings=tuple(settings))


_LATER_FORMS: tuple[Effect, ...] = (
    _sensed("speed_lag", _speed_lag, "pitot_lag"),
    _sensed("two_chamber", _two_chamber, "static_lag"),
    _sensed("filling_buffer", _filling_buffer, "air_data_latency"),
    # A clock that is set right each 30 s by a growing step instead of running slow.
    _sensed(
        "leaping_clock",
        lambda s, sizes: delayed_by(s, 1e-6 * sizes["drift_ppm"] * 30.0 * np.floor(elapsed(s) / 30.0), *GROUND),
        "clock_drift",
    ),
    _sensed("straining_receiver", _straining_receiver, "gps_smoothing"),
    _sensed("rounded_hysteresis", _backlash_growing, "hysteresis"),
    _sensed(
        "logarithmic_drift",
        lambda s, sizes: _moved(s, 3.0 * sizes["rate_pa_per_min"] * np.log1p(elapsed(s) / 40.0) / np.log(5.5)),
        "time_drift",
    ),
    _sensed("late_temperature_drift", _bent_temperature_drift, "temperature_drift"),
    _sensed("curved_alpha_error", _curved_alpha, "alpha_static_error"),
    # A static error of one port: in sideslip from the left only.
    _sensed(
        "one_sided_slip_error",
        lambda s, sizes: _displaced(
            s, sizes["slope_per_rad"] * np.minimum(0.0, s["sideslip"]) * s["impact_pressure"]
        ),
        "sideslip_static_error",
    ),
    # A static error with the square root of power, as the slipstream's speed grows.
    _sensed(
        "root_propwash",
        lambda s, sizes: _displaced(
            s, sizes["pressure_pa"] * np.sqrt(np.maximum(0.0, 0.5 * (s["throttle_left"] + s["throttle_right"])))
        ),
        "propwash_error",
    ),
    _sensed("turbulent_leak", _leak_by_speed, "line_leak"),
    # A probe off by more as it warms up from the cold of the climb.
    _sensed(
        "warming_bias",
        lambda s, sizes: s.with_channels(
            total_temperature=s["total_temperature"] + sizes["bias_k"] * (0.7 + 0.6 * elapsed(s) / 300.0)
        ),
        "temperature_bias",
    ),
    # Drag due to lift with its fourth power.
    _dragging(
        "quartic_induced_drag", "induced_drag", "factor",
        "metrics/Sw-sqft", "aero/cl-squared", "aero/cl-squared", 2.0,
    ),
    # A pod whose drag rises slowly with Mach number.
    _dragging(
        "fast_pod", "belly_pod", "drag_area_m2",
        1.0 / FOOT**2, operation("sum", 0.6, product(2.0, "velocities/mach")),
    ),
    # Drag with the sine of the bank, not its square.
    _dragging(
        "sine_turn_drag", "turn_drag", "coefficient_at_30deg",
        "metrics/Sw-sqft", operation("abs", operation("sin", "attitude/phi-rad")), 2.0,
    ),
    _felt("lean_power", _lean_power, "power_deficit", *EFFECTS["power_deficit"].parameters),
)  # fmt: skip
OWN_FORMS: Mapping[str, Effect] = {**FORMS, **{effect.name: effect for effect in _LATER_FORMS}}
