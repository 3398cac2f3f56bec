"""Judge the aerodynamic terms of a model's file by equation error: which are off, by how much, what
they close.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.linalg import toeplitz

from pitotbench.reconciliation.term_regression import (
    AXIS_CHANNEL,
    NAMES,
    RATES,
    UNITS,
    Regression,
    Term,
)
from pitotbench.records.calibration import Estimate
from pitotbench.records.terms import CHANNELS, ChannelGap, ManeuverGap, TermEstimate, TermsAccount
from pitotbench.units import DEGREE, Array

SIGNIFICANT = 3.0  # deviations from which a term enters
LEAST_GAIN = 0.005  # of the explainable gap that a term must close on what it was not fitted to
UNSEEN = 3.0  # times the noise that a change by half must move a channel, so that the maneuver can show the term
PLAUSIBLE = (-1.0, 4.0)  # relative change; a term that turns its sign stands for something else
ALIKE = 0.95  # correlation from which two terms cannot be told apart
# Deviation of a variable from which a maneuver says something of a term in it, twice the usual
# error of its sensor. Below it the errors of the sensor, which move no force, make every term seem
# too small.
LEAST_MOVE = {
    **dict.fromkeys(("alpha", "alpha_rate", "sideslip"), 0.2 * DEGREE),
    **dict.fromkeys(("p", "q", "r"), 0.5 * DEGREE),
    **dict.fromkeys(("elevator", "aileron", "rudder"), 0.1 * DEGREE),
}
LONGEST_MEMORY = 300  # samples of the residual's autocovariance


# The least squares: what is free in each maneuver is taken out first, so that sizes alone are left.


@dataclass(frozen=True, slots=True)
class _Bare:
    """A regression without its free columns, in the unit of the noise: residual (n, 6) and columns
    (n, 6, k).

    `errors` are the products of the errors of two columns, summed over channels and samples, (k,
    k).
    """

    name: str
    time: Array
    residual: Array
    columns: Array
    errors: Array

    def part(self, rows: slice) -> "_Bare":
        """Some rows."""
        share = len(self.time[rows]) / len(self.time)
        return _Bare(
            self.name, self.time[rows], self.residual[rows], self.columns[rows], share * self.errors
        )

    def left(self, sizes: Array) -> Array:
        """The residual with terms of some sizes, (n, 6)."""
        return np.asarray(self.residual - self.columns @ sizes)


def _bare(each: Regression, noise: Array) -> _Bare:
    count, weight = len(each.time), (each.kept / noise)[:, None]
    free = (each.free * weight).reshape(6 * count, -1)
    both = np.concatenate([each.residual[:, :, None], each.columns], axis=2) * weight
    flat = both.reshape(6 * count, -1)
    flat = flat - free @ np.linalg.lstsq(free, flat, rcond=None)[0]
    back = flat.reshape(count, 6, -1)
    erring = each.errors * weight[:, :, None]
    errors = count * np.einsum("ciw,cjw->ij", erring, erring)
    return _Bare(each.name, each.time, back[:, :, 0], back[:, :, 1:], errors)


def _products(several: Sequence[_Bare]) -> tuple[Array, Array, float]:
    """Normal matrix, right side and sum of squares of several maneuvers."""
    columns = np.concatenate([each.columns.reshape(-1, each.columns.shape[2]) for each in several])
    right = np.concatenate([each.residual.ravel() for each in several])
    return columns.T @ columns, columns.T @ right, float(right @ right)


def _sizes(several: Sequence[_Bare], chosen: Sequence[int]) -> Array:
    normal, right, _ = _products(several)
    sizes, own = np.zeros(len(right)), list(chosen)
    if own:
        sizes[own] = np.linalg.lstsq(normal[np.ix_(own, own)], right[own], rcond=1e-10)[0]
    return sizes


def _squares(several: Sequence[_Bare], sizes: Array) -> float:
    return float(sum(np.sum(each.left(sizes) ** 2) for each in several))


def _noise(several: Sequence[Regression]) -> list[Array]:
    """The deviation of each channel in each maneuver that all terms together leave, (6,) each.

    A maneuver in which the file explains little, because flaps moved or the flow separated, thus
    weighs little. None weighs more than the median.
    """
    left = np.empty((len(several), 6))
    for row, each in zip(left, several, strict=True):
        for i in range(6):
            design = np.concatenate([each.free[:, i], each.columns[:, i]], axis=1)
            target = each.residual[:, i]
            rest = target - design @ np.linalg.lstsq(design, target, rcond=1e-8)[0]
            row[i] = np.sqrt(np.mean(rest**2))
    return list(np.maximum(left, np.maximum(np.median(left, axis=0), 1e-9)))


def _attenuation(several: Sequence[_Bare], sizes: Array, chosen: Sequence[int]) -> Array:
    """By how much errors in the measured variables can have moved the sizes of the chosen terms.

    They move no force, so they pull every measured coefficient toward zero, and the change toward
    -1 (Klein and Morelli 2006, ch. 5.1.5; Fuller 1987, Measurement Error Models, eq. 1.2.2).
    """
    own = np.ix_(list(chosen), list(chosen))
    errors = sum(each.errors[own] for each in several)
    normal = _products(several)[0][own]
    return np.abs(
        np.linalg.pinv(normal, rcond=1e-10, hermitian=True) @ errors @ (1.0 + sizes[list(chosen)])
    )


def _covariance(several: Sequence[_Bare], sizes: Array, chosen: Sequence[int]) -> Array:
    """The covariance of sizes under residuals that are not white (Morelli and Klein 1997, eq. 15)."""
    own = list(chosen)
    normal = _products(several)[0][np.ix_(own, own)]
    middle = np.zeros_like(normal)
    for each in several:
        left = each.left(sizes)
        for i in range(6):
            design = each.columns[:, i][:, own]
            if np.any(design):
                middle += design.T @ _autocovariance(left[:, i]) @ design
    inverse = np.linalg.pinv(normal, rcond=1e-10, hermitian=True)
    return np.asarray(inverse @ middle @ inverse)


def _autocovariance(left: Array) -> Array:
    count = len(left)
    lags = min(LONGEST_MEMORY, max(2, count // 3))
    centered = left - left.mean()
    full = np.correlate(centered, centered, "full")[count - 1 :][:lags] / count
    tapered = np.zeros(count)
    tapered[:lags] = full * (1.0 - np.arange(lags) / lags)
    return np.asarray(toeplitz(tapered))


Tests = Sequence[tuple[Sequence[_Bare], Sequence[_Bare]]]


def judge_terms(
    aircraft: str,
    terms: Sequence[Term],
    fitted: Sequence[Regression],
    held_out: Sequence[Regression],
    remarks: tuple[str, ...] = (),
) -> TermsAccount:
    """Choose the terms that are off, in the order of what they close, and return them with their
    bounds.

    A term enters while its size is significant and it closes some of the gap that it was not fitted
    to: of the maneuvers held out, else of each half of a maneuver with sizes of the other half. It
    leaves again where those that entered after it close that part better.
    """
    some = [*fitted, *held_out]
    bare = [_bare(each, noise) for each, noise in zip(some, _noise(some), strict=True)]
    fit, held = bare[: len(fitted)], bare[len(fitted) :]
    seen = _seen(fit, np.max([each.moves for each in fitted], axis=0), terms)
    tests = _tests(fit, held)
    chosen = _chosen(tests, fit, seen)
    sizes = _sizes(fit, chosen)
    deviations = _deviations(fit, held, sizes, chosen)
    # Any one model could close no more than all terms of the file fitted to the maneuvers
    # themselves.
    best = [_sizes(some, seen) if some else sizes for some in (fit, held)]
    gaps = [_gap(each, bare, sizes, best[0], False) for each, bare in zip(fitted, fit, strict=True)]
    gaps += [
        _gap(each, bare, sizes, best[1], True) for each, bare in zip(held_out, held, strict=True)
    ]
    explainable = _explainable(tests, seen)
    estimates = []
    for k, i in enumerate(chosen):
        closes = _gain(tests, chosen[:k], (i,)) / explainable
        like = tuple(_alike(terms, fit, seen, i))
        estimates.append(
            _estimate(terms, i, fitted, float(sizes[i]), float(deviations[k]), closes, like)
        )
    silent = tuple(term.name for i, term in enumerate(terms) if i not in seen)
    zeros = _zeros(terms, chosen, fitted, sizes)
    return TermsAccount(
        aircraft, tuple(estimates), tuple(gaps), silent, zeros, (*remarks, *_vane(estimates))
    )


def _chosen(tests: Tests, fit: Sequence[_Bare], seen: Sequence[int]) -> list[int]:
    """The terms that close something on what they were not fitted to, those that close most first.

    Where no further term does so alone, two of them may: in slow flight the elevator balances the
    stability, and a change of either alone explains nothing.
    """
    least = LEAST_GAIN * _explainable(tests, seen)
    chosen: list[int] = []
    while True:
        rest = [i for i in seen if i not in chosen]
        singles: list[tuple[int, ...]] = [(i,) for i in rest]
        for group in (singles, list(combinations(rest, 2))):
            gains = [_gain(tests, chosen, new) for new in group]
            able = [
                (gain, new)
                for gain, new in zip(gains, group, strict=True)
                if gain >= len(new) * least and _enter(fit, [*chosen, *new], new)
            ]
            if able:
                chosen += max(able)[1]
                break
        else:
            break
    while chosen:
        without = {i: [each for each in chosen if each != i] for i in chosen}
        lost = {i: _gain(tests, without[i], (i,)) for i in chosen}
        weakest = min(lost, key=lambda i: lost[i])
        if lost[weakest] >= least and _enter(fit, chosen, chosen):
            break
        chosen = without[weakest]
    return chosen


def _vane(estimates: Sequence[TermEstimate]) -> tuple[str, ...]:
    """What a wrong scale of the vane would do: change lift slope and pitch stiffness by the same
    share.
    """
    changes = {each.name: each.change for each in estimates}
    lift = changes.get(NAMES["LIFT", "alpha"])
    if lift is None:
        return ()
    pitch = changes.get(NAMES["PITCH", "alpha"])
    other, bound = (pitch.value, pitch.two_sigma) if pitch is not None else (0.0, 0.0)
    apart = abs(lift.value - other) > np.hypot(lift.two_sigma, bound)
    told = (
        f"the lift slope changes by {100.0 * lift.value:+.0f} %, the pitch stiffness by "
        f"{100.0 * other:+.0f} %"
    )
    if apart:
        return (
            "A wrong scale of the angle-of-attack vane would change both alike. It is not the "
            f"vane alone: {told}.",
        )
    return (
        "A wrong scale of the angle-of-attack vane would change both alike. The log cannot "
        f"exclude it: {told}.",
    )


def _seen(fit: Sequence[_Bare], moves: Array, terms: Sequence[Term]) -> list[int]:
    """The terms that the maneuvers can show: half of one stands clear of the noise, and its
    variable moves.
    """
    clear = 0.5 * np.sqrt(np.diag(_products(fit)[0])) > UNSEEN
    moved = [
        move > LEAST_MOVE.get(term.function.variable, 0.0)
        for move, term in zip(moves, terms, strict=True)
    ]
    return [int(i) for i in np.flatnonzero(clear & np.array(moved))]


def _tests(fit: Sequence[_Bare], held: Sequence[_Bare]) -> Tests:
    """Pairs of what sizes are fitted to and what they are tested on."""
    if held:
        return [(fit, held)]
    if len(fit) > 1:
        return [([e for e in fit if e is not each], [each]) for each in fit]
    half = len(fit[0].time) // 2
    parts = [fit[0].part(slice(None, half)), fit[0].part(slice(half, None))]
    return [([parts[0]], [parts[1]]), ([parts[1]], [parts[0]])]


def _gain(tests: Tests, chosen: Sequence[int], new: Sequence[int]) -> float:
    """The fall of the sum of squares by further terms on what they were not fitted to."""
    with_new = [*chosen, *new]
    return sum(
        _squares(test, _sizes(on, chosen)) - _squares(test, _sizes(on, with_new))
        for on, test in tests
    )


def _explainable(tests: Tests, seen: Sequence[int]) -> float:
    """The gap that all terms together close on what is tested."""
    return sum(
        _squares(test, _sizes(test, ())) - _squares(test, _sizes(test, seen)) for _, test in tests
    )


def _enter(fit: Sequence[_Bare], chosen: Sequence[int], new: Sequence[int]) -> bool:
    """Whether the sizes of some of the chosen terms are significant, and those of a term of its
    kind.
    """
    sizes = _sizes(fit, chosen)
    found = np.sqrt(np.diag(_covariance(fit, sizes, chosen))) + _attenuation(fit, sizes, chosen)
    deviations = dict(zip(chosen, found.tolist(), strict=True))
    return all(
        abs(sizes[i]) > SIGNIFICANT * deviations[i] and PLAUSIBLE[0] < sizes[i] < PLAUSIBLE[1]
        for i in new
    )


def _deviations(
    fit: Sequence[_Bare], held: Sequence[_Bare], sizes: Array, chosen: Sequence[int]
) -> Array:
    """The deviations of the sizes: of the noise, and of what the parts of the data say each for
    itself.
    """
    if not chosen:
        return np.empty(0)
    own = np.diag(_covariance(fit, sizes, chosen))
    parts = [*fit, *held]
    if len(parts) == 1:
        half = len(fit[0].time) // 2
        parts = [fit[0].part(slice(None, half)), fit[0].part(slice(half, None))]
    # What a part hardly shows says nothing about the spread: each counts by its information.
    several = np.stack([_sizes([part], chosen)[list(chosen)] for part in parts])
    weights = np.stack([np.diag(_products([part])[0])[list(chosen)] for part in parts])
    weights = weights / weights.sum(axis=0)
    mean = np.sum(weights * several, axis=0)
    spread = (
        np.sum(weights**2 * (several - mean) ** 2, axis=0) * len(parts) / max(1, len(parts) - 1)
    )
    return np.asarray(np.sqrt(own + spread) + _attenuation(fit, sizes, chosen))


def _gap(each: Regression, bare: _Bare, sizes: Array, best: Array, held_out: bool) -> ManeuverGap:
    parts = [np.mean(bare.left(s) ** 2, axis=0) for s in (np.zeros(len(sizes)), sizes, best)]
    channels = {
        name: ChannelGap(float(parts[0][i]), float(parts[1][i]), float(parts[2][i]))
        for i, name in enumerate(CHANNELS)
        if each.kept[i]
    }
    raw = _bare(each, np.ones(6))
    constants = np.stack([_constants(each, s) for s in (np.zeros(len(sizes)), sizes)])
    before, after = raw.residual * each.scale, raw.left(sizes) * each.scale
    return ManeuverGap(each.name, held_out, channels, each.time, before, after, constants)


def _constants(each: Regression, sizes: Array) -> Array:
    """The constants of a maneuver with terms of some sizes: drag, lift and pitch-moment
    coefficients, (3,).
    """
    weight = each.kept[:, None].astype(np.float64)
    left = ((each.residual - each.columns @ sizes)[:, :, None] * weight).reshape(-1)
    free = (each.free * weight).reshape(len(left), -1)
    found = np.linalg.lstsq(free, left, rcond=None)[0]
    return np.asarray(found[[CHANNELS.index(name) for name in ("drag", "lift", "pitch moment")]])


def _alike(
    terms: Sequence[Term], fit: Sequence[_Bare], seen: Sequence[int], own: int
) -> Iterator[str]:
    """Terms whose columns are nearly that of a term."""
    normal = _products(fit)[0]
    for i in seen:
        if i != own and abs(normal[i, own]) > ALIKE * np.sqrt(normal[i, i] * normal[own, own]):
            yield terms[i].name


def _estimate(
    terms: Sequence[Term],
    i: int,
    fitted: Sequence[Regression],
    size: float,
    deviation: float,
    closes: float,
    like: tuple[str, ...],
) -> TermEstimate:
    term = terms[i]
    variable = term.function.variable
    values = np.concatenate([each.model[:, i] for each in fitted])
    model = float(values.mean())
    if variable in UNITS or variable in RATES:
        moved = [(each.model[:, i], each.regressors[:, i]) for each in fitted]
        values, regressor = (
            np.concatenate([part - part.mean() for part in parts])
            for parts in zip(*moved, strict=True)
        )
        model = float(regressor @ values / (regressor @ regressor))
    bound = 2.0 * deviation
    return TermEstimate(
        term.name,
        term.function.name,
        term.axis,
        AXIS_CHANNEL[term.axis],
        UNITS.get(variable, RATES.get(variable, "")),
        model,
        Estimate(term.name, model * (1.0 + size), abs(model) * bound),
        Estimate("change", size, bound),
        closes,
        like,
    )


def _zeros(
    terms: Sequence[Term], chosen: Sequence[int], fitted: Sequence[Regression], sizes: Array
) -> dict[str, float]:
    """What is added to each changed slope so that it turns about the flown angle of attack, by
    function.
    """
    pivots = np.mean([each.pivots for each in fitted], axis=0)
    return {
        terms[i].function.name: -float(sizes[i] * pivots[i]) for i in chosen if pivots[i] != 0.0
    }
