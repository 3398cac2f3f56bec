"""The candidate's answer: the curve, the wind and the sources, read off one posterior."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.calibration.covering import Posterior
from pitotbench.calibration.fit_checks import require_observable
from pitotbench.calibration.observations import Observations, observe
from pitotbench.calibration.options import CalibrationOptions, accuracies_of
from pitotbench.calibration.prediction import PredictionModel, curve_airspeeds, wind_by_circle
from pitotbench.calibration.reduction import one_thread, reference_of, screen
from pitotbench.logbook.columns import MAPPING, PARAMETERS
from pitotbench.pressure_error import MODELS
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Disagreement, ErrorCurve, Estimate, WindEstimate
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT, Array, MetersPerSecond
from pitotlab.candidate.fit import Fit, fit
from pitotlab.candidate.heights import height_rows
from pitotlab.candidate.priors import Priors
from pitotlab.candidate.unknowns import ZERO, Unknowns, unknowns_of

DISAGREE = 0.001  # probability of so much disagreement of the equations by chance
_FAR = 3.0  # standard deviations of a prior beyond which an unknown is told
_HALF = 0.5  # probability of an uncalibrated impact-pressure system above which it is told
_CHANGED = 1.5  # m/s between two winds of the slow wind's path, above which it is told
_LEAST_KNOWN = 0.04  # share of the prior variance: a log that resolves less says nothing
# Ratio of impact pressures that a law of the screening needs, and the law.
_SCREENING = ((1.3, "quadratic"), (1.05, "linear"), (1.0, "bias"))


@dataclass(frozen=True, slots=True)
class CandidateAnswer:
    """The curve, the wind of the first flight, and what else the fit says.

    `sources` are Δp/q_c of the static and of the total source in the middle of the curve, each with
    its 2σ. `agreement` is the probability of so large a difference of triangle and heights by
    chance.
    """

    curve: ErrorCurve
    wind: WindEstimate
    winds: tuple[WindEstimate, ...]
    sources: tuple[Estimate, Estimate]
    latency: Estimate
    agreement: float | None
    unknown: float
    warnings: tuple[str, ...]
    disagreements: tuple[Disagreement, ...]
    usable: bool = True


def calibrate(
    log: FlightLog | Sequence[FlightLog],
    options: CalibrationOptions | None = None,
    priors: Priors | None = None,
) -> CandidateAnswer:
    """Calibrate one log, or several of one airplane with one curve.

    Of the options the accuracies, the limits of rows and the use of height and vertical velocity
    count. Raises BadInputError for a log that cannot be used, NoAnswerError for one that does not
    determine the answer.
    """
    logs = [log] if isinstance(log, FlightLog) else list(log)
    chosen, known = options or CalibrationOptions(), priors or Priors()
    stated = accuracies_of(chosen.accuracies, logs[0].header)
    used = replace(chosen, accuracies=stated)
    with one_thread():
        observed = [_screened(each, used) for each in logs]
        flown = [
            (obs, height_rows(each, obs, wind_by_circle(obs)) if used.use_altitude else None)
            for each, obs in zip(logs, observed, strict=True)
        ]
        share = _share_of(logs[0], known)
        unknowns = unknowns_of(
            stated, flown, reference_of(observed), replace(known, unknown_share=share)
        )
        return _read_off(fit(unknowns), observed)


def _share_of(log: FlightLog, priors: Priors) -> float:
    """The probability, before the log is seen, of an impact-pressure system that nobody calibrated.

    The parameters of an autopilot say that its sensor has no calibration but theirs; a log of a
    known recorder comes from an air-data system within its tolerance.
    """
    if PARAMETERS in log.header:
        return 1.0
    return 0.0 if MAPPING in log.header else priors.unknown_share


def _screened(log: FlightLog, options: CalibrationOptions) -> Observations:
    """The rows of a log without the faulty ones, as the product screens them."""
    obs = observe(log, options)
    low, high = np.quantile(obs.impact_pressure, [0.02, 0.98])
    name = next(law for ratio, law in _SCREENING if high / low >= ratio)
    model = PredictionModel(MODELS[name], reference_of([obs]))
    require_observable(model, obs)
    return screen(model, obs, None).observations


@dataclass(frozen=True, slots=True)
class _View:
    """The curve at indicated airspeeds (c,) [m/s] as a function of the unknowns β (p,)."""

    unknowns: Unknowns
    indicated_airspeed: MetersPerSecond
    beta: Array

    @property
    def zero(self) -> int | None:
        """The place of the zero offset of the impact pressure; None without one."""
        return self.unknowns.flights[0].at.get(ZERO)

    def pressure(self) -> Array:
        """q_ci at the ports [Pa], (c,)."""
        zero = 0.0 if self.zero is None else float(self.beta[self.zero])
        return air.impact_pressure(self.indicated_airspeed) - zero

    def sources(self) -> tuple[Array, Array]:
        """The maps (c, p) from β to Δp/q_c of the static and of the total source."""
        q, unknowns = self.pressure(), self.unknowns
        static, total = np.zeros((2, len(q), unknowns.count))
        static[:, unknowns.of_static] = unknowns.static.basis(q)
        total[:, unknowns.of_total] = unknowns.total.basis(q)
        return static, total

    def correction(self) -> MetersPerSecond:
        """Calibrated airspeed minus the raw reading [m/s], (c,)."""
        static, total = self.sources()
        true = self.pressure() / (1.0 - (static + total) @ self.beta)
        return air.calibrated_airspeed(true) - self.indicated_airspeed

    def gradient(self) -> Array:
        """Derivative of the correction by β, (c, p) [m/s]."""
        q, unknowns = self.pressure(), self.unknowns
        static, total = self.sources()
        rest = 1.0 - (static + total) @ self.beta
        slope = air.calibrated_airspeed_slope(q / rest)
        found = (static + total) * (slope * q / rest**2)[:, None]
        if self.zero is not None:
            bend = unknowns.static.slope(q) @ self.beta[unknowns.of_static]
            bend = bend + unknowns.total.slope(q) @ self.beta[unknowns.of_total]
            found[:, self.zero] = -slope * (1.0 + q * bend / rest) / rest
        return np.asarray(found)


def _read_off(found: Fit, observed: Sequence[Observations]) -> CandidateAnswer:
    posterior, unknowns = found.posterior, found.unknowns
    readings = np.concatenate([obs.impact_pressure for obs in observed])
    airspeeds = curve_airspeeds(air.calibrated_airspeed(readings))
    view = _View(unknowns, airspeeds, posterior.mean)
    if np.any(view.pressure() <= 0.0):
        raise NoAnswerError("the impact pressure is hardly more than its zero offset: fly faster")
    static, total = view.sources()
    gradient = view.gradient()
    bounds = posterior.two_sigma(gradient)
    curve = ErrorCurve(
        indicated_airspeed=airspeeds,
        correction=view.correction(),
        two_sigma=bounds,
        simultaneous_two_sigma=posterior.simultaneous(gradient, bounds),
        white_two_sigma=bounds,
        normalized_pressure_error=(static + total) @ view.beta,
        normalized_two_sigma=posterior.two_sigma(static + total),
    )
    winds = tuple(_wind(each.mean, each.covariance) for each in found.winds)
    middle = len(airspeeds) // 2
    sources = tuple(
        _estimate(name, part[middle], posterior)
        for name, part in (("static", static), ("total", total))
    )
    place = unknowns.flights[0].at["latency_s"]
    latency = _estimate("latency_s", np.eye(unknowns.count)[place], posterior)
    apart = found.agreement is not None and found.agreement < DISAGREE
    words = "the wind triangle and the height disagree about the curve by more than chance"
    told = (Disagreement("height", words, float(np.max(bounds)), False),) if apart else ()
    warnings = (*_outside(found), *_of_system(found, observed[0]), *_of_wind(found))
    return CandidateAnswer(
        curve,
        winds[0],
        winds,
        (sources[0], sources[1]),
        latency,
        found.agreement,
        found.unknown,
        warnings,
        told,
    )


def _estimate(name: str, row: Array, posterior: Posterior) -> Estimate:
    bound = float(posterior.two_sigma(row[None])[0]) if np.any(row) else 0.0
    return Estimate(name, float(row @ posterior.mean), bound)


def _wind(mean: Array, covariance: Array) -> WindEstimate:
    bounds = 2.0 * np.sqrt(np.diag(covariance))
    north, east = (
        Estimate(axis, float(mean[i]), float(bounds[i])) for i, axis in enumerate(("north", "east"))
    )
    return WindEstimate(north, east)


_TOLD = {
    "temperature_k": ("temperature", "K"),
    "recovery_factor": ("recovery factor", ""),
    "static_pressure_pa": ("static pressure", "Pa"),
}


def _outside(found: Fit) -> list[str]:
    """A sentence for each constant error that lies beyond 3σ of what its prior lets such logs
    find (Box, Journal of the Royal Statistical Society A 143, 1980).
    """
    posterior, told = found.posterior, []
    deviations = found.unknowns.rivals[0][2]
    for name, (words, unit) in _TOLD.items():
        place = found.unknowns.flights[0].at.get(name)
        if place is None:
            continue
        prior, mean = float(deviations[place]), float(posterior.mean[place])
        left = float(posterior.weights @ posterior.covariances[:, place, place]) / prior**2
        scatter = prior * float(np.sqrt(max(1.0 - left, _LEAST_KNOWN)))
        if abs(mean) > _FAR * scatter:
            told.append(f"the {words} is {mean:+.3g} {unit} off, more than was assumed")
    return told


def _of_system(found: Fit, obs: Observations) -> list[str]:
    """What a large error of the total source or of the impact-pressure sensor may be."""
    place = found.unknowns.of_total.start
    level = _estimate("total", np.eye(found.unknowns.count)[place], found.posterior)
    sound = float(found.unknowns.rivals[0][2][place])
    if abs(level.value) < level.two_sigma or (
        found.unknown < _HALF and abs(level.value) < _FAR * sound
    ):
        return []
    kelvin = -level.value * float(np.median(obs.probe_temperature))
    return [
        f"the airspeed asks for a factor of {(1.0 - level.value) ** -0.5:.3f} ± "
        f"{0.5 * level.two_sigma:.3f} that the static source does not explain: the scale of the "
        f"impact-pressure sensor, a leak of the pitot line, or a temperature {kelvin:+.0f} K off"
    ]


def _of_wind(found: Fit) -> list[str]:
    wind = found.winds[0]
    if wind.jump > _HALF:
        return [f"the wind seems to have jumped (probability {wind.jump:.0%})"]
    if wind.change > _CHANGED:
        return [f"the wind changed by about {wind.change / KNOT:.1f} kt over the flight"]
    return []
