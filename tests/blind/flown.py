"""Fly and record one hidden flight: its effects, its schedules, and an environment of the generator's own."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from math import cos, sin
from typing import Any
from unittest.mock import patch

import numpy as np
from tests.blind.gusts import GustField, gust_field
from tests.blind.outside_airplane import HIDDEN_EFFECTS, SCHEDULES
from tests.blind.schedule import Schedule

from pitotbench.effects import EFFECTS, AirEffect, Effect, Overlay, SensorEffect, Signals
from pitotbench.effects.air.recorded_time import elapsed
from pitotbench.effects.expression import size
from pitotbench.records.case import Case
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense import record
from pitotbench.simulate import fly
from pitotbench.simulate.modified import mark_recording
from pitotbench.simulate.plant import Plant
from pitotbench.timeline import pauses, stretches
from pitotbench.units import FOOT, Array

USUAL_RATE = 100.0  # Hz
TICK = 0.02  # s between two looks at gusts and schedules
RAMP = 10.0  # s, in which gusts begin
# Standard deviation [m/s] of JSBSim's turbulence at 6,000 ft, measured on a flight of each level.
DEVIATIONS = {"none": 0.0, "light": 0.19, "moderate": 0.72}


@dataclass(frozen=True, slots=True)
class Environment:
    """What of the world is not the product's: `rate` [Hz] of integration, own gusts, own receiver and probes."""

    rate: float = USUAL_RATE
    own_gusts: bool = False
    receiver: bool = False
    probes: bool = False

    @property
    def usual(self) -> bool:
        """Whether all is the product's own."""
        return self == Environment()


@contextmanager
def known_effects(schedules: Mapping[str, Schedule]) -> Iterator[None]:
    """The table of effects with the generator's own in it; those on sensors act by their schedules."""
    table: dict[str, Effect] = {**EFFECTS, **HIDDEN_EFFECTS}
    changed = {n: _scheduled(e, schedules[n]) for n, e in table.items() if n in schedules}
    with patch.dict(EFFECTS._entries, {**HIDDEN_EFFECTS, **changed}):
        yield


def _scheduled(effect: Effect, schedule: Schedule) -> Effect:
    if not isinstance(effect, SensorEffect):
        return effect
    plain = effect.function

    def function(signals: Signals, sizes: Mapping[str, float]) -> Signals:
        moved, share = plain(signals, sizes), schedule(elapsed(signals))
        differ = [n for n in signals if moved[n] is not signals[n]]
        return signals.with_channels(**{n: _blend(n, signals[n], moved[n], share) for n in differ})

    return replace(effect, function=function)


def _blend(name: str, before: Array, after: Array, share: Array) -> Array:
    change = after - before
    if name == "heading":
        change = np.mod(change + np.pi, 2.0 * np.pi) - np.pi
    return np.asarray(before + share * change)


@dataclass(slots=True)
class _Driver:
    """Stands between the plant and JSBSim: sets gusts and scheduled sizes as the flight goes on."""

    plant: Plant
    fdm: Any
    gusts: GustField | None
    sizes: Sequence[tuple[str, float, Schedule]]
    begun: float = np.inf
    way: float = 0.0
    last: float = field(default=-np.inf)

    def run(self) -> bool:
        """Run one step."""
        time = float(self.fdm.get_sim_time())
        if time - self.last >= TICK - 1e-6:
            self._look(time)
        return bool(self.fdm.run())

    def _look(self, time: float) -> None:
        for path, value, schedule in self.sizes:
            self.plant.set(
                path, value * float(schedule(np.array(time - self.begun))) if time >= self.begun else 0.0
            )
        if self.gusts is not None:
            self.way += self.plant.get("true_airspeed") * min(TICK * 5.0, max(0.0, time - self.last))
            along, across, down = min(1.0, time / RAMP) * self.gusts.at(self.way)
            heading = self.plant.get("heading")
            north = along * cos(heading) - across * sin(heading)
            east = along * sin(heading) + across * cos(heading)
            for path, value in (("north", north), ("east", east), ("down", down)):
                self.plant.set(f"atmosphere/gust-{path}-fps", value / FOOT)
        self.last = time

    def __getattr__(self, name: str) -> Any:
        return getattr(self.fdm, name)


