"""Time fits of one log together with a plain SciPy fit of the same rows.

The log has 36,000 rows of three outputs; five parameters are unknown (Inverse+ and the wind).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from pitotbench.calibration import calibrate
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records.log import FlightLog
from pitotbench.show.pages import log_section
from pitotbench.units import Array
from pitotlab.speed.commands import least
from pitotlab.study.velocity_fit import fit_velocity, velocity_outputs_of

FIT_ROWS = 36_000
_ROUNDS = 25  # in which each fit is timed once


@dataclass(frozen=True, slots=True)
class FitTimes:
    """CPU times [s], each the least of several: SciPy's fit, ours by method, one residual with its
    Jacobian.

    `covering` asks the heights where the error is. `static` is told that it is at the static
    source, and fits the altitude equation with the wind triangle. `triangle` uses no heights.
    `panel` draws one panel of the log's page.
    """

    rows: int
    scipy: float
    vector: float
    covering: float
    static: float
    triangle: float
    evaluation: float
    panel: float


def fit_times(log: FlightLog) -> FitTimes:
    """Time fits of a log with attitude and flow angles: three outputs, five parameters (Inverse+
    and wind).

    The SciPy fit is `least_squares` with the analytic Jacobian and the method `lm`. Its time
    includes neither a 2σ bound nor the reading of the log.
    """
    obs = observe(log, CalibrationOptions())
    outputs = velocity_outputs_of(PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE), obs, log)
    start = np.zeros(5)

    def jacobian(theta: Array) -> Array:
        return -outputs(theta)[1].reshape(-1, len(theta))

    def residual(theta: Array) -> Array:
        return outputs(theta)[0].ravel()

    def search() -> object:
        return least_squares(residual, start, jac=jacobian, method="lm", x_scale="jac")

    paper = CalibrationOptions(method="paper")
    static, impact = (CalibrationOptions(error_location=each) for each in ("static", "impact"))
    works: dict[str, Callable[[], object]] = {
        "scipy": search,
        "vector": lambda: fit_velocity(log, paper),
        "covering": lambda: calibrate(log),
        "static": lambda: calibrate(log, static),
        "triangle": lambda: calibrate(log, impact),
        "evaluation": lambda: outputs(start),
    }
    with threadpool_limits(limits=1):
        # In turn: a busy minute of a shared machine then slows all of them.
        rounds = [[least(work, 1) for work in works.values()] for _ in range(_ROUNDS)]
        times = dict(zip(works, map(min, zip(*rounds, strict=True)), strict=True))
        return FitTimes(rows=len(obs), panel=_panel_time(log), **times)


def _panel_time(log: FlightLog) -> float:
    """Return the CPU time of one panel of the page of a log, a mean over its panels."""
    found = calibrate(log)
    panels = log_section("log", log, found).html.count("<svg")
    return least(lambda: log_section("log", log, found)) / panels
