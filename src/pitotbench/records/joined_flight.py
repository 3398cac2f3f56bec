"""One flight of several that were reconciled together: what it says alone, and how it agrees with the others."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Closure, Kind


@dataclass(frozen=True, slots=True)
class OwnSize:
    """The size of an effect that one flight shows by itself; `apart` [σ] is its distance from that of the others.

    `apart` is None where no other flight shows the effect.
    """

    effect: str
    size: Estimate
    apart: float | None


@dataclass(frozen=True, slots=True)
class JoinedFlight:
    """A flight of a reconciliation.

    `alone` and `causes` are the verdict and the named causes of this flight by itself, `probabilities` those of its
    causes, `log_bayes_factor` its own evidence for a gap. `closure` is by the sizes that all flights share,
    `left_out` by the sizes of the other flights. `own_sizes` are those that it shows of the shared effects.
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
