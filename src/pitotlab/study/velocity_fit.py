"""The paper's fit of several outputs: ground velocity, predicted from airspeed, attitude, flow
angles and wind.
"""

import numpy as np

from pitotbench import air
from pitotbench.axes import body_to_earth, flow_direction
from pitotbench.calibration.fit_checks import require_observable
from pitotbench.calibration.observations import Observations, observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.output_error import OutputErrorFit, Outputs, fit_output_error
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.calibration.reduction import one_thread, reference_of
from pitotbench.pressure_error import MODELS
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array


def fit_velocity(log: FlightLog, options: CalibrationOptions) -> OutputErrorFit:
    """Fit ground velocity north, east and, with `use_down`, down [m/s]. The error is in the impact
    pressure alone.

    Raises BadInputError where the log has no attitude or no flow angles, NoAnswerError as
    `fit_output_error` does.
    """
    with one_thread():
        obs = observe(log, options)
        model = PredictionModel(MODELS[options.model], reference_of([obs]))
        require_observable(model, obs)
        return fit_output_error(velocity_outputs_of(model, obs, log), np.zeros(model.count))


def _air_direction(log: FlightLog) -> Array:
    """Return the unit vector of the velocity through the air, north, east, down, (3, n).

    Raises BadInputError where the log lacks attitude or a flow angle.
    """
    if log.roll is None or log.pitch is None or log.heading is None:
        raise BadInputError("ground velocity is predicted from the attitude, which the log lacks")
    if log.angle_of_attack is None or log.sideslip is None:
        raise BadInputError(
            "ground velocity is predicted from the flow angles, which the log lacks"
        )
    flow = flow_direction(log.angle_of_attack, log.sideslip)
    return body_to_earth(flow, log.roll, log.pitch, log.heading)


def velocity_outputs_of(model: PredictionModel, obs: Observations, log: FlightLog) -> Outputs:
    """Return the function of θ that gives the residual of ground velocity, (2 or 3, n) [m/s], and
    the Jacobian.

    Raises BadInputError where the log has no attitude or no flow angles.
    """
    direction = _air_direction(log)[:, obs.used]
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
