"""The effects of a case in the sensors: on what the probes feel before sampling, and on the samples after it."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from pitotbench import air
from pitotbench.effects import SensorEffect, Signals, chosen
from pitotbench.effects.airframe.loading import MASS
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense.sensor import PLAIN, indicated_impact_pressure, known_curve
from pitotbench.units import Array

PROBES = ("static_pressure", "impact_pressure", "total_temperature")
_FELT = "felt_"  # channels of a disturbed flight that stand for what the probes feel


def felt(flight: Flight, das: DataSystem, at: Callable[[Array], Array]) -> dict[str, Array]:
    """What the probes feel at some instants: static pressure, indicated impact pressure, total temperature.

    Raises BadInputError where the case's pressure error cannot be applied.
    """
    if _FELT + PROBES[0] in flight.channels:
        return {name: at(flight[_FELT + name]) for name in PROBES}
    static, temperature = at(flight["static_pressure"]), at(flight["air_temperature"])
    impact = at(flight["total_pressure"]) - static
    mach = air.mach_from_impact_pressure(impact, static)
    error = flight.case.pressure_error
    indicated = indicated_impact_pressure(impact, known_curve(error))
    # Where the total pressure is right, p_i − p = q_c − q_ci; an error of the total source leaves p_i alone.
    return {
        "static_pressure": static + (impact - indicated) if error.location == "static" else static,
        "impact_pressure": indicated,
        "total_temperature": air.total_temperature(temperature, mach, das.recovery_factor),
    }


def disturbed(flight: Flight, das: DataSystem) -> Flight:
    """The flight as the sensors of its case feel it; the same flight where no effect acts there.

    Raises UnknownNameError for an unknown effect, BadInputError for parameters that cannot be.
    """
    choices = _sensor_effects(flight.case, after_noise=False)
    if not choices:
        return flight
    plain = {c.name: flight[c.name] for c in PLAIN if c.name in flight.channels}
    channels = plain | felt(flight, das, lambda values: values)
    signals = _applied(Signals(flight["time"], channels), choices)
    changed = {(_FELT + name if name in PROBES else name): signals[name] for name in signals}
    return replace(flight, channels={**flight.channels, **changed})


def weighed(flight: Flight) -> Flight:
    """The flight with the mass of its weight sheet: what an effect of the case loads beyond that is not on it.

    Else the mass column would give the effect away, and a model that is flown at that mass could never miss it.
    """
    unlisted = sum(c.sizes["mass_kg"] for c in chosen(flight.case.effects) if c.effect is MASS)
    if not unlisted or "mass" not in flight.channels:
        return flight
    return replace(flight, channels={**flight.channels, "mass": flight["mass"] - unlisted})


def spoiled(log: FlightLog, case: Case) -> FlightLog:
    """The log as the recorder of its case stores it; the same log where no effect acts there."""
    choices = _sensor_effects(case, after_noise=True)
    if not choices:
        return log
    channels = {name: values for name, values in log.channels().items() if values.dtype == float and name != "time"}
    changed: dict[str, Any] = dict(_applied(Signals(log.time, channels), choices).channels)
    return replace(log, **changed)


def _sensor_effects(case: Case, after_noise: bool) -> list[tuple[SensorEffect, Mapping[str, float]]]:
    found = [(c.effect, c.sizes) for c in chosen(case.effects) if isinstance(c.effect, SensorEffect)]
    return [(effect, sizes) for effect, sizes in found if effect.after_noise == after_noise]


def _applied(signals: Signals, choices: list[tuple[SensorEffect, Mapping[str, float]]]) -> Signals:
    """The effects one after the other, in the order of the case."""
    for effect, sizes in choices:
        signals = effect.apply(signals, sizes)
    return signals
