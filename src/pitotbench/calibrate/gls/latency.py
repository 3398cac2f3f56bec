"""By how much GPS velocity trails the air data, from planned changes of speed.

A latency shows where the ground accelerates along the airspeed. An airspeed hold, and drag alone, answer gusts with
ground speed: such small accelerations make a latency of a second appear that is none (measured on simulated
flights without latency: −1.0 to −1.5 s on circles and level legs). So only accelerations beyond those count,
smoothed, which also keeps the velocity's own noise out. Logs without any (steady legs, turns) say nothing about
latency.
"""

from dataclasses import replace

import numpy as np

from pitotbench.calibrate.accuracy import accuracies_of
from pitotbench.calibrate.gls.covering_fit import CoveringFit, acceleration_effect
from pitotbench.calibrate.gls.linearized_problem import Structure
from pitotbench.calibrate.model.nuisances import Nuisance, by_latency
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.calibrate.rows.observations import Observations, observe_again
from pitotbench.records.calibration import Estimate
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.log import FlightLog

_PLANNED = 0.4  # m/s²: an idle deceleration has 1, the answer to moderate turbulence 0.1
_READINGS = 4
_LARGEST = 2.0  # s


def estimate_latency(
    log: FlightLog, options: CalibrationOptions, obs: Observations, structure: Structure, fit: CoveringFit
) -> Estimate:
    """Latency of the GPS velocity [s], with 2σ; negative where the air data trail; 2σ infinite where unknown.

    The rows of the fit, `obs`, are read again with what was found, until it stays.
    """
    column = Nuisance("latency_s", _PLANNED, by_latency)
    total = options.gps_latency
    for _ in range(_READINGS):
        read = observe_again(log, replace(options, gps_latency=total), obs)
        found = acceleration_effect(structure, read, fit, column)
        total = float(np.clip(total + found.value, -_LARGEST, _LARGEST))
        if abs(found.value) < 0.1 * found.two_sigma:
            break
    return Estimate("latency_s", total, found.two_sigma)


def with_latency(options: CalibrationOptions, latency: Estimate) -> CalibrationOptions:
    """Options with an estimated latency taken off and its 2σ carried. Raises NoAnswerError where it is unknown."""
    if not np.isfinite(latency.two_sigma):
        raise NoAnswerError(
            "the latency is not observable: the log holds no planned change of speed; fly an idle deceleration, "
            "or state the latency in seconds"
        )
    stated = accuracies_of(options.accuracies, {})
    stated = replace(stated, latency_s=max(stated.latency_s, latency.two_sigma))
    return replace(options, gps_latency=latency.value, accuracies=stated)


def latency_warning(latency: float, two_sigma: float) -> str:
    """What a significant latency means, in words."""
    late, early = ("GPS velocity", "air data") if latency > 0.0 else ("air data", "GPS velocity")
    return (
        f"the {late} trail the {early} by {abs(latency):.2f} ± {two_sigma:.2f} s (2σ); "
        "use --latency estimated, or state it"
    )
