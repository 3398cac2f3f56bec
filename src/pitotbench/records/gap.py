"""The gap of a reconciliation: its map, the part of each effect, the rest, and its formula."""

from dataclasses import dataclass, field

from pitotbench.records import Shown
from pitotbench.records.calibration import Estimate
from pitotbench.records.forecast import BriefedLeg
from pitotbench.records.verdict import Gap, JoinedFlight, Verdict
from pitotbench.units import Array, Booleans


@dataclass(frozen=True, slots=True)
class FormulaTerm:
    """A term of a formula.

    `effect` and `size` are the entry of a case file: the name of the formula's effect, and the
    coefficient with its bound, in the unit of its name. `quantity`, `symbol` and `unit` say what is
    corrected, `term` what it follows. `significance` [σ] is that of the term given the others.
    `alternatives` are other terms, in words, with which the log would be explained as well.
    """

    effect: str
    size: Estimate
    quantity: str
    symbol: str
    unit: str
    term: str
    significance: float
    alternatives: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FoundFormula:
    """The formula of what no effect of the table explains, and the effects fitted with it."""

    terms: tuple[FormulaTerm, ...]
    effects: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class GapMap:
    """Significance [σ] of the gap by channel (rows) and phase of flight or variable (columns).

    `before` and `after` are (c, p): without and with the named effects in the model. Null flights,
    simulated flights of the same card without an effect, stay below `threshold` [σ].
    """

    channels: tuple[str, ...]
    places: tuple[str, ...]
    before: Array
    after: Array
    threshold: float


@dataclass(frozen=True, slots=True)
class Trace:
    """A residual channel over time [s], (n,) each, without wind, error curve and sensor biases.

    `gap` is measured minus simulated, `explained` the part of it that the named effects predict.
    `used` is false where the comparison did not use the log: at the end of a sensor's range and
    above the greatest Mach number.
    """

    channel: str
    unit: str
    time: Array
    gap: Array
    explained: Array
    used: Booleans


@dataclass(frozen=True, slots=True)
class TellingChannel:
    """The residual channel that shows the gap best, over time, over a variable and over the ground.

    `gap` and `unexplained`, (n,), are measured minus simulated [`unit`] without and with the named
    effects, at `time` [s]. `noise` is the standard deviation, between flights without an effect, of
    a mean over `averaged` seconds. `variable` is a variable of the flight and `values`, (n,), holds
    it in SI units (time in s). `north` and `east` [m], (n,), are the ground track; `marked`, (n,),
    is true in the quarter of the flight where the gap is largest. `mass` [kg], (n,), is that of the
    airplane, None where it is not recorded. `used`, (n,), is false at instants that the comparison
    did not use.
    """

    channel: str
    unit: str
    time: Array
    gap: Array
    unexplained: Array
    noise: float
    averaged: float
    variable: str
    values: Array
    north: Array
    east: Array
    marked: Booleans
    mass: Array | None
    used: Booleans


@dataclass(frozen=True, slots=True)
class CalibrationChange:
    """What the named effects do to a calibration that does not know them.

    `change` [m/s], (k,), is the correction that the calibration would report less the true one, at
    the indicated airspeeds [m/s], (k,), that were flown.
    """

    airspeed: Array
    change: Array


@dataclass(frozen=True, slots=True)
class Step:
    """One bar of the waterfall: the sum of squares left with one more effect.

    The squares are over noise variance.
    """

    effect: str
    left: float


@dataclass(frozen=True, slots=True)
class History:
    """A quantity measured, simulated, and simulated with the patch, over a segment's time [s].

    The segment is one of the card.
    """

    quantity: str
    unit: str
    time: Array
    measured: Array
    simulated: Array
    patched: Array


@dataclass(frozen=True, slots=True)
class Feature:
    """A characteristic number of a segment of the card, such as its mean power, with its unit.

    `measured` is from the log, `simulated` and `patched` from the card flown again without and with
    the patch. `deviation` is the standard deviation between two flights of one airplane, of
    `freedom` degrees of freedom.
    """

    segment: str
    name: str
    unit: str
    measured: float
    simulated: float
    patched: float
    deviation: float
    freedom: int


