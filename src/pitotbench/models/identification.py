"""Maneuvers of system identification: those of SIDPAC's array `fdata`, and the lively parts of a
flight log.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pitotbench import air
from pitotbench.logbook.matlab import read_mat
from pitotbench.records import BadInputError
from pitotbench.records.aircraft import Motion
from pitotbench.records.log import FlightLog
from pitotbench.records.maneuver import CHANNELS, Maneuver
from pitotbench.timeline import fresh_fixes, minutes_text, pauses, stretches
from pitotbench.units import DEGREE, FOOT, POUND_FORCE, PSF, SLUG, STANDARD_GRAVITY, Array, Booleans

# The standard array of SIDPAC (Morelli, NASA, 2002): one row a sample, 90 columns, numbered from 1.
# Columns that were not measured are zero. Deflections are positive where they turn the airplane the
# negative way, so that its aileron is the negative of ours.

COLUMNS = 90
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
IDLE = 0.5  # of the throttles, whose position does not matter to the forces of the air


def is_identification(path: Path) -> bool:
    """Return whether a file is a .mat file with the array of SIDPAC. Raises BadInputError for a
    broken one.
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
        temperature_offset=_offset(temperature, pressure),
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
        noise={each: mean * _roughness(getattr(motion, each)) for each in NOISY},
    )


NOISY = (
    "angle_of_attack",
    "sideslip",
    "roll_rate",
    "pitch_rate",
    "yaw_rate",
    "elevator",
    "aileron",
    "rudder",
)


def _roughness(values: Array) -> float:
    """The deviation of white noise that second differences show: those of a motion are far smaller."""
    return float(np.sqrt(np.mean(np.diff(values, 2) ** 2) / 6.0)) if len(values) > 2 else 0.0


def _offset(temperature: Array, pressure: Array) -> float:
    """The mean offset from a standard day [K], height by height."""
    standard = air.standard_temperature(air.pressure_altitude(pressure))
    return float(np.mean((temperature - standard) * air.SEA_LEVEL_TEMPERATURE / standard))


# Find the maneuvers of a log: an airplane that flies straight and quietly says nothing of its
# derivatives.

LIVELY = 2.0 * DEGREE  # rad/s, of any body rate
QUIET_LEAST, QUIET_MOST = (
    4.0,
    12.0,
)  # s of quiet flight before and behind a maneuver; a longer pause parts two
SHORTEST, LONGEST = 6.0, 60.0  # s
LEAST_MACH = 0.1
SLOWEST = 5.0  # Hz
# Of all channels and of the slope of the rates alike: parabolas over so long follow a short period,
# and an error of the sensors that stands in the regressors makes every term too small.
SMOOTH = 0.5  # s
NEEDED = (
    *("roll", "pitch", "roll_rate", "pitch_rate", "yaw_rate", "angle_of_attack"),
    *("specific_force_x", "specific_force_y", "specific_force_z", "elevator", "aileron", "rudder"),
)


def maneuvers_of(log: FlightLog, name: str) -> list[Maneuver]:
    """Return the maneuvers of a log: the parts in which a body rate exceeds 2°/s, with some quiet
    flight around.

    Without sideslip the channels of side force, roll and yaw are left out. Without mass the model's
    counts. Raises BadInputError where the log lacks a channel that is needed, renews its rates too
    slowly, or holds no maneuver.
    """
    channels = log.channels()
    missing = [each for each in NEEDED if each not in channels]
    if missing:
        raise BadInputError(
            f"{name}: the terms of a model need {', '.join(missing)}, and the log has no such "
            "column"
        )
    time = log.time
    rates = np.stack([channels[f"{axis}_rate"] for axis in ("roll", "pitch", "yaw")], axis=1)
    renewed = float(fresh_fixes(None, *rates.T).sum() / (time[-1] - time[0]))
    if renewed < SLOWEST:
        raise BadInputError(
            f"{name}: the body rates are renewed {renewed:.1f} times a second, and their slope, "
            "the angular "
            f"acceleration, needs at least {SLOWEST:g}; record them faster, or reconcile without "
            "--terms"
        )
    mach = air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)
    lively = (np.abs(rates).max(axis=1) > LIVELY) & (mach > LEAST_MACH)
    parts = [
        part
        for each in stretches(time, pauses(time))
        for part in _parts(time[each], lively[each], each.start)
    ]
    if not parts:
        raise BadInputError(
            f"{name}: no maneuver of {SHORTEST:g} s and more in which a body rate exceeds 2°/s"
        )
    whole = _whole(log, mach, rates)
    return [
        _part(whole, rows, f"{name} at {minutes_text(time[rows.start] - time[0])}")
        for rows in parts
    ]


