"""What a reconciliation says: where simulation and measurement disagree, because of what, and how sure that is."""

from dataclasses import dataclass
from typing import Literal

from pitotbench.records.calibration import Estimate

Kind = Literal["named", "one_of", "unknown", "no_gap"]
SURE: tuple[Kind, ...] = ("named", "one_of")  # what does not explain the gap is no patch


@dataclass(frozen=True, slots=True)
class Check:
    """One deterministic look at the log: `status` is passed, failed or skipped; `why` is a sentence."""

    name: str
    status: Literal["passed", "failed", "skipped"]
    why: str


def where(phase: str, variable: str) -> str:
    """A phase of flight, or `over` a variable, or `throughout`."""
    return phase or (f"over {variable}" if variable else "throughout")


@dataclass(frozen=True, slots=True)
class Located:
    """A place of the gap: channel, phase of flight or variable (one of them empty, or both), significance in σ."""

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
    """An effect of the table as an explanation: its sizes in the table's units, its score (significance in σ after
    what is known of this card), held-out over in-sample gain, and whether its sizes are plausible."""

    name: str
    sizes: tuple[Estimate, ...]
    score: float
    held_out_ratio: float
    plausible: bool


@dataclass(frozen=True, slots=True)
class Detectable:
    """The smallest size of an effect's parameter that this log would have shown."""

    effect: str
    parameter: str
    size: float


@dataclass(frozen=True, slots=True)
class Closure:
    """The gap as sums of squares in units of the noise: before, after, and what noise alone leaves."""

    before: float
    after: float
    noise: float

    @property
    def share(self) -> float:
        """Explainable gap that is closed, (before − after)/(before − noise) (1 closed, 0 as before)."""
        return (self.before - self.after) / max(self.before - self.noise, 1e-9)


@dataclass(frozen=True, slots=True)
class Verdict:
    """The answer. `effects` are those named; `alternatives` holds, for each of them, the names that the log does
    not tell from it (empty where it does); `candidates` all single explanations, best first."""

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
