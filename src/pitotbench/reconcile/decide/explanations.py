"""Compare the explanations of one log: which fits best, which fits as well, which is plausible."""

from collections.abc import Sequence

import numpy as np

from pitotbench.effects import Parameter
from pitotbench.reconcile.decide.normal_equations import Fit, NormalEquations
from pitotbench.reconcile.decide.scoring import joined, merit, score_candidates
from pitotbench.reconcile.null_flights.null_distribution import Knowledge
from pitotbench.reconcile.residuals.layout import FITTED, cause_of, columns_of
from pitotbench.reconcile.signatures.signatures import Signature
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate

APART = 9.0  # fall of the sum of squares that separates two explanations: 3σ
DOUBT = 0.1  # share of the explained sum of squares that an error in the form of an effect may cost it
LINEAR = 0.03  # error of a signature as a share of it, which other effects may then seem to explain
METHOD = 0.05  # deviation of a size as a share of it, for the error of the method (lags come out 3 to 5 % long)
FORM = 6.0  # fall of the sum of squares from which another form of the same cause is preferred to the plain one
MOST = 3  # effects named at once
CONTENDERS = 6  # explanations whose signatures are renewed at their fitted sizes
SLIGHT = 2.0  # deviations by which a size may miss its plausible range


class Explanations:
    """The explanations of one log, and the choice among them."""

    def __init__(self, weighed: NormalEquations, signatures: Sequence[Signature], known: Knowledge) -> None:
        self.evidence, self.signatures, self.known = weighed, signatures, known
        columns = columns_of(signatures)
        self.columns = columns
        self.singles = {n: weighed.fit(c) for n, c in columns.items()}

    def fit(self, names: Sequence[str]) -> Fit:
        """Fit several effects together."""
        return self.evidence.fit(joined(self.columns, names))

    def score(self, name: str) -> float:
        """Return the score of an effect alone, in units of its spread on null flights."""
        return self.known.told(name, score_candidates(self.singles[name]))

    def choose(self) -> tuple[str, ...]:
        """Return the effects that together explain the gap, at most `MOST`; none where no effect is needed.

        An effect is added for as long as the fit improves by more than its threshold on null flights.
        """
        chosen: tuple[str, ...] = ()
        for _ in range(MOST):
            better = self._better(chosen)
            if better is None:
                break
            chosen = better
        return self._simplest(chosen)

    def _simplest(self, chosen: tuple[str, ...]) -> tuple[str, ...]:
        """Replace each effect by the plain form of its cause where that fits as well.

        A single effect also gives way to one with fewer sizes that fits as well, in the form that fits.
        """
        for place in range(len(chosen)):
            chosen = self._plain(chosen, place)
        if len(chosen) != 1:
            return chosen
        same = [chosen, *(self._plain((form,), 0) for form in self._forms_like(chosen, 0).values())]
        return min(same, key=lambda names: (len(self.columns[names[0]]), -merit(self.singles[names[0]])))

    def _plain(self, names: tuple[str, ...], place: int) -> tuple[str, ...]:
        """The same effects, the one at a place in the plain form of its cause where that fits as well."""
        plain = (*names[:place], cause_of(names[place]), *names[place + 1 :])
        if plain[place] in self.columns and merit(self.fit(names)) - merit(self.fit(plain)) < FORM:
            return plain
        return names

    def ranked(self) -> list[str]:
        """Return each cause by the form that fits best, the best cause first."""
        best: dict[str, str] = {}
        for name in sorted(self.columns, key=lambda n: -merit(self.singles[n])):
            best.setdefault(cause_of(name), name)
        return list(best.values())

    def _better(self, chosen: tuple[str, ...]) -> tuple[str, ...] | None:
        """The best set with one effect more; None where the fit does not improve by enough.

        Two effects are searched over pairs with the best single ones; a third is added to the best pair.
        """
        before = self.fit(chosen) if chosen else None
        stems = [chosen] if len(chosen) != 1 else [(n,) for n in self._front()]
        sets = {tuple(sorted((*stem, n))) for stem in stems for n in self.columns if _is_new(n, stem)}
        fits = {s: self.fit(s) for s in sets}
        plausible = [s for s in sets if self._plausible(s, fits[s])]
        if not plausible:
            return None
        best = max(plausible, key=lambda s: merit(fits[s]))
        gained = merit(fits[best]) - (merit(before) if before is not None else 0.0)
        new = max(self.known.needed(n) for n in best if n not in chosen)
        allowance = LINEAR * score_candidates(before) if before is not None else 0.0
        return best if gained > new**2 + allowance**2 else None

    def _front(self) -> list[str]:
        return sorted(self.columns, key=lambda n: -merit(self.singles[n]))[: 2 * CONTENDERS]

    def _plausible(self, names: Sequence[str], fit: Fit) -> bool:
        ranges = [_range(self.signatures[c]) for n in names for c in self.columns[n]]
        sizes = zip(ranges, fit.sizes, fit.deviations, strict=True)
        return all(_within(*limits, size, deviation) for limits, size, deviation in sizes)

    def like(self, chosen: tuple[str, ...], place: int) -> tuple[str, ...]:
        """The other causes that fit as well in the place of a chosen effect, in whatever form; the best first."""
        return tuple(self._forms_like(chosen, place))

    def _forms_like(self, chosen: tuple[str, ...], place: int) -> dict[str, str]:
        """The causes of `like`, each with the form that fits best."""
        rest = chosen[:place] + chosen[place + 1 :]
        here = merit(self.fit(chosen))
        own = here - (merit(self.fit(rest)) if rest else 0.0)
        apart = max(APART, DOUBT * own)
        found: dict[str, float] = {}
        for other in self.columns:
            if _is_new(other, chosen):
                fit = self.fit((*rest, other))
                as_good = self._in_proportion(other, chosen[place], rest, merit(fit))
                if here - as_good < apart and self._plausible((*rest, other), fit):
                    found[other] = as_good
        forms: dict[str, str] = {}
        for name in sorted(found, key=lambda n: -found[n]):
            forms.setdefault(cause_of(name), name)
        return forms

    def _in_proportion(self, other: str, name: str, rest: Sequence[str], free: float) -> float:
        """The merit of another explanation: `free` with all its sizes free, or less where that would be unfair.

        An effect with more sizes can contain the chosen one as a special case: water of no weight in a line is a
        lag. It is then judged with its sizes in their typical proportions.
        """
        columns, simple = self.columns[other], self.columns[name]
        if len(columns) <= len(simple) or not self.evidence.contains(columns, simple):
            return free
        typical = [_parameter(self.signatures[c]).typical for c in columns]
        given = joined(self.columns, rest)
        base = merit(self.fit(rest)) if rest else 0.0
        return base + self.evidence.gain_along(columns, typical, given)

    def held_out_ratio(self, names: Sequence[str]) -> float:
        """Return the gain on blocks left out of the fit over the gain in sample."""
        fit = self.fit(names)
        return self.evidence.held_out_gain(joined(self.columns, names)) / max(fit.gain, 1e-9)

    def candidate(self, name: str) -> Candidate:
        """Return an effect as a candidate: its sizes, score and held-out ratio as the only explanation."""
        fit = self.singles[name]
        ratio, plausible = self.held_out_ratio((name,)), self._plausible((name,), fit)
        return Candidate(name, estimates(self.signatures, fit), self.score(name), ratio, plausible)


def _parameter(signature: Signature) -> Parameter:
    return FITTED[signature.effect].parameter(signature.parameter)


def _range(signature: Signature) -> tuple[float, float]:
    parameter = _parameter(signature)
    return parameter.low, parameter.high


def _is_new(name: str, chosen: Sequence[str]) -> bool:
    """Whether an effect has another cause than those chosen."""
    return cause_of(name) not in map(cause_of, chosen)


def estimates(signatures: Sequence[Signature], fit: Fit) -> tuple[Estimate, ...]:
    """Return the fitted sizes by the names of their parameters; the bound includes the error of the method."""
    found = zip(fit.columns, fit.sizes, fit.deviations, strict=True)
    return tuple(
        Estimate(signatures[c].parameter, float(s), 2.0 * float(np.hypot(d, METHOD * s))) for c, s, d in found
    )


def _within(low: float, high: float, size: float, deviation: float) -> bool:
    """Whether a size is plausible: in its range, or not significantly different from zero."""
    slack = SLIGHT * deviation
    return low - slack <= size <= high + slack or abs(size) <= slack
