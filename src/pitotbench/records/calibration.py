"""The result of a calibration: what the log says, and how far to trust it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import atan2, degrees, hypot, inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from pitotbench.records import BadInputError, NoAnswerError, Shown, freeze_arrays, views
from pitotbench.records.log import Caution, FlightLog, Provenance
from pitotbench.units import FOOT, KNOT, Array, Booleans, Meters, MetersPerSecond, Seconds


@dataclass(frozen=True, slots=True)
class Estimate:
    """An estimate and its ±2σ bound, in one unit, made to hold the truth in 95 % of cases."""

    name: str
    value: float
    two_sigma: float


@dataclass(frozen=True, slots=True)
class WindEstimate:
    """Wind velocity, toward north, east and down [m/s]; down is None where it was not estimated."""

    north: Estimate
    east: Estimate
    down: Estimate | None = None

    @property
    def speed_kt(self) -> float:
        """The speed of the horizontal wind [kt]."""
        return hypot(self.north.value, self.east.value) / KNOT

    @property
    def from_deg(self) -> float:
        """The direction that the wind comes from [°, true]."""
        return degrees(atan2(-self.east.value, -self.north.value)) % 360.0


@dataclass(frozen=True, slots=True)
class WindowWind:
    """The mean wind [m/s] of a part of a log, with its begin and end [s] and mean height [m]."""

    begin: float
    end: float
    altitude: float
    north: Estimate
    east: Estimate


@dataclass(frozen=True, slots=True)
class Disagreement:
    """Two findings of one log that contradict each other, in words.

    `kind` is `height`, `samples`, `fixed_speed`, `reading`, `scale` or `pitot`; `size` is the
    largest difference [m/s], of a `height` or a `reading` what it moves in the curve. One that is
    `fatal` is not held by the bound.
    """

    kind: str
    words: str
    size: float
    fatal: bool


@dataclass(frozen=True, slots=True)
class OneSided:
    """Indicated airspeeds [m/s] of a log that were flown on tracks of one side only.

    The tracks go from `begin` clockwise to `end` [°, true]. A wind and an error of the airspeed
    look alike there.
    """

    low: float
    high: float
    begin: float
    end: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedSpeedPoint:
    """One airspeed, one wind [m/s], from legs or a turn at constant airspeed.

    `legs` is 1 for a turn. `indicated_airspeed`, `calibrated_airspeed`, `correction` (calibrated
    minus indicated) and `two_sigma` (its bound) are mean values over the legs; `true_airspeed`
    belongs to the same mean. `spread` is the standard deviation of the redundant solutions: those
    of three legs out of four, or the residuals of a regression; None where nothing is redundant.
    `two_sigma` contains the stated accuracies of temperature and pressures,
    `true_airspeed_two_sigma` only the scatter of the ground velocities. The wind is the velocity of
    the air toward north and east.
    """

    method: str
    legs: int
    seconds: float
    indicated_airspeed: float
    calibrated_airspeed: float
    correction: float
    two_sigma: float
    true_airspeed: float
    true_airspeed_two_sigma: float
    spread: float | None
    wind_north: float
    wind_east: float
    wind_two_sigma: float  # of the larger component


@dataclass(frozen=True, slots=True)
class PublishedCurve:
    """A handbook's airspeed calibration: calibrated by indicated airspeed [m/s], (n,) each.

    Both airspeeds grow along the curve, which is that of one configuration. `source` is the file's
    name.
    """

    source: str
    configuration: str
    indicated_airspeed: MetersPerSecond
    calibrated_airspeed: MetersPerSecond

    def __post_init__(self) -> None:
        freeze_arrays(self, len(self.indicated_airspeed))

    @property
    def correction(self) -> MetersPerSecond:
        """Calibrated minus indicated airspeed [m/s], (n,)."""
        return self.calibrated_airspeed - self.indicated_airspeed


_ROUNDING_KT = 0.5  # an end of the curve is shown in whole knots


class CorrectionAt(NamedTuple):
    """What to add to an indicated airspeed, or to several, and its 2σ [kt]."""

    correction_kt: Any
    two_sigma_kt: Any


@dataclass(frozen=True, slots=True)
class ErrorCurve:
    """The pressure error as a curve over indicated airspeed; arrays of one length.

    `correction` is calibrated minus indicated airspeed, to be added to the raw reading: a zero
    offset of the impact pressure that was found is taken out with it. `normalized_pressure_error`
    and `altitude_correction` are of the pressure error alone, at the same readings. `two_sigma` is
    the bound of each point: it is made to contain the true correction at that airspeed in 95 % of
    flights. `simultaneous_two_sigma` is wider: the band is made to contain the true curve at all
    airspeeds at once. `white_two_sigma` is the Cramér-Rao bound for white residuals, for comparison
    only. `altitude_assumed`: nothing shows that the error is the static source's, so that the
    altitude may have none. `highest` [m] is the greatest pressure altitude of the data.
    `published`: the curves of a handbook, for comparison.
    """

    indicated_airspeed: MetersPerSecond
    correction: MetersPerSecond
    two_sigma: MetersPerSecond
    simultaneous_two_sigma: MetersPerSecond
    white_two_sigma: MetersPerSecond
    normalized_pressure_error: Array  # Δp/q_c
    normalized_two_sigma: Array
    # True minus indicated pressure altitude; None where the static source is taken to be right.
    altitude_correction: Meters | None = None
    altitude_two_sigma: Meters | None = None
    # (n, n), of the errors of the correction; None where it is not known
    correlation: Array | None = None
    altitude_assumed: bool = False
    highest: float = inf
    published: tuple[PublishedCurve, ...] = ()

    def __post_init__(self) -> None:
        freeze_arrays(self, len(self.indicated_airspeed), "correlation")

    @property
    def indicated_airspeed_kt(self) -> Array:
        """The indicated airspeeds [kt], (n,)."""
        return self.indicated_airspeed / KNOT

    @property
    def calibrated_airspeed_kt(self) -> Array:
        """The calibrated airspeeds [kt], (n,): indicated airspeed plus correction."""
        return (self.indicated_airspeed + self.correction) / KNOT

    @property
    def correction_kt(self) -> Array:
        """The correction to add to the indicated airspeed [kt], (n,)."""
        return self.correction / KNOT

    @property
    def two_sigma_kt(self) -> Array:
        """The ±2σ bound of the correction at each airspeed [kt], (n,)."""
        return self.two_sigma / KNOT

    def at(self, airspeed_kt: Any) -> CorrectionAt:
        """Return the correction at an indicated airspeed [kt] or at several, with its 2σ.

        Raises BadInputError for an airspeed that was not flown: the curve says nothing of it.
        """
        asked, known = np.asarray(airspeed_kt, dtype=np.float64), self.indicated_airspeed_kt
        low, high = known[0] - _ROUNDING_KT, known[-1] + _ROUNDING_KT
        if not np.all((asked >= low) & (asked <= high)):
            raise BadInputError(
                f"the curve is known from {known[0]:.0f} to {known[-1]:.0f} KIAS, and "
                f"{airspeed_kt} is not between them"
            )
        values = (np.interp(asked, known, each) for each in (self.correction_kt, self.two_sigma_kt))
        return CorrectionAt(*(each if asked.ndim else float(each) for each in values))

    __call__ = at

    @property
    def altitude_correction_ft(self) -> Array | None:
        """True minus indicated pressure altitude [ft], (n,), None for a right static source."""
        return None if self.altitude_correction is None else self.altitude_correction / FOOT


@dataclass(frozen=True, slots=True)
class Share:
    """The contribution of one uncertain constant, such as a temperature error, to 2σ bounds [m/s].

    `curve` is its root mean square over the curve, `wind` that on the larger wind component. Where
    the constant is known, the square of the bound falls by its square. Parts of constants that the
    log hardly distinguishes overlap. `estimate` is the constant as the log determines it.
    """

    name: str
    estimate: Estimate
    curve: float
    wind: float


@dataclass(frozen=True, slots=True)
class DayTemperature:
    """The temperature that a calibration rests on, and what an error of it would do.

    `departure` [K] is that of the air from the standard day, in the middle of the log.
    `by_five_kelvin` [m/s], rms over the curve, is what the curve would be off by for a probe 5 K
    off beyond what the log shows. `by_slow_end` [m/s] is the most that the curve would be off for a
    probe that is 5 K off at the slowest airspeed alone.
    """

    departure: float
    by_five_kelvin: float
    by_slow_end: float


READ_AT_REST = "read at rest"  # source of an assumption


@dataclass(frozen=True, slots=True)
class Assumption:
    """The 2σ accuracy of one constant error that a bound takes for granted, in its name's unit.

    `source`: `stated` by the user or the mapping, `header` (by the log itself), `usual` (nobody
    stated one), `standard day` (the log has no temperature), `READ_AT_REST` (the rows at rest show
    it) or `method` (the published method takes its sensors for exact).
    """

    name: str
    two_sigma: float
    source: str


@dataclass(frozen=True, slots=True)
class Residuals:
    """The residuals of the fitted model, for pictures and checks: one entry a sample used.

    `airspeed` is measured minus predicted, with all unknowns in the prediction, expressed as
    calibrated airspeed [m/s].
    """

    time: Seconds
    indicated_airspeed: MetersPerSecond
    airspeed: MetersPerSecond
    used: Booleans  # over the rows of the log: which were used

    def __post_init__(self) -> None:
        freeze_arrays(self, len(self.time), "used")


@dataclass(frozen=True, slots=True)
class LatencyFound:
    """The latency of the GPS velocity that a log shows, its 2σ, and the part not taken out [s].

    The 2σ is infinite where the log does not determine the latency. The `key` of a field, here and
    below, is its name in plain data, with the unit.
    """

    value: float = field(metadata={"key": "latency_s"})
    two_sigma: float = field(metadata={"key": "latency_two_sigma_s"})
    left: float = field(metadata={"key": "latency_left_s"})


@dataclass(frozen=True, slots=True)
class WindChange:
    """The evidence for a wind that changed, and its most likely change.

    `bayes_factor` is that of a change against a constant wind. `chance` is how often a constant
    wind would give as large a one in the same gusts: where gusts hide every change, the factor is
    near 1 and says nothing. `kind` is `steady`, `wave`, `drift` or `jump`. `size` [m/s] is the
    greatest difference between two winds of the log, `time` [s after the first row] the middle of a
    jump, NaN for another kind. The change would move the curve by `moves` [m/s] and by `share` of
    its 2σ at most.
    """

    bayes_factor: float = field(metadata={"key": "wind_change_bayes_factor"})
    chance: float = field(metadata={"key": "wind_change_chance"})
    kind: str = field(metadata={"key": "wind_change_kind"})
    size: float = field(metadata={"key": "wind_change_mps"})
    time: float = field(metadata={"key": "wind_change_time_s"})
    moves: float = field(metadata={"key": "wind_change_moves_mps"})
    share: float = field(metadata={"key": "wind_change_share"})


@dataclass(frozen=True, slots=True)
class GustsFound:
    """The gusts of a log, by deviation and length, and the deviation of a drifting wind.

    `blocks` is the number of block means.
    """

    deviation: float = field(metadata={"key": "gust_deviation_mps"})
    length: float = field(metadata={"key": "gust_length_m"})
    wind_deviation: float = field(metadata={"key": "wind_deviation_mps"})
    blocks: int


@dataclass(frozen=True, slots=True)
class HeightFound:
    """The altitude equation: level and memory of the height's slow error, and the number of rows.

    With vertical velocity its integral wanders by `walk`; without, the height has the white noise
    `white`. The other is None.
    """

    deviation: float = field(metadata={"key": "height_deviation_m"})
    memory: float = field(metadata={"key": "height_memory_s"})
    white: float | None = field(metadata={"key": "height_white_m"})
    walk: float | None = field(metadata={"key": "height_walk_m_per_root_s"})
    rows: int = field(metadata={"key": "altitude_rows"})


@dataclass(frozen=True, slots=True)
class Diagnostics:
    """What a fit found beside curve and wind; None or empty for what was not looked for.

    `iterations` are those of the white fit, and `rows_left_out` the numbers of the first faulty
    rows of the log. `height_agreement` is the probability that wind triangle and height differ
    about the curve by so much by chance, `static_probability` that of an error of the static
    source. `departures` holds the probability of each size of a smooth curve's departures, keyed by
    their root mean square in Δp/q_c.
    """

    iterations: int
    rows_left_out: tuple[int, ...] = ()
    latency: LatencyFound | None = None
    wind_change: WindChange | None = None
    gusts: GustsFound | None = None
    height_agreement: float | None = None
    static_probability: float | None = None
    height: HeightFound | None = None
    departures: dict[str, float] | None = field(default=None, metadata={"key": "departure"})


@dataclass(frozen=True, slots=True)
class Scale:
    """The factor by which the airspeed is to be multiplied, with 2σ [-].

    `units` are other meanings of such a factor, in words: units that a column may have in place of
    its own, or a true airspeed. Where there are any, the log does not tell which is right.
    """

    factor: float
    two_sigma: float
    units: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class RecordedAutopilot:
    """The airspeed parameters of a log by name, the propeller wash it shows, and the sensor.

    `wash`: by how much the indicated airspeed [m/s] reads higher at full power than at idle; its 2σ
    is infinite where power follows airspeed, so that the log does not distinguish them. None where
    no power was recorded. `sensor` is the number of the sensor.
    """

    parameters: Mapping[str, float]
    wash: Estimate | None = None
    sensor: int = 1


@dataclass(frozen=True, slots=True)
class Setting:
    """A parameter to set: its new value with 2σ, the old value, and how it was derived.

    A switch has no 2σ; a parameter that the log does not hold has no old value.
    """

    name: str
    value: float
    two_sigma: float | None
    old: float | None
    source: str


@dataclass(frozen=True, slots=True)
class AutopilotSettings:
    """The parameters that take the error out of an autopilot's airspeed, and what they leave.

    At each `calibrated_airspeed` [m/s], (n,), the airspeed shown with the new parameters is right
    within `bound` [m/s], (n,): the 2σ of the curve plus what the autopilot's formula cannot follow.
    `wash` as in the log.
    """

    autopilot: str
    settings: tuple[Setting, ...]
    calibrated_airspeed: MetersPerSecond
    bound: MetersPerSecond
    wash: Estimate | None = None


@dataclass(frozen=True, slots=True, repr=False)
class Calibration(Shown):
    """An error curve and a wind with their bounds, and the numbers to check them by."""

    model: str
    method: str
    parameters: tuple[Estimate, ...]
    reference_pressure: float  # Pa
    wind: WindEstimate | None  # None where height alone answers
    curve: ErrorCurve
    # 2σ of `residuals` as calibrated airspeed [m/s], no bound on the curve; by the estimator alone
    # that of its white fit, the figure of Martos, Kiszely and Foster (2011)
    residual_two_sigma: float
    samples: int
    converged: bool
    reason: str  # why the iteration stopped
    condition_number: float  # of the scaled, whitened normal problem
    residuals: Residuals
    diagnostics: Diagnostics
    warnings: tuple[Caution, ...] = ()
    shares: tuple[Share, ...] = ()
    # place of the pressure error, stated, assumed or estimated: `static`, `total` or `impact`
    error_location: str = "impact"
    assumptions: tuple[Assumption, ...] = ()  # the accuracies on which every bound depends
    priors: Mapping[str, float] = field(default_factory=dict)  # those that were stated, by name
    # zero offset of the sensor that was found and that `curve.correction` takes out [Pa]; None
    # where none was looked for
    impact_pressure_zero: Estimate | None = None
    winds: tuple[WindowWind, ...] = ()  # of each window of a long flight, else of the whole log
    parts: tuple[tuple[float, float], ...] = ()  # first and last time of each part used [s]
    left_out: tuple[str, ...] = ()  # why other rows were not used
    disagreements: tuple[Disagreement, ...] = ()
    points: tuple[FixedSpeedPoint, ...] = ()  # against which the curve was held
    place_assumed: bool = False  # nothing in the log shows at which source the error is
    # what the temperature is and does to the curve; None where it is assumed or exact
    day: DayTemperature | None = None
    mach: float = 0.0  # largest one used
    log_start: float = 0.0  # time of the first row of the file [s]
    autopilot: RecordedAutopilot | None = None  # parameters in the log of an autopilot
    scale: Scale | None = None  # factor on the airspeed; None where height alone answers
    # slow and fast airspeeds that were flown on one side of the compass only, at most one each
    one_sided: tuple[OneSided, ...] = ()
    # files and choices behind the answer, where the caller stated them
    provenance: Provenance = field(default_factory=Provenance)

    @property
    def known_wind(self) -> WindEstimate:
        """The wind. Raises NoAnswerError where it is unknown."""
        if self.wind is None:
            raise NoAnswerError("the wind is unknown: height alone gave the curve")
        return self.wind

    @property
    def usable(self) -> bool:
        """Whether the answer may be used: its samples do not contradict it."""
        return not any(each.fatal for each in self.disagreements)

    @property
    def zero_at_rest(self) -> Estimate | None:
        """The zero of the impact pressure [Pa] where the log was read at rest, else None.

        One that the flight alone shows cannot be told from a factor.
        """
        return (
            self.impact_pressure_zero
            if any(each.source == READ_AT_REST for each in self.assumptions)
            else None
        )

    def at(self, airspeed_kt: Any) -> CorrectionAt:
        """Return the correction at an indicated airspeed [kt] and its 2σ.

        `value, two_sigma = result.at(100)`, as `ErrorCurve.at`.
        """
        return self.curve.at(airspeed_kt)

    @property
    def doubts(self) -> list[str]:
        """What the answer must not go without, in sentences; the first is the weightiest."""
        return cast("list[str]", views().doubts_of(self))

    def save(self, path: str | Path) -> None:
        """Write the answer in the form of a name: page (.html), card (.csv) or data (.json).

        The card is that of airspeeds, the data those of `calibrate --json`. Raises BadInputError
        for another name.
        """
        views().save(self, Path(path))

    if not TYPE_CHECKING:  # a type checker is to find a name that is misspelled

        def __getattr__(self, name: str) -> Any:
            """Say what a name means that other programs have and this record lacks."""
            hint = f": use {_MEANT[name]}" if name in _MEANT else ""
            raise AttributeError(f"a {type(self).__name__} has no {name!r}{hint}")

    def write_page(self, path: str | Path, units: str = "") -> None:
        """Write the answer, its picture and its card as a page (.html).

        The page is in `units` such as `km/h,m`, by default in kt and ft. Raises BadInputError for
        another name or unit.
        """
        views().write_page(self, Path(path), units)

    def write_record(self, path: str | Path, rule: str = "auto", units: str = "") -> None:
        """Write the record for the file (.html, two pages), as `calibrate --record` does.

        `rule` as for `judge`, `units` as for `write_page`.

        Raises BadInputError for another name or unit.
        """
        views().write_record(self, Path(path), rule, units)

    def write_card(self, path: str | Path) -> None:
        """Write the airspeed card (.csv), as `calibrate --card` does.

        Raises BadInputError for another name.
        """
        views().write_card(self, Path(path))

    def judge(self, rule: str = "auto") -> list[Any]:
        """Return the judgments by a rule: `far23`, `far25`, `auto`, or your own (`2%,3kt,30ft`).

        Each has the `rule`, its margins and a `sentence`. Raises BadInputError for another rule.
        """
        return cast("list[Any]", views().judge(self, rule))

    def params(self, autopilot: str) -> AutopilotSettings:
        """Return the parameters to set, `ardupilot` or `px4`, as `calibrate --params` does.

        Raises BadInputError for a log without the old ones, unless they are stated:
        `px4,ASPD_SCALE_1=1,SENS_DPRES_OFF=0`.
        """
        return cast(AutopilotSettings, views().params(self, autopilot))


# What is typed for a method of `Calibration` that has another name.
_MEANT = {"correction": "at(100)", "report": 'save("page.html")', "to_csv": 'save("card.csv")'}


@dataclass(frozen=True, slots=True)
class CalibratedFlight:
    """A flight of a log with its calibration.

    `place` is the index of the log among those given. `number` counts the flights of the log from
    1, `count` is how many it holds; both are 1 where the log was reduced as one. `joined` is the
    number of flights, of all logs, that share the curve, and `leader` the index of the first log
    of these.
    """

    log: FlightLog
    calibration: Calibration
    place: int
    number: int = 1
    count: int = 1
    joined: int = 1
    leader: int = 0
