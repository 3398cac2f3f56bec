"""Faults outside the table of effects, of the log and of the airplane, and their course over a flight."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AircraftEffect, Effect, Parameter, SensorEffect, Sizes, elapsed
from pitotbench.effects.overlay import (
    AxisFunction,
    Baseline,
    Expression,
    Overlay,
    PropertySetting,
    difference,
    operation,
    product,
    quotient,
    size,
)
from pitotbench.effects.propulsion import left_and_right
from pitotbench.effects.response import Signals, delayed, first_order, first_order_varying
from pitotbench.units import FOOT, Array
from pitotlab.blind.forms import OWN_FORMS

Schedule = Callable[[Array], Array]  # of seconds since the first sample; below 0 before it
EDGE = 3.0  # s, in which a part of a flight begins and ends


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the flight, in seconds since the first sample."""

    begin: float
    end: float

    def __call__(self, time: Array) -> Array:
        """Return the share of the effect that acts: 1 within the part, 0 outside, with edges of 3 s."""
        inside = np.minimum((time - self.begin) / EDGE, (self.end - time) / EDGE)
        return np.asarray(np.clip(inside, 0.0, 1.0))


def always(time: Array) -> Array:
    """Act through the whole flight."""
    return np.ones_like(np.asarray(time, dtype=np.float64))


def square(period: float) -> Schedule:
    """Act half of each period [s], with edges of a tenth of it."""
    return lambda time: np.clip(5.0 * np.sin(2.0 * np.pi * np.asarray(time) / period), -0.5, 0.5) + 0.5


def wave(period: float) -> Schedule:
    """Go to and fro with a period [s]."""
    return lambda time: np.sin(2.0 * np.pi * np.asarray(time) / period)


def growing(seconds: float) -> Schedule:
    """Grow from nothing to all within some time [s], and on."""
    return lambda time: np.maximum(0.0, np.asarray(time)) / seconds


def pulses(period: float, last: float) -> Schedule:
    """Act for `last` seconds in each period [s], with smooth edges."""
    return lambda time: np.exp(-0.5 * ((np.mod(np.asarray(time), period) - 0.5 * period) / last) ** 2)


Fault = Callable[[Signals, float], Signals]
GRAVITY = 9.80665
PRESSURE = 3000.0  # Pa, an impact pressure in the midst of the range
SPEED = 70.0  # m/s, likewise


def _added(signals: Signals, **change: Array) -> Signals:
    present = {name: signals[name] + more for name, more in change.items() if name in signals}
    return signals.with_channels(**present)


def _wave(signals: Signals, period: float, phase: float = 0.0) -> Array:
    return np.asarray(np.sin(2.0 * np.pi * elapsed(signals) / period + phase))


def _load(signals: Signals) -> Array:
    """Load factor less one."""
    return np.asarray(-signals["specific_force_z"] / GRAVITY - 1.0)


def _pieces(signals: Signals, seconds: float, seed: int) -> Array:
    """Random numbers of deviation 1, each kept for some seconds."""
    piece = (elapsed(signals) / seconds).astype(np.intp)
    return np.asarray(np.random.default_rng(seed).standard_normal(piece.max() + 1)[piece])


def _static(signals: Signals, error: Array) -> Signals:
    return _added(signals, static_pressure=error, impact_pressure=-error)


def loose_tube(s: Signals, size: float) -> Signals:
    """A pitot tube that rocks: 1 % of the impact pressure with a period of 23 s."""
    return _added(s, impact_pressure=0.01 * size * s["impact_pressure"] * _wave(s, 23.0))


def icing_port(s: Signals, size: float) -> Signals:
    """A static port that ices over: a lag that grows from nothing to 4 s within two minutes."""
    lag = 0.02 + 4.0 * abs(size) * np.clip(elapsed(s) / 120.0, 0.0, 1.5)
    late = first_order_varying(s, s["static_pressure"], lag)
    return _static(s, late - s["static_pressure"])


