"""The options of a calibration, and accuracies of constant errors, which no residual shows."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields, replace
from math import cos, inf, isfinite, pi, radians, sin
from types import MappingProxyType
from typing import Any

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.pressure_error import MODELS
from pitotbench.pressure_error.models import SMOOTH, SmoothModel
from pitotbench.records import USUAL_ACCURACIES, BadInputError
from pitotbench.records.calibration import Assumption
from pitotbench.records.calibration_request import CalibrationChoices, asked_fields
from pitotbench.records.calibration_request import Unstated as Unstated
from pitotbench.units import KNOT, SUFFIXES

# K, 2σ: departure of a day from the standard one, for a log without temperature. Five days of
# measured logs were +9.8, +10.7, 0, −4 and −1 K off; it allows for so few.
WITHOUT_TEMPERATURE = 15.0


@dataclass(frozen=True, slots=True)
class Accuracies:
    """2σ of errors that are constant over a log, and over several of one airplane; 0 for none.

    Each widens the bound: the residual does not show them. Where an accuracy is not stated, the
    usual one is assumed, because a bound for an exact temperature would be too small on nearly
    every airplane.

    total_source [-] of the total pressure and the sensor's scale, as a share of the impact
    pressure: it parts the airspeed's error from the static source's, which the height shows.
    temperature_k [K] of the probe; recovery_factor [-]; static_pressure_pa [Pa] of the transducer;
    impact_pressure_zero_pa [Pa], the zero offset of the impact pressure (wide: it is estimated from
    the log); velocity_mps [m/s] of each horizontal GPS component; latency_s [s] by which GPS
    velocity trails the air data. Raises BadInputError for a negative or infinite accuracy.
    """

    temperature_k: float = 0.0
    recovery_factor: float = 0.0
    static_pressure_pa: float = 0.0
    impact_pressure_zero_pa: float = 0.0
    velocity_mps: float = 0.0
    latency_s: float = 0.0
    total_source: float = 0.0

    def __post_init__(self) -> None:
        for f in fields(self):
            value = getattr(self, f.name)
            if not isfinite(value) or value < 0.0:
                raise BadInputError(
                    f"accuracy {f.name} = {value:g}: state a 2σ accuracy of zero or more"
                )


USUAL = Accuracies(**USUAL_ACCURACIES)

NONE = "none"  # in `--accuracy`: sensors without constant errors, as in the published simulator
Stated = Accuracies | Mapping[str, float] | None


def assumptions_of(stated: Stated, header: Mapping[str, object]) -> tuple[Assumption, ...]:
    """Return the accuracies assumed for a log, each with its source.

    Parameters: stated, a whole record or some of its names; header, that of the log. A name that is
    not stated comes from the header's table `accuracy`, else it has the usual accuracy. Raises
    BadInputError for unknown names or wrong numbers.
    """
    if isinstance(stated, Accuracies):
        return tuple(Assumption(f.name, getattr(stated, f.name), "stated") for f in fields(stated))
    by_header = _checked(header.get("accuracy", {}))
    by_user = _checked({} if stated is None else stated)
    found = []
    for f in fields(Accuracies):
        layers = (
            ("stated", by_user),
            ("header", by_header),
            ("usual", {f.name: getattr(USUAL, f.name)}),
        )
        source, value = next((source, layer[f.name]) for source, layer in layers if f.name in layer)
        found.append(Assumption(f.name, value, source))
    return tuple(found)


def accuracies_of(stated: Stated, header: Mapping[str, object]) -> Accuracies:
    """Return the accuracies assumed for a log as a record. Raises as `assumptions_of`."""
    if isinstance(stated, Accuracies):
        return stated
    return Accuracies(**{a.name: a.two_sigma for a in assumptions_of(stated, header)})


def parse_accuracies(text: str) -> dict[str, float]:
    """Read accuracies from text such as `temperature_k=1,static_pressure_pa=40`.

    Where `none` is among them, all accuracies that are not named are zero. Raises BadInputError for
    an unknown name, with the known ones, or for a value that is not a number.
    """
    parts = [part.strip() for part in text.split(",") if part.strip()]
    known = {f.name: 0.0 for f in fields(Accuracies)} if NONE in parts else {}
    others = [part for part in parts if part != NONE]
    return _checked(known | _pairs("accuracy", others, "name=2σ, such as temperature_k=1"))


def parse_priors(text: str) -> dict[str, float]:
    """Read priors from text such as `gust_length_m=300,gust_mps=1`. Raises as `priors_of`."""
    return _pairs("prior", text.split(","), "name=number, such as gust_length_m=300")


def _pairs(what: str, parts: Sequence[str], form: str) -> dict[str, float]:
    """Read pairs NAME=NUMBER. Raises BadInputError where one is not."""
    found = {}
    for part in parts:
        name, _, number = part.partition("=")
        try:
            found[name.strip()] = float(number)
        except ValueError as error:
            raise BadInputError(f"{what} {part!r}: write {form}") from error
    return found


def _numbers(
    what: str, stated: object, known: Sequence[Field[Any]], example: str
) -> dict[str, float]:
    """Return a table of numbers. Raises BadInputError for unknown names and what is no number."""
    if not isinstance(stated, Mapping):  # the header of a log can contain any value
        raise BadInputError(f"{what} {stated!r}: state a table by name, such as {example}")
    names = [f.name for f in known]
    for name, value in stated.items():
        if name not in names:
            raise BadInputError(explain(what, name, names))
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise BadInputError(f"{what} {name}: {value!r} is not a number")
    return {name: float(value) for name, value in stated.items()}


def _checked(stated: object) -> dict[str, float]:
    """Return the accuracies as numbers. Raises BadInputError for unknown names and wrong values."""
    numbers = _numbers("accuracy", stated, fields(Accuracies), "temperature_k = 1")
    Accuracies(**numbers)  # raises for negative and infinite ones
    return numbers


def _prior(value: float, unit: str, usual: tuple[float, float], source: str) -> Any:
    """A field with its value, unit, usual range and source."""
    return field(default=value, metadata={"unit": unit, "usual": usual, "source": source})


def _column(value: float, unit: str, usual: tuple[float, float], source: str) -> Any:
    """The same of a column's coefficient (1σ): 0 leaves the column out."""
    return field(
        default=value, metadata={"unit": unit, "usual": usual, "source": source, "column": True}
    )


