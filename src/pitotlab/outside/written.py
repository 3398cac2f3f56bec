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

DEVELOPMENT_BELOW, SCORED_FROM = 50_000, 600_000
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
        "mean_wind_kt": list(flight.truth.mean_wind / KNOT),
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


def write_set(name: str, seeds: Sequence[int], folder: Path) -> int:
    """Write each flight of a set: CELL/SEED.csv, SEED.truth.json; return how many were new."""
    new = 0
    for cell in SETS[name]:
        for seed in seeds:
            path = folder / cell.name / f"{seed}.csv"
            beside = path.with_suffix(TRUTH)
            if beside.exists():
                continue
            path.parent.mkdir(parents=True, exist_ok=True)
            flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
            write_csv(flight.columns, path)
            beside.write_text(json.dumps(truth_of(flight)), encoding="utf-8")
            new += 1
    return new


def command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Write sets of flights of the independent generator: a log and its truth each."""
    parser.add_argument("sets", nargs="+", metavar="SET", help=", ".join(SETS))
    parser.add_argument("--seeds", required=True, metavar="A:B", help="from A to B - 1")
    parser.add_argument("--out", type=Path, required=True, help="folder")
    choice = parser.parse_args(words)
    unknown = [name for name in choice.sets if name not in SETS]
    if unknown:
        parser.error(f"unknown set {unknown[0]!r}; known: {', '.join(SETS)}")
    first, _, behind = choice.seeds.partition(":")
    if not (first.isdigit() and behind.isdigit()):
        parser.error(f"--seeds {choice.seeds!r}: give two whole numbers, such as 1000:1008")
    seeds = checked_seeds(parser, int(first), int(behind) - int(first))
    for name in choice.sets:
        print(f"{name}: {write_set(name, seeds, choice.out)} new logs in {choice.out}", flush=True)


def checked_seeds(parser: argparse.ArgumentParser, first: int, flights: int) -> range:
    """Seeds that are all of development or all scored; ends the command where they are not."""
    seeds = range(first, first + flights)
    if flights < 1 or first < 0 or (seeds[-1] >= DEVELOPMENT_BELOW and first < SCORED_FROM):
        parser.error(
            f"seeds {first} to {first + flights - 1}: stay below {DEVELOPMENT_BELOW} (development) "
            f"or begin at {SCORED_FROM} or above (scored)"
        )
    return seeds
