"""Compute bounds from a mixture of Gaussians, one for each plausible set of noise parameters.

The noise parameters are unknown. At each of some nodes of their posterior the answer is Gaussian; the weighted
mixture of these is the answer with the noise marginalized (integrated nested Laplace approximations: Rue, Martino
and Chopin 2009; §6.5 for the nodes).
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import ndtr

from pitotbench.units import Array

TWO_SIGMA_SHARE = float(2.0 * ndtr(2.0) - 1.0)  # 95.45 %
_DRAWS, _DRAW_SEED = 600, 20111  # draws for each node; they give the factor to about 1 %
_FULL = 5  # dimensions up to which the design has all corners
_STAR = 1.1  # Rue et al. 2009, §6.5: radius factor of the composite design


@dataclass(frozen=True, slots=True)
class Nodes:
    """Design points in whitened coordinates, (m, d), and their weights for a Gaussian, (m,)."""

    points: Array
    weights: Array


def composite_design(dimensions: int) -> Nodes:
    """Return the center, and star and corner points on a sphere of radius f0·√d, with weights exact for a Gaussian.

    In three dimensions these are 15 points.
    """
    if dimensions == 0:
        return Nodes(np.zeros((1, 0)), np.ones(1))
    radius = _STAR * np.sqrt(dimensions)
    star = np.concatenate([np.eye(dimensions), -np.eye(dimensions)]) * radius
    corners = _corners(dimensions) * _STAR
    outer = np.concatenate([star, corners]) if dimensions > 1 else star
    # Such that Σ w exp(−|z|²/2) = 1 and Σ w exp(−|z|²/2) |z|² = d: exact moments for a Gaussian posterior.
    center = 1.0 - 1.0 / _STAR**2
    each = np.exp(0.5 * radius**2) / (len(outer) * _STAR**2)
    weights = np.concatenate([[center], np.full(len(outer), each)])
    return Nodes(np.concatenate([np.zeros((1, dimensions)), outer]), weights)


def _corners(dimensions: int) -> Array:
    """Return all corners of a cube up to five dimensions; in more dimensions, sixteen of them.

    The sixteen prefer neither a sum nor a product of two coordinates (a fraction of resolution IV: Box, Hunter and
    Hunter 1978).
    """
    if dimensions <= _FULL:
        return np.array(list(product((-1.0, 1.0), repeat=dimensions)))
    base = np.array(list(product((-1.0, 1.0), repeat=4)))
    a, b, c, d = base.T
    return np.stack([a, b, c, d, a * b * c, b * c * d, a * c * d, a * b * d], axis=1)[:, :dimensions]


def half_width(weights: Array, means: Array, deviations: Array, share: float = TWO_SIGMA_SHARE) -> Array:
    """Return the half-width, (c,), of the interval around the mixture mean that holds `share` of the mixture.

    Parameters: weights (m,), with sum 1; means and standard deviations, (m, c), of c quantities.
    """
    # Bisection: 60 halvings take the bracket to rounding, and all quantities are solved together.
    offset = means - weights @ means
    low = np.zeros(means.shape[1])
    high = 12.0 * np.max(deviations + np.abs(offset), axis=0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = weights @ (ndtr((middle - offset) / deviations) - ndtr((-middle - offset) / deviations))
        low, high = np.where(inside < share, middle, low), np.where(inside < share, high, middle)
    return np.asarray(0.5 * (low + high))


def simultaneous_factor(weights: Array, means: Array, covariances: Array, gradient: Array, bounds: Array) -> float:
    """Return the factor, at least 1, by which pointwise bounds must grow to hold at all points at once.

    They then hold together in `TWO_SIGMA_SHARE` of cases. The factor is that quantile of the largest deviation, in
    units of the bounds, over draws of the mixture with a fixed seed.

    Parameters: weights (m,), means (m, p) and covariances (m, p, p) of the mixture; gradient (c, p) of c linear
    functions; bounds, their pointwise half-widths, (c,).
    """
    # A fixed seed makes the bound of one log the same at every run.
    rng = np.random.default_rng(_DRAW_SEED)
    offset = (means - weights @ means) @ gradient.T
    largest = np.empty((len(weights), _DRAWS))
    for node, covariance in enumerate(covariances):
        scale = np.sqrt(np.diag(covariance))
        # The root of a covariance by its eigenvectors: a Cholesky factor fails where rounding makes it singular.
        values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
        root = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
        deviation = offset[node][:, None] + gradient @ root @ rng.standard_normal((len(scale), _DRAWS))
        largest[node] = np.max(np.abs(deviation) / bounds[:, None], axis=0)
    order = np.argsort(largest, axis=None)
    held = np.cumsum(np.repeat(weights / _DRAWS, _DRAWS)[order])
    return max(1.0, float(largest.ravel()[order][np.searchsorted(held, TWO_SIGMA_SHARE)]))
