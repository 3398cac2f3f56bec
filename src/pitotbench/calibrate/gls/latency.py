"""The latency of the GPS velocity against the air data, from planned changes of speed.

A latency has an effect where the airplane accelerates over the ground along the airspeed. But the ground speed also
responds to gusts, by an airspeed hold or by drag alone. These small accelerations imitate a latency (simulated
flights without latency gave −1.0 to −1.5 s on circles and level legs). Therefore only larger accelerations count.
They are smoothed, which also removes the noise of the velocity. A log without any, of steady legs or turns, does
not determine the latency.
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

_PLANNED = 0.4  # m/s²: an idle deceleration has 1, the response to moderate turbulence 0.1
_READINGS = 4  # of the log, at most, each with the latest estimate
_LARGEST = 2.0  # s, of a latency of either sign


def estimate_latency(
    log: FlightLog, options: CalibrationOptions, obs: Observations, structure: Structure, fit: CoveringFit
) -> Estimate:
    """Estimate the latency of the GPS velocity [s], with 2σ.

    It is negative where the air data trail. The 2σ is infinite where the log does not determine it. The rows of the
    fit, `obs`, are read again with each estimate until the estimate settles.
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
    """Return the options with an estimated latency as the GPS latency and its 2σ as the accuracy.

    A greater stated accuracy is kept. Raises NoAnswerError where the latency is unknown.
    """
    if not np.isfinite(latency.two_sigma):
        raise NoAnswerError(
            "the latency is not observable: the log holds no planned change of speed; fly an idle deceleration, "
            "or state the latency in seconds"
        )
    stated = accuracies_of(options.accuracies, {})
    stated = replace(stated, latency_s=max(stated.latency_s, latency.two_sigma))
    return replace(options, gps_latency=latency.value, accuracies=stated)


def latency_warning(latency: float, two_sigma: float) -> str:
    """The warning of a latency that differs from zero by more than its 2σ; both in seconds."""
    late, early = ("GPS velocity", "air data") if latency > 0.0 else ("air data", "GPS velocity")
    return (
        f"the {late} trail the {early} by {abs(latency):.2f} ± {two_sigma:.2f} s (2σ); "
        "use --latency estimated, or state it"
    )
