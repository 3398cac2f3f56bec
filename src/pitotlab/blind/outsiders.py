"""Faults outside the table of effects, of the log and of the airplane, and their course over a
flight.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import (
    AircraftEffect,
    Effect,
    Parameter,
    SensorEffect,
    Sizes,
    elapsed,
)
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
from pitotbench.effects.response import Signals, first_order, first_order_varying
from pitotbench.units import FOOT, Array
from pitotlab.blind.forms import AIR_DATA, GROUND, OWN_FORMS, delayed_by

Schedule = Callable[[Array], Array]  # of seconds since the first sample; below 0 before it
EDGE = 3.0  # s, in which a part of a flight begins and ends


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the flight, in seconds since the first sample."""

    begin: float
    end: float

    def __call__(self, time: Array) -> Array:
        """Return the share of the effect that acts: 1 within the part, 0 outside, 3 s edges."""
        inside = np.minimum((time - self.begin) / EDGE, (self.end - time) / EDGE)
        return np.asarray(np.clip(inside, 0.0, 1.0))


def square(period: float) -> Schedule:
    """Act half of each period [s], with edges of a tenth of it."""
    return lambda time: (
        np.clip(5.0 * np.sin(2.0 * np.pi * np.asarray(time) / period), -0.5, 0.5) + 0.5
    )


def wave(period: float) -> Schedule:
    """Go to and fro with a period [s]."""
    return lambda time: np.sin(2.0 * np.pi * np.asarray(time) / period)


def growing(seconds: float) -> Schedule:
    """Grow from nothing to all within some time [s], and on."""
    return lambda time: np.maximum(0.0, np.asarray(time)) / seconds


def pulses(period: float, last: float) -> Schedule:
    """Act for `last` seconds in each period [s], with smooth edges."""
    return lambda time: np.exp(
        -0.5 * ((np.mod(np.asarray(time), period) - 0.5 * period) / last) ** 2
    )


Fault = Callable[[Signals, float], Signals]
MANIFOLD = ("manifold_pressure_left", "manifold_pressure_right")
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


def _late(signals: Signals, seconds: float, *names: str) -> Signals:
    return signals.with_channels(
        **{name: first_order(signals, signals[name], seconds) for name in names}
    )


def _lever(signals: Signals) -> Array:
    return np.asarray(0.5 * (signals["throttle_left"] + signals["throttle_right"]))


def _power(signals: Signals) -> Array:
    """The levers less their mean."""
    return np.asarray(_lever(signals) - _lever(signals).mean())


def _icing_port(s: Signals, size: float) -> Signals:
    lag = 0.02 + 4.0 * abs(size) * np.clip(elapsed(s) / 120.0, 0.0, 1.5)
    late = first_order_varying(s, s["static_pressure"], lag)
    return _static(s, late - s["static_pressure"])


def _multipath_bursts(s: Signals, size: float) -> Signals:
    found = {}
    for number, name in enumerate(GROUND[:3]):
        on = np.abs(_pieces(s, 8.0, 20)) > 1.15
        found[name] = first_order(s, 0.4 * size * on * _pieces(s, 4.0, 21 + number), 0.4)
    return _added(s, **found)


def _stale_fixes(s: Signals, size: float) -> Signals:
    since = np.mod(elapsed(s), 12.0)
    return delayed_by(s, np.where(since < 1.5 * abs(size), since, 0.0), *GROUND)