def open_drain(s: Signals, size: float) -> Signals:
    """A drain hole that opens with the nose high: 1.5 % of the impact pressure."""
    open_share = 0.5 * (1.0 + np.tanh((s["pitch"] - 0.09) / 0.01))
    return _added(s, impact_pressure=-0.015 * size * open_share * s["impact_pressure"])


def rain_in_port(s: Signals, size: float) -> Signals:
    """Drops over the static port: pieces of 6 s with 12 Pa."""
    return _static(s, first_order(s, 12.0 * size * _pieces(s, 6.0, 11), 0.5))


def insect_in_tube(s: Signals, size: float) -> Signals:
    """An insect in the tube, which is blown out slowly: 2 % that decays twice."""
    time = np.mod(elapsed(s), 95.0)
    return _added(s, impact_pressure=-0.02 * size * np.exp(-time / 25.0) * s["impact_pressure"])


def climb_crosstalk(s: Signals, size: float) -> Signals:
    """A leaking case: the impact pressure follows the rate of climb, 4 Pa a meter per second."""
    return _added(s, impact_pressure=-4.0 * size * first_order(s, s["velocity_down"], 2.0))


def heavy_membrane(s: Signals, size: float) -> Signals:
    """A transducer whose membrane feels the load: 25 Pa at each g."""
    return _added(s, impact_pressure=25.0 * size * _load(s))


def kinked_transducer(s: Signals, size: float) -> Signals:
    """A transducer with a kink in the midst of its range and one at each of two others."""
    share = s["impact_pressure"] / 700.0
    return _added(s, impact_pressure=14.0 * size * np.abs(np.mod(share, 2.0) - 1.0))


def strobe_light(s: Signals, size: float) -> Signals:
    """A strobe light on the same ground wire: 15 Pa in the static pressure, beating with a period of 7 s."""
    return _static(s, np.asarray(15.0 * size * (_wave(s, 7.0) > 0.6), dtype=np.float64))


def heated_transducer(s: Signals, size: float) -> Signals:
    """A pitot heater that warms the transducer in cycles of 45 s: a sawtooth of 14 Pa."""
    return _added(s, impact_pressure=14.0 * size * (np.mod(elapsed(s) / 45.0, 1.0) - 0.5))


def bending_boom(s: Signals, size: float) -> Signals:
    """A boom that bends under load: 0.4° of angle of attack at each g."""
    return _added(s, angle_of_attack=0.007 * size * _load(s))


def twisting_boom(s: Signals, size: float) -> Signals:
    """A boom that the slipstream bends aside: 0.5° of sideslip over the range of power."""
    lever = 0.5 * (s["throttle_left"] + s["throttle_right"])
    return _added(s, sideslip=0.009 * size * (lever - lever.mean()) / 0.3)


def late_vane(s: Signals, size: float) -> Signals:
    """Vanes of a slow converter: 0.8 s late."""
    late = {n: first_order(s, s[n], 0.8 * size) for n in ("angle_of_attack", "sideslip")}
    return s.with_channels(**late)


def crossed_vanes(s: Signals, size: float) -> Signals:
    """A sideslip vane that leans: it reads 8 % of angle of attack."""
    return _added(s, sideslip=0.08 * size * s["angle_of_attack"])


def vane_in_wake(s: Signals, size: float) -> Signals:
    """An angle-of-attack vane in the slipstream: 0.6° over the range of power."""
    lever = 0.5 * (s["throttle_left"] + s["throttle_right"])
    return _added(s, angle_of_attack=0.01 * size * (lever - lever.mean()) / 0.3)


def warming_accelerometer(s: Signals, size: float) -> Signals:
    """A forward accelerometer whose zero drifts as the box warms: 0.04 m/s² with a time of 80 s."""
    return _added(s, specific_force_x=0.04 * size * (1.0 - np.exp(-elapsed(s) / 80.0)))