@dataclass(frozen=True, slots=True)
class Priors:
    """The priors of what a log says little of: the air, the receiver's height, the curve's shape.

    Each field has its unit, usual range and source in its metadata. The answer hardly depends on
    one that the log contradicts clearly; in a short log or in smooth air it does.

    A name that ends in `factor` is one standard deviation of a log-normal prior, as a factor; the
    other standard deviations are those of half-normal priors, or 1σ. Those of a column (`COLUMNS`)
    may be 0, which leaves the column out. Raises BadInputError for another number that is not above
    zero, or a factor that is not above one.
    """

    gust_mps: float = _prior(2.0, "m/s", (0.5, 5.0), "gusts' standard deviation: severe is 3")
    gust_length_m: float = _prior(533.0, "m", (100.0, 2000.0), "MIL-F-8785C, Dryden above 2,000 ft")
    gust_length_factor: float = _prior(2.5, "-", (1.5, 5.0), "chosen: 200 to 1,300 m within 1σ")
    high_length_factor: float = _prior(
        4.0,
        "-",
        (1.5, 8.0),
        "chosen, above 10,000 ft: slow wind has no outer scale near that length",
    )
    white_mps: float = _prior(0.5, "m/s", (0.1, 2.0), "white noise that is no pressure sensor's")
    slow_wind_mps: float = _prior(1.0, "m/s", (0.3, 5.0), "a drifting wind over half an hour")
    slow_wind_s: float = _prior(1800.0, "s", (600.0, 7200.0), "its memory: longer than a maneuver")
    wind_change_mps: float = _prior(
        5.0, "m/s", (1.0, 20.0), "change in 600 s of a linear wind, and in 300 m of height"
    )
    instruments_s: float = _prior(3.0, "s", (1.0, 6.0), "filter that makes the instruments")
    height_slow_m: float = _prior(5.0, "m", (1.0, 20.0), "slow error of a receiver alone: 1 to 3")
    height_memory_s: float = _prior(90.0, "s", (20.0, 600.0), "memory of the slow height error")
    height_memory_factor: float = _prior(3.0, "-", (1.5, 5.0), "chosen: 30 to 270 s within 1σ")
    height_walk: float = _prior(
        0.2, "m/√s", (0.02, 1.0), "integral of the vertical velocity's error: 0.05 at 1 Hz"
    )
    height_white_m: float = _prior(3.0, "m", (0.5, 10.0), "height without a vertical velocity")
    curve_level: float = _prior(
        0.05, "Δp/q_c", (0.02, 0.1), "chosen, by height alone: few static ports err by 10 %"
    )
    curve_slope: float = _prior(0.06, "Δp/q_c", (0.02, 0.2), "root mean square: 4 kt at 130 kt")
    curve_lift: float = _prior(0.06, "Δp/q_c", (0.02, 0.2), "root mean square of the part in 1/x")
    curve_departure: float = _prior(
        0.002, "Δp/q_c", (0.0005, 0.01), "root mean square; a quarter and four times are its rivals"
    )
    height_form: float = _prior(
        0.04,
        "Δp/q_c",
        (0.01, 0.1),
        "by height alone, an air-data computer's: heights of a cockpit ask for 7 % beyond its airspeed",
    )

    zero_drift_pa: float = _prior(
        2.0, "Pa", (0.5, 10.0), "chosen: what a zero moves between the ground and the flight"
    )
    receiver_smoothing_s2: float = _column(
        0.1,
        "s²",
        (0.02, 0.5),
        "square of the time constant, 0.3 s; the latency found and the interval of the fixes add",
    )
    latency_s: float = _column(
        1.0, "s", (0.2, 2.0), "GPS velocity after the air data; measured logs: −1.1 to +0.6"
    )
    height_latency_s: float = _column(
        0.5, "s", (0.2, 1.0), "GPS height after its velocity; measured logs: −0.84"
    )
    turn_lift: float = _column(
        0.02, "Δp/q_c", (0.01, 0.05), "part in n − 1 at the middle of the speeds: lift is n/q"
    )

    def __post_init__(self) -> None:
        for each in fields(self):
            value, least = getattr(self, each.name), float(each.name.endswith("factor"))
            if value == 0.0 and each.name in COLUMNS:
                continue
            if not isfinite(value) or value <= least:
                raise BadInputError(f"prior {each.name} = {value:g}: give more than {least:g}")

    def of_curve(self, law: SmoothModel) -> SmoothModel:
        """Return a smooth curve with the priors of its parts."""
        return replace(
            law, slope=self.curve_slope, lift=self.curve_lift, departure=self.curve_departure
        )


