"""Apply the effects of a case on the sensors: on the probes before sampling, and on the recorded samples."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.effects import SensorEffect, Signals, chosen, share_of_size
from pitotbench.effects.airframe.loading import MASS
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense.sensor import PLAIN, indicated_impact_pressure, known_curve
from pitotbench.units import Array

PROBES = ("static_pressure", "impact_pressure", "total_temperature")
_FELT = "felt_"  # prefix of the channels that hold the values at the probes with the effects in them


def values_at_probes(flight: Flight, das: DataSystem, at: Callable[[Array], Array]) -> dict[str, Array]:
    """Return static pressure, indicated impact pressure and total temperature at the probes [SI].

    Parameters: flight; das; at, a function that takes a channel of the flight to the instants wanted.
    Raises BadInputError where the case's pressure error cannot be applied.
    """
    if _FELT + PROBES[0] in flight.channels:
        return {name: at(flight[_FELT + name]) for name in PROBES}
    # The pressure error comes first; the effects then act on the indicated pressures.
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


def with_probe_effects(flight: Flight, das: DataSystem) -> Flight:
    """Return the flight with the case's effects on the probes; the same flight where there are none.

    Raises UnknownNameError for an unknown effect, BadInputError for impossible parameters.
    """
    choices = _sensor_effects(flight.case, after_noise=False)
    if not choices:
        return flight
    plain = {c.name: flight[c.name] for c in PLAIN if c.name in flight.channels}
    channels = plain | values_at_probes(flight, das, lambda values: values)
    signals = _applied(Signals(flight["time"], channels), choices)
    changed = {(_FELT + name if name in PROBES else name): signals[name] for name in signals}
    return replace(flight, channels={**flight.channels, **changed})


def with_listed_mass(flight: Flight) -> Flight:
    """Return the flight with the mass of its weight sheet, which lacks any mass that an effect adds.

    Otherwise the mass column would reveal the effect, and a model flown at that mass would show no gap.
    """
    time = flight["time"] - flight["time"][0]
    added = (c for c in chosen(flight.case.effects) if MASS.name in (c.effect.name, c.effect.part_of))
    unlisted = sum(c.sizes["mass_kg"] * share_of_size(c.effect, time, c.sizes) for c in added)
    if not np.any(unlisted) or "mass" not in flight.channels:
        return flight
    return replace(flight, channels={**flight.channels, "mass": flight["mass"] - unlisted})


def with_recorder_effects(log: FlightLog, case: Case) -> FlightLog:
    """Return the log with the case's effects on recorded samples; the same log where there are none."""
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
    """Apply the effects one after the other, in the order of the case."""
    for effect, sizes in choices:
        signals = effect.apply(signals, sizes)
    return signals
