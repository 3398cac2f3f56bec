"""The bound that a log of a flight will have, from where the flight goes alone: the inverse information matrix.

The response of the log is not looked at, only the geometry: speeds, headings, times. The level and the length of
the gusts are taken as known, so the calibrator's own bound, which has to find them, is wider.
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
    """What is expected: standard deviation [m/s] and length [m] of the gusts, and of the white noise beside the
    pressure sensor's [m/s]."""

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
    """2σ of the error curve at indicated airspeeds [m/s] (c,), for noise that is known.

    Parameters: log, of the flight in smooth air; theta (p,), error parameters and wind toward north and east [m/s],
    about which the problem is linearized. Raises NoAnswerError where the flight cannot determine the answer.
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
