"""An error curve held against that of a handbook, in sentences and as plain data."""

from typing import Any

import numpy as np

from pitotbench.records.calibration import Calibration, ErrorCurve, PublishedCurve
from pitotbench.show.calibration import Correction
from pitotbench.show.columns import with_minus_signs
from pitotbench.show.curve_rows import published_at
from pitotbench.show.words import capital
from pitotbench.timeline import minutes_text
from pitotbench.units import KNOT, percent_text


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
        f"at {percent_text(inside.sum() / known.sum())} of {span}" if inside.any() else "nowhere"
    )
    by_log = Correction(float(speed[at]), float(curve.correction_kt[at]), float(bound[at]))
    by_book = f"{curve.correction_kt[at] + difference[at]:+.1f} kt"
    return (
        f"The handbook's correction ({name}) lies inside ±2σ {where}; at {speed[at]:.0f} KIAS it "
        f"is {with_minus_signs(by_book)}, that of the log {by_log}."
    )


def handbook_advice(result: Calibration, published: PublishedCurve) -> str:
    """Say what to do where the correction of a handbook lies outside the bound of a curve.

    Leave out the parts that are flown there, or fly there again. Empty where none lies outside.
    """
    curve = result.curve
    speed = curve.indicated_airspeed
    outside = np.abs(published_at(curve, published) - curve.correction) > curve.two_sigma
    if not outside.any():
        return ""
    low, high = speed[outside][[0, -1]] / KNOT
    again = f"fly {low:.0f} to {high:.0f} KIAS again with flaps and gear as the handbook has them"
    there = np.interp(result.residuals.indicated_airspeed, speed, outside.astype(float)) > _MOSTLY
    time = result.residuals.time
    parts = [
        f"--without {'-'.join(minutes_text(t - result.log_start) for t in (begin, end))}"
        for begin, end in result.parts
        for rows in [(time >= begin) & (time <= end)]
        if rows.any() and np.mean(there[rows]) > _MOSTLY
    ]
    if not 0 < len(parts) < len(result.parts):
        return f"{capital(again)}."
    return (
        f"{len(parts)} of the {len(result.parts)} parts used are flown mostly where the two differ, "
        "perhaps with flaps or gear down, for which a handbook has other rows: leave them out "
        f"({' '.join(parts)}), or {again}."
    )


_MOSTLY = 0.5  # share of the samples of a part, and of the way between two airspeeds


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
