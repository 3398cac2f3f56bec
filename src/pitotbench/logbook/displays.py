"""What a display shows comes in steps: how large they are, and what they leave unknown.

Within a step nobody knows the value, so that half a step and less stays as a constant error of each
reading. The header's table `display` holds the steps, from which the calibration widens its bound,
and `accuracy` what they leave of the velocity, where the header does not state another one.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from pitotbench.units import Array, from_si, to_si

TWO_SIGMA = float(2.0 / np.sqrt(12.0))  # of a value known to one step, in steps
_FINE = 1e-3  # of the median size of the values: a finer step does not matter
_ON_GRID = 1e-6  # of a step: what the rounding of a decimal leaves


def state_accuracy(header: dict[str, Any], name: str, two_sigma: float) -> None:
    """Put the accuracy of a channel into the header, unless the header states one."""
    header["accuracy"] = {name: two_sigma, **table_in(header, "accuracy")}


def display_step(values: Array, suffix: str) -> float:
    """Return the step of a display [SI], of which its numbers (n,) are whole multiples.

    The numbers are those in the unit of `suffix`.

    0 where no step is seen, or where it is finer than a thousandth of the values.
    """
    written = (
        np.unique(np.round(from_si(values[np.isfinite(values)], suffix), 9))
        if suffix
        else np.zeros(0)
    )
    if len(written) < 2:
        return 0.0
    step = float(np.min(np.diff(written)))
    typical = float(np.median(np.abs(written)))
    steps = written / step
    if step <= _FINE * typical or np.max(np.abs(steps - np.round(steps))) > max(
        _ON_GRID * np.max(np.abs(steps)), 1e-6
    ):
        return 0.0
    return float(to_si(step, suffix) - to_si(0.0, suffix))


def table_in(header: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = header.get(name, {})
    return found if isinstance(found, Mapping) else {}
