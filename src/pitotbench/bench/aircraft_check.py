"""Check what can be flown with an aircraft: its speeds, the autopilot's step responses, the paper's maneuvers."""

from collections.abc import Callable, Sequence

import numpy as np

from pitotbench.records.attached import AircraftCheck, ManeuverCheck, StepResponse
from pitotbench.records.case import Case
from pitotbench.records.errors import BadInputError
from pitotbench.simulate import MANEUVERS, fly
from pitotbench.simulate.attach.record import read_record
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.maneuvers import PAPER_MANEUVERS
from pitotbench.simulate.maneuvers.scaled_card import card_of
from pitotbench.simulate.step_responses import step_responses
from pitotbench.units import KNOT

Progress = Callable[[str], None]


def check_aircraft(
    aircraft: str,
    maneuvers: Sequence[str] = PAPER_MANEUVERS,
    seed: int = 1,
    say: Progress = lambda text: None,
) -> AircraftCheck:
    """Return what can be flown with an aircraft: a name of the hangar or of JSBSim's library, or a path.

    Flies the step responses in smooth air and each maneuver once, in light turbulence, with one truth seed. `say`
    is called with each line of progress.
    Raises UnknownNameError, BadInputError or SimulationError where the aircraft cannot be flown at all.
    """
    say(f"attach the autopilot to {aircraft}")
    folder = find_aircraft(aircraft)
    case = Case(aircraft=aircraft, turbulence="light", truth_seed=seed)
    speeds = sorted(card_of(case).speeds)
    steps: list[StepResponse] = []
    for speed in (speeds[0], speeds[-1]):
        say(f"step responses at {speed / KNOT:.0f} KCAS")
        steps += step_responses(aircraft, speed, case.altitude)
    found = []
    for maneuver in maneuvers:
        say(f"fly {maneuver}")
        found.append(_tried(aircraft, maneuver, seed))
    return AircraftCheck(folder.name, read_record(folder), tuple(steps), tuple(found))


def _tried(aircraft: str, maneuver: str, seed: int) -> ManeuverCheck:
    case = Case(aircraft=aircraft, maneuver=maneuver, turbulence="light", truth_seed=seed)
    speeds = tuple(speed / KNOT for speed in card_of(case).speeds)
    try:
        flight = fly(case)
    except BadInputError as error:
        return ManeuverCheck(maneuver, speeds, failure=" ".join(str(error).split()))
    judged = np.char.startswith(flight.segment, MANEUVERS[maneuver].kind)
    return ManeuverCheck(maneuver, speeds, flight.duration / 60.0, float(flight.on_condition[judged].mean()))
