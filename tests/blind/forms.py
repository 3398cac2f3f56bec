"""Forms of known causes that no hypothesis holds: written here, flown by the generator, and known to nobody else.

Each is `variant_of` the effect of the table whose cause it shares. `flying_them` adds them to the table of effects
while the generator flies.
"""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from math import pi
from unittest.mock import patch

import numpy as np

from pitotbench import air
from pitotbench.effects import EFFECTS, AircraftEffect, AirEffect, Baseline, Effect, Overlay, SensorEffect, Signals
from pitotbench.effects.air.recorded_time import ELAPSED, elapsed
from pitotbench.effects.effect import Parameter
from pitotbench.effects.expression import Term, operation, product, size
from pitotbench.effects.overlay import AxisFunction, WindTerm
from pitotbench.effects.response import delayed, first_order
from pitotbench.units import FOOT, Array

Sizes = Mapping[str, float]
Sensed = Callable[[Signals, Sizes], Signals]
Built = Callable[[Sizes, Baseline], Overlay]
MACH = 0.2  # at which a growing recovery deficit is what its size says
SWING = 90.0  # s, of the load of a data system that makes its latency wander
BEGINS = 100.0  # s, when a late drift begins


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
    names = [n for n in ("velocity_north", "velocity_east", "velocity_down", "altitude") if n in signals]
    return signals.with_channels(**{name: delayed(signals, signals[name], late) for name in names})


def _late_drift(signals: Signals, sizes: Sizes) -> Signals:
    """A zero that stands still at first and then drifts."""
    minutes = np.maximum(0.0, elapsed(signals) - BEGINS) / 60.0
    moved = signals["impact_pressure"] + sizes["rate_pa_per_min"] * minutes
    return signals.with_channels(impact_pressure=moved)


def _growing_recovery(signals: Signals, sizes: Sizes) -> Signals:
    """A recovery deficit that grows with Mach number."""
    mach = air.mach_from_impact_pressure(signals["impact_pressure"].clip(min=0.0), signals["static_pressure"])
    static = air.air_temperature(signals["total_temperature"], mach)
    felt = static * (1.0 + 0.2 * (1.0 - sizes["deficit"] * mach / MACH) * mach**2)
    return signals.with_channels(total_temperature=np.asarray(felt))


def _curved(signals: Signals, sizes: Sizes) -> tuple[Array, Array, Array]:
    minutes = elapsed(signals) / 60.0
    bent = minutes * minutes
    return sizes["north_mps_per_min2"] * bent, sizes["east_mps_per_min2"] * bent, np.zeros_like(bent)


def _curving(sizes: Sizes, baseline: Baseline) -> Overlay:
    minutes = product(1.0 / 60.0, ELAPSED)
    paths = {key: size("curved_wind_drift", key) for key in sizes}
    winds = tuple(
        WindTerm(toward, product(path, 1.0 / FOOT, minutes, minutes))
        for toward, path in zip(("north", "east"), paths.values(), strict=True)
    )
    return Overlay(sizes=tuple((path, sizes[key]) for key, path in paths.items()), winds=winds)


def _drag(path: str, value: float, *factors: Term) -> Overlay:
    drag = product("aero/qbar-psf", path, *factors)
    return Overlay(sizes=((path, value),), functions=(AxisFunction("DRAG", drag),))


def _cubed(sizes: Sizes, baseline: Baseline) -> Overlay:
    """Drag due to lift that grows with the cube of lift."""
    path = size("cubed_induced_drag", "factor")
    lift = operation("sqrt", "aero/cl-squared")
    return _drag(path, sizes["factor"], "metrics/Sw-sqft", "aero/cl-squared", lift)


def _slow_pod(sizes: Sizes, baseline: Baseline) -> Overlay:
    """A blunt pod whose drag area falls with Reynolds number, V^-0.6."""
    path = size("slow_pod", "drag_area_m2")
    rough = operation("pow", operation("max", 0.1, product(1.0 / 220.0, "velocities/vt-fps")), -0.6)
    return _drag(path, sizes["drag_area_m2"], 1.0 / FOOT**2, rough)


def _sensed(name: str, function: Sensed, parent: str, parameter: Parameter) -> SensorEffect:
    known = EFFECTS[parent]
    assert isinstance(known, SensorEffect)
    known = replace(known, name=name, parameters=(parameter,), variant_of=parent, what="hidden")
    return replace(known, function=function)


def _felt(name: str, build: Built, parent: str, parameter: Parameter) -> AircraftEffect:
    known = EFFECTS[parent]
    assert isinstance(known, AircraftEffect)
    return replace(known, name=name, parameters=(parameter,), variant_of=parent, what="hidden", build=build)


def _wind() -> AirEffect:
    known = EFFECTS["wind_drift"]
    assert isinstance(known, AirEffect)
    parameters = (
        Parameter("north_mps_per_min2", 0.04, -1.0, 1.0, "hidden"),
        Parameter("east_mps_per_min2", -0.03, -1.0, 1.0, "hidden"),
    )
    known = replace(known, name="curved_wind_drift", parameters=parameters, variant_of="wind_drift", what="hidden")
    return replace(known, build=_curving, wind=_curved)


_ALL: tuple[Effect, ...] = (
    _sensed("one_way_lag", _one_way_lag, "pitot_lag", Parameter("lag_s", 0.4, 0.01, 3.0, "hidden")),
    _sensed(
        "wandering_latency", _wandering_latency, "gps_latency", Parameter("latency_s", 0.3, 0.01, 3.0, "hidden")
    ),
    _sensed("late_drift", _late_drift, "time_drift", Parameter("rate_pa_per_min", 10.0, -200.0, 200.0, "hidden")),
    _sensed(
        "growing_recovery", _growing_recovery, "recovery_deficit", Parameter("deficit", 0.2, -0.2, 1.0, "hidden")
    ),
    _wind(),
    _felt("cubed_induced_drag", _cubed, "induced_drag", Parameter("factor", 0.012, -0.06, 0.1, "hidden")),
    _felt("slow_pod", _slow_pod, "belly_pod", Parameter("drag_area_m2", 0.1, -0.2, 0.8, "hidden")),
)
FORMS: Mapping[str, Effect] = {effect.name: effect for effect in _ALL}
KNOWN_AND_HIDDEN: Mapping[str, Effect] = {**EFFECTS, **FORMS}


def flying_them() -> AbstractContextManager[object]:
    """The table of effects with these in it, while it lasts: the simulator and the sensors look them up by name."""
    return patch.dict(EFFECTS._entries, FORMS)
