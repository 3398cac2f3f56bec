"""Reduce a card written by hand: corrections of its points, one curve a configuration."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.calibration.card_model import (
    SIZES,
    CardModel,
    LegArrays,
    Sizes,
    by_point,
    leg_arrays,
    unit,
)
from pitotbench.calibration.card_slips import find_slips, legs_that_can_be
from pitotbench.calibration.leg_points import (
    circle_fit,
    circle_gain,
    three_leg_answers,
    three_leg_gain,
)
from pitotbench.calibration.options import USUAL, Accuracies
from pitotbench.estimation.restricted_likelihood import half_width
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.legs import CardLeg, CardPoint, HandCard, ReadingSteps, Slip
from pitotbench.units import KNOT, Array

_SPEEDS = 13  # airspeeds of a curve
_LIGHT = 1e-2  # of the weights: sizes that are as unlikely are left out
# The unequal airspeeds are referred to their mean along flight paths, which depend on the wind.
_ROUNDS, _SETTLED = 40, 1e-9  # at most; m/s
_STEP = 1e-3  # m/s
_TOO_WIDE = 20.0 * KNOT  # m/s, 2σ above which a point is none
# Log odds from which headings were written for tracks, a thousand to one. A slip less is as much.
_CLEARLY = 7.0


def reduce_card(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies = USUAL
) -> HandCard:
    """Return the points, curves and slips of a card. Legs are in the order in which they were
    flown.

    A point's true airspeed and wind are those of the published methods (three legs: Gray 1998;
    four: the mean of the four answers of three legs; more: a circle). Its bound propagates the
    steps of the readings, and wind that changes from leg to leg by as much as the card shows,
    through the weights of that method. A card whose tracks fit as headings alone is read so, with a
    warning. Raises BadInputError for fewer than three legs that can be.
    """
    if len(legs) < 3:
        raise BadInputError("a card needs at least three legs")
    model, slips, warnings = _as_meant(legs, steps, stated)
    heavy = _heavy(model.weights())
    named = {slip.row for slip in slips}
    written, used = by_point(legs), by_point(model.legs)
    points = tuple(
        _point([legs[i] for i in places], used.get(name, []), model, heavy, stated, named)
        for name, places in written.items()
    )
    configurations = dict.fromkeys(leg.configuration for leg in model.legs)
    curves = {name: _curve(name, model, heavy) for name in configurations}
    left_out = tuple(
        f"row {slip.row}, point {slip.point}: {slip.words}"
        + (f"; probably {slip.probably}" if slip.probably else "")
        + ": left out"
        for slip in slips
    )
    return HandCard(points, curves, slips, (*warnings, *left_out))


def _as_meant(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies
) -> tuple[CardModel, tuple[Slip, ...], tuple[str, ...]]:
    """The model of the legs that can be, the slips and a warning, with the directions as tracks or
    as headings.

    They are what the card says, unless the other makes the same legs clearly more probable.
    """
    kept, slips = find_slips(legs, steps, stated)
    said = CardModel(legs_that_can_be(legs), steps, stated)
    model = CardModel(kept, steps, stated) if slips else said
    if _odds_of_turning(said) <= 0.0:
        return model, slips, ()
    others, fewer = find_slips(_turned(legs), steps, stated)
    shared = {leg.row for leg in others}
    both = CardModel([leg for leg in kept if leg.row in shared], steps, stated)
    if _odds_of_turning(both) + _CLEARLY * (len(slips) - len(fewer)) < _CLEARLY:
        return model, slips, ()
    names = ("tracks", "track_deg"), ("headings", "heading_deg")
    (wrong, _), (right, column) = names if others[0].by_heading else names[::-1]
    words = f"the {wrong} of the card fit as {right}, and are read so: name the column {column}"
    return CardModel(others, steps, stated), fewer, (words,)


def _turned(legs: Sequence[CardLeg]) -> list[CardLeg]:
    return [replace(leg, by_heading=not leg.by_heading) for leg in legs]


def _odds_of_turning(said: CardModel) -> float:
    """The log odds of headings in the place of tracks, or of tracks in that of headings."""
    turned = CardModel(_turned(said.legs), said.steps, said.stated)
    return turned.log_evidence - said.log_evidence


def _point(
    own: Sequence[CardLeg],
    rows: Sequence[int],
    model: CardModel,
    heavy: tuple[list[Sizes], Array],
    stated: Accuracies,
    wrong: set[int],
) -> CardPoint:
    """The answer of one point from its legs `own`, of which the model has those in places `rows`."""
    used = [model.legs[place] for place in rows]
    indicated = float(np.mean([leg.indicated_airspeed for leg in used or own]))
    lost = [leg.row for leg in own if leg.row in wrong]
    remark = (
        f"without row{'s' if len(lost) > 1 else ''} {', '.join(map(str, lost))}" if lost else None
    )
    empty = CardPoint(
        point=own[0].point,
        configuration=own[0].configuration,
        legs=len(used),
        indicated_airspeed=indicated,
    )
    if len(used) < 3:
        left = (
            f"{len(used)} leg{'' if len(used) == 1 else 's'} left: no point, but used for the curve"
        )
        return replace(empty, remark=f"{remark}; {left}" if remark else left)
    arrays = leg_arrays(used)
    try:
        answer, spread, velocity = _answer(arrays, indicated)
        gain = (  # of the true airspeed, per change of each leg along its flight path
            circle_gain(velocity, answer)[:, 0] if len(velocity) > 4 else three_leg_gain(velocity)
        )
    except NoAnswerError as error:
        return replace(empty, remark=str(error))
    true = answer[0]
    correction, slope, per_kelvin = _correction(arrays, indicated, true)
    sigmas = np.array([np.sqrt(gain @ model.leg_noise(rows, sizes) @ gain) for sizes in heavy[0]])
    width = float(half_width(heavy[1], np.zeros((len(sigmas), 1)), sigmas[:, None])[0])
    two_sigma = float(np.hypot(slope * width, per_kelvin * stated.temperature_k))
    if two_sigma > _TOO_WIDE:
        return replace(
            empty, remark="the tracks are too near each other: fly them at least 60° apart"
        )
    height, per_speed = _height(arrays, indicated, correction)
    return replace(
        empty,
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


def _referred(arrays: LegArrays, indicated: float, answer: Array) -> Array:
    """Return the ground velocities (n, 2) [m/s] as they would be at one indicated airspeed and in
    one air, near an airspeed and a wind [m/s], (3,).
    """
    speeds = arrays.true_airspeed(0.0)
    common = float(_mean_air(arrays, indicated).true_airspeed(0.0)[0])
    velocity = arrays.ground_velocity(answer[0] + speeds - common, answer[1:])
    return np.asarray(velocity - (speeds - common)[:, None] * unit(velocity - answer[1:]))


def _mean_air(arrays: LegArrays, indicated: float) -> LegArrays:
    return LegArrays(
        np.array([indicated]),
        np.array([arrays.static_pressure.mean()]),
        np.array([arrays.air_temperature.mean()]),
        arrays.ground_speed[:1],
        arrays.toward[:1],
        arrays.by_heading[:1],
    )


def _answer(arrays: LegArrays, indicated: float) -> tuple[Array, float | None, Array]:
    """Return [V, W_N, W_E] [m/s] of legs, the spread of four, and the ground velocities at one
    airspeed (n, 2).
    """
    answer, spread, velocity = np.zeros(3), None, np.zeros((0, 2))
    answer[0] = float(arrays.true_airspeed(0.0).mean())
    for _ in range(_ROUNDS):
        velocity = _referred(arrays, indicated, answer)
        before, (answer, spread) = answer, _solved(velocity)
        if np.max(np.abs(answer - before)) < _SETTLED:
            break
    return answer, spread, velocity


def _solved(velocity: Array) -> tuple[Array, float | None]:
    """Return [V, W_N, W_E] [m/s] of ground velocities at one airspeed, (n, 2), by the published
    method, and the spread of four.
    """
    if len(velocity) > 4:
        return circle_fit(velocity), None
    answers = three_leg_answers(velocity)
    return answers.mean(axis=0), float(answers[:, 0].std(ddof=1)) if len(answers) > 1 else None


def _correction(arrays: LegArrays, indicated: float, true: float) -> tuple[float, float, float]:
    """Return the correction [m/s] for a true airspeed, its change per that, and per kelvin [m/s].

    The static source errs: p (1 + q_c/p) is the total pressure, which is right.
    """
    here = _mean_air(arrays, indicated)
    pressure, temperature = float(here.static_pressure[0]), float(here.air_temperature[0])
    ratio = float(air.impact_pressure_from_true_airspeed(true, 1.0, temperature))
    static = (pressure + float(air.impact_pressure(indicated))) / (1.0 + ratio)
    correction = float(air.calibrated_airspeed(static * ratio)) - indicated
    slope = 1.0 / float(here.slope(correction)[0])
    return correction, slope, slope * float(here.warmth(correction)[0])


def _height(arrays: LegArrays, indicated: float, correction: float) -> tuple[float, float]:
    """Return the altitude correction [m], true minus indicated, and its change per m/s of the
    correction.
    """

    def of(change: float) -> float:
        moved = air.impact_pressure(indicated) - air.impact_pressure(indicated + change)
        pressure = float(arrays.static_pressure.mean())
        return float(air.pressure_altitude(pressure + moved) - air.pressure_altitude(pressure))

    return of(correction), (of(correction + _STEP) - of(correction)) / _STEP


def _curve(configuration: str, model: CardModel, heavy: tuple[list[Sizes], Array]) -> ErrorCurve:
    own = [leg for leg in model.legs if leg.configuration == configuration]
    speeds = np.array([leg.indicated_airspeed for leg in own])
    low, high = float(speeds.min()), float(speeds.max())
    at = np.linspace(low, high, _SPEEDS) if high - low > KNOT else np.array([0.5 * (low + high)])
    means, variances = model.curves(at, configuration, heavy[0])
    mean = heavy[1] @ means
    bound = half_width(heavy[1], means, np.sqrt(variances))
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
        altitude_assumed=True,
        highest=max(leg.pressure_altitude for leg in own),
    )
