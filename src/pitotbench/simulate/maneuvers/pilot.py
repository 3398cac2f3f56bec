"""Pilots: the autopilot alone, or a model of a person with a reaction time, a threshold and a random drift.

The person is an intermittent controller (Craik 1948; Neilson and others since). Between corrections the held
value drifts at random (the remnant of McRuer and Jex 1967). A deviation is noticed only when it is larger than a
glance at the gauge shows. It is corrected in part; then the pilot waits for the aircraft to respond.

The autopilot keeps stick and rudder, so this models how well targets are held, not handling qualities. All sizes
are estimates: a good pilot stays within the paper's tolerances most of the time in smooth air, a busy one does
not.
"""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.simulate.plant import Plant
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT

CORRECTED = 0.7  # share of a noticed deviation that one correction takes out
PURSUED = 5.0  # thresholds; a larger deviation is a commanded change under way, not an error to correct
# The modes in which the autopilot holds a quantity: the throttle or the nose holds an airspeed.
HELD_IN_MODE = {
    "airspeed": (("throttle_mode", 1), ("pitch_mode", 2)),
    "altitude": (("pitch_mode", 1),),
    "heading": (("lateral_mode", 1),),
    "bank": (("lateral_mode", 2),),
}


@dataclass(frozen=True, slots=True)
class Skill:
    """How well a person flies.

    `reaction` [s] is the delay of each command. For each quantity, `patience` [s] is the wait after a correction,
    `thresholds` [SI] the deviation that is noticed, `drifts` [SI per square-root second] the random walk of the
    held value. `setting_error` [Pa, 1σ] is the error of a manifold-pressure setting.
    """

    reaction: float
    patience: Mapping[str, float]
    thresholds: Mapping[str, float]
    drifts: Mapping[str, float]
    setting_error: float


# quantity: patience [s], threshold, drift a square-root second; airspeed answers the throttle slowly
HABITS = {
    "airspeed": (12.0, 0.5 * KNOT, 0.05 * KNOT),
    "altitude": (6.0, 20.0 * FOOT, 1.5 * FOOT),
    "heading": (3.0, 0.7 * DEGREE, 0.15 * DEGREE),
    "bank": (3.0, 1.5 * DEGREE, 0.25 * DEGREE),
}


def _skill(reaction: float, coarseness: float) -> Skill:
    """Return a skill with the habits above, thresholds and drifts multiplied by `coarseness`."""
    return Skill(
        reaction,
        patience={quantity: habit[0] for quantity, habit in HABITS.items()},
        thresholds={quantity: coarseness * habit[1] for quantity, habit in HABITS.items()},
        drifts={quantity: coarseness * habit[2] for quantity, habit in HABITS.items()},
        setting_error=coarseness * 0.1 * INCH_OF_MERCURY,
    )


class Hands:
    """The autopilot alone: each command of the card is set at once and held exactly."""

    def __init__(self, plant: Plant, truth_seed: int = 1) -> None:
        self._plant = plant

    def command(self, name: str, value: float) -> None:
        """Set a control of the property table [SI]."""
        self._plant.set(name, value)

    def tick(self, deviation: Callable[[str], float], seconds: float) -> None:
        """Let time pass [s]; `deviation(quantity)` is the reading minus the target [SI]. Nothing is corrected."""


class Person(Hands):
    """A pilot with reaction time, gauge thresholds and remnant, drawn from the truth seed."""

    skill = _skill(0.5, 1.0)

    def __init__(self, plant: Plant, truth_seed: int = 1) -> None:
        super().__init__(plant)
        self._random = np.random.default_rng(np.random.SeedSequence(truth_seed).spawn(1)[0])
        self._now = 0.0
        self._waiting: deque[tuple[float, str, float]] = deque()
        self._commanded: dict[str, float] = {"pitch_mode": 1}  # as the flight begins
        self._offsets: dict[str, float] = {}
        self._next_look: dict[str, float] = {}

    def command(self, name: str, value: float) -> None:
        """Set a control [SI] after the reaction time; a manifold pressure is set with an error."""
        if name == "manifold_pressure_target":
            value += self._random.normal(0.0, self.skill.setting_error)
        self._waiting.append((self._now + self.skill.reaction, name, value))

    def tick(self, deviation: Callable[[str], float], seconds: float) -> None:
        """Set the commands that are due, then let held values drift and correct the deviations noticed."""
        self._now += seconds
        while self._waiting and self._waiting[0][0] <= self._now:
            _, name, value = self._waiting.popleft()
            self._commanded[name] = value
            self._offsets.pop(name.removesuffix("_target"), None)
            self._plant.set(name, value)
        for quantity in self.skill.thresholds:
            if self._holds(quantity):
                self._hold(quantity, deviation(quantity), seconds)

    def _holds(self, quantity: str) -> bool:
        in_mode = any(self._commanded.get(name) == mode for name, mode in HELD_IN_MODE[quantity])
        return in_mode and f"{quantity}_target" in self._commanded

    def _hold(self, quantity: str, deviation: float, seconds: float) -> None:
        threshold = self.skill.thresholds[quantity]
        offset = self._offsets.get(quantity, 0.0)
        offset += self._random.normal(0.0, self.skill.drifts[quantity] * seconds**0.5)
        # A person looks again only after the patience: a correction needs time to show.
        noticed = threshold < abs(deviation) < PURSUED * threshold
        if noticed and self._now >= self._next_look.get(quantity, 0.0):
            offset -= CORRECTED * deviation
            self._next_look[quantity] = self._now + self.skill.patience[quantity]
        self._offsets[quantity] = min(max(offset, -PURSUED * threshold), PURSUED * threshold)
        self._plant.set(f"{quantity}_target", self._commanded[f"{quantity}_target"] + self._offsets[quantity])


class BusyPerson(Person):
    """The same person with other tasks: twice the reaction time, thresholds, drifts and setting error."""

    skill = _skill(1.0, 2.0)


PILOTS: Catalog[type[Hands]] = Catalog("pilot", {"none": Hands, "good": Person, "busy": BusyPerson})
