"""The formulas of the outside generator, from their sources: compressible flow, the standard day,
static errors.
"""

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

Array: TypeAlias = NDArray[np.float64]

KNOT: Final = 1852.0 / 3600.0  # m/s
FOOT: Final = 0.3048  # m
GRAVITY: Final = 9.80665  # m/s²
GAS_CONSTANT: Final = 287.053  # J/(kg K)
GAMMA: Final = 1.4
SEA_LEVEL_PRESSURE: Final = 101325.0  # Pa
SEA_LEVEL_TEMPERATURE: Final = 288.15  # K
LAPSE: Final = 0.0065  # K/m
SOUND_AT_SEA_LEVEL: Final = float(np.sqrt(GAMMA * GAS_CONSTANT * SEA_LEVEL_TEMPERATURE))  # m/s
CORIOLIS: Final = float(2.0 * 7.292115e-5 * np.sin(np.radians(45.0)))  # rad/s, at 45° N


@dataclass(frozen=True, slots=True)
class Day:
    """The air of one day: how far it is from the standard, the same offset at all heights."""

    warmer: float = 0.0  # K
    sea_level_pressure: float = SEA_LEVEL_PRESSURE  # Pa

    def temperature(self, height: Array) -> Array:
        """Temperature of the air [K] at heights [m]."""
        return SEA_LEVEL_TEMPERATURE + self.warmer - LAPSE * height

    def pressure(self, height: Array) -> Array:
        """Hydrostatic pressure [Pa] at heights [m], closed form for a constant lapse."""
        base = SEA_LEVEL_TEMPERATURE + self.warmer
        exponent = GRAVITY / (GAS_CONSTANT * LAPSE)
        return np.asarray(self.sea_level_pressure * (self.temperature(height) / base) ** exponent)

    def density(self, height: Array) -> Array:
        """Density of the air [kg/m³] at heights [m]."""
        return self.pressure(height) / (GAS_CONSTANT * self.temperature(height))


def speed_of_sound(temperature: Array) -> Array:
    """Speed of sound [m/s] at an air temperature [K]."""
    return np.sqrt(GAMMA * GAS_CONSTANT * temperature)


def impact_over_static(mach: Array) -> Array:
    """Impact pressure over static pressure at a Mach number below 1."""
    # expm1 and log1p: at 30 kt the plain power loses five digits
    return np.asarray(np.expm1(3.5 * np.log1p(0.2 * mach**2)))


def mach_number(impact_over_static_pressure: Array) -> Array:
    """Mach number from impact over static pressure."""
    return np.sqrt(5.0 * np.expm1(np.log1p(impact_over_static_pressure) / 3.5))


def impact_pressure(calibrated_airspeed: Array) -> Array:
    """Impact pressure [Pa] of a calibrated airspeed [m/s]."""
    return SEA_LEVEL_PRESSURE * impact_over_static(calibrated_airspeed / SOUND_AT_SEA_LEVEL)


def calibrated_airspeed(impact: Array) -> Array:
    """Calibrated airspeed [m/s] of an impact pressure [Pa]."""
    return SOUND_AT_SEA_LEVEL * mach_number(impact / SEA_LEVEL_PRESSURE)


def total_temperature(temperature: Array, mach: Array, recovery: float = 1.0) -> Array:
    """Temperature [K] of a probe that recovers a share of the rise, all of it by default."""
    return temperature * (1.0 + 0.2 * recovery * mach**2)


def pressure_altitude(pressure: Array) -> Array:
    """Height [m] of a pressure [Pa] in the standard atmosphere."""
    exponent = GAS_CONSTANT * LAPSE / GRAVITY
    return np.asarray(
        SEA_LEVEL_TEMPERATURE / LAPSE * (1.0 - (pressure / SEA_LEVEL_PRESSURE) ** exponent)
    )


