"""The equations of a calibration at one point: the wind triangle, and the heights beside it.

The rows are means over blocks of about a second. In the triangle the noisy channel, the impact
pressure, is predicted from the clean one, the ground velocity, and the difference is told as a true
airspeed [m/s]. The basis of the curve is taken at the predicted pressure: at the measured one it
would explain the gusts. The heights' equations are in meters of air.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pitotbench import air
from pitotbench.calibration.observations import Blocks, Observations
from pitotbench.estimation.noise import NORMAL, MarkovNoise, MarkovProcess
from pitotbench.records import NoAnswerError
from pitotbench.units import Array, MetersPerSecond, Pascal
from pitotlab.candidate.heights import HeightNoise
from pitotlab.candidate.linear_gaussian import Equations
from pitotlab.candidate.unknowns import ZERO, Flight, Unknowns

_NEWTON_STEPS, _LAST_STEP = 8, 1e-5  # at most; of the impact pressure
_SMOOTHING = 3.0  # s, width of the zero-phase filter that makes the instruments
_WHITE_FLOOR = 1e-8  # (m/s)²: keeps the covariance regular for logs without noise
# m/s²: smaller accelerations along the path answer gusts, by an airspeed hold or by drag alone, and
# imitate a latency (flights without one gave −1.0 to −1.5 s on circles and level legs).
_PLANNED = 0.4


@dataclass(frozen=True, slots=True)
class Prediction:
    """The predicted reading of the impact pressure (n,) [Pa] and its derivatives.

    `slope` (n,) [Pa s/m] is that by the true airspeed, `airspeed` (n,) [m/s]; `columns` (n, p) are
    those by the unknowns, over the slope, in m/s a unit.
    """

    reading: Pascal
    slope: Array
    airspeed: MetersPerSecond
    columns: Array


def predict(unknowns: Unknowns, flight: Flight, beta: Array) -> Prediction:
    """Predict every row of a flight for unknowns β (p,).

    Of the static source's error Δp_s = f_s q_c the static pressure is p = p_i − Δp_s; of both,
    q_ci = q_c (1 − f_s − f_t).
    """
    obs, at = flight.observations, flight.at
    known = {name: beta[place] for name, place in at.items()}
    air_velocity, layers, slow = _through_air(flight, beta)
    ground = np.linalg.norm(air_velocity, axis=1)
    along = air_velocity / ground[:, None]
    late = np.sum(along[:, :2] * _acceleration(obs), axis=1)
    speed = ground + known.get("latency_s", 0.0) * late
    temperature = obs.probe_temperature - known.get("temperature_k", 0.0)
    heating = obs.probe_heating * (1.0 + known.get("recovery_factor", 0.0))
    ratio, by_square = _pressure_ratio(speed**2, temperature, heating)
    pressure = obs.static_pressure - known.get("static_pressure_pa", 0.0)
    zero = known.get(ZERO, 0.0)
    static, total = unknowns.static, unknowns.total
    z_static, z_total = beta[unknowns.of_static], beta[unknowns.of_total]
    q = obs.impact_pressure - zero  # Newton's method starts from the measured one
    for _ in range(_NEWTON_STEPS):
        of_static, of_total = static.basis(q), total.basis(q)
        f_static, f_total = of_static @ z_static, of_total @ z_total
        rest, shape = 1.0 - f_static - f_total, 1.0 / (1.0 + f_static * ratio)
        by_total = -pressure * ratio * shape
        by_static = by_total * shape * (1.0 + ratio * (1.0 - f_total))
        bend = by_static * (static.slope(q) @ z_static) + by_total * (total.slope(q) @ z_total)
        step = (-by_total * rest - q) / (1.0 - bend)
        q = q + step
        if float(np.max(np.abs(step))) < _LAST_STEP * float(np.max(np.abs(q))):
            break
    damping = 1.0 - bend
    slope = pressure * rest * shape**2 * by_square * 2.0 * speed / damping
    columns = np.zeros((unknowns.count, len(obs))).T
    columns[:, unknowns.of_static] = of_static * (by_static / damping / slope)[:, None]
    columns[:, unknowns.of_total] = of_total * (by_total / damping / slope)[:, None]
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * temperature
    effects = {
        ZERO: 1.0 / slope,
        "wind_north": -along[:, 0],
        "wind_east": -along[:, 1],
        # V = M √(γRT): the same ground velocity in colder air is a greater impact pressure.
        "temperature_k": 0.5 * speed / temperature,
        "recovery_factor": 0.1 * speed**3 / heat * (obs.probe_heating > 0.0),
        "static_pressure_pa": -ratio * rest * shape / damping / slope,
        "latency_s": late,
    }
    for axis, name in enumerate(("north", "east")):
        effects |= {
            f"shear_{name}_{i}": -along[:, axis] * layer for i, layer in enumerate(layers.T)
        }
    for axis, places in enumerate(flight.slow_places):
        columns[:, places] = -along[:, axis, None] * slow
    for name, effect in effects.items():
        if name in at:
            columns[:, at[name]] = effect
    return Prediction(q + zero, slope, speed, columns)


def _pressure_ratio(squared: Array, temperature: Array, heating: float) -> tuple[Array, Array]:
    """q_c/p of a squared true airspeed [m²/s²] and its derivative with respect to V².

    From V² = M² γRT and T_t = T(1 + 0.2 r M²): M² = V²/(γR T_t − 0.2 r V²).
    """
    heat = air.HEAT_RATIO * air.GAS_CONSTANT * temperature
    rest = heat - heating * squared
    base = 1.0 + 0.2 * squared / rest
    return base**3.5 - 1.0, 0.7 * base**2.5 * heat / (rest * rest)


def _through_air(flight: Flight, beta: Array) -> tuple[Array, Array, Array]:
    """The velocity through the air, (n, 3) [m/s], the height above the middle of each layer, and
    the cosines of the slow wind.
    """
    obs = flight.observations
    wind = np.zeros((len(obs), 3))
    layers, slow = flight.shear_basis(obs.height()), flight.slow_basis(obs.time)
    for axis, name in enumerate(("north", "east")):
        shear = [flight.value(f"shear_{name}_{i}", beta) for i in range(layers.shape[1])]
        wind[:, axis] = flight.value(f"wind_{name}", beta) + layers @ np.array(shear)
        wind[:, axis] += slow @ beta[flight.slow_places[axis]]
    ground = np.stack([obs.velocity_north, obs.velocity_east, obs.velocity_down], axis=1)
    return ground - wind, layers, slow


def _acceleration(obs: Observations) -> Array:
    """Acceleration over the ground toward north and east, (n, 2) [m/s²]; zero beside a pause."""
    rates = np.stack([np.gradient(v, obs.time) for v in (obs.velocity_north, obs.velocity_east)], 1)
    edge = np.flatnonzero(np.diff(obs.stretch))
    rates[edge] = rates[edge + 1] = 0.0
    return rates


@dataclass(frozen=True, slots=True)
class Triangle:
    """The equations of one flight's wind triangle, with what its blocks are.

    `along` (n, 2) are the direction cosines of the velocity through the air toward north and east.
    """

    equations: Equations
    blocks: Blocks
    along: Array


def triangle(
    unknowns: Unknowns,
    flight: Flight,
    blocks: Blocks,
    beta: Array,
    gust: float,
) -> Triangle:
    """Linearize the wind triangle of a flight at β (p,).

    Gusts across the flight path lengthen the airspeed vector by σ²/V on average, with σ = `gust`
    [m/s]; this is subtracted. Raises NoAnswerError where β is outside the model's domain.
    """
    obs, at = flight.observations, flight.at
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        seen = predict(unknowns, flight, beta)
    if not np.isfinite(np.sum(seen.columns)) or not np.all(seen.slope > 0.0):
        raise NoAnswerError(
            "the fit leaves the domain of the model (no airspeed explains some rows): check the "
            "clock and the units, also of part of the log, or choose a model with fewer parameters"
        )
    columns = blocks.mean(seen.columns)
    residual = blocks.mean((obs.impact_pressure - seen.reading) / seen.slope)
    airspeed, slope = blocks.mean(seen.airspeed), blocks.mean(seen.slope)
    along = -columns[:, flight.winds]
    residual -= gust**2 / airspeed
    instruments = gaussian_filter1d(columns, _SMOOTHING / blocks.length, axis=0, mode="nearest")
    if "latency_s" in at:
        own = instruments[:, at["latency_s"]]
        instruments[:, at["latency_s"]] = np.where(np.abs(own) > _PLANNED, own, 0.0)
    moved = np.flatnonzero(np.any(columns != 0.0, axis=0))
    sensor = (_sensor_noise(obs) / slope) ** 2 / blocks.count
    noise = WindNoise(blocks, blocks.at_edges(airspeed), along[None], sensor)
    equations = Equations(
        residual,
        beta[moved],
        columns[:, moved],
        instruments[:, moved],
        moved,
        noise,
        flight.triangle,
    )
    return Triangle(equations, blocks, along)


def _sensor_noise(obs: Observations) -> float:
    """White noise of the impact pressure [Pa], from its second differences (slow signals cancel)."""
    second = np.diff(obs.impact_pressure, 2)
    return float(NORMAL * np.median(np.abs(second)) / np.sqrt(6.0))


@dataclass(frozen=True, slots=True)
class WindNoise:
    """The map from φ to the covariance of the triangle.

    φ = ln(gusts [m/s], their length [m], white noise [m/s]). The gusts are a horizontal vector
    whose components are first-order Gauss-Markov processes along the path. `airspeed` [m/s] holds at the edges of the blocks, `seen`
    (1, n, 2) are direction cosines, `sensor` (n,) [(m/s)²] the pressure sensor's noise.
    """

    blocks: Blocks
    airspeed: MetersPerSecond
    seen: Array
    sensor: Array

    def stack(self, phis: Array) -> MarkovNoise:
        """Return the covariances for many φ, (b, d)."""
        sizes = np.exp(phis)
        winds = [MarkovProcess(sizes[:, 0], sizes[:, 1, None] / self.airspeed, self.seen)]
        variance = self.sensor + sizes[:, 2, None] ** 2 + _WHITE_FLOOR
        return MarkovNoise(self.blocks.intervals, variance[:, None, :], winds)


def height_equations(unknowns: Unknowns, flight: Flight, beta: Array) -> Equations:
    """Linearize the heights of a flight at β (p,): p_i − p(h) = f_s q_c, in meters of air.

    Air data that trail the GPS see an older height: a latency shows in the climb rate.
    """
    assert flight.heights is not None
    own, rows, at = flight.heights, flight.heights.rows, flight.at
    flying, zero = rows.impact_pressure > 0.0, flight.value(ZERO, beta)
    q = np.where(flying, np.maximum(rows.impact_pressure - zero, 1.0), 0.0)
    static, total = unknowns.of_static, unknowns.of_total
    of_static, of_total = unknowns.static.basis(q), unknowns.total.basis(q)
    f = of_static @ beta[static]
    rest = 1.0 - f - of_total @ beta[total]
    meters = rows.gain * q / rest
    columns = np.zeros((len(rows), unknowns.count))
    columns[:, static] = of_static * (meters * (rest + f) / rest)[:, None]
    columns[:, total] = of_total * (meters * f / rest)[:, None]
    bend = unknowns.static.slope(q) @ beta[static]
    effects = {
        ZERO: np.where(flying, -rows.gain * (f / rest + q * bend / rest**2), 0.0),
        "temperature_k": rows.warmth,
        "latency_s": -own.climb,
        "height_latency_s": -own.climb,
    }
    for name, effect in effects.items():
        if name in at:
            columns[:, at[name]] = effect
    bent = [*range(total.stop), *([at[ZERO]] if ZERO in at else [])]
    response = rows.rise - meters * f + columns[:, bent] @ beta[bent]
    if rows.tie is not None:
        ties = rows.tie[np.isfinite(rows.fix)]
        response = np.concatenate([response, ties])
        columns = np.concatenate([columns, np.zeros((len(ties), columns.shape[1]))])
    columns[:, [at[f"height_{i}"] for i in range(own.columns.shape[1])]] = own.columns
    moved = np.flatnonzero(np.any(columns != 0.0, axis=0))
    seen = columns[:, moved]
    whole = np.zeros(len(moved))  # the response is what all unknowns explain, not a rest
    return Equations(response, whole, seen, seen, moved, HeightNoise(rows), flight.height)
