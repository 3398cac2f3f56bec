"""The paper's method: one output, indicated airspeed."""

import numpy as np

from pitotbench import air
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.output_error import OutputErrorFit, Outputs, fit_output_error
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.units import Array

_COARSE_ROWS = 2000  # rows of the first fit of a long log, which starts the full fit near its minimum


def fit_scalar(model: PredictionModel, obs: Observations) -> OutputErrorFit:
    """Fit one output: indicated airspeed [m/s], predicted from the held velocity and the wind.

    Raises NoAnswerError as `fit_output_error` does.
    """
    held = obs.as_held()
    start = np.zeros(model.count)
    if len(held) > _COARSE_ROWS * 4:
        coarse = held.every(len(held) // _COARSE_ROWS)
        start = fit_output_error(airspeed_outputs(model, coarse), start).theta
    return fit_output_error(airspeed_outputs(model, held), start)


def airspeed_outputs(model: PredictionModel, obs: Observations) -> Outputs:
    """Return the function of θ that gives the residual of indicated airspeed, (1, n) [m/s], and the Jacobian."""
    measured = air.calibrated_airspeed(obs.impact_pressure)

    def outputs(theta: Array) -> tuple[Array, Array]:
        prediction = model.predict(theta, obs)
        predicted = air.calibrated_airspeed(prediction.indicated)
        slope = air.calibrated_airspeed_slope(prediction.indicated, predicted)
        return (measured - predicted)[None, :], (prediction.jacobian * slope[:, None])[None, :, :]

    return outputs
