"""The study's names of the maneuvers, and the order in which the paper ranks them."""

import pandas as pd

NAMES = {
    "step_decrease": "Step Decrease",
    "circle": "Circle",
    "rapid_decel": "Rapid Decel",
    "race_track": "Race Track",
    "four_leg": "4-Leg",
    "step_both_ways": "Step Decrease both ways",
}
PAPER_ORDER = tuple(NAMES)[:5]  # smallest 2σ first (Martos et al. 2011, III.E)


def named(rows: dict[str, dict[str, object]]) -> pd.DataFrame:
    """Return a table with one line for each maneuver, in the paper's order and with its name."""
    return pd.DataFrame([{"maneuver": NAMES[m], **rows[m]} for m in NAMES if m in rows])
