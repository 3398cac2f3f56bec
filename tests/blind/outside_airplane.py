"""Faults of the airplane that the table does not hold, and the catalog of all faults outside it."""

from collections.abc import Mapping
from dataclasses import replace

from tests.blind.outsiders import SENSOR_FAULTS, Fault
from tests.blind.own_forms import OWN_FORMS
from tests.blind.schedule import Schedule, growing, pulses, square, wave

from pitotbench.effects import EFFECTS, AircraftEffect, Effect, Overlay, SensorEffect, Signals
from pitotbench.effects.effect import Parameter, Sizes
from pitotbench.effects.expression import Expression, difference, operation, product, quotient, size
from pitotbench.effects.overlay import AxisFunction, Baseline, PropertySetting
from pitotbench.effects.propulsion.engines import left_and_right
from pitotbench.units import FOOT

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