@dataclass(slots=True)
class _Loader:
    """Takes the place of the class of plants in the simulator."""

    rate: float
    gusts: GustField | None
    sizes: Sequence[tuple[str, float, Schedule]]
    driver: _Driver | None = None

    def load(self, aircraft: str = "navajo", rate: float = USUAL_RATE, overlay: Overlay | None = None) -> Plant:
        """Load the same aircraft at another rate, with a driver."""
        plant = Plant.load(aircraft, self.rate, overlay)
        if self.gusts is not None or self.sizes:
            self.driver = _Driver(plant, plant.fdm, self.gusts, self.sizes)
            plant.fdm = self.driver
        return plant

    def mark(self, plant: Plant) -> None:
        """Note when the recording begins."""
        mark_recording(plant)
        if self.driver is not None:
            self.driver.begun = plant.get("time") + plant.time_step


def flown(
    case: Case, environment: Environment | None = None, schedules: Mapping[str, Schedule] | None = None
) -> Flight:
    """Fly a case with effects of the table, of the generator, by schedules, in an environment."""
    environment, schedules = environment or Environment(), {**SCHEDULES, **(schedules or {})}
    gusts = None
    if environment.own_gusts and case.turbulence != "none":
        gusts = gust_field(DEVIATIONS[case.turbulence], case.truth_seed)
    loader = _Loader(environment.rate, gusts, _driven(case, schedules))
    in_air = replace(case, turbulence="none") if gusts is not None else case
    with ExitStack() as stack:
        stack.enter_context(known_effects(schedules))
        stack.enter_context(patch("pitotbench.simulate.sortie.Plant", loader))
        stack.enter_context(patch("pitotbench.simulate.sortie.mark_recording", loader.mark))
        flight = fly(in_air)
    return replace(flight, case=case)


def _driven(case: Case, schedules: Mapping[str, Schedule]) -> list[tuple[str, float, Schedule]]:
    """The sizes of effects on the airplane that a schedule changes in flight."""
    table = {**EFFECTS, **HIDDEN_EFFECTS}
    return [
        (size(spec.name, key), value, schedules[spec.name])
        for spec in case.effects
        if spec.name in schedules and not isinstance(table[spec.name], SensorEffect)
        for key, value in spec.parameters.items()
    ]


def has_wind(names: Sequence[str]) -> bool:
    """Whether an effect brings a wind of its own, which takes the place of gusts in JSBSim."""
    table = {**EFFECTS, **HIDDEN_EFFECTS}
    return any(isinstance(table[name], AirEffect) for name in names)


def recorded(
    flight: Flight, environment: Environment | None = None, schedules: Mapping[str, Schedule] | None = None
) -> FlightLog:
    """Record a flight with the effects of its case, through the receiver and the probes of the environment."""
    environment, schedules = environment or Environment(), {**SCHEDULES, **(schedules or {})}
    case = flight.case
    if environment.probes:
        flight = _through_probes(flight)
    with known_effects(schedules), ExitStack() as stack:
        if environment.receiver:
            stack.enter_context(patch("pitotbench.sense.recorder.add_noise", _receiver_noise))
        return record(flight, case.das, case.sensor_seed)


MEMORY = 0.4  # of a sample in the next one


def _receiver_noise(values: Array, deviation: float, stream: np.random.Generator) -> Array:
    """Noise of the same deviation that is not white: each error holds 0.4 of the one before."""
    white = stream.standard_normal(len(values))
    noise, before = np.empty_like(white), 0.0
    root = np.sqrt(1.0 - MEMORY**2)
    for row, new in enumerate(white):
        before = MEMORY * before + root * new
        noise[row] = before
    return np.asarray(values + deviation * noise)


def _through_probes(flight: Flight) -> Flight:
    """The flight as probes feel it that average over a fifth of a second, the delay taken out.

    They average within each stretch: what was flown in a pause of the recording is not known.
    """
    time = flight["time"]
    width = max(1, round(0.1 / float(np.median(np.diff(time)))))
    taps = np.convolve(np.ones(width), np.ones(width)) / width**2
    parts = stretches(time, pauses(time))
    changed = {}
    for name in ("total_pressure", "static_pressure", "air_temperature"):
        padded = [np.pad(flight[name][rows], width - 1, mode="edge") for rows in parts]
        changed[name] = np.concatenate([np.convolve(each, taps, mode="valid") for each in padded])
    return replace(flight, channels={**flight.channels, **changed})
