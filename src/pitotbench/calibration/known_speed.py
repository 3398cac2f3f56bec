"""Reduce points with a known speed: those of a wind tunnel, a car, a pacer, a reference sensor."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import stdtrit

from pitotbench import air
from pitotbench.records import BadInputError
from pitotbench.records.legs import KnownSpeed, KnownSpeedResult, SpeedFactor

_FEWEST = 3
_TWO_SIGMA = 0.9772  # the share of a normal distribution below 2σ
_UNIFORM = 1.0 / np.sqrt(12.0)  # 1σ of a reading, in its steps


def reduce_known_speeds(
    points: Sequence[KnownSpeed], steps: Mapping[str, float]
) -> KnownSpeedResult:
    """Return the factor measured at each point, the correction by all of them, scale and zero.

    The known impact pressure is `scale` times the indicated one plus `zero`, by least squares; each
    point counts by the `steps` [m/s] in which its two speeds were read. What scatters by more than
    these widens all bounds, by Student's t of so few points. The known speed counts as a calibrated
    airspeed. Raises BadInputError for fewer than three points, for speeds of which none is above
    zero, and where all points have one speed.
    """
    known, shown = (
        np.array([getattr(each, name) for each in points])
        for name in ("known_airspeed", "indicated_airspeed")
    )
    if len(points) < _FEWEST or not np.all((known > 0.0) & (shown > 0.0)):
        raise BadInputError(
            f"points with a known speed need at least {_FEWEST} rows, each with two speeds above "
            "zero: remove the others"
        )
    true, indicated = air.impact_pressure(known), air.impact_pressure(shown)
    if np.ptp(indicated) <= 0.0:
        raise BadInputError("all points have one airspeed: a scale and a zero need two or more")
    noise = _UNIFORM * np.hypot(
        steps["known_airspeed"] / air.calibrated_airspeed_slope(true),
        steps["indicated_airspeed"] / air.calibrated_airspeed_slope(indicated),
    )
    design = np.column_stack([indicated, np.ones_like(indicated)])
    weighted = design / noise[:, None]
    covariance = np.linalg.inv(weighted.T @ weighted)
    scale, zero = covariance @ (weighted.T @ (true / noise))
    spare = len(points) - 2
    misfit = float(np.sum(((true - design @ np.array([scale, zero])) / noise) ** 2)) / spare
    width = float(stdtrit(spare, _TWO_SIGMA)) * np.sqrt(max(misfit, 1.0))
    fitted = np.maximum(design @ np.array([scale, zero]), 0.0)
    spread = width * np.sqrt(np.einsum("ij,jk,ik->i", design, covariance, design))
    speed = air.calibrated_airspeed(fitted)
    bound = spread * air.calibrated_airspeed_slope(np.maximum(fitted, 1e-3))
    scatter = width * noise * air.calibrated_airspeed_slope(true)
    order = np.argsort(shown)
    return KnownSpeedResult(
        points=tuple(
            _point(points[i], float(scatter[i]), float(speed[i]), float(bound[i])) for i in order
        ),
        scale=float(scale),
        scale_two_sigma=float(width * np.sqrt(covariance[0, 0])),
        zero=float(zero),
        zero_two_sigma=float(width * np.sqrt(covariance[1, 1])),
        scatter=float(np.std(known - speed)),
    )


def _point(each: KnownSpeed, scatter: float, speed: float, bound: float) -> SpeedFactor:
    shown = each.indicated_airspeed
    return SpeedFactor(
        point=each.point,
        configuration=each.configuration,
        indicated_airspeed=shown,
        known_airspeed=each.known_airspeed,
        factor=each.known_airspeed / shown,
        factor_two_sigma=scatter / shown,
        correction=speed - shown,
        two_sigma=bound,
    )
