"""The unknowns of a calibration: one vector for all flights, each with a normal prior.

The curve of the static source and the curve of the total source, the constant errors of the
sensors, and for each flight its wind and what only its heights hold. Rival priors of the impact
system, sound or uncalibrated, are hypotheses over the same vector.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.height import HeightRows, height_log_prior
from pitotbench.calibration.observations import Blocks, Observations
from pitotbench.calibration.options import AUTO, SMOOTH, WITHOUT_TEMPERATURE, CalibrationOptions
from pitotbench.calibration.options import Accuracies as Accuracies
from pitotbench.calibration.priors import Priors
from pitotbench.estimation.linear_gaussian import Hypothesis
from pitotbench.pressure_error import MODELS, laws
from pitotbench.pressure_error.laws import Law
from pitotbench.units import Array, Meters

STATIC, TOTAL, IMPACT = "static", "total", "impact"
ZERO = "impact_pressure_zero_pa"
SOUND, UNKNOWN = "sound", "unknown"  # hypotheses of the impact-pressure system
_NEVER = 1e-7  # deviation of an unknown that a hypothesis takes for zero
_LEAST_RANGE = 1.01  # of q_ci, where the airspeed hardly changes
_LAYER, _MOST_LAYERS = 150.0, 8  # m, least thickness of a layer of one shear; their number
_THICK = 300.0  # m: over thicker layers shears add up as a random walk
_HEIGHT_NOISE = 3  # parameters of the heights' noise


@dataclass(frozen=True, slots=True)
class Flight:
    """The rows of one flight, and where its unknowns stand: `at` gives the place by the name.

    `layers` (k + 1,) [m] are the edges of the layers in which the wind changes with height.
    `triangle` and `height` are the places of its noise in φ.
    """

    observations: Observations
    heights: HeightRows | None
    layers: Meters
    at: Mapping[str, int]
    triangle: slice
    height: slice

    def value(self, name: str, beta: Array) -> float:
        """The value of one of its unknowns in β (p,); 0 where it has none of this name."""
        return float(beta[self.at[name]]) if name in self.at else 0.0

    def shear_basis(self, height: Meters) -> Array:
        """Height above the middle of each layer, within the layer, (n, k) [m]."""
        low, high = self.layers[:-1], self.layers[1:]
        return np.asarray(np.clip(height[:, None], low, high) - 0.5 * (low + high))

    @property
    def winds(self) -> list[int]:
        """The places of its wind toward north and east."""
        return [self.at["wind_north"], self.at["wind_east"]]


@dataclass(frozen=True, slots=True)
class Unknowns:
    """The laws of both sources, the flights, and the rival priors: name, probability, (p,) each.

    `slow` states whether the wind changes slowly. φ holds the noise of each flight in turn, then
    the size of the departures.
    """

    static: Law
    total: Law
    flights: tuple[Flight, ...]
    count: int
    rivals: tuple[tuple[str, float, Array], ...]
    departures: NDArray[np.bool_]
    slow: bool
    priors: Priors

    @property
    def of_static(self) -> slice:
        """The places of the static source's curve."""
        return slice(0, len(self.static))

    @property
    def of_total(self) -> slice:
        """The places of the total source's curve."""
        return slice(len(self.static), len(self.static) + len(self.total))

    @property
    def parameters(self) -> int:
        """The number of parameters of the noise, φ."""
        return int(self.flights[-1].height.stop) + int(self.departures.any())

    def hypotheses(self) -> list[Hypothesis]:
        """The rival priors as precisions for φ."""
        return [
            Hypothesis(name, share, partial(self._precision, deviations))
            for name, share, deviations in self.rivals
        ]

    def _precision(self, deviations: Array, phis: Array) -> Array:
        precision = np.broadcast_to(deviations**-2.0, (len(phis), self.count)).copy()
        if self.departures.any():
            precision[:, self.departures] *= np.exp(-2.0 * phis[:, -1:])
        return precision

    def medians(self) -> Array:
        """Median of each size in φ and one standard deviation below and above, as factors, (d, 3).

        NaN for the noise of the heights, which has a prior of its own.
        """
        p = self.priors
        level, length = (p.calm_factor, p.level_factor), (p.length_factor, p.length_factor)
        own = [(p.gust, *level), (p.gust_length, *length), (p.white, *level)]
        if self.slow:
            own += [(p.slow_wind, *level), (p.slow_time, *length)]
        found = np.full((self.parameters, 3), np.nan)
        for flight in self.flights:
            found[flight.triangle] = own
        if self.departures.any():
            found[-1] = p.departure, p.departure_factor, p.departure_factor
        return found

    def log_prior(self, phis: Array) -> Array:
        """The logarithm of the prior density of φ (b, d), up to a constant, (b,)."""
        medians = self.medians()
        known = np.isfinite(medians[:, 0])
        median, below, above = medians[known].T
        off = phis[:, known] - np.log(median)
        total = -0.5 * np.sum((off / np.log(np.where(off < 0.0, below, above))) ** 2, axis=1)
        for flight in self.flights:
            if flight.heights is not None:
                total += height_log_prior(flight.heights, phis[:, flight.height])
        return np.asarray(total)


