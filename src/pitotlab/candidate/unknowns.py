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

from pitotbench.calibration.observations import Observations
from pitotbench.calibration.options import WITHOUT_TEMPERATURE, Accuracies
from pitotbench.units import Array, Meters, Seconds
from pitotlab.candidate import laws
from pitotlab.candidate.heights import HeightRows, height_log_prior
from pitotlab.candidate.laws import Law
from pitotlab.candidate.linear_gaussian import Hypothesis
from pitotlab.candidate.priors import Priors

ZERO = "impact_pressure_zero_pa"
SOUND, UNKNOWN = "sound", "unknown"  # hypotheses of the impact-pressure system
_NEVER = 1e-7  # deviation of an unknown that a hypothesis takes for zero
_LEAST_RANGE = 1.01  # of q_ci, where the airspeed hardly changes
_LAYER, _MOST_LAYERS = 150.0, 8  # m, least thickness of a layer of one shear; their number
_THICK = 300.0  # m: over thicker layers shears add up as a random walk
_MOST_COSINES = 60  # of the slow wind of one flight, toward each of north and east
_HEIGHT_NOISE = 3  # parameters of the heights' noise


@dataclass(frozen=True, slots=True)
class Flight:
    """The rows of one flight, and where its unknowns stand: `at` gives the place by the name.

    `layers` (k + 1,) [m] are the edges of the layers in which the wind changes with height,
    `cosines` counts those of the slow wind. `triangle`, `slow` and `height` are the places of its
    noise in φ.
    """

    observations: Observations
    heights: HeightRows | None
    layers: Meters
    cosines: int
    at: Mapping[str, int]
    triangle: slice
    slow: slice
    height: slice

    def value(self, name: str, beta: Array) -> float:
        """The value of one of its unknowns in β (p,); 0 where it has none of this name."""
        return float(beta[self.at[name]]) if name in self.at else 0.0

    def shear_basis(self, height: Meters) -> Array:
        """Height above the middle of each layer, within the layer, (n, k) [m]."""
        low, high = self.layers[:-1], self.layers[1:]
        return np.asarray(np.clip(height[:, None], low, high) - 0.5 * (low + high))

    def slow_basis(self, time: Seconds) -> Array:
        """The cosines of the slow wind, which have a mean of zero over the flight, (n, k)."""
        place = (time - self.observations.time[0]) / self.duration
        return np.asarray(np.cos(np.pi * place[:, None] * np.arange(1, self.cosines + 1)))

    @property
    def duration(self) -> float:
        """From the first row to the last [s]."""
        return float(np.ptp(self.observations.time))

    def slow_deviations(self, sizes: Array, times: Array) -> Array:
        """The deviation of each cosine, (b, k), for sizes (b,) [m/s] and times (b,) [s].

        The slow wind is a process of Matérn's order 3/2, whose spectrum is 4λ³/(λ² + ω²)² with
        λ = √3 over its time, expanded in cosines (Solin and Särkkä 2020, eq. 20).
        """
        rate = np.sqrt(3.0) / times[:, None]
        frequency = np.pi * np.arange(1, self.cosines + 1) / self.duration
        spectrum = 4.0 * rate**3 / (rate**2 + frequency**2) ** 2
        return np.asarray(sizes[:, None] * np.sqrt(2.0 * spectrum / self.duration))

    @property
    def slow_places(self) -> list[list[int]]:
        """The places of its cosines toward north and toward east."""
        return [
            [self.at[f"slow_{axis}_{k}"] for k in range(self.cosines)] for axis in ("north", "east")
        ]

    @property
    def winds(self) -> list[int]:
        """The places of its wind toward north and east."""
        return [self.at["wind_north"], self.at["wind_east"]]


@dataclass(frozen=True, slots=True)
class Unknowns:
    """The laws of both sources, the flights, and the rival priors: name, probability, (p,) each.

    φ holds the noise of each flight in turn, then the size of the departures.
    """

    static: Law
    total: Law
    flights: tuple[Flight, ...]
    count: int
    rivals: tuple[tuple[str, float, Array], ...]
    departures: NDArray[np.bool_]
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
        for flight in self.flights:
            size, time = np.exp(phis[:, flight.slow]).T
            for places in flight.slow_places:
                precision[:, places] = flight.slow_deviations(size, time) ** -2.0
        return precision

    def medians(self) -> Array:
        """Median of each size in φ and one standard deviation below and above, as factors, (d, 3).

        NaN for the noise of the heights, which has a prior of its own.
        """
        p = self.priors
        level, length = (p.calm_factor, p.level_factor), (p.length_factor, p.length_factor)
        own = [(p.gust, *level), (p.gust_length, *length), (p.white, *level)]
        slow = [(p.slow_wind, p.slow_calm_factor, p.level_factor), (p.slow_time, *length)]
        found = np.full((self.parameters, 3), np.nan)
        for flight in self.flights:
            found[flight.triangle], found[flight.slow] = own, slow
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
                total += height_log_prior(flight.heights.rows, phis[:, flight.height])
        return np.asarray(total)


