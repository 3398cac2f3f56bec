"""The outputs of the paper's method: one output (airspeed) or three (ground velocity)."""

import numpy as np

from pitotbench import air
from pitotbench.calibrate.model.air_direction import air_direction
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.output_error import OutputErrorFit, Outputs, fit_output_error
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.records.log import FlightLog
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


def fit_vector(model: PredictionModel, obs: Observations, log: FlightLog) -> OutputErrorFit:
    """Fit ground velocity north, east and down [m/s], predicted from airspeed, attitude, flow angles and wind.

    Raises BadInputError where the log has no attitude or no flow angles, NoAnswerError as `fit_output_error` does.
    """
    return fit_output_error(velocity_outputs_of(model, obs, log), np.zeros(model.count))


def velocity_outputs_of(model: PredictionModel, obs: Observations, log: FlightLog) -> Outputs:
    """Return the function of θ that gives the residual of ground velocity, (2 or 3, n) [m/s], and the Jacobian.

    Raises BadInputError where the log has no attitude or no flow angles.
    """
    direction = air_direction(log)[:, obs.used]
    x = obs.impact_pressure / model.reference_pressure
    basis = model.error.basis(x)
    measured = [obs.held_north, obs.held_east] + ([obs.held_down] if obs.has_down else [])
    axes, n, free = len(measured), len(obs), model.error_count
    jacobian = np.zeros((axes, n, model.count))
    for axis in range(min(axes, model.count - free)):
        jacobian[axis, :, free + axis] = 1.0

    def outputs(theta: Array) -> tuple[Array, Array]:
        rest = 1.0 - basis @ theta[:free]
        speed, slope = _speed(obs.impact_pressure / rest, obs)
        by_error = slope * obs.impact_pressure / (rest * rest)
        residuals = np.empty((axes, n))
        for axis in range(axes):
            wind = theta[free + axis] if free + axis < len(theta) else 0.0
            residuals[axis] = measured[axis] - speed * direction[axis] - wind
            np.multiply(basis, (by_error * direction[axis])[:, None], out=jacobian[axis, :, :free])
        return residuals, jacobian

    return outputs


def _speed(impact: Array, obs: Observations) -> tuple[Array, Array]:
    """True airspeed [m/s] for a true impact pressure [Pa], and its derivative [m/s per Pa]."""
    ratio = impact / obs.static_pressure
    power = np.exp(np.log1p(ratio) * (2.0 / 7.0))
    mach_squared = 5.0 * (power - 1.0)
    heated = 1.0 + obs.probe_heating * mach_squared
    sound_squared = air.HEAT_RATIO * air.GAS_CONSTANT * obs.probe_temperature / heated
    speed = np.sqrt(mach_squared * sound_squared)
    mach_slope = (10.0 / 7.0) * power / ((1.0 + ratio) * obs.static_pressure)
    return speed, 0.5 * mach_slope * sound_squared / (heated * speed)