@dataclass(frozen=True, slots=True)
class Tolerance:
    """The share of the samples of the card flown again within ±`half_width` of the measured ones.

    `before` is without the patch, `after` with it. `by_chance` is the share between two flights of
    the patched simulator, which differ by gusts alone.
    """

    quantity: str
    unit: str
    half_width: float
    before: float
    after: float
    by_chance: float


@dataclass(frozen=True, slots=True)
class FlownAgain:
    """The card of a log flown again, or the reason in `skipped` why it was not.

    `pilot` is the one who flew it where the log shows another hand than its card tells, else empty.
    """

    features: tuple[Feature, ...] = ()
    tolerances: tuple[Tolerance, ...] = ()
    histories: tuple[History, ...] = ()
    skipped: str = ""
    pilot: str = ""


@dataclass(frozen=True, slots=True)
class Coefficient:
    """A coefficient of a model's file, and what the log says of it.

    The effect and the size that change it, the model's own and the measured one, which goes by its
    unit, and whether the log shows a gap in it.
    """

    effect: str
    parameter: str
    model: float
    measured: Estimate
    has_gap: bool = True


@dataclass(frozen=True, slots=True)
class Closing:
    """What closing the loop came to: the airplane `aircraft` with what was patched into it.

    `closed` is the share of the explainable gap that its patch closes in parts of the logs left
    out, after each round. `patched` are the gaps that were patched, with the sizes of all rounds
    and what they close of the first gap; `reported` are those that the logs show in addition to the
    patched airplane: of sensors and the air, of a part of a flight, or too small. `coefficients`
    are those of the model's file that were patched. `verdict` is the answer with the patched
    airplane, `cut` the sizes beyond their range, which are not patched, in sentences,
    `closure_holdout` the share that the patch closes of the held-out log. `not_told` says which
    causes are not patched because the log does not tell which of them it is, and what to fly.
    Without a round the airplane is not written.
    """

    aircraft: str
    closed: tuple[float, ...]
    patched: tuple[Gap, ...]
    reported: tuple[Gap, ...]
    coefficients: tuple[Coefficient, ...]
    verdict: Verdict
    cut: tuple[str, ...] = ()
    closure_holdout: float | None = None
    not_told: str = ""

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """The rows of its table: the gaps that were patched, then those that are reported."""
        return (*self.patched, *self.reported)


@dataclass(frozen=True, slots=True, repr=False)
class Account(Shown):
    """The content of a reconciliation's report.

    `verdict` is the answer, `patch` the text of its patch, whose effects are `entries`; `flown` is
    the card flown again. `flights` says what each log says. `telling` is the channel of the first
    picture, and `calibration` what the effects do to a calibration; None without a gap or an
    effect. `warnings` are those of the logs as they were read. `formula` describes a gap that the
    table does not explain; None where there is no such gap, or no formula. `chosen` is the cause
    that the user chose of a set. `closing` is what closing the loop came to; None where it was not
    asked for. `coefficients` are those of the model's file that a cause changes. `following` is the
    maneuver to fly next, and `legs` the card of it; both are empty where the card of the log was
    not flown again either.
    """

    log: str
    aircraft: str
    holdout: str
    verdict: Verdict
    gap_map: GapMap
    waterfall: tuple[Step, ...]
    traces: tuple[Trace, ...]
    patch: str
    entries: tuple[tuple[str, dict[str, float]], ...] = ()
    flown: FlownAgain = field(default_factory=FlownAgain)
    null_flights: int = 0
    formula: FoundFormula | None = None
    flights: tuple[JoinedFlight, ...] = ()
    telling: TellingChannel | None = None
    calibration: CalibrationChange | None = None
    warnings: tuple[str, ...] = ()
    closing: Closing | None = None
    chosen: str = ""
    coefficients: tuple[Coefficient, ...] = ()
    following: str = ""
    legs: tuple[BriefedLeg, ...] = ()
