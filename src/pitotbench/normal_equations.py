"""The inverse of the normal equations of a linear fit, whatever the units of its columns."""

import numpy as np

from pitotbench.units import Array

# Of columns that are each scaled to 1, the share of the strongest axis that is rounding.
ROUNDING = 1e-13


def inverse(matrix: Array, least: float = ROUNDING) -> Array:
    """Return the inverse of a symmetric matrix without negative powers, of columns in any units.

    Each column is scaled to 1. Axes with less than the share `least` of the strongest are left out,
    and so is an empty column.
    """
    diagonal = np.diag(matrix)
    scale = np.where(diagonal > 0.0, 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)), 0.0)
    powers, axes = np.linalg.eigh(matrix * (scale[:, None] * scale))
    known = powers > least * np.max(powers, initial=0.0)
    return np.asarray(
        (axes[:, known] / powers[known]) @ axes[:, known].T * (scale[:, None] * scale)
    )
