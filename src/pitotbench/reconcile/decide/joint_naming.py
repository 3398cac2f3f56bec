"""Name the effects of several flights of one airplane: causes and sizes shared, free parameters each flight's own.

Each flight is judged by the noise and the wander of the null flights of its own card. Its evidence adds to that of
the others. A flight that shows another size than the others do contradicts the cause.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, ndtri

from pitotbench.reconcile.decide.closure import closure_of, with_form_error
from pitotbench.reconcile.decide.evidence import Evidence
from pitotbench.reconcile.decide.log_evidence import LogEvidence
from pitotbench.reconcile.decide.naming import Naming, Renewed, naming_of, renewed_signatures
from pitotbench.reconcile.decide.normal_equations import Fit
from pitotbench.reconcile.decide.posterior import CausePosterior, cause_posterior
from pitotbench.reconcile.decide.search import CauseSearch, Names
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import whitened_equations
from pitotbench.reconcile.signatures.hypotheses import FITTED, returns
from pitotbench.reconcile.signatures.refine import at_sizes
from pitotbench.records.verdict import Closure
from pitotbench.units import Array

Key = tuple[str, str]  # an effect and one of its parameters
FARTHEST = 1e-300  # smallest probability that is turned into a distance


@dataclass(frozen=True, slots=True)
class Together:
    """Several flights named together.

    `namings` holds for each flight the shared answer with the shared sizes, `logs` its evidence, and `alone` the
    posterior of the flight by itself.
    """

    posterior: CausePosterior
    namings: tuple[Naming, ...]
    logs: tuple[LogEvidence, ...]
    alone: tuple[CausePosterior, ...]
    sizes: Mapping[Key, float]


@dataclass(frozen=True, slots=True)
class OwnSizes:
    """The sizes of some effects that one flight, or several, show: keys, values, (k,), and covariance, (k, k)."""

    keys: tuple[Key, ...]
    values: Array
    covariance: Array

    def by_key(self) -> dict[Key, float]:
        """Return each size by its key."""
        return dict(zip(self.keys, self.values.tolist(), strict=True))


def name_together(layouts: Sequence[Layout], nulls: Sequence[NullDistribution]) -> Together:
    """Name the effects that several flights show, each with its null distribution.

    The signatures are computed once more at the shared sizes, because a flight that shows little of an effect fits
    a size of its own that is far from them.
    Raises ValueError without a flight.
    """
    renewed = [renewed_signatures(layout, null) for layout, null in zip(layouts, nulls, strict=True)]
    logs = [each.evidence(null) for each, null in zip(renewed, nulls, strict=True)]
    alone = tuple(cause_posterior([log]) for log in logs)
    posterior = alone[0] if len(logs) == 1 else cause_posterior(logs)
    if len(logs) > 1:
        moved = [_at(each, _sizes_of(posterior)) for each in renewed]
        changed = [new is not old for new, old in zip(moved, renewed, strict=True)]
        if any(changed):
            logs = [
                new.evidence(null) if is_new else log
                for new, null, log, is_new in zip(moved, nulls, logs, changed, strict=True)
            ]
            renewed, posterior = moved, cause_posterior(logs)
    namings = [naming_of(each, null, posterior) for each, null in zip(renewed, nulls, strict=True)]
    sizes = shared_sizes(namings).by_key()
    if len(namings) > 1:
        namings = [_with_sizes(naming, sizes) for naming in namings]
    return Together(posterior, tuple(namings), tuple(logs), alone, sizes)


def _at(renewed: Renewed, sizes: Mapping[Key, float]) -> Renewed:
    """The signatures at some sizes; the same object where none has to be computed anew."""
    layout = at_sizes(renewed.layout, sizes)
    if layout is renewed.layout:
        return renewed
    return Renewed(layout, whitened_equations(layout, renewed.noise), renewed.noise)


def _sizes_of(posterior: CausePosterior) -> dict[Key, float]:
    """The sizes of the most probable set of effects."""
    best = posterior.weights[0].explained
    return dict(zip(best.keys, best.weighed.sizes.tolist(), strict=True))


def shared_sizes(namings: Sequence[Naming], left_out: int | None = None) -> OwnSizes:
    """Return the sizes of the named effects as fitted to all flights together, or to all but one of them.

    Form error widens their bounds and must not shift them: this is a fit without it. A size that the others hardly
    show is drawn to zero by a wide prior, as its bound is.
    """
    keys = list(dict.fromkeys(key for naming in namings for key in _keys(naming)))
    inner = np.zeros((len(keys) + 1, len(keys) + 1))
    for number, naming in enumerate(namings):
        if number != left_out:
            rows = [*(keys.index(key) for key in _keys(naming)), len(keys)]
            columns = [*naming.fit.columns, -1]
            inner[np.ix_(rows, rows)] += naming.equations.inner[np.ix_(columns, columns)]
    shown = [i for i in range(len(keys)) if inner[i, i] > 0.0]
    squares, found = inner[np.ix_(shown, shown)], tuple(keys[i] for i in shown)
    covariance = np.linalg.inv(squares + np.diag([_widest(key) ** -2.0 for key in found]))
    if left_out is None:
        sizes = np.linalg.lstsq(squares, inner[shown, -1], rcond=None)[0]
    else:
        sizes = covariance @ inner[shown, -1]
    return OwnSizes(found, np.asarray(sizes), np.asarray(covariance))


def _keys(naming: Naming) -> tuple[Key, ...]:
    """The sizes of the chosen effects that this flight shows, in the order of its fit."""
    signatures = [naming.layout.signatures[c] for c in naming.fit.columns]
    return tuple((s.effect, s.parameter) for s in signatures)


def _with_sizes(naming: Naming, sizes: Mapping[Key, float]) -> Naming:
    """The naming of a flight with the shared sizes in place of its own."""
    values = np.array([sizes[key] for key in _keys(naming)])
    columns = naming.fit.columns
    inner = naming.equations.inner
    gain = 2.0 * values @ inner[columns, -1] - values @ inner[np.ix_(columns, columns)] @ values
    return replace(naming, fit=Fit(columns, values, naming.fit.covariance, max(0.0, float(gain))))


def left_out_closures(namings: Sequence[Naming]) -> tuple[Closure | None, ...]:
    """Return for each flight the closure by the sizes that the other flights show; None where they show none.

    Effects for a part of one flight, and events, are fitted to that flight: another flight does not have them.
    """
    if len(namings) < 2:
        return (None,) * len(namings)
    found: list[Closure | None] = []
    for number, naming in enumerate(namings):
        sizes = shared_sizes(namings, left_out=number)
        pairs = [
            (column, sizes.keys.index(key))
            for column, key in zip(naming.fit.columns, _keys(naming), strict=True)
            if key in sizes.keys and returns(key[0])
        ]
        cells, columns, places = [i for i, _ in naming.layout.places], [c for c, _ in pairs], [p for _, p in pairs]
        own = zip(naming.fit.columns, _keys(naming), strict=True)
        once = [column for column, key in own if not returns(key[0])]
        values = sizes.values[places].tolist()
        errors = with_form_error(sizes.covariance[np.ix_(places, places)], values)
        found.append(closure_of(naming.equations, columns, values, cells, errors, once) if pairs else None)
    return tuple(found)


def own_sizes(logs: Sequence[LogEvidence], effects: Names, sizes: Mapping[Key, float]) -> OwnSizes:
    """Return the sizes of some effects that logs show, with the form error of effects of about these sizes.

    The prior is as wide as a size can be, so that a log that does not show an effect says nothing of it.
    """
    search = CauseSearch(logs)
    shown = tuple(name for name in effects if name in search.keys)
    keys = search.keys_of(shown)
    evidence, _ = search.reduced(shown, np.array([sizes.get(key, 0.0) for key in keys]), keys)
    wide = np.array([_widest(key) for key in keys])
    found = Evidence(evidence.inner).of(range(len(keys)), wide)
    method = np.array([THRESHOLDS.size_error * sizes.get(key, 0.0) for key in keys])
    return OwnSizes(tuple(keys), found.mean, found.covariance + np.diag(method**2))


def _widest(key: Key) -> float:
    """The widest prior deviation of a size."""
    return THRESHOLDS.size_scales[-1] * abs(float(FITTED[key[0]].parameter(key[1]).typical))


def contradiction(own: OwnSizes, others: OwnSizes) -> float:
    """Return the distance [σ] of the sizes that one flight shows from those that the other flights show.

    It is that of a normal number as improbable as the squared distance of the sizes, which is χ²-distributed.
    """
    both = [key for key in own.keys if key in others.keys]
    if not both:
        return 0.0
    mine, theirs = ([each.keys.index(key) for key in both] for each in (own, others))
    difference = own.values[mine] - others.values[theirs]
    covariance = own.covariance[np.ix_(mine, mine)] + others.covariance[np.ix_(theirs, theirs)]
    square = float(difference @ np.linalg.solve(covariance, difference))
    chance = float(chdtrc(len(both), square))
    return float(-ndtri(0.5 * max(chance, FARTHEST)))