def stretched_accelerometer(s: Signals, size: float) -> Signals:
    """A vertical accelerometer with a scale error that grows with load: 1 % at each g."""
    felt = s["specific_force_z"]
    return _added(s, specific_force_z=0.01 * size * felt * np.abs(felt) / GRAVITY)


def crossed_gyros(s: Signals, size: float) -> Signals:
    """Gyros that feel the other axes: 6 % of yaw rate in roll and in pitch."""
    return _added(s, roll_rate=0.06 * size * s["yaw_rate"], pitch_rate=0.06 * size * s["yaw_rate"])


def leaning_gyro(s: Signals, size: float) -> Signals:
    """A vertical gyro that erects to the apparent vertical: 3 % of bank, and pitch with its square."""
    return _added(s, roll=-0.03 * size * s["roll"], pitch=0.02 * size * s["roll"] ** 2)


def erected_pitch(s: Signals, size: float) -> Signals:
    """A vertical gyro that takes a deceleration for a tilt: a tenth of it, within 20 s."""
    along = first_order(s, s["specific_force_x"] / GRAVITY - np.sin(s["pitch"]), 20.0)
    return _added(s, pitch=0.1 * size * along)


def late_attitude(s: Signals, size: float) -> Signals:
    """An attitude box that is 0.25 s late."""
    late = {n: delayed(s, s[n], 0.25 * abs(size), angle=n == "heading") for n in ("roll", "pitch", "heading")}
    return s.with_channels(**late)


def shaken_accelerometer(s: Signals, size: float) -> Signals:
    """A vertical accelerometer that rectifies vibration: 0.06 m/s² over the range of propeller speed."""
    turning = s["propeller_speed_left"]
    return _added(s, specific_force_z=0.06 * size * (turning / turning.mean() - 1.0) / 0.05)


def swinging_altitude(s: Signals, size: float) -> Signals:
    """A satellite height with multipath: 3 m with a period of 70 s."""
    return _added(s, altitude=3.0 * size * _wave(s, 70.0))


def multipath_bursts(s: Signals, size: float) -> Signals:
    """Satellite velocities with bursts of error: 0.4 m/s, some seconds each, a quarter of the time."""
    found = {}
    for number, name in enumerate(("velocity_north", "velocity_east", "velocity_down")):
        on = np.abs(_pieces(s, 8.0, 20)) > 1.15
        found[name] = first_order(s, 0.4 * size * on * _pieces(s, 4.0, 21 + number), 0.4)
    return _added(s, **found)


def leaping_altitude(s: Signals, size: float) -> Signals:
    """A satellite height that leaps as satellites come and go: 4 m each 35 s."""
    return _added(s, altitude=4.0 * size * _pieces(s, 35.0, 31))


def stale_fixes(s: Signals, size: float) -> Signals:
    """A receiver that stands still for 1.5 s of each 12 s, and then leaps."""
    time = elapsed(s)
    since = np.mod(time, 12.0)
    late = np.where(since < 1.5 * abs(size), since, 0.0)
    names = [n for n in ("velocity_north", "velocity_east", "velocity_down", "altitude") if n in s]
    return s.with_channels(**{n: delayed(s, s[n], late) for n in names})


def stamp_jitter(s: Signals, size: float) -> Signals:
    """Air data whose time stamps jump by 0.3 s to either side, anew each second."""
    late = 0.3 * size * _pieces(s, 1.0, 41)
    names = ("impact_pressure", "static_pressure", "total_temperature")
    return s.with_channels(**{n: delayed(s, s[n], late) for n in names})


def sun_on_probe(s: Signals, size: float) -> Signals:
    """A probe that the sun warms from one side: 0.8 K."""
    return _added(s, total_temperature=0.8 * size * np.maximum(0.0, np.cos(s["heading"] - 1.1)))


def slow_probe(s: Signals, size: float) -> Signals:
    """A temperature probe in a thick well: 15 s late."""
    return s.with_channels(total_temperature=first_order(s, s["total_temperature"], 15.0 * abs(size)))


