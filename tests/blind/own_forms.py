"""More forms of known causes, written for this test alone: each is `variant_of` the effect of its cause."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from tests.blind.forms import FORMS, Built, Sensed, Sizes

from pitotbench.effects import EFFECTS, AircraftEffect, Baseline, Effect, Overlay, SensorEffect, Signals
from pitotbench.effects.air.recorded_time import elapsed
from pitotbench.effects.effect import Parameter
from pitotbench.effects.expression import Term, operation, product, quotient, size
from pitotbench.effects.overlay import AxisFunction, PropertySetting
from pitotbench.effects.propulsion.engines import left_and_right
from pitotbench.effects.response import delayed, first_order, first_order_varying
from pitotbench.units import FOOT, Array

REFERENCE = 3000.0  # Pa of impact pressure, 136 KCAS
GROUND = ("velocity_north", "velocity_east", "velocity_down", "altitude")


def _gps(signals: Signals) -> list[str]:
    return [name for name in GROUND if name in signals]


def _speed_lag(signals: Signals, sizes: Sizes) -> Signals:
    """A line whose lag falls with the pressure in it."""
    static = signals["static_pressure"]
    lag = sizes["lag_s"] * np.clip(REFERENCE / np.maximum(signals["impact_pressure"], 300.0), 0.3, 3.0)
    return signals.with_channels(
        impact_pressure=first_order_varying(signals, signals["impact_pressure"] + static, lag) - static
    )


def _two_chamber(signals: Signals, sizes: Sizes) -> Signals:
    """A static line with a bottle in it: two equal lags in a row."""
    static, lag = signals["static_pressure"], 0.5 * sizes["lag_s"]
    late = first_order(signals, first_order(signals, static, lag), lag)
    return signals.with_channels(static_pressure=late, impact_pressure=signals["impact_pressure"] + static - late)


def _filling_buffer(signals: Signals, sizes: Sizes) -> Signals:
    """Air data from a buffer that fills over 40 s and is then emptied: between 0.6 and 1.4 of the latency."""
    late = sizes["latency_s"] * (0.6 + 0.8 * np.mod(elapsed(signals) / 40.0, 1.0))
    names = [n for n in ("impact_pressure", "static_pressure", "total_temperature") if n in signals]
    return signals.with_channels(**{n: delayed(signals, signals[n], late) for n in names})


def _leaping_clock(signals: Signals, sizes: Sizes) -> Signals:
    """A clock that is set right each 30 s by a growing step instead of running slow."""
    late = 1e-6 * sizes["drift_ppm"] * 30.0 * np.floor(elapsed(signals) / 30.0)
    return signals.with_channels(**{n: delayed(signals, signals[n], late) for n in _gps(signals)})


def _straining_receiver(signals: Signals, sizes: Sizes) -> Signals:
    """A receiver that opens its tracking loop as the airplane accelerates, and is then less late."""
    accelerated = np.hypot(*(np.gradient(signals[n], signals.time) for n in GROUND[:2]))
    late = sizes["lag_s"] * (1.2 - 0.9 * np.tanh(first_order(signals, accelerated, 1.0) / 2.0))
    return signals.with_channels(**{n: delayed(signals, signals[n], late) for n in _gps(signals)})


def _backlash_growing(signals: Signals, sizes: Sizes) -> Signals:
    """A bellows whose readings differ by a share of the range gone through, with a rounded turning point."""
    pressure = signals["impact_pressure"]
    rate = np.gradient(first_order(signals, pressure, 3.0), signals.time)
    side = np.tanh(rate / 6.0)
    return signals.with_channels(impact_pressure=pressure - 0.5 * sizes["width_pa"] * side)


def _logarithmic_drift(signals: Signals, sizes: Sizes) -> Signals:
    moved = 3.0 * sizes["rate_pa_per_min"] * np.log1p(elapsed(signals) / 40.0) / np.log(5.5)
    return signals.with_channels(impact_pressure=signals["impact_pressure"] + moved)


def _bent_temperature_drift(signals: Signals, sizes: Sizes) -> Signals:
    """A zero that follows the temperature of its own case, 25 s behind the air, and more when it is far away."""
    warm = signals["total_temperature"] - signals["total_temperature"][0]
    case = first_order(signals, warm, 25.0)
    moved = sizes["shift_pa_per_k"] * case * (1.0 + 0.1 * np.abs(case))
    return signals.with_channels(impact_pressure=signals["impact_pressure"] + moved)


def _curved_alpha(signals: Signals, sizes: Sizes) -> Signals:
    """A static error with the square of angle of attack above 1.5°."""
    over = np.maximum(0.0, signals["angle_of_attack"] - 0.026)
    error = sizes["slope_per_rad"] * over * (1.0 + over / 0.1) * signals["impact_pressure"]
    return _displaced(signals, error)


def _one_sided_slip(signals: Signals, sizes: Sizes) -> Signals:
    """A static error of one port: in sideslip from the left only."""
    beta = np.minimum(0.0, signals["sideslip"])
    return _displaced(signals, sizes["slope_per_rad"] * beta * signals["impact_pressure"])


def _pulsing_propwash(signals: Signals, sizes: Sizes) -> Signals:
    """A static error with the square root of power, as the slipstream's speed grows."""
    power = np.sqrt(np.maximum(0.0, 0.5 * (signals["throttle_left"] + signals["throttle_right"])))
    return _displaced(signals, sizes["pressure_pa"] * power)


def _displaced(signals: Signals, error: Array) -> Signals:
    return signals.with_channels(
        static_pressure=signals["static_pressure"] + error, impact_pressure=signals["impact_pressure"] - error
    )