COLUMNS = tuple(each.name for each in fields(Priors) if each.metadata.get("column"))
PRIORS = Priors()
CARD_PRIORS = ("curve_slope", "curve_lift", "curve_departure")  # that a card of legs takes
StatedPriors = Priors | Mapping[str, float] | None


def priors_of(stated: StatedPriors, header: Mapping[str, object] = MappingProxyType({})) -> Priors:
    """Return a whole record of priors from some of its names.

    A name that is not stated comes from the header's table `priors`, else it has its usual value.
    Raises BadInputError for unknown names or wrong numbers.
    """
    if isinstance(stated, Priors):
        return stated
    layers = (header.get("priors", {}), stated or {})
    known = [_numbers("prior", each, fields(Priors), "gust_length_m = 300") for each in layers]
    return Priors(**{**known[0], **known[1]})


def stated_of(priors: StatedPriors) -> dict[str, float]:
    """Return the priors that somebody stated, by name; of a whole record those that are not usual.

    Raises as `priors_of`.
    """
    if isinstance(priors, Mapping):
        return _numbers("prior", priors, fields(Priors), "gust_length_m = 300")
    values = {each.name: getattr(priors or PRIORS, each.name) for each in fields(Priors)}
    return {name: value for name, value in values.items() if value != getattr(PRIORS, name)}


def priors_of_card(stated: StatedPriors) -> Priors:
    """Return the priors for a card of legs.

    Raises BadInputError as `priors_of`, and for a prior that a card does not take.
    """
    for name in stated_of(stated):
        if name not in CARD_PRIORS:
            known = ", ".join(CARD_PRIORS)
            raise BadInputError(f"prior {name}: a card of legs takes those of its curve: {known}")
    return priors_of(stated)


