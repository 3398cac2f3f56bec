"""Read the standard array of SIDPAC (Morelli, NASA, 2002) as a maneuver, a row a sample.

The array has 90 columns. Columns are numbered from 1; those that were not measured are zero.
Deflections are positive where they turn the airplane the negative way, so that its aileron is the
negative of ours.
"""

from pathlib import Path

import numpy as np

from pitotbench import air
from pitotbench.logbook.matlab import read_mat
from pitotbench.models.maneuver_parts import IDLE, NOISY, roughness, temperature_offset
from pitotbench.records import BadInputError
from pitotbench.records.maneuver import Maneuver
from pitotbench.records.motion import Motion
from pitotbench.units import DEGREE, FOOT, POUND_FORCE, PSF, SLUG, STANDARD_GRAVITY, Array

COLUMNS = 90  # of `fdata`, the standard array of SIDPAC (Klein and Morelli 2006)
_SLUG_A_CUBIC_FOOT = SLUG / FOOT**3  # kg/m³
_SPEED, _SIDESLIP, _ALPHA, _ROLL_RATE, _ATTITUDE, _FORCE, _ELEVATOR = 2, 3, 4, 5, 8, 11, 14
_DYNAMIC_PRESSURE, _MACH, _DENSITY, _ALTITUDE, _THRUST, _TURNING, _MASS, _INERTIA = (
    27,
    28,
    29,
    30,
    38,
    42,
    48,
    49,
)
TENTH = 0.1  # s


def is_identification(path: Path) -> bool:
    """Return whether a file is a .mat file with the array of SIDPAC.

    Raises BadInputError for a broken one.
    """
    if path.suffix.lower() != ".mat" or not path.is_file():
        return False
    return f"fdata(:,{COLUMNS})" in read_mat(path).names


def read_identification(path: Path) -> Maneuver:
    """Return the maneuver of a file with the array of SIDPAC, in SI units and radians.

    Pressure and temperature come from dynamic pressure and Mach number, else from density and
    altitude. Raises BadInputError where neither is there, or where time does not increase.
    """
    table = read_mat(path)
    number = {name: i for i, name in enumerate(table.names)}

    def column(k: int) -> Array:
        return np.asarray(table.columns[number[f"fdata(:,{k})"]], dtype=np.float64)

    def columns(first: int) -> Array:
        return np.stack([column(first + i) for i in range(3)], axis=1)

    time = column(1)
    if len(time) < 10 or not np.all(np.diff(time) > 0.0):
        raise BadInputError(
            f"{path}: column 1 of fdata, the time, does not increase in at least ten rows"
        )
    speed = column(_SPEED) * FOOT
    if np.all(column(_MACH) > 0.0):
        mach = column(_MACH)
        pressure = column(_DYNAMIC_PRESSURE) * PSF / (0.5 * air.HEAT_RATIO * mach**2)
        temperature = (speed / mach) ** 2 / (air.HEAT_RATIO * air.GAS_CONSTANT)
    elif np.all(column(_DENSITY) > 0.0):
        pressure = air.standard_pressure(column(_ALTITUDE) * FOOT)
        temperature = pressure / (air.GAS_CONSTANT * column(_DENSITY) * _SLUG_A_CUBIC_FOOT)
        mach = speed / air.sound_speed(temperature)
    else:
        raise BadInputError(
            f"{path}: fdata needs Mach number (column {_MACH}) or density (column {_DENSITY})"
        )
    angles = np.hstack([columns(k) for k in (_ATTITUDE, _ROLL_RATE, _ELEVATOR)]) * DEGREE
    names = (
        "roll",
        "pitch",
        "heading",
        "roll_rate",
        "pitch_rate",
        "yaw_rate",
        "elevator",
        "aileron",
        "rudder",
    )
    turned = dict(zip(names, angles.T, strict=True))
    thrust = (column(_THRUST) + column(_THRUST + 1)) * POUND_FORCE
    mass = column(_MASS) * SLUG
    inertia = [float(np.mean(column(_INERTIA + i))) * SLUG * FOOT**2 for i in range(4)]
    motion = Motion(
        time=time - time[0],
        static_pressure=pressure,
        mach=mach,
        angle_of_attack=column(_ALPHA) * DEGREE,
        sideslip=column(_SIDESLIP) * DEGREE,
        **{**turned, "aileron": -turned["aileron"]},
        throttle_left=np.full(len(time), IDLE),
        throttle_right=np.full(len(time), IDLE),
        mass=mass,
        temperature_offset=temperature_offset(temperature, pressure),
    )
    # Of the mean of white noise over a tenth of a second, which is what is compared.
    mean = float(np.sqrt(min(1.0, np.median(np.diff(time)) / TENTH)))
    return Maneuver(
        path.stem,
        motion,
        columns(_FORCE) * STANDARD_GRAVITY,
        columns(_TURNING) * DEGREE,
        thrust if np.any(thrust) else None,
        mass if np.all(mass > 0.0) else None,
        tuple(inertia) if min(inertia[:3]) > 0.0 else None,
        noise={each: mean * roughness(getattr(motion, each)) for each in NOISY},
    )
