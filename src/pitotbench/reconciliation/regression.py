"""Fit all gaps of some logs at once: which effects act, how probable each is, and how large."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, reduce
from operator import add

import numpy as np
from scipy.special import expit, logsumexp

from pitotbench.effects import FORMULAS, effect_of
from pitotbench.effects.effect import Parameter
from pitotbench.estimation.information import Information, Marginal
from pitotbench.reconciliation.discrepancies import Discrepancy, discrepancy_of
from pitotbench.reconciliation.equations import (
    NormalEquations,
    whitened_equations,
    with_form_error,
)
from pitotbench.reconciliation.evidence import (
    NEGLIGIBLE,
    evidence_beyond_floor,
    prior_of,
    significance,
    weigh,
    widest,
)
from pitotbench.reconciliation.flight_path import is_without_vanes
from pitotbench.reconciliation.layout import (
    Layout,
)
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import NullDistribution, size_label
from pitotbench.reconciliation.null_learning import wander_of
from pitotbench.reconciliation.pitch_factor import around_sizes, without_factor
from pitotbench.reconciliation.sets import FittedHypothesis, Hypothesis, WeighedSet, weighed_sets
from pitotbench.reconciliation.signatures import (
    FITTED,
    Key,
    cause_of,
    columns_of,
    lasts,
    parameter_of,
    searched_shapes,
)
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.units import Array

# One regression. Its columns are the sizes of the effects of the table in all their forms, the
# terms of formulas, and the cells, which are smooth and stand for a cause that nobody has written
# down. Free parameters and the floor of null flights are eliminated in each log; logs are blocks
# that share the sizes of effects, and each has cells of its own. A gap is an effect that is added
# because no other explains the logs better beside all those that are in the fit; then each is
# weighed again given the others. What a set of hypotheses is worth is its marginal likelihood,
# raised to a power that depends on this gap alone: a second effect of 30 sigma is as well seen
# beside a first of 1,700.


@dataclass(frozen=True, slots=True)
class Block:
    """A log as a block of the regression: its layout, normal equations, and evidence.

    `beyond` is the evidence beyond the floor for its signatures and then its examined cells,
    `pulled` that before the factor of the pitching terms is integrated out. `noise` is that of null
    flights at the level of the log. `stands_out`: something does beside no gap.
    """

    layout: Layout
    noise: NoiseModel
    null: NullDistribution
    equations: NormalEquations
    pulled: Information
    beyond: Information
    stands_out: bool = True

    @property
    def keys(self) -> tuple[Key, ...]:
        """The sizes that the log shows, each as the effect and its parameter."""
        return tuple((s.effect, s.parameter) for s in self.layout.signatures)

    @property
    def channels(self) -> dict[Key, str]:
        """The channel that each size moves most, in units of its noise."""
        moved = [
            np.sum((s.column / self.noise.deviations) ** 2, axis=0) for s in self.layout.signatures
        ]
        names = [self.layout.residuals.names[int(np.argmax(power))] for power in moved]
        return dict(zip(self.keys, names, strict=True))

    @property
    def cells(self) -> range:
        """The columns of the examined cells in the evidence."""
        return range(len(self.layout.signatures), len(self.beyond.inner) - 1)

    def around_sizes(self, columns: Sequence[int], deviations: Array) -> Information:
        """Return the evidence of the sizes of some columns, freed of the factor.

        The log shows them times the factor of the pitching terms. The deviations are those of their
        priors, (k,).
        """
        shown = np.zeros(len(self.beyond.inner) - 1)
        np.add.at(shown, [*columns], self.beyond.posterior(columns, deviations).mean)
        pitching = [i for i, c in enumerate(self.channels.values()) if c == "pitch_acceleration"]
        labels = [size_label(*key) for key in self.keys]
        return around_sizes(self.pulled, labels, self.null.scores.pitch_factor, pitching, shown)


def block_of(layout: Layout, noise: NoiseModel, null: NullDistribution) -> Block:
    """Return a log that is laid out as a block of the regression."""
    equations = whitened_equations(layout, noise)
    wander = wander_of(null, layout.residuals.names)
    pulled = evidence_beyond_floor(layout, equations, null.scores, wander)
    labels = [size_label(s.effect, s.parameter) for s in layout.signatures]
    beyond = without_factor(pulled, labels, null.scores.pitch_factor)
    stands_out = stands_out_beside(layout, equations, null)
    return Block(layout, noise, null, equations, pulled, beyond, stands_out)


def stands_out_beside(
    layout: Layout, equations: NormalEquations, null: NullDistribution, given: Sequence[int] = ()
) -> bool:
    """Return whether a cell or an effect, beside `given` columns, scores more than on null flights.

    A sum of many small scores is no gap that anyone sees. Null flights do not tell what an effect
    for a part of the flight scores. Without them the Bayes factor alone decides.
    """
    scores = equations.scores(layout.examined, given)
    cells = (
        null.scores.of_cell(cell, float(score))
        for (_, cell), score in zip(layout.places, scores, strict=True)
    )
    effects = (
        null.scores.of_effect(name, significance(equations.fit(own, given)))
        for name, own in columns_of(layout.signatures).items()
        if name in FITTED and lasts(name) and set(given).isdisjoint(own)
    )
    return (
        null.flights == 0
        or any(abs(score) > null.cell_threshold for score in cells)
        or any(score > null.threshold for score in effects)
    )


@dataclass(frozen=True, slots=True)
class FoundGap:
    """A gap of the logs beside all others.

    `member` explains it best. `forms` is the probability of each hypothesis, given this gap; a term
    of a formula goes by the formula and the term. `unknown` is that of smooth cells, whose largest
    `place` is a channel, a family of channels or `all`. `held_out` is the fall of the sum of
    squares in parts of the logs to which the sizes were not fitted, over that in the fit; of the
    whole set for terms of one moment or force that were weighed together; `near` are then the sets
    that are nearly as probable as theirs, which is the first.
    """

    member: FittedHypothesis
    log_bayes_factor: float
    forms: Mapping[str, float] = field(default_factory=dict)
    unknown: float = 0.0
    place: str = ""
    held_out: float = 0.0
    near: tuple[WeighedSet, ...] = ()

    @property
    def of_set(self) -> bool:
        """Whether the gap is a member of a set of one moment or force, weighed together."""
        return any(len(each.names) > 1 for each in self.near[:1])

    @property
    def probability(self) -> float:
        """That there is such a gap, which was as probable as none before the logs were seen."""
        return float(expit(self.log_bayes_factor))

    @property
    def causes(self) -> dict[str, float]:
        """The probability of each cause of the table, in any form, the most probable first."""
        found: dict[str, float] = {}
        for name, p in self.forms.items():
            if not is_term(name):
                found[cause_of(name)] = found.get(cause_of(name), 0.0) + p
        return dict(sorted(found.items(), key=lambda item: -item[1]))


# between a formula and its term, and between an effect and a size of it that is looked for alone
SEPARATOR = "|"
CHANNEL_GROUPS = ("airspeed", "attitude", "specific_force", "acceleration", "engine", "turning")
LIKE_WITHOUT_VANES = [n for n, effect in FITTED.items() if effect.like_without_vanes and lasts(n)]
NOTHING = FittedHypothesis("", (), np.zeros(0))


def is_term(name: str) -> bool:
    """Whether a hypothesis is a term of a formula."""
    return effect_and_size(name)[0] in FORMULAS


def effect_and_size(name: str) -> tuple[str, str]:
    """Return the formula and the term of a hypothesis, or the effect and its size, if one alone."""
    formula, _, term = name.partition(SEPARATOR)
    return formula, term


def keys_of(name: str, keys: Sequence[Key]) -> list[Key]:
    """Return the sizes of a hypothesis among some."""
    return [key for key in keys if name in (key[0], SEPARATOR.join(key))]


class Regression:
    """The regression of some logs. Raises ValueError without a log.

    Sizes of an effect are the same in all logs, those of the air as well: the logs should be of one
    day.
    """

    def __init__(self, blocks: Sequence[Block]) -> None:
        if not blocks:
            raise ValueError("no log to explain")
        self.blocks = blocks
        self.keys = tuple(dict.fromkeys(key for block in blocks for key in block.keys))
        self._of_block = self._places()
        self.evidence = self._joined(block.beyond for block in blocks)
        self.columns: dict[str, tuple[int, ...]] = {}
        for i, (effect, parameter) in enumerate(self.keys):
            if effect in FORMULAS or FITTED[effect].by_size:
                self.columns[SEPARATOR.join((effect, parameter))] = (i,)
            elif not FITTED[effect].one_model_with:
                self.columns[effect] = (*self.columns.get(effect, ()), i)
        self._priors = {
            name: prior_of([self.parameter(self.keys[i]) for i in own])
            for name, own in self.columns.items()
        }
        self._log_priors = _log_priors(list(self.columns))

    def parameter(self, key: Key) -> Parameter:
        """Return the parameter of a size, for the airplane of the logs."""
        return parameter_of(self.blocks[0].layout.reference, key)

    def _places(self) -> list[list[int]]:
        """For each log the columns of its sizes and cells in the evidence of all logs."""
        place = {key: i for i, key in enumerate(self.keys)}
        places, first = [], len(place)
        for block in self.blocks:
            cells = len(block.layout.places)
            places.append([*(place[key] for key in block.keys), *range(first, first + cells)])
            first += cells
        return places

    def _joined(self, evidence: Iterable[Information]) -> Information:
        """The evidence of all logs."""
        count = 1 + max(max(own, default=-1) for own in self._of_block)
        pairs = zip(evidence, self._of_block, strict=True)
        return reduce(add, (each.placed(own, count) for each, own in pairs))

    def _without_pull(self, columns: Sequence[int], deviations: Array) -> Information:
        """The evidence of the sizes of some columns, freed of the factor of the pitching terms."""
        found = list[Information]()
        for block, own in zip(self.blocks, self._of_block, strict=True):
            shown = [i for i, column in enumerate(columns) if column in own]
            places = [own.index(columns[i]) for i in shown]
            found.append(block.around_sizes(places, deviations[shown]))
        return self._joined(found)

    @cached_property
    def _discrepancies(self) -> list[Discrepancy]:
        """The smooth discrepancies of each log: of one channel, of a family of them, and of all.

        Who asks for sizes alone needs none.
        """
        power, found = np.diag(self.evidence.inner), list[Discrepancy]()
        for own, block in zip(self._of_block, self.blocks, strict=True):
            cells: dict[str, list[int]] = {}
            by_group: dict[str, list[int]] = {}
            for column, (_, cell) in zip(own[len(block.keys) :], block.layout.places, strict=True):
                if power[column] > NEGLIGIBLE:
                    cells.setdefault(cell.channel, []).append(column)
                    by_group.setdefault(_channel_group(cell.channel), []).append(column)
            shown = {group: own for group, own in by_group.items() if group in CHANNEL_GROUPS}
            whole = [column for each in cells.values() for column in each]
            groups = [(c, own, 0.5 / len(cells)) for c, own in cells.items()]
            groups += [(group, own, 0.25 / len(shown)) for group, own in shown.items()]
            for place, columns, prior in [*groups, ("all", whole, 0.25)]:
                own_prior = prior / len(self.blocks)
                found.append(discrepancy_of(place, columns, self.evidence, own_prior))
        return found

    def fit(self, without: Iterable[str] = ()) -> tuple[list[FoundGap], FoundGap]:
        """Return the gaps that the logs show, and what is left beside them.

        The best hypothesis beside all others is added; then each is weighed again given the others,
        and left out where it is not needed. Hypotheses `without` which to do take no part.
        """
        gaps, refused = list[FoundGap](), set(without)
        for _ in range(THRESHOLDS.weighings_most):
            gaps = self._with_more(gaps, refused)
            before = [gap.member.name for gap in gaps]
            gaps = self._with_sets(self._weighed_again(gaps, refused), set(without))
            if [gap.member.name for gap in gaps] == before:
                break
        left = self.beside([gap.member for gap in gaps], refused)
        return self._with_shared_forms(_by_effect(gaps)), _by_effect([left])[0]

    def _with_shared_forms(self, gaps: Sequence[FoundGap]) -> list[FoundGap]:
        """Gaps in which the effects that no log without vanes separates are equally probable.

        The rest that the prediction leaves in each force would decide between them.
        """
        if not all(is_without_vanes(block.layout.track) for block in self.blocks):
            return list(gaps)
        shared = list[FoundGap]()
        for gap in gaps:
            alike = [n for n in LIKE_WITHOUT_VANES if n in gap.forms]
            mean = sum(gap.forms[name] for name in alike) / max(1, len(alike))
            same = dict.fromkeys(alike, mean) if gap.member.name in alike else {}
            shared.append(replace(gap, forms={**gap.forms, **same}))
        return shared

    def _with_more(self, gaps: list[FoundGap], refused: set[str]) -> list[FoundGap]:
        """Gaps with those that the logs show beside them; what explains nothing is `refused`."""
        gaps = list(gaps)
        for _ in range(THRESHOLDS.gaps_most - len(gaps)):
            found = self.beside([gap.member for gap in gaps], refused)
            if self._is_taken(found):
                gaps.append(found)
            elif not self.shows(found) or found.unknown > THRESHOLDS.likely:
                break
            else:
                refused.add(found.member.name)
        return gaps

    def _weighed_again(self, gaps: list[FoundGap], refused: set[str]) -> list[FoundGap]:
        """Return gaps each weighed again given the others, less those that are not needed.

        Those of a set were weighed together.
        """
        for gap in [gap for gap in gaps if not gap.of_set]:
            others = [each for each in gaps if each is not gap]
            again = self.beside([each.member for each in others], refused)
            taken = self._is_taken(again)
            gaps = [again if each is gap else each for each in gaps] if taken else others
        return gaps

    def _with_sets(self, gaps: list[FoundGap], without: set[str]) -> list[FoundGap]:
        """Gaps with the most probable set of each moment and each force in which there is one."""
        for names in self._axes.values():
            own = [gap for gap in gaps if gap.member.name in names]
            if own:
                gaps = self._with_best_set(gaps, own, names - without)
        return gaps

    def _with_best_set(
        self, gaps: list[FoundGap], own: list[FoundGap], names: frozenset[str]
    ) -> list[FoundGap]:
        """Gaps with the most probable set of one moment or force in place of their `own` of it.

        A set of more members has to bring as much for each as a gap does, and it has to hold in
        parts of the logs left out: parts that hardly excite a term say nothing of it alone.
        """
        others = [gap for gap in gaps if gap not in own]
        rest = [gap.member for gap in others]
        left = self.evidence.given([c for m in rest for c in m.columns], _deviations(rest))[0]
        taken = {_cause(member.name) for member in rest}
        hypotheses = [self._hypothesis(left, n) for n in sorted(names) if _cause(n) not in taken]
        sets = weighed_sets(left, hypotheses, THRESHOLDS.set_most)
        now = {gap.member.name for gap in own}
        held = next((each for each in sets if set(each.names) == now), None)
        if held is None:
            return gaps
        # One hypothesis against another is the question of its gap, weighed with the temper.
        sets = [each for each in sets if each is held or len(each.names + held.names) > 2]
        best = next((s for s in sets if s is held or self._is_better(rest, s, held)), held)
        members = best.members
        least = best.log_weight - THRESHOLDS.set_near
        near = (best, *(s for s in sets if s is not best and s.log_weight > least))
        if len(members) < 2 and best is held:
            return [*others, *(replace(gap, near=near) for gap in own)]
        ratio, alone = self.held_out(rest, members), {gap.member.name: gap for gap in own}
        if best is not held:
            each_beside = ([*rest, *(m for m in members if m is not member)] for member in members)
            alone = dict(zip(best.names, map(self.beside, each_beside), strict=True))
        found = [
            replace(
                alone[member.name],
                member=member,
                forms=_forms_of_sets(alone[member.name].forms, member.name, near, names),
                held_out=ratio,
                near=near,
            )
            for member in members
        ]
        return [*others, *found]

    def _hypothesis(self, evidence: Information, name: str) -> Hypothesis:
        """A hypothesis as one of a set, with what its form leaves open where it acts alone."""
        own = self.columns[name]
        known = 1.0 - THRESHOLDS.prior_of_none - THRESHOLDS.prior_of_unknown
        odds = self._log_priors[name] + np.log(known / THRESHOLDS.prior_of_none)
        alone = self._member(evidence, name)[1]
        left_open = alone.columns[len(own) :], alone.deviations[len(own) :]
        return Hypothesis(name, _cause(name), own, self._priors[name], float(odds), left_open)

    def _is_better(
        self, rest: Sequence[FittedHypothesis], other: WeighedSet, held: WeighedSet
    ) -> bool:
        """Whether a set is more probable than the one that is held.

        One of more members also has to hold better in parts of the logs left out.
        """
        more = max(0, len(other.names) - len(held.names))
        if other.log_weight <= held.log_weight + self.least_bayes_factor * more:
            return False
        if more == 0:
            return True
        held_out, inside = self._gains(rest, other.members)
        before, _ = self._gains(rest, held.members)
        return held_out > max(before, THRESHOLDS.held_out_least * inside)

    @cached_property
    def _axes(self) -> dict[str, frozenset[str]]:
        """The effects of the whole flight by the force or the moment that they move most."""
        channels = {k: c for block in reversed(self.blocks) for k, c in block.channels.items()}
        found: dict[str, set[str]] = {}
        for name, columns in self.columns.items():
            channel = channels.get(self.keys[columns[0]], "")
            if (
                not is_term(name)
                and lasts(effect_and_size(name)[0])
                and _is_force_or_moment(channel)
            ):
                found.setdefault(channel, set()).add(name)
        return {channel: frozenset(names) for channel, names in found.items()}

    def shows(self, found: FoundGap) -> bool:
        """Whether a gap is beyond what null flights show."""
        return found.log_bayes_factor >= self.least_bayes_factor

    def _is_taken(self, found: FoundGap) -> bool:
        """Whether a gap is explained: by posterior odds, and in parts of the logs left out."""
        known = self.shows(found) and found.unknown <= THRESHOLDS.likely
        return known and found.held_out >= THRESHOLDS.held_out_least

    @property
    def least_bayes_factor(self) -> float:
        """ln of the Bayes factor from which the logs show a gap, infinite where none stands out.

        A log that does not takes nothing from those that do.
        """
        return max(
            (block.null.gap_bayes_factor for block in self.blocks if block.stands_out),
            default=np.inf,
        )

    def beside(
        self, members: Sequence[FittedHypothesis], refused: frozenset[str] | set[str] = frozenset()
    ) -> FoundGap:
        """Return the gap that the logs show beside a fit's members, however improbable."""
        columns = [c for member in members for c in member.columns]
        marginal = self.evidence.marginal(columns, _deviations(members))
        taken = {_cause(member.name) for member in members}
        names = [
            n
            for n in self.columns
            if _cause(n) not in taken and refused.isdisjoint((n, effect_and_size(n)[0]))
        ]
        weights, unmodeled, _ = self._weighed(marginal, names)
        every = [*weights.values(), *unmodeled.values()]
        log_bayes_factor = float(logsumexp(every) - np.log(THRESHOLDS.prior_of_none))
        power = tempering_power(log_bayes_factor)
        weights, unmodeled, found = self._weighed(marginal.tempered(power), names)
        whole = float(logsumexp([*weights.values(), *unmodeled.values()]))
        member = found[max(weights, key=lambda name: weights[name])] if weights else NOTHING
        return FoundGap(
            member,
            log_bayes_factor,
            {name: float(np.exp(value - whole)) for name, value in weights.items()},
            float(np.exp(logsumexp([*unmodeled.values()]) - whole)),
            max(unmodeled, key=lambda place: unmodeled[place]) if unmodeled else "",
            self.held_out(members, [member]),
        )

    def _weighed(
        self, marginal: Marginal, names: Sequence[str]
    ) -> tuple[dict[str, float], dict[str, float], dict[str, FittedHypothesis]]:
        """Return ln of prior times evidence by hypothesis and by place, and hypotheses as members.

        A hypothesis may have an unmodeled discrepancy beside it, if it is among the best; by place
        stand the discrepancies alone.
        """
        known = np.log1p(-THRESHOLDS.prior_of_none - THRESHOLDS.prior_of_unknown)
        unknown, share = np.log(THRESHOLDS.prior_of_unknown), THRESHOLDS.prior_of_rest
        values, members = dict[str, float](), dict[str, FittedHypothesis]()
        for name in names:
            prior = self._log_priors[name] + (unknown if is_term(name) else known)
            weighed, member = self._member(marginal.left, name)
            values[name], members[name] = float(prior + weighed), member
        best = sorted(values, key=lambda n: -values[n])[: THRESHOLDS.rested]
        alone, *beside = self._of_discrepancies(marginal, [NOTHING, *(members[n] for n in best)])
        for name, each in zip(best, beside, strict=True):
            left = np.log(share) + logsumexp([*each.values()])
            values[name] += float(np.logaddexp(np.log1p(-share), left))
        half = unknown + (np.log(0.5) if any(map(is_term, names)) else 0.0)
        return values, {place: value + half for place, value in alone.items()}, members

    def _of_discrepancies(
        self, marginal: Marginal, members: Sequence[FittedHypothesis]
    ) -> list[dict[str, float]]:
        """Return ln of prior times evidence of each place's discrepancies beside a hypothesis.

        There is a mapping for each hypothesis.
        """
        found: list[dict[str, float]] = [{} for _ in members]
        hypotheses = [(member.columns, member.deviations) for member in members]
        for each in self._discrepancies:
            for places, value in zip(found, each.log_evidences(marginal, hypotheses), strict=True):
                places[each.place] = float(np.logaddexp(places.get(each.place, -np.inf), value))
        return found

    def _member(self, evidence: Information, name: str) -> tuple[float, FittedHypothesis]:
        """The logarithm of the evidence of a hypothesis, and it as a member of a fit.

        What its form leaves open are small columns, in proportion to its size. With even odds there
        is nothing of them, so that an effect is not behind another one whose form leaves none open.
        """
        own, prior = self.columns[name], self._priors[name]
        plain = weigh(evidence, own, prior)
        columns, deviations = list[int](), list[float]()
        share = min(1.0, float(np.max(np.abs(plain.sizes) / prior.typical)))
        for other in () if is_term(name) else FITTED[effect_and_size(name)[0]].left_open:
            columns += self.columns.get(other, ())
            if other in self.columns:
                deviations += (THRESHOLDS.open_share * share * self._priors[other].typical).tolist()
        if not columns:
            return plain.log_evidence, FittedHypothesis(name, own, plain.deviations)
        bare, extra = evidence.given(columns, deviations, own)
        opened = weigh(bare, range(len(own)), prior)
        member = FittedHypothesis(
            name, (*own, *columns), np.array([*opened.deviations, *deviations])
        )
        both = np.logaddexp(plain.log_evidence, opened.log_evidence + extra) - np.log(2.0)
        return float(both), member

    def of_typical_size(self, name: str) -> FittedHypothesis:
        """A hypothesis as a member of a fit whose sizes are as large as is typical."""
        return FittedHypothesis(name, self.columns[name], self._priors[name].typical)

    def held_out(
        self, members: Sequence[FittedHypothesis], new: Sequence[FittedHypothesis]
    ) -> float:
        """Return the share of their gain that some hypotheses keep in parts of the logs left out.

        A gain is the fall of the sum of squares beside the other members.
        """
        held, inside = self._gains(members, new)
        return held / max(inside, NEGLIGIBLE)

    def _gains(
        self, members: Sequence[FittedHypothesis], new: Sequence[FittedHypothesis]
    ) -> tuple[float, float]:
        """Return the falls of the sum of squares in parts left out and in the fit, by `new`.

        The hypotheses are fitted beside the `members`.
        """
        held = inside = 0.0
        for block in self.blocks:
            own = self.shown_columns(block, new)
            given = self.shown_columns(block, members)
            if own:
                held += block.equations.held_out_gain(own, given)
                inside += block.equations.fit(own, given).gain
        return held, inside

    def shown_columns(self, block: Block, members: Sequence[FittedHypothesis]) -> list[int]:
        """Return the columns of some members' sizes in a block, without those left open.

        A hypothesis that has no columns yet has those of all its sizes.
        """
        own = [
            key
            for m in members
            for key in keys_of(m.name, block.keys)
            if not m.columns or self.keys.index(key) in m.columns
        ]
        return [block.keys.index(key) for key in own]

    def sizes(self, members: Sequence[FittedHypothesis], freed: bool = False) -> "Sizes":
        """Return the sizes of a fit's members, then those that their forms leave open.

        All are fitted at once. A size that is both is the sum. The sizes are as the logs show them,
        or `freed` of the factor that each log gives all terms of the pitching moment.
        """
        columns = [c for member in members for c in member.columns]
        evidence = self._without_pull(columns, _deviations(members)) if freed else self.evidence
        found = evidence.posterior(columns, _deviations(members))
        own = [c for m in members for c in m.columns if keys_of(m.name, [self.keys[c]])]
        kept = list(dict.fromkeys([*own, *columns]))
        sums = np.equal.outer(kept, columns).astype(np.float64)
        return Sizes(
            tuple(self.keys[c] for c in kept), sums @ found.mean, sums @ found.covariance @ sums.T
        )

    def shown_alone(self, numbers: Sequence[int], members: Sequence[FittedHypothesis]) -> "Sizes":
        """Return the sizes of the members that some of the logs show, by their numbers.

        The prior is as wide as a size can be, so that a log that does not show an effect says
        nothing of it.
        """
        kept = Regression([self.blocks[i] for i in numbers])
        keys = [k for m in members for k in keys_of(m.name, kept.keys)]
        wide = [widest(self.parameter(key)) for key in keys]
        found = kept.evidence.posterior([kept.keys.index(key) for key in keys], wide)
        return Sizes(tuple(keys), found.mean, found.covariance)


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes of effects: their keys, values, (k,), and covariance, (k, k)."""

    keys: tuple[Key, ...]
    values: Array
    covariance: Array

    def by_key(self) -> dict[Key, float]:
        """Return each size by its key."""
        return dict(zip(self.keys, self.values.tolist(), strict=True))

    def among(self, keys: Sequence[Key]) -> "Sizes":
        """Return those of some keys, in the order of these."""
        places = [self.keys.index(key) for key in keys if key in self.keys]
        return Sizes(
            tuple(self.keys[i] for i in places),
            self.values[places],
            self.covariance[np.ix_(places, places)],
        )

    def widened(self) -> "Sizes":
        """Return the sizes with the error that another log's form and the method add to each."""
        return replace(self, covariance=with_form_error(self.covariance, self.values.tolist()))