@dataclass(frozen=True, slots=True)
class InversePlus:
    """Δp_s/q_c = k1 + k2 x + k3/x with x = q_ci/q_ref."""

    k: tuple[float, float, float]
    reference: float  # Pa

    def share(self, indicated_impact: Array) -> Array:
        """Δp_s/q_c at indicated impact pressures [Pa]."""
        x = indicated_impact / self.reference
        return self.k[0] + self.k[1] * x + self.k[2] / x


@dataclass(frozen=True, slots=True)
class TwoSlopes:
    """Δp_s/q_c in two straight lines over indicated airspeed, joined by a kink."""

    airspeeds: tuple[float, float, float]  # m/s: low end, kink, high end
    shares: tuple[float, float, float]

    def share(self, indicated_impact: Array) -> Array:
        """Δp_s/q_c at indicated impact pressures [Pa]; the lines go on beyond their ends."""
        v = calibrated_airspeed(indicated_impact)
        (low, kink, high), (at_low, at_kink, at_high) = self.airspeeds, self.shares
        below = at_kink + (v - kink) * (at_kink - at_low) / (kink - low)
        above = at_kink + (v - kink) * (at_high - at_kink) / (high - kink)
        return np.where(v < kink, below, above)


@dataclass(frozen=True, slots=True)
class Tabulated:
    """Δp/q_c at points of ln q_ci [ln Pa], straight between them and level beyond."""

    log_impact: tuple[float, ...]
    shares: tuple[float, ...]

    def share(self, indicated_impact: Array) -> Array:
        """Δp/q_c at indicated impact pressures [Pa]."""
        return np.interp(np.log(indicated_impact), self.log_impact, self.shares)


StaticError = InversePlus | TwoSlopes | Tabulated


@dataclass(frozen=True, slots=True)
class TwoSources:
    """Errors of both sources in shares of q_c, positive where they lower the impact pressure.

    p_i = p + f_s q_c and q_ci = q_c (1 − f_s − f_t): that of the total source leaves the static
    pressure as it is.
    """

    static: StaticError
    total: StaticError

    def share(self, indicated_impact: Array) -> Array:
        """(q_c − q_ci)/q_c at indicated impact pressures [Pa]."""
        return self.static.share(indicated_impact) + self.total.share(indicated_impact)


SourceError = StaticError | TwoSources


def total_share(error: SourceError, indicated_impact: Array) -> Array:
    """The part of (q_c − q_ci)/q_c that the total source has."""
    if isinstance(error, TwoSources):
        return error.total.share(indicated_impact)
    return np.zeros_like(indicated_impact)


def through(airspeeds: Array, shares: Array) -> InversePlus:
    """The Inverse+ law through three points of indicated airspeed [m/s] and Δp_s/q_c."""
    q = impact_pressure(airspeeds)
    x = q / q[1]
    k = np.linalg.solve(np.stack([np.ones(3), x, 1.0 / x], axis=-1), shares)
    return InversePlus((float(k[0]), float(k[1]), float(k[2])), float(q[1]))


def draw_inverse_plus(low: float, high: float, dice: np.random.Generator) -> InversePlus:
    """A light airplane's source between two airspeeds [m/s]: 2.5 to 5 % falling to 0.5 to 2 %."""
    at_low, at_high = dice.uniform(0.025, 0.05), dice.uniform(0.005, 0.02)
    at_middle = at_high + dice.uniform(0.3, 0.5) * (at_low - at_high)
    shares = np.array([at_low, at_middle, at_high])
    return through(np.array([low, (low + high) / 2.0, high]), shares)


def draw_two_slopes(low: float, high: float, dice: np.random.Generator) -> TwoSlopes:
    """A source whose error falls to a kink near the middle of the range and is then nearly flat."""
    kink = low + dice.uniform(0.35, 0.65) * (high - low)
    at_low, at_kink = dice.uniform(0.035, 0.05), dice.uniform(0.005, 0.012)
    at_high = at_kink + dice.uniform(0.0, 0.006)
    return TwoSlopes((low, kink, high), (float(at_low), float(at_kink), float(at_high)))


