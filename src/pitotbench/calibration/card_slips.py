"""Find slips of the pencil on a card: legs that cannot be, and what was probably meant."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from pitotbench.calibration.card_model import (
    SIZES,
    TYPICAL_SIZES,
    CardModel,
    Others,
    Sizes,
    by_point,
)
from pitotbench.calibration.options import Accuracies
from pitotbench.records import BadInputError
from pitotbench.records.legs import CardLeg, ReadingSteps, Slip
from pitotbench.units import DEGREE, KNOT, Array

# A leg is judged by what all other legs of the card predict for it. Where it cannot be, each slip
# that a hand makes is tried, and the one with which the card fits best is named.

_IMPOSSIBLE = 4.5  # standard deviations: one leg in 100,000 departs so far by chance
_FITS = 2.5  # standard deviations within which the corrected leg must lie
_FULL_TURN = 360.0
_OFF_TRACK = 20.0 * DEGREE  # from the track that the other points fly
_TRACK_SPREAD = 6.0 * DEGREE  # 1σ of a pilot's tracks about the one meant
_AIRSPEED_SPREAD = 3.0 * KNOT  # 1σ of a pilot's airspeeds about that of the point
_LEAST_STEP = 0.6 * KNOT  # m/s: the wind wanders by so much even where the card does not show it
_NEAR = (0.4, 2.5)  # times the usual speed of the card, within which a speed may have been meant
_CAN_BE = (0.15, 4.0)  # times the usual speed, beyond which a speed cannot be
_CLEARLY = 2.0  # log odds by which a leg out of its usual turn must be more probable
_FEWEST = 3  # legs of a card below which nothing can be judged


@dataclass(frozen=True, slots=True)
class _Reading:
    """A column that a slip can be in: its field, its unit [SI], its words, and the largest number
    that makes sense.
    """

    field: str
    si: float
    article: str
    name: str
    unit: str
    most: float


_TRACK = _Reading("track", DEGREE, "a", "track", "°", _FULL_TURN)
_SPEEDS = (
    _Reading("ground_speed", KNOT, "a", "ground speed", " kt", 700.0),
    _Reading("indicated_airspeed", KNOT, "an", "indicated airspeed", " kt", 700.0),
)
_READINGS = (_TRACK, *_SPEEDS)


def find_slips(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies
) -> tuple[list[CardLeg], tuple[Slip, ...]]:
    """Return the legs that can be, and the slips. Raises BadInputError where no three legs remain."""
    usual = _usual_speeds(legs)
    card = _Card(legs, usual, expected_tracks(legs), steps, stated)
    kept, slips = legs_that_can_be(legs), []
    if len(kept) < _FEWEST:
        raise BadInputError("fewer than three legs of the card can be: correct it")
    others = card.others(kept)
    for leg in legs:
        if words := _refusal(leg, usual):
            slips.append(_slip(leg, words, card.meant(leg, kept, others.sizes)))
    for leg in [leg for leg in kept if card.off_track(leg) > _OFF_TRACK]:
        if leg not in kept:  # it was the wrong one of two on another track
            continue
        wrong, meant = card.on_wrong_track(leg, kept, others.sizes)
        if meant is not None and len(kept) > _FEWEST:
            kept.remove(wrong)
            words = f"a {_of(wrong)} of {wrong.track / DEGREE:.0f}° is not that of the other points"
            slips.append(_slip(wrong, words, meant))
    if len(kept) < len(others.model.legs):
        others = card.others(kept)
    while len(kept) > _FEWEST and (found := card.impossible(others)) is not None:
        leg, meant = found
        kept.remove(leg)
        slips.append(_slip(leg, "does not fit the other legs of the card", meant))
        others = card.others(kept)
    return kept, tuple(sorted(slips, key=lambda slip: slip.row))


def legs_that_can_be(legs: Sequence[CardLeg]) -> list[CardLeg]:
    """Return the legs that can be, whatever the others are."""
    usual = _usual_speeds(legs)
    return [leg for leg in legs if not _refusal(leg, usual)]


def _usual_speeds(legs: Sequence[CardLeg]) -> dict[str, float]:
    return {r.field: float(np.median([getattr(leg, r.field) for leg in legs])) for r in _SPEEDS}


def _refusal(leg: CardLeg, usual: Mapping[str, float]) -> str:
    """Why a leg cannot be, whatever the others are; empty for one that can."""
    if not 0.0 <= leg.track <= _FULL_TURN * DEGREE * (1.0 + 1e-9):
        return f"a {_of(leg)} of {leg.track / DEGREE:.0f}° cannot be"
    for each in _SPEEDS:
        value = getattr(leg, each.field)
        if not _CAN_BE[0] < value / usual[each.field] < _CAN_BE[1]:
            return f"{each.article} {each.name} of {value / each.si:.0f} kt cannot be"
    return ""


def _of(leg: CardLeg) -> str:
    return "heading" if leg.by_heading else "track"


def _slip(leg: CardLeg, words: str, meant: "Meant | None") -> Slip:
    return Slip(leg.row, leg.point, words, "" if meant is None else meant.words)


@dataclass(frozen=True, slots=True)
class Meant:
    """What was probably meant by a leg, and what the card's log-likelihood gains by it."""

    words: str
    gain: float


