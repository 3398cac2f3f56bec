"""One jump of a flight's wind, at a time that nobody knows: the one discrete hypothesis of the air.

A jump at a given time is two more unknowns, so that its likelihood and its answer are updates of
rank two (the Schur complement of the normal equations). The time is marginalized over a grid. The
noise is searched anew: without the jump, the slow wind and the gusts have to imitate it.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.special import logsumexp

from pitotbench.units import Array, Seconds
from pitotlab.candidate.linear_gaussian import LinearGaussian, Normal

SELDOM = 1e-3  # share of an answer below which a time is left out


@dataclass(frozen=True, slots=True)
class _Updates:
    """For each time (t,) and one φ: log-odds against no jump, the jump's size (t, 2) and its
    covariance (t, 2, 2), and what a jump of 1 m/s moves the other unknowns by, (t, p, 2).
    """

    log_odds: Array
    size: Array
    covariance: Array
    moved: Array


@dataclass(slots=True)
class WithJump:
    """The problem with one jump of the wind of one flight; a `Surface` of φ.

    `further` (n, 2 t) are the columns of a jump at each of `times` (t,) [s] in the set of equations
    `number`; `deviation` [m/s] is the prior of a component, `odds` that of a jump.
    """

    problem: LinearGaussian
    number: int
    times: Seconds
    further: Array
    deviation: float
    odds: float
    _known: dict[tuple[int, bytes], _Updates] = field(default_factory=dict)
    _weighed: dict[bytes, tuple[Array, Array, Array]] = field(default_factory=dict)

    @property
    def owners(self) -> list[slice]:
        """As those of the problem."""
        return self.problem.owners

    @property
    def rivals(self) -> int:
        """As those of the problem."""
        return self.problem.rivals

    def heights(self, phis: Array, hypothesis: int = 0) -> Array:
        """The log-posterior at φ (b, d) with a jump at any of the times, (b,)."""
        without = self.problem.heights(phis, hypothesis)
        found = [
            -np.inf if not np.isfinite(height) else height + logsumexp(update.log_odds)
            for height, update in zip(
                without, (self._updates(phi, hypothesis) for phi in phis), strict=True
            )
        ]
        return np.array(found)

    def answers(self, phi: Array, hypothesis: int, weight: float) -> list[Normal]:
        """The answers given one φ, one a time that is not too unlikely."""
        update = self._updates(phi, hypothesis)
        mean, covariance = self.problem.solve(phi, hypothesis)
        shares = np.exp(update.log_odds - logsumexp(update.log_odds))
        kept = np.flatnonzero(shares > SELDOM)
        return [
            Normal(
                weight * float(shares[t] / shares[kept].sum()),
                hypothesis,
                phi,
                mean - update.moved[t] @ update.size[t],
                covariance + update.moved[t] @ update.covariance[t] @ update.moved[t].T,
            )
            for t in kept
        ]

    def likeliest_time(self, phi: Array, hypothesis: int) -> float:
        """The likeliest time of the jump given φ [s]."""
        return float(self.times[np.argmax(self._updates(phi, hypothesis).log_odds)])

    def _updates(self, phi: Array, hypothesis: int) -> _Updates:
        key = (hypothesis, phi.tobytes())
        if key not in self._known:
            self._known[key] = self._updated(phi, hypothesis)
        return self._known[key]

    def _updated(self, phi: Array, hypothesis: int) -> _Updates:
        part, t = self.problem.equations[self.number], len(self.times)
        crossed, pull, alone = self._products(phi[part.own])
        mean, covariance = self.problem.by_instruments(phi, hypothesis)
        moved = covariance[:, part.places] @ crossed  # (t, p, 2)
        left = pull - np.swapaxes(crossed, 1, 2) @ mean[part.places]
        information = alone - np.swapaxes(crossed, 1, 2) @ moved[:, part.places]
        known = np.linalg.inv(information + np.eye(2) / self.deviation**2)
        size = np.einsum("tij,tj->ti", known, left)
        gain = 0.5 * (np.sum(left * size, axis=1) + np.linalg.slogdet(known)[1])
        log_odds = gain - 2.0 * np.log(self.deviation) + np.log(self.odds / t)
        return _Updates(log_odds, size, np.asarray(known, dtype=np.float64), moved)

    def _products(self, own: Array) -> tuple[Array, Array, Array]:
        """Of the columns F of each time, ZᵀC⁻¹F (t, q, 2), FᵀC⁻¹y (t, 2) and FᵀC⁻¹F (t, 2, 2)."""
        if own.tobytes() not in self._weighed:
            part, t = self.problem.equations[self.number], len(self.times)
            (weighed,) = part.noise_of.stack(own[None]).weigh(self.further)
            each = np.swapaxes(weighed.reshape(-1, t, 2), 0, 1)
            columns = np.swapaxes(self.further.reshape(-1, t, 2), 0, 1)
            self._weighed[own.tobytes()] = (
                part.instruments.T @ each,
                np.einsum("n,tni->ti", part.residual + part.instruments @ part.point, each),
                np.swapaxes(columns, 1, 2) @ each,
            )
        return self._weighed[own.tobytes()]


def jump_columns(
    along: Array, time: Seconds, times: Seconds, seconds: float, weights: Array
) -> Array:
    """Return the columns of a jump at each of `times` (t,), (n, 2 t).

    `along` (n, 2) are the direction cosines of the velocity through the air at `time` (n,) [s]; a
    jump lasts `seconds` and has a mean of zero under `weights` (n,).
    """
    ramp = np.clip((time[:, None] - times) / seconds + 0.5, 0.0, 1.0)
    ramp -= np.average(ramp, axis=0, weights=weights)
    return -(along[:, None, :] * ramp[:, :, None]).reshape(len(time), -1)


def evenly(time: Seconds, count: int) -> Seconds:
    """Return the middles of `count` parts of a flight [s]."""
    return np.asarray(time[0] + (time[-1] - time[0]) * (np.arange(count) + 0.5) / count)