def exhaust_on_probe(s: Signals, size: float) -> Signals:
    """A probe that feels the exhaust: 1.5 K over the range of power."""
    lever = 0.5 * (s["throttle_left"] + s["throttle_right"])
    return _added(s, total_temperature=1.5 * size * first_order(s, lever, 8.0))


def heated_probe(s: Signals, size: float) -> Signals:
    """A probe with its heater on: 2 K that fall with airspeed."""
    return _added(s, total_temperature=2.0 * size * (PRESSURE / np.maximum(s["impact_pressure"], 500.0)))


def fuel_meter(s: Signals, size: float) -> Signals:
    """A turbine flow meter that reads 4 % too much."""
    return _added(s, fuel_flow_left=0.04 * size * s["fuel_flow_left"])


def slipping_tachometer(s: Signals, size: float) -> Signals:
    """A tachometer that slips: 1 % low on the right."""
    return _added(s, propeller_speed_right=-0.01 * size * s["propeller_speed_right"])


def long_manifold_line(s: Signals, size: float) -> Signals:
    """Manifold pressures through a long line: 1.5 s late."""
    names = ("manifold_pressure_left", "manifold_pressure_right")
    return s.with_channels(**{n: first_order(s, s[n], 1.5 * abs(size)) for n in names})


def bent_elevator_pickup(s: Signals, size: float) -> Signals:
    """An elevator pickup with another lever arm: 12 % too much."""
    return _added(s, elevator=0.12 * size * s["elevator"])


def floating_rudder(s: Signals, size: float) -> Signals:
    """A rudder that the air pushes behind its pickup: 0.6° over the range of airspeed."""
    return _added(s, rudder=0.01 * size * (s["impact_pressure"] / PRESSURE - 1.0))


def pressure_slope(s: Signals, size: float) -> Signals:
    """A pressure field with waves that the airplane crosses in 100 s: 12 Pa."""
    way = np.cumsum(s["velocity_north"]) * s.interval
    return _added(s, static_pressure=12.0 * size * np.sin(2.0 * np.pi * way / (100.0 * SPEED)))


def warm_patches(s: Signals, size: float) -> Signals:
    """Air with warm patches of 2 km: 0.5 K that the probe feels and the pressure does not."""
    return _added(s, total_temperature=first_order(s, 0.5 * size * _pieces(s, 28.0, 51), 5.0))


def sagging_supply(s: Signals, size: float) -> Signals:
    """A supply voltage that sags for 20 s each 50 s: all analog channels read 0.5 % less."""
    low = np.mod(elapsed(s), 50.0) < 20.0
    names = ("impact_pressure", "manifold_pressure_left", "manifold_pressure_right")
    return s.with_channels(**{n: s[n] * (1.0 - 0.005 * size * low) for n in names})


SENSOR_FAULTS: tuple[Fault, ...] = (
    loose_tube, icing_port, open_drain, rain_in_port, insect_in_tube, climb_crosstalk, heavy_membrane,
    kinked_transducer, strobe_light, heated_transducer, bending_boom, twisting_boom, late_vane, crossed_vanes,
    vane_in_wake, warming_accelerometer, stretched_accelerometer, crossed_gyros, leaning_gyro, erected_pitch,
    late_attitude, shaken_accelerometer, swinging_altitude, multipath_bursts, leaping_altitude, stale_fixes,
    stamp_jitter, sun_on_probe, slow_probe, exhaust_on_probe, heated_probe, fuel_meter, slipping_tachometer,
    long_manifold_line, bent_elevator_pickup, floating_rudder, pressure_slope, warm_patches, sagging_supply,
)  # fmt: skip


SIZE = Parameter("size", 1.0, -6.0, 6.0, "hidden")
_QS = ("aero/qbar-psf", "metrics/Sw-sqft")
_QSB = (*_QS, "metrics/bw-ft")


