"""Output error as in the paper: maximum likelihood, white residuals of re-estimated covariance.

Klein and Morelli, Aircraft System Identification, 2006, ch. 6 (Gauss-Newton with the modified
Newton-Raphson information matrix); Martos, Kiszely and Foster (2011) used the routine of the same
name from their toolbox. Its bound is the Cramér-Rao bound for white residuals. It is far too small
in real air, where gusts are correlated.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.records import NoAnswerError, UndeterminedError
from pitotbench.units import Array

# standard errors: remaining step at convergence, in the metric of the information matrix
_DECREMENT = 0.02
_ITERATIONS = 50
_HALVINGS = 8
_DAMPINGS = (0.0, 1e-3, 1e-2, 0.1, 1.0, 10.0)  # of the scaled normal equations
_ARMIJO = 0.2
_NOISE_FLOOR = 1e-10  # (m/s)²: gives data without noise a scale for a small step

Outputs = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class OutputErrorFit:
    """θ (p,) with its white Cramér-Rao covariance (p, p).

    The residuals of the m outputs have the standard `deviation` (m,) and the covariance `noise` (m,
    m) [m/s]; kept themselves, they would hold on to the memory of the whole fit of a long log.

    The condition number is that of the scaled information matrix; `reason` says why the iteration
    ended.
    """

    theta: Array
    covariance: Array
    deviation: Array
    noise: Array
    iterations: int
    condition_number: float
    reason: str


def fit_output_error(outputs: Outputs, start: Array) -> OutputErrorFit:
    """Minimize the negative log-likelihood over θ and the residual covariance.

    `outputs(θ)` returns residuals (m, n), measured minus predicted, and the Jacobian (m, n, p) of
    the *prediction*; `start` is θ (p,). Raises NoAnswerError where the start is outside the model's
    domain, the steps do not converge or the information matrix is singular.
    """
    theta = start
    residuals, jacobian = _at_start(outputs, start)
    noise = _residual_covariance(residuals)
    for iteration in range(1, _ITERATIONS + 1):
        information, gradient = _normal_equations(residuals, jacobian, noise)
        scale = np.sqrt(np.diag(information))
        condition = _condition_number(information, scale)
        if not np.isfinite(condition) or condition > 1e13:
            raise UndeterminedError(
                "these rows do not distinguish the parameters (singular information matrix): "
                "fly more headings and a wider speed range, or choose a model with fewer parameters"
            )
        normal, slope = information / np.outer(scale, scale), gradient / scale
        descent = max(float(slope @ np.linalg.solve(normal, slope)), 0.0)
        theta, residuals, jacobian = _step(outputs, theta, normal, slope, scale, noise, residuals)
        noise = _residual_covariance(residuals)
        if np.sqrt(descent) < _DECREMENT:
            information, _ = _normal_equations(residuals, jacobian, noise)
            covariance = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(
                scale, scale
            )
            reason = f"step below {_DECREMENT:g} standard errors after {iteration} iterations"
            deviation = np.array([np.std(each) for each in residuals])
            return OutputErrorFit(theta, covariance, deviation, noise, iteration, condition, reason)
    raise NoAnswerError(
        f"output error did not converge in {_ITERATIONS} iterations (condition number "
        f"{condition:.2g}): "
        "check the log for gross errors, or choose a model with fewer parameters"
    )


def _at_start(outputs: Outputs, start: Array) -> tuple[Array, Array]:
    """The outputs at the start.

    Raises NoAnswerError where the model has no prediction for some row.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        residuals, jacobian = outputs(start)
    if not np.all(np.isfinite(residuals)) or not np.all(np.isfinite(jacobian)):
        raise NoAnswerError(
            "ground velocity and air data do not belong together (no airspeed explains some rows): "
            "check the clock, the order of the rows and the units"
        )
    return residuals, jacobian


def _condition_number(information: Array, scale: Array) -> float:
    """Return the scaled information's condition number, infinite for a parameter without effect."""
    if not np.all(np.isfinite(information)) or not np.all(scale > 0.0):
        return float("inf")
    return float(np.linalg.cond(information / np.outer(scale, scale)))


