"""Sizes of effects: with their bounds as estimates, and in their plausible ranges."""

from collections.abc import Sequence

import numpy as np

from pitotbench.reconcile.decide.normal_equations import Fit
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.signatures.hypotheses import FITTED
from pitotbench.reconcile.signatures.signatures import Signature
from pitotbench.records.calibration import Estimate


def estimates(signatures: Sequence[Signature], fit: Fit) -> tuple[Estimate, ...]:
    """Return the fitted sizes by the names of their parameters; the bound includes the error of the method."""
    fitted = zip(fit.columns, fit.sizes, fit.deviations, strict=True)
    return tuple(
        Estimate(signatures[c].parameter, float(s), 2.0 * float(np.hypot(d, THRESHOLDS.size_error * s)))
        for c, s, d in fitted
    )


def significant(sizes: Sequence[Estimate]) -> tuple[Estimate, ...]:
    """Return the sizes that are beyond their own bound of zero; the largest in its bound where none is."""
    beyond = tuple(size for size in sizes if abs(size.value) > size.two_sigma)
    return beyond or tuple(sorted(sizes, key=lambda size: -abs(size.value) / size.two_sigma)[:1])


def is_in_range(signatures: Sequence[Signature], fit: Fit) -> bool:
    """Whether all sizes are plausible: in their ranges, or not significantly different from zero."""
    fitted = zip(fit.columns, fit.sizes, fit.deviations, strict=True)
    return all(_plausible(signatures[c], float(s), float(d)) for c, s, d in fitted)


def _plausible(signature: Signature, size: float, deviation: float) -> bool:
    parameter = FITTED[signature.effect].parameter(signature.parameter)
    slack = THRESHOLDS.range_slack * deviation
    return parameter.low - slack <= size <= parameter.high + slack or abs(size) <= slack
