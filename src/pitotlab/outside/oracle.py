"""What the information of a log allows: generalized least squares with the covariance known.

Two equations see the curve. The triangle: the airspeed of the indicated pressures is the length of
ground velocity minus wind. The height: p_i(t) − p(h(t)) is the error of the static source. Every
row of both carries noise whose size and memory the oracle is given; a calibration that has to find
them cannot do better on average.

Rows are means over blocks of a second. The matrices are dense, so that no shortcut can hide an
error.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from pitotlab.outside import physics as physics
from pitotlab.outside.generator import OutsideFlight
from pitotlab.outside.motion import NOISE, RATE, Noise
from pitotlab.outside.moving_air import von_karman_correlation
from pitotlab.outside.physics import Array, InversePlus, central_difference, through

WIND = slice(3, 5)  # where θ = (k1, k2, k3, wind north, wind east) holds the wind


class Height(Enum):
    """What of the second equation is used."""

    NONE = "triangle alone"
    ALONE = "with the height"
    WITH_VELOCITY = "with the height and the vertical velocity"


@dataclass(frozen=True, slots=True)
class Blocks:
    """Block means of the true state, one entry a block."""

    time: Array  # s
    seconds: float  # of a block
    distance: Array  # m through the air
    indicated_impact: Array  # Pa
    indicated_static: Array  # Pa
    temperature: Array  # K
    velocity: Array  # m/s, ground velocity less the slow wind (n, 3)
    position: Array  # m (n, 2)
    height: Array  # m
    density: Array  # kg/m³
    error: InversePlus
    wind: Array  # m/s (2,)
    fix_rate: float  # Hz


@dataclass(frozen=True, slots=True)
class Accuracy:
    """1σ of the errors that are constant over a log: the oracle knows how large they may be."""

    temperature: float = 0.0  # K
    recovery: float = 0.0
    static: float = 0.0  # Pa
    velocity: float = 0.0  # m/s, toward north and toward east


EXACT = Accuracy()
# Half of the 2σ that the calibration takes for usual where a log states nothing.
USUAL_ONE_SIGMA = Accuracy(temperature=0.75, recovery=0.01, static=15.0, velocity=0.025)


@dataclass(frozen=True, slots=True)
class Bound:
    """2σ that the information allows."""

    curve: Array  # m/s, at the truth's points
    wind: Array  # m/s, north and east


def blocks_of(flight: OutsideFlight, seconds: float = 1.0) -> Blocks:
    """Means over blocks of the flight as it would be without gusts."""
    state, rows = flight.state, round(seconds * RATE)
    impact = state.pressure * physics.impact_over_static(
        state.quiet_airspeed / physics.speed_of_sound(state.temperature)
    )
    error = _three_parameters(flight)
    indicated = impact * (1.0 - error.share(impact))
    for _ in range(40):
        indicated = impact * (1.0 - error.share(indicated))
    count = len(state.time) // rows

    def mean(values: Array) -> Array:
        kept = values[: count * rows]
        return np.asarray(kept.reshape(count, rows, *values.shape[1:]).mean(axis=1))

    airspeed = mean(state.quiet_airspeed)
    return Blocks(
        time=mean(state.time),
        seconds=seconds,
        distance=np.cumsum(airspeed) * seconds,
        indicated_impact=mean(indicated),
        indicated_static=mean(state.pressure + impact - indicated),
        temperature=mean(state.temperature),
        velocity=mean(state.ground_velocity - state.slow_wind),
        position=mean(state.position),
        height=mean(state.height),
        density=mean(state.pressure / (physics.GAS_CONSTANT * state.temperature)),
        error=error,
        wind=flight.sky.wind[:2],
        fix_rate=flight.fix_rate,
    )


def _three_parameters(flight: OutsideFlight) -> InversePlus:
    if isinstance(flight.error, InversePlus):
        return flight.error
    low, high = flight.cell.low, flight.cell.high
    at = np.array([low, (low + high) / 2.0, high])
    return through(at, flight.error.share(physics.impact_pressure(at)))


def known_covariance(flight: OutsideFlight) -> bool:
    """Whether the noise of the triangle has a covariance that the oracle can write down."""
    cell = flight.cell
    return not (
        cell.bursts or cell.thermals or cell.carried or (cell.airspeed_step and not cell.gust_sigma)
    )


def bound(
    flight: OutsideFlight,
    height: Height = Height.NONE,
    seconds: float = 1.0,
    noise: Noise = NOISE,
    accuracy: Accuracy = EXACT,
) -> Bound:
    """2σ of the curve and of the wind that a log allows, with or without the second equation.

    The lateness of GPS and the slow wind count as known; constant errors of the sensors are as
    large as `accuracy` says. Raises ValueError for a cell whose covariance cannot be written down.
    """
    if not known_covariance(flight):
        raise ValueError(
            f"the noise of the cell {flight.cell.name!r} has no covariance in closed form"
        )
    blocks = blocks_of(flight, seconds)
    jacobian, covariance = equations(flight, blocks, height, noise)
    constant = constant_errors(blocks, height, accuracy)
    covariance = covariance + constant @ constant.T
    # unknowns differ by ten powers of ten: scale before solving
    scale = np.sqrt(np.sum(jacobian**2, axis=0))
    columns = jacobian / scale
    information = columns.T @ cho_solve(cho_factor(covariance, lower=True), columns)
    spread = np.linalg.inv(information) / np.outer(scale, scale)
    slope = curve_slope(blocks.error, flight.truth.indicated_airspeed)
    curve = np.einsum("ci,ij,cj->c", slope, spread[:3, :3], slope)
    return Bound(2.0 * np.sqrt(curve), 2.0 * np.sqrt(np.diag(spread)[WIND]))


def curve_slope(error: InversePlus, indicated_airspeed: Array) -> Array:
    """Slopes of the calibrated airspeed with k at indicated airspeeds [m/s]: (points, 3)."""
    indicated = physics.impact_pressure(indicated_airspeed)

    def calibrated(k: Array) -> Array:
        return physics.calibrated_airspeed(_impact(k, error.reference, indicated))

    return central_difference(calibrated, np.array(error.k), np.full(3, 1e-5))


def _impact(k: Array, reference: float, indicated: Array) -> Array:
    law = InversePlus((float(k[0]), float(k[1]), float(k[2])), reference)
    return np.asarray(indicated / (1.0 - law.share(indicated)))


def triangle(blocks: Blocks, theta: Array, inputs: Array) -> Array:
    """Airspeed of the pressures minus length of ground velocity less wind [m/s], a block.

    `inputs` (6, n): indicated impact and static pressure, temperature, ground velocity north, east,
    down.
    """
    indicated, static, temperature, north, east, down = inputs
    impact = _impact(theta[:3], blocks.error.reference, indicated)
    mach = physics.mach_number(impact / (static - (impact - indicated)))
    through_air = np.sqrt((north - theta[3]) ** 2 + (east - theta[4]) ** 2 + down**2)
    return np.asarray(mach * physics.speed_of_sound(temperature) - through_air)


def source_error(blocks: Blocks, theta: Array) -> Array:
    """What the height equation sees of θ [Pa]: Δp_s, and the pressure gradient that the wind needs."""
    impact = _impact(theta[:3], blocks.error.reference, blocks.indicated_impact)
    north, east = blocks.position.T
    gradient = blocks.density * physics.CORIOLIS * (theta[3] * east - theta[4] * north)
    return np.asarray(impact - blocks.indicated_impact + gradient)


def equations(
    flight: OutsideFlight, blocks: Blocks, height: Height, noise: Noise
) -> tuple[Array, Array]:
    """Jacobian and covariance of all rows: the triangle, then the height, then the height against
    its velocity.

    The unknowns are θ; with the height an offset and a steady drift of the pressure; with the
    vertical velocity the height at the start.
    """
    theta, inputs = _true_inputs(blocks)
    steps = np.array([1e-5, 1e-5, 1e-5, 1e-3, 1e-3])
    slopes = central_difference(lambda t: triangle(blocks, t, inputs), theta, steps)
    felt = _felt(blocks, theta, inputs)
    covariance = _triangle_covariance(flight, blocks, felt, noise)
    if height is Height.NONE:
        return slopes, covariance
    n, one, zero = len(blocks.time), np.ones_like(blocks.time), np.zeros((len(blocks.time), 1))
    by_height = central_difference(lambda t: source_error(blocks, t), theta, steps)
    drift = (blocks.time - blocks.time.mean()) / 60.0
    weight = blocks.density * physics.GRAVITY  # Pa/m
    receiver = _receiver_covariance(blocks, noise)
    shared = np.diag(felt[1]) * noise.static**2 / _rows(blocks)
    white = np.eye(n) * noise.static**2 / _rows(blocks)
    height_covariance = np.outer(weight, weight) * receiver + white
    if height is Height.ALONE:
        jacobian = np.block([[slopes, zero, zero], [by_height, one[:, None], drift[:, None]]])
        return jacobian, np.block([[covariance, shared], [shared, height_covariance]])
    against = receiver + _integrated_velocity_covariance(blocks, noise)
    cross = weight[:, None] * receiver
    nothing = np.zeros((n, n))
    jacobian = np.block(
        [
            [slopes, zero, zero, zero],
            [by_height, one[:, None], drift[:, None], zero],
            [np.zeros((n, 5)), zero, zero, one[:, None]],
        ]
    )
    return jacobian, np.block(
        [
            [covariance, shared, nothing],
            [shared, height_covariance, cross],
            [nothing, cross.T, against],
        ]
    )


def constant_errors(blocks: Blocks, height: Height, accuracy: Accuracy) -> Array:
    """What one standard deviation of each constant error does to the rows: (rows, errors)."""
    felt = _felt(blocks, *_true_inputs(blocks))
    airspeed = np.linalg.norm(blocks.velocity - np.append(blocks.wind, 0.0), axis=1)
    mach = airspeed / physics.speed_of_sound(blocks.temperature)
    # a probe that recovers more than is taken into account reads high: T_t = T(1 + 0.2 r M²)
    temperature = blocks.temperature * 0.2 * mach**2
    each = [
        felt[2] * accuracy.temperature,
        felt[2] * temperature * accuracy.recovery,
        felt[1] * accuracy.static,
        *(felt[3:5] * accuracy.velocity),
    ]
    triangle_rows = np.stack(each, axis=1)
    if height is Height.NONE:
        return triangle_rows
    # a layer that is warmer than measured is thicker; a static zero is part of the unknown offset
    above = physics.GRAVITY * blocks.density * (blocks.height - blocks.height.mean())
    height_rows, velocity_rows = np.zeros((2, *triangle_rows.shape))
    height_rows[:, 0] = above * accuracy.temperature / blocks.temperature
    return np.concatenate(
        [triangle_rows, height_rows, *([velocity_rows] if height is Height.WITH_VELOCITY else [])]
    )


def _true_inputs(blocks: Blocks) -> tuple[Array, Array]:
    """θ and the inputs of the triangle, (6, n), as they are."""
    pressures = [blocks.indicated_impact, blocks.indicated_static]
    inputs = [*pressures, blocks.temperature, *blocks.velocity.T]
    return np.array([*blocks.error.k, *blocks.wind]), np.stack(inputs)


def _felt(blocks: Blocks, theta: Array, inputs: Array) -> Array:
    """How the triangle's row answers its six inputs: (6, n)."""
    slopes = []
    for place, step in enumerate((0.1, 1.0, 0.01, 1e-3, 1e-3, 1e-3)):
        shift = np.zeros_like(inputs)
        shift[place] = step
        above, below = (triangle(blocks, theta, inputs + each) for each in (shift, -shift))
        slopes.append((above - below) / (2.0 * step))
    return np.stack(slopes)


