"""The bound expected of a flight from its geometry alone: the inverse information matrix.

The geometry is speeds, headings and times; the response of the log is not used. The level and the length of the
gusts are assumed known. The calibration estimates them, so its bound is wider.
"""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench.calibrate.accuracy import accuracies_of
from pitotbench.calibrate.gls.covering_fit import covariance_given
from pitotbench.calibrate.gls.linearized_problem import GUST_LENGTH, Structure
from pitotbench.calibrate.model.curve_map import CurveMap
from pitotbench.calibrate.model.nuisances import nuisances_of
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.observability import require_observable
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.calibrate.reduction import reference_of
from pitotbench.calibrate.rows.blocks import block_length, divide
from pitotbench.calibrate.rows.observations import observe
from pitotbench.pressure_error import MODELS
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, MetersPerSecond


@dataclass(frozen=True, slots=True)
class ExpectedNoise:
    """The expected noise: standard deviation [m/s] and length [m] of the gusts, and the standard deviation of the
    white noise [m/s] without that of the pressure sensor."""

    gust_deviation: float
    gust_length: float = GUST_LENGTH
    white_deviation: float = 0.03


def expected_two_sigma(
    log: FlightLog,
    options: CalibrationOptions,
    theta: Array,
    noise: ExpectedNoise,
    indicated_airspeed: MetersPerSecond,
) -> MetersPerSecond:
    """Compute 2σ of the error curve at indicated airspeeds, (c,) [m/s], for known noise.

    Parameters: log, of the flight in smooth air; options; theta (p,), error parameters and wind toward north and
    east [m/s], at which the problem is linearized; noise; indicated_airspeed (c,) [m/s]. Raises NoAnswerError where
    the flight cannot determine the answer.
    """
    options = replace(options, accuracies=accuracies_of(options.accuracies, log.header))
    obs = observe(log, options)
    model = PredictionModel(MODELS[options.model], reference_of([obs]), options.error_location == "static")
    require_observable(model, obs)
    structure = Structure(model, nuisances_of(options, obs), drifting=False)
    phi = np.log([max(noise.gust_deviation, 1e-4), noise.gust_length, noise.white_deviation])
    covariance = covariance_given(structure, obs, divide(obs, block_length(obs)), theta, phi)
    free = model.error_count
    gradient = CurveMap(model, indicated_airspeed).correction_gradient(theta[:free])
    return np.asarray(2.0 * np.sqrt(np.einsum("cp,pq,cq->c", gradient, covariance[:free, :free], gradient)))
