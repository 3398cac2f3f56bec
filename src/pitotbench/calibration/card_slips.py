"""Find slips of the pencil on a card: legs that cannot be, and what was probably meant.

A leg is right or a slip, and a slip is one of those that a hand makes, or of no known kind. What is
judged is a set of slips: by the evidence of all other legs under the noise that is likeliest
without the set, by what these predict for each slip and for what was meant by it, by the airspeeds
and tracks that are usual on the card, and by how rare a slip is. Under the noise of all legs two
slips hide each other, and under that of a set one leg more is always a slip.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any

import numpy as np
from scipy.special import logsumexp

from pitotbench.calibration.card_model import CardModel, Others
from pitotbench.calibration.leg_methods import turn_between
from pitotbench.calibration.options import PRIORS, Accuracies, Priors
from pitotbench.records import BadInputError
from pitotbench.records.legs import CardLeg, ReadingSteps, Slip
from pitotbench.scatter import NORMAL
from pitotbench.units import DEGREE, KNOT, Array, Booleans

_SLIPS = 0.03  # of the legs of a card
_KINDS = 5.0  # alike likely: three columns with a wrong digit, a reciprocal or exchanged, unknown
_ELSEWHERE = -10.0  # ln of the density, per peak, of legs flown apart from the others: 1 in 500
_PILOTS = 0.1  # such legs after which a card is expected to hold twice as many: pilots differ
_OUT_OF_TURN = 1.5  # ln of how much less usual a track is where most points fly another in its turn
_UNKNOWN = 20.0 * KNOT  # 1σ of a slip of no known kind
_LOOKED_AT = 2.0  # ln of how unlikely a leg must be before it is suspected: some 2σ
_SUSPECTS = 3  # at a time
_FITS = 2.5  # standard deviations within which the corrected leg must lie
_NEAR = (0.4, 2.5)  # times the usual speed of the card, within which a speed may have been meant
_CAN_BE = (0.15, 4.0)  # times the usual speed, beyond which a speed cannot be
_FEWEST = 3  # legs of a card below which nothing can be judged
_FULL_TURN = 360.0
_TIGHT = 12  # degrees from the middle of a track
_SHOWN_BY = 3  # points: more than so many fly a common track,
_SHARE = 0.5  # and more than this share of all points
_LEAST_SPREADS = 5.0 * DEGREE, 2.0 * KNOT  # 1σ of a pilot's tracks and airspeeds about those meant


@dataclass(frozen=True, slots=True)
class _Reading:
    """A column that a slip can be in: field, unit [SI], words, and the largest sensible number."""

    field: str
    si: float
    article: str
    name: str
    unit: str
    most: float

    def put(self, leg: CardLeg, number: float) -> CardLeg:
        """Return a leg with another number, in the unit of the column."""
        changed: dict[str, Any] = {self.field: number * self.si}
        return replace(leg, **changed)


_SPEEDS = (
    _Reading("ground_speed", KNOT, "a", "ground speed", " kt", 700.0),
    _Reading("indicated_airspeed", KNOT, "an", "indicated airspeed", " kt", 700.0),
)
_READINGS = (_Reading("track", DEGREE, "a", "track", "°", _FULL_TURN), *_SPEEDS)


def find_slips(
    legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies, priors: Priors = PRIORS
) -> tuple[CardModel, tuple[Slip, ...]]:
    """Return the model of a card without its slips, and the slips.

    Raises BadInputError where no three legs can be.
    """
    card = _Card(legs)
    if len(legs) - len(card.refused) < _FEWEST:
        raise BadInputError("fewer than three legs of the card can be: correct it")
    heard = [card.usual(leg) if leg.row in card.refused else leg for leg in legs]
    model = CardModel(heard, steps, stated, frozenset(card.refused), priors)
    found = card.likeliest(model)
    slips = [
        Slip(legs[place].row, legs[place].point, each.words, each.probably)
        for place, each in found.slips.items()
    ]
    return found.model, tuple(slips)


@dataclass(frozen=True, slots=True)
class _Suspicion:
    """A slip that may have made what is written.

    ln of its probability, what is wrong, and what was probably meant. A leg that cannot be is a
    slip in any case: 0.
    """

    log_probability: float
    words: str
    probably: str


@dataclass(frozen=True, slots=True)
class _Judged:
    """A set of slips, by place, ln of its probability, and the model of the other legs.

    `suspects` are the places of the legs that are the next to be suspected.
    """

    model: CardModel
    log_posterior: float
    suspects: tuple[int, ...]
    slips: dict[int, _Suspicion]


_log_posterior = attrgetter("log_posterior")


class _Card:
    """What is usual on a card, however flown: speeds, tracks, and how closely both are kept."""

    def __init__(self, legs: Sequence[CardLeg]) -> None:
        self.legs = legs
        self._usual = {
            r.field: float(np.median([getattr(leg, r.field) for leg in legs])) for r in _SPEEDS
        }
        self.refused = {leg.row: words for leg in legs if (words := self._refusal(leg))}
        points, turns = dict[str, list[int]](), list[int]()
        for place, leg in enumerate(legs):
            own = points.setdefault(leg.point, [])
            turns.append(len(own))
            own.append(place)
        self._points = {name: np.array(own) for name, own in points.items()}
        self._turns = np.array(turns)
        self._tracks = np.array([leg.track for leg in legs])
        self._speeds = np.array([leg.indicated_airspeed for leg in legs])
        self._middles = _common_tracks(self._tracks, len(self._points))
        in_turn = [self._tracks[self._turns == turn] for turn in range(max(turns) + 1)]
        self._usual_tracks = [_common_tracks(tracks, len(tracks)) for tracks in in_turn]
        off = np.abs(turn_between(self._tracks[:, None], self._middles))
        held = np.zeros(len(legs))
        for rows in self._points.values():
            held[rows] = np.abs(self._speeds[rows] - np.median(self._speeds[rows]))
        kept = off[off < _TIGHT * DEGREE], held
        self._spreads = [
            max(least, NORMAL * float(np.median([*each, 0.0])))
            for least, each in zip(_LEAST_SPREADS, kept, strict=True)
        ]
        departures = np.stack([off.min(axis=1, initial=np.pi), held], axis=1) / self._spreads
        self._apart = np.exp(_ELSEWHERE - np.logaddexp(_ELSEWHERE, -0.5 * departures**2))
        nobody = np.zeros(len(legs), dtype=np.bool_)
        self._oddness = np.array([-self._habit(i, [leg], nobody)[0] for i, leg in enumerate(legs)])

    def usual(self, leg: CardLeg) -> CardLeg:
        """Return a leg with usual numbers in the place of one that cannot be."""
        for reading in _SPEEDS:
            leg = reading.put(leg, self._usual[reading.field] / reading.si)
        return replace(leg, track=0.0)

    def likeliest(self, model: CardModel) -> _Judged:
        """Return the likeliest set of slips that single steps reach from those of a model.

        A step strikes a leg out or takes it back. Where neither gains, two such steps are tried, as
        an exchange is.
        """
        known = dict[frozenset[int], _Judged]()

        def judged(each: _Judged, places: Iterable[int]) -> list[_Judged]:
            rows = [each.model.struck_rows ^ {self.legs[place].row} for place in places]
            for own in rows:
                if own not in known:
                    known[own] = self._judged(model.without(own))
            return [known[own] for own in rows if own != best.model.struck_rows]

        best = self._judged(model)
        while True:
            near = judged(best, [*best.suspects, *self._taken_back(best)])
            found = max([best, *near], key=_log_posterior)
            if found is best:
                far = [e for each in near for e in judged(each, each.suspects)]
                found = max([best, *far], key=_log_posterior)
            if found is best:
                return best
            best = found

    def _taken_back(self, judged: _Judged) -> list[int]:
        struck = np.flatnonzero(judged.model.struck).tolist()
        return [place for place in struck if self.legs[place].row not in self.refused]

    def _judged(self, model: CardModel) -> _Judged:
        """Weigh a set of slips by the other legs, and by what was probably meant by each slip.

        The evidence of the other legs is that under their own likeliest noise.
        """
        noise, struck = model.likeliest_noise, model.struck
        others = model.others(noise)
        total = model.log_evidence_of_heard(noise)
        found = dict[int, _Suspicion]()
        for place in range(len(struck)):
            if struck[place]:
                found[place] = self._suspicion(place, others)
                total += found[place].log_probability
            else:
                total += self._habit(place, [self.legs[place]], struck)[0] + np.log(1.0 - _SLIPS)
        unlikely = np.where(struck, 0.0, 0.5 * others.surprise**2 + self._oddness)
        suspects = [
            p for p in np.argsort(-unlikely)[:_SUSPECTS].tolist() if unlikely[p] > _LOOKED_AT
        ]
        if np.count_nonzero(~struck) <= _FEWEST:
            suspects = []
        return _Judged(model, total, tuple(suspects), found)

    def _suspicion(self, place: int, others: Others) -> _Suspicion:
        """Weigh a struck leg as a slip: what was probably meant, and how likely it was so.

        The likelihood is that of writing it as it stands.
        """
        leg, struck = self.legs[place], others.model.struck
        refusal = self.refused.get(leg.row, "")
        written = others.model.legs[place]
        words, priors, readings = [], list[float](), [written]
        for kind in filter(None, _kinds(leg)):  # no slip makes a number far above the largest
            possible = [each for each in kind if self._may_be_meant(each[1])]
            words += [each[0] for each in possible]
            readings += [each[1] for each in possible]
            priors += [_SLIPS / _KINDS / len(kind)] * len(possible)
        error, variance = others.of(place, readings)
        habit = self._habit(place, readings, struck)
        wide = variance[0] + _UNKNOWN**2
        unknown = -0.5 * (error[0] ** 2 / wide + np.log(wide)) + habit[0] + np.log(_SLIPS / _KINDS)
        meant = -0.5 * (error**2 / variance + np.log(variance)) + habit
        meant = meant[1:] + np.log(priors)
        probably = ""
        if len(meant):
            best = int(np.argmax(meant))
            if error[best + 1] ** 2 <= _FITS**2 * variance[best + 1]:
                probably = words[best]
        strange = -habit[0] > 0.5 * error[0] ** 2 / variance[0]
        off = f"a {_of(leg)} of {leg.track / DEGREE:.0f}° is not that of the other points"
        fits_not = "does not fit the other legs of the card"
        return _Suspicion(
            0.0 if refusal else float(logsumexp([*meant, unknown])),
            refusal or (off if strange and probably.startswith(_of(leg)) else fits_not),
            probably,
        )

    def _habit(self, place: int, readings: Sequence[CardLeg], struck: Booleans) -> Array:
        """Return ln of how usual readings (m,) in the place of a leg are, (m,).

        They are judged by their airspeed and by their track, which no other leg of the point has.
        The more legs of the card are flown apart from the usual, the less does one of them
        surprise.
        """
        own = self._points[self.legs[place].point]
        others = own[(own != place) & ~struck[own]]
        off, late = np.zeros((2, len(readings))), np.zeros(len(readings), dtype=np.bool_)
        tracks = np.array([each.track for each in readings])
        taken = np.abs(turn_between(self._middles[:, None], self._tracks[others])) < _TIGHT * DEGREE
        free = self._middles[~taken.any(axis=1)]
        if len(free) and taken.any(axis=0).all():
            off[0] = np.min(np.abs(turn_between(tracks[:, None], free)), axis=1)
        if len(others):
            speeds = np.array([each.indicated_airspeed for each in readings])
            off[1] = speeds - np.median(self._speeds[others])
        for usual in self._usual_tracks[self._turns[place]][:1]:
            late = np.abs(turn_between(tracks, usual)) > _TIGHT * DEGREE
        departures = off / np.array(self._spreads)[:, None]
        heard = ~struck & (np.arange(len(struck)) != place)
        apart = self._apart[heard].sum(axis=0)[:, None]
        elsewhere = _ELSEWHERE + np.log1p(apart / _PILOTS)
        usual = np.logaddexp(elsewhere, -0.5 * departures**2).sum(axis=0)
        return np.asarray(usual - _OUT_OF_TURN * late)

    def _refusal(self, leg: CardLeg) -> str:
        """Why a leg cannot be, whatever the others are; empty for one that can."""
        if not 0.0 <= leg.track <= _FULL_TURN * DEGREE * (1.0 + 1e-9):
            return f"a {_of(leg)} of {leg.track / DEGREE:.0f}° cannot be"
        for each in _SPEEDS:
            value = getattr(leg, each.field)
            if not _CAN_BE[0] < value / self._usual[each.field] < _CAN_BE[1]:
                return f"{each.article} {each.name} of {value / each.si:.0f} kt cannot be"
        return ""

    def _may_be_meant(self, leg: CardLeg) -> bool:
        """Whether a leg is near the usual speeds."""
        ratios = [getattr(leg, field) / usual for field, usual in self._usual.items()]
        return all(_NEAR[0] < ratio < _NEAR[1] for ratio in ratios) and not self._refusal(leg)


def _of(leg: CardLeg) -> str:
    return "heading" if leg.by_heading else "track"


def _kinds(leg: CardLeg) -> Iterator[list[tuple[str, CardLeg]]]:
    """Yield what may have been meant by a leg, in words and as a leg, by the kind of the slip."""
    direction = _of(leg)
    for reading in _READINGS:
        written = getattr(leg, reading.field) / reading.si
        name = direction if reading is _READINGS[0] else reading.name
        yield [
            (
                f"{name} {number:.0f}{reading.unit}, not {written:.0f}{reading.unit}",
                reading.put(leg, number),
            )
            for number in _meant(f"{written:.0f}", reading.most)
        ]
    track, speed = leg.track / DEGREE, leg.ground_speed / KNOT
    back, once = (track + 180.0) % _FULL_TURN, track % _FULL_TURN
    turned = [
        (f"{direction} {back:.0f}°, not its reciprocal {track:.0f}°", _READINGS[0].put(leg, back)),
        (f"{direction} {once:.0f}°, not {track:.0f}°", _READINGS[0].put(leg, once)),
        (
            f"ground speed {track:.0f} kt and {direction} {speed:.0f}°, exchanged",
            replace(leg, track=speed * DEGREE, ground_speed=track * KNOT),
        ),
    ]
    yield [(words, meant) for words, meant in turned if meant.track != leg.track]


def _meant(written: str, most: float) -> list[float]:
    """Return the numbers from which a slip makes the written one.

    A digit is exchanged with its neighbor, lost, doubled, or misread.
    """
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


def _common_tracks(tracks: Array, points: int) -> Array:
    """Return the tracks [rad] that most points fly, in whatever order, the most frequent first."""
    middles = list[float]()
    while True:
        counts = np.bincount(np.rint(tracks / DEGREE).astype(int) % 360, minlength=360)
        best = DEGREE * int(
            np.argmax(sum(np.roll(counts, turn) for turn in range(-_TIGHT, _TIGHT + 1)))
        )
        off = turn_between(tracks, best)
        near = np.abs(off) <= _TIGHT * DEGREE
        if np.count_nonzero(near) <= max(_SHOWN_BY, _SHARE * points):
            return np.array(middles)
        middles.append(best + float(off[near].mean()))
        tracks = tracks[np.abs(turn_between(tracks, middles[-1])) > 2.0 * _TIGHT * DEGREE]
