"""Time public packages on the fit of one log in one run: `python -m tests.evidence.speed.peers`.

The log has 36,000 rows of three outputs; five parameters are unknown (Inverse+ and the wind). SciPy searches the
minimum. statsmodels, filterpy and aeroid are given our linearization at zero, which is most of their work saved:
they solve a linear problem. filterpy and aeroid take a share of the rows; their time is that of all rows, by
proportion. A package that is not installed is left out (`pip install statsmodels filterpy aeroid`).
"""

from collections.abc import Callable, Iterator
from importlib.util import find_spec
from time import process_time

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from pitotbench.calibrate import CalibrationOptions, calibrate
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.rows.observations import observe
from pitotbench.evidence.speed.ratios import FIT_ROWS
from pitotbench.evidence.study.velocity_fit import fit_velocity, velocity_outputs_of
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records.case import Case
from pitotbench.sense import data_system, record
from pitotbench.simulate import fly
from pitotbench.units import Array

LAGS = 800
FILTERED, INTEGRATED = 10, 30  # one row in so many


def least(work: Callable[[], object], tries: int) -> float:
    """Return the CPU time [s] of the fastest of some tries."""
    times = []
    for _ in range(tries):
        begun = process_time()
        work()
        times.append(process_time() - begun)
    return min(times)


def peers(residual: Array, jacobian: Array) -> Iterator[tuple[str, float]]:
    """Yield name and CPU time [s] of each package, for a residual (3, n) and its Jacobian (3, n, 5)."""
    response, regressors = residual.T.ravel(), np.ascontiguousarray(np.moveaxis(jacobian, 0, 1)).reshape(-1, 5)
    if find_spec("statsmodels"):
        from statsmodels.api import GLSAR, OLS

        for order in (1, 12):
            yield (
                f"statsmodels GLSAR({order})",
                least(lambda order=order: GLSAR(response, regressors, rho=order).iterative_fit(4), 3),
            )
        hac = {"cov_type": "HAC", "cov_kwds": {"maxlags": LAGS}}
        yield f"statsmodels OLS with HAC, {LAGS} lags", least(lambda: OLS(response, regressors).fit(**hac), 1)
    if find_spec("filterpy"):
        yield (
            "filterpy extended Kalman filter, 5 states",
            FILTERED * least(lambda: filtered(residual[:, ::FILTERED], jacobian[:, ::FILTERED]), 2),
        )
    if find_spec("aeroid"):
        yield (
            "aeroid output_error",
            INTEGRATED * least(lambda: integrated(residual[:, ::INTEGRATED], jacobian[:, ::INTEGRATED]), 1),
        )


def filtered(residual: Array, jacobian: Array) -> Array:
    """Return the parameters, (5,), after one pass of filterpy's extended Kalman filter."""
    from filterpy.kalman import ExtendedKalmanFilter

    kalman = ExtendedKalmanFilter(dim_x=5, dim_z=3)
    kalman.Q *= 1e-9
    for z, row in zip(residual.T, np.moveaxis(jacobian, 0, 1), strict=True):
        kalman.predict()
        kalman.update(z[:, None], lambda _, row=row: row, lambda x, row=row: row @ x)
    return np.asarray(kalman.x[:, 0])


def integrated(residual: Array, jacobian: Array) -> Array:
    """Return the parameters, (5,), by aeroid, for which the outputs depend on the inputs and on a state at rest."""
    import aeroid

    names, inputs = [f"p{i}" for i in range(5)], [f"u{i}" for i in range(15)]

    def outputs(_: float, state: Array, control: Array, p: dict[str, float]) -> Array:
        return control.reshape(3, 5) @ np.array([p[name] for name in names]) + 0.0 * state[0]

    model = aeroid.Model(
        states=["rest"], controls=inputs, parameters=dict.fromkeys(names, 0.1),
        dynamics=lambda _, state, control, p: 0.0 * state, outputs=["north", "east", "down"], measurement=outputs,
    )  # fmt: skip
    columns = np.moveaxis(jacobian, 0, 1).reshape(residual.shape[1], 15).T
    channels = dict(zip(inputs, columns, strict=True)) | dict(zip(model.outputs, residual, strict=True))
    data = aeroid.FlightData(time=0.01 * INTEGRATED * np.arange(residual.shape[1]), channels=channels)
    found = aeroid.identify(model, data, names, x0=[0.0])
    return np.array([found.parameters[name] for name in names])


def main() -> None:
    log = record(fly(Case(maneuver="circle")), data_system("100/100"), 1)
    log = log.select(np.arange(min(FIT_ROWS, len(log))))
    obs = observe(log, CalibrationOptions())
    outputs = velocity_outputs_of(PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE), obs, log)
    residual, jacobian = outputs(np.zeros(5))
    paper = CalibrationOptions(method="paper")

    def scipy_alone() -> Array:
        return np.asarray(
            least_squares(
                lambda theta: outputs(theta)[0].ravel(),
                np.zeros(5),
                jac=lambda theta: -outputs(theta)[1].reshape(-1, 5),
                method="lm",
                x_scale="jac",
            ).x
        )

    with threadpool_limits(limits=1):
        ours = least(lambda: calibrate(log), 5)
        rows = [
            ("ours, covering bound", ours),
            ("ours, vector output error, three outputs", least(lambda: fit_velocity(log, paper), 5)),
            ("SciPy least_squares (LM), analytic Jacobian", least(scipy_alone, 5)),
            ("ours, `--model auto`", least(lambda: calibrate(log, CalibrationOptions(model="auto")), 1)),
        ]
        print("| fit | CPU [s] | over ours |\n|---|---|---|")
        for name, seconds in rows:
            print(f"| {name} | {seconds:.3f} | {seconds / ours:.2f} |")
        for name, seconds in peers(residual, jacobian):
            print(f"| {name} | {seconds:.3f} | {seconds / ours:.2f} |", flush=True)


if __name__ == "__main__":
    main()
