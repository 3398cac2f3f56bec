"""Causes that the table of effects does not hold, made by hand: edited airplanes, and sensors of
their own.

Nothing here uses the terms of `effects/formula`, nor any effect of the table: the airplane is
edited as text, and a sensor error is written on the recorded channels.
"""

import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path

import numpy as np

from pitotbench import Case, FlightLog, fly, sense
from pitotbench.records.case import PressureErrorSpec, Wind

AIRCRAFT = Path(__file__).resolve().parents[2] / "aircraft" / "navajo"
KNOT = 0.514444
Sensor = Callable[[FlightLog], FlightLog]


@dataclass(frozen=True)
class Outsider:
    """A hidden cause: functions put into the airplane's file by axis, replaced text, or an error of
    a sensor.
    """

    where: str  # the quantity that a right formula corrects
    functions: Mapping[str, str] | None = None
    text: tuple[str, str] | None = None
    sensor: Sensor | None = None


def times(*factors: str | float) -> str:
    terms = (
        f"<value>{f}</value>" if isinstance(f, float) else f"<property>{f}</property>"
        for f in factors
    )
    return "<product>" + "".join(terms) + "</product>"


AREA, BETA = "aero/qbar-area", "aero/beta-rad"


OUTSIDERS: Mapping[str, Outsider] = {
    "drag in sideslip": Outsider("drag", {"DRAG": times(AREA, BETA, BETA, 3.0)})
}


def day(number: int, maneuver: str = "diagnostic", aircraft: str = "navajo") -> Case:
    """A flight of a card on a day of its own: wind, error curve and seeds."""
    draw = np.random.default_rng(number)
    wind = Wind(float(draw.uniform(4.0, 22.0)) * KNOT, radians(float(draw.uniform(0.0, 360.0))))
    curve = PressureErrorSpec(
        parameters=tuple(float(draw.uniform(0.6, 1.4)) * p for p in (-0.06, 0.006, 0.06))
    )
    return Case(
        aircraft=aircraft,
        maneuver=maneuver,
        turbulence="light",
        wind=wind,
        pressure_error=curve,
        truth_seed=number,
        sensor_seed=number,
    )


def flown(outsider: Outsider | None, number: int, folder: Path, das: str = "50/50") -> FlightLog:
    """The log of a flight with a hidden cause, on a day of its own; `folder` takes the edited
    airplane.
    """
    if outsider is None or outsider.sensor is not None:
        log = sense(fly(day(number)), das)
        return log if outsider is None or outsider.sensor is None else outsider.sensor(log)
    with edited(outsider, folder) as name:
        log = sense(fly(day(number, aircraft=name)), das)
    return replace(log, header=_without_aircraft(log.header))


def _without_aircraft(header: Mapping[str, object]) -> dict[str, object]:
    """The header of a log without the name of the edited airplane."""
    case = header["case"]
    assert isinstance(case, Mapping)
    return {**header, "case": {k: v for k, v in case.items() if k != "aircraft"}}


@contextmanager
def edited(outsider: Outsider, folder: Path) -> Iterator[str]:
    """An airplane edited as text, on the shelf of a folder that is the working directory meanwhile."""
    name, back = "outsider", Path.cwd()
    place = folder / "aircraft" / name
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(AIRCRAFT, place)
    text = (place / "navajo.xml").read_text(encoding="utf-8")
    (place / "navajo.xml").unlink()
    for axis, value in (outsider.functions or {}).items():
        function = (
            f'<axis name="{axis}">\n<function name="aero/hidden-{axis.lower()}">{value}</function>'
        )
        assert f'<axis name="{axis}">' in text
        text = text.replace(f'<axis name="{axis}">', function, 1)
    if outsider.text is not None:
        assert outsider.text[0] in text
        text = text.replace(*outsider.text)
    (place / f"{name}.xml").write_text(text, encoding="utf-8")
    os.chdir(folder)
    try:
        yield name
    finally:
        os.chdir(back)