@dataclass(frozen=True, slots=True)
class _Card:
    """What all judgments share: the legs in the order of their rows, the tracks meant, the steps
    and accuracies.
    """

    legs: Sequence[CardLeg]
    usual: Mapping[str, float]
    tracks: Mapping[int, float]
    steps: ReadingSteps
    stated: Accuracies

    def off_track(self, leg: CardLeg) -> float:
        """How far a leg is from the track meant [rad]; 0 where the other points show none."""
        meant = self.tracks.get(leg.row)
        return 0.0 if meant is None else abs(float(turn_between(leg.track, meant)))

    def may_be_meant(self, leg: CardLeg) -> bool:
        """Whether a leg is near the usual speeds and on the track meant."""
        ratios = [getattr(leg, each.field) / self.usual[each.field] for each in _SPEEDS]
        near = all(_NEAR[0] < ratio < _NEAR[1] for ratio in ratios)
        return near and not _refusal(leg, self.usual) and self.off_track(leg) <= _OFF_TRACK

    def oddness(self, leg: CardLeg) -> float:
        """How far a leg is from the track and the airspeed that were meant, as minus the logarithm
        of a probability.
        """
        own = [o.indicated_airspeed for o in self.legs if o.point == leg.point and o.row != leg.row]
        slower = leg.indicated_airspeed - float(np.median(own)) if own else 0.0
        off = self.off_track(leg) / _TRACK_SPREAD, slower / _AIRSPEED_SPREAD
        return 0.5 * float(np.sum(np.square(off)))

    def others(self, kept: Sequence[CardLeg]) -> Others:
        """What all other legs predict for each, with the sizes that the card shows.

        How much the wind wanders is taken from the card without its worst leg, which would make
        every wind plausible.
        """
        rows = {leg.row for leg in kept}
        model = CardModel([leg for leg in self.legs if leg.row in rows], self.steps, self.stated)
        worst = int(np.argmax(np.abs(model.others(TYPICAL_SIZES).surprise)))
        rest = [leg for place, leg in enumerate(model.legs) if place != worst]
        without = CardModel(rest, self.steps, self.stated)
        sizes = SIZES[int(np.argmax(without.weights()))]
        return model.others(replace(sizes, leg_step=max(sizes.leg_step, _LEAST_STEP)))

    def on_wrong_track(
        self, leg: CardLeg, kept: Sequence[CardLeg], sizes: Sizes
    ) -> tuple[CardLeg, Meant | None]:
        """Of the legs of a point on the track of a leg that should be on another, the one that is
        wrong, with what was meant: this one, unless another is clearly more probable.
        """
        best, meant = leg, self.meant(leg, kept, sizes, (_TRACK,))
        least = -np.inf if meant is None else meant.gain + _CLEARLY
        for other in kept:
            near = abs(turn_between(other.track, leg.track)) <= _OFF_TRACK
            if other is leg or other.point != leg.point or not near:
                continue
            tracks = {other.row: self.tracks[leg.row], leg.row: self.tracks[other.row]}
            exchanged = replace(self, tracks={**self.tracks, **tracks})
            found = exchanged.meant(other, kept, sizes, (_TRACK,))
            if found is not None and found.gain > least:
                best, meant, least = other, found, found.gain
        return best, meant

    def impossible(self, others: Others) -> tuple[CardLeg, Meant | None] | None:
        """A leg that cannot be, with what was probably meant; None for a card without a slip.

        It is one of the point of the worst leg: that with the best correction.
        """
        legs, surprise = others.model.legs, np.abs(others.surprise)
        worst = int(np.argmax(surprise))
        if surprise[worst] < _IMPOSSIBLE:
            return None
        suspects = [leg for leg in legs if leg.point == legs[worst].point]
        found = [(leg, self.meant(leg, legs, others.sizes)) for leg in suspects]
        known = [(leg, meant) for leg, meant in found if meant is not None]
        return max(known, key=lambda each: each[1].gain, default=(legs[worst], None))

    def meant(
        self,
        leg: CardLeg,
        kept: Sequence[CardLeg],
        sizes: Sizes,
        readings: Sequence[_Reading] = _READINGS,
    ) -> Meant | None:
        """What was meant by a leg that all others contradict; None where no slip explains it."""
        rows = {other.row for other in kept} | {leg.row}
        legs = [other for other in self.legs if other.row in rows]
        place = legs.index(leg)
        usual: dict[str, Any] = dict(self.usual)
        legs[place] = replace(leg, track=0.0, **usual)  # unheard: any that can be
        others = CardModel(legs, self.steps, self.stated, unheard=place).others(sizes)
        refused = bool(_refusal(leg, self.usual))
        written = 0.0 if refused else others.of(place, leg)[0] - self.oddness(leg)
        best: Meant | None = None
        for words, corrected in _corrections(leg, readings):
            if not self.may_be_meant(corrected):
                continue
            density, surprise = others.of(place, corrected)
            gain = density - self.oddness(corrected) - written
            if abs(surprise) <= _FITS and (best is None or gain > best.gain):
                best = Meant(words, gain)
        return best


