"""The height that was flown by its pilot's word, for a log without height and static pressure."""

import re

import numpy as np

from pitotbench import air
from pitotbench.logbook.columns import HEIGHT
from pitotbench.logbook.draft import Draft
from pitotbench.records import BadInputError
from pitotbench.units import to_si

_STATED = re.compile(
    r"(?P<height>[+-]?\d+(\.\d+)?)\s*((±|\+-|\+/-|/)\s*(?P<spread>\d+(\.\d+)?))?\s*(?P<unit>ft|m)?"
)
_LOWEST, _HIGHEST = -500.0, 20e3  # m
USUAL = 150.0  # m, 2σ: a height that is kept by eye


def stated_height(text: str) -> tuple[float, float]:
    """Return the height above the sea and its 2σ [m] of `2000` (ft), `600m` or `2000±300ft`.

    Raises BadInputError for any other text, and for a height that no airplane flies.
    """
    found = _STATED.fullmatch(text.strip().lower().replace("−", "-"))
    if found is None:
        raise BadInputError(
            f"height {text!r}: write the height above the sea that was flown, such as 2000 (ft), "
            "600m or 2000±300ft"
        )
    unit = found["unit"] or "ft"
    height = float(to_si(float(found["height"]), unit))
    if not _LOWEST < height < _HIGHEST:
        raise BadInputError(f"height {text!r}: no airplane flies there; write it in ft or m")
    spread = found["spread"]
    return height, USUAL if spread is None else float(to_si(float(spread), unit))


def take_height(draft: Draft, text: str, weather: float) -> float:
    """Give a log the standard static pressure at a stated height, and return its 2σ [Pa].

    The 2σ holds that of the height and what the `weather` adds [m]. Raises as `stated_height` does.
    """
    height, spread = stated_height(text)
    low, high = (float(air.standard_pressure(height + step)) for step in (-1.0, 1.0))
    pressure = np.full(len(draft.rows), air.standard_pressure(height))
    draft.put("static_pressure", pressure, HEIGHT, "pa")
    two_sigma = float(np.hypot(spread, weather))
    draft.warnings.append(
        f"the height of {text} is stated: the static pressure is that of a standard day there, "
        f"±{two_sigma:.0f} m (2σ)"
    )
    return two_sigma * (low - high) / 2.0
