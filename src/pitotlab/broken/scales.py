"""Sweep the factor on the airspeed over what a sensor may have, in each container and at two heights."""

import argparse
from dataclasses import replace
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pitotbench.records.calibration import Calibration
from pitotlab.broken.breaks import LIGHT, as_shown
from pitotlab.broken.measure import SCALED, THINNED, answer_of, scaled_flight
from pitotlab.outside.generator import generate
from pitotlab.outside.physics import FOOT
from pitotlab.sets import seeds_of

HEIGHTS_FT = (1500.0, 6000.0)
FACTORS = tuple(float(each) for each in np.round(np.arange(0.80, 1.201, 0.02), 2))


def answer(
    container: str, height_ft: float, given: float, seed: int, folder: Path, *, temperature: bool
) -> tuple[Calibration | None, float, str]:
    """Write, read and calibrate one log as the command does; return the answer, the true factor and
    what is said.

    A table holds the airspeed itself. Without the `temperature` a standard day is assumed.
    """
    cell = replace(LIGHT, height=height_ft * FOOT, temperature="air")
    columns, true = scaled_flight(cell, seed, given)
    if container == ".csv":
        columns = as_shown(columns)
        if temperature:
            flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
            columns |= {"air_temperature_k": flight.columns["air_temperature_k"][::THINNED]}
    path = folder / f"log{container}"
    SCALED[container](columns, path)
    found, says = answer_of(path)
    return found, true, says


def command(parser: argparse.ArgumentParser, words: list[str]) -> None:
    """Count false "do not use" and factors inside their 2σ, scales 0.80 to 1.20 by 0.02."""
    parser.add_argument("--seed", type=int, required=True, help="of the first flight")
    parser.add_argument("--temperature", action="store_true", help="log the temperature in tables")
    parser.add_argument("--every", type=int, default=1, help="take one factor in so many")
    choice = parser.parse_args(words)
    cases = [*product(HEIGHTS_FT, FACTORS[:: choice.every])]
    seeds = seeds_of(parser, f"{choice.seed}:{choice.seed + len(cases)}")
    print("container  height [ft]  logs  not to be used  inside 2σ  median 2σ")
    for container in SCALED:
        found: dict[float, list[tuple[bool, bool, float]]] = {height: [] for height in HEIGHTS_FT}
        for seed, (height, given) in zip(seeds, cases, strict=True):
            with TemporaryDirectory() as folder:
                told, true, says = answer(
                    container, height, given, seed, Path(folder), temperature=choice.temperature
                )
            scale = told.scale if told else None
            inside = scale is not None and abs(scale.factor - true) <= scale.two_sigma
            usable = told is not None and scale is not None and told.usable
            found[height].append((usable, inside, scale.two_sigma if scale else float("nan")))
            if not (usable and inside):
                print(
                    f"  {container} {height:.0f} ft: {true:.3f}, {scale}, {says[:160]}", flush=True
                )
        for height, rows in found.items():
            refused, held = len(rows) - sum(r[0] for r in rows), sum(r[1] for r in rows)
            bound = float(np.median([r[2] for r in rows]))
            numbers = f"{len(rows):4}  {refused:14}  {held:9}  {bound:.3f}"
            print(f"{container:9}  {height:11.0f}  {numbers}")
