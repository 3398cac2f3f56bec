"""The options of a calibration, in one record."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import inf
from typing import Any

from pitotbench.calibrate.accuracy import Stated, accuracies_of
from pitotbench.catalog import UnknownNameError, explain
from pitotbench.pressure_error import MODELS
from pitotbench.records.errors import BadInputError

AUTO = "auto"  # every model of the table, weighted
METHODS = ("covering", "paper")
ERROR_LOCATIONS = (AUTO, "static", "total", "impact")
WINDS = ("constant", "checked", "linear", "drifting")
LATENCIES = ("given", "checked", "estimated")
LONGEST_LATENCY = 10.0  # s: receivers are late by tenths of a second; more is another unit


@dataclass(frozen=True, slots=True)
class CalibrationOptions:
    """Choices of a calibration; the defaults suit a low-speed log with turns.

    model: name in the table of pressure-error models, or `auto` (see `averaging`).
    method: `covering` (generalized least squares with the covering bound) or `paper` (output error with
    white residuals).
    error_location: `impact` (as in the paper: the error is in the impact pressure alone), `total` (the error of the
    total source, which is the same to this estimator), `static` (the error of the static source, which changes the
    static pressure too and is visible against GPS height), or `auto`: by evidence where the log has its height,
    else static for logs that are not synthetic.
    use_down: use the vertical GPS velocity. use_altitude: use the receiver's height (the altitude equation).
    on_condition: use only the rows that the log marks as on condition.
    mach_max: rows above it are left out. ground_speed_min [m/s]: rows below it are left out, for a log that begins
    on the ground, where the air data have an unknown zero.
    wind_down: estimate a vertical wind. recovery_factor [-]: that of the temperature probe.
    wind: `constant`; `checked`, constant with a warning where the log shows a change; `linear` in time, and in
    height where the log climbs; `drifting`, a slow Gauss-Markov process whose size is estimated (method
    `covering`).
    gps_latency [s]: time by which GPS velocity is stamped late; it is subtracted.
    latency: `given`, `checked` (a warning where the log shows another) or `estimated`.
    robust: leave out faulty rows and list them.
    accuracies: 2σ of constant errors that the residual does not show, as a whole record or by name. A name that is
    not given comes from the log's header, else it has the usual accuracy (`accuracy.USUAL`).
    Raises BadInputError or UnknownNameError for a choice that does not exist, and for a limit or latency that no
    log can have.
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
    wind: str = "constant"
    gps_latency: float = 0.0
    latency: str = "given"
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
                f"a latency of {self.gps_latency:g} s: give at most {LONGEST_LATENCY:g} s, in seconds, "
                "by which the GPS velocity trails the air data"
            )
        if self.model == AUTO and self.method != "covering":
            raise BadInputError("models can only be weighed with the method 'covering'; name one with --model")


def require_model(name: str) -> None:
    """Raise UnknownNameError unless a model of the table has this name, or it is `auto`."""
    if name not in MODELS and name != AUTO:
        raise UnknownNameError(explain(MODELS.kind, name, [*MODELS, AUTO]))


def options_from(choices: Mapping[str, Any]) -> CalibrationOptions:
    """Make options from choices by name.

    Raises BadInputError for an unknown name or a wrong value, and UnknownNameError for an unknown model.
    """
    known = [f.name for f in fields(CalibrationOptions)]
    for name in choices:
        if name not in known:
            raise BadInputError(explain("calibration option", name, known))
    try:
        return CalibrationOptions(**choices)
    except TypeError as error:
        raise BadInputError(f"calibration options: {error}") from error