def draw_lifting(low: float, high: float, dice: np.random.Generator, lift: float) -> InversePlus:
    """A static source of a level near −4 % and a part in 1/q_c that is `lift` at the low airspeed."""
    level = dice.uniform(-0.05, -0.03)
    return InversePlus((float(level), 0.0, lift), float(impact_pressure(np.array(low))))


def draw_losing(
    low: float, high: float, dice: np.random.Generator, loss: float, power: float
) -> TwoSources:
    """A usual static source, and a total source that loses `loss` of q_c at the low airspeed and by
    the power of 1/q_c elsewhere.
    """
    slowest, fastest = np.log(impact_pressure(np.array([0.5 * low, 2.0 * high])))
    at = np.linspace(slowest, fastest, 401)
    lost = loss * (impact_pressure(np.array(low)) / np.exp(at)) ** power
    return TwoSources(draw_inverse_plus(low, high, dice), Tabulated(tuple(at), tuple(lost)))


def handbook(airspeeds: Array, corrections: Array) -> Tabulated:
    """The source of an airplane whose handbook adds `corrections` at `airspeeds` [m/s]."""
    at = np.linspace(airspeeds[0], airspeeds[-1], 201)
    indicated = impact_pressure(at)
    impact = impact_pressure(at + PchipInterpolator(airspeeds, corrections)(at))
    return Tabulated(tuple(np.log(indicated)), tuple(1.0 - indicated / impact))


def line_in_log(low: float, high: float, at_low: float, at_high: float) -> Tabulated:
    """Δp/q_c from one value to another, straight in ln q_ci, half the range further on."""
    x = np.log(impact_pressure(np.array([low, high])))
    u = np.array([-2.0, 2.0])
    return Tabulated(
        tuple(x.mean() + 0.5 * u * np.ptp(x)),
        tuple(0.5 * (at_low + at_high) + 0.5 * u * (at_high - at_low)),
    )


def draw_smooth(low: float, high: float, dice: np.random.Generator) -> TwoSources:
    """Two sources drawn from priors over u, the place in the range of ln q_ci from −1 to 1.

    Static: level and slope N(0, 0.05), and departures with a Matérn-3/2 correlation of length 0.7,
    whose size has the median 0.002 and a factor of 2.5 as its standard deviation. Total: level
    N(0, 0.005) and slope N(0, 0.0015), as a calibration assumes.
    """
    x = np.log(impact_pressure(np.array([low, high])))
    u = np.linspace(-2.0, 2.0, 121)
    at = tuple(x.mean() + 0.5 * u * np.ptp(x))
    level, slope, total_level, total_slope = np.array([0.05, 0.05, 0.005, 0.0015]) * (
        dice.standard_normal(4)
    )
    size = 0.002 * 2.5 ** dice.standard_normal()
    apart = np.sqrt(3.0) * np.abs(u[:, None] - u) / 0.7
    root = np.linalg.cholesky((1.0 + apart) * np.exp(-apart) + 1e-9 * np.eye(len(u)))
    departures = size * root @ dice.standard_normal(len(u))
    return TwoSources(
        Tabulated(at, tuple(level + slope * u + departures)),
        Tabulated(at, tuple(total_level + total_slope * u)),
    )


def impact_from_indicated(error: SourceError, indicated_impact: Array) -> Array:
    """q_c [Pa] from q_ci [Pa]: q_ci = q_c (1 − share)."""
    return indicated_impact / (1.0 - error.share(indicated_impact))


def indicated_from_impact(error: SourceError, impact: Array) -> Array:
    """q_ci [Pa] from q_c [Pa], by fixed point: each turn gains a digit."""
    indicated = impact * (1.0 - error.share(impact))
    for _ in range(60):
        before, indicated = indicated, impact * (1.0 - error.share(indicated))
        if np.all(np.abs(indicated - before) <= 1e-12 * impact):
            break
    return indicated