SENSOR_FAULTS: Mapping[str, Fault] = {
    # A pitot tube that rocks: 1 % of the impact pressure with a period of 23 s.
    "loose_tube": lambda s, size: _added(
        s, impact_pressure=0.01 * size * s["impact_pressure"] * _wave(s, 23.0)
    ),
    # A static port that ices over: a lag that grows from nothing to 4 s within two minutes.
    "icing_port": _icing_port,
    # A drain hole that opens with the nose high: 1.5 % of the impact pressure.
    "open_drain": lambda s, size: _added(
        s,
        impact_pressure=-0.015
        * size
        * (0.5 * (1.0 + np.tanh((s["pitch"] - 0.09) / 0.01)))
        * s["impact_pressure"],
    ),
    # Drops over the static port: pieces of 6 s with 12 Pa.
    "rain_in_port": lambda s, size: _static(
        s, first_order(s, 12.0 * size * _pieces(s, 6.0, 11), 0.5)
    ),
    # An insect in the tube, which is blown out slowly: 2 % that decays twice.
    "insect_in_tube": lambda s, size: _added(
        s,
        impact_pressure=-0.02
        * size
        * np.exp(-np.mod(elapsed(s), 95.0) / 25.0)
        * s["impact_pressure"],
    ),
    # A leaking case: the impact pressure follows the rate of climb, 4 Pa a meter per second.
    "climb_crosstalk": lambda s, size: _added(
        s, impact_pressure=-4.0 * size * first_order(s, s["velocity_down"], 2.0)
    ),
    # A transducer whose membrane feels the load: 25 Pa at each g.
    "heavy_membrane": lambda s, size: _added(s, impact_pressure=25.0 * size * _load(s)),
    # A transducer with a kink in the midst of its range and one at each of two others.
    "kinked_transducer": lambda s, size: _added(
        s, impact_pressure=14.0 * size * np.abs(np.mod(s["impact_pressure"] / 700.0, 2.0) - 1.0)
    ),
    # A strobe light on the same ground wire: 15 Pa in the static pressure, beating with a period of
    # 7 s.
    "strobe_light": lambda s, size: _static(
        s, np.asarray(15.0 * size * (_wave(s, 7.0) > 0.6), dtype=np.float64)
    ),
    # A pitot heater that warms the transducer in cycles of 45 s: a sawtooth of 14 Pa.
    "heated_transducer": lambda s, size: _added(
        s, impact_pressure=14.0 * size * (np.mod(elapsed(s) / 45.0, 1.0) - 0.5)
    ),
    # A boom that bends under load: 0.4° of angle of attack at each g.
    "bending_boom": lambda s, size: _added(s, angle_of_attack=0.007 * size * _load(s)),
    # A boom that the slipstream bends aside: 0.5° of sideslip over the range of power.
    "twisting_boom": lambda s, size: _added(s, sideslip=0.009 * size * _power(s) / 0.3),
    # Vanes of a slow converter: 0.8 s late.
    "late_vane": lambda s, size: _late(s, 0.8 * size, "angle_of_attack", "sideslip"),
    # A sideslip vane that leans: it reads 8 % of angle of attack.
    "crossed_vanes": lambda s, size: _added(s, sideslip=0.08 * size * s["angle_of_attack"]),
    # An angle-of-attack vane in the slipstream: 0.6° over the range of power.
    "vane_in_wake": lambda s, size: _added(s, angle_of_attack=0.01 * size * _power(s) / 0.3),
    # A forward accelerometer whose zero drifts as the box warms: 0.04 m/s² with a time of 80 s.
    "warming_accelerometer": lambda s, size: _added(
        s, specific_force_x=0.04 * size * (1.0 - np.exp(-elapsed(s) / 80.0))
    ),
    # A vertical accelerometer with a scale error that grows with load: 1 % at each g.
    "stretched_accelerometer": lambda s, size: _added(
        s,
        specific_force_z=0.01
        * size
        * s["specific_force_z"]
        * np.abs(s["specific_force_z"])
        / GRAVITY,
    ),
    # Gyros that feel the other axes: 6 % of yaw rate in roll and in pitch.
    "crossed_gyros": lambda s, size: _added(
        s, roll_rate=0.06 * size * s["yaw_rate"], pitch_rate=0.06 * size * s["yaw_rate"]
    ),
    # A vertical gyro that erects to the apparent vertical: 3 % of bank, and pitch with its square.
    "leaning_gyro": lambda s, size: _added(
        s, roll=-0.03 * size * s["roll"], pitch=0.02 * size * s["roll"] ** 2
    ),
    # A vertical gyro that takes a deceleration for a tilt: a tenth of it, within 20 s.
    "erected_pitch": lambda s, size: _added(
        s,
        pitch=0.1
        * size
        * first_order(s, s["specific_force_x"] / GRAVITY - np.sin(s["pitch"]), 20.0),
    ),
    # An attitude box that is 0.25 s late.
    "late_attitude": lambda s, size: delayed_by(s, 0.25 * abs(size), "roll", "pitch", "heading"),
    # A vertical accelerometer that rectifies vibration: 0.06 m/s² over the range of propeller
    # speed.
    "shaken_accelerometer": lambda s, size: _added(
        s,
        specific_force_z=0.06
        * size
        * (s["propeller_speed_left"] / s["propeller_speed_left"].mean() - 1.0)
        / 0.05,
    ),
    # A satellite height with multipath: 3 m with a period of 70 s.
    "swinging_altitude": lambda s, size: _added(s, altitude=3.0 * size * _wave(s, 70.0)),
    # Satellite velocities with bursts of error: 0.4 m/s, some seconds each, a quarter of the time.
    "multipath_bursts": _multipath_bursts,
    # A satellite height that leaps as satellites come and go: 4 m each 35 s.
    "leaping_altitude": lambda s, size: _added(s, altitude=4.0 * size * _pieces(s, 35.0, 31)),
    # A receiver that stands still for 1.5 s of each 12 s, and then leaps.
    "stale_fixes": _stale_fixes,
    # Air data whose time stamps jump by 0.3 s to either side, anew each second.
    "stamp_jitter": lambda s, size: delayed_by(s, 0.3 * size * _pieces(s, 1.0, 41), *AIR_DATA),
    # A probe that the sun warms from one side: 0.8 K.
    "sun_on_probe": lambda s, size: _added(
        s, total_temperature=0.8 * size * np.maximum(0.0, np.cos(s["heading"] - 1.1))
    ),
    # A temperature probe in a thick well: 15 s late.
    "slow_probe": lambda s, size: _late(s, 15.0 * abs(size), "total_temperature"),
    # A probe that feels the exhaust: 1.5 K over the range of power.
    "exhaust_on_probe": lambda s, size: _added(
        s, total_temperature=1.5 * size * first_order(s, _lever(s), 8.0)
    ),
    # A probe with its heater on: 2 K that fall with airspeed.
    "heated_probe": lambda s, size: _added(
        s, total_temperature=2.0 * size * (PRESSURE / np.maximum(s["impact_pressure"], 500.0))
    ),
    # A turbine flow meter that reads 4 % too much.
    "fuel_meter": lambda s, size: _added(s, fuel_flow_left=0.04 * size * s["fuel_flow_left"]),
    # A tachometer that slips: 1 % low on the right.
    "slipping_tachometer": lambda s, size: _added(
        s, propeller_speed_right=-0.01 * size * s["propeller_speed_right"]
    ),
    # Manifold pressures through a long line: 1.5 s late.
    "long_manifold_line": lambda s, size: _late(s, 1.5 * abs(size), *MANIFOLD),
    # An elevator pickup with another lever arm: 12 % too much.
    "bent_elevator_pickup": lambda s, size: _added(s, elevator=0.12 * size * s["elevator"]),
    # A rudder that the air pushes behind its pickup: 0.6° over the range of airspeed.
    "floating_rudder": lambda s, size: _added(
        s, rudder=0.01 * size * (s["impact_pressure"] / PRESSURE - 1.0)
    ),
    # A pressure field with waves that the airplane crosses in 100 s: 12 Pa.
    "pressure_slope": lambda s, size: _added(
        s,
        static_pressure=12.0
        * size
        * np.sin(2.0 * np.pi * (np.cumsum(s["velocity_north"]) * s.interval) / (100.0 * SPEED)),
    ),
    # Air with warm patches of 2 km: 0.5 K that the probe feels and the pressure does not.
    "warm_patches": lambda s, size: _added(
        s, total_temperature=first_order(s, 0.5 * size * _pieces(s, 28.0, 51), 5.0)
    ),
    # A supply voltage that sags for 20 s each 50 s: all analog channels read 0.5 % less.
    "sagging_supply": lambda s, size: s.with_channels(
        **{
            n: s[n] * (1.0 - 0.005 * size * (np.mod(elapsed(s), 50.0) < 20.0))
            for n in ("impact_pressure", *MANIFOLD)
        }
    ),
}


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


