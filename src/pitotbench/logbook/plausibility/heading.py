"""Velocity against heading, where the log holds it: signs, exchanged or turned axes.

With z = north + i·east, the velocity over ground is a·V·e^(iψ) + wind, and a is near 1. A velocity with exchanged
axes or with one wrong sign is the mirror image, a·V·e^(−iψ) + wind; the angle of a says which.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.plausibility.limits import LIMITS
from pitotbench.logbook.plausibility.speed import Factor, FlownRows
from pitotbench.units import DEGREE, Array

Complex = NDArray[np.complex128]

_MIRRORED = {  # degrees of the angle of a, to the nearest quarter of a turn
    0: "the east velocity has the wrong sign",
    90: "the north and east velocities are exchanged",
    180: "the north velocity has the wrong sign",
    -90: "the north and east velocities are exchanged, with the wrong sign",
}


@dataclass(frozen=True, slots=True)
class Alignment:
    """Velocity against heading: the angle from one to the other [deg], its standard error [deg], and the rms of
    what does not fit, over the airspeed."""

    angle: float
    spread: float
    misfit: float


def check_heading(draft: Draft, flown: FlownRows, factor: Factor) -> None:
    """Warn where the velocity does not follow the heading; leave out a heading that stands still in turns."""
    heading = draft.channels.get("heading")
    if heading is None:
        return
    psi = heading[flown.rows]
    track = np.arctan2(flown.east, flown.north)
    if _turning(psi) < LIMITS.headings_spread:
        if _turning(track) > LIMITS.headings_spread and _turning(psi) < 0.1 * LIMITS.headings_spread:
            draft.leave_out("heading", "it does not turn while the GPS track does; check its unit")
        return
    words = _disagreement(flown, factor, psi, track)
    if words:
        draft.warnings.append(
            f"columns {draft.columns['heading']!r} and {draft.columns['velocity_north']!r}: {words}; the wind, and "
            "all that uses the heading, would be wrong"
        )


def align(flown: FlownRows, psi: Array, mirrored: bool) -> Alignment:
    """The least-squares a and wind of the velocity against the heading `psi` [rad], (n,)."""
    airspeed = air.true_airspeed(flown.impact, flown.static, flown.temperature)
    pointer = airspeed * np.exp(-1j * psi if mirrored else 1j * psi)
    velocity: Complex = flown.north + 1j * flown.east
    matrix = np.stack([pointer, np.ones_like(pointer)], axis=1)
    solution = np.linalg.lstsq(matrix, velocity, rcond=None)[0]
    rest = velocity - matrix @ solution
    misfit = float(np.sqrt(np.mean(np.abs(rest) ** 2)))
    scatter = float(np.std(pointer))
    spread = misfit / (abs(solution[0]) * scatter * np.sqrt(len(psi) / flown.shared))
    usual = abs(solution[0]) * float(np.median(airspeed))
    return Alignment(float(np.angle(solution[0])) / DEGREE, float(spread) / DEGREE, misfit / usual)


def _turning(angle: Array) -> float:
    """0 on one heading, 1 over full turns or out and back."""
    return 1.0 - float(np.abs(np.mean(np.exp(1j * angle))))


def _disagreement(flown: FlownRows, factor: Factor, psi: Array, track: Array) -> str:
    direct, mirror = align(flown, psi, False), align(flown, psi, True)
    if min(direct.misfit, mirror.misfit) > LIMITS.misfit_refused:
        return "the velocity does not follow the heading; check signs and units of both"
    if mirror.misfit < LIMITS.mirror_better * direct.misfit:
        quarter = round(mirror.angle / 90.0) * 90
        return f"{_MIRRORED[180 if abs(quarter) == 180 else quarter]}, or the heading is counted the wrong way"
    if min(direct.misfit, mirror.misfit) > LIMITS.misfit_doubted:
        return (
            f"the velocity does not follow the heading (they differ by {direct.misfit:.0%} rms): does one of its "
            "components lack its sign?"
        )
    if abs(direct.angle) - LIMITS.sigmas * direct.spread > LIMITS.angle_doubted:
        if abs(direct.angle) > 150.0:
            return "both velocities have the wrong sign, or the heading is that of the tail"
        return (
            f"the axes are turned by {direct.angle:+.0f}° against each other: is one of them magnetic, the heading "
            "not the airplane's, or a sign wrong?"
        )
    return _is_track(flown, factor, psi, track)


def _is_track(flown: FlownRows, factor: Factor, psi: Array, track: Array) -> str:
    """A heading that is the track itself, though the wind sets the airplane off."""
    difference = np.angle(np.exp(1j * (psi - track)))
    if float(np.sqrt(np.mean(difference**2))) > LIMITS.track_equal * DEGREE:
        return ""
    wind = float(np.hypot(*factor.wind)) / float(np.median(np.hypot(flown.north, flown.east)))
    return "" if wind < 4.0 * LIMITS.track_equal * DEGREE else "the heading is the track over ground"
