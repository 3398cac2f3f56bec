"""Good logs, none of which may be refused: all maneuvers, systems and air, and the cells of the
outside generator.

    python -m tests.lab.good_logs [--seeds 2] [--outside 3] [--log FILE --mapping NAME]

reads each as a file's table would be read, prints every refusal and warning, and counts them.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.lab.mistakes import Columns, good_columns, read

from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError
from pitotbench.records.case import Case
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotlab.outside.generator import generate, write_csv
from pitotlab.outside.moving_air import CELLS

SYSTEMS = ("50/50", "20/5", "20/1")
TURBULENCE = ("none", "light", "moderate")


def simulated(seeds: Sequence[int]) -> Iterator[tuple[str, Columns]]:
    """The columns of every maneuver in every air, by every system."""
    for maneuver in MANEUVERS:
        for turbulence in TURBULENCE:
            for seed in seeds:
                flight = fly(
                    Case(
                        maneuver=maneuver, turbulence=turbulence, truth_seed=seed, sensor_seed=seed
                    )
                )
                for das in SYSTEMS:
                    log = record(flight, data_system(das), seed)
                    yield f"{maneuver} {turbulence} {das} seed {seed}", good_columns(log)


def said_of_outside(flights: int) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """What is said of flights of each of the outside generator's cells."""
    for cell in CELLS.values():
        for seed in range(1, flights + 1):
            flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
            with TemporaryDirectory() as folder:
                path = Path(folder) / "log.csv"
                write_csv(flight, path)
                yield (
                    f"outside {cell.name} {flight.maneuver} seed {seed}",
                    *said_of_file(path, None),
                )


def said_of_file(path: Path, mapping: str | None) -> tuple[str, tuple[str, ...]]:
    """Why a log is refused, or an empty text, and its warnings."""
    try:
        return "", tuple(read_log(path, mapping).header.get("warnings", ()))
    except BadInputError as error:
        return str(error), ()


def said_of_columns(columns: Columns) -> tuple[str, tuple[str, ...]]:
    """The same of columns."""
    try:
        return "", tuple(read(columns).header.get("warnings", ()))
    except BadInputError as error:
        return str(error), ()


def _all(choice: argparse.Namespace) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    for name in choice.log:
        yield name, *said_of_file(Path(name), choice.mapping)
    for name, columns in simulated(range(1, choice.seeds + 1)):
        yield name, *said_of_columns(columns)
    yield from said_of_outside(choice.outside)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; returns exit code 1 where a good log is refused."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.lab.good_logs", description=__doc__.split("\n")[0]
    )
    parser.add_argument(
        "--seeds", type=int, default=2, help="flights of each maneuver in each turbulence"
    )
    parser.add_argument(
        "--outside", type=int, default=3, help="flights of each of the outside generator's cells"
    )
    parser.add_argument("--log", action="append", default=[], help="a measured log as well")
    parser.add_argument("--mapping", help="of the measured logs")
    logs = refused = warned = 0
    for name, refusal, warnings in _all(parser.parse_args(arguments)):
        logs, refused, warned = logs + 1, refused + bool(refusal), warned + bool(warnings)
        if refusal or warnings:
            print(
                f"{name}: {'REFUSED ' + refusal if refusal else ' | '.join(warnings)}", flush=True
            )
    print(f"{logs} good logs: {refused} refused, {warned} warned of")
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
