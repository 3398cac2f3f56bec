"""Round numbers for an axis, and how they are written."""

from math import ceil, floor, log10

import numpy as np

from pitotbench.units import Array

_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_MOST, _FEWEST = 9, 2
_SLACK = 1e-9  # steps: a limit this close to a tick is on it


def ticks_between(low: float, high: float, most: int) -> Array:
    """Return multiples of a round step between two limits: no more than about `most`, at least two."""
    raw = (high - low) / min(max(most, 1), _MOST)
    power = 10.0 ** floor(log10(raw))
    steps = [scale * power * step for scale in (0.01, 0.1, 1.0) for step in _STEPS[:-1]] + [10.0 * power]
    usable = [step for step in steps if step < raw * (1.0 - _SLACK)]
    fitting = steps[len(usable)]
    for step in (fitting, *reversed(usable)):
        first, last = ceil(low / step - _SLACK), floor(high / step + _SLACK)
        if last - first + 1 >= _FEWEST:
            break
    return np.arange(first, last + 1, dtype=np.float64) * step


def tick_words(ticks: Array) -> list[str]:
    """Return the ticks with as many decimals as tell them apart; numbers far from one as powers of ten."""
    spread = float(np.ptp(ticks)) or float(np.max(np.abs(ticks))) or 1.0
    order = floor(log10(spread))
    if not -5 < floor(log10(float(np.max(np.abs(ticks))) or 1.0)) < 6:
        return [_minus(f"{tick:g}") for tick in ticks]
    decimals = max(0, 3 - order)
    while decimals > 0 and np.allclose(ticks, np.round(ticks, decimals - 1), rtol=0.0, atol=1e-3 * 10.0**order):
        decimals -= 1
    return [_minus(f"{tick:.{decimals}f}") for tick in ticks]


def _minus(text: str) -> str:
    zero = text.strip("-0.") == "" and text.startswith("-")
    return text[1:] if zero else text.replace("-", "−")
