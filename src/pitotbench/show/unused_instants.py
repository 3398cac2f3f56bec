"""Instants of a log that the comparison did not use, in words and as shaded stretches of a picture over time."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.gap import Trace
from pitotbench.timeline import interval, stretches
from pitotbench.units import Array, Booleans

NOT_USED = "not used"
_SHADE = "#F0E0D0"  # unlike the grey of a noise band


def unused_words(traces: Sequence[Trace]) -> str:
    """Return why some instants are shaded, and their share; empty where all were used."""
    if all(np.all(trace.used) for trace in traces):
        return ""
    share = max(float(np.mean(~trace.used)) for trace in traces)
    return (
        f"Shaded: {100.0 * share:.1f} % of the flight that was not used, because the impact pressure stood at the "
        "end of its sensor's range or the Mach number was above the limit."
    )


def shade_unused(axes: Axes, time: Array, used: Booleans) -> None:
    """Shade the stretches of time [min], (n,), that are not used, (n,), with one entry in the legend."""
    half = 0.5 * interval(time)
    changes = np.flatnonzero((np.diff(used.astype(np.int8)) != 0) | (np.diff(time) > 3.0 * half)) + 1
    label = NOT_USED
    for part in stretches(time, changes):
        if not used[part.start]:
            axes.axvspan(time[part.start] - half, time[part.stop - 1] + half, color=_SHADE, lw=0.0, label=label)
            label = "_"
