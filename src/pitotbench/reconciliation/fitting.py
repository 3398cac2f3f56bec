"""Fit the gaps of some logs and linearize at what was found, until the sizes stay."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.reconciliation.equations import (
    Fit,
    scaled_to,
    whitened_equations,
)
from pitotbench.reconciliation.evidence import (
    merit,
)
from pitotbench.reconciliation.formula import term_signatures
from pitotbench.reconciliation.layout import (
    Layout,
    shown_vane_errors,
    vane_errors,
    without_vane_errors,
)
from pitotbench.reconciliation.lines import with_lines
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.regression import (
    Block,
    FoundGap,
    Regression,
    Sizes,
    block_of,
    is_term,
    shares_of,
    stands_out_beside,
)
from pitotbench.reconciliation.renewal import (
    Entries,
    at_sizes,
    placed_in_time,
    with_parts_of_flight,
    without_sensor_effects,
)
from pitotbench.reconciliation.sets import FittedHypothesis
from pitotbench.reconciliation.signatures import (
    FITTED,
    Key,
    columns_of,
    lasts,
    parameter_of,
    reads_gusts,
)
from pitotbench.reconciliation.thresholds import THRESHOLDS

# Linearize at what was found: signatures at the fitted sizes, around the log without the effects on
# its sensors; then fit again, until the sizes stay.


@dataclass(frozen=True, slots=True)
class Fitted:
    """All gaps of some logs in the order of what each explains, what is left, and the sizes of all.

    `regression` is that at the sizes which it finds. `sizes` are as the logs show them; `told` are
    freed of the factor that a log gives all terms of the pitching moment.
    """

    regression: Regression
    gaps: tuple[FoundGap, ...]
    left: FoundGap
    sizes: Sizes
    told: Sizes

    @property
    def members(self) -> list[FittedHypothesis]:
        """The hypotheses in the fit."""
        return [gap.member for gap in self.gaps]

    @property
    def shows_more(self) -> bool:
        """Whether the logs show a gap beside all that are explained.

        A log shows one as a log without members does, by a cell or an effect that stands out beside
        them.
        """
        return self.regression.shows(self.left) and any(
            stands_out_beside(
                each.layout,
                each.equations,
                each.null,
                self.regression.shown_columns(each, self.members),
            )
            for each in self.regression.blocks
        )

    @property
    def has_open_gap(self) -> bool:
        """Whether they show one that probably has no cause in the table."""
        return self.shows_more and self.left.unknown > THRESHOLDS.likely

    def fit_of(self, block: Block) -> Fit:
        """Return the sizes of all gaps that a block shows as a fit of it."""
        own = self.sizes.among([key for key in self.sizes.keys if key in block.keys])
        columns = [block.keys.index(key) for key in own.keys]
        inner, s = block.equations.inner, own.values
        gain = 2.0 * s @ inner[columns, -1] - s @ inner[np.ix_(columns, columns)] @ s
        return Fit(tuple(columns), s, own.covariance, max(0.0, float(gain)))


def fit_gaps(layouts: Sequence[Layout], nulls: Sequence[NullDistribution]) -> Fitted:
    """Return all gaps of one log or of several of one airplane, each with its null distribution.

    Where a gap is left to smooth cells, events are placed anew beside the others; where it stays
    so, the terms of formulas compete as well.
    """
    layouts = [with_lines(*each) for each in zip(layouts, nulls, strict=True)]
    noises = [scaled_to(n.noise, each) for n, each in zip(nulls, layouts, strict=True)]
    original = [
        with_parts_of_flight(placed_in_time(layout, noise), noise)
        for layout, noise in zip(layouts, noises, strict=True)
    ]
    now = [_at_single(layout, noise) for layout, noise in zip(original, noises, strict=True)]
    fitted = _fitted(now, noises, nulls)
    for _ in range(THRESHOLDS.linearized_most - 1):
        blocks = fitted.regression.blocks
        laid = [_with_vanes(*each, fitted) for each in zip(original, blocks, strict=True)]
        moved = [
            _at(layout, at if layout is before else layout, fitted)
            for layout, before, at in zip(laid, original, now, strict=True)
        ]
        original = laid
        if all(after is before for after, before in zip(moved, now, strict=True)):
            break
        now, fitted = moved, _fitted(moved, noises, nulls)
    if fitted.has_open_gap:
        laid = [_placed_beside(block, fitted) for block in fitted.regression.blocks]
        fitted = _fitted(laid, noises, nulls)
    wanted = fitted.has_open_gap or not fitted.regression.columns
    return with_terms(fitted) if wanted else fitted


def with_terms(fitted: Fitted) -> Fitted:
    """Return the gaps of the same logs with the terms of formulas among the hypotheses."""
    blocks = fitted.regression.blocks
    if any(map(is_term, fitted.regression.columns)):
        return fitted
    layouts = [block.layout for block in blocks]
    laid = [
        replace(each, signatures=(*each.signatures, *term_signatures(each.reference)))
        for each in layouts
    ]
    return _fitted(laid, [block.noise for block in blocks], [block.null for block in blocks])


def _placed_beside(block: Block, fitted: Fitted) -> Layout:
    """Return a layout with events and part-of-flight effects placed beside the gaps found.

    Each stands where it explains most.
    """
    layout, fit, taken = block.layout, fitted.fit_of(block), {m.name for m in fitted.members}
    bare = layout.without([layout.signatures[c].column for c in fit.columns], fit.sizes)
    others = tuple(s for s in layout.signatures if lasts(s.effect))
    placed = placed_in_time(replace(bare, signatures=others), block.noise)
    again = with_parts_of_flight(placed, block.noise).signatures
    own = [s for s in layout.signatures if s.effect in taken]
    return replace(layout, signatures=(*own, *(s for s in again if s.effect not in taken)))


def _fitted(
    layouts: Sequence[Layout], noises: Sequence[NoiseModel], nulls: Sequence[NullDistribution]
) -> Fitted:
    blocks = [block_of(*each) for each in zip(layouts, noises, nulls, strict=True)]
    return fitted_by(Regression(blocks))


def fitted_by(regression: Regression, without: Iterable[str] = ()) -> Fitted:
    """Return the gaps of a regression, those with the most evidence first, with their sizes."""
    gaps, left = regression.fit(without)
    ranked = sorted(gaps, key=lambda gap: -gap.log_bayes_factor)
    shown, told = (_sizes_of(regression, ranked, freed) for freed in (False, True))
    return Fitted(regression, tuple(ranked), left, shown, told)


def _sizes_of(regression: Regression, gaps: Sequence[FoundGap], freed: bool) -> Sizes:
    """The sizes of all gaps, with bounds that hold those of sets nearly as probable."""
    sizes = regression.sizes([gap.member for gap in gaps], freed)
    for near in dict.fromkeys(gap.near for gap in gaps if len(gap.near) > 1):
        others = [gap.member for gap in gaps if gap.near != near]
        variances, weights = np.zeros(len(sizes.keys)), np.zeros(len(sizes.keys))
        for each, share in zip(near, shares_of(near), strict=True):
            rival = regression.sizes([*others, *each.members], freed).among(sizes.keys)
            own = [sizes.keys.index(key) for key in rival.keys]
            apart = rival.values - sizes.values[own]
            variances[own] += share * (np.diag(rival.covariance) + apart**2)
            weights[own] += share
        wider = variances / np.where(weights > 0.0, weights, 1.0) / np.diag(sizes.covariance)
        scale = np.sqrt(np.maximum(wider, 1.0))
        sizes = replace(sizes, covariance=sizes.covariance * np.outer(scale, scale))
    return sizes


def _with_vanes(original: Layout, block: Block, fitted: Fitted) -> Layout:
    """Return a layout linearized without the vanes' errors that the log shows beside the gaps.

    Where the errors stay, or where a gap is one of the vanes, it is the same object. A force is the
    product of a derivative and an angle. Each linearized for itself, a lift slope that is a quarter
    off and a vane whose scale is a tenth off leave an error of 2.5 % in the slope.
    """
    if any(not is_term(each.name) and reads_gusts(each.name) for each in fitted.members):
        return original
    layout, own = block.layout, fitted.regression.shown_columns(block, fitted.members)
    errors = (
        shown_vane_errors(layout.free.names, *block.equations.free_estimates(own))
        if own
        else vane_errors(layout)
    )
    again = without_vane_errors(original, errors)
    if again is original:
        return original
    return with_parts_of_flight(placed_in_time(again, block.noise), block.noise)


def _at_single(layout: Layout, noise: NoiseModel) -> Layout:
    """A layout with the signatures of its best single explanations at their fitted sizes."""
    columns = columns_of(layout.signatures)
    equations = whitened_equations(layout, noise, with_cells=False)
    fits = {name: equations.fit(own) for name, own in columns.items()}
    ranked = sorted(fits, key=lambda name: -merit(fits[name]))
    if not ranked:
        return layout
    sizes = {
        (name, layout.signatures[c].parameter): float(size)
        for name in ranked[: THRESHOLDS.rested]
        for c, size in zip(columns[name], fits[name].sizes, strict=True)
    }
    large = merit(fits[ranked[0]]) > THRESHOLDS.undone_from**2
    return at_sizes(
        without_sensor_effects(layout, _entries(layout, ranked[:1], sizes) if large else {}), sizes
    )


def _at(original: Layout, now: Layout, fitted: Fitted) -> Layout:
    """A layout linearized at the sizes of all gaps; the same object where none has moved."""
    sizes = {key: size for key, size in fitted.sizes.by_key().items() if key[0] in FITTED}
    deviations = np.sqrt(np.diag(fitted.sizes.covariance)).tolist()
    far = [
        key
        for key, size, deviation in zip(
            fitted.sizes.keys, fitted.sizes.values.tolist(), deviations, strict=True
        )
        if abs(size) > THRESHOLDS.undone_from * deviation
    ]
    names = [name for name in dict.fromkeys(key[0] for key in far) if name in FITTED]
    if at_sizes(now, sizes) is now:
        return now
    # The rivals stay at the sizes that they have alone.
    alone = {(s.effect, s.parameter): s.size for s in now.signatures}
    bare = without_sensor_effects(original, _entries(now, names, sizes))
    return at_sizes(bare, {**alone, **sizes})


def _entries(layout: Layout, names: Sequence[str], sizes: Mapping[Key, float]) -> Entries:
    """Some effects with their sizes, in their plausible ranges, and their shapes."""
    found: dict[str, dict[str, float]] = {}
    for signature in layout.signatures:
        name, key = signature.effect, (signature.effect, signature.parameter)
        if name in names and key in sizes:
            held = parameter_of(layout.reference, key).within(sizes[key])
            found.setdefault(name, dict(signature.shapes))[signature.parameter] = held
    return found
