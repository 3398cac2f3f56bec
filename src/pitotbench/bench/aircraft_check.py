"""Check what can be flown with an aircraft."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pitotbench.records import BadInputError
from pitotbench.records.aircraft import AircraftCheck, ManeuverCheck, StepResponse
from pitotbench.records.case import Case
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import read_record
from pitotbench.simulation.aircraft_import import set_to_zero
from pitotbench.simulation.autopilot.step_responses import step_responses
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS
from pitotbench.simulation.sortie import card_of, fly
from pitotbench.units import KNOT

Progress = Callable[[str], None]


def check_aircraft(
    aircraft: str,
    maneuvers: Sequence[str] = PAPER_MANEUVERS,
    seed: int = 1,
    say: Progress = lambda text: None,
) -> AircraftCheck:
    """Return what can be flown with an aircraft of the hangar, of JSBSim's library, or at a path.

    Flies the step responses in smooth air and each maneuver once, in light turbulence, with one
    truth seed. `say` is called with each line of progress. Raises UnknownNameError, BadInputError
    or SimulationError where the aircraft cannot be flown at all.
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
        tried = replace(case, maneuver=maneuver)
        flown = tuple(speed / KNOT for speed in card_of(tried).speeds)
        try:
            flight = fly(tried)
        except BadInputError as error:
            found.append(ManeuverCheck(maneuver, flown, failure=" ".join(str(error).split())))
            continue
        on = flight.on_condition[np.char.startswith(flight.segment, MANEUVERS[maneuver].kind)]
        found.append(ManeuverCheck(maneuver, flown, flight.duration / 60.0, float(on.mean())))
    return AircraftCheck(
        folder.name, read_record(folder), tuple(steps), tuple(found), set_to_zero(folder)
    )
