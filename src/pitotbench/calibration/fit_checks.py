"""Checks of a fit: what a log determines, what curve is possible, what lies outside its prior."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pitotbench.calibration.altitude import NOISE_COUNT
from pitotbench.calibration.covering import CoveringFit, Flown, moved_by
from pitotbench.calibration.covering_problem import Structure, length_factor, wind_scale
from pitotbench.calibration.nuisances import Nuisance, in_turns, side_of_turns
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.prediction import PredictionModel, curve_moved
from pitotbench.estimation.mixture import Posterior, mixed
from pitotbench.logbook.plausible_air import LIMITS
from pitotbench.records import NoAnswerError, OneHeadingError, UndeterminedError
from pitotbench.records.calibration import (
    Calibration,
    Disagreement,
    ErrorCurve,
    Estimate,
    Residuals,
)
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import Caution, CurveMove, FlightLog
from pitotbench.units import DEGREE, KNOT, Array, Booleans, MetersPerSecond, percent_text

# Checks that a log determines the requested answer. A number that it does not determine is never
# returned.

# below it the along-track wind and the curve's level are one unknown
_HEADING_SPREAD = 30.0 * DEGREE
# Number of terms to the ratio of impact pressures that they need.
_SPEED_RATIO = {1: 1.0, 2: 1.05, 3: 1.10}
_SPLINE_RATIO = 1.3  # the same for a model of more terms
USELESS = 10.0 * KNOT  # a bound beyond this is no answer
# Two legs, reciprocal ones too, leave the wind across them unknown.
FLY_HEADINGS = "fly legs on three headings at least 60° apart, or a full turn"


def require_observable(model: PredictionModel, obs: Observations) -> None:
    """Raise NoAnswerError, with what to fly next, where headings or speeds are too similar."""
    for axis, velocity in (("north", obs.velocity_north), ("east", obs.velocity_east)):
        if not np.any(velocity):
            raise NoAnswerError(
                f"the wind is not observable: the ground velocity toward {axis} is zero in every "
                "row: check it"
            )
    spread = heading_spread(obs)
    if spread < _HEADING_SPREAD:
        raise OneHeadingError(
            f"the wind is not observable: all headings lie within {spread / DEGREE:.0f}°; "
            f"{FLY_HEADINGS}"
        )
    low, high = np.quantile(obs.impact_pressure, [0.02, 0.98])
    # What a log does not tell of a curve with a prior, the prior tells.
    free = int(np.sum(np.all(model.error.precisions == 0.0, axis=0)))
    needed = _SPEED_RATIO.get(free, _SPLINE_RATIO)
    if high / low < needed:
        raise NoAnswerError(
            f"the airspeed hardly changes (impact pressure {low:.0f} to {high:.0f} Pa): the model "
            f"{model.error.name!r} with {model.error_count} parameters needs a ratio of "
            f"{needed:g}; use --model bias, or fly a wider speed range"
        )


def heading_spread(obs: Observations) -> float:
    """Return the width of the smallest arc that contains 98 % of the ground tracks [rad]."""
    thin = max(1, len(obs) // 5000)
    track = np.sort(np.arctan2(obs.velocity_east[::thin], obs.velocity_north[::thin]))
    keep = int(np.ceil(0.98 * len(track)))
    wrapped = np.concatenate([track, track + 2.0 * np.pi])
    return float(np.min(wrapped[keep - 1 : keep - 1 + len(track)] - wrapped[: len(track)]))


_ONE_LINE = 0.9  # of the mean of e^2iψ: tracks within some 13° of a line, as out and back on a road


def require_useful(calibration: Calibration, log: FlightLog) -> None:
    """Raise NoAnswerError where a bound is above 10 kt or not finite.

    The bounds are 2σ of half the curve, and of the best known wind. The wind across a line that was
    flown out and back is unknown, and the curve holds that.
    """
    wind = min(
        (max(each.north.two_sigma, each.east.two_sigma) for each in calibration.winds), default=0.0
    )
    curve = float(np.median(calibration.curve.two_sigma))
    if not np.all(np.isfinite(calibration.curve.two_sigma + wind)):
        raise UndeterminedError(
            "the log does not determine the answer: no bound can be given; check the clock, the "
            f"units and the columns, or {FLY_HEADINGS}"
        )
    north, east = (v[calibration.residuals.used] for v in (log.velocity_north, log.velocity_east))
    line = abs(np.mean(np.exp(2j * np.arctan2(east, north)))) > _ONE_LINE
    if max(curve, 0.0 if line else wind) > USELESS:
        raise UndeterminedError(
            f"the log does not determine the answer: 2σ would be {curve / KNOT:.1f} kt on the "
            f"curve and {wind / KNOT:.1f} kt on the wind; {FLY_HEADINGS}, at every speed of interest"
        )


@dataclass(frozen=True, slots=True)
class CurveVerdict:
    """The verdict on a curve: `plausible`, `doubtful` (a warning) or `impossible` (no answer).

    `worst` [-] is the Δp/q_c of greatest size among the points beyond the limit, and
    `indicated_airspeed` [m/s] the airspeed at that point. Both are 0 where no point is beyond it.
    `words` explain the verdict in a sentence.
    """

    kind: Literal["plausible", "doubtful", "impossible"]
    worst: float = 0.0
    indicated_airspeed: float = 0.0
    words: str = ""


def judge_curve(
    indicated_airspeed: MetersPerSecond,
    normalized_pressure_error: Array,
    normalized_two_sigma: Array,
) -> CurveVerdict:
    """Judge a curve Δp/q_c over indicated airspeed [m/s] by its size; arrays of one length, (n,).

    A point is beyond a limit where it exceeds the limit by more than its 2σ: an uncertain curve is
    not impossible. Impossible: above 0.2, an error of a tenth in airspeed. Doubtful: above 0.1,
    which is 5 kt at 100 kt and the largest error that FAR 23.1323 accepts from 1.3 times the
    stalling speed on. Below the middle of the curve both grow as 1/V², as the lift coefficient
    does: the handbook of the Cessna 172S has 56 KCAS at 50 KIAS. Raises ValueError for arrays of
    different lengths, or for a number that is not finite.
    """
    speed, error, bound = indicated_airspeed, normalized_pressure_error, normalized_two_sigma
    if not speed.shape == error.shape == bound.shape:
        raise ValueError(
            f"a curve needs arrays of one length, not {speed.shape}, {error.shape}, {bound.shape}"
        )
    if not np.all(np.isfinite([speed, error, bound])):
        raise ValueError("a curve holds a number that is not finite")
    surely = (np.abs(error) - bound) / np.maximum((np.median(speed) / speed) ** 2, 1.0)
    if np.any(surely > LIMITS.curve_refused):
        return _verdict("impossible", speed, error, surely > LIMITS.curve_refused)
    if np.any(surely > LIMITS.curve_doubted):
        return _verdict("doubtful", speed, error, surely > LIMITS.curve_doubted)
    return CurveVerdict("plausible")


def _verdict(
    kind: Literal["doubtful", "impossible"], speed: MetersPerSecond, error: Array, beyond: Booleans
) -> CurveVerdict:
    at = int(np.argmax(np.where(beyond, np.abs(error), -1.0)))
    reason = {
        "doubtful": "from 1.3 times the stalling speed on a certified airplane's is smaller: check "
        "units, gains and zeros of the log",
        "impossible": "no airplane's is so large; a gain, a zero or a unit of the log makes it",
    }[kind]
    words = (
        f"the pressure error is {percent_text(error[at], '+')} of the impact pressure at "
        f"{speed[at] / KNOT:.0f} kt indicated; {reason}"
    )
    return CurveVerdict(kind, float(error[at]), float(speed[at]), words)


_BIN = 10.0 * KNOT  # m/s: samples so near an airspeed are taken together
_MEAN_OVER = 30.0  # s: and so near in time
_SMOOTH_OVER = 300.0  # s: where the wind drifts, over as long as its path is smooth
_FEWEST_MEANS = 4
# probability of so much disagreement by chance: below it triangle and height are not averaged, but
# mixed (`location`)
DISAGREE = 0.001
_CLEAR = 3.0  # standard errors beyond which samples disagree
_BOUNDS = 1.5  # times 2σ, likewise
_LEAST_OFF = 0.5 * KNOT  # m/s, likewise


def disagreements(
    agreement: float | None,
    residuals: Residuals,
    curve: ErrorCurve,
    drifting: bool = False,
    by_height: Sequence[MetersPerSecond] = (),
) -> tuple[Disagreement, ...]:
    """Return where wind triangle and height disagree, and where samples lie off the curve.

    Samples without the wind scatter about the curve. Where their mean near an airspeed lies off the
    curve by more than its bound and their own scatter allow, the model of the curve or of the wind
    does not describe the log.

    Of a wind that is `drifting` only a smooth path is taken from the samples. `agreement` is the
    probability that triangle and height differ by so much by chance, None where only one spoke, and
    `by_height` are the corrections (c,) [m/s] without the height and with it.
    """
    found = []
    if agreement is not None and agreement < DISAGREE and by_height:
        without, with_height = by_height
        moved = np.abs(with_height - without)
        most = int(np.argmax(moved / curve.two_sigma))
        words = (
            f"the height moves the correction at {curve.indicated_airspeed[most] / KNOT:.0f} KIAS "
            f"from {without[most] / KNOT:+.1f} to {with_height[most] / KNOT:+.1f} kt, which is "
            "more than chance, and the bound holds both. The temperature or the height may be off by "
            "more than stated, or the wind may follow the speeds flown"
        )
        moves = CurveMove(float(moved[most]), float(moved[most] / curve.two_sigma[most]))
        if moves.matters:
            found.append(Disagreement("height", words, moves.most, fatal=False))
    off, at = _samples_off(residuals, curve, _SMOOTH_OVER if drifting else _MEAN_OVER)
    if off > 0.0:
        words = (
            f"the samples near {at / KNOT:.0f} KIAS lie {off / KNOT:.1f} kt off the curve, more "
            "than its bound and their scatter allow: take a part of the flight (--from, --to), or "
            "another --model"
        )
        found.append(Disagreement("samples", words, off, fatal=True))
    return tuple(found)


def with_points(calibration: Calibration, points: Sequence[FixedSpeedPoint]) -> Calibration:
    """Return a calibration with its fixed-speed points, and the one farthest off its curve.

    A point beyond the bounds of both is a disagreement.
    """
    calibration = replace(calibration, points=tuple(points))
    curve, worst = calibration.curve, None
    for point in points:
        value, bound = (
            float(np.interp(point.indicated_airspeed, curve.indicated_airspeed, part))
            for part in (curve.correction, curve.two_sigma)
        )
        ratio = abs(point.correction - value) / float(np.hypot(bound, point.two_sigma))
        if ratio > _BOUNDS and (worst is None or ratio > worst[0]):
            worst = (ratio, point, value)
    if worst is None:
        return calibration
    _, point, value = worst
    name = point.method.replace("_", " ")
    found = (
        f"{point.correction / KNOT:+.1f} ± {point.two_sigma / KNOT:.1f} kt, the curve "
        f"{value / KNOT:+.1f} kt"
    )
    words = (
        f"a fixed-speed point ({name}) at {point.indicated_airspeed / KNOT:.0f} KIAS gives "
        f"{found}. The wind changed between its legs, or the curve does not describe this part of "
        "the flight"
    )
    finding = Disagreement("fixed_speed", words, abs(point.correction - value), fatal=False)
    return replace(calibration, disagreements=(*calibration.disagreements, finding))


def _samples_off(residuals: Residuals, curve: ErrorCurve, over: float) -> tuple[float, float]:
    """Return the largest clear distance of the samples' mean from the curve, and its airspeed.

    Both are in m/s, and 0 for none.
    """
    group = np.floor((residuals.time - residuals.time[0]) / over).astype(np.intp)
    # By the airspeed without the residual: a gust that raises a reading would else sort itself to
    # its own kind.
    speed = residuals.indicated_airspeed - residuals.airspeed
    place = np.floor(np.nan_to_num(speed, nan=-_BIN) / _BIN).astype(np.intp)
    worst = (0.0, 0.0)
    for number in np.unique(place[np.isfinite(speed)]):
        rows = place == number
        means = np.bincount(group[rows], residuals.airspeed[rows])[np.unique(group[rows])]
        means = means / np.bincount(group[rows])[np.unique(group[rows])]
        if len(means) < _FEWEST_MEANS:
            continue
        mean, error = float(np.mean(means)), float(np.std(means, ddof=1) / np.sqrt(len(means)))
        at = float(np.mean(speed[rows]))
        if not curve.indicated_airspeed[0] <= at <= curve.indicated_airspeed[-1]:
            continue
        bound = float(np.interp(at, curve.indicated_airspeed, curve.two_sigma))
        if abs(mean) - _CLEAR * error > max(_BOUNDS * bound, _LEAST_OFF) and abs(mean) > worst[0]:
            worst = (abs(mean), at)
    return worst


_WASH_OVER = 30.0  # s: residuals within it share a gust and count as one
_FEWEST_BLOCKS = 8
# of full power: rms of power not explained by airspeed, below which nothing is reported
_OWN_POWER = 0.05


def propwash_effect(residuals: Residuals, log: FlightLog) -> Estimate | None:
    """Return how much higher the airspeed [m/s] reads at full power than at idle.

    None without power. The residual is regressed on the power that is left when constant, airspeed
    and its square are taken out (Frisch and Waugh 1933); its 2σ is that of blocks of 30 s (Liang
    and Zeger 1986). The 2σ is infinite where power follows airspeed.
    """
    levers = [each for each in (log.throttle_left, log.throttle_right) if each is not None]
    engines = ("left", "right")
    pairs = [
        (getattr(log, f"manifold_pressure_{e}"), getattr(log, f"propeller_speed_{e}"))
        for e in engines
    ]
    powers = [a * b for a, b in pairs if a is not None and b is not None]
    if not levers and not powers:
        return None
    lever = np.mean(levers or powers, axis=0)
    lever = lever if levers else lever / np.max(np.abs(lever))
    power = np.interp(residuals.time, log.time, lever)
    speed = residuals.indicated_airspeed - residuals.airspeed
    speed = (speed - np.mean(speed)) / max(float(np.std(speed)), 1e-9)
    known = np.vander(speed, 3)
    both = np.column_stack([power, residuals.airspeed])
    own, airspeed = (both - known @ np.linalg.lstsq(known, both, rcond=None)[0]).T
    _, block = np.unique(
        np.floor((residuals.time - residuals.time[0]) / _WASH_OVER), return_inverse=True
    )
    blocks, size = int(block[-1]) + 1, float(own @ own)
    if blocks < _FEWEST_BLOCKS or np.sqrt(size / len(own)) < _OWN_POWER:
        return Estimate("wash", 0.0, np.inf)
    value = float(own @ airspeed) / size
    scores = np.bincount(block, own * (airspeed - value * own))
    spread = np.sqrt(scores @ scores * blocks / (blocks - len(known[0]) - 1)) / size
    return Estimate("wash", value, 2.0 * float(spread))


_FAR = 3.0  # standard deviations of the prior of a noise parameter
_Z_1_PERCENT = 2.58  # standard deviations of a nuisance's estimates: 1 % of logs are farther
# share of the prior variance: a log that resolves less says nothing of a nuisance
_LEAST_KNOWN = 0.04
# likewise: below it the estimate without the prior is a small number over a smaller one
_SIZED = 0.2

_ERRORS = {  # name of a nuisance to its words and its unit
    "temperature_k": ("correction that the temperature needs", "K"),
    "recovery_factor": ("correction that the recovery factor needs", ""),
    "static_pressure_pa": ("correction that the static pressure needs", "Pa"),
    "impact_pressure_zero_pa": ("zero offset of the impact pressure", "Pa"),
    "velocity_north_mps": ("constant error of the GPS velocity toward north", "m/s"),
    "velocity_east_mps": ("constant error of the GPS velocity toward east", "m/s"),
    "latency_s": ("latency of the GPS", "s"),
    "height_latency_s": ("latency of the GPS height beyond that of its velocity", "s"),
    "receiver_smoothing_s2": ("square of the time over which the GPS velocity is smoothed", "s²"),
    "turn_lift": ("pressure error that the load factor adds in turns", "Δp/q_c"),
    "wind_north_mps_per_600_s": ("change of the wind toward north in 600 s", "m/s"),
    "wind_east_mps_per_600_s": ("change of the wind toward east in 600 s", "m/s"),
    "wind_north_mps_per_300_m": ("change of the wind toward north over 300 m of height", "m/s"),
    "wind_east_mps_per_300_m": ("change of the wind toward east over 300 m of height", "m/s"),
}


@dataclass(frozen=True, slots=True)
class _Level:
    """A level with a half-normal prior of the given scale."""

    words: str
    unit: str
    scale: float

    def departure(self, value: float) -> float:
        """Distance from zero in standard deviations."""
        return value / self.scale

    @property
    def expected(self) -> str:
        """The assumed size, in words."""
        return f"at most about {2.0 * self.scale:.3g} {self.unit} expected"


@dataclass(frozen=True, slots=True)
class _Extent:
    """A length or a time with a log-normal prior: its middle, and one deviation as a factor."""

    words: str
    unit: str
    middle: float
    factor: float

    def departure(self, value: float) -> float:
        """Distance of the logarithm from that of the middle, in deviations, without sign."""
        return float(abs(np.log(value / self.middle)) / np.log(self.factor))

    @property
    def expected(self) -> str:
        """The assumed size, in words."""
        reach = self.factor**2
        return f"{self.middle / reach:.3g} to {self.middle * reach:.3g} {self.unit} expected"


def outside_prior(
    structure: Structure, obs: Observations, fit: CoveringFit, answer: Posterior
) -> tuple[Caution, ...]:
    """Write a sentence for each nuisance and each noise parameter far outside its prior.

    Where the log contradicts a prior, the estimate is a compromise between the two, and the bound
    is too small: the sensor, its unit or the assumption is wrong, and only the user can decide
    which. A log that hardly knows a nuisance moves its estimate little, however wrong the prior. So
    an estimate is compared with what the prior lets such logs find, its prior predictive
    distribution: where the prior has standard deviation s and the posterior r, estimates scatter by
    √(s² − r²) (Box, "Sampling and Bayes' inference in scientific modelling and robustness", Journal
    of the Royal Statistical Society A 143, 1980).

    Far is what 1 % of logs find of a nuisance where its prior holds, and for a noise parameter more
    than three standard deviations of the prior from its middle. The sentence states the size. A
    nuisance moves the curve by what the answer changes where it is held at zero; `either_way` gives
    the answer that holds both.
    """
    found, names = [], [each.name for each in structure.nuisances]
    for caution in _nuisances_outside(structure, answer):
        place = structure.model.count + names.index(caution.column)
        moved = answer.mean - answer.without(place).mean
        moves = curve_moved(structure.model, obs, answer, moved)
        text = (
            f"{caution}; it moves the curve by up to {moves.most / KNOT:.2f} kt, and the bound "
            "holds both"
        )
        found.append(Caution(text, caution.code, caution.column, caution.size, moves))
    return (*found, *_noise_outside(structure, obs, fit))


def either_way(structure: Structure, cautions: Sequence[Caution], answer: Posterior) -> Posterior:
    """Return an answer with each nuisance that `outside_prior` names as it is found and without it.

    Neither the prior nor what contradicts it is known to be wrong: one is as probable as the other.
    """
    names = [each.name for each in structure.nuisances]
    for caution in cautions:
        if caution.column in names:
            without = answer.without(structure.model.count + names.index(caution.column))
            answer = mixed([(1.0, answer), (1.0, without)])
    return answer


_IN_TURNS = 0.01  # of the impact pressure at 30° of bank: a static source in a slip has 1 to 2 %


def turns_to_one_side(
    structure: Structure, obs: Observations, fit: CoveringFit, answer: Posterior, flown: Flown
) -> tuple[Caution, ...]:
    """What sideslip would move the curve by where all turns are to one side.

    Nothing in such a log shows it. Where turns are said to add no error (`turn_lift` 0), sideslip
    has none.
    """
    if structure.priors.turn_lift == 0.0 or not (side := side_of_turns(*flown)):
        return ()
    moved = _IN_TURNS * moved_by(structure, obs, fit, flown, in_turns())
    moves = curve_moved(structure.model, obs, answer, moved)
    text = (
        f"all turns are to the {side}: sideslip that changes the static pressure there by "
        f"{percent_text(_IN_TURNS)} of the impact pressure would move the curve by up to "
        f"{moves.most / KNOT:.1f} kt, and this log does not show it; fly turns to both sides"
    )
    return (
        Caution(text, "turns to one side", size=moves.most / KNOT, moves=moves),
    ) * moves.matters


def _nuisances_outside(structure: Structure, answer: Posterior) -> list[Caution]:
    mean, found = answer.mean, []
    for place, nuisance in enumerate(structure.nuisances, start=structure.model.count):
        # The scatter for known noise: the nodes' own differences are no knowledge of the nuisance.
        left = float(answer.weights @ answer.covariances[:, place, place]) / nuisance.deviation**2
        scatter = nuisance.deviation * float(np.sqrt(max(1.0 - left, _LEAST_KNOWN)))
        size = float(mean[place]) if nuisance.positive else abs(float(mean[place]))
        if size > _Z_1_PERCENT * scatter:
            # What the log says without the prior, which draws the estimate to zero.
            freed = (nuisance.deviation / scatter) ** 2
            value, bound = float(mean[place]) * freed, 2.0 * nuisance.deviation * freed**0.5
            sized = (value, bound * left**0.5) if left < 1.0 - _SIZED else None
            text = _nuisance_sentence(nuisance, sized)
            found.append(Caution(text, "outside prior", nuisance.name, value))
    return found


def _nuisance_sentence(nuisance: Nuisance, found: tuple[float, float] | None) -> str:
    """Return in words what a nuisance is by the rest of the log, with its 2σ.

    `found` is None where the log does not tell its size, since its prior, or what else is unknown,
    says as much.
    """
    words, unit = _ERRORS.get(nuisance.name, (nuisance.name.replace("_", " "), ""))
    usual = _sized(f"±{2.0 * nuisance.deviation:.3g}", unit)
    if found is None:
        finding = f"lies beyond the {usual} (2σ) that is assumed; the log does not tell by how much"
    else:
        value = _sized(f"{found[0]:+.3g} ± {found[1]:.2g}", unit)
        finding = f"is {value} by the rest of the log, where {usual} (2σ) is assumed"
    return f"the {words} {finding}: check the sensor and its unit, or assume more"


def _sized(number: str, unit: str) -> str:
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()


def _noise_outside(structure: Structure, obs: Observations, fit: CoveringFit) -> list[Caution]:
    likely = np.exp(fit.likely.noise)
    found = []
    for prior, value in zip(_noise_priors(structure, obs), likely, strict=True):
        departure = prior.departure(float(value))
        if departure > _FAR:
            text = (
                f"the {prior.words} is found to be {value:.3g} {prior.unit}, {departure:.1f} "
                f"standard deviations of what was assumed ({prior.expected}): the bound may be too "
                "small; check the log for slow changes of the wind and for faulty channels"
            )
            found.append(Caution(text, "outside prior", size=float(value)))
    return found


def _noise_priors(structure: Structure, obs: Observations) -> list[_Level | _Extent]:
    """The priors of the noise parameters in their order."""
    assumed = structure.priors
    priors: list[_Level | _Extent] = [
        _Level("gusts' standard deviation", "m/s", assumed.gust_mps),
        _Extent("gusts' length", "m", assumed.gust_length_m, length_factor(structure, obs)),
        _Level("white noise of the airspeed", "m/s", assumed.white_mps),
    ]
    if structure.drifting:
        priors.append(
            _Level("standard deviation of the drifting wind", "m/s", wind_scale(structure, obs))
        )
    if structure.altitude is not None:
        third = (
            _Level("white noise of the height", "m", assumed.height_white_m)
            if structure.altitude.tie is None
            else _Level("wander of the integrated vertical velocity", "m/√s", assumed.height_walk)
        )
        height: list[_Level | _Extent] = [
            _Level("slow error of the height", "m", assumed.height_slow_m),
            _Extent(
                "memory of the height error",
                "s",
                assumed.height_memory_s,
                assumed.height_memory_factor,
            ),
            third,
        ]
        assert len(height) == NOISE_COUNT
        priors += height
    return priors