AUTO = "auto"  # of the location of the error: by evidence; of the model: the smooth curve
_NOW_SMOOTH = (AUTO, "spline")  # what the smooth curve stands for
METHODS = ("covering", "paper")
ERROR_LOCATIONS = (AUTO, "static", "total", "impact")
WINDS = ("constant", "checked", "linear", "drifting")
LATENCIES = ("given", "checked", "estimated")
_STATED_WIND = re.compile(
    r"(?P<speed>\d+(\.\d+)?)\s*((±|\+-|\+/-|/)\s*(?P<spread>\d+(\.\d+)?))?\s*"
    r"(@\s*(?P<direction>\d+(\.\d+)?)\s*°?)?"
)
_WIND_SPREAD = 2.0 * KNOT  # 2σ of a wind that is stated without one: of a report nearby
_FASTEST_WIND = 250.0  # kt


@dataclass(frozen=True, slots=True)
class StatedWind:
    """A mean wind toward north and east [m/s], and the deviation of each component (1σ)."""

    north: float
    east: float
    deviation: float


def stated_wind(text: str) -> StatedWind | None:
    """Return the wind of a text such as `0`, `8@250` or `8±1@250`, None for another text.

    The text has the speed in kt, its 2σ after the sign, and where it is from in °. Without `±` the
    2σ is 2 kt. Raises BadInputError for a wind without its direction, and for one that never blows.
    """
    found = _STATED_WIND.fullmatch(text.strip())
    if found is None:
        return None
    speed, direction = float(found["speed"]), found["direction"]
    if (speed > 0.0 and direction is None) or speed > _FASTEST_WIND:
        raise BadInputError(
            f"wind {text!r}: state it in kt with where it is from, such as 8@250, 8±1@250 or 0"
        )
    spread = _WIND_SPREAD if found["spread"] is None else float(found["spread"]) * KNOT
    if not spread > 0.0:
        raise BadInputError(f"wind {text!r}: its ± is to be above zero")
    toward = radians(float(direction or 0.0)) + pi
    return StatedWind(speed * KNOT * cos(toward), speed * KNOT * sin(toward), 0.5 * spread)


LONGEST_LATENCY = 10.0  # s: receivers are late by tenths of a second; more is another unit


@dataclass(frozen=True, slots=True)
class CalibrationOptions(CalibrationChoices):
    """Choices of a calibration; the defaults suit a low-speed log with turns.

    model: name in the table of pressure-error models; `auto` is `smooth`.
    method: `covering` (generalized least squares with the covering bound) or `paper` (output error
    with white residuals).
    error_location: `impact` (as in the paper: the error is in the impact pressure alone), `total`
    (the error of the total source, which is the same to this estimator), `static` (the error of the
    static source, which changes the static pressure too and is visible against GPS height), or
    `auto`: by evidence where the log has its height, else static for logs that are not synthetic.
    use_down: use the vertical GPS velocity. use_altitude: use the receiver's height (the altitude
    equation).
    on_condition: use only the rows that the log marks as on condition.
    mach_max: rows above it are left out. ground_speed_min [m/s]: rows below it are left out, for a
    log that begins on the ground, where the air data have an unknown zero.
    slowest [m/s]: rows below this indicated airspeed are left out, below 20 kt for None; where it
    is stated, the whole log above it is used.
    wind_down: estimate a vertical wind. recovery_factor [-]: that of the temperature probe.
    wind: `constant`; `checked`, constant or changing, averaged by evidence, with a warning where
    the log shows a change; `linear` in time, and in height where the log climbs; `drifting`, a slow
    Gauss-Markov process whose size is estimated (method `covering`); or a stated one, constant with
    a prior, as `stated_wind` reads it.
    gps_latency [s]: time by which GPS velocity is stamped late; it is subtracted.
    latency: `given`; `checked`, a column with a prior; `estimated`, the same, which refuses a log
    that does not determine it.
    robust: leave out faulty rows and list them.
    accuracies: 2σ of constant errors that the residual does not show, as a whole record or by name.
    A name that is not given comes from the log's header, else it has the usual accuracy (`USUAL`).
    priors: those of `Priors` that are not to have their default, by name.
    Raises BadInputError or UnknownNameError for a choice that does not exist, and for a limit or
    latency that no log can have.
    """

    def __post_init__(self) -> None:
        require_model(self.model)
        accuracies_of(self.accuracies, {})  # raises for unknown names
        priors_of(self.priors)
        for kind, value, known in (
            ("method", self.method, METHODS),
            ("error location", self.error_location, ERROR_LOCATIONS),
            ("latency", self.latency, LATENCIES),
        ):
            if value not in known:
                raise BadInputError(explain(kind, value, list(known)))
        if stated_wind(self.wind) is None and self.wind not in WINDS:
            words = explain("wind", self.wind, list(WINDS))
            raise BadInputError(f"{words} Or state it: 0, 8@250, 8±1@250 (kt from °)")
        if self.mach_max is not None and not self.mach_max > 0.0:
            raise BadInputError(f"the Mach limit is {self.mach_max:g}: it must be above zero")
        if self.slowest is not None and not 0.0 < self.slowest < inf:
            raise BadInputError("the slowest airspeed must be a number above zero")
        if not 0.0 <= self.ground_speed_min < inf:
            raise BadInputError("the lowest ground speed must be a number that is not negative")
        if not abs(self.gps_latency) <= LONGEST_LATENCY:
            raise BadInputError(
                f"a latency of {self.gps_latency:g} s: give at most {LONGEST_LATENCY:g} s, in "
                "seconds, "
                "by which the GPS velocity trails the air data"
            )
        if self.law == SMOOTH.name and self.method != "covering":
            raise BadInputError(
                "a smooth curve needs the method 'covering'; name a law with --model"
            )

    @property
    def law(self) -> str:
        """The name of the model in the table of pressure-error models."""
        return SMOOTH.name if self.model in _NOW_SMOOTH else self.model


