"""What a reconciliation shows of a gap: where it sits, what each effect took out of it, and what is left."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pitotbench.records.verdict import Closure, Verdict
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class GapMap:
    """Significance [σ] of the gap by channel (rows) and phase of flight or variable (columns), before and after
    what was named, (c, p) each; `threshold` is what null flights stay below."""

    channels: tuple[str, ...]
    places: tuple[str, ...]
    before: Array
    after: Array
    threshold: float


@dataclass(frozen=True, slots=True)
class Trace:
    """A residual channel over time [s]: measured less simulated, and what the named effects say of it, (n,) each,
    both without wind, error curve and sensor biases."""

    channel: str
    unit: str
    time: Array
    gap: Array
    explained: Array


@dataclass(frozen=True, slots=True)
class Step:
    """One bar of the waterfall: the sum of squares [noise units] that is left once an effect is added as well."""

    effect: str
    left: float


@dataclass(frozen=True, slots=True)
class History:
    """A quantity over the time [s] of a segment of the card: as measured, and as two simulators flew it."""

    quantity: str
    unit: str
    time: Array
    measured: Array
    simulated: Array
    patched: Array


@dataclass(frozen=True, slots=True)
class Feature:
    """A number that sums up a segment of the card, as measured and as flown again by the simulator without and with
    the patch; `deviation` is how far two flights of one airplane differ by chance."""

    segment: str
    name: str
    unit: str
    measured: float
    simulated: float
    patched: float
    deviation: float


@dataclass(frozen=True, slots=True)
class Tolerance:
    """Share of samples of the card flown again within a tolerance of the measured ones: before, with the patch, and
    between two flights of the patched simulator, which differ by gusts alone."""

    quantity: str
    unit: str
    half_width: float
    before: float
    after: float
    by_chance: float


@dataclass(frozen=True, slots=True)
class FlownAgain:
    """The card of a log flown again, or in `skipped` why it was not."""

    features: tuple[Feature, ...] = ()
    tolerances: tuple[Tolerance, ...] = ()
    histories: tuple[History, ...] = ()
    skipped: str = ""


@dataclass(frozen=True, slots=True)
class Round:
    """One look at the log with all that was named before in the model; `added` are the effects it names."""

    verdict: Verdict
    added: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Account:
    """All that a report of a reconciliation shows. `rounds[0].verdict` is the answer; `patch` the text of the
    patch; `flown` and `flown_holdout` the cards flown again; `closures` name each gap that was measured."""

    log: str
    aircraft: str
    holdout: str
    rounds: tuple[Round, ...]
    gap_map: GapMap
    waterfall: tuple[Step, ...]
    traces: tuple[Trace, ...]
    patch: str
    flown: FlownAgain = field(default_factory=FlownAgain)
    flown_holdout: FlownAgain = field(default_factory=FlownAgain)
    closures: Mapping[str, Closure] = field(default_factory=dict)
    null_flights: int = 0
