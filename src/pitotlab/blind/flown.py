"""Fly a hidden case: its setting, its own gusts, and what the header of its log tells."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from math import cos, sin
from typing import Any
from unittest.mock import patch

import numpy as np

from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AirEffect, Effect, SensorEffect, elapsed
from pitotbench.effects.overlay import Overlay, size
from pitotbench.effects.response import Signals
from pitotbench.records.case import Case
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.modified import mark_recording
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.sortie import fly
from pitotbench.timeline import pauses, stretches
from pitotbench.units import FOOT, Array
from pitotlab.blind.outsiders import HIDDEN_EFFECTS, SCHEDULES, Schedule

RAPID = {"dwell_s": 20.0, "settle_s": 10.0}
SHORT_CIRCLE = {"speeds_kt": [150.0, 110.0]}
SHORT_TURN = {"dwells_s": [25.0, 40.0, 25.0]}


@dataclass(frozen=True, slots=True)
class Setting:
    """`flown`: the case without wind, error curve, effects, seeds; `told`: that of the header."""

    flown: Case
    told: Case


def _setting(
    maneuver: str,
    card: Mapping[str, Any],
    das: str,
    air: str,
    feet: float,
    planned: float = 0.0,
    **day: Any,
) -> Setting:
    """`planned`: the height [ft] of the header, if another; `day`: what no header tells."""
    told = Case(
        maneuver=maneuver,
        card=card,
        das=data_system(das),
        turbulence=air,
        altitude=(planned or feet) * FOOT,
    )
    return Setting(replace(told, altitude=feet * FOOT, **day), told)


_rapid = partial(_setting, "rapid_decel", RAPID)
_turn = partial(_setting, "decel_circle", SHORT_TURN)
_circle = partial(_setting, "circle", SHORT_CIRCLE)
_STEEP = {**SHORT_TURN, "bank_deg": 40.0}
_EIGHT = {**SHORT_CIRCLE, "turns": [1.0, 1.0]}
_TRACK = {**SHORT_CIRCLE, "dwell_s": 25.0}
_LEGS = {"speeds_kt": [140.0, 105.0]}
SETTINGS: Mapping[str, Setting] = {
    "A": _rapid("50/50", "light", 6000, temperature_offset=8.0, pilot="good", fuel=0.62),
    "B": _rapid("20/5", "none", 4000, temperature_offset=-12.0),
    "C": _turn("50/10", "light", 6000, fuel=0.81),
    "D": _setting("decel_circle", _STEEP, "100/100", "none", 8000, 6000, temperature_offset=14.0),
    "E": _circle("50/50", "light", 5000, pilot="busy", temperature_offset=-8.0),
    "F": _circle("20/1", "none", 6000, temperature_offset=5.0, fuel=0.5),
    "G": _rapid("25/5", "moderate", 6000, 7000, ballast=120.0),
    "H": _turn("20/10", "moderate", 7000, pilot="good", fuel=0.7),
    "I": _circle("50/10", "light", 4500, 6000, temperature_offset=11.0),
    "J": _rapid("100/20", "none", 9000, pilot="busy", fuel=0.42),
    "K": _turn("20/1", "none", 5000, ballast=-100.0, temperature_offset=-5.0),
    "L": _setting("figure_eight", _EIGHT, "50/10", "light", 6000),
    "M": _setting("race_track", _TRACK, "50/50", "light", 6000, fuel=0.55),
    "N": _setting("four_leg", _LEGS, "20/5", "light", 5500, 5000, pilot="good"),
    "O": _setting("diagnostic", {}, "50/10", "light", 6000, temperature_offset=-10.0, fuel=0.75),
}


LENGTH = 762.0  # m
LEAST, MOST, MODES = 2.0e-4, 0.5, 160  # rad/m: from 31 km to 13 m, or a fifth of a second
STEP = 1.0  # m


def longitudinal(number: Array) -> Array:
    """The one-sided spectrum of the gust along the flight over wave number [rad/m]."""
    return np.asarray(2.0 * LENGTH / np.pi / (1.0 + (1.339 * LENGTH * number) ** 2) ** (5.0 / 6.0))


def lateral(number: Array) -> Array:
    """The same for the gusts across the flight."""
    x = (1.339 * LENGTH * number) ** 2
    return np.asarray(LENGTH / np.pi * (1.0 + 8.0 / 3.0 * x) / (1.0 + x) ** (11.0 / 6.0))


@dataclass(frozen=True, slots=True)
class GustField:
    """Gusts along, across and down [m/s] at each `STEP` of the way, (m, 3)."""

    values: Array

    def at(self, way: float) -> Array:
        """Return the gusts after some way through the air [m], (3,); the field repeats itself."""
        low, count = int(way / STEP), len(self.values)
        share = way / STEP - low
        before, behind = self.values[low % count], self.values[(low + 1) % count]
        return np.asarray((1.0 - share) * before + share * behind)


def gust_field(deviation: float, seed: int, way: float = 60_000.0) -> GustField:
    """Return gusts of a standard deviation [m/s] along a way [m]."""
    draw = np.random.default_rng([seed, 77])
    edges = np.geomspace(LEAST, MOST, MODES + 1)
    numbers = edges[:-1] + draw.random(MODES) * np.diff(edges)
    place = np.arange(0.0, way, STEP)
    columns = []
    for spectrum in (longitudinal, lateral, lateral):
        size = np.sqrt(2.0 * spectrum(numbers) * np.diff(edges))
        phase = draw.uniform(0.0, 2.0 * np.pi, MODES)
        column = np.zeros_like(place)
        for amplitude, number, start in zip(size, numbers, phase, strict=True):
            column += amplitude * np.sin(number * place + start)
        columns.append(column)
    return GustField(deviation * np.stack(columns, axis=1))


USUAL_RATE = 100.0  # Hz
TICK = 0.02  # s between two looks at gusts and schedules
RAMP = 10.0  # s, in which gusts begin
# Standard deviation [m/s] of JSBSim's turbulence at 6,000 ft, measured on a flight of each level.
DEVIATIONS = {"none": 0.0, "light": 0.19, "moderate": 0.72}


@dataclass(frozen=True, slots=True)
class Environment:
    """What is not the product's: `rate` [Hz] of integration, gusts, receiver and probes."""

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
            share = float(schedule(np.array(time - self.begun))) if time >= self.begun else 0.0
            self.plant.set(path, value * share)
        if self.gusts is not None:
            lasted = min(TICK * 5.0, max(0.0, time - self.last))
            self.way += self.plant.get("true_airspeed") * lasted
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

    def load(
        self, aircraft: str = "navajo", rate: float = USUAL_RATE, overlay: Overlay | None = None
    ) -> Plant:
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
    case: Case,
    environment: Environment | None = None,
    schedules: Mapping[str, Schedule] | None = None,
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
        stack.enter_context(patch("pitotbench.simulation.sortie.Plant", loader))
        stack.enter_context(patch("pitotbench.simulation.sortie.mark_recording", loader.mark))
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
    flight: Flight,
    environment: Environment | None = None,
    schedules: Mapping[str, Schedule] | None = None,
) -> FlightLog:
    """Record a flight with the effects of its case, receiver and probes of the environment."""
    environment, schedules = environment or Environment(), {**SCHEDULES, **(schedules or {})}
    case = flight.case
    if environment.probes:
        flight = _through_probes(flight)
    with known_effects(schedules), ExitStack() as stack:
        if environment.receiver:
            stack.enter_context(patch("pitotbench.sensing.recorder.add_noise", _receiver_noise))
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
