"""The options of a calibration, and the accuracies of constant errors that the residual does not
show.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf, isfinite
from typing import Any

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.pressure_error import MODELS
from pitotbench.pressure_error.models import SMOOTH
from pitotbench.records import USUAL_ACCURACIES, BadInputError
from pitotbench.records.calibration import Assumption

# Accuracies of constant errors that the residual does not show. Each widens the bound. Where an
# accuracy is not stated, the usual one is assumed. A bound for an exact temperature would be too
# small on nearly every airplane.

# K, 2σ: departure of a day from the standard one, for a log without temperature. Five days of
# measured logs were +9.8, +10.7, 0, −4 and −1 K off; it allows for so few.
WITHOUT_TEMPERATURE = 15.0


@dataclass(frozen=True, slots=True)
class Accuracies:
    """2σ of errors that are constant over a log, and over several logs of one airplane; 0 leaves an
    error out.

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
    """Return the accuracies assumed for a log as a record; see `assumptions_of`. Raises as it does."""
    if isinstance(stated, Accuracies):
        return stated
    return Accuracies(**{a.name: a.two_sigma for a in assumptions_of(stated, header)})


def parse_accuracies(text: str) -> dict[str, float]:
    """Read accuracies from text such as `temperature_k=1,static_pressure_pa=40`.

    With `none` among them, all accuracies that are not named are zero. Raises BadInputError for an
    unknown name, with the known ones, or for a value that is not a number.
    """
    parts = [part.strip() for part in text.split(",") if part.strip()]
    stated = {f.name: 0.0 for f in fields(Accuracies)} if NONE in parts else {}
    for part in parts:
        if part == NONE:
            continue
        name, equals, number = part.partition("=")
        try:
            stated[name.strip()] = float(number)
        except ValueError as error:
            raise BadInputError(
                f"accuracy {part!r}: write name=2σ, such as temperature_k=1"
            ) from error
        if not equals:
            raise BadInputError(f"accuracy {part!r}: write name=2σ, such as temperature_k=1")
    return _checked(stated)


def _checked(stated: object) -> dict[str, float]:
    """Return the accuracies as numbers. Raises BadInputError for unknown names and wrong values."""
    if not isinstance(stated, Mapping):  # the header of a log can contain any value
        raise BadInputError(
            f"accuracy {stated!r}: state a table of 2σ by name, such as temperature_k = 1"
        )
    known = [f.name for f in fields(Accuracies)]
    for name, value in stated.items():
        if name not in known:
            raise BadInputError(explain("accuracy", name, known))
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise BadInputError(f"accuracy {name}: {value!r} is not a number")
    numbers = {name: float(value) for name, value in stated.items()}
    Accuracies(**numbers)  # raises for negative and infinite ones
    return numbers


# The options of a calibration, in one record.

AUTO = "auto"  # of the location of the error: by evidence; of the model: the smooth curve
_NOW_SMOOTH = (AUTO, "spline")  # what the smooth curve stands for
METHODS = ("covering", "paper")
ERROR_LOCATIONS = (AUTO, "static", "total", "impact")
WINDS = ("constant", "checked", "linear", "drifting")
LATENCIES = ("given", "checked", "estimated")
LONGEST_LATENCY = 10.0  # s: receivers are late by tenths of a second; more is another unit


class Unstated(str):
    """A choice that nobody stated, such as that of the published figures: it equals its text, and
    gives way to what a mapping advises and to the defaults of who asks.
    """

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class CalibrationOptions:
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
    wind_down: estimate a vertical wind. recovery_factor [-]: that of the temperature probe.
    wind: `constant`; `checked`, constant or changing, averaged by evidence, with a warning where
    the log shows a change; `linear` in time, and in height where the log climbs; `drifting`, a slow
    Gauss-Markov process whose size is estimated (method `covering`). gps_latency [s]: time by which
    GPS velocity is stamped late; it is subtracted.
    latency: `given`, `checked` (a warning where the log shows another) or `estimated`.
    robust: leave out faulty rows and list them.
    accuracies: 2σ of constant errors that the residual does not show, as a whole record or by name.
    A name that is not given comes from the log's header, else it has the usual accuracy (`USUAL`).
    Raises BadInputError or UnknownNameError for a choice that does not exist, and for a limit or
    latency that no log can have.
    """

    model: str = "inverse+"
    method: str = "covering"
    error_location: str = AUTO
    use_down: bool = True
    use_altitude: bool = True
    on_condition: bool = False
    mach_max: float | None = None
    ground_speed_min: float = 0.0
    wind_down: bool = False
    recovery_factor: float = 1.0
    wind: str = Unstated("constant")
    gps_latency: float = 0.0
    latency: str = Unstated("given")
    robust: bool = True
    accuracies: Stated = None

    def __post_init__(self) -> None:
        require_model(self.model)
        accuracies_of(self.accuracies, {})  # raises for unknown names
        for kind, value, known in (
            ("method", self.method, METHODS),
            ("error location", self.error_location, ERROR_LOCATIONS),
            ("wind", self.wind, WINDS),
            ("latency", self.latency, LATENCIES),
        ):
            if value not in known:
                raise BadInputError(explain(kind, value, list(known)))
        if self.mach_max is not None and not self.mach_max > 0.0:
            raise BadInputError(f"the Mach limit is {self.mach_max:g}: it must be above zero")
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
    """Raise UnknownNameError unless a model of the table has this name, or stands for the smooth
    curve.
    """
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
        if kind is not Stated and not isinstance(1.0 if whole else value, kind):
            wanted = {str: "a text", bool: "true or false"}.get(kind, "a number")
            raise BadInputError(f"calibration option {name}: give {wanted}, not {value!r}")
    return CalibrationOptions(**choices)
