"""The bound expected of a flight before it is flown, for noise that is known or estimated.

With known noise the bound is the inverse information matrix of the geometry alone: speeds, headings
and times. The response of the log is not used; the level and the length of the gusts and the noise
of the receiver's height are given. The calibration estimates them, and its bound is wider: for a
log in gusts that are drawn, it is the fit's own, without the checks of a measured log.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.calibration.altitude import altitude_rows
from pitotbench.calibration.covering import FirstPass, final_pass, posterior_of
from pitotbench.calibration.covering_problem import Structure, linearize, wind_scale
from pitotbench.calibration.fit_checks import USELESS, require_observable
from pitotbench.calibration.nuisances import nuisances_of, with_signs
from pitotbench.calibration.observations import (
    Observations,
    block_length,
    divide,
    observe,
    wind_drifts,
)
from pitotbench.calibration.options import (
    PRIORS,
    CalibrationOptions,
    accuracies_of,
    priors_of,
)
from pitotbench.calibration.prediction import CurveMap
from pitotbench.calibration.reduction import model_of, one_thread, scale_of
from pitotbench.calibration.result import correction_gradient
from pitotbench.estimation.mixture import Posterior
from pitotbench.estimation.restricted_likelihood import solve
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, MetersPerSecond

_LEAST = 1e-4  # m/s, m: stands for a level of zero, whose logarithm does not exist


@dataclass(frozen=True, slots=True)
class ExpectedNoise:
    """The expected noise, of gusts and of the receiver's height.

    Standard deviation [m/s] and length [m] of the gusts, and the standard deviation of the white
    noise [m/s] without that of the pressure sensor.

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
    structure, obs, near = _problem(log, options, wind, noise)
    problem = linearize(structure, obs, divide(obs, block_length(obs)), near.theta)
    # The inverse information matrix, which does not depend on the response.
    covariance = solve(problem.regression, problem.noise_of(near.noise))[1]
    known = np.pad(near.theta, (0, len(structure.nuisances)))
    answer = Posterior(np.ones(1), known[None], covariance[None])
    return _two_sigma(structure, answer, indicated_airspeed)


def two_sigma_in_gusts(
    logs: Sequence[FlightLog],
    options: CalibrationOptions,
    wind: Array,
    noise: ExpectedNoise,
    indicated_airspeed: MetersPerSecond,
) -> Array:
    """Compute 2σ of the curve at indicated airspeeds, (logs, c) [m/s], with estimated noise.

    Parameters as of `expected_two_sigma`, with logs of one flight in gusts. It is the bound of
    `calibrate` by the covering method: its last pass, linearized at the answer of the log before.
    The first log is fitted twice, at first from no error and the noise that is expected. Faulty
    rows are not looked for. Raises NoAnswerError where a log does not determine the answer.
    """
    bounds, near = list[Array](), None
    with one_thread():
        for log in (logs[0], *logs):
            structure, obs, start = _problem(log, options, wind, noise)
            fit = final_pass(structure, obs, near or start)
            answer = posterior_of(fit)
            near = FirstPass(answer.mean[: structure.model.count], fit.likely.noise, (), fit.path)
            bounds.append(_two_sigma(structure, answer, indicated_airspeed))
    if not np.max(np.median(bounds, axis=1)) <= USELESS:  # nor NaN
        raise NoAnswerError("the maneuver does not determine the curve in these gusts")
    return np.stack(bounds[1:])


def _problem(
    log: FlightLog, options: CalibrationOptions, wind: Array, noise: ExpectedNoise
) -> tuple[Structure, Observations, FirstPass]:
    """Return the problem of a log, its rows, and the expectation: no error, wind, noise."""
    stated = accuracies_of(options.accuracies, log.header)
    options = replace(options, accuracies=stated, priors=priors_of(options.priors, log.header))
    obs = observe(log, options)
    model = model_of(options, scale_of([obs]))
    require_observable(model, obs)
    seen = model.static_error and options.use_altitude
    rows = altitude_rows(log, obs, options, wind) if seen else None
    drifting, priors = wind_drifts(options, obs), priors_of(options.priors)
    structure = Structure(model, nuisances_of(options, obs), drifting, priors, rows)
    levels = [noise.gust_deviation, noise.gust_length, noise.white_deviation]
    if structure.drifting:
        levels.append(wind_scale(structure, obs))
    if rows is not None:
        third = noise.height_white if rows.tie is None else noise.height_walk
        levels += [noise.height_deviation, noise.height_memory, third]
    theta = np.concatenate([np.zeros(model.error_count), wind])
    return structure, obs, FirstPass(theta, np.log(np.maximum(levels, _LEAST)), ())


def _two_sigma(
    structure: Structure, answer: Posterior, indicated_airspeed: MetersPerSecond
) -> MetersPerSecond:
    """Return 2σ of the curve of an answer whose nuisances may have either sign."""
    signed = with_signs(answer, structure.nuisances, structure.model.count)
    curve = CurveMap(structure.model, indicated_airspeed)
    return signed.two_sigma(correction_gradient(curve, signed, structure.nuisances))


def geometry_suffices(log: FlightLog, options: CalibrationOptions) -> bool:
    """Return whether a log's headings and speeds would determine its curve if its channels agree.

    The answer is that of the model Inverse+ in gusts of the usual size, with no wind.
    """
    plain = replace(options, model=CalibrationOptions().model, use_down=False, wind_down=False)
    speed = air.calibrated_airspeed(np.quantile(log.impact_pressure, [0.05, 0.5, 0.95]))
    try:
        bound = expected_two_sigma(log, plain, np.zeros(2), ExpectedNoise(PRIORS.gust_mps), speed)
    except (BadInputError, NoAnswerError):
        return False
    return bool(np.all(bound < USELESS))  # not for NaN
