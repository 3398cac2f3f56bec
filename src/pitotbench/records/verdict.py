"""The answer of a reconciliation, of one flight or of several."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pitotbench.records.calibration import Estimate

Kind = Literal["named", "one_of", "unknown", "no_gap"]
# Only these kinds explain the gap, so only they give a patch.
SURE: tuple[Kind, ...] = ("named", "one_of")
REPORTED_FROM = 0.02  # probability from which a further cause is reported beside the best one


@dataclass(frozen=True, slots=True)
class Check:
    """One deterministic check of the log, with what it found in `why`; a remark is no fault."""

    name: str
    status: Literal["passed", "failed", "skipped", "remark"]
    why: str


def where(phase: str, variable: str) -> str:
    """A phase of flight, or `over` a variable, or `throughout`."""
    return phase or (f"over {variable}" if variable else "throughout")


@dataclass(frozen=True, slots=True)
class Located:
    """A place of the gap: channel, phase of flight or variable, and significance in σ.

    Of phase and variable one is empty, or both.
    """

    channel: str
    phase: str
    variable: str
    significance: float

    @property
    def where(self) -> str:
        """The phase, or the variable over which the gap runs, or `throughout`."""
        return where(self.phase, self.variable)


@dataclass(frozen=True, slots=True)
class Candidate:
    """An effect of the table as an explanation of the gap; its sizes are in the table's units.

    `score` is its significance [σ], relative to null flights of this card. `probability` is that of
    its cause, given a gap; 1 for what is counted and not fitted. `times` are those at which an
    effect for a part of the flight begins and ends [s], by name.
    """

    name: str
    sizes: tuple[Estimate, ...]
    score: float
    probability: float = 1.0
    times: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Detectable:
    """The smallest size of an effect's parameter that half of all flights like this one show."""

    effect: str
    parameter: str
    size: float


@dataclass(frozen=True, slots=True)
class Closure:
    """The gap before and after, and its part of noise, as sums of squares over noise variance.

    `chance` is what sizes that were not fitted to this log leave on average, because they have
    errors of their own.
    """

    before: float
    after: float
    noise: float
    chance: float = 0.0

    @property
    def share(self) -> float:
        """The share of the explainable gap that is closed, 1 for all of it.

        That is (before − after)/(before − noise), 0 where all is as before.
        """
        return (self.before - self.after) / max(self.before - self.noise, 1e-9)


@dataclass(frozen=True, slots=True)
class FreeSize:
    """An unknown of a log itself, such as the scale of a vane, that lies far beyond its prior.

    `value` and `two_sigma` are in the unit of its channel, `prior` is the deviation that it has on
    a usual log: that of its prior, or of null flights where these show more.
    """

    name: str
    value: float
    two_sigma: float
    prior: float


@dataclass(frozen=True, slots=True)
class Gap:
    """One of the gaps of an answer, each fitted with all others.

    `part` is what a mechanic looks at, with its `probability`; empty for a formula. `causes` are
    those of the smallest set that holds the gap, the most probable first, and a single one where it
    is `named`. `part_named` says whether the part is. `closes` is the share of the explainable gap
    of the log with the largest gap that this one explains given the others, `closes_held_out` that
    in parts of the logs to which its size was not fitted.
    """

    part: str
    probability: float
    causes: tuple[Candidate, ...]
    named: bool
    part_named: bool
    closes: float
    closes_held_out: float


@dataclass(frozen=True, slots=True)
class Verdict:
    """The answer on one log or several.

    `gaps` are in the order of what each closes in parts of the logs left out. `candidates` are all
    causes as the only explanation, the most probable first. `probabilities` is that of each cause
    of the table, without a gap that the log shows as well; the causes may act together, so they do
    not sum to 1. `log_bayes_factor` is the logarithm of the Bayes factor of the largest gap against
    none. `remains` says whether something significant is left after the gaps. `doubts` are the
    checks that speak against them. `free` are unknowns of the logs far beyond their priors.
    """

    kind: Kind
    gaps: tuple[Gap, ...]
    candidates: tuple[Candidate, ...]
    located: tuple[Located, ...]
    checks: tuple[Check, ...]
    closure: Closure
    smallest_detectable: tuple[Detectable, ...]
    advice: tuple[str, ...]
    notes: tuple[str, ...] = ()
    closure_holdout: Closure | None = None
    probabilities: Mapping[str, float] = field(default_factory=dict)
    log_bayes_factor: float = 0.0
    remains: bool = False
    doubts: tuple[str, ...] = ()
    free: tuple[FreeSize, ...] = ()

    @property
    def explained(self) -> tuple[Gap, ...]:
        """The gaps with causes of the table; none where no cause is reported."""
        return tuple(gap for gap in self.gaps if gap.part) if self.kind in SURE else ()

    @property
    def effects(self) -> tuple[Candidate, ...]:
        """The most probable cause of each gap, in its best form."""
        return tuple(gap.causes[0] for gap in self.explained)

    @property
    def alternatives(self) -> tuple[tuple[str, ...], ...]:
        """For each of `effects`, the names of the others in the set that holds it."""
        return tuple(tuple(c.name for c in gap.causes[1:]) for gap in self.explained)

    @property
    def parts(self) -> dict[str, float]:
        """The probability of each reported part, the most probable first."""
        found: dict[str, float] = {}
        for gap in self.gaps:
            if gap.part:
                found[gap.part] = max(found.get(gap.part, 0.0), gap.probability)
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    @property
    def named_parts(self) -> tuple[str, ...]:
        """The parts that are named."""
        return tuple(dict.fromkeys(gap.part for gap in self.explained if gap.part_named))


@dataclass(frozen=True, slots=True)
class OwnSize:
    """The size of an effect that one flight shows by itself.

    `distance` [σ] is that from the size of the others, None where no other flight shows the effect.
    """

    effect: str
    size: Estimate
    distance: float | None


@dataclass(frozen=True, slots=True)
class JoinedFlight:
    """A flight of a reconciliation.

    `alone` and `causes` are the verdict and the named causes of this flight by itself,
    `log_bayes_factor` its own evidence for a gap. `closure` is by the sizes that all flights share,
    `left_out` by the sizes of the other flights. `own_sizes` are those that it shows of the shared
    effects.
    """

    log: str
    maneuver: str
    minutes: float
    alone: Kind
    causes: tuple[tuple[str, ...], ...]
    log_bayes_factor: float
    closure: Closure
    left_out: Closure | None = None
    own_sizes: tuple[OwnSize, ...] = ()
    null_flights: int = 0