def _deviations(members: Sequence[FittedHypothesis]) -> Array:
    return np.concatenate([np.zeros(0), *(member.deviations for member in members)])


def _cause(name: str) -> str:
    """The cause of a hypothesis, with its size where it is looked for alone."""
    effect, size = effect_and_size(name)
    if is_term(name) or not name:
        return name
    return SEPARATOR.join(filter(None, (cause_of(effect), size)))


def _by_effect(gaps: Sequence[FoundGap]) -> list[FoundGap]:
    """Return gaps by effects and terms, those of one effect's sizes merged into one.

    The merged gap goes by the size with the most evidence.
    """
    found: dict[str, list[FoundGap]] = {}
    for gap in sorted(gaps, key=lambda gap: -gap.log_bayes_factor):
        found.setdefault(_whole(gap.member.name), []).append(gap)
    return [_merged(name, own) for name, own in found.items()]


def _merged(name: str, gaps: Sequence[FoundGap]) -> FoundGap:
    """Gaps of the sizes of one effect as one, the first of them with all their columns."""
    forms: dict[str, float] = {}
    for form, p in gaps[0].forms.items():
        forms[_whole(form)] = forms.get(_whole(form), 0.0) + p
    columns = tuple(c for gap in gaps for c in gap.member.columns)
    member = FittedHypothesis(name, columns, _deviations([gap.member for gap in gaps]))
    return replace(gaps[0], member=member, forms=forms)


