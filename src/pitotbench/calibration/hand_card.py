"""Reduce a card written by hand: corrections of its points, one curve a configuration, slips named;
fly-bys.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.calibration.hand_card_model import (
    SIZES,
    TYPICAL_SIZES,
    CardModel,
    LegArrays,
    Sizes,
    expected_tracks,
    leg_arrays,
    turn_between,
)
from pitotbench.calibration.leg_points import circle_fit, fixed_speed
from pitotbench.calibration.options import USUAL, Accuracies
from pitotbench.estimation.restricted_likelihood import half_width
from pitotbench.logbook.plausible_air import LIMITS
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.legs import (
    CardLeg,
    CardPoint,
    FlyBy,
    FlyByPoint,
    HandCard,
    ReadingSteps,
    Slip,
)
from pitotbench.units import DEGREE, KNOT, Array

# Slips of the pencil: legs that cannot be, and what was probably meant. A leg is judged by what all
# other legs of the card predict for it. Where it cannot be, each slip that a hand makes is tried,
# and the one with which the card fits best is named.

_IMPOSSIBLE = 4.5  # standard deviations: one leg in 100,000 departs so far by chance
_DOUBTED = 2.5  # standard deviations: others of its point that may be the wrong one
_FITS = 2.5  # standard deviations within which the corrected leg must lie
_FULL_TURN = 360.0
_OFF_TRACK = 20.0 * DEGREE  # from the track that the other points fly on the same leg
_TRACK_SPREAD = 6.0 * DEGREE  # 1σ of a pilot's tracks about the one meant
_LEAST_STEP = 0.6 * KNOT  # m/s: the wind wanders by so much even where the card does not show it
_NEAR = (0.4, 2.5)  # times the usual speed of the card, within which a speed may have been meant
_FEWEST = 3  # legs of a card below which nothing can be judged


@dataclass(frozen=True, slots=True)
class _Reading:
    """A column that a slip can be in: its field, its unit [SI], its words, and the largest number
    that makes sense."""

    field: str
    si: float
    name: str
    unit: str
    most: float


_TRACK = _Reading("track", DEGREE, "track", "°", _FULL_TURN)
_READINGS = (
    _TRACK,
    _Reading("ground_speed", KNOT, "ground speed", " kt", 700.0),
    _Reading("indicated_airspeed", KNOT, "indicated airspeed", " kt", 700.0),
)


@dataclass(frozen=True, slots=True)
class _Card:
    """What all judgments share: the order of the rows, the tracks meant, the steps and accuracies."""

    order: dict[int, int]
    tracks: dict[int, float]
    steps: ReadingSteps
    stated: Accuracies

    def model(self, legs: Sequence[CardLeg]) -> CardModel:
        return CardModel(sorted(legs, key=lambda leg: self.order[leg.row]), self.steps, self.stated)

    def off_track(self, leg: CardLeg) -> float:
        """Return how far a leg is from the track of the other points [rad]; 0 where they show none."""
        return (
            abs(float(turn_between(leg.track, self.tracks[leg.row])))
            if leg.row in self.tracks
            else 0.0
        )


def find_slips(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies
) -> tuple[list[CardLeg], tuple[Slip, ...]]:
    """Return the legs that can be, and the slips. Raises BadInputError where no three legs remain."""
    order = {leg.row: place for place, leg in enumerate(legs)}
    card = _Card(order, expected_tracks(legs), steps, stated)
    kept = [leg for leg in legs if 0.0 <= leg.track <= _FULL_TURN * DEGREE * (1.0 + 1e-9)]
    slips = []
    for leg in legs:
        if leg not in kept:
            slips.append(
                _slip(
                    leg,
                    f"a track of {leg.track / DEGREE:.0f}° cannot be",
                    _best(kept, leg, card, (_TRACK,)),
                )
            )
    for leg in [leg for leg in kept if card.off_track(leg) > _OFF_TRACK]:
        meant = _best([other for other in kept if other is not leg], leg, card, (_TRACK,))
        if meant is not None and len(kept) > _FEWEST:
            kept.remove(leg)
            words = f"a track of {leg.track / DEGREE:.0f}° is not that of the other points"
            slips.append(_slip(leg, words, meant))
    while len(kept) > _FEWEST:
        suspects = _suspects(kept, card)
        if not suspects:
            break
        leg, meant = _culprit(kept, suspects, card)
        kept.remove(leg)
        slips.append(_slip(leg, "does not fit the other legs of the card", meant))
    if len(kept) < _FEWEST:
        raise BadInputError("fewer than three legs of the card can be: correct it")
    return kept, tuple(sorted(slips, key=lambda slip: slip.row))


def _slip(leg: CardLeg, words: str, meant: tuple[float, str] | None) -> Slip:
    return Slip(leg.row, leg.point, words, "" if meant is None else meant[1])


def _suspects(kept: list[CardLeg], card: _Card) -> list[CardLeg]:
    """Return the legs of a point of which one cannot be, the worst first; none for a card without a
    slip.

    How much the wind wanders is taken from the card without its worst leg, which would make every
    wind plausible.
    """
    model = card.model(kept)
    worst = int(np.argmax(np.abs(model.surprise())))
    without = card.model([leg for leg in kept if leg is not model.legs[worst]])
    sizes = SIZES[int(np.argmax(without.weights()))]
    surprise = np.abs(model.surprise(replace(sizes, leg_step=max(sizes.leg_step, _LEAST_STEP))))
    worst = int(np.argmax(surprise))
    if surprise[worst] < _IMPOSSIBLE:
        return []
    ranked = sorted(zip(surprise, model.legs, strict=True), key=lambda each: -each[0])
    return [leg for size, leg in ranked if leg.point == model.legs[worst].point and size > _DOUBTED]


def _culprit(
    kept: list[CardLeg], suspects: Sequence[CardLeg], card: _Card
) -> tuple[CardLeg, tuple[float, str] | None]:
    """Return the leg that is wrong, and what was probably meant: within a point, that of the best
    correction.
    """
    found = [
        (leg, _best([other for other in kept if other is not leg], leg, card)) for leg in suspects
    ]
    known = [(leg, meant) for leg, meant in found if meant is not None]
    return max(known, key=lambda each: each[1][0], default=(suspects[0], None))


def _best(
    others: list[CardLeg], leg: CardLeg, card: _Card, readings: "Sequence[_Reading] | None" = None
) -> tuple[float, str] | None:
    """Return the likelihood of the card with the best correction of a leg, and that in words; None
    for none.
    """
    best: tuple[float, str] | None = None
    usual = {
        name: float(np.median([getattr(o, name) for o in others]))
        for name in ("ground_speed", "indicated_airspeed")
    }
    for words, corrected in _corrections(leg, usual, readings or _READINGS):
        off = card.off_track(corrected)
        if off > _OFF_TRACK:
            continue
        model = card.model([*others, corrected])
        if abs(model.surprise()[model.legs.index(corrected)]) > _FITS:
            continue
        likelihood = (
            float(model.log_likelihoods([TYPICAL_SIZES])[0]) - 0.5 * (off / _TRACK_SPREAD) ** 2
        )
        if best is None or likelihood > best[0]:
            best = (likelihood, words)
    return best


def _corrections(
    leg: CardLeg, usual: dict[str, float], readings: Sequence[_Reading]
) -> Iterator[tuple[str, CardLeg]]:
    """Yield what may have been meant by a leg, in words and as a leg; speeds near those that are
    `usual` [m/s].
    """
    for reading in readings:
        written = getattr(leg, reading.field) / reading.si
        for number in _meant(f"{written:.0f}", reading.most):
            if (
                reading.field != "track"
                and not _NEAR[0] < number * reading.si / usual[reading.field] < _NEAR[1]
            ):
                continue
            words = f"{reading.name} {number:.0f}{reading.unit}, not {written:.0f}{reading.unit}"
            changed: dict[str, Any] = {reading.field: number * reading.si}
            yield words, replace(leg, **changed)
    track, speed = leg.track / DEGREE, leg.ground_speed / KNOT
    yield (
        f"track {(track + 180.0) % 360.0:.0f}°, not its reciprocal {track:.0f}°",
        replace(leg, track=(track + 180.0) % 360.0 * DEGREE),
    )
    if track > _FULL_TURN:
        yield (
            f"track {track % _FULL_TURN:.0f}°, not {track:.0f}°",
            replace(leg, track=leg.track % (_FULL_TURN * DEGREE)),
        )
    if speed <= _FULL_TURN and len(readings) > 1:
        yield (
            f"ground speed {track:.0f} kt and track {speed:.0f}°, exchanged",
            replace(leg, track=speed * DEGREE, ground_speed=track * KNOT),
        )


def _meant(written: str, most: float) -> list[float]:
    """Return the numbers from which a slip makes the written one: a digit exchanged with its
    neighbor, lost, doubled, or misread."""
    found = set()
    for i in range(len(written)):
        found.add(written[:i] + written[i + 1 :])  # one too many
        if i + 1 < len(written):
            found.add(written[:i] + written[i + 1] + written[i] + written[i + 2 :])  # exchanged
        found.update(written[:i] + digit + written[i + 1 :] for digit in "0123456789")  # misread
    if len(written) < 3:
        found.update(
            written[:i] + digit + written[i:]
            for i in range(len(written) + 1)
            for digit in "0123456789"
        )  # lost
    numbers = {float(text) for text in found if text.isdigit()} - {float(written)}
    return sorted(number for number in numbers if 0.0 < number <= most)


_SPEEDS = 13  # airspeeds of a curve
_LIGHT = 1e-2  # of the weights: sizes that are as unlikely are left out
_ROUNDS = 4  # the unequal airspeeds are referred to their mean along flight paths, which depend on the wind
_STEP = 1e-3  # m/s
_TOO_WIDE = 20.0 * KNOT  # m/s, 2σ above which a point is none


def reduce_card(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies = USUAL
) -> HandCard:
    """Return the points, curves and slips of a card. Legs are in the order in which they were
    flown.

    A point's true airspeed and wind are those of the published methods (three legs: Gray 1998;
    four: the mean of the four answers of three legs; more: a circle). Its bound propagates the
    steps of the readings, and wind that changes from leg to leg by as much as the card shows,
    through the weights of that method. Raises BadInputError for fewer than three legs that can be.
    """
    if len(legs) < 3:
        raise BadInputError("a card needs at least three legs")
    kept, slips = find_slips(legs, steps, stated)
    model = CardModel(kept, steps, stated)
    weights = model.weights()
    named = {slip.row: slip for slip in slips}
    points = tuple(
        _point(name, legs, model, weights, stated, set(named))
        for name in dict.fromkeys(leg.point for leg in legs)
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
    name: str,
    legs: Sequence[CardLeg],
    model: CardModel,
    weights: Array,
    stated: Accuracies,
    wrong: set[int],
) -> CardPoint:
    own = [leg for leg in legs if leg.point == name]
    rows = [place for place, leg in enumerate(model.legs) if leg.point == name]
    used = [model.legs[place] for place in rows]
    indicated = float(np.mean([leg.indicated_airspeed for leg in used or own]))
    lost = [leg.row for leg in own if leg.row in wrong]
    remark = (
        f"without row{'s' if len(lost) > 1 else ''} {', '.join(map(str, lost))}" if lost else None
    )
    empty = CardPoint(
        point=name, configuration=own[0].configuration, legs=len(used), indicated_airspeed=indicated
    )
    if len(used) < 3:
        left = (
            f"{len(used)} leg{'' if len(used) == 1 else 's'} left: no point, but used for the curve"
        )
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
        return _with_remark(
            empty, "the tracks are too near each other: fly them at least 60° apart"
        )
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
    """Return the ground velocities (n, 2) [m/s] as they would be at one indicated airspeed and in
    one air.
    """
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
    """Return [V, W_N, W_E] [m/s] of legs, the spread of four, and the ground velocities at one
    airspeed (n, 2).
    """
    answer, spread, velocity = np.zeros(3), None, arrays.velocity
    for _ in range(_ROUNDS):
        velocity = _referred(arrays, indicated, answer[1:])
        answer, spread = _solved(velocity)
    return answer, spread, velocity


def _solved(velocity: Array) -> tuple[Array, float | None]:
    """Return [V, W_N, W_E] [m/s] of ground velocities at one airspeed, (n, 2), by the published
    method.
    """
    if len(velocity) > 4:
        return circle_fit(velocity), None
    found = fixed_speed(
        np.linalg.norm(velocity, axis=1), np.arctan2(velocity[:, 1], velocity[:, 0])
    )
    toward = found.wind_from + np.pi
    wind = found.wind_speed * np.cos(toward), found.wind_speed * np.sin(toward)
    return np.array([found.true_airspeed, *wind]), found.spread


def _gain(velocity: Array, wind: Array) -> Array:
    """Return the change of the true airspeed per change of each leg along its flight path, (n,)
    [-].

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
        correction += (true - float(here.true_airspeed(correction)[0])) / float(
            here.slope(correction)[0]
        )
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


