"""Find the maneuvers of a log: quiet flight says nothing of an airplane's derivatives."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.records.maneuver import CHANNELS, Maneuver
from pitotbench.records.motion import Motion
from pitotbench.scatter import white_differences
from pitotbench.timeline import fresh_fixes, minutes_text, pauses, stretches
from pitotbench.units import DEGREE, Array, Booleans

IDLE = 0.5  # of the throttles, whose position does not matter to the forces of the air
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
LIVELY = 2.0 * DEGREE  # rad/s, of any body rate
# s of quiet flight before and behind a maneuver; a longer pause parts two.
QUIET_LEAST, QUIET_MOST = 4.0, 12.0
SHORTEST, LONGEST = 6.0, 60.0  # s of a maneuver
LEAST_MACH = 0.1  # of a maneuver in flight
SLOWEST = 5.0  # Hz of a log: a short period of a second or two needs as many samples
# Of all channels and of the slope of the rates alike: parabolas over so long follow a short period,
# and an error of the sensors that stands in the regressors makes every term too small.
SMOOTH = 0.5  # s
NEEDED = (
    *("roll", "pitch", "roll_rate", "pitch_rate", "yaw_rate", "angle_of_attack"),
    *("specific_force_x", "specific_force_y", "specific_force_z", "elevator", "aileron", "rudder"),
)


def maneuvers_of(log: FlightLog, name: str) -> list[Maneuver]:
    """Return the maneuvers of a log: parts with a body rate above 2°/s, and quiet flight around.

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
            f"the angular acceleration, needs at least {SLOWEST:g}; record them faster, or "
            "reconcile without --terms"
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
            f"{name}: no maneuver of {SHORTEST:g} s and more in which a body rate exceeds "
            f"{LIVELY / DEGREE:g}°/s"
        )
    whole = _whole(log, mach, rates)
    return [
        _part(whole, rows, f"{name} at {minutes_text(time[rows.start] - time[0])}")
        for rows in parts
    ]


def _parts(time: Array, lively: Booleans, first: int) -> list[slice]:
    """Return a stretch's maneuvers: lively parts joined over rests, none too short or long.

    The rests are short, and the stretch has no pauses.
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
        temperature_offset=temperature_offset(temperature, log.static_pressure),
        **{
            each: smooth(channels[each]) for each in NEEDED if not each.startswith("specific_force")
        },
    )
    forces = smooth(np.stack([channels[f"specific_force_{axis}"] for axis in "xyz"], axis=1))
    kept = CHANNELS if seen is not None else ("drag", "lift", "pitch moment")
    # Of white noise the filter leaves the share of its middle weight in the variance.
    left = float(np.sqrt(savgol_coeffs(window, 2)[window // 2]))
    noise = {each: left * roughness(channels[each]) for each in NOISY if each in channels}
    return Maneuver(
        "", motion, forces, smooth(rates, 1), mass=channels.get("mass"), channels=kept, noise=noise
    )


# s, of the vane behind the accelerometers: vanes are damped, and buses slow.
LAGS = 0.05 * np.arange(-4, 13)


def align_vane(maneuvers: Sequence[Maneuver]) -> tuple[list[Maneuver], float]:
    """Return maneuvers with the angle of attack earlier by its vane's lag, and that lag [s].

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
    """The normal force coefficient's sum of squares that the motion in pitch leaves."""
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


def roughness(values: Array) -> float:
    """Return the deviation of white noise that second differences show.

    A motion has far smaller differences.
    """
    return float(np.sqrt(np.mean(white_differences(values) ** 2))) if len(values) > 2 else 0.0


def temperature_offset(temperature: Array, pressure: Array) -> float:
    """Return the mean offset from a standard day [K], height by height."""
    standard = air.standard_temperature(air.pressure_altitude(pressure))
    return float(np.mean((temperature - standard) * air.SEA_LEVEL_TEMPERATURE / standard))