def require_model(name: str) -> None:
    """Raise UnknownNameError unless a model of the table, or the smooth curve, has this name."""
    if name not in (*MODELS, *_NOW_SMOOTH):
        raise UnknownNameError(explain(MODELS.kind, name, [*MODELS, AUTO]))


def options_from(choices: Mapping[str, Any]) -> CalibrationOptions:
    """Make options from choices by name.

    Raises BadInputError for an unknown name or a wrong value, and UnknownNameError for an unknown
    model.
    """
    kinds = {f.name: f.type for f in fields(CalibrationOptions)}
    for name, value in choices.items():
        if name not in kinds:
            raise BadInputError(explain("calibration option", name, list(kinds)))
        kind: Any = kinds[name]
        whole = isinstance(value, int) and not isinstance(value, bool)  # as good as a float
        if kind is not Any and not isinstance(1.0 if whole else value, kind):
            wanted = {str: "a text", bool: "true or false"}.get(kind, "a number")
            raise BadInputError(f"calibration option {name}: give {wanted}, not {value!r}")
    return CalibrationOptions(**choices)


def _number(flag: str, text: str, form: str = "a number") -> float:
    try:
        return float(text)
    except ValueError as error:
        raise BadInputError(f"{flag} {text!r}: give {form}") from error


def _latency(text: str) -> dict[str, object]:
    named = LATENCIES[1:]
    if text in named:
        return {"latency": text}
    seconds = _number("--latency", text, f"seconds, or {' or '.join(named)}")
    return {"gps_latency": seconds, "latency": "given"}


_READ: dict[str, Callable[[str], dict[str, object]]] = {  # what is neither text nor number
    "latency": _latency,
    "accuracies": lambda text: {"accuracies": parse_accuracies(text)},
    "priors": lambda text: {"priors": parse_priors(text)},
}


def choices_of(texts: Mapping[str, Any]) -> dict[str, Any]:
    """Return the choices by name that texts state, as the flags take them.

    `texts` has a text or None for each option; a switch is any text. Raises BadInputError for a
    text that cannot be read.
    """
    found: dict[str, Any] = {}
    for each in asked_fields(CalibrationChoices):
        text, read = texts.get(each.name), _READ.get(each.name)
        if text is None:
            continue
        if read is not None:
            found |= read(text)
        elif isinstance(each.default, bool):
            found[each.name] = not each.default
        elif each.type is str:
            found[each.name] = text
        else:
            unit = SUFFIXES.get(each.metadata["unit"])
            number = _number(each.metadata["flag"], text)
            found[each.name] = number if unit is None else number * unit.factor
    return found