def flown_range(observed: Sequence[Observations]) -> tuple[float, float]:
    """Return the range of the impact pressure [Pa], without the outermost thousandths."""
    q = np.concatenate([obs.impact_pressure for obs in observed])
    low, high = (float(each) for each in np.quantile(q, [0.001, 0.999]))
    return low, max(high, _LEAST_RANGE * low)


def sources_of(
    options: CalibrationOptions,
    stated: Accuracies,
    share: float,
    span: tuple[float, float],
    q: float,
) -> tuple[Law, Law, dict[str, tuple[Array, Array]]]:
    """Return the laws of static and total source, and the deviations of both under each rival.

    `share` is the probability of an uncalibrated impact system and `q` the reference pressure [Pa].
    """
    priors, where = options.priors, options.error_location
    level = 0.5 * float(np.hypot(stated.total_pressure, stated.impact_pressure_scale))
    line = max(level, _NEVER), max(priors.total_slope * 0.5 * stated.total_pressure, _NEVER)
    if options.model in (SMOOTH, AUTO):
        law = laws.smooth(*span, q, priors.level, priors.slope, priors.departure_length)
    else:
        model = MODELS[options.model].spread_over(span[0] / q, span[1] / q)
        law = laws.published(model, *span, q, priors.published)
    static = laws.no_law() if where in (TOTAL, IMPACT) else law
    rivals = share > 0.0 or where in (TOTAL, IMPACT)
    total = law if rivals else laws.line(*span, *line)
    if not rivals:
        return static, total, {SOUND: (static.deviations, total.deviations)}
    sound, wide, kept = np.full(len(total), _NEVER), total.deviations.copy(), static.deviations
    if law.line:
        sound[:2] = line
        if where == AUTO:
            wide[0] = priors.unknown_scale
    else:
        kept = np.full(len(static), _NEVER)  # one published law cannot stand at both sources
    return static, total, {SOUND: (static.deviations, sound), UNKNOWN: (kept, wide)}


def unknowns_of(
    options: CalibrationOptions,
    stated: Accuracies,
    flown: Sequence[tuple[Observations, HeightRows | None]],
    reference_pressure: float,
    share: float,
) -> Unknowns:
    """Return the unknowns of one or several flights of one airplane.

    Parameters: options; accuracies of the sensors, 2σ; the rows of each flight with its heights;
    reference_pressure [Pa]; share, the probability of an uncalibrated impact-pressure system.
    """
    priors, slow = options.priors, options.wind != "constant"
    if options.error_location in (TOTAL, IMPACT):
        share = 1.0
    elif options.error_location == STATIC:
        share = 0.0
    span = flown_range([obs for obs, _ in flown])
    static, total, deviations = sources_of(options, stated, share, span, reference_pressure)
    first = len(static) + len(total)
    common, sound_zero = _common(options, stated, [obs for obs, _ in flown], share)
    shared = {name: first + i for i, name in enumerate(common)}
    others = [*common.values()]
    flights, place = [], 0
    for obs, heights in flown:
        layers = _layers_of(obs)
        own = _own(options, stated, obs, heights, layers)
        at = shared | {name: first + len(others) + i for i, name in enumerate(own)}
        others += own.values()
        triangle = slice(place, place + (5 if slow else 3))
        height = slice(triangle.stop, triangle.stop + (_HEIGHT_NOISE if heights is not None else 0))
        place = height.stop
        flights.append(Flight(obs, heights, layers, at, triangle, height))
    rest = np.array(others)
    rivals = []
    for name, chance in ((SOUND, 1.0 - share), (UNKNOWN, share)):
        if chance > 0.0:
            own_rest = rest.copy()
            if ZERO in shared and name == SOUND:
                own_rest[shared[ZERO] - first] = sound_zero
            rivals.append((name, chance, np.concatenate([*deviations[name], own_rest])))
    departures = np.concatenate([static.departure, total.departure, np.zeros(len(rest), np.bool_)])
    return Unknowns(
        static, total, tuple(flights), first + len(rest), tuple(rivals), departures, slow, priors
    )


