"""The interval of a share."""

from math import sqrt

Z = 1.959964  # of a two-sided interval of 95 %


def wilson(hits: int, cases: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson 1927); from 0 to 1 without cases."""
    if not cases:
        return 0.0, 1.0
    share, shrunk = hits / cases, 1.0 + Z * Z / cases
    center = (share + Z * Z / (2 * cases)) / shrunk
    half = Z * sqrt(share * (1.0 - share) / cases + Z * Z / (4 * cases * cases)) / shrunk
    return max(0.0, center - half), min(1.0, center + half)
