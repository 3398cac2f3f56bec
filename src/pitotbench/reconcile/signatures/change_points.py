"""Look for effects that act for a part of the flight: where in a log does each of them begin, and end?

Every effect is fitted from each of some times on and between each two of them. Only an effect that so explains
more than every effect does over the whole flight becomes a hypothesis; its times are then refined.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.effects import Effect
from pitotbench.effects.part_of_flight import FROM, TO
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.whitening import ORDER, NoiseModel
from pitotbench.reconcile.signatures.hypotheses import FITTED, ONE_MODEL, happens_once
from pitotbench.reconcile.signatures.refine import HALVINGS, Shapes, Trials
from pitotbench.reconcile.signatures.signatures import Signature, columns_of
from pitotbench.units import Array, Seconds

APART = 10.0  # s between the times that are tried; the whitening looks back by 6 s
MOST_TIMES = 30  # of them: pairs grow with the square
WIDEST = 4.0  # typical sizes: the widest prior deviation of a size
PROMISING = 3  # effects that become hypotheses
LEAST_GAIN = 100.0  # fall of the SS; the wander of null flights gives the best of all times up to 60

# They have a law of time of their own: a drift for a part of the flight jumps at its ends, as no drift does.
DRIFTS = ("clock_drift", "time_drift", "temperature_drift", "wind_drift")
# Mounting, rigging and calibration of instruments: these are the same from the first sample to the last.
SET_ON_GROUND = (
    "alpha_vane_calibration", "antenna_lever_arm", "compass_deviation", "gps_velocity_scale",
    "inertial_unit_misalignment", "manifold_pressure_scale", "quadrantal_deviation", "sideslip_vane_calibration",
    "static_pressure_scale", "throttle_pickup", "throttle_rigging",
)  # fmt: skip

Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class _Stretch:
    """The best part of the flight for one form of an effect, and the fall of the sum of squares."""

    form: Effect
    shapes: Shapes
    gain: float


def with_parts_of_flight(layout: Layout, noise: NoiseModel) -> Layout:
    """Return the layout with the signatures of promising effects that act for a part of the flight."""
    found = _promising(layout, noise)
    if not found:
        return layout
    trials, added = Trials(layout, noise), list[Signature]()
    for each in found:
        start = [replace(s, effect=each.form.name) for s in layout.signatures if s.effect == each.form.part_of]
        added += _refined(trials, each, start)
    return replace(layout, signatures=(*layout.signatures, *added))


def _refined(trials: Trials, found: _Stretch, start: Sequence[Signature]) -> list[Signature]:
    """The signatures of a form at its best times, in halved steps around those found."""
    best, step = trials.at(found.form, start, found.shapes), 0.5 * APART
    for _ in range(HALVINGS):
        for name in found.shapes:
            for moved in (best.shapes[name] - step, best.shapes[name] + step):
                shapes = {**best.shapes, name: max(0.0, moved)}
                if shapes.get(TO.name, np.inf) > shapes[FROM.name] + step:
                    trial = trials.at(found.form, start, shapes)
                    best = trial if trial.merit > best.merit else best
        step *= 0.5
    return best.signatures


def _promising(layout: Layout, noise: NoiseModel) -> list[_Stretch]:
    """The best forms for a part of the flight, of the effects that explain most."""
    scan = _Scan(layout, noise)
    columns = columns_of(layout.signatures)
    whole = {name: scan.whole(own) for name, own in columns.items()}
    least = max(
        LEAST_GAIN, max(gain - THRESHOLDS.free_size_penalty * (len(columns[n]) - 1) for n, gain in whole.items())
    )
    found = [
        each for name in columns if _may_be_timed(name) for each in scan.stretches(name, columns[name], whole[name])
    ]
    best = sorted((s for s in found if s.gain > least), key=lambda s: -s.gain)
    effects = list(dict.fromkeys(s.form.part_of for s in best))[:PROMISING]
    return [s for s in best if s.form.part_of in effects]


def _may_be_timed(name: str) -> bool:
    """Whether an effect is looked for in parts of the flight: the plain form of a cause without own times.

    What a workshop sets does not change in the air.
    """
    plain = not FITTED[name].variant_of and name not in (*ONE_MODEL, *DRIFTS, *SET_ON_GROUND)
    return plain and not happens_once(name) and f"{name}_for_a_time" in FITTED


class _Scan:
    """Inner products of every signature from each of some times on, with the free parameters eliminated.

    A signature that begins at an instant is whitened like any other: from `ORDER` instants later on it is that of
    the whole flight.
    """

    def __init__(self, layout: Layout, noise: NoiseModel) -> None:
        grid, slack, free = layout.grid, layout.residuals.slack, layout.free
        values = np.stack([s.column for s in layout.signatures], axis=2)
        whiten = noise.whitener(grid, slack)
        known = np.concatenate([whiten(free.columns), whiten(layout.residuals.values)[:, :, None]], axis=2)
        columns = whiten(values)
        time = layout.track.time[grid.rows] - layout.track.time[0]
        apart = max(APART, (ORDER + 2) * grid.step)  # with a fix a second the whitening looks back by 12 s
        count = int(np.clip((time[-1] - time[0]) / apart, 2, MOST_TIMES))
        starts = np.searchsorted(time, time[0] + (time[-1] - time[0]) * np.arange(1, count) / count)
        self.starts: Indices = starts[np.diff(starts, append=len(time)) > ORDER]
        self.times: Seconds = time[self.starts]
        every = np.concatenate([known, columns], axis=2)
        k, s = known.shape[2] - 1, columns.shape[2]
        across, own = np.zeros((len(self.starts) + 1, s, k + 1 + s)), np.zeros((len(self.starts) + 1, s, s))
        later, end = np.zeros((s, k + 1 + s)), len(time)
        for i in range(len(self.starts) - 1, -1, -1):
            begin = int(self.starts[i])
            near = slice(max(0, begin - ORDER - 1), min(len(time), begin + ORDER))
            part = values[near].copy()
            part[: begin - near.start] = 0.0
            there = replace(grid, rows=grid.rows[near], first=grid.first[near], _kept=[])
            first = noise.whiten(part, there, slack[near])[begin - near.start :]
            later = later + _product(columns[near.stop : end], every[near.stop : end])
            end = near.stop
            across[i + 1] = later + _product(first, every[begin : near.stop])
            own[i + 1] = later[:, k + 1 :] + _product(first, first)
        across[0] = _product(columns, every)
        own[0] = across[0][:, k + 1 :]
        free_products = _product(known, known)
        normal = free_products[:k, :k] + np.diag(free.deviations**-2.0)
        scale = 1.0 / np.sqrt(np.diag(normal))
        inverse = np.linalg.pinv(normal * np.outer(scale, scale), rcond=1e-12, hermitian=True) * np.outer(
            scale, scale
        )
        self._with_free, self._with_residual = (
            across[:, :, :k],
            across[:, :, k] - across[:, :, :k] @ (inverse @ free_products[:k, k]),
        )
        self._with_whole, self._own, self._inverse = across[:, :, k + 1 :], own, inverse
        self._widest = WIDEST * np.array(
            [abs(FITTED[s.effect].parameter(s.parameter).typical) for s in layout.signatures]
        )

    def whole(self, columns: Sequence[int]) -> float:
        """The fall of the sum of squares by an effect over the whole flight."""
        return float(self._gains(columns, np.zeros(1, dtype=np.intp), None)[0])

    def stretches(self, name: str, columns: Sequence[int], whole: float) -> Iterator[_Stretch]:
        """The best form of an effect from a time on and the best between two times, where they are worth it.

        What the flight shows without the effect has to contradict it as another flight would have to.
        """
        if not len(self.starts):
            return
        least = whole + THRESHOLDS.contradicted_from**2
        starts = np.arange(1, len(self.starts) + 1)
        on = self._gains(columns, starts, None)
        best = int(np.argmax(on))
        if on[best] > least:
            yield _Stretch(FITTED[f"{name}_from_a_time"], {FROM.name: float(self.times[best])}, float(on[best]))
        begins, ends = np.triu_indices(len(self.starts) + 1, 1)
        between = self._gains(columns, begins, ends)
        last = int(np.argmax(between))
        if between[last] > max(least, on[best] + THRESHOLDS.free_size_penalty):
            times = np.concatenate([[0.0], self.times])
            shapes = {FROM.name: float(times[begins[last]]), TO.name: float(times[ends[last]])}
            yield _Stretch(FITTED[f"{name}_for_a_time"], shapes, float(between[last]))

    def _gains(self, columns: Sequence[int], begins: Indices, ends: Indices | None) -> Array:
        """The falls of the sum of squares by columns from some starts on, or between starts and ends, (w,)."""
        own = list(columns)
        # The columns first: a few of some hundred, where pairs of times are many.
        with_free, with_residual = self._with_free[:, own], self._with_residual[:, own]
        inner_own = self._own[:, own][:, :, own]
        free, right, inner = with_free[begins], with_residual[begins], inner_own[begins]
        if ends is not None:
            free, right = free - with_free[ends], right - with_residual[ends]
            shared = self._with_whole[:, own][:, :, own][ends]
            inner = inner + inner_own[ends] - shared - shared.transpose(0, 2, 1)
        reproduced = (free.reshape(-1, free.shape[2]) @ self._inverse).reshape(free.shape)
        normal = inner - reproduced @ free.transpose(0, 2, 1)
        normal = normal + np.diag(self._widest[own] ** -2.0)
        return np.asarray(np.sum(right * np.linalg.solve(normal, right[:, :, None])[:, :, 0], axis=1))


def _product(one: Array, other: Array) -> Array:
    """Inner products of columns over all instants and channels: (n, c, i) and (n, c, j) to (i, j)."""
    return np.asarray(one.reshape(-1, one.shape[2]).T @ other.reshape(-1, other.shape[2]))
