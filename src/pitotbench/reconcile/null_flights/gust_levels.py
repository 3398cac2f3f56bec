"""The turbulence of a log against that of null flights: its level, and how long a gust lasts.

No mean shows it. It shows in how far and how long the residuals of the wind triangle wander: in their
autocovariance beyond the correlation of sensor noise, and in its decrease with time (MIL-F-8785C: a scale of length
over the airspeed).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_measure import Measure, measures_over
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import noise_residuals
from pitotbench.reconcile.residuals.whitening import autocovariance
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate

CHANNELS = ("airspeed_along", "airspeed_across", "airspeed_down")
NEAR, FAR = 1, 6  # instants (0.5 s and 3 s): at lag 0 sensor noise adds to the gusts
SMALLEST = 1e-9  # m²/s², of an autocovariance whose logarithm is taken


def gust_measures(layout: Layout) -> dict[str, float]:
    """Return two logarithms: `level` of the gust deviation, `scale` of the ratio of far to near autocovariance."""
    columns = [layout.residuals.names.index(n) for n in CHANNELS if n in layout.residuals.names]
    covariance = autocovariance(noise_residuals(layout)[:, columns], layout.grid)
    near, far = np.maximum(covariance[:, NEAR], SMALLEST), np.maximum(covariance[:, FAR], SMALLEST)
    return {"level": 0.5 * float(np.mean(np.log(near))), "scale": float(np.mean(np.log(far / near)))}


def gusts_over(layouts: Sequence[Layout]) -> dict[str, Measure]:
    """Return mean and deviation of the gust measures over null flights."""
    return measures_over([gust_measures(layout) for layout in layouts], THRESHOLDS.gust_deviation_lowest)


def turbulence_candidates(layout: Layout, null: Mapping[str, Measure]) -> tuple[Candidate, ...]:
    """Return the level of turbulence as an explanation where it differs from that of the card.

    None without null flights.
    """
    if not null:
        return ()
    level, on_null = gust_measures(layout)["level"], null["level"]
    change = float(np.expm1(level - on_null.mean))
    score = abs(on_null.standardized(level))
    if score < THRESHOLDS.gust_level:
        return ()
    size = Estimate("change", max(change, -1.0), 2.0 * (1.0 + change) * on_null.deviation)
    return (Candidate("turbulence_level", (size,), score, 1.0, change <= THRESHOLDS.gust_change_plausible),)