def _leak_by_speed(signals: Signals, sizes: Sizes) -> Signals:
    """A leak that is turbulent: its loss grows with the square root of the pressure only."""
    impact = signals["impact_pressure"]
    lost = sizes["fraction"] * np.sqrt(np.maximum(impact, 0.0) * REFERENCE)
    return signals.with_channels(
        impact_pressure=impact - lost, static_pressure=signals["static_pressure"] + 0.5 * lost
    )


def _seasick_probe(signals: Signals, sizes: Sizes) -> Signals:
    """A probe off by more as it warms up from the cold of the climb."""
    return signals.with_channels(
        total_temperature=signals["total_temperature"] + sizes["bias_k"] * (0.7 + 0.6 * elapsed(signals) / 300.0)
    )


def _drag(path: str, value: float, *factors: Term) -> Overlay:
    return Overlay(
        sizes=((path, value),), functions=(AxisFunction("DRAG", product("aero/qbar-psf", path, *factors)),)
    )


def _quartic(sizes: Sizes, baseline: Baseline) -> Overlay:
    """Drag due to lift with its fourth power."""
    path = size("quartic_induced_drag", "factor")
    return _drag(path, sizes["factor"], "metrics/Sw-sqft", "aero/cl-squared", "aero/cl-squared", 2.0)


def _slipping_pod(sizes: Sizes, baseline: Baseline) -> Overlay:
    """A pod whose drag rises slowly with Mach number."""
    path = size("fast_pod", "drag_area_m2")
    grows = operation("sum", 0.6, product(2.0, "velocities/mach"))
    return _drag(path, sizes["drag_area_m2"], 1.0 / FOOT**2, grows)


def _bank_drag(sizes: Sizes, baseline: Baseline) -> Overlay:
    """Drag with the sine of the bank, not its square."""
    path = size("sine_turn_drag", "coefficient_at_30deg")
    sine = operation("abs", operation("sin", "attitude/phi-rad"))
    return _drag(path, sizes["coefficient_at_30deg"], "metrics/Sw-sqft", sine, 2.0)


def _lean_power(sizes: Sizes, baseline: Baseline) -> Overlay:
    """Engines that lose a share that grows with the throttle."""
    settings = []
    for engine, (key, lever) in zip(
        left_and_right("lean_power", baseline),
        (("left_fraction", "fcs/throttle-pos-norm"), ("right_fraction", "fcs/throttle-pos-norm[1]")),
        strict=True,
    ):
        fuel = baseline.engines[engine].fuel_per_power
        lost = product(size("lean_power", key), 1.5, lever)
        settings.append(
            PropertySetting(
                f"propulsion/engine[{engine}]/bsfc-lbs_hphr", quotient(fuel, operation("difference", 1.0, lost))
            )
        )
    return Overlay(sizes=tuple((size("lean_power", k), v) for k, v in sizes.items()), settings=tuple(settings))


def _sensed(name: str, function: Sensed, parent: str, *parameters: Parameter) -> SensorEffect:
    known = EFFECTS[parent]
    assert isinstance(known, SensorEffect)
    return replace(
        known, name=name, parameters=parameters, variant_of=known.cause, what="hidden", function=function
    )


def _felt(name: str, build: Built, parent: str, *parameters: Parameter) -> AircraftEffect:
    known = EFFECTS[parent]
    assert isinstance(known, AircraftEffect)
    return replace(known, name=name, parameters=parameters, variant_of=known.cause, what="hidden", build=build)


def _one(parent: str, name: str = "") -> Parameter:
    """The first size of the plain effect, or the one named."""
    return next(p for p in EFFECTS[parent].parameters if (p.name == name or not name) and not p.shape)


_ALL: tuple[Effect, ...] = (
    _sensed("speed_lag", _speed_lag, "pitot_lag", _one("pitot_lag")),
    _sensed("two_chamber", _two_chamber, "static_lag", _one("static_lag")),
    _sensed("filling_buffer", _filling_buffer, "air_data_latency", _one("air_data_latency")),
    _sensed("leaping_clock", _leaping_clock, "clock_drift", _one("clock_drift")),
    _sensed("straining_receiver", _straining_receiver, "gps_smoothing", _one("gps_smoothing")),
    _sensed("rounded_hysteresis", _backlash_growing, "hysteresis", _one("hysteresis")),
    _sensed("logarithmic_drift", _logarithmic_drift, "time_drift", _one("time_drift")),
    _sensed("late_temperature_drift", _bent_temperature_drift, "temperature_drift", _one("temperature_drift")),
    _sensed("curved_alpha_error", _curved_alpha, "alpha_static_error", _one("alpha_static_error")),
    _sensed("one_sided_slip_error", _one_sided_slip, "sideslip_static_error", _one("sideslip_static_error")),
    _sensed("root_propwash", _pulsing_propwash, "propwash_error", _one("propwash_error")),
    _sensed("turbulent_leak", _leak_by_speed, "line_leak", _one("line_leak")),
    _sensed("warming_bias", _seasick_probe, "temperature_bias", _one("temperature_bias")),
    _felt("quartic_induced_drag", _quartic, "induced_drag", _one("induced_drag")),
    _felt("fast_pod", _slipping_pod, "belly_pod", _one("belly_pod")),
    _felt("sine_turn_drag", _bank_drag, "turn_drag", _one("turn_drag")),
    _felt("lean_power", _lean_power, "power_deficit", *EFFECTS["power_deficit"].parameters),
)
OWN_FORMS: Mapping[str, Effect] = {**FORMS, **{effect.name: effect for effect in _ALL}}
