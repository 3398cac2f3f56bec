"""The turbulence of a log against that of null flights: its level, and how long it stays.

No mean shows it, only how much and how long the residuals of the wind triangle wander: their autocovariance beyond
the reach of sensor noise, and how it falls with time (MIL-F-8785C: a scale of length over the airspeed).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.reconcile.decide.scoring import usual
from pitotbench.reconcile.residuals.layout import Layout, noise_residuals
from pitotbench.reconcile.residuals.whitening import autocovariance
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate

CHANNELS = ("airspeed_along", "airspeed_across", "airspeed_down")
NEAR, FAR = 1, 6  # instants
SIGNIFICANT = 4.5  # deviations among null flights, of which there are few
LEAST = 0.02  # deviation of a logarithm below which so few flights cannot be trusted


def measures(layout: Layout) -> dict[str, float]:
    """Logarithms: `level` of the gusts' deviation, `scale` of the ratio of far to near autocovariance."""
    places = [layout.residuals.names.index(n) for n in CHANNELS if n in layout.residuals.names]
    covariance = autocovariance(noise_residuals(layout)[:, places], layout.grid)
    near, far = np.maximum(covariance[:, NEAR], 1e-9), np.maximum(covariance[:, FAR], 1e-9)
    return {"level": 0.5 * float(np.mean(np.log(near))), "scale": float(np.mean(np.log(far / near)))}


def usual_gusts(studies: Sequence[Layout]) -> dict[str, tuple[float, float]]:
    """Mean and deviation of the measures over null flights."""
    return usual([measures(s) for s in studies], LEAST)


def turbulence(layout: Layout, known: Mapping[str, tuple[float, float]]) -> tuple[Candidate, ...]:
    """The level of turbulence as an explanation, where it differs from that of the card; none without null
    flights."""
    if not known:
        return ()
    seen = measures(layout)
    told = {name: (seen[name] - mean) / deviation for name, (mean, deviation) in known.items()}
    change = float(np.expm1(seen["level"] - known["level"][0]))
    bound = 2.0 * (1.0 + change) * known["level"][1]
    if abs(told["level"]) < SIGNIFICANT:
        return ()
    size = (Estimate("change", max(change, -1.0), bound),)
    return (Candidate("turbulence_level", size, abs(told["level"]), 1.0, change <= 3.0),)
