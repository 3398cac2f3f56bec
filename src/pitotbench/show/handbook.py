"""An error curve held against that of a handbook, in sentences and as plain data."""

from typing import Any

import numpy as np

from pitotbench.records.calibration import ErrorCurve, PublishedCurve
from pitotbench.show.calibration import Correction
from pitotbench.show.columns import with_minus_signs
from pitotbench.show.curve_rows import published_at
from pitotbench.units import KNOT


def handbook_sentence(curve: ErrorCurve, published: PublishedCurve) -> str:
    """Say where a curve agrees with that of a handbook."""
    speed, bound = curve.indicated_airspeed_kt, curve.two_sigma_kt
    name = ", ".join(each for each in (published.source, published.configuration) if each)
    difference = (published_at(curve, published) - curve.correction) / KNOT
    known = np.isfinite(difference)
    if not known.any():
        flown = f"between {speed[0]:.0f} and {speed[-1]:.0f} KIAS"
        return f"The handbook ({name}) has no airspeed {flown}."
    inside = known & (np.abs(difference) <= bound)
    span = f"{speed[known][0]:.0f} to {speed[known][-1]:.0f} KIAS"
    if inside.sum() == known.sum():
        return f"The handbook's correction ({name}) lies inside ±2σ at all of {span}."
    at = int(np.nanargmax(np.abs(difference) - bound))
    where = (
        f"at {100.0 * inside.sum() / known.sum():.0f} % of {span}" if inside.any() else "nowhere"
    )
    by_log = Correction(float(speed[at]), float(curve.correction_kt[at]), float(bound[at]))
    by_book = f"{curve.correction_kt[at] + difference[at]:+.1f} kt"
    return (
        f"The handbook's correction ({name}) lies inside ±2σ {where}; at {speed[at]:.0f} KIAS it "
        f"is {with_minus_signs(by_book)}, that of the log {by_log}."
    )


def handbook_json(curve: ErrorCurve) -> dict[str, Any]:
    """The curves of a handbook as plain data; no key without one."""
    found = [
        {
            "file": each.source,
            "configuration": each.configuration or None,
            "indicated_airspeed_kt": (each.indicated_airspeed / KNOT).round(3).tolist(),
            "calibrated_airspeed_kt": (each.calibrated_airspeed / KNOT).round(3).tolist(),
            "words": handbook_sentence(curve, each),
        }
        for each in curve.published
    ]
    return {"handbook": found} if found else {}
