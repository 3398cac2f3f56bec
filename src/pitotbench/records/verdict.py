"""The answer of a reconciliation, of one flight or of several."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from pitotbench.records.calibration import Estimate

Kind = Literal["named", "one_of", "unknown", "no_gap"]
SURE: tuple[Kind, ...] = (
    "named",
    "one_of",
)  # only these kinds explain the gap, so only they give a patch


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
    """A place of the gap: channel, phase of flight or variable (one of them empty, or both),
    significance in σ.
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
    """The smallest size of an effect's parameter that a log like this one shows in half of all
    flights.
    """

    effect: str
    parameter: str
    size: float


@dataclass(frozen=True, slots=True)
class Closure:
    """The gap as sums of squares over noise variance: before, after, and the part that is noise
    alone.

    `chance` is what sizes that were not fitted to this log leave on average, because they have
    errors of their own.
    """

    before: float
    after: float
    noise: float
    chance: float = 0.0

    @property
    def share(self) -> float:
        """Explainable gap that is closed, (before − after)/(before − noise) (1 closed, 0 as
        before).
        """
        return (self.before - self.after) / max(self.before - self.noise, 1e-9)


@dataclass(frozen=True, slots=True)
class Verdict:
    """The answer of one pass over a log.

    `effects` are those named. `alternatives` holds, for each of them, the names of the effects that
    the log cannot distinguish from it. `candidates` are all single explanations, the best first.
    `probabilities` is that of each cause of the table, given a gap; the causes may act together, so
    they do not sum to 1. `parts` is that of each part of the airplane, its instruments or the
    world, the most probable first, and `named_parts` are those above the probability of a name.
    `log_bayes_factor` is the logarithm of the Bayes factor of a gap against none. `remains` says
    whether something significant is left beside the effects. `doubts` are the checks that speak
    against the effects, so that none of them is named. `changes` has a line for each change of the
    kind after the posterior's own answer: `named -> one_of: why`.
    """

    kind: Kind
    effects: tuple[Candidate, ...]
    alternatives: tuple[tuple[str, ...], ...]
    candidates: tuple[Candidate, ...]
    located: tuple[Located, ...]
    checks: tuple[Check, ...]
    closure: Closure
    smallest_detectable: tuple[Detectable, ...]
    advice: tuple[str, ...]
    notes: tuple[str, ...] = ()
    closure_holdout: Closure | None = None
    probabilities: Mapping[str, float] = field(default_factory=dict)
    parts: Mapping[str, float] = field(default_factory=dict)
    named_parts: tuple[str, ...] = ()
    log_bayes_factor: float = 0.0
    remains: bool = False
    doubts: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()


# One flight of several that were reconciled together: what it says alone, and how it agrees with
# the others.


@dataclass(frozen=True, slots=True)
class OwnSize:
    """The size of an effect that one flight shows by itself; `apart` [σ] is its distance from that
    of the others.

    `apart` is None where no other flight shows the effect.
    """

    effect: str
    size: Estimate
    apart: float | None


@dataclass(frozen=True, slots=True)
class JoinedFlight:
    """A flight of a reconciliation.

    `alone` and `causes` are the verdict and the named causes of this flight by itself,
    `probabilities` those of its causes, `log_bayes_factor` its own evidence for a gap. `closure` is
    by the sizes that all flights share, `left_out` by the sizes of the other flights. `own_sizes`
    are those that it shows of the shared effects.
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
    probabilities: Mapping[str, float] = field(default_factory=dict)
