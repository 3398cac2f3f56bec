"""Bounds from a mixture: noise parameters are unknown, so every node of their posterior gets its say.

Each node of the noise posterior gives a Gaussian answer; their weighted mixture is the answer with the noise
marginalized (integrated nested Laplace approximations: Rue, Martino and Chopin 2009, §6.5 for the nodes).
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import ndtr

from pitotbench.units import Array

TWO_SIGMA_SHARE = float(2.0 * ndtr(2.0) - 1.0)  # 95.45 %
_DRAWS, _DRAW_SEED = 600, 20111  # a node; the factor is then good to about 1 %
_FULL = 5  # dimensions up to which the design has all corners
_STAR = 1.1  # Rue et al. 2009, §6.5: radius factor of the composite design


@dataclass(frozen=True, slots=True)
class Nodes:
    """Design points in whitened coordinates, (m, d), and their base weights, (m,)."""

    points: Array
    weights: Array


def composite_design(dimensions: int) -> Nodes:
    """Center, star and corner points on a sphere of radius f0·√d, with weights exact for a Gaussian."""
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
    """All corners of a cube up to five dimensions; beyond, sixteen of them, chosen such that neither a sum nor a
    product of two coordinates is preferred (a fraction of resolution IV: Box, Hunter and Hunter 1978)."""
    if dimensions <= _FULL:
        return np.array(list(product((-1.0, 1.0), repeat=dimensions)))
    base = np.array(list(product((-1.0, 1.0), repeat=4)))
    a, b, c, d = base.T
    return np.stack([a, b, c, d, a * b * c, b * c * d, a * c * d, a * b * d], axis=1)[:, :dimensions]


def half_width(weights: Array, means: Array, deviations: Array, share: float = TWO_SIGMA_SHARE) -> Array:
    """Half-width of the interval around the mixture mean that holds `share` of the mixture.

    Parameters: weights (m,), summing to 1; means and deviations (m, c) of c quantities. Returns (c,).
    """
    offset = means - weights @ means
    low = np.zeros(means.shape[1])
    high = 12.0 * np.max(deviations + np.abs(offset), axis=0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        inside = weights @ (ndtr((middle - offset) / deviations) - ndtr((-middle - offset) / deviations))
        low, high = np.where(inside < share, middle, low), np.where(inside < share, high, middle)
    return np.asarray(0.5 * (low + high))


def simultaneous_factor(weights: Array, means: Array, covariances: Array, gradient: Array, bounds: Array) -> float:
    """By how much pointwise bounds must grow so that all of them hold at once in `TWO_SIGMA_SHARE` of cases.

    Parameters: a mixture of weights (m,), means (m, p), covariances (m, p, p); gradient (c, p) of c linear
    functions with pointwise half-widths (c,). The largest deviation in units of its bound, over draws of the
    mixture with fixed seed. At least 1.
    """
    rng = np.random.default_rng(_DRAW_SEED)
    offset = (means - weights @ means) @ gradient.T
    largest = np.empty((len(weights), _DRAWS))
    for node, covariance in enumerate(covariances):
        scale = np.sqrt(np.diag(covariance))
        values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
        root = scale[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
        deviation = offset[node][:, None] + gradient @ root @ rng.standard_normal((len(scale), _DRAWS))
        largest[node] = np.max(np.abs(deviation) / bounds[:, None], axis=0)
    order = np.argsort(largest, axis=None)
    held = np.cumsum(np.repeat(weights / _DRAWS, _DRAWS)[order])
    return max(1.0, float(largest.ravel()[order][np.searchsorted(held, TWO_SIGMA_SHARE)]))