def _step(
    outputs: Outputs,
    theta: Array,
    normal: Array,
    slope: Array,
    scale: Array,
    noise: Array,
    residuals: Array,
) -> tuple[Array, Array, Array]:
    """Take the Gauss-Newton step, or a damped one (Marquardt 1963).

    Where no part of the step reduces the squares, as in a curved valley, the damping is increased.
    Raises NoAnswerError where no step stays within the model's domain.
    """
    taken = None
    for damping in _DAMPINGS:
        step = np.linalg.solve(normal + damping * np.eye(len(slope)), slope) / scale
        descent = max(float(slope @ (step * scale)), 0.0)
        found, leads_down = _line_search(outputs, theta, step, descent, noise, residuals)
        taken = found if taken is None else taken
        if leads_down or (found is not None and np.sqrt(descent) < _DECREMENT):
            assert found is not None
            return found
    if taken is None:
        raise NoAnswerError(
            "the fit leaves the domain of the model (an impact pressure below zero): "
            "check the log for gross errors, or choose a model with fewer parameters"
        )
    return taken


def _line_search(
    outputs: Outputs, theta: Array, step: Array, descent: float, noise: Array, residuals: Array
) -> tuple[tuple[Array, Array, Array] | None, bool]:
    """Halve the step until the weighted squares fall enough (Armijo), and say whether they do.

    Enough is a fixed share of the fall that the gradient predicts; `descent` is gradient · step.
    Without this condition the steps cross a curved valley from side to side. The first result is
    None where even the shortest step leaves the model's domain.
    """
    weight = np.asarray(np.linalg.inv(noise))
    before = _weighted_squares(residuals, weight)
    for halving in range(_HALVINGS):
        share = 0.5**halving
        with np.errstate(
            invalid="ignore"
        ):  # a step too far may leave the model's domain: it is halved
            new, jacobian = outputs(theta + share * step)
            after = _weighted_squares(new, weight)
        if np.isfinite(after) and after <= before * (1.0 + 1e-9) - 2.0 * _ARMIJO * share * descent:
            return (theta + share * step, new, jacobian), True
    return (theta + share * step, new, jacobian) if np.isfinite(after) else None, False


def _weighted_squares(residuals: Array, weight: Array) -> float:
    return float(np.sum(weight * (residuals @ residuals.T)))


def _residual_covariance(residuals: Array) -> Array:
    floor = _NOISE_FLOOR * np.eye(len(residuals))
    return np.asarray(residuals @ residuals.T / residuals.shape[1] + floor)


def _normal_equations(residuals: Array, jacobian: Array, noise: Array) -> tuple[Array, Array]:
    weight = np.linalg.inv(noise)
    count = jacobian.shape[2]
    information, gradient = np.zeros((count, count)), np.zeros(count)
    weighted = weight @ residuals
    for a in range(len(residuals)):
        gradient += jacobian[a].T @ weighted[a]
        for b in range(a + 1):
            product = weight[a, b] * (jacobian[a].T @ jacobian[b])
            information += product if a == b else product + product.T
    return information, gradient


# rows of the first fit of a long log, which starts the full fit near its minimum
_COARSE_ROWS = 2000


def fit_scalar(
    model: PredictionModel, obs: Observations, start: Array | None = None
) -> OutputErrorFit:
    """Fit one output: indicated airspeed [m/s], predicted from the held velocity and the wind.

    `start` is a first guess of θ (p,), None for no error and no wind.
    Raises NoAnswerError as `fit_output_error` does.
    """
    held = obs.as_held()
    start = np.zeros(model.count) if start is None else start
    if len(held) > _COARSE_ROWS * 4:
        coarse = held.every(len(held) // _COARSE_ROWS)
        start = fit_output_error(airspeed_outputs(model, coarse), start).theta
    return fit_output_error(airspeed_outputs(model, held), start)


def airspeed_outputs(model: PredictionModel, obs: Observations) -> Outputs:
    """Return a function of θ that gives the indicated airspeed's residual, (1, n) [m/s].

    The function gives the Jacobian as well.
    """
    measured = air.calibrated_airspeed(obs.impact_pressure)

    def outputs(theta: Array) -> tuple[Array, Array]:
        prediction = model.predict(theta, obs)
        predicted = air.calibrated_airspeed(prediction.indicated)
        slope = air.calibrated_airspeed_slope(prediction.indicated, predicted)
        return (measured - predicted)[None, :], (prediction.jacobian * slope[:, None])[None, :, :]

    return outputs
