"""The bound expected of a flight from its geometry alone: the inverse information matrix.

The geometry is speeds, headings and times; the response of the log is not used. The level and the
length of the gusts and the noise of the receiver's height are assumed known. The calibration
estimates them, and its bound is wider.
"""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.calibration.altitude import altitude_rows
from pitotbench.calibration.covering import covariance_given
from pitotbench.calibration.covering_problem import Structure, wind_scale
from pitotbench.calibration.fit_checks import USELESS, require_observable
from pitotbench.calibration.observations import block_length, divide, observe, wind_drifts
from pitotbench.calibration.options import (
    PRIORS,
    CalibrationOptions,
    accuracies_of,
    priors_of,
)
from pitotbench.calibration.prediction import CurveMap, nuisances_of, with_signs
from pitotbench.calibration.reduction import model_of, scale_of
from pitotbench.calibration.result import correction_gradient
from pitotbench.estimation.mixture import Posterior
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, MetersPerSecond

_LEAST = 1e-4  # m/s, m: stands for a level of zero, whose logarithm does not exist


@dataclass(frozen=True, slots=True)
class ExpectedNoise:
    """The expected noise: standard deviation [m/s] and length [m] of the gusts, and the standard
    deviation of the white noise [m/s] without that of the pressure sensor.

    The receiver's height error: standard deviation [m] and correlation time [s] of its slow part,
    the standard deviation of its white part [m] a fix, and the random walk of the integrated
    vertical velocity [m/√s].
    """

    gust_deviation: float
    gust_length: float = PRIORS.gust_length_m
    white_deviation: float = 0.03
    height_deviation: float = 0.0
    height_memory: float = PRIORS.height_memory_s
    height_white: float = 1.5
    height_walk: float = 0.05


def expected_two_sigma(
    log: FlightLog,
    options: CalibrationOptions,
    wind: Array,
    noise: ExpectedNoise,
    indicated_airspeed: MetersPerSecond,
) -> MetersPerSecond:
    """Compute 2σ of the error curve at indicated airspeeds, (c,) [m/s], for known noise.

    Parameters: log, of the flight in smooth air; options; wind toward north and east (2,) [m/s], at
    which the problem is linearized, with no error; noise; indicated_airspeed (c,) [m/s]. Raises
    NoAnswerError where the flight cannot determine the answer. An error of the static source is
    seen by the altitude equation too, where the log has its height. A wind that drifts does so by
    its usual size.
    """
    stated = accuracies_of(options.accuracies, log.header)
    options = replace(options, accuracies=stated, priors=priors_of(options.priors, log.header))
    obs = observe(log, options)
    model = model_of(options, scale_of([obs]))
    require_observable(model, obs)
    rows = None
    if model.static_error and options.use_altitude:
        rows = altitude_rows(log, obs, options, wind)
    structure = Structure(
        model,
        nuisances_of(options, obs),
        wind_drifts(options, obs),
        priors_of(options.priors),
        altitude=rows,
    )
    phi = np.log([max(noise.gust_deviation, _LEAST), noise.gust_length, noise.white_deviation])
    if structure.drifting:
        phi = np.append(phi, np.log(wind_scale(structure, obs)))
    if rows is not None:
        third = noise.height_white if rows.tie is None else noise.height_walk
        phi = np.append(
            phi, np.log(np.maximum([noise.height_deviation, noise.height_memory, third], _LEAST))
        )
    theta = np.concatenate([np.zeros(model.error_count), wind])
    covariance = covariance_given(structure, obs, divide(obs, block_length(obs)), theta, phi)
    known = np.zeros(len(covariance))
    known[: len(theta)] = theta
    answer = with_signs(
        Posterior(np.ones(1), known[None], covariance[None]), structure.nuisances, model.count
    )
    gradient = correction_gradient(CurveMap(model, indicated_airspeed), answer, structure.nuisances)
    return answer.two_sigma(gradient)


def geometry_suffices(log: FlightLog, options: CalibrationOptions) -> bool:
    """Return whether the headings and speeds of a log would determine its curve if the channels
    agreed.

    The answer is that of the model Inverse+ in gusts of the usual size, with no wind.
    """
    plain = replace(options, model=CalibrationOptions().model, use_down=False, wind_down=False)
    speed = air.calibrated_airspeed(np.quantile(log.impact_pressure, [0.05, 0.5, 0.95]))
    try:
        bound = expected_two_sigma(log, plain, np.zeros(2), ExpectedNoise(PRIORS.gust_mps), speed)
    except (BadInputError, NoAnswerError):
        return False
    return bool(np.all(bound < USELESS))  # not for NaN