def _as_effect(name: str, build: Callable[[Sizes, Baseline], Overlay]) -> AircraftEffect:
    known = EFFECTS["belly_pod"]
    assert isinstance(known, AircraftEffect)
    own = replace(known, name=name, parameters=(SIZE,), variant_of="", what="hidden")
    return replace(own, build=lambda _, sizes, baseline: build(sizes, baseline))


def _surging(sizes: Sizes, baseline: Baseline) -> Overlay:
    """The left engine's power falls and rises by 5 %."""
    path = size("surging_engine", "size")
    left, _ = left_and_right("surging_engine", baseline)
    fuel = baseline.engines[left].fuel_per_power
    setting = PropertySetting(
        f"propulsion/engine[{left}]/bsfc-lbs_hphr",
        quotient(fuel, difference(1.0, product(0.05, path))),
    )
    return Overlay(sizes=((path, sizes["size"]),), settings=(setting,))


def _drag(area: float) -> Expression:
    return product("aero/qbar-psf", area / FOOT**2)


_ALPHA = "aero/alpha-rad"
AIRPLANE_FAULTS: Mapping[str, AircraftEffect] = {
    e.name: e
    for e in (
        _pushing("cowl_flap_cycling", ("DRAG", _drag(0.05))),
        _pushing(
            "fluttering_door",
            ("DRAG", _drag(0.05)),
            ("PITCH", product(*_QS, "metrics/cbarw-ft", 0.003)),
        ),
        _pushing("fuel_slosh", ("ROLL", product(*_QSB, 0.0012)), ("SIDE", product(*_QS, 0.002))),
        _pushing("baggage_door", ("YAW", product(*_QSB, 0.0012)), ("DRAG", _drag(0.03))),
        _pushing(
            "bending_wing",
            (
                "LIFT",
                product(-0.05, "aero/qbar-psf", "aero/qbar-psf", "metrics/Sw-sqft", _ALPHA, 0.01),
            ),
        ),
        _pushing("icing_wing", ("DRAG", _drag(0.08)), ("LIFT", product(*_QS, _ALPHA, -0.25))),
        _pushing("rain_on_wing", ("DRAG", _drag(0.04)), ("LIFT", product(*_QS, _ALPHA, -0.15))),
        _pushing("wake_encounter", ("ROLL", product(*_QSB, 0.003))),
        _pushing(
            "rolling_tanks", ("ROLL", product(*_QSB, 0.002, operation("sin", "attitude/phi-rad")))
        ),
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


def _sensed(name: str, fault: Fault) -> SensorEffect:
    """A fault of the sensors as an effect that the recorder applies."""
    known = EFFECTS["pitot_lag"]
    assert isinstance(known, SensorEffect)
    plain = replace(
        known, name=name, parameters=(SIZE,), variant_of="", what="hidden", changes=(), needs=()
    )
    return replace(plain, function=lambda signals, sizes: fault(signals, sizes["size"]))


OUTSIDERS: Mapping[str, Effect] = {
    **{name: _sensed(name, fault) for name, fault in SENSOR_FAULTS.items()},
    **AIRPLANE_FAULTS,
}
HIDDEN_EFFECTS: Mapping[str, Effect] = {**OWN_FORMS, **OUTSIDERS}
