"""Compare linear models by the evidence for further columns.

The columns' coefficients have a normal prior around zero. With the other coefficients integrated
out, the ratio of the evidences with and without them needs only products of the columns with the
whitened rows (the Schur complement of the normal equations; the evidence of a linear model: Bishop,
Pattern Recognition and Machine Learning, 2006, §3.5), so that many sets of columns and many sizes
of a prior cost one solution with the covariance.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.estimation.information import Information, information_from
from pitotbench.estimation.noise import Noise
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class EvidencePart:
    """Rows whose noise is independent of that of other parts.

    `response` (n,), `regressors` (n, p) of the fitted coefficients, `further` (n, m) columns, and
    their noise.
    """

    response: Array
    regressors: Array
    further: Array
    noise: Noise


@dataclass(frozen=True, slots=True)
class ColumnEvidence:
    """What the rows say of further columns when the fitted coefficients are integrated out.

    `log_likelihood` is the restricted log-likelihood without them, up to a constant, and
    `information` (m + 1, m + 1) that of the further columns. `moved` (p, m) is the change of the
    estimates of the fitted coefficients per unit of a further one.
    """

    log_likelihood: float
    information: Information
    moved: Array


def column_evidence(
    parts: Sequence[EvidencePart], prior_precision: Array, prior_pull: Array | None = None
) -> ColumnEvidence:
    """Compute the evidence for further columns.

    `prior_precision` (p,) is that of the fitted coefficients, `prior_pull` (p,) the precision times
    the prior mean, None for a mean of zero.

    Raises numpy.linalg.LinAlgError where the rows do not determine the fitted coefficients.
    """
    p = len(prior_precision)
    count = p + 1 + parts[0].further.shape[1]
    products, determinant = np.zeros((count, count)), 0.0
    for part in parts:
        data = np.column_stack([part.regressors, part.response, part.further])
        products += data.T @ part.noise.weigh(data)
        determinant += part.noise.log_determinant
    products.flat[: p * count : count + 1] += prior_precision
    if prior_pull is not None:
        products[:p, p] += prior_pull
        products[p, :p] += prior_pull
    scale = np.sqrt(np.diag(products)[:p])
    normal = products[:p, :p] / np.outer(scale, scale)
    root = np.linalg.cholesky(normal)
    explained = np.linalg.solve(root, products[:p, p:] / scale[:, None])
    rest = products[p:, p:] - explained.T @ explained
    determinant += 2.0 * float(np.sum(np.log(np.diag(root)) + np.log(scale)))
    moved = -np.linalg.solve(root.T, explained[:, 1:]) / scale[:, None]
    square = float(rest[0, 0])
    information = information_from(rest[1:, 1:], rest[1:, 0], square)
    return ColumnEvidence(-0.5 * (determinant + square), information, moved)
