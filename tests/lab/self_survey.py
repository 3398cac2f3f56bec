"""The self survey of Jurado and McGehee (Journal of Aircraft 56, 2019), written from its published
equations.

Five unknowns of a whole log: the offset of the ambient pressure, three components of a constant
wind, and the recovery factor of the probe. The ambient pressure follows the geometric height by
hydrostatics, the Mach number follows from it and the total pressure, the speed from Mach number and
temperature. Attitude and sideslip turn the speed into a velocity through the air; with the wind it
must be the GPS velocity, in three components.

Nothing here comes from the product. Units are SI; angles are radians.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]
KNOT, FOOT, PSI = 1852.0 / 3600.0, 0.3048, 6894.757293168
_GRAVITY, _GAS, _GAMMA = 9.80665, 287.05287, 1.4
_ROUNDS = 4  # pressure, Mach number and temperature depend on one another: they settle at once


@dataclass(frozen=True, slots=True)
class Rows:
    """Rows of a log, (n,) each."""

    time: Array
    velocity: Array  # toward north, east, down (n, 3)
    height: Array
    total_pressure: Array
    static_pressure: Array
    total_temperature: Array
    sideslip: Array
    roll: Array
    pitch: Array
    heading: Array

    def select(self, mask: NDArray[np.bool_]) -> "Rows":
        """The rows of a mask."""
        return Rows(*(getattr(self, name)[mask] for name in self.__slots__))

    @property
    def indicated_mach(self) -> Array:
        """Mach number by the indicated pressures."""
        return mach_number(self.total_pressure, self.static_pressure)

    @property
    def indicated_airspeed(self) -> Array:
        """The speed at which a standard sea level gives the same impact pressure."""
        sea = np.full(len(self.time), 101325.0)
        return 340.294 * mach_number(sea + self.total_pressure - self.static_pressure, sea)


@dataclass(frozen=True, slots=True)
class Survey:
    """What the equations give: wind toward north, east and down, recovery factor, error of heading
    less sideslip, root mean square of the residual velocity, a component.
    """

    wind: Array
    recovery: float
    direction: float
    residual: float


def read(path: Path) -> Rows:
    """The rows of a flight-test log of the published data set."""
    t = pd.read_csv(path)
    named = {
        name: t[column].to_numpy(float) * unit
        for name, column, unit in (
            ("time", "time_s", 1.0),
            ("height", "height_ft", FOOT),
            ("total_pressure", "total_pres_psi", PSI),
            ("static_pressure", "static_pres_psi", PSI),
            ("total_temperature", "total_temp_K", 1.0),
            ("sideslip", "aos_rad", 1.0),
            ("roll", "roll_angle_rad", 1.0),
            ("pitch", "pitch_angle_rad", 1.0),
            ("heading", "true_heading_rad", 1.0),
        )
    }
    velocity = t[["north_vel_fps", "east_vel_fps", "down_vel_fps"]].to_numpy(float) * FOOT
    return Rows(velocity=velocity, **named)


def mach_number(total: Array, static: Array) -> Array:
    """Mach number of total and static pressure, behind a normal shock above 1 (Rayleigh)."""
    ratio = total / static
    mach = np.sqrt(5.0 * (ratio ** (2.0 / 7.0) - 1.0))
    fast = mach > 1.0
    for _ in range(30):
        mach[fast] = (ratio[fast] / 166.92158 * (7.0 * mach[fast] ** 2 - 1.0) ** 2.5) ** (1.0 / 7.0)
    return mach


def survey(rows: Rows, free_direction: bool = False) -> Survey:
    """Solve the five unknowns by least squares over all rows.

    `free_direction` adds a sixth that the published equations lack: a constant error of heading
    less sideslip.
    """
    direction = _through_the_air(rows)

    def residual(unknown: Array) -> Array:
        mach, temperature = _ambient(rows, unknown[0], unknown[4])
        speed = mach * np.sqrt(_GAMMA * _GAS * temperature)
        turned = _turned(direction, unknown[5]) if free_direction else direction
        return np.asarray((speed[:, None] * turned + unknown[1:4] - rows.velocity).ravel())

    start = np.array([0.0, 0.0, 0.0, 0.0, 1.0, *([0.0] if free_direction else [])])
    fit = least_squares(residual, start, method="lm")
    return Survey(
        wind=fit.x[1:4],
        recovery=float(fit.x[4]),
        direction=float(fit.x[5]) if free_direction else 0.0,
        residual=float(np.sqrt(np.mean(fit.fun**2))),
    )


def _turned(direction: Array, angle: float) -> Array:
    """Directions (n, 3) turned to the right by an angle."""
    north, east, down = direction.T
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine * north - sine * east, sine * north + cosine * east, down], axis=1)


def _ambient(rows: Rows, offset: float, recovery: float) -> tuple[Array, Array]:
    """Mach number and temperature in every row.

    The ambient pressure begins at the indicated static one times exp(`offset`) and follows the
    height.
    """
    ambient = rows.static_pressure
    for _ in range(_ROUNDS):
        mach = mach_number(rows.total_pressure, ambient)
        temperature = rows.total_temperature / (1.0 + 0.2 * recovery * mach**2)
        lightness = _GRAVITY / (_GAS * temperature)
        fall = np.cumsum(np.diff(rows.height, prepend=rows.height[0]) * lightness)
        ambient = rows.static_pressure[0] * np.exp(offset - fall)
    return mach, temperature


def _through_the_air(rows: Rows) -> Array:
    """Unit vectors of the velocity through the air, (n, 3): from attitude, flight path and
    sideslip.

    The angle of attack is the pitch less the slope of the flight path, as published; the vane is
    not used.
    """
    climb = np.arcsin(-rows.velocity[:, 2] / np.hypot(rows.velocity[:, 0], rows.velocity[:, 1]))
    attack = rows.pitch - climb
    slip = np.arctan(np.cos(attack) * np.tan(rows.sideslip))
    ahead, right, below = np.cos(attack) * np.cos(slip), np.sin(slip), np.sin(attack) * np.cos(slip)
    # Roll about the nose, pitch, then heading.
    cosine, sine = np.cos(rows.roll), np.sin(rows.roll)
    right, below = cosine * right - sine * below, sine * right + cosine * below
    cosine, sine = np.cos(rows.pitch), np.sin(rows.pitch)
    ahead, down = cosine * ahead + sine * below, -sine * ahead + cosine * below
    cosine, sine = np.cos(rows.heading), np.sin(rows.heading)
    return np.stack([cosine * ahead - sine * right, sine * ahead + cosine * right, down], axis=1)