def flown_range(observed: Sequence[Observations]) -> tuple[float, float]:
    """Return the range of the impact pressure [Pa], without the outermost thousandths."""
    q = np.concatenate([obs.impact_pressure for obs in observed])
    low, high = (float(each) for each in np.quantile(q, [0.001, 0.999]))
    return low, max(high, _LEAST_RANGE * low)


def sources_of(
    priors: Priors, share: float, span: tuple[float, float], reference_pressure: float
) -> tuple[Law, Law, dict[str, tuple[Array, Array]]]:
    """Return the laws of static and total source, and the deviations of both under each rival.

    `share` is the probability of an uncalibrated impact system.
    """
    level = float(np.hypot(priors.total_level, priors.scale))
    law = laws.smooth(
        *span, reference_pressure, priors.level, priors.slope, priors.departure_length
    )
    if share == 0.0:
        total = laws.line(*span, level, priors.total_slope)
        return law, total, {SOUND: (law.deviations, total.deviations)}
    sound, wide = np.full(len(law), _NEVER), law.deviations.copy()
    sound[:2] = level, priors.total_slope
    wide[0] = priors.unknown_scale
    return law, law, {SOUND: (law.deviations, sound), UNKNOWN: (law.deviations, wide)}


def unknowns_of(
    stated: Accuracies,
    flown: Sequence[tuple[Observations, HeightRows | None]],
    reference_pressure: float,
    priors: Priors,
) -> Unknowns:
    """Return the unknowns of one or several flights of one airplane.

    Parameters: accuracies of the sensors, 2σ; the rows of each flight with its heights;
    reference_pressure [Pa]; priors.
    """
    share = priors.unknown_share
    span = flown_range([obs for obs, _ in flown])
    static, total, deviations = sources_of(priors, share, span, reference_pressure)
    first = len(static) + len(total)
    common, sound_zero = _common(priors, stated, [obs for obs, _ in flown])
    shared = {name: first + i for i, name in enumerate(common)}
    others = [*common.values()]
    flights, place = [], 0
    for obs, heights in flown:
        layers = _layers_of(obs)
        cosines = _cosines_of(priors, obs)
        own = _own(priors, stated, obs, heights, layers) | {
            f"slow_{axis}_{k}": 1.0 for axis in ("north", "east") for k in range(cosines)
        }
        at = shared | {name: first + len(others) + i for i, name in enumerate(own)}
        others += own.values()
        triangle, slow = slice(place, place + 3), slice(place + 3, place + 5)
        height = slice(slow.stop, slow.stop + (_HEIGHT_NOISE if heights is not None else 0))
        place = height.stop
        flights.append(Flight(obs, heights, layers, cosines, at, triangle, slow, height))
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
        static, total, tuple(flights), first + len(rest), tuple(rivals), departures, priors
    )


def _common(
    priors: Priors, stated: Accuracies, observed: Sequence[Observations]
) -> tuple[dict[str, float], float]:
    """The unknowns of the airplane with their deviations, and that of a sound sensor's zero [Pa]."""
    zero = 0.5 * stated.impact_pressure_zero_pa
    heated = any(obs.probe_heating > 0.0 for obs in observed)
    found = {
        ZERO: max(zero, priors.unknown_zero) if priors.unknown_share > 0.0 else zero,
        "temperature_k": 0.0 if observed[0].standard_day else 0.5 * stated.temperature_k,
        "recovery_factor": 0.5 * stated.recovery_factor if heated else 0.0,
        "static_pressure_pa": 0.5 * stated.static_pressure_pa,
        "latency_s": max(0.5 * stated.latency_s, priors.latency),
    }
    return {name: value for name, value in found.items() if value > 0.0}, max(zero, _NEVER)


def _own(
    priors: Priors,
    stated: Accuracies,
    obs: Observations,
    heights: HeightRows | None,
    layers: Meters,
) -> dict[str, float]:
    """The unknowns of one flight with their deviations."""
    found = {"wind_north": priors.wind, "wind_east": priors.wind}
    thickness = max(float(layers[1] - layers[0]), _THICK)
    shear = priors.shear * float(np.sqrt(_THICK / thickness))
    found |= {
        f"shear_{axis}_{i}": shear for axis in ("north", "east") for i in range(len(layers) - 1)
    }
    if obs.standard_day:
        found["temperature_k"] = 0.5 * max(stated.temperature_k, WITHOUT_TEMPERATURE)
    if heights is not None:
        found["height_latency_s"] = priors.height_latency
        found |= {f"height_{i}": float(each) for i, each in enumerate(heights.deviations)}
    return found


def _cosines_of(priors: Priors, obs: Observations) -> int:
    """The number of cosines down to the shortest period of the slow wind."""
    return int(np.clip(2.0 * float(np.ptp(obs.time)) / priors.slow_shortest, 1, _MOST_COSINES))


def _layers_of(obs: Observations) -> Meters:
    low, high = (float(edge) for edge in np.quantile(obs.height(), [0.01, 0.99]))
    high = max(high, low + 1.0)
    count = min(max(int((high - low) / _LAYER), 1), _MOST_LAYERS)
    return np.linspace(low, high, count + 1)
