"""Fly the diagnostic card with edited airplanes; write logs that name the unchanged one, and the
truth apart.
"""

import re
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from contextlib import chdir
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.random import Generator

from pitotbench.records.case import Case, DataSystem, PressureErrorSpec, Wind
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT
from pitotlab.derivatives.files import AIRPLANES, Change, write_edited
from pitotlab.experiment import OUT
from pitotlab.sealing import HELD, seal, write_logs

PLACE = OUT / "derivatives"
LEAST, MOST = 0.15, 0.50  # share of a change
SEVERAL = (3, 6)  # derivatives changed at once, at least and at most
STRONGEST_WIND = 25.0  # kt
HELD_APART = 10_000  # between the seeds of a flight and of the one held out
TELLING = ("seeds", "case_sha256")  # entries of a header from which the case could be drawn again


@dataclass(frozen=True, slots=True)
class EditedCase:
    """An airplane with changes; where they are several, a second flight of it is held out."""

    name: str
    seed: int
    airplane: str
    changes: tuple[Change, ...]


def draw_cases(seed: int, airplanes: Sequence[str], each: int, several: int) -> list[EditedCase]:
    """Draw `each` cases of every derivative of every airplane, and `several` an airplane with more
    changes at once.

    The pivots of a derivative take turns. The order of the cases is random.
    """
    draw = np.random.default_rng([seed, 11])
    drawn: list[tuple[str, tuple[Change, ...]]] = []
    for number, airplane in enumerate(airplanes):
        change, table = partial(_change, draw, airplane), AIRPLANES[airplane]
        for name in table:
            drawn += [(airplane, (change(name, number + turn),)) for turn in range(each)]
        for turn in range(several):
            names = draw.permutation(list(table))[: draw.integers(SEVERAL[0], SEVERAL[1] + 1)]
            drawn.append((airplane, tuple(change(str(name), turn) for name in names)))
    order = draw.permutation(len(drawn))
    return [EditedCase(f"case-{i:04d}", seed + i, *drawn[k]) for i, k in enumerate(order)]


def _change(draw: Generator, airplane: str, name: str, turn: int) -> Change:
    pivots = list(AIRPLANES[airplane][name])
    share = float(draw.choice([-1.0, 1.0]) * draw.uniform(LEAST, MOST))
    return Change(name, round(share, 4), pivots[turn % len(pivots)])


def flown_log(edited: EditedCase, held: bool = False) -> FlightLog:
    """Fly and record an edited airplane. The header of the log has the unchanged one, and no seed."""
    seed = edited.seed + HELD_APART * held
    draw = np.random.default_rng([seed, 12])
    # The error curve of the airplane is the same in both flights.
    factor = np.random.default_rng([edited.seed, 13]).uniform(0.5, 1.5)
    curve = np.array(PressureErrorSpec().parameters) * factor
    speed, direction = draw.uniform(2.0, STRONGEST_WIND), draw.uniform(0.0, 2.0 * np.pi)
    case = Case(
        aircraft=edited.airplane,
        maneuver="diagnostic",
        wind=Wind(float(speed) * KNOT, float(direction)),
        pressure_error=PressureErrorSpec(parameters=tuple(float(k) for k in curve)),
        das=DataSystem(),
        truth_seed=seed,
        sensor_seed=seed,
    )
    base = find_aircraft(edited.airplane)
    # A variant in ./aircraft is flown as it is. Its name is new, because the simulator remembers
    # folders and names.
    with TemporaryDirectory(prefix="edited") as scratch, chdir(scratch):
        name = Path(scratch).name
        write_edited(base, Path("aircraft", name), AIRPLANES[edited.airplane], edited.changes)
        flight = fly(replace(case, aircraft=name))
    log = record(replace(flight, case=case), case.das, case.sensor_seed)
    told = {key: entry for key, entry in log.header.items() if key not in TELLING}
    return replace(log, header=told)


def flights(edited: EditedCase) -> Iterator[tuple[str, FlightLog]]:
    """Fly an edited airplane, of several changes first the flight that is held out."""
    if len(edited.changes) > 1:
        yield HELD, flown_log(edited, held=True)
    yield "", flown_log(edited)


def generate(seed: int, cases: Sequence[EditedCase], out: Path, jobs: int = 1) -> dict[str, str]:
    """Seal the truth, fly the cases without a log; return why some could not be flown, by name.

    Raises ValueError where the folder has the truth of other cases.
    """
    seal(out / "seal", seed, [asdict(case) for case in cases])
    lost = write_logs(out, {case.name: case for case in cases}, flights, jobs)
    planes = {case.name: case.airplane for case in cases}
    return {name: re.sub(r"\bedited\w+", planes[name], why) for name, why in lost.items()}


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly the diagnostic card with edited airplanes; write logs and, apart, the truth."""
    add = parser.add_argument
    add("--seed", type=int, default=60_000, help="of the set and its first case")
    add("--airplanes", default=",".join(AIRPLANES))
    add("--each", type=int, default=2, help="cases of each derivative (default: %(default)s)")
    add("--several", type=int, default=8, help="cases an airplane with three to six changes")
    add("--jobs", type=int, default=1)
    add("--out", type=Path, default=PLACE)
    options = parser.parse_args(words)
    airplanes = options.airplanes.split(",")
    unknown = [name for name in airplanes if name not in AIRPLANES]
    if unknown:
        parser.error(f"unknown airplane {unknown[0]!r}; known: {', '.join(AIRPLANES)}")
    cases = draw_cases(options.seed, airplanes, options.each, options.several)
    failed = generate(options.seed, cases, options.out, options.jobs)
    print(f"{len(cases) - len(failed)} of {len(cases)} cases flown: {options.out / 'logs'}")
    for name, why in failed.items():
        print(f"{name}: {why}")
