"""Smooth discrepancies of unknown form: the evidence of a log with cells of unwritten sizes.

A place has some hundred cells, and a fit asks for their evidence given each hypothesis, in five
sizes, at two powers of the likelihood. The cells are turned once into axes that are independent
where nothing else is in the fit. What the members of a fit take from them is of low rank, so that
each further question costs matrices of the members alone (Woodbury's identity and the determinant
lemma: Rasmussen and Williams 2006, app. A.3).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.estimation.information import Information, Marginal
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class Discrepancy:
    """A smooth discrepancy of a place, by its n cells.

    `turn`, (n, n), makes independent axes of them, `powers` are those of the axes, (n,), and
    `log_prior` is the logarithm of the prior of each of its sizes.

    `place` is a channel, a family of channels or `all`.
    """

    place: str
    cells: tuple[int, ...]
    turn: Array
    powers: Array
    log_prior: float

    def log_evidences(
        self, marginal: Marginal, hypotheses: Sequence[tuple[Sequence[int], Array]]
    ) -> list[float]:
        """Return ln of prior times evidence of the discrepancy, in any size, by hypothesis.

        Each hypothesis is in the fit as well as the members that are fitted with it. A hypothesis
        has some columns, (q,), with prior deviations, (q,); none of them stand for the members
        alone.
        """
        inner, cells = marginal.left.inner, list(self.cells)
        rows = [*(c for columns, _ in hypotheses for c in columns), -1]
        scale = np.concatenate([*(deviations for _, deviations in hypotheses), [1.0]])
        own = inner[np.ix_(rows, rows)] * np.outer(scale, scale)
        across = self.turn @ (inner[np.ix_(cells, rows)] * scale)
        sizes = np.square(THRESHOLDS.rest_sizes)[:, None]
        spread = 1.0 + marginal.power * sizes * self.powers
        weight = (sizes / spread)[:, :, None]
        taken = self.turn @ marginal.taken[cells]
        weighted = taken * weight
        between = np.swapaxes(weighted, 1, 2) @ across
        members = np.eye(taken.shape[1]) - taken.T @ weighted
        fall = across.T @ (across * weight)
        fall = fall + np.swapaxes(between, 1, 2) @ np.linalg.solve(members, between)
        occam = np.log(spread).sum(axis=1) + np.linalg.slogdet(members)[1]
        left, found, first = own - fall, list[float](), 0
        for columns, _ in hypotheses:
            each = [*range(first, first + len(columns)), -1]
            first += len(columns)
            with_cells = _log_evidence(left[:, each][:, :, each]) + 0.5 * (fall[:, -1, -1] - occam)
            alone = _log_evidence(own[np.ix_(each, each)])
            found.append(float(self.log_prior + np.logaddexp.reduce(with_cells) - alone))
        return found


def discrepancy_of(
    place: str, cells: Sequence[int], evidence: Information, prior: float
) -> Discrepancy:
    """Return the discrepancy of some cells of a log, with a prior that all its sizes share.

    The prior deviation of a cell of size 1 is that at which all cells together show one σ.
    """
    own = evidence.inner[np.ix_(cells, cells)]
    unit = 1.0 / np.sqrt(np.diag(own) * len(cells))
    powers, axes = np.linalg.eigh(own * np.outer(unit, unit))
    log_prior = float(np.log(prior / len(THRESHOLDS.rest_sizes)))
    return Discrepancy(place, tuple(cells), axes.T * unit, np.maximum(powers, 0.0), log_prior)


def _log_evidence(inner: Array) -> Array:
    """Return ln of the evidence of columns by inner products (..., q + 1, q + 1).

    The columns are in units of their deviations, with the residual last.
    """
    normal, right = inner[..., :-1, :-1] + np.eye(inner.shape[-1] - 1), inner[..., :-1, -1:]
    fall = np.sum(right * np.linalg.solve(normal, right), axis=(-2, -1))
    return np.asarray(0.5 * (fall - np.linalg.slogdet(normal)[1]))