# Tower fly-bys: the altimeter beside the tower's barometer.

_NODES = 101  # of the reading with the coarsest step
_HIGHEST_GRID = 1000.0  # m: a grid height is that above the tower, not above the sea


def reduce_fly_bys(
    passes: Sequence[FlyBy], steps: Mapping[str, float], stated: Accuracies = USUAL
) -> tuple[FlyByPoint, ...]:
    """Return the position error of each pass of a tower, with 2σ.

    The static pressure at the airplane is the tower's, reduced by the column of air between
    (hydrostatics with the standard lapse rate from the tower's temperature; Gracey, NASA RP-1046,
    1980, ch. IX). The bound holds the steps of the readings, which are uniform, and the stated
    accuracies: `static_pressure_pa` of altimeter against barometer, `temperature_k` of the tower.
    Raises BadInputError for a pass that cannot be.
    """
    if not passes:
        raise BadInputError("the card holds no pass")
    return tuple(_fly_by(each, steps, stated) for each in passes)


def _fly_by(each: FlyBy, steps: Mapping[str, float], stated: Accuracies) -> FlyByPoint:
    if not abs(each.grid_height) < _HIGHEST_GRID or not each.indicated_airspeed > 0.0:
        raise BadInputError(
            f"row {each.row}: a pass needs an airspeed above zero and a grid height above the "
            "tower's barometer, "
            f"at most {_HIGHEST_GRID:.0f} m"
        )
    if not (each.tower_pressure > 0.0 and each.tower_temperature > 0.0):
        raise BadInputError(
            f"row {each.row}: tower pressure and temperature must be above zero: check their units"
        )
    column = 1.0 - air.LAPSE_RATE * each.grid_height / each.tower_temperature
    true = each.tower_pressure * column ** (air.GRAVITY / (air.GAS_CONSTANT * air.LAPSE_RATE))
    by_height = true * air.GRAVITY / (air.GAS_CONSTANT * each.tower_temperature)  # Pa per m
    indicated = float(air.standard_pressure(each.pressure_altitude))
    low, high = air.standard_pressure(each.pressure_altitude + np.array([0.5, -0.5]))
    by_altimeter = float(high - low)  # Pa per m
    by_temperature = by_height * each.grid_height / each.tower_temperature  # Pa per K
    half = 0.5 * np.array(
        [
            steps["pressure_altitude"] * by_altimeter,
            steps["grid_height"] * by_height,
            steps["tower_pressure"] * true / each.tower_pressure,
            steps["tower_temperature"] * by_temperature,
        ]
    )
    normal = 0.5 * np.hypot(stated.static_pressure_pa, stated.temperature_k * by_temperature)
    bound = _of_readings(np.abs(half), float(normal))
    error = indicated - true  # the static source reads so much too high
    impact = float(air.impact_pressure(each.indicated_airspeed))
    if abs(error) - bound > LIMITS.curve_refused * impact:
        raise BadInputError(
            f"row {each.row}: the static pressure is off by {error / impact:+.0%} of the impact "
            "pressure, and no "
            "airplane's is so far. The altimeter must stand on 1013.25 hPa (29.92 inHg), and "
            "tower_pressure is "
            "what the barometer reads at its height, not the altimeter setting"
        )
    right = max(
        impact + error, 0.5 * impact
    )  # readings too coarse for the airspeed have a bound beyond that
    slope = float(air.calibrated_airspeed_slope(right))
    by_airspeed = 1.0 / float(air.calibrated_airspeed_slope(impact))  # Pa per m/s
    read = steps["indicated_airspeed"] / np.sqrt(3.0)  # 2σ of a reading
    return FlyByPoint(
        point=each.point,
        configuration=each.configuration,
        indicated_airspeed=each.indicated_airspeed,
        altitude_correction=float(air.pressure_altitude(true) - each.pressure_altitude),
        altitude_two_sigma=bound / by_altimeter,
        correction=float(air.calibrated_airspeed(right) - each.indicated_airspeed),
        two_sigma=float(np.hypot(slope * bound, (slope * by_airspeed - 1.0) * read)),
        normalized_pressure_error=error / right,
        normalized_two_sigma=float(np.hypot(impact * bound, error * by_airspeed * read) / right**2),
    )


def _of_readings(half: Array, normal: float) -> float:
    """Return the 2σ of a sum of uniform errors within ±`half` (n,), and a normal one of a standard
    deviation.

    The widest one is taken as it is, the others as normal: a single reading errs by no more than
    half its step.
    """
    widest = float(np.max(half))
    others = float(np.sqrt(max(np.sum(half**2) - widest**2, 0.0) / 3.0 + normal**2))
    means = widest * np.linspace(-1.0, 1.0, 2 * _NODES + 1)[1::2]
    deviations = np.full((_NODES, 1), max(others, widest / _NODES, 1e-9))
    return float(half_width(np.full(_NODES, 1.0 / _NODES), means[:, None], deviations)[0])


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
        altitude_assumed=True,
        highest=max(leg.pressure_altitude for leg in own),
    )