def _parts(time: Array, lively: Booleans, first: int) -> list[slice]:
    """The maneuvers of a stretch without pauses: lively parts joined over short rests, none too
    short or long.
    """
    places = np.flatnonzero(lively)
    if not len(places):
        return []
    breaks = np.flatnonzero(np.diff(time[places]) > QUIET_MOST) + 1
    found = []
    for group in np.split(places, breaks):
        begin, end = np.searchsorted(
            time, [time[group[0]] - QUIET_LEAST, time[group[-1]] + QUIET_LEAST]
        )
        count = int(np.ceil((time[end - 1] - time[begin]) / LONGEST)) or 1
        for some in np.array_split(np.arange(begin, end), count):
            if len(some) > 1 and time[some[-1]] - time[some[0]] >= SHORTEST:
                found.append(slice(first + int(some[0]), first + int(some[-1]) + 1))
    return found


def _whole(log: FlightLog, mach: Array, rates: Array) -> Maneuver:
    """A whole log as one maneuver, every channel filtered alike."""
    from scipy.signal import savgol_coeffs, savgol_filter

    channels, count, step = log.channels(), len(log.time), float(np.median(np.diff(log.time)))
    window = 2 * max(1, round(0.5 * SMOOTH / step)) + 1

    def smooth(values: Array, slope: int = 0) -> Array:
        return np.asarray(savgol_filter(values, window, 2, deriv=slope, delta=step, axis=0))

    temperature = log.air_temperature
    if temperature is None:
        total, standard = (
            log.total_temperature,
            air.standard_temperature(air.pressure_altitude(log.static_pressure)),
        )
        temperature = standard if total is None else air.air_temperature(total, mach)
    nothing, idle = np.zeros(count), np.full(count, IDLE)
    seen = channels.get("sideslip")
    motion = Motion(
        time=log.time,
        static_pressure=smooth(log.static_pressure),
        mach=smooth(mach),
        sideslip=nothing if seen is None else smooth(seen),
        heading=channels.get("heading", nothing),  # no force depends on it
        throttle_left=channels.get("throttle_left", idle),
        throttle_right=channels.get("throttle_right", idle),
        mass=channels.get("mass", nothing),
        temperature_offset=_offset(temperature, log.static_pressure),
        **{
            each: smooth(channels[each]) for each in NEEDED if not each.startswith("specific_force")
        },
    )
    forces = smooth(np.stack([channels[f"specific_force_{axis}"] for axis in "xyz"], axis=1))
    kept = CHANNELS if seen is not None else ("drag", "lift", "pitch moment")
    # Of white noise the filter leaves the share of its middle weight in the variance.
    left = float(np.sqrt(savgol_coeffs(window, 2)[window // 2]))
    noise = {each: left * _roughness(channels[each]) for each in NOISY if each in channels}
    return Maneuver(
        "", motion, forces, smooth(rates, 1), mass=channels.get("mass"), channels=kept, noise=noise
    )


LAGS = 0.05 * np.arange(
    -4, 13
)  # s, of the vane behind the accelerometers: vanes are damped, and buses slow


def align_vane(maneuvers: Sequence[Maneuver]) -> tuple[list[Maneuver], float]:
    """Return the maneuvers with the angle of attack earlier by the lag of its vane, and this lag
    [s].

    The lag is that at which angle of attack, pitch rate and elevator explain most of the normal
    force coefficient.
    """
    sums = [sum(_unexplained(each, lag) for each in maneuvers) for lag in LAGS.tolist()]
    lag = float(LAGS[int(np.argmin(sums))])
    return [_earlier(each, lag) for each in maneuvers], lag


def _earlier(maneuver: Maneuver, lag: float) -> Maneuver:
    motion = maneuver.motion
    shifted = np.interp(motion.time + lag, motion.time, motion.angle_of_attack)
    return replace(maneuver, motion=replace(motion, angle_of_attack=shifted))


def _unexplained(maneuver: Maneuver, lag: float) -> float:
    """The sum of squares of the normal force coefficient that the motion in pitch does not explain."""
    motion = _earlier(maneuver, lag).motion
    inner = slice(*np.searchsorted(motion.time, [-LAGS[0], motion.time[-1] - LAGS[-1]]))
    force = maneuver.specific_force[:, 2] / (motion.static_pressure * motion.mach**2)
    moved = (np.ones_like(force), motion.angle_of_attack, motion.pitch_rate, motion.elevator)
    design = np.stack(moved, axis=1)[inner]
    unexplained = force[inner] - design @ np.linalg.lstsq(design, force[inner], rcond=None)[0]
    return float(unexplained @ unexplained)


def _part(whole: Maneuver, rows: slice, name: str) -> Maneuver:
    """Some rows of a maneuver, as one of its own."""
    names = Motion.__dataclass_fields__.keys() - {"temperature_offset"}
    motion = replace(whole.motion, **{each: getattr(whole.motion, each)[rows] for each in names})
    motion = replace(motion, time=motion.time - motion.time[0])
    return replace(
        whole,
        name=name,
        motion=motion,
        specific_force=whole.specific_force[rows],
        angular_acceleration=whole.angular_acceleration[rows],
        mass=None if whole.mass is None else whole.mass[rows],
    )
