"""Convert the injected noise of the impact pressure to airspeed."""

import numpy as np

from pitotbench import air
from pitotbench.records.case import DataSystem
from pitotbench.units import KNOT, Array


def airspeed_noise(airspeed_kt: Array, seconds: Array) -> float:
    """Return 2σ [kt] of white noise of the impact pressure at calibrated airspeeds [kt], each flown for a time [s].

    It is the noise of the default data system [Pa] times the slope of airspeed over impact pressure.
    """
    impact = air.impact_pressure(airspeed_kt * KNOT)
    slope = air.calibrated_airspeed_slope(impact)
    variance = np.average((DataSystem().impact_pressure_noise * slope) ** 2, weights=seconds)
    return 2.0 * float(np.sqrt(variance)) / KNOT
