"""Reduce a card written by hand: corrections of its points, one curve a configuration, slips named."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.calibrate.accuracy import USUAL as USUAL_ACCURACIES
from pitotbench.calibrate.accuracy import Accuracies
from pitotbench.calibrate.gps_legs.methods import circle_fit, fixed_speed
from pitotbench.calibrate.hand_card.card_model import SIZES, CardModel, Sizes
from pitotbench.calibrate.hand_card.leg_equations import LegArrays, leg_arrays
from pitotbench.calibrate.hand_card.slips import find_slips
from pitotbench.estimate.mixture import half_width
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.hand_card import CardLeg, CardPoint, HandCard, ReadingSteps
from pitotbench.units import KNOT, Array

_SPEEDS = 13  # airspeeds of a curve
_LIGHT = 1e-2  # of the weights: sizes that are as unlikely are left out
_ROUNDS = 4  # the unequal airspeeds are referred to their mean along flight paths, which depend on the wind
_STEP = 1e-3  # m/s
_TOO_WIDE = 20.0 * KNOT  # m/s, 2σ above which a point is none


def reduce_card(legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies = USUAL_ACCURACIES) -> HandCard:
    """Return the points, curves and slips of a card. Legs are in the order in which they were flown.

    A point's true airspeed and wind are those of the published methods (three legs: Gray 1998; four: the mean of
    the four answers of three legs; more: a circle). Its bound propagates the steps of the readings, and wind that
    changes from leg to leg by as much as the card shows, through the weights of that method. Raises BadInputError
    for fewer than three legs that can be.
    """
    if len(legs) < 3:
        raise BadInputError("a card needs at least three legs")
    kept, slips = find_slips(legs, steps, stated)
    model = CardModel(kept, steps, stated)
    weights = model.weights()
    named = {slip.row: slip for slip in slips}
    points = tuple(
        _point(name, legs, model, weights, stated, set(named)) for name in dict.fromkeys(leg.point for leg in legs)
    )
    configurations = dict.fromkeys(leg.configuration for leg in kept)
    curves = {name: _curve(name, model, weights) for name in configurations}
    warnings = tuple(
        f"row {slip.row}, point {slip.point}: {slip.words}"
        + (f"; probably {slip.probably}" if slip.probably else "")
        + ": left out"
        for slip in slips
    )
    return HandCard(points, curves, slips, warnings)


def _point(
    name: str, legs: Sequence[CardLeg], model: CardModel, weights: Array, stated: Accuracies, wrong: set[int]
) -> CardPoint:
    own = [leg for leg in legs if leg.point == name]
    rows = [place for place, leg in enumerate(model.legs) if leg.point == name]
    used = [model.legs[place] for place in rows]
    indicated = float(np.mean([leg.indicated_airspeed for leg in used or own]))
    lost = [leg.row for leg in own if leg.row in wrong]
    remark = f"without row{'s' if len(lost) > 1 else ''} {', '.join(map(str, lost))}" if lost else None
    empty = CardPoint(point=name, configuration=own[0].configuration, legs=len(used), indicated_airspeed=indicated)
    if len(used) < 3:
        left = f"{len(used)} leg{'' if len(used) == 1 else 's'} left: no point, but used for the curve"
        return _with_remark(empty, f"{remark}; {left}" if remark else left)
    arrays = leg_arrays(used)
    try:
        answer, spread, velocity = _answer(arrays, indicated)
        gain = _gain(velocity, answer[1:])
    except NoAnswerError as error:
        return _with_remark(empty, str(error))
    true = answer[0]
    correction, slope, per_kelvin = _correction(arrays, indicated, true)
    choices, share = _heavy(weights)
    sigmas = np.array([np.sqrt(gain @ model.leg_noise(rows, sizes) @ gain) for sizes in choices])
    width = float(half_width(share, np.zeros((len(share), 1)), sigmas[:, None])[0])
    two_sigma = float(np.hypot(slope * width, per_kelvin * stated.temperature_k))
    if two_sigma > _TOO_WIDE:
        return _with_remark(empty, "the tracks are too near each other: fly them at least 60° apart")
    height, per_speed = _height(arrays, indicated, correction)
    return CardPoint(
        point=name,
        configuration=own[0].configuration,
        legs=len(used),
        indicated_airspeed=indicated,
        calibrated_airspeed=indicated + correction,
        correction=correction,
        two_sigma=two_sigma,
        altitude_correction=height,
        altitude_two_sigma=abs(per_speed) * two_sigma,
        true_airspeed=true,
        spread=spread,
        wind_speed=float(np.hypot(*answer[1:])),
        wind_from=float(np.arctan2(-answer[2], -answer[1]) % (2.0 * np.pi)),
        remark=remark,
    )


def _heavy(weights: Array) -> tuple[list[Sizes], Array]:
    """Return the sizes that count, and their weights."""
    places = np.flatnonzero(weights > _LIGHT * weights.max())
    return [SIZES[place] for place in places], weights[places] / weights[places].sum()


def _with_remark(point: CardPoint, remark: str) -> CardPoint:
    return replace(point, remark=remark)


def _referred(arrays: LegArrays, indicated: float, wind: Array) -> Array:
    """Return the ground velocities (n, 2) [m/s] as they would be at one indicated airspeed and in one air."""
    speeds = arrays.true_airspeed(0.0)
    common = float(_mean_air(arrays, indicated).true_airspeed(0.0)[0])
    through = arrays.velocity - wind
    along = through / np.linalg.norm(through, axis=1, keepdims=True)
    return np.asarray(arrays.velocity - (speeds - common)[:, None] * along)


def _mean_air(arrays: LegArrays, indicated: float) -> LegArrays:
    return LegArrays(
        np.array([indicated]),
        np.array([arrays.static_pressure.mean()]),
        np.array([arrays.air_temperature.mean()]),
        arrays.velocity[:1],
    )


def _answer(arrays: LegArrays, indicated: float) -> tuple[Array, float | None, Array]:
    """Return [V, W_N, W_E] [m/s] of legs, the spread of four, and the ground velocities at one airspeed (n, 2)."""
    answer, spread, velocity = np.zeros(3), None, arrays.velocity
    for _ in range(_ROUNDS):
        velocity = _referred(arrays, indicated, answer[1:])
        answer, spread = _solved(velocity)
    return answer, spread, velocity


def _solved(velocity: Array) -> tuple[Array, float | None]:
    """Return [V, W_N, W_E] [m/s] of ground velocities at one airspeed, (n, 2), by the published method."""
    if len(velocity) > 4:
        return circle_fit(velocity), None
    found = fixed_speed(np.linalg.norm(velocity, axis=1), np.arctan2(velocity[:, 1], velocity[:, 0]))
    toward = found.wind_from + np.pi
    wind = found.wind_speed * np.cos(toward), found.wind_speed * np.sin(toward)
    return np.array([found.true_airspeed, *wind]), found.spread


def _gain(velocity: Array, wind: Array) -> Array:
    """Return the change of the true airspeed per change of each leg along its flight path, (n,) [-].

    `velocity` (n, 2) [m/s] are the ground velocities at one airspeed.
    """
    through = velocity - wind
    along = through / np.linalg.norm(through, axis=1, keepdims=True)
    here = _solved(velocity)[0][0]
    gain = np.empty(len(along))
    for leg in range(len(along)):
        moved = velocity.copy()
        moved[leg] += _STEP * along[leg]
        gain[leg] = (_solved(moved)[0][0] - here) / _STEP
    return gain


def _correction(arrays: LegArrays, indicated: float, true: float) -> tuple[float, float, float]:
    """Return the correction [m/s] for a true airspeed, its change per that, and per kelvin [m/s]."""
    here = _mean_air(arrays, indicated)
    correction = 0.0
    for _ in range(8):  # Newton: the true airspeed is nearly linear in the correction
        correction += (true - float(here.true_airspeed(correction)[0])) / float(here.slope(correction)[0])
    slope = 1.0 / float(here.slope(correction)[0])
    return correction, slope, slope * float(here.warmth(correction)[0])


def _height(arrays: LegArrays, indicated: float, correction: float) -> tuple[float, float]:
    """Return the altitude correction [m], true minus indicated, and its change per m/s of the correction."""

    def of(change: float) -> float:
        moved = air.impact_pressure(indicated) - air.impact_pressure(indicated + change)
        pressure = float(arrays.static_pressure.mean())
        return float(air.pressure_altitude(pressure + moved) - air.pressure_altitude(pressure))

    return of(correction), (of(correction + _STEP) - of(correction)) / _STEP


def _curve(configuration: str, model: CardModel, weights: Array) -> ErrorCurve:
    own = [leg for leg in model.legs if leg.configuration == configuration]
    speeds = np.array([leg.indicated_airspeed for leg in own])
    low, high = float(speeds.min()), float(speeds.max())
    at = np.linspace(low, high, _SPEEDS) if high - low > KNOT else np.array([0.5 * (low + high)])
    choices, share = _heavy(weights)
    means, variances = model.curves(at, configuration, choices)
    mean = share @ means
    bound = half_width(share, means, np.sqrt(variances))
    impact = air.impact_pressure(at)
    true = air.impact_pressure(at + mean)
    arrays = leg_arrays(own)
    heights = np.array([_height(arrays, float(v), float(c)) for v, c in zip(at, mean, strict=True)])
    relative = 1.0 / (impact * air.calibrated_airspeed_slope(impact))
    return ErrorCurve(
        indicated_airspeed=at,
        correction=mean,
        two_sigma=bound,
        simultaneous_two_sigma=bound,
        white_two_sigma=bound,
        normalized_pressure_error=(true - impact) / true,
        normalized_two_sigma=bound * relative,
        altitude_correction=heights[:, 0],
        altitude_two_sigma=np.abs(heights[:, 1]) * bound,
    )
