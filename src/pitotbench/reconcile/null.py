"""What a flight without an effect looks like: the noise, and how far chance and small faults of the method carry.

Textbook thresholds would name something on nearly every flight: many hypotheses are tried, and no noise model is
perfect. So the scores of flights of the very same card, data system and turbulence set the thresholds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.special import ndtri

from pitotbench.reconcile.gusts import usual_gusts
from pitotbench.reconcile.locate import Cell
from pitotbench.reconcile.power import powers, usual_powers
from pitotbench.reconcile.refine import placed_in_time
from pitotbench.reconcile.scoring import score
from pitotbench.reconcile.study import Study, columns_of, noise_residuals, scaled_to, weigh
from pitotbench.reconcile.whitening import NoiseModel, autocovariance, noise_model
from pitotbench.units import Array

FEWEST = 4  # flights for their spread to mean anything
FALSE_ALARM = 0.01  # share of null flights above the threshold
FLOOR = 4.0  # σ, below which no threshold for the table falls: some 60 hypotheses, each tried twice
EULER = 0.5772156649

Table = tuple[dict[str, float], dict[str, float]]  # scores of the effects, signed scores of the cells


@dataclass(frozen=True, slots=True)
class Knowledge:
    """What null flights tell: the noise; per signature and per cell the mean score and its spread (never below
    one); the thresholds for the largest score of the table and of the cells, in those units."""

    noise: NoiseModel
    spread: Mapping[str, float]
    cell_mean: Mapping[str, float]
    cell_spread: Mapping[str, float]
    threshold: float
    cell_threshold: float
    flights: int
    gusts: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # mean and deviation, see gusts.py
    powers: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # mean and deviation, see power.py


def ignorance(noise: NoiseModel) -> Knowledge:
    """What is known where no null flight could be flown: thresholds from theory, with a margin of a half for a
    noise model that the log itself had to give."""
    return Knowledge(noise, {}, {}, {}, 1.5 * FLOOR, 1.5 * FLOOR, 0)


def learn(studies: Sequence[Study]) -> Knowledge:
    """Learn from null flights. Raises ValueError for fewer than `FEWEST`.

    Each flight is scored by the noise, means and spreads of the others, so that it is as fresh as the log will be.
    """
    if len(studies) < FEWEST:
        raise ValueError(f"{len(studies)} null flights are too few to set a threshold; fly at least {FEWEST}")
    names = studies[0].residuals.names
    each = np.stack([autocovariance(noise_residuals(s), s.grid) for s in studies])
    fresh = [noise_model(names, np.delete(each, i, axis=0).mean(axis=0)) for i in range(len(studies))]
    tables = [_table(s, noise) for s, noise in zip(studies, fresh, strict=True)]
    rest = [_usual([*tables[:i], *tables[i + 1 :]]) for i in range(len(tables))]
    largest = [
        max(v / spread.get(k, 1.0) for k, v in t[0].items()) for t, (spread, _, _) in zip(tables, rest, strict=True)
    ]
    largest_cell = [
        max(abs(v - mean.get(k, 0.0)) / deviation.get(k, 1.0) for k, v in t[1].items())
        for t, (_, mean, deviation) in zip(tables, rest, strict=True)
    ]
    spread, mean, deviation = _usual(tables)
    gusts = usual_gusts(studies)
    wandering = [powers(s, noise) for s, noise in zip(studies, fresh, strict=True)]
    return Knowledge(
        noise_model(names, each.mean(axis=0)),
        spread,
        mean,
        deviation,
        _quantile(largest),
        _quantile(largest_cell, _floor(len(mean), len(studies))),
        len(studies),
        gusts,
        usual_powers(wandering, min(len(s.grid) for s in studies), gusts),
    )


def _usual(tables: Sequence[Table]) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    """Root mean square score of each effect, never below one; mean and deviation of each cell's."""
    keys, places = ({k for t in tables for k in t[part]} for part in (0, 1))
    effects = {k: [t[0].get(k, 0.0) for t in tables] for k in keys}
    cells = {k: [t[1].get(k, 0.0) for t in tables] for k in places}
    spread = {k: max(1.0, _rms(v)) for k, v in effects.items()}
    return (
        spread,
        {k: float(np.mean(v)) for k, v in cells.items()},
        {k: max(1.0, float(np.std(v))) for k, v in cells.items()},
    )


def _table(layout: Study, noise: NoiseModel) -> Table:
    """Scores of all effects and signed scores of all cells of one null flight, events where they fit best."""
    noise = scaled_to(noise, layout)
    layout = placed_in_time(layout, noise)
    evidence = weigh(layout, noise)
    effects = {name: score(evidence.fit(columns)) for name, columns in columns_of(layout.signatures).items()}
    first = len(layout.signatures)
    values = evidence.scores(range(first, first + len(layout.cells)))
    return effects, {label(cell): float(v) for cell, v in zip(layout.cells, values, strict=True)}


def label(cell: Cell) -> str:
    """A cell as text."""
    return f"{cell.channel}|{cell.phase}|{cell.variable}"


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _floor(tries: int, flights: int) -> float:
    """What the largest of independent scores exceeds on that share of null flights (Šidák 1967), with the error of
    means taken over so few flights."""
    return float(ndtri(1.0 - 0.5 * FALSE_ALARM / tries) * np.sqrt(1.0 + 1.0 / flights))


def _quantile(largest: Sequence[float] | Array, least: float = FLOOR) -> float:
    """The value that the largest score exceeds on a share of null flights (Gumbel 1958, by moments)."""
    scale = float(np.std(largest, ddof=1)) * np.sqrt(6.0) / np.pi
    mode = float(np.mean(largest)) - EULER * scale
    return max(least, float(mode - scale * np.log(-np.log1p(-FALSE_ALARM))))
