"""Output error as the paper has it: maximum likelihood with white residuals whose covariance is re-estimated.

Klein and Morelli, Aircraft System Identification, 2006, ch. 6 (Gauss-Newton with the modified Newton-Raphson
information matrix); Martos, Kiszely and Foster (2011) used the routine of the same name from their toolbox.
The bound that belongs to it is the Cramér-Rao bound for white residuals: far too small on real air.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

_DECREMENT = 0.02  # standard errors: the step left to take, in the metric of the information matrix
_ITERATIONS = 50
_HALVINGS = 8
_ARMIJO = 0.2
_NOISE_FLOOR = 1e-10  # (m/s)²: data without noise still have a scale on which a step is small

Outputs = Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class OutputErrorFit:
    """θ (p,), its white Cramér-Rao covariance (p, p), residuals (m, n), their covariance (m, m) and the way."""

    theta: Array
    covariance: Array
    residuals: Array
    noise: Array
    iterations: int
    condition_number: float
    reason: str


def fit_output_error(outputs: Outputs, start: Array) -> OutputErrorFit:
    """Minimize the negative log-likelihood over θ and the residual covariance.

    `outputs(θ)` returns residuals (m, n), measured minus predicted, and the Jacobian (m, n, p) of the
    *prediction*. Raises NoAnswerError where the steps do not settle or the information matrix is singular.
    """
    theta = start
    residuals, jacobian = outputs(theta)
    noise = _residual_covariance(residuals)
    for iteration in range(1, _ITERATIONS + 1):
        information, gradient = _normal_equations(residuals, jacobian, noise)
        scale = np.sqrt(np.diag(information))
        condition = float(np.linalg.cond(information / np.outer(scale, scale)))
        if not np.isfinite(condition) or condition > 1e13:
            raise NoAnswerError(
                "the parameters cannot be told apart from these rows (singular information matrix): "
                "fly more headings and a wider speed range, or choose a model with fewer parameters"
            )
        step = np.linalg.solve(information / np.outer(scale, scale), gradient / scale) / scale
        descent = max(float(gradient @ step), 0.0)
        theta, residuals, jacobian = _line_search(outputs, theta, step, descent, noise, residuals)
        noise = _residual_covariance(residuals)
        if np.sqrt(descent) < _DECREMENT:
            information, _ = _normal_equations(residuals, jacobian, noise)
            covariance = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
            reason = f"step below {_DECREMENT:g} standard errors after {iteration} iterations"
            return OutputErrorFit(theta, covariance, residuals, noise, iteration, condition, reason)
    raise NoAnswerError(
        f"output error did not converge in {_ITERATIONS} iterations (condition number {condition:.2g}): "
        "check the log for gross errors, or choose a model with fewer parameters"
    )


def _line_search(
    outputs: Outputs, theta: Array, step: Array, descent: float, noise: Array, residuals: Array
) -> tuple[Array, Array, Array]:
    """Take the step, halved until the weighted squares fall by a fair share of what the gradient promises.

    `descent` is gradient · step. Without the Armijo condition a curved valley is crossed from side to side.
    """
    weight = np.asarray(np.linalg.inv(noise))
    before = _weighted_squares(residuals, weight)
    for halving in range(_HALVINGS):
        share = 0.5**halving
        with np.errstate(invalid="ignore"):  # a step too far may leave the model's domain: it is halved
            new, jacobian = outputs(theta + share * step)
            after = _weighted_squares(new, weight)
        if np.isfinite(after) and after <= before * (1.0 + 1e-9) - 2.0 * _ARMIJO * share * descent:
            return theta + share * step, new, jacobian
    if not np.isfinite(after):
        raise NoAnswerError(
            "the fit leaves the domain of the model (an impact pressure below zero): "
            "check the log for gross errors, or choose a model with fewer parameters"
        )
    return theta + share * step, new, jacobian


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
