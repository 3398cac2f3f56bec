"""Attitude, heading and track of a log that holds them in another form."""

import numpy as np

from pitotbench.logbook.draft import Draft
from pitotbench.records.log import Caution
from pitotbench.units import Array


def form_attitude(draft: Draft) -> None:
    """Form roll, pitch and heading from the quaternion that turns body axes to north, east, down.

    Source: Diebel (2006), Representing Attitude, equation 290.
    """
    parts = [draft.channels.pop(f"attitude_q{place}", None) for place in range(4)]
    w, x, y, z = (np.zeros(0) if part is None else part for part in parts)
    if any(part is None for part in parts):
        return
    angles = {
        "roll": np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x**2 + y**2)),
        "pitch": np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0)),
        "heading": np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y**2 + z**2)) % (2.0 * np.pi),
    }
    for name, angle in angles.items():
        if name not in draft.channels:
            draft.put(name, angle, draft.columns["attitude_q0"], "rad")


def form_heading(draft: Draft) -> None:
    magnetic = draft.channels.pop("magnetic_heading", None)
    if magnetic is not None and "heading" not in draft.channels:
        heading = magnetic + variation(draft, "magnetic_heading", "so is the heading")
        column, suffix = draft.columns["magnetic_heading"], draft.suffixes["magnetic_heading"]
        draft.put("heading", heading % (2.0 * np.pi), column, suffix)
    draft.channels.pop("magnetic_variation", None)


def variation(draft: Draft, name: str, consequence: str) -> Array:
    variation = draft.channels.get("magnetic_variation")
    if variation is not None:
        known = np.degrees(variation[np.isfinite(variation)])
        words = f"made true by {draft.columns['magnetic_variation']!r}"
        if len(known) and not any(words in warning for warning in draft.warnings):
            draft.warnings.append(
                f"what is magnetic is {words} ({known.min():.1f} to {known.max():.1f}°, east "
                "positive)"
            )
        return np.asarray(np.nan_to_num(variation), dtype=np.float64)
    draft.warnings.append(
        Caution(
            f"column {draft.columns[name]!r} is magnetic and the log holds no magnetic variation: "
            f"{consequence}",
            "suspect",
        )
    )
    return np.zeros(len(draft.rows))
