"""Reduce a card written by hand: corrections of its points, one curve a configuration."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.calibration.card_model import CardModel, rows_of
from pitotbench.calibration.card_slips import find_slips
from pitotbench.calibration.leg_methods import LegAir, by_track, solve_group, wind_from
from pitotbench.calibration.options import (
    USUAL,
    Accuracies,
    Priors,
    StatedPriors,
    priors_of_card,
    stated_of,
)
from pitotbench.estimation.mixture import half_width
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.legs import CardLeg, CardPoint, HandCard, ReadingSteps, Slip
from pitotbench.units import KNOT, Array

_SPEEDS = 13  # airspeeds of a curve
_STEP = 1e-3  # m/s
_TOO_WIDE = 20.0 * KNOT  # m/s, 2σ above which a point is none
# Log odds from which headings were written for tracks, thirty to one: no right card of 340 of one
# to five points reaches them. A slip less is as much.
_CLEARLY = 3.5


def reduce_card(
    legs: Sequence[CardLeg],
    steps: ReadingSteps,
    stated: Accuracies = USUAL,
    priors: StatedPriors = None,
) -> HandCard:
    """Return the points, curves and slips of a card, its legs in the order they were flown.

    A point's true airspeed and wind are those of the published methods (three legs: Gray 1998;
    four: the mean of the four answers of three legs; more: a circle). Its bound propagates the
    steps of the readings, and wind that changes from leg to leg by as much as the card shows,
    through the weights of that method. A card whose tracks fit as headings alone is read so, with a
    warning. `priors` are those of the curves. Raises BadInputError for fewer than three legs that
    can be, and for a prior that a card does not take.
    """
    if len(legs) < 3:
        raise BadInputError("a card needs at least three legs")
    model, slips, warnings = _as_meant(legs, steps, stated, priors_of_card(priors))
    places: dict[str, list[int]] = {}
    for place, leg in enumerate(legs):
        places.setdefault(leg.point, []).append(place)
    heard = [leg for leg, struck in zip(model.legs, model.struck, strict=True) if not struck]
    left_out = tuple(
        f"row {slip.row}, point {slip.point}: {slip.words}"
        + (f"; probably {slip.probably}" if slip.probably else "")
        + ": left out"
        for slip in slips
    )
    return HandCard(
        tuple(_point(own, model, stated) for own in places.values()),
        {name: _curve(name, model) for name in dict.fromkeys(leg.configuration for leg in heard)},
        slips,
        (*warnings, *left_out),
        stated_of(priors),
    )


def _as_meant(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies, priors: Priors
) -> tuple[CardModel, tuple[Slip, ...], tuple[str, ...]]:
    """Return the model of the card, its slips and a warning, with directions as tracks or headings.

    Directions are what the card says, unless the other makes the same legs clearly more probable.
    """
    model, slips = find_slips(legs, steps, stated, priors)
    other = CardModel(_turned(model.legs), steps, stated, model.struck_rows, priors)
    noise = model.likeliest_noise
    if other.log_evidence(noise) <= model.log_evidence(noise):
        return model, slips, ()
    other, fewer = find_slips(_turned(legs), steps, stated, priors)
    struck = model.struck_rows | other.struck_rows
    here, there = (
        each.log_evidence(each.likeliest_noise)
        for each in (model.without(struck), other.without(struck))
    )
    if there - here + _CLEARLY * (len(slips) - len(fewer)) < _CLEARLY:
        return model, slips, ()
    names = ("tracks", "track_deg"), ("headings", "heading_deg")
    (wrong, _), (right, column) = names if other.legs[0].by_heading else names[::-1]
    words = f"the {wrong} of the card fit as {right}, and are read so: name the column {column}"
    return other, fewer, (words,)


def _turned(legs: Sequence[CardLeg]) -> list[CardLeg]:
    return [replace(leg, by_heading=not leg.by_heading) for leg in legs]


def _point(own: Sequence[int], model: CardModel, stated: Accuracies) -> CardPoint:
    """The answer of one point from its legs in the places `own`."""
    used = [place for place in own if not model.struck[place]]
    legs = [model.legs[place] for place in used or own]
    lost = [str(model.legs[place].row) for place in own if model.struck[place]]
    remarks = [f"without row{'s' if len(lost) > 1 else ''} {', '.join(lost)}"] if lost else []
    indicated = float(np.mean([leg.indicated_airspeed for leg in legs]))
    point = CardPoint(
        point=legs[0].point,
        configuration=legs[0].configuration,
        legs=len(used),
        indicated_airspeed=indicated,
    )
    if len(used) < 3:
        few = (
            f"{len(used)} leg{'' if len(used) == 1 else 's'} left: no point, but used for the curve"
        )
        return replace(point, remark="; ".join([*remarks, few]))
    rows = rows_of(legs)
    if len(set(number := by_track(rows.toward))) > 2:  # else too near, or all around
        rows = replace(rows, leg=number)
    try:
        solved = solve_group(rows)
    except NoAnswerError as error:
        return replace(point, remark=str(error))
    indicated = float(solved.air.indicated_airspeed)
    true, sigmas = float(solved.answer[0]), model.deviations(used, solved.gain[:, 0])[:, None]
    (width,) = half_width(model.posterior.weights, np.zeros_like(sigmas), sigmas)
    correction, two_sigma = solved.air.corrected(true, float(width), stated)
    if two_sigma > _TOO_WIDE:
        return replace(
            point, remark="the tracks are too near each other: fly them at least 60° apart"
        )
    height, per_speed = map(float, _height(rows.air, np.asarray(indicated), np.asarray(correction)))
    return replace(
        point,
        indicated_airspeed=indicated,
        calibrated_airspeed=indicated + correction,
        correction=correction,
        two_sigma=two_sigma,
        altitude_correction=height,
        altitude_two_sigma=abs(per_speed) * two_sigma,
        true_airspeed=true,
        spread=solved.spread,
        wind_speed=float(np.hypot(*solved.answer[1:])),
        wind_from=wind_from(solved.answer[1:]),
        remark="; ".join(remarks) or None,
    )


def _height(here: LegAir, indicated: Array, correction: Array) -> tuple[Array, Array]:
    """Return altitude corrections [m], true minus indicated, and their change per m/s.

    The change is with the corrections of the airspeed.
    """
    pressure = float(np.mean(here.static_pressure))
    changed = indicated + np.stack([correction, correction + _STEP])
    moved = pressure + air.impact_pressure(indicated) - air.impact_pressure(changed)
    found, next_to = np.asarray(air.pressure_altitude(moved)) - air.pressure_altitude(pressure)
    return found, (next_to - found) / _STEP


def _curve(configuration: str, model: CardModel) -> ErrorCurve:
    own = [
        leg
        for leg, struck in zip(model.legs, model.struck, strict=True)
        if leg.configuration == configuration and not struck
    ]
    speeds = np.array([leg.indicated_airspeed for leg in own])
    low, high = float(speeds.min()), float(speeds.max())
    at = np.linspace(low, high, _SPEEDS) if high - low > KNOT else np.array([0.5 * (low + high)])
    gradient = model.gradient(at, configuration)
    mean, bound = gradient @ model.posterior.mean, model.posterior.two_sigma(gradient)
    impact, true = air.impact_pressure(at), air.impact_pressure(at + mean)
    height, per_speed = _height(rows_of(own).air, at, mean)
    relative = 1.0 / (impact * air.calibrated_airspeed_slope(impact))
    return ErrorCurve(
        indicated_airspeed=at,
        correction=mean,
        two_sigma=bound,
        simultaneous_two_sigma=bound,
        white_two_sigma=bound,
        normalized_pressure_error=(true - impact) / true,
        normalized_two_sigma=bound * relative,
        altitude_correction=height,
        altitude_two_sigma=np.abs(per_speed) * bound,
        altitude_assumed=True,
        highest=max(leg.pressure_altitude for leg in own),
    )
