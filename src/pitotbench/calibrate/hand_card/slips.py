"""Slips of the pencil: legs that cannot be, and what was probably meant.

A leg is judged by what all other legs of the card predict for it. Where it cannot be, each slip that a hand makes
is tried, and the one with which the card fits best is named.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.calibrate.accuracy import Accuracies
from pitotbench.calibrate.hand_card.card_model import USUAL, CardModel
from pitotbench.records.errors import BadInputError
from pitotbench.records.hand_card import CardLeg, ReadingSteps, Slip
from pitotbench.units import DEGREE, KNOT

_IMPOSSIBLE = 4.5  # standard deviations: one leg in 100,000 departs so far by chance
_DOUBTED = 2.5  # standard deviations: others of its point that may be the wrong one
_FITS = 2.5  # standard deviations within which the corrected leg must lie
_FULL_TURN = 360.0
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


_READINGS = (
    _Reading("track", DEGREE, "track", "°", _FULL_TURN),
    _Reading("ground_speed", KNOT, "ground speed", " kt", 700.0),
    _Reading("indicated_airspeed", KNOT, "indicated airspeed", " kt", 700.0),
)


def find_slips(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies
) -> tuple[list[CardLeg], tuple[Slip, ...]]:
    """Return the legs that can be, and the slips. Raises BadInputError where no three legs remain."""
    kept, slips = list(legs), []
    impossible = [leg for leg in kept if not 0.0 <= leg.track <= _FULL_TURN * DEGREE * (1.0 + 1e-9)]
    for leg in impossible:
        kept.remove(leg)
    for leg in impossible:
        meant = _best(kept, leg, legs, steps, stated)
        words = f"a track of {leg.track / DEGREE:.0f}° cannot be"
        slips.append(Slip(leg.row, leg.point, words, meant[1] if meant else ""))
    while len(kept) > _FEWEST:
        surprise = np.abs(CardModel(kept, steps, stated).surprise())
        worst = int(np.argmax(surprise))
        if surprise[worst] < _IMPOSSIBLE:
            break
        leg, meant = _culprit(kept, surprise, worst, legs, steps, stated)
        kept.remove(leg)
        slips.append(Slip(leg.row, leg.point, "does not fit the other legs of the card", meant))
    if len(kept) < _FEWEST:
        raise BadInputError("fewer than three legs of the card can be: correct it")
    return kept, tuple(sorted(slips, key=lambda slip: slip.row))


def _culprit(
    kept: list[CardLeg],
    surprise: np.ndarray,
    worst: int,
    legs: Sequence[CardLeg],
    steps: ReadingSteps,
    stated: Accuracies,
) -> tuple[CardLeg, str]:
    """Return the leg that is wrong, and what was probably meant: within a point, that of the best correction."""
    suspects = [
        leg for leg, size in zip(kept, surprise, strict=True) if leg.point == kept[worst].point and size > _DOUBTED
    ]
    found = []
    for leg in suspects:
        meant = _best([other for other in kept if other is not leg], leg, legs, steps, stated)
        if meant is not None:
            found.append((*meant, leg))
    if not found:
        return kept[worst], ""
    _, words, leg = max(found, key=lambda each: each[0])
    return leg, words


def _best(
    others: list[CardLeg], leg: CardLeg, legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies
) -> tuple[float, str] | None:
    """Return the likelihood of the card with the best correction of a leg, and that in words; None for none."""
    order = {each.row: place for place, each in enumerate(legs)}
    best: tuple[float, str] | None = None
    for words, corrected in _corrections(leg):
        card = sorted([*others, corrected], key=lambda each: order[each.row])
        model = CardModel(card, steps, stated)
        if abs(model.surprise()[card.index(corrected)]) > _FITS:
            continue
        likelihood = float(model.log_likelihoods([USUAL])[0])
        if best is None or likelihood > best[0]:
            best = (likelihood, words)
    return best


def _corrections(leg: CardLeg) -> Iterator[tuple[str, CardLeg]]:
    """Yield what may have been meant by a leg, in words and as a leg."""
    for reading in _READINGS:
        written = getattr(leg, reading.field) / reading.si
        for number in _meant(f"{written:.0f}", reading.most):
            words = f"{reading.name} {number:.0f}{reading.unit}, not {written:.0f}{reading.unit}"
            yield words, replace(leg, **{reading.field: number * reading.si})
    track, speed = leg.track / DEGREE, leg.ground_speed / KNOT
    yield (
        f"track {(track + 180.0) % 360.0:.0f}°, not its reciprocal {track:.0f}°",
        replace(leg, track=(track + 180.0) % 360.0 * DEGREE),
    )
    if speed <= _FULL_TURN:
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
