"""What a scored calibration comes down to: shares inside the bounds, bounds and errors."""

import numpy as np

from pitotbench import bench
from pitotbench.records.calibration import Calibration
from pitotbench.records.flight import Flight
from pitotbench.units import KNOT


def figures(result: Calibration, flight: Flight) -> dict[str, float]:
    """Of one calibration against the truth of its flight: shares of the curve (100 to 160 KIAS) and of the wind's
    components inside 2σ [%], mean 2σ and rms error of the curve and of the wind [kt]."""
    score = bench.score(result, flight)
    wind = np.array([result.wind.north.value, result.wind.east.value]) - bench.wind_toward(flight.case.wind)[:2]
    bound = np.array([result.wind.north.two_sigma, result.wind.east.two_sigma])
    return {
        "coverage_percent": 100.0 * score.curve_coverage,
        "wind_coverage_percent": 100.0 * float(np.mean(np.abs(wind) <= bound)),
        "two_sigma_kt": score.two_sigma / KNOT,
        "rms_error_kt": score.curve_rms_error / KNOT,
        "wind_two_sigma_kt": float(np.mean(bound)) / KNOT,
        "wind_rms_error_kt": float(np.sqrt(np.mean(wind**2))) / KNOT,
    }