def _whole(name: str) -> str:
    """The effect of a hypothesis with all its sizes; a term stays what it is."""
    return name if is_term(name) else effect_and_size(name)[0]


def _forms_of_sets(
    forms: Mapping[str, float],
    name: str,
    near: Sequence[WeighedSet],
    names: frozenset[str],
) -> dict[str, float]:
    """Return each hypothesis' probability in the place of one member of a set.

    What those of its moment or force have together is shared by the sets that are nearly as
    probable as the best.
    """
    found = {form: p for form, p in forms.items() if form not in names}
    whole = sum(p for form, p in forms.items() if form in names)
    for each, weight in zip(near, whole * shares_of(near), strict=True):
        places = [name] if name in each.names else [n for n in each.names if n not in near[0].names]
        for place in places or [name]:
            found[place] = found.get(place, 0.0) + float(weight) / max(1, len(places))
    return found


def shares_of(near: Sequence[WeighedSet]) -> Array:
    """The probabilities of sets that are nearly as probable as the first."""
    weights = np.exp(np.array([each.log_weight for each in near]) - near[0].log_weight)
    return np.asarray(weights / weights.sum())


def _is_force_or_moment(channel: str) -> bool:
    """Whether a channel is a component of the specific force or of the angular acceleration."""
    return channel.startswith("specific_force") or channel.endswith("_acceleration")


