"""Time fits of one log beside a plain SciPy fit of the same rows, and beside statsmodels.

The log has 36,000 rows of three outputs; five parameters are unknown (Inverse+ and the wind). SciPy
searches the minimum. statsmodels is given our linearization at zero, which saves most of its work:
it solves a linear problem.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain

import numpy as np
from scipy.optimize import least_squares
from statsmodels.api import GLSAR, OLS
from threadpoolctl import threadpool_limits

from pitotbench.calibration import calibrate
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.show.pages import log_section
from pitotbench.simulation.sortie import fly
from pitotbench.units import Array
from pitotlab.speed.commands import least
from pitotlab.study.velocity_fit import fit_velocity, velocity_outputs_of

FIT_ROWS = 36_000
LAGS = 800
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


def statsmodels_times(residual: Array, jacobian: Array) -> Iterator[tuple[str, float]]:
    """Yield name and CPU time [s] of each fit, for a residual (3, n) and its Jacobian (3, n, 5)."""
    response, regressors = (
        residual.T.ravel(),
        np.ascontiguousarray(np.moveaxis(jacobian, 0, 1)).reshape(-1, 5),
    )
    for order in (1, 12):
        fit = partial(lambda order: GLSAR(response, regressors, rho=order).iterative_fit(4), order)
        yield f"statsmodels GLSAR({order})", least(fit, 3)
    hac = {"cov_type": "HAC", "cov_kwds": {"maxlags": LAGS}}
    yield (
        f"statsmodels OLS with HAC, {LAGS} lags",
        least(lambda: OLS(response, regressors).fit(**hac), 1),
    )


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Time our fit, SciPy and statsmodels; print a table."""
    parser.parse_args(words)
    log = record(fly(Case(maneuver="circle")), data_system("100/100"), 1)
    log = log.select(np.arange(min(FIT_ROWS, len(log))))
    obs = observe(log, CalibrationOptions())
    outputs = velocity_outputs_of(PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE), obs, log)
    fit = fit_times(log)
    with threadpool_limits(limits=1):
        rows = [
            ("ours, covering bound", fit.covering),
            ("ours, vector output error, three outputs", fit.vector),
            ("SciPy least_squares (LM), analytic Jacobian", fit.scipy),
            (
                "ours, `--model auto`",
                least(lambda: calibrate(log, CalibrationOptions(model="auto")), 1),
            ),
        ]
        print("| fit | CPU [s] | over ours |\n|---|---|---|")
        for name, seconds in chain(rows, statsmodels_times(*outputs(np.zeros(5)))):
            print(f"| {name} | {seconds:.3f} | {seconds / fit.covering:.2f} |", flush=True)
