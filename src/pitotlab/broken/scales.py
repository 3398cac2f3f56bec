"""Sweep the factor on the airspeed over what a sensor may have, in each container and at two heights."""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pitotlab.broken.breaks import LIGHT, as_shown
from pitotlab.broken.measure import SCALED, THINNED, answer_of, scaled
from pitotlab.outside.generator import generate
from pitotlab.outside.physics import FOOT, calibrated_airspeed
from pitotlab.outside.written import DEVELOPMENT_BELOW, SCORED_FROM

HEIGHTS_FT = (1500.0, 6000.0)
FACTORS = tuple(float(each) for each in np.round(np.arange(0.80, 1.201, 0.02), 2))


@dataclass(frozen=True, slots=True)
class ScaleRow:
    """What was said of a log whose airspeed is to be multiplied by `factor`, the airplane's own
    error included.
    """

    container: str
    height_ft: float
    factor: float
    found: float = float("nan")
    two_sigma: float = float("nan")
    usable: bool = False
    says: str = ""

    @property
    def inside(self) -> bool:
        """Whether the factor is inside its 2σ."""
        return abs(self.found - self.factor) <= self.two_sigma


def scale_row(
    container: str, height_ft: float, given: float, seed: int, folder: Path, *, temperature: bool
) -> ScaleRow:
    """Write, read and calibrate one log as the command does; a table holds the airspeed itself.
    Without the `temperature` a standard day is assumed.
    """
    cell = replace(LIGHT, height=height_ft * FOOT, temperature="air")
    flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
    right = calibrated_airspeed(flight.state.impact)
    own = float(np.mean(right / calibrated_airspeed(flight.state.indicated_impact)))
    columns = {name: column[::THINNED] for name, column in scaled(flight, given).items()}
    if container == ".csv":
        columns = as_shown(columns)
        if temperature:
            columns["air_temperature_k"] = flight.columns["air_temperature_k"][::THINNED]
    path = folder / f"log{container}"
    SCALED[container](columns, path)
    answer, says = answer_of(path)
    row = ScaleRow(container, height_ft, given * own, says=says)
    if answer is None or answer.scale is None:
        return row
    found = answer.scale
    return replace(row, found=found.factor, two_sigma=found.two_sigma, usable=answer.usable)


def rows(
    seed: int, factors: Sequence[float], temperature: bool, folder: Path
) -> Iterator[ScaleRow]:
    """The rows of a sweep, a flight of its own for each factor and height."""
    for container in SCALED:
        place = seed
        for height in HEIGHTS_FT:
            for factor in factors:
                yield scale_row(container, height, factor, place, folder, temperature=temperature)
                place += 1


def command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Count false "do not use" and factors inside their 2σ, scales 0.80 to 1.20 by 0.02."""
    parser.add_argument("--seed", type=int, required=True, help="of the first flight")
    parser.add_argument("--temperature", action="store_true", help="log the temperature in tables")
    parser.add_argument("--every", type=int, default=1, help="take one factor in so many")
    choice = parser.parse_args(words)
    if not (choice.seed < DEVELOPMENT_BELOW or choice.seed >= SCORED_FROM):
        parser.error(f"give a seed below {DEVELOPMENT_BELOW} or from {SCORED_FROM} on")
    found: dict[tuple[str, float], list[ScaleRow]] = {}
    with TemporaryDirectory() as folder:
        factors = FACTORS[:: choice.every]
        for row in rows(choice.seed, factors, choice.temperature, Path(folder)):
            found.setdefault((row.container, row.height_ft), []).append(row)
            if not (row.usable and row.inside):
                print(
                    f"  {row.container} {row.height_ft:.0f} ft: {row.factor:.3f}, found "
                    f"{row.found:.3f} ± {row.two_sigma:.3f}, {row.says[:160]}",
                    flush=True,
                )
    print("container  height [ft]  logs  not to be used  inside 2σ  median 2σ")
    for (container, height), group in found.items():
        refused = sum(not each.usable for each in group)
        inside = sum(each.inside for each in group)
        bound = float(np.median([each.two_sigma for each in group]))
        print(
            f"{container:9}  {height:11.0f}  {len(group):4}  {refused:14}  {inside:9}  {bound:.3f}"
        )