def _corrections(leg: CardLeg, readings: Sequence[_Reading]) -> Iterator[tuple[str, CardLeg]]:
    """Yield what may have been meant by a leg, in words and as a leg."""
    direction = _of(leg)
    for reading in readings:
        written = getattr(leg, reading.field) / reading.si
        for number in _meant(f"{written:.0f}", reading.most):
            name = direction if reading is _TRACK else reading.name
            words = f"{name} {number:.0f}{reading.unit}, not {written:.0f}{reading.unit}"
            changed: dict[str, Any] = {reading.field: number * reading.si}
            yield words, replace(leg, **changed)
    track, speed = leg.track / DEGREE, leg.ground_speed / KNOT
    yield (
        f"{direction} {(track + 180.0) % 360.0:.0f}°, not its reciprocal {track:.0f}°",
        replace(leg, track=(track + 180.0) % 360.0 * DEGREE),
    )
    if track > _FULL_TURN:
        yield (
            f"{direction} {track % _FULL_TURN:.0f}°, not {track:.0f}°",
            replace(leg, track=leg.track % (_FULL_TURN * DEGREE)),
        )
    if speed <= _FULL_TURN and len(readings) > 1:
        yield (
            f"ground speed {track:.0f} kt and {direction} {speed:.0f}°, exchanged",
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


# The tracks that a card was meant to be flown on, in whatever order: those that most points fly. In
# little wind a wrong track leaves the airspeeds as they are; beside the other points it shows.

_SHOWN_BY = 3  # other points that fly a track, at least
_SHARE = 0.5  # of all points
_TURN = 8.0 * DEGREE  # of a leg that is not flown in its usual turn: decides between equals
_TIGHT = 12.0 * DEGREE  # from the middle of a track


def expected_tracks(legs: Sequence[CardLeg]) -> dict[int, float]:
    """Return the track [rad] that a leg was meant to be flown on, by row.

    A leg has one where all other legs of its point are on tracks that most points fly, and one of
    these is left for it.
    """
    points = {name: [legs[i] for i in places] for name, places in by_point(legs).items()}
    middles = _common_tracks(legs, len(points))
    found: dict[int, float] = {}
    usual = _usual_places(points.values(), middles)
    for own in points.values():
        if len(middles) < len(own):
            continue
        away = np.abs(turn_between(np.array([leg.track for leg in own])[:, None], middles))
        out_of_turn = np.arange(len(own))[:, None] != usual
        rows, columns = linear_sum_assignment(np.minimum(away, _OFF_TRACK) + _TURN * out_of_turn)
        on = away[rows, columns] <= _TIGHT
        if np.count_nonzero(~on) <= 1:
            found |= {own[i].row: float(middles[k]) for i, k in zip(rows, columns, strict=True)}
    return found


def _usual_places(points: Collection[Sequence[CardLeg]], middles: Array) -> Array:
    """The place in its point at which each track is flown most often: of two legs on one track it
    tells which is wrong.
    """
    seen = np.zeros((len(middles), max(map(len, points))))
    for own in points:
        for place, leg in enumerate(own):
            seen[:, place] += np.abs(turn_between(leg.track, middles)) <= _TIGHT
    return np.asarray(np.argmax(seen, axis=1))


def _common_tracks(legs: Sequence[CardLeg], points: int) -> Array:
    """The tracks that most points fly [rad], the most frequent first."""
    tracks = np.array([leg.track for leg in legs]) % (2.0 * np.pi)
    middles = list[float]()
    while len(tracks):
        ordered = np.sort(tracks)
        turned = np.concatenate([ordered - 2.0 * np.pi, ordered, ordered + 2.0 * np.pi])
        first = np.searchsorted(turned, ordered - _TIGHT)
        last = np.searchsorted(turned, ordered + _TIGHT, side="right")
        best = int(np.argmax(last - first))
        near = turned[first[best] : last[best]]
        if len(near) <= max(_SHOWN_BY, _SHARE * points):
            break
        middles.append(float(near.mean()) % (2.0 * np.pi))
        tracks = tracks[np.abs(turn_between(tracks, middles[-1])) > 2.0 * _TIGHT]
    return np.array(middles)


def turn_between(one: Array | float, other: Array | float) -> Array:
    """Return the angle from one track to another [rad], within half a turn."""
    return np.asarray((np.asarray(one) - np.asarray(other) + np.pi) % (2.0 * np.pi) - np.pi)
