"""Slips of the pencil: legs that cannot be, and what was probably meant.

A leg is judged by what all other legs of the card predict for it. Where it cannot be, each slip that a hand makes
is tried, and the one with which the card fits best is named.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pitotbench.calibrate.accuracy import Accuracies
from pitotbench.calibrate.hand_card.card_model import SIZES, USUAL, CardModel
from pitotbench.calibrate.hand_card.track_pattern import expected_tracks, turn_between
from pitotbench.records.errors import BadInputError
from pitotbench.records.hand_card import CardLeg, ReadingSteps, Slip
from pitotbench.units import DEGREE, KNOT

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
    """A column that a slip can be in: its field, its unit [SI], its words, and the largest number that makes
    sense."""

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
        return abs(float(turn_between(leg.track, self.tracks[leg.row]))) if leg.row in self.tracks else 0.0


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
                _slip(leg, f"a track of {leg.track / DEGREE:.0f}° cannot be", _best(kept, leg, card, (_TRACK,)))
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
    """Return the legs of a point of which one cannot be, the worst first; none for a card without a slip.

    How much the wind wanders is taken from the card without its worst leg, which would make every wind plausible.
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
    """Return the leg that is wrong, and what was probably meant: within a point, that of the best correction."""
    found = [(leg, _best([other for other in kept if other is not leg], leg, card)) for leg in suspects]
    known = [(leg, meant) for leg, meant in found if meant is not None]
    return max(known, key=lambda each: each[1][0], default=(suspects[0], None))


def _best(
    others: list[CardLeg], leg: CardLeg, card: _Card, readings: "Sequence[_Reading] | None" = None
) -> tuple[float, str] | None:
    """Return the likelihood of the card with the best correction of a leg, and that in words; None for none."""
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
        likelihood = float(model.log_likelihoods([USUAL])[0]) - 0.5 * (off / _TRACK_SPREAD) ** 2
        if best is None or likelihood > best[0]:
            best = (likelihood, words)
    return best


def _corrections(
    leg: CardLeg, usual: dict[str, float], readings: Sequence[_Reading]
) -> Iterator[tuple[str, CardLeg]]:
    """Yield what may have been meant by a leg, in words and as a leg; speeds near those that are `usual` [m/s]."""
    for reading in readings:
        written = getattr(leg, reading.field) / reading.si
        for number in _meant(f"{written:.0f}", reading.most):
            if reading.field != "track" and not _NEAR[0] < number * reading.si / usual[reading.field] < _NEAR[1]:
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
    """Return the numbers from which a slip makes the written one: a digit exchanged with its neighbor, lost,
    doubled, or misread."""
    found = set()
    for i in range(len(written)):
        found.add(written[:i] + written[i + 1 :])  # one too many
        if i + 1 < len(written):
            found.add(written[:i] + written[i + 1] + written[i] + written[i + 2 :])  # exchanged
        found.update(written[:i] + digit + written[i + 1 :] for digit in "0123456789")  # misread
    if len(written) < 3:
        found.update(
            written[:i] + digit + written[i:] for i in range(len(written) + 1) for digit in "0123456789"
        )  # lost
    numbers = {float(text) for text in found if text.isdigit()} - {float(written)}
    return sorted(number for number in numbers if 0.0 < number <= most)