def _rows(blocks: Blocks) -> float:
    return blocks.seconds * RATE


def _fixes(blocks: Blocks) -> float:
    return blocks.seconds * blocks.fix_rate


def _triangle_covariance(flight: OutsideFlight, blocks: Blocks, felt: Array, noise: Noise) -> Array:
    """Gusts along the velocity through the air, and the white noise of all inputs."""
    white = (
        (felt[0] * noise.impact) ** 2
        + (felt[1] * noise.static) ** 2
        + (felt[2] * noise.temperature) ** 2
    ) / _rows(blocks)
    white = white + np.sum(felt[3:] ** 2, axis=0) * noise.velocity**2 / _fixes(blocks)
    cell, directions = flight.cell, felt[3:].T
    apart = np.abs(blocks.distance[:, None] - blocks.distance[None, :])
    if cell.gusts == "von_karman":  # drawn along the path: always the longitudinal correlation
        correlation = von_karman_correlation(apart, cell.gust_length)
    else:
        correlation = (directions @ directions.T) * mean_exponential(
            apart, blocks.distance, cell.gust_length
        )
    return cell.gust_sigma**2 * correlation + np.diag(white)


def mean_exponential(apart: Array, position: Array, length: float) -> Array:
    """Correlation of block means of a process with exp(−|Δs|/L): blocks lie at `position`, side by
    side.

    The mean of exp over two blocks of widths aL and bL a distance apart is exp times
    sinh(a/2)/(a/2) times sinh(b/2)/(b/2); over one block with itself it is 2(a − 1 + exp(−a))/a².
    """
    width = np.gradient(position) / length
    half = np.sinh(width / 2.0) / (width / 2.0)
    correlation = np.exp(-apart / length) * np.outer(half, half)
    within = 2.0 * (width + np.expm1(-width)) / width**2
    np.fill_diagonal(correlation, within)
    return correlation


def _receiver_covariance(blocks: Blocks, noise: Noise) -> Array:
    """Error of the receiver's height [m²]: white, and slow."""
    apart = np.abs(blocks.time[:, None] - blocks.time[None, :])
    slow = noise.slow_height**2 * mean_exponential(apart, blocks.time, noise.slow_height_seconds)
    return slow + np.eye(len(blocks.time)) * noise.height**2 / _fixes(blocks)


def _integrated_velocity_covariance(blocks: Blocks, noise: Noise) -> Array:
    """Error of the integrated vertical velocity [m²]: a random walk of white errors, one a fix."""
    since = blocks.time - blocks.time[0] + blocks.seconds / 2.0
    walk = np.minimum(since[:, None], since[None, :])
    return np.asarray(noise.velocity**2 / blocks.fix_rate * walk)
