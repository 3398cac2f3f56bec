"""Roll against the turn that the GPS shows, and pitch against the specific force along the airplane."""

import numpy as np

from pitotbench.logbook.draft import Draft
from pitotbench.logbook.plausibility.limits import LIMITS
from pitotbench.logbook.plausibility.speed import Factor, FlownRows
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.units import STANDARD_GRAVITY, SUFFIXES, Array

_SPAN = 4.0  # s, over which an acceleration is taken: longer than a fix of 1 Hz, shorter than a turn


def check_attitude(draft: Draft, flown: FlownRows, factor: Factor) -> None:
    """Leave out a roll or pitch in another unit than its column says; warn of one with the wrong sign."""
    forward, right = _accelerations(flown, factor.wind)
    if "roll" in draft.channels:
        _compare(draft, "roll", np.arctan(right / STANDARD_GRAVITY), draft.channels["roll"][flown.rows], False)
    if "pitch" in draft.channels and "specific_force_x" in draft.channels:
        force = draft.channels["specific_force_x"][flown.rows] - forward
        # In a turn of bank φ the force along the airplane is that of the angle of attack times the load factor,
        # 1/cos φ, and the pitch is cos φ of the angle of attack.
        in_level_flight = force / (1.0 + (right / STANDARD_GRAVITY) ** 2)
        expected = np.arcsin(np.clip(in_level_flight / STANDARD_GRAVITY, -0.9, 0.9))
        _compare(draft, "pitch", expected, draft.channels["pitch"][flown.rows], True)


def _accelerations(flown: FlownRows, wind: Array) -> tuple[Array, Array]:
    """Along and to the right of the path through the air [m/s²], (n,), over `_SPAN`."""
    north, east = (_rate(flown.time, v) for v in (flown.north, flown.east))
    through = flown.north - wind[0], flown.east - wind[1]
    speed = np.maximum(np.hypot(*through), 1.0)
    forward = (north * through[0] + east * through[1]) / speed
    right = (east * through[0] - north * through[1]) / speed
    return forward, right


def _rate(time: Array, values: Array) -> Array:
    before, after = np.maximum(time - _SPAN / 2.0, time[0]), np.minimum(time + _SPAN / 2.0, time[-1])
    change = np.interp(after, time, values) - np.interp(before, time, values)
    return np.asarray(change / np.maximum(after - before, 1e-3))


def _compare(draft: Draft, name: str, expected: Array, measured: Array, about_mean: bool) -> None:
    """Name the unit or the sign with which the measured angle would be the expected one."""
    if about_mean:
        expected, measured = expected - np.mean(expected), measured - np.mean(measured)
    power = float(np.mean(expected**2))
    needed = LIMITS.pitch_needed if about_mean else LIMITS.bank_needed
    size = float(np.sqrt(np.mean(measured**2)))
    if np.sqrt(power) < needed or size == 0.0:
        return
    slope = float(np.mean(expected * measured)) / power
    if abs(slope) * np.sqrt(power) / size < LIMITS.agrees:
        return
    column = draft.columns[name]
    if not LIMITS.slope_low < abs(slope) < LIMITS.slope_high:
        fits = [f"{name}_{s}" for s in _units(draft, name, slope)]
        way_out = f"; it would fit {' or '.join(fits)}: name the column so" if fits else "; check its unit"
        draft.leave_out(name, f"the motion asks for {1.0 / abs(slope):.2g} times the angle{way_out}")
    elif slope < 0.0:
        draft.warnings.append(f"column {column!r}: the angle has the wrong sign against the motion of the airplane")


def _units(draft: Draft, name: str, slope: float) -> list[str]:
    written = SUFFIXES[draft.suffixes[name]].factor
    return [
        s
        for s in QUANTITIES[name].suffixes
        if LIMITS.slope_low < abs(slope) * SUFFIXES[s].factor / written < LIMITS.slope_high
    ]
