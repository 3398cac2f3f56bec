"""What a flight without an effect looks like: the noise, and how far chance and small faults of the method carry.

Textbook thresholds would name something on nearly every flight: many hypotheses are tried, and no noise model is
perfect. So the scores of flights of the very same card, data system and turbulence set the thresholds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import ndtri

from pitotbench.reconcile.decide.locate import Cell
from pitotbench.reconcile.decide.scoring import score_candidates
from pitotbench.reconcile.null_flights.gust_levels import usual_gusts
from pitotbench.reconcile.null_flights.periodic import swings, usual_swings
from pitotbench.reconcile.null_flights.wander import powers, usual_powers
from pitotbench.reconcile.residuals.layout import (
    FITTED,
    Layout,
    columns_of,
    noise_residuals,
    scaled_to,
    searched,
    weigh_layout,
)
from pitotbench.reconcile.residuals.whitening import NoiseModel, learned
from pitotbench.reconcile.signatures.refine import placed_in_time
from pitotbench.units import Array

FEWEST = 4  # flights for their spread to mean anything
FALSE_ALARM = 0.01  # share of null flights above the threshold
FLOOR = 3.5  # deviations, below which no threshold for the table falls
USUAL = 0.5  # deviation of the largest score from flight to flight: 48 null flights of four cards, 0.4 to 0.7
TRUSTED = 8  # flights that this is worth
IGNORANT = 6.0  # the threshold where no null flight could be flown
EULER = 0.5772156649

CHANCE = 0.8  # mean size of a standard normal number

Table = tuple[dict[str, float], dict[str, float]]  # scores of the effects, signed scores of the cells


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What null flights tell: the noise; what the search for a shape (the time of an event) adds to an effect's
    score, and the spread of the rest, never below one; per cell the mean score and its spread; the thresholds for
    the largest score of the table and of the cells, in those units."""

    noise: NoiseModel
    search: Mapping[str, float]
    spread: Mapping[str, float]
    cell_mean: Mapping[str, float]
    cell_spread: Mapping[str, float]
    threshold: float
    cell_threshold: float
    flights: int
    gusts: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # mean and deviation, see gusts.py
    powers: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # mean and deviation, see power.py
    swings: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # mean and deviation, see swings.py

    def told(self, name: str, value: float) -> float:
        """A score of an effect in the units of the threshold."""
        return _told(name, value, self.search, self.spread)

    def told_at(self, cell: Cell, value: float) -> float:
        """A signed score of a cell beyond its usual one, in the units of the threshold of cells."""
        return _told_at(label(cell), value, self.cell_mean, self.cell_spread)

    def needed(self, name: str) -> float:
        """The score at which an effect reaches the threshold."""
        return self.search.get(name, 0.0) + self.threshold * self.spread.get(name, 1.0)


def ignorance(noise: NoiseModel) -> Knowledge:
    """What is known where no null flight could be flown: thresholds from theory, with a margin of a half for a
    noise model that the log itself had to give."""
    return Knowledge(noise, {}, {}, {}, {}, IGNORANT, IGNORANT, 0)


def learn(studies: Sequence[Layout]) -> Knowledge:
    """Learn from null flights. Raises ValueError for fewer than `FEWEST`.

    Each flight is scored by the noise, means and spreads of the others, so that it is as fresh as the log will be.
    """
    if len(studies) < FEWEST:
        raise ValueError(f"{len(studies)} null flights are too few to set a threshold; fly at least {FEWEST}")
    names = studies[0].residuals.names
    each = [(noise_residuals(s), s.grid, s.residuals.slack) for s in studies]
    fresh = [learned(names, [*each[:i], *each[i + 1 :]]) for i in range(len(studies))]
    tables = [_table(s, noise) for s, noise in zip(studies, fresh, strict=True)]
    rest = [_usual([*tables[:i], *tables[i + 1 :]]) for i in range(len(tables))]
    largest = [
        max(_told(k, v, search, spread) for k, v in t[0].items())
        for t, (search, spread, _, _) in zip(tables, rest, strict=True)
    ]
    largest_cell = [
        max(abs(_told_at(k, v, mean, deviation)) for k, v in t[1].items())
        for t, (_, _, mean, deviation) in zip(tables, rest, strict=True)
    ]
    search, spread, mean, deviation = _usual(tables)
    gusts = usual_gusts(studies)
    wandering = [powers(s, noise) for s, noise in zip(studies, fresh, strict=True)]
    return Knowledge(
        learned(names, each),
        search,
        spread,
        mean,
        deviation,
        _quantile(largest),
        _quantile(largest_cell, _floor(len(mean), len(studies))),
        len(studies),
        gusts,
        usual_powers(wandering, min(len(s.grid) for s in studies), gusts),
        usual_swings([swings(s, noise) for s, noise in zip(studies, fresh, strict=True)]),
    )


