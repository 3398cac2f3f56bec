"""Hold the calibration of two jet flights against a weather balloon, with an independent reduction
beside it.

A balloon meets other air than the airplane: its own wind changes by some knots over 500 ft of
height, and that is added to the bound of the wind. The published equations take heading less
sideslip for exact; with a constant error of it as a sixth unknown, the wind of CLASS65 moves to the
answer's, which uses no direction.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tests.lab import self_survey
from tests.lab.self_survey import FOOT, KNOT, Array, Rows
from tests.shared_data import real_log

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import options_from
from pitotbench.logbook.mapping import find_mapping
from pitotbench.logbook.reading import read_log
from pitotbench.records.calibration import Calibration

FLIGHTS = ("CLASS55", "CLASS65")
AIRSPEEDS_KT = np.array([260.0, 300.0, 340.0, 380.0, 420.0])
_STEP = 500.0 * FOOT  # of height, over which the balloon's wind is compared with itself
_BAND = (15000.0 * FOOT, 26000.0 * FOOT)  # around the flights
_NEAR = 5.0 * KNOT


@dataclass(frozen=True, slots=True)
class Balloon:
    """Height [m], wind toward north and east [m/s], (n, 2), and pressure [Pa], by rising height."""

    height: Array
    wind: Array
    pressure: Array

    def wind_at(self, height: Array) -> Array:
        """The wind at heights (k,), (k, 2)."""
        return np.stack([np.interp(height, self.height, part) for part in self.wind.T], axis=1)

    def pressure_at(self, height: Array) -> Array:
        """The pressure at heights (k,), (k,)."""
        return np.exp(np.interp(height, self.height, np.log(self.pressure)))

    def wander(self) -> Array:
        """Rms change of the wind over 500 ft of height, toward north and east [m/s], (2,)."""
        low, high = _BAND
        at = self.height[(self.height >= low) & (self.height <= high - _STEP)]
        return np.sqrt(np.mean((self.wind_at(at + _STEP) - self.wind_at(at)) ** 2, axis=0))


@dataclass(frozen=True, slots=True)
class Held:
    """One flight against the balloon; winds toward north and east [m/s], Δp/q_c at `AIRSPEEDS_KT`.

    `reached` marks the airspeeds that the answer covers. `survey` is the published reduction,
    `freed` the same with an unknown error of the direction.
    """

    name: str
    found: Array
    two_sigma: Array
    reached: Array
    by_height: Array
    wind: Array
    wind_two_sigma: Array
    balloon_wind: Array
    wander: Array
    survey: self_survey.Survey
    freed: self_survey.Survey
    calibration: Calibration

    @property
    def error_inside(self) -> Array:
        """Whether the balloon's Δp/q_c is inside 2σ."""
        return np.abs(self.found - self.by_height) <= self.two_sigma

    @property
    def wind_bound(self) -> Array:
        """2σ of the difference between the flight's wind and the balloon's, (2,)."""
        return np.hypot(self.wind_two_sigma, 2.0 * self.wander)


def read_balloon(path: Path) -> Balloon:
    """Read the sounding."""
    lines = path.read_text(encoding="latin-1").splitlines()
    rows = [line.split() for line in lines if re.match(r"^\s*\d{4,6}\s+\d", line)]
    feet, degrees, knots, hectopascal = np.array(
        [[float(row[place]) for place in (0, 1, 2, 6)] for row in rows if len(row) > 12]
    ).T
    toward = np.radians(degrees) + np.pi
    wind = KNOT * knots[:, None] * np.stack([np.cos(toward), np.sin(toward)], axis=1)
    order = np.argsort(feet)
    return Balloon(FOOT * feet[order], wind[order], 100.0 * hectopascal[order])


def hold(name: str) -> Held:
    """Calibrate a flight as `pitotbench calibrate --mapping jmoss` does."""
    log, balloon = real_log("jmoss", f"{name}.csv"), read_balloon(real_log("jmoss", "WB.txt"))
    choices = options_from({"latency": "checked", **find_mapping("jmoss").calibrate})
    result, rows = calibrate(read_log(log, mapping="jmoss"), choices), self_survey.read(log)
    curve, airspeeds = result.curve, AIRSPEEDS_KT * KNOT
    survey, freed = (self_survey.survey(rows, free) for free in (False, True))
    ambient = balloon.pressure_at(rows.height)
    return Held(
        name=name,
        found=np.interp(airspeeds, curve.indicated_airspeed, curve.normalized_pressure_error),
        two_sigma=np.interp(airspeeds, curve.indicated_airspeed, curve.normalized_two_sigma),
        reached=airspeeds <= curve.indicated_airspeed[-1] + 0.01,
        by_height=_near(rows, (rows.static_pressure - ambient) / (rows.total_pressure - ambient)),
        wind=np.array([result.wind.north.value, result.wind.east.value]),
        wind_two_sigma=np.array([result.wind.north.two_sigma, result.wind.east.two_sigma]),
        balloon_wind=balloon.wind_at(rows.height).mean(axis=0),
        wander=balloon.wander(),
        survey=survey,
        freed=freed,
        calibration=result,
    )


def _near(rows: Rows, values: Array) -> Array:
    """Means of values (n,) over the rows within 5 kt of each airspeed of `AIRSPEEDS_KT`."""
    return np.array(
        [values[np.abs(rows.indicated_airspeed - at) < _NEAR].mean() for at in AIRSPEEDS_KT * KNOT]
    )
