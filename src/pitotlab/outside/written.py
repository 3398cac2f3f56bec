"""Logs written beside their truth, so that several builds of the product can be judged on them."""

import argparse
import json
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np

from pitotlab.outside.generator import OutsideFlight, generate, read_airspeed, write_csv
from pitotlab.outside.kinds import SETS
from pitotlab.outside.moving_air import Cell
from pitotlab.outside.physics import KNOT
from pitotlab.sets import seeds_of

TRUTH = ".truth.json"


def truth_of(flight: OutsideFlight) -> dict[str, object]:
    """What a calibration of the log should find, for JSON; airspeeds as the log shows them."""
    cell = flight.cell
    low, high = read_airspeed(cell, np.array([cell.low, cell.high]))
    at = np.linspace(low, high, 241)
    return {
        "set": cell.name,
        "seed": flight.seed,
        "maneuver": flight.maneuver,
        "gps_hz": flight.fix_rate,
        "calibrate": dict(cell.calibrate),
        "indicated_airspeed_kt": list(at / KNOT),
        "correction_kt": list(flight.correction(at) / KNOT),
        "position_error_ft": list(flight.position_error(at)),
        "mean_wind_kt": list(flight.mean_wind / KNOT),
        "unknowns": _not_usual(cell),
    }


def _not_usual(cell: Cell) -> dict[str, object]:
    """The numbers of a flight that are not those of the cell `base`."""
    numbers = {
        field.name: value
        for field in fields(Cell)
        if isinstance(value := getattr(cell, field.name), int | float | tuple)
        and value != field.default
        and field.name not in ("maneuvers", "shown", "calibrate")
    }
    return numbers | getattr(cell.slow_wind, "keywords", {})


def write_flight(cell: Cell, seed: int, folder: Path) -> Path:
    """Write one flight of a cell, SEED.csv and its SEED.truth.json; return the latter."""
    flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
    write_csv(flight.columns, folder / f"{seed}.csv")
    beside = folder / f"{seed}{TRUTH}"
    beside.write_text(json.dumps(truth_of(flight)), encoding="utf-8")
    return beside


def write_set(name: str, seeds: Sequence[int], folder: Path) -> int:
    """Write each flight of a set into a folder a cell; return how many were new."""
    new = 0
    for cell in SETS[name]:
        place = folder / cell.name
        place.mkdir(parents=True, exist_ok=True)
        missing = [seed for seed in seeds if not (place / f"{seed}{TRUTH}").exists()]
        for seed in missing:
            write_flight(cell, seed, place)
        new += len(missing)
    return new


def command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Write sets of flights of the independent generator: a log and its truth each."""
    parser.add_argument("sets", nargs="+", metavar="SET", choices=SETS, help=", ".join(SETS))
    parser.add_argument("--seeds", required=True, metavar="A:B", help="from A to B - 1")
    parser.add_argument("--out", type=Path, required=True, help="folder")
    choice = parser.parse_args(words)
    seeds = seeds_of(parser, choice.seeds)
    for name in choice.sets:
        print(f"{name}: {write_set(name, seeds, choice.out)} new logs in {choice.out}", flush=True)