def _usual(
    tables: Sequence[Table],
) -> tuple[dict[str, float], dict[str, float], dict[str, float], dict[str, float]]:
    """What a search adds to the score of each effect and the root mean square of the rest, never below one; mean
    and deviation of each cell's."""
    keys, places = ({k for t in tables for k in t[part]} for part in (0, 1))
    effects = {k: np.array([t[0].get(k, 0.0) for t in tables]) for k in keys}
    cells = {k: [t[1].get(k, 0.0) for t in tables] for k in places}
    search = {k: max(0.0, float(np.mean(v)) - CHANCE) if _is_searched(k) else 0.0 for k, v in effects.items()}
    return (
        search,
        {k: max(1.0, float(np.sqrt(np.mean((v - search[k]) ** 2)))) for k, v in effects.items()},
        {k: float(np.mean(v)) for k, v in cells.items()},
        {k: max(1.0, float(np.std(v))) for k, v in cells.items()},
    )


def _table(layout: Layout, noise: NoiseModel) -> Table:
    """Scores of all effects and signed scores of all cells of one null flight, events where they fit best."""
    noise = scaled_to(noise, layout)
    layout = placed_in_time(layout, noise)
    evidence = weigh_layout(layout, noise)
    effects = {
        name: score_candidates(evidence.fit(columns)) for name, columns in columns_of(layout.signatures).items()
    }
    places = layout.places
    values = evidence.scores([i for i, _ in places])
    return effects, {label(cell): float(v) for (_, cell), v in zip(places, values, strict=True)}


def label(cell: Cell) -> str:
    """A cell as text."""
    return f"{cell.channel}|{cell.phase}|{cell.variable}"


def _is_searched(name: str) -> bool:
    return bool(searched(FITTED[name]))


def _told_at(key: str, value: float, mean: Mapping[str, float], spread: Mapping[str, float]) -> float:
    return (value - mean.get(key, 0.0)) / spread.get(key, 1.0)


def _told(name: str, value: float, search: Mapping[str, float], spread: Mapping[str, float]) -> float:
    return max(0.0, value - search.get(name, 0.0)) / spread.get(name, 1.0)


def _floor(tries: int, flights: int) -> float:
    """What the largest of independent scores exceeds on that share of null flights (Šidák 1967), with the error of
    means taken over so few flights."""
    return float(ndtri(1.0 - 0.5 * FALSE_ALARM / tries) * np.sqrt(1.0 + 1.0 / flights))


def _quantile(largest: Sequence[float] | Array, least: float = FLOOR) -> float:
    """The value that the largest score exceeds on a share of null flights (Gumbel 1958, by moments, the deviation
    shrunk toward the usual one)."""
    own, n = float(np.var(largest, ddof=1)), len(largest)
    shrunk = ((n - 1) * own + TRUSTED * USUAL**2) / (n - 1 + TRUSTED)
    scale = float(np.sqrt(6.0 * shrunk)) / np.pi
    mode = float(np.mean(largest)) - EULER * scale
    return max(least, float(mode - scale * np.log(-np.log1p(-FALSE_ALARM))))
