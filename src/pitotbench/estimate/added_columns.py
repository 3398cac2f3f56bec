"""A noise plus columns with random factors: a covariance C + σ² S Sᵀ, by the matrix-inversion lemma."""

import numpy as np

from pitotbench.estimate.joint_noise import Noise
from pitotbench.units import Array


class AddedColumns:
    """The covariance of a noise plus columns S (n, k) with independent factors of one standard deviation.

    Such a column is an effect that is estimated with a prior and eliminated: regressors stay what they are.
    """

    def __init__(self, noise: Noise, columns: Array, deviation: float) -> None:
        self._noise, self._columns = noise, deviation * columns
        self._weighed = noise.weigh(self._columns)
        inner = np.eye(columns.shape[1]) + self._columns.T @ self._weighed
        self._inverse = np.linalg.inv(inner)
        self.log_determinant = noise.log_determinant + float(np.linalg.slogdet(inner)[1])

    def weigh(self, data: Array) -> Array:
        """The inverse covariance times data of shape (n, k)."""
        weighed = self._noise.weigh(data)
        return np.asarray(weighed - self._weighed @ (self._inverse @ (self._columns.T @ weighed)))
