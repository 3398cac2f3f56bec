"""Measure the CPU time of a calibration, for comparison with a plain SciPy fit of the same rows."""

from collections.abc import Callable
from dataclasses import dataclass
from time import process_time

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from pitotbench.calibrate import CalibrationOptions, calibrate
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.rows.observations import observe
from pitotbench.evidence.study.velocity_fit import fit_velocity, velocity_outputs_of
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records.log import FlightLog
from pitotbench.show.draw_section import log_section
from pitotbench.units import Array

_REPEATS = 5


@dataclass(frozen=True, slots=True)
class FitTimes:
    """CPU times [s], each the least of several: SciPy's fit, ours by method, one residual with its Jacobian.

    `covering` asks the heights where the error is. `static` is told that it is at the static source, and fits the
    altitude equation with the wind triangle. `triangle` uses no heights. `panel` draws one panel of the log's page.
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
    """Time fits of a log with attitude and flow angles: three outputs, five parameters (Inverse+ and wind).

    The SciPy fit is `least_squares` with the analytic Jacobian and the method `lm`. Its time includes neither a
    2σ bound nor the reading of the log.
    """
    obs = observe(log, CalibrationOptions())
    outputs = velocity_outputs_of(PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE), obs, log)
    start = np.zeros(5)

    def flat_residual(theta: Array) -> Array:
        return outputs(theta)[0].ravel()

    def flat_jacobian(theta: Array) -> Array:
        return -outputs(theta)[1].reshape(-1, len(theta))

    paper = CalibrationOptions(method="paper")
    with threadpool_limits(limits=1):
        return FitTimes(
            rows=len(obs),
            scipy=_least(
                lambda: least_squares(flat_residual, start, jac=flat_jacobian, method="lm", x_scale="jac")
            ),
            vector=_least(lambda: fit_velocity(log, paper)),
            covering=_least(lambda: calibrate(log)),
            static=_least(lambda: calibrate(log, CalibrationOptions(error_location="static"))),
            triangle=_least(lambda: calibrate(log, CalibrationOptions(error_location="impact"))),
            evaluation=_least(lambda: outputs(start)),
            panel=_panel_time(log),
        )


def _panel_time(log: FlightLog) -> float:
    """Return the CPU time of one panel of the page of a log, a mean over its panels."""
    found = calibrate(log)
    panels = log_section("log", log, found).html.count("<svg")
    return _least(lambda: log_section("log", log, found)) / panels


def _least(work: Callable[[], object]) -> float:
    times = []
    for _ in range(_REPEATS):
        begin = process_time()
        work()
        times.append(process_time() - begin)
    return min(times)
