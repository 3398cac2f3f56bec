"""Compare the explanations of one log: which fits best, which fits equally well, which is plausible."""

from collections.abc import Sequence

import numpy as np

from pitotbench.effects import Parameter
from pitotbench.reconcile.decide.normal_equations import Fit, NormalEquations
from pitotbench.reconcile.decide.scoring import joined, merit, significance
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.signatures.hypotheses import FITTED, cause_of
from pitotbench.reconcile.signatures.signatures import Signature, columns_of
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate

STEMS = 12  # best single effects from which pairs are searched: all pairs of some 60 effects take too long
SMALLEST_GAIN = 1e-9  # so that the ratio of two gains is defined for an effect without any


class Explanations:
    """The explanations of one log, and the choice among them."""

    def __init__(self, equations: NormalEquations, signatures: Sequence[Signature], null: NullDistribution) -> None:
        self.equations, self.signatures, self.null = equations, signatures, null
        self.columns = columns_of(signatures)
        self.singles = {n: equations.fit(c) for n, c in self.columns.items()}

    def fit(self, names: Sequence[str]) -> Fit:
        """Fit several effects together."""
        return self.equations.fit(joined(self.columns, names))

    def score(self, name: str) -> float:
        """Return the score of an effect alone, in units of its spread on null flights."""
        return self.null.scores.of_effect(name, significance(self.singles[name]))

    def choose(self) -> tuple[str, ...]:
        """Return the effects that together explain the gap; none where no effect is needed.

        An effect is added for as long as the fit improves by more than its threshold on null flights.
        """
        chosen: tuple[str, ...] = ()
        for _ in range(THRESHOLDS.effects_most):
            improved = self._improved(chosen)
            if improved is None:
                break
            chosen = improved
        return self._simplest(chosen)

    def _simplest(self, chosen: tuple[str, ...]) -> tuple[str, ...]:
        """Replace each effect by the plain form of its cause where that fits equally well.

        A single effect also gives way to one with fewer sizes that fits equally well, in the form that fits.
        """
        for place in range(len(chosen)):
            chosen = self._plain(chosen, place)
        if len(chosen) != 1:
            return chosen
        same = [chosen, *(self._plain((form,), 0) for form in self._equivalent_forms(chosen, 0).values())]
        return min(same, key=lambda names: (len(self.columns[names[0]]), -merit(self.singles[names[0]])))

    def _plain(self, names: tuple[str, ...], place: int) -> tuple[str, ...]:
        """The same effects, the one at a place in the plain form of its cause where that fits equally well."""
        plain = (*names[:place], cause_of(names[place]), *names[place + 1 :])
        if plain[place] in self.columns and merit(self.fit(names)) - merit(self.fit(plain)) < THRESHOLDS.other_form:
            return plain
        return names

    def ranked(self) -> list[str]:
        """Return each cause in its best-fitting form, the best cause first."""
        best: dict[str, str] = {}
        for name in self._by_merit():
            best.setdefault(cause_of(name), name)
        return list(best.values())

    def _by_merit(self) -> list[str]:
        return sorted(self.columns, key=lambda n: -merit(self.singles[n]))

    def _improved(self, chosen: tuple[str, ...]) -> tuple[str, ...] | None:
        """The best set with one more effect; None where the fit does not improve by enough.

        Two effects are searched over pairs with the best single ones; a third is added to the best pair.
        """
        before = self.fit(chosen) if chosen else None
        stems = [chosen] if len(chosen) != 1 else [(n,) for n in self._by_merit()[:STEMS]]
        sets = {tuple(sorted((*stem, n))) for stem in stems for n in self.columns if _is_new(n, stem)}
        fits = {s: self.fit(s) for s in sets}
        plausible = [s for s in sets if self._plausible(s, fits[s])]
        if not plausible:
            return None
        best = max(plausible, key=lambda s: merit(fits[s]))
        gained = merit(fits[best]) - (merit(before) if before is not None else 0.0)
        needed = max(self.null.threshold_of(n) for n in best if n not in chosen)
        allowance = THRESHOLDS.signature_error * significance(before) if before is not None else 0.0
        return best if gained > needed**2 + allowance**2 else None

    def _plausible(self, names: Sequence[str], fit: Fit) -> bool:
        parameters = [_parameter(self.signatures[c]) for n in names for c in self.columns[n]]
        sizes = zip(parameters, fit.sizes, fit.deviations, strict=True)
        return all(_is_in_range(parameter, size, deviation) for parameter, size, deviation in sizes)

    def equivalents(self, chosen: tuple[str, ...], place: int) -> tuple[str, ...]:
        """Return the other causes that fit equally well in the place of a chosen effect, the best first.

        Each cause may take any of its forms.
        """
        return tuple(self._equivalent_forms(chosen, place))

    def _equivalent_forms(self, chosen: tuple[str, ...], place: int) -> dict[str, str]:
        """The causes of `equivalents`, each with its best-fitting form."""
        others = chosen[:place] + chosen[place + 1 :]
        best = merit(self.fit(chosen))
        explained = best - (merit(self.fit(others)) if others else 0.0)
        limit = max(THRESHOLDS.equal_fit, THRESHOLDS.equal_fit_share * explained)
        merits: dict[str, float] = {}
        for rival in self.columns:
            if _is_new(rival, chosen):
                fit = self.fit((*others, rival))
                fair = self._in_proportion(rival, chosen[place], others, merit(fit))
                if best - fair < limit and self._plausible((*others, rival), fit):
                    merits[rival] = fair
        forms: dict[str, str] = {}
        for name in sorted(merits, key=lambda n: -merits[n]):
            forms.setdefault(cause_of(name), name)
        return forms

    def _in_proportion(self, rival: str, name: str, others: Sequence[str], free: float) -> float:
        """The merit of a rival explanation: `free` with all its sizes free, or less where that would be unfair.

        An effect with more sizes can contain the chosen one as a special case: water in a line, without the weight
        of its column, is a lag. The rival then has its sizes in their typical proportions.
        """
        columns, simple = self.columns[rival], self.columns[name]
        if len(columns) <= len(simple) or not self.equations.contains(columns, simple):
            return free
        typical = [_parameter(self.signatures[c]).typical for c in columns]
        given = joined(self.columns, others)
        base = merit(self.fit(others)) if others else 0.0
        return base + self.equations.gain_along(columns, typical, given)

    def held_out_ratio(self, names: Sequence[str]) -> float:
        """Return the gain on blocks that the fit does not use over the gain in sample."""
        fit = self.fit(names)
        return self.equations.held_out_gain(joined(self.columns, names)) / max(fit.gain, SMALLEST_GAIN)

    def candidate(self, name: str) -> Candidate:
        """Return an effect as a candidate: its sizes, score and held-out ratio as the only explanation."""
        fit = self.singles[name]
        ratio, plausible = self.held_out_ratio((name,)), self._plausible((name,), fit)
        return Candidate(name, estimates(self.signatures, fit), self.score(name), ratio, plausible)


def _parameter(signature: Signature) -> Parameter:
    return FITTED[signature.effect].parameter(signature.parameter)


def _is_new(name: str, chosen: Sequence[str]) -> bool:
    """Whether an effect has a cause other than those chosen."""
    return cause_of(name) not in map(cause_of, chosen)


def estimates(signatures: Sequence[Signature], fit: Fit) -> tuple[Estimate, ...]:
    """Return the fitted sizes by the names of their parameters; the bound includes the error of the method."""
    fitted = zip(fit.columns, fit.sizes, fit.deviations, strict=True)
    return tuple(
        Estimate(signatures[c].parameter, float(s), 2.0 * float(np.hypot(d, THRESHOLDS.size_error * s)))
        for c, s, d in fitted
    )


def _is_in_range(parameter: Parameter, size: float, deviation: float) -> bool:
    """Whether a size is plausible: in its range, or not significantly different from zero."""
    slack = THRESHOLDS.range_slack * deviation
    return parameter.low - slack <= size <= parameter.high + slack or abs(size) <= slack