def _common(
    options: CalibrationOptions, stated: Accuracies, observed: Sequence[Observations], share: float
) -> tuple[dict[str, float], float]:
    """The unknowns of the airplane with their deviations, and that of a sound sensor's zero [Pa]."""
    zero, latency = 0.5 * stated.impact_pressure_zero_pa, 0.5 * stated.latency_s
    if options.latency != "given":
        latency = max(latency, options.priors.latency)
    wide = options.error_location == AUTO and options.model in (SMOOTH, AUTO) and share > 0.0
    total = any(obs.probe_heating > 0.0 for obs in observed)
    found = {
        ZERO: max(zero, options.priors.unknown_zero) if wide else zero,
        "temperature_k": 0.0 if observed[0].standard_day else 0.5 * stated.temperature_k,
        "recovery_factor": 0.5 * stated.recovery_factor if total else 0.0,
        "static_pressure_pa": 0.5 * stated.static_pressure_pa,
        "latency_s": latency,
    }
    return {name: value for name, value in found.items() if value > 0.0}, max(zero, _NEVER)


def _own(
    options: CalibrationOptions,
    stated: Accuracies,
    obs: Observations,
    heights: HeightRows | None,
    layers: Meters,
) -> dict[str, float]:
    """The unknowns of one flight with their deviations."""
    priors = options.priors
    found = {"wind_north": priors.wind, "wind_east": priors.wind}
    if options.wind_down:
        found["wind_down"] = priors.wind
    if options.wind != "constant":
        thickness = max(float(layers[1] - layers[0]), _THICK)
        shear = priors.shear * float(np.sqrt(_THICK / thickness))
        found |= {
            f"shear_{axis}_{i}": shear for axis in ("north", "east") for i in range(len(layers) - 1)
        }
    if obs.standard_day:
        found["temperature_k"] = 0.5 * max(stated.temperature_k, WITHOUT_TEMPERATURE)
    for name, step, (_, count) in _steps(obs):
        found |= {f"{name}_{i}": step / float(np.sqrt(12.0)) for i in range(count)}
    if heights is not None:
        if options.latency != "given":
            found["height_latency_s"] = priors.height_latency
        found |= {f"height_{i}": float(each) for i, each in enumerate(heights.deviations)}
    return found


_MOST_STEPS = 40  # columns of one display


def _steps(obs: Observations) -> list[tuple[str, float, tuple[NDArray[np.intp], int]]]:
    """The displays that round: name, step [m/s], and the step that each row shows of how many.

    A reading that stands still is wrong by the same part of a step for as long as it stands, so
    each displayed value has an error of its own, uniform over the step. Above 40 values neighbors
    share one.
    """
    shown = {
        "airspeed_step": air.calibrated_airspeed(obs.impact_pressure),
        "ground_speed_step": np.hypot(obs.velocity_north, obs.velocity_east),
    }
    found = []
    for (name, value), step in zip(shown.items(), obs.steps, strict=True):
        if step > 0.0:
            number = np.round(value / step).astype(np.intp)
            number -= number.min()
            number //= 1 + int(number.max()) // _MOST_STEPS
            places, index = np.unique(number, return_inverse=True)
            found.append((name, step, (index, len(places))))
    return found


def step_columns(flight: Flight, blocks: Blocks, ratio: Array) -> dict[str, Array]:
    """Return the effect of each displayed step on the true airspeed of the blocks, (n,) [-].

    `ratio` (n,) is true over calibrated airspeed, by which an error of the reading grows.
    """
    columns = {}
    for name, _, (index, count) in _steps(flight.observations):
        gain = ratio if name == "airspeed_step" else -np.ones_like(ratio)
        for i in range(count):
            columns[f"{name}_{i}"] = gain * blocks.mean((index == i).astype(np.float64))
    return columns


def _layers_of(obs: Observations) -> Meters:
    low, high = (float(edge) for edge in np.quantile(obs.height(), [0.01, 0.99]))
    high = max(high, low + 1.0)
    count = min(max(int((high - low) / _LAYER), 1), _MOST_LAYERS)
    return np.linspace(low, high, count + 1)


def reference_of(observed: Sequence[Observations]) -> float:
    """Return the usual reference pressure [Pa], or for fast airplanes the median of the data,
    rounded.
    """
    from pitotbench.pressure_error import REFERENCE_PRESSURE

    middle = float(np.median(np.concatenate([obs.impact_pressure for obs in observed])))
    if middle < _FULL_SCALE_RATIO * REFERENCE_PRESSURE:
        return REFERENCE_PRESSURE
    return float(round(middle, -3))


_FULL_SCALE_RATIO = 8.0  # q_ci/q_ref: above it the reference pressure is taken from the data
