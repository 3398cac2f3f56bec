"""What the user can choose about a calibration, in one record."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from pitotbench.calibrate.accuracy import Accuracies, accuracies_from
from pitotbench.catalog import UnknownNameError, explain
from pitotbench.pressure_error import MODELS
from pitotbench.records.errors import BadInputError

AUTO = "auto"  # every model of the table, weighted
METHODS = ("covering", "paper")
FORMS = ("scalar", "vector")
ERROR_LOCATIONS = (AUTO, "static", "total", "impact")
WINDS = ("checked", "constant", "linear", "drifting")
LATENCIES = ("given", "checked", "estimated")


@dataclass(frozen=True, slots=True)
class CalibrationOptions:
    """Choices of a calibration; the defaults suit a low-speed log with turns.

    model: name in the table of pressure-error models, or `auto` (see `structure`). method: `covering` (generalized
    least squares with a bound that is meant to cover) or `paper` (output error with white residuals).
    form: `scalar` (impact pressure predicted from ground velocity and wind) or `vector` (method `paper`: ground
    velocity predicted from airspeed, attitude and flow angles; method `covering`: the wind across the measured
    direction of the air velocity beside the scalar equation). error_location: `impact` (the paper: the error
    corrupts the impact pressure alone), `total` (the total source's: to this estimator the same), `static` (the
    error is the static source's and moves the static pressure too; it then shows against GPS height as well), or
    `auto`: by evidence where the log has its height, else static for logs that are not synthetic.
    mach_max: rows above it are left out; ground_speed_min: rows below it [m/s] (a log that begins on the ground,
    where the air data have an unknown zero). wind_down: estimate a vertical wind. recovery_factor: of the
    temperature probe. wind: `checked`, constant unless the log speaks for a drift or a jump (method `covering`; the
    bound allows for what the log cannot tell); `constant`; `linear` in time, and in height where the log climbs;
    `drifting`, a slow Gauss-Markov process whose size is found from the data (method `covering`). gps_latency:
    seconds by which GPS velocity is stamped late, taken off; latency: `given`, `checked` (a warning where the log
    shows another) or `estimated`. accuracies: of what the residual cannot show, None for those in the log's header.
    robust: leave faulty rows out and list them.
    Raises BadInputError or UnknownNameError for a choice that does not exist.
    """

    model: str = "inverse+"
    method: str = "covering"
    form: str = "scalar"
    error_location: str = AUTO
    use_down: bool = True
    on_condition: bool = False
    mach_max: float | None = None
    ground_speed_min: float = 0.0
    wind_down: bool = False
    recovery_factor: float = 1.0
    wind: str = "constant"
    gps_latency: float = 0.0
    latency: str = "given"
    robust: bool = True
    accuracies: Accuracies | None = None

    def __post_init__(self) -> None:
        require_model(self.model)
        for kind, value, known in (
            ("method", self.method, METHODS),
            ("form", self.form, FORMS),
            ("error location", self.error_location, ERROR_LOCATIONS),
            ("wind", self.wind, WINDS),
            ("latency", self.latency, LATENCIES),
        ):
            if value not in known:
                raise BadInputError(explain(kind, value, list(known)))
        if self.form == "vector" and self.model == AUTO:
            raise BadInputError("models are weighed in the scalar form; name one with --model for the vector form")
        if self.model == AUTO and self.method != "covering":
            raise BadInputError("models can only be weighed with the method 'covering'; name one with --model")


def require_model(name: str) -> None:
    """Raise UnknownNameError unless a model of the table has this name, or it is `auto`."""
    if name not in MODELS and name != AUTO:
        raise UnknownNameError(explain(MODELS.kind, name, [*MODELS, AUTO]))


def options_from(choices: Mapping[str, Any]) -> CalibrationOptions:
    """Options from choices by name. Raises BadInputError for an unknown name or a value of a wrong kind."""
    known = [f.name for f in fields(CalibrationOptions)]
    for name in choices:
        if name not in known:
            raise BadInputError(explain("calibration option", name, known))
    stated = choices.get("accuracies")
    if isinstance(stated, Mapping):
        choices = {**choices, "accuracies": accuracies_from(stated)}
    try:
        return CalibrationOptions(**choices)
    except TypeError as error:
        raise BadInputError(f"calibration options: {error}") from error
