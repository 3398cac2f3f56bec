"""The evidence of one log for sets of effects, with their form error, the wander of null flights, and a rest."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pitotbench.reconcile.decide.evidence import Evidence
from pitotbench.reconcile.decide.form_error import form_directions
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import ScoreScale, size_label
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import whitened_columns
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.hypotheses import FITTED, cause_of, reads_gusts
from pitotbench.reconcile.signatures.signatures import columns_of
from pitotbench.units import Array

ROOMS = ("airspeed", "specific_force", "acceleration", "engine", "turning")
SMALLEST = 1e-300
SINGULAR = 1e-9  # singular value below which cells and free parameters are the same
LEAST_POWER = 1e-9  # of a direction that the free parameters take up whole
SEEN = 1e-3  # squared significance of a typical size below which free parameters take it up whole
SMOOTH_LEAST = 0.2  # σ; a smooth form error below it changes nothing


@dataclass(frozen=True, slots=True)
class Rest:
    """A smooth discrepancy of unknown form: its place, its cells with their prior deviations, and its own prior."""

    place: str
    columns: tuple[int, ...]
    deviations: Array
    log_prior: float


class LogEvidence:
    """What one log says of every set of effects.

    Free parameters are eliminated, and so are the wander that null flights have in the cells, the sizes that
    effects have there (`null_scores`), and the form error of the effects that are in the model. Directions of form
    error are added when an effect first needs them. `least_bayes_factor` is the logarithm of the Bayes factor from
    which the log shows a gap.
    """

    def __init__(
        self,
        layout: Layout,
        noise: NoiseModel,
        wander: Mapping[str, float],
        null_scores: ScoreScale | None = None,
        least_bayes_factor: float = THRESHOLDS.gap_bayes_factor,
    ) -> None:
        self.least_bayes_factor = least_bayes_factor
        self.layout, self._noise = layout, noise
        self.signatures = layout.signatures
        self.columns = columns_of(layout.signatures)
        white = whitened_columns(layout, noise)
        k = layout.free.columns.shape[2]
        rows = white.reshape(-1, white.shape[2])
        self._products = rows.T @ rows
        # Columns in blocks, as they were added: to join them would copy them all each time.
        self._blocks, self._residual = [rows[:, :-1]], rows[:, -1:]
        self._free = range(k)
        self._free_deviations = layout.free.deviations
        self._wander = wander
        self._null_scores = null_scores or ScoreScale({}, {}, {}, {})
        self.labels = tuple(size_label(s.effect, s.parameter) for s in layout.signatures)
        self.typical = np.array([abs(FITTED[s.effect].parameter(s.parameter).typical) for s in self.signatures])
        self._power = self._power_by_channel()
        self._directions: dict[int, tuple[int, ...]] = {}
        self._cells = self._places()
        self._fluctuating = self._add_fluctuations()
        self._model_error: tuple[list[int], Array] = [], np.zeros(0)
        self._update()
        if layout.in_model:  # what is in the model has its form error there
            self._model_error = self.form_error(layout.in_model)
            self._update()

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, in all their forms, that this log can show."""
        return tuple(self.columns)

    def directions(self, columns: Iterable[int]) -> tuple[tuple[int, ...], Array]:
        """Return the columns of form error of some signatures, and the signature that each belongs to, (d,)."""
        wanted = list(columns)
        new = [c for c in wanted if c not in self._directions]
        if new:
            self._add(new)
        found = [(d, c) for c in wanted for d in self._directions[c]]
        return tuple(d for d, _ in found), np.array([c for _, c in found], dtype=np.intp)

    def _add(self, new: Sequence[int]) -> None:
        parts = form_directions(self.layout, self._noise, [self.signatures[c].column for c in new])
        places = self._append(np.concatenate([part.reshape(-1, part.shape[2]) for part in parts], axis=1))
        for column, part in zip(new, parts, strict=True):
            self._directions[column] = tuple(next(places) for _ in range(part.shape[2]))
        self._update()

    def _append(self, added: Array) -> Iterator[int]:
        """Add whitened columns, (n·c, k), before the residual; return their places."""
        last = self._products.shape[0] - 1
        across = np.concatenate([block.T @ added for block in (*self._blocks, self._residual)])
        own = added.T @ added
        count = added.shape[1]
        order = [*range(last), *range(last + 1, last + 1 + count), last]
        whole = np.block([[self._products, across], [across.T, own]])
        self._products = whole[np.ix_(order, order)]
        self._blocks.append(added)
        first = last - len(self._free)
        return iter(range(first, first + count))

    def _add_fluctuations(self) -> dict[int, float]:
        """Add what every cell leaves of the signatures that gusts imitate, and return their null scores by place.

        An elevator that answers a gust moves with the pitching of the gust, as one of another effectiveness would.
        """
        surplus = [self._null_scores.fluctuation.get(label, 1.0) ** 2 - 1.0 for label in self.labels]
        imitated = [i for i, more in enumerate(surplus) if more > 0.0]
        if not imitated:
            return {}
        k = len(self._free)
        beside = [*self._free, *(k + c for cells in self._cells.values() for c in cells)]
        columns = [k + i for i in imitated]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(self._products)[beside], SMALLEST))
        normal = self._products[np.ix_(beside, beside)] * np.outer(scale, scale)
        across = self._products[np.ix_(beside, columns)] * scale[:, None]
        reproduced = scale[:, None] * np.linalg.lstsq(normal, across, rcond=SINGULAR)[0]
        rows = self._blocks[0]
        places = self._append(rows[:, columns] - rows[:, beside] @ reproduced)
        return {place: float(np.sqrt(surplus[i])) for place, i in zip(places, imitated, strict=True)}

    def _update(self) -> None:
        k = len(self._free)
        kept = range(k, self._products.shape[0] - 1)
        plain, _ = Evidence(self._products).given(self._free, self._free_deviations, kept)
        without_sizes, _ = plain.given(*self._null_sizes(plain))
        base, _ = without_sizes.given(*self._null_wander(plain))
        for label, score in self._null_scores.left_over.items():
            base = without_score(base, self.labels.index(label), score) if label in self.labels else base
        self.base, _ = base.given(*self._model_error)

    def _power_by_channel(self) -> dict[str, Array]:
        """The sum of squares of one unit of each signature in each channel, (s,)."""
        grid, slack = self.layout.grid, self.layout.residuals.slack
        columns = np.stack([s.column for s in self.signatures], axis=2)
        power = np.sum(self._noise.innovations(columns, grid, slack) ** 2, axis=0)
        return dict(zip(self.layout.residuals.names, power, strict=True))

    def form_error(self, sizes: Mapping[tuple[str, str], float]) -> tuple[list[int], Array]:
        """Return the columns of the form error of effects of these sizes, and their prior deviations, (d,).

        They are the directions of each effect, and a smooth discrepancy in each channel that it acts on.
        """
        index = {(s.effect, s.parameter): i for i, s in enumerate(self.signatures)}
        own = {index[k]: abs(float(v)) for k, v in sizes.items() if k in index}
        if not own:
            return [], np.zeros(0)
        directions, owner = self.directions(own)
        columns = list(directions)
        power = np.diag(self.base.inner)
        # What the free parameters leave of a direction is at most as long as what they leave of the effect.
        length = np.sqrt(power[owner] / np.maximum(power[list(directions)], LEAST_POWER))
        sized = np.array([own[c] for c in owner.tolist()]) * np.minimum(1.0, length)
        deviations = (THRESHOLDS.form_error * sized).tolist()
        squared = np.zeros(len(self.signatures))
        whole = np.sum(list(self._power.values()), axis=0)[list(own)]
        squared[list(own)] = np.array(list(own.values())) ** 2 * np.minimum(
            1.0, power[list(own)] / np.maximum(whole, SMALLEST)
        )
        for channel, cells in self._cells.items():
            acting = THRESHOLDS.smooth_error * float(np.sqrt(self._power[channel] @ squared))
            usable = [c for c in cells if power[c] > SMALLEST]
            if acting > SMOOTH_LEAST and usable:
                columns += usable
                deviations += [acting / float(np.sqrt(len(usable) * power[c])) for c in usable]
        return columns, np.array(deviations)

    def _places(self) -> dict[str, list[int]]:
        """The cells of each channel."""
        found: dict[str, list[int]] = {}
        for column, cell in self.layout.places:
            found.setdefault(cell.channel, []).append(column)
        return found

    def _null_wander(self, plain: Evidence) -> tuple[list[int], Array]:
        """The cells with the prior deviations that the wander of null flights asks for.

        The surplus of the squared scores of a channel over 1 is shared among its cells, which overlap.
        """
        columns, deviations = [], []
        for channel, cells in self._cells.items():
            surplus = self._wander.get(channel, 0.0)
            power = np.diag(plain.inner)[cells]
            usable = [c for c, p in zip(cells, power, strict=True) if p > SMALLEST]
            if surplus <= 0.0 or not usable:
                continue
            part = plain.inner[np.ix_(usable, usable)]
            own = np.diag(part)
            overlap = float(np.mean(np.sum(part**2 / np.outer(own, own), axis=1)))
            columns += usable
            deviations += [float(np.sqrt(surplus / overlap / p)) for p in own]
        return columns, np.array(deviations)

    def _null_sizes(self, plain: Evidence) -> tuple[list[int], Array]:
        """The columns of effects that null flights show, with the prior deviations of their sizes there.

        A size like that of null flights is no evidence; only what exceeds it is. For the fluctuating part of each
        signature this is what null flights have beyond noise. A vane reads gusts whole, and so do the residuals: on
        a flight without steady sideslips it seems to have a wrong scale. A flight of another day has other gusts,
        so that twice the size of null flights is usual.
        """
        scores = dict(self._fluctuating)
        for name in filter(reads_gusts, self.columns):
            largest = THRESHOLDS.null_size_margin * self._null_scores.effect_spread.get(cause_of(name), 0.0)
            own = [c for c in self.columns[name] if plain.inner[c, c] * self.typical[c] ** 2 > SEEN]
            scores |= dict.fromkeys(own, largest)
        powers = np.diag(plain.inner)
        usable = [c for c in scores if powers[c] > SMALLEST]
        return usable, np.array([scores[c] for c in usable]) / np.sqrt(powers[usable])

    def beyond(self, sizes: Mapping[tuple[str, str], float], power: float = 1.0) -> Evidence:
        """Return the evidence with effects of about these sizes eliminated, and their form error with them.

        It is that of the likelihood to some power.
        """
        index = {(s.effect, s.parameter): i for i, s in enumerate(self.signatures)}
        own = {index[k]: abs(v) for k, v in sizes.items() if k in index}
        directions, errors = self.form_error(sizes)
        deviations = [max(value, float(self.typical[column])) for column, value in own.items()]
        return self.base.tempered(power).given([*own, *directions], np.concatenate([deviations, errors]))[0]

    @cached_property
    def rests(self) -> list[Rest]:
        """The smooth discrepancies: of one channel, of a family of channels, and of all, in several sizes."""
        sizes = THRESHOLDS.rest_sizes
        families = {room: [c for c in self._cells if _room(c) == room] for room in ROOMS}
        alone = 0.5 / len(self._cells)
        groups: list[tuple[tuple[str, ...], float]] = [((channel,), alone) for channel in self._cells]
        shown = {name: tuple(each) for name, each in families.items() if len(each) > 1}
        groups += [(each, 0.25 / len(shown)) for each in shown.values()]
        groups += [(tuple(self._cells), 0.25)]
        found = []
        power = np.diag(self.base.inner)
        for channels, prior in groups:
            columns = [c for channel in channels for c in self._cells[channel] if power[c] > SMALLEST]
            if not columns:
                continue
            unit = 1.0 / np.sqrt(power[columns] * len(columns))
            place = (
                channels[0]
                if len(channels) == 1
                else ("all" if len(channels) == len(self._cells) else _room(channels[0]))
            )
            found += [Rest(place, tuple(columns), s * unit, float(np.log(prior / len(sizes)))) for s in sizes]
        return found


def without_score(evidence: Evidence, column: int, score: float) -> Evidence:
    """Return the evidence with the size of a column eliminated as far as flights without it seem to have it.

    `score` is the root mean square of its score there: what remains of a score is that many times smaller.
    """
    power = float(evidence.inner[column, column])
    if power <= SMALLEST:
        return evidence
    return evidence.given([column], [np.sqrt((score**2 - 1.0) / power)])[0]


def _room(channel: str) -> str:
    for room in ("airspeed", "specific_force"):
        if channel.startswith(room):
            return room
    if channel.startswith("acceleration"):
        return "acceleration"
    if channel in ("roll_acceleration", "pitch_acceleration", "yaw_acceleration"):
        return "turning"
    return "engine" if channel.split("_")[-1] in ("left", "right", "split") else channel