def _pushing(name: str, *functions: tuple[str, Expression]) -> AircraftEffect:
    """An effect that adds functions to aerodynamic axes, each times the size."""

    def build(sizes: Sizes, baseline: Baseline) -> Overlay:
        path = size(name, "size")
        added = tuple(AxisFunction(axis, product(path, value)) for axis, value in functions)
        return Overlay(sizes=((path, sizes["size"]),), functions=added)

    return _as_effect(name, build)


def _as_effect(name: str, build) -> AircraftEffect:  # type: ignore[no-untyped-def]
    known = EFFECTS["belly_pod"]
    assert isinstance(known, AircraftEffect)
    return replace(known, name=name, parameters=(SIZE,), variant_of="", what="hidden", build=build)


def _surging(sizes: Sizes, baseline: Baseline) -> Overlay:
    """The left engine's power falls and rises by 5 %."""
    path = size("surging_engine", "size")
    left, _ = left_and_right("surging_engine", baseline)
    fuel = baseline.engines[left].fuel_per_power
    setting = PropertySetting(
        f"propulsion/engine[{left}]/bsfc-lbs_hphr", quotient(fuel, difference(1.0, product(0.05, path)))
    )
    return Overlay(sizes=((path, sizes["size"]),), settings=(setting,))


def _drag(area: float) -> Expression:
    return product("aero/qbar-psf", area / FOOT**2)


_ALPHA = "aero/alpha-rad"
AIRPLANE_FAULTS: Mapping[str, AircraftEffect] = {
    e.name: e
    for e in (
        _pushing("cowl_flap_cycling", ("DRAG", _drag(0.05))),
        _pushing("fluttering_door", ("DRAG", _drag(0.05)), ("PITCH", product(*_QS, "metrics/cbarw-ft", 0.003))),
        _pushing("fuel_slosh", ("ROLL", product(*_QSB, 0.0012)), ("SIDE", product(*_QS, 0.002))),
        _pushing("baggage_door", ("YAW", product(*_QSB, 0.0012)), ("DRAG", _drag(0.03))),
        _pushing(
            "bending_wing",
            ("LIFT", product(-0.05, "aero/qbar-psf", "aero/qbar-psf", "metrics/Sw-sqft", _ALPHA, 0.01)),
        ),
        _pushing("icing_wing", ("DRAG", _drag(0.08)), ("LIFT", product(*_QS, _ALPHA, -0.25))),
        _pushing("rain_on_wing", ("DRAG", _drag(0.04)), ("LIFT", product(*_QS, _ALPHA, -0.15))),
        _pushing("wake_encounter", ("ROLL", product(*_QSB, 0.003))),
        _pushing("rolling_tanks", ("ROLL", product(*_QSB, 0.002, operation("sin", "attitude/phi-rad")))),
        _as_effect("surging_engine", _surging),
    )
}
SCHEDULES: Mapping[str, Schedule] = {
    "cowl_flap_cycling": square(40.0),
    "fluttering_door": wave(9.0),
    "fuel_slosh": wave(6.5),
    "icing_wing": growing(180.0),
    "rain_on_wing": pulses(90.0, 12.0),
    "wake_encounter": pulses(60.0, 2.0),
    "surging_engine": wave(8.0),
}


def _sensed(fault: Fault) -> SensorEffect:
    """A fault of the sensors as an effect that the recorder applies."""
    known = EFFECTS["pitot_lag"]
    assert isinstance(known, SensorEffect)

    def function(signals: Signals, sizes: Sizes) -> Signals:
        return fault(signals, sizes["size"])

    name = getattr(fault, "__name__", "")
    return replace(
        known, name=name, parameters=(SIZE,), variant_of="", what="hidden", changes=(), needs=(), function=function
    )


OUTSIDERS: Mapping[str, Effect] = {
    **{effect.name: effect for effect in map(_sensed, SENSOR_FAULTS)},
    **AIRPLANE_FAULTS,
}
HIDDEN_EFFECTS: Mapping[str, Effect] = {**OWN_FORMS, **OUTSIDERS}
