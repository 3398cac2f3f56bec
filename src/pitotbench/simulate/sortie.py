"""Fly one case and return the truth of the flight."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pitotbench.records.case import Case
from pitotbench.records.errors import BadInputError
from pitotbench.records.flight import Flight
from pitotbench.records.integration import rate_problem
from pitotbench.simulate.atmosphere import Air
from pitotbench.simulate.fuel_and_ballast import ballast_overlay, load_fuel
from pitotbench.simulate.maneuvers import MANEUVERS, Maneuver
from pitotbench.simulate.maneuvers.card import Card
from pitotbench.simulate.maneuvers.cockpit import TICK, Cockpit, Targets
from pitotbench.simulate.maneuvers.pilot import PILOTS
from pitotbench.simulate.maneuvers.scaled_card import card_of
from pitotbench.simulate.modified import mark_recording, overlay_of
from pitotbench.simulate.plant import Plant
from pitotbench.simulate.recording import Recorder, lines_of
from pitotbench.units import Booleans

Progress = Callable[[float, str], None]


def fly(case: Case, progress: Progress | None = None, channels: Collection[str] | None = None) -> Flight:
    """Fly the maneuver of a case and return the truth at the case's rate of integration.

    One case gives one flight, bit for bit, in any process on one platform. Time is the simulator's; it jumps where
    a set-up between speeds was flown unrecorded. `progress(seconds, label)` is called as each segment begins.
    `channels` names the channels to record beside the time, by default all: to read one costs 1 % of a step. The
    flight itself does not depend on them. Channels that the aircraft does not serve are left out.

    Raises UnknownNameError for an unknown channel, aircraft, maneuver, card entry, turbulence, pilot or effect,
    BadInputError for impossible parameters of an effect or a rate that cannot be, SimulationError where the case
    cannot be flown.
    """
    # Names are looked up before the aircraft is loaded, so that a spelling mistake costs no time.
    recorded = lines_of(channels)
    maneuver = MANEUVERS[case.maneuver]
    if problem := rate_problem(case.integration_rate):
        raise BadInputError(problem)
    overlay = overlay_of(case)
    card = card_of(case)
    air = Air.of(case, overlay.temperature_offset)
    pilot = PILOTS[case.pilot]
    added = overlay + ballast_overlay(case.aircraft, case.ballast)
    plant = Plant.load(case.aircraft, case.integration_rate, added)
    load_fuel(plant, case.fuel)
    plant.start(case.altitude, card.speeds[0], air=air)
    # Truth seed: the same one drives the pilot and, through the air, the turbulence.
    targets = Targets(card.speeds[0], 0.0, case.altitude)
    cockpit = Cockpit(plant, card, targets, pilot(plant, case.truth_seed))
    recorder, marks = Recorder(plant, [line for line in recorded if line in plant.channels]), Marks()
    _fly_card(maneuver, card, cockpit, recorder, marks, progress)
    return Flight(case, recorder.channels(), marks.segments(), marks.conditions())


@dataclass(slots=True)
class Marks:
    """Labels and on-condition flags of the recorded samples, stored once a tick with the number of steps."""

    labels: list[str] = field(default_factory=list)
    on_condition: list[bool] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)

    def add(self, label: str, on_condition: bool, steps: int) -> None:
        """Mark the samples of the next steps."""
        self.labels.append(label)
        self.on_condition.append(on_condition)
        self.steps.append(steps)

    def segments(self) -> NDArray[np.str_]:
        """Return the label of each sample, (n,)."""
        return np.repeat(np.array(self.labels, dtype=np.str_), self.steps)

    def conditions(self) -> Booleans:
        """Return whether each sample is on condition, (n,)."""
        return np.repeat(np.array(self.on_condition, dtype=np.bool_), self.steps)


def _fly_card(
    maneuver: Maneuver,
    card: Card,
    cockpit: Cockpit,
    recorder: Recorder,
    marks: Marks,
    progress: Progress | None,
) -> None:
    """Run the card and the plant in turn: the card decides once a tick, the plant runs the steps of the tick."""
    plant = cockpit.plant
    steps = round(TICK / plant.time_step)
    announced = ""
    for _ in maneuver.fly(cockpit, card):
        if progress is not None and cockpit.label != announced:
            announced = cockpit.label
            progress(plant.get("time"), announced)
        cockpit.fly()
        # A tick is on condition where its first and its last state are.
        before = cockpit.on_condition()
        if cockpit.recorded and not marks.steps:
            mark_recording(plant)
        (recorder if cockpit.recorded else plant).advance(steps)
        plant.check()
        cockpit.look()
        if cockpit.recorded:
            marks.add(cockpit.label, before and cockpit.on_condition(), steps)