def _channel_group(channel: str) -> str:
    for group in ("airspeed", "attitude", "specific_force"):
        if channel.startswith(group):
            return group
    if channel.startswith("acceleration"):
        return "acceleration"
    if channel.endswith("_acceleration"):
        return "turning"
    return "engine" if channel.split("_")[-1] in ("left", "right", "split") else channel


def _log_priors(names: Sequence[str]) -> dict[str, float]:
    """Return ln of each hypothesis' prior: by part, then cause in the part, then form.

    Effects and terms have one each for themselves. Most causes act for the whole flight. Of the
    forms that do, the plain one is as probable as all others. Each shape that is searched for has
    its price.
    """
    effects = [name for name in names if not is_term(name)]
    causes = dict.fromkeys(map(_cause, effects))
    parts = [effect_of(effect_and_size(cause)[0]).part for cause in causes]
    found = {
        name: -float(np.log(len(names) - len(effects))) - np.log(2.0)
        for name in names
        if is_term(name)
    }
    for name in effects:
        cause, effect = _cause(name), effect_and_size(name)[0]
        part = effect_of(cause_of(effect)).part
        forms = [each for each in effects if _cause(each) == cause]
        whole = [each for each in forms if lasts(effect_and_size(each)[0])]
        in_time = (THRESHOLDS.prior_of_time if whole else 1.0) if len(whole) < len(forms) else 0.0
        if not lasts(effect):
            share = in_time / (len(forms) - len(whole))
        elif len(whole) == 1:
            share = 1.0 - in_time
        else:
            plain = name == cause
            share = (1.0 - in_time) * 0.5 / (1 if plain else len(whole) - (cause in whole))
        price = THRESHOLDS.search_penalty * len(searched_shapes(FITTED[effect]))
        found[name] = float(np.log(share / len(set(parts)) / parts.count(part))) - price
    return found


def tempering_power(log_bayes_factor: float) -> float:
    """Return the power 1 / (1 + τ²χ²) to which the likelihood of a gap is raised.

    χ² is twice the logarithm of the Bayes factor of this gap beside the others. The likelihood
    takes the table for exact, but a signature that is wrong in an unknown direction makes it err in
    proportion to χ². So beyond 1/τ² a hypothesis is preferred by its share of the gap, however
    strong the gap is. Source: the coarsened posterior of Miller and Dunson (2019); τ is estimated
    on development logs.
    """
    return 1.0 / (1.0 + 2.0 * THRESHOLDS.table_error**2 * max(0.0, log_bayes_factor))
