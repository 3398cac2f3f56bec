"""Causes that the table of effects does not hold, made by hand: edited airplanes, and sensors of their own.

Nothing here uses the terms of `effects/formula`, nor any effect of the table: the airplane is edited as text, and a
sensor error is written on the recorded channels.
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
KNOT, INCH = 0.514444, 3386.39
Sensor = Callable[[FlightLog], FlightLog]


@dataclass(frozen=True)
class Outsider:
    """A hidden cause: functions put into the airplane's file by axis, replaced text, or an error of a sensor."""

    where: str  # the quantity that a right formula corrects
    functions: Mapping[str, str] | None = None
    text: tuple[str, str] | None = None
    sensor: Sensor | None = None


def _times(*factors: str | float) -> str:
    terms = (f"<value>{f}</value>" if isinstance(f, float) else f"<property>{f}</property>" for f in factors)
    return "<product>" + "".join(terms) + "</product>"


AREA, SPAN, CHORD = "aero/qbar-area", "aero/qbar-area-span", "aero/qbar-area-chord"
POWER = "propulsion/engine[0]/power-hp"
BETA, BANK, HEADING = "aero/beta-rad", "attitude/phi-rad", "attitude/psi-rad"


def _static(log: FlightLog, share: np.ndarray) -> FlightLog:
    """The static pressure too high by a share of the impact pressure."""
    error = share * log.impact_pressure
    return replace(log, static_pressure=log.static_pressure + error, impact_pressure=log.impact_pressure - error)


def _horsepower(log: FlightLog) -> np.ndarray:
    """Manifold pressure times speed over that of the rating, about the share of the rated power."""
    return 0.5 * sum(
        log.channels()[f"manifold_pressure_{s}"] / (40.0 * INCH) * log.channels()[f"propeller_speed_{s}"] / 269.7
        for s in ("left", "right")
    )


def _mach(log: FlightLog) -> np.ndarray:
    return np.sqrt(5.0 * ((np.maximum(log.impact_pressure, 0.0) / log.static_pressure + 1.0) ** (2.0 / 7.0) - 1.0))


def _north(log: FlightLog) -> FlightLog:
    """A receiver whose velocity north errs with the heading: its antenna is shaded on two sides."""
    return replace(log, velocity_north=log.velocity_north + 0.5 * np.cos(2.0 * log.heading))


def _warm(log: FlightLog) -> FlightLog:
    """A probe that reads warmer as Mach number falls: its heater warms it in slow air."""
    return replace(log, total_temperature=log.total_temperature + 25.0 * (0.25 - _mach(log)))


def _vane(log: FlightLog) -> FlightLog:
    """A sideslip vane in the slipstream."""
    return replace(log, sideslip=log.sideslip + 0.04 * _horsepower(log))


def _horizon(log: FlightLog) -> FlightLog:
    """A vertical gyro that tilts in a turn."""
    return replace(log, pitch=log.pitch + 0.06 * np.sin(log.roll) ** 2)


def _accelerometer(log: FlightLog) -> FlightLog:
    """A longitudinal accelerometer that the airplane's sideways force tilts."""
    return replace(log, specific_force_x=log.specific_force_x + 0.12 * log.specific_force_y)


def _fuel(log: FlightLog) -> FlightLog:
    """Two fuel-flow transducers that read less at a high flow."""
    return replace(
        log,
        fuel_flow_left=log.fuel_flow_left - 5.0 * log.fuel_flow_left**2,
        fuel_flow_right=log.fuel_flow_right - 5.0 * log.fuel_flow_right**2,
    )


def _gyro(log: FlightLog) -> FlightLog:
    """A yaw gyro that feels the load factor."""
    return replace(log, pitch_rate=log.pitch_rate + 0.1 * log.sideslip)


OUTSIDERS: Mapping[str, Outsider] = {
    "drag in sideslip": Outsider("drag", {"DRAG": _times(AREA, BETA, BETA, 3.0)}),
    "gear door that flutters": Outsider("drag", {"DRAG": _times(AREA, "aero/qbar-psf", "aero/qbar-psf", 1.5e-6)}),
    "cowl flaps with power": Outsider("drag", {"DRAG": _times(AREA, POWER, 3e-5)}),
    "wing shaded in sideslip": Outsider("lift", {"LIFT": _times(AREA, BETA, BETA, -8.0)}),
    "thrust line": Outsider("pitch moment", {"PITCH": _times(CHORD, POWER, 8e-5)}),
    "slipstream on the fin": Outsider("yaw moment", {"YAW": _times(SPAN, POWER, 1.2e-5)}),
    "yaw by aileron": Outsider("yaw moment", {"YAW": _times(SPAN, "fcs/left-aileron-pos-rad", 0.03)}),
    "static port behind the elevator": Outsider(
        "static pressure", sensor=lambda g: _static(g, 0.8 * (g.elevator - 0.02))
    ),
    "static port low in the bank": Outsider(
        "static pressure", sensor=lambda g: _static(g, 0.12 * np.sin(g.roll) ** 2)
    ),
    "receiver shaded on two sides": Outsider("velocity north", sensor=_north),
    "probe heated in slow air": Outsider("temperature", sensor=_warm),
    "vane in the slipstream": Outsider("sideslip", sensor=_vane),
    "gyro tilted in turns": Outsider("pitch", sensor=_horizon),
    "accelerometer tilted by side force": Outsider("longitudinal acceleration", sensor=_accelerometer),
    "fuel flow low at high power": Outsider("fuel flow", sensor=_fuel),
    "gyro that feels the sideslip": Outsider("pitch rate", sensor=_gyro),
}


def day(number: int, maneuver: str = "diagnostic", aircraft: str = "navajo") -> Case:
    """A flight of a card on a day of its own: wind, error curve and seeds."""
    draw = np.random.default_rng(number)
    wind = Wind(float(draw.uniform(4.0, 22.0)) * KNOT, radians(float(draw.uniform(0.0, 360.0))))
    curve = PressureErrorSpec(parameters=tuple(float(draw.uniform(0.6, 1.4)) * p for p in (-0.06, 0.006, 0.06)))
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
    """The log of a flight with a hidden cause, on a day of its own; `folder` takes the edited airplane."""
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
        function = f'<axis name="{axis}">\n<function name="aero/hidden-{axis.lower()}">{value}</function>'
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
