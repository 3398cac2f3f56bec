"""The error of the static source: Δp_s over q_c as a function of indicated airspeed."""

from dataclasses import dataclass

import numpy as np
from tests.outside.compressible import Array, calibrated_airspeed, impact_pressure


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
        v, (low, kink, high), (at_low, at_kink, at_high) = (
            calibrated_airspeed(indicated_impact),
            self.airspeeds,
            self.shares,
        )
        below = at_kink + (v - kink) * (at_kink - at_low) / (kink - low)
        above = at_kink + (v - kink) * (at_high - at_kink) / (high - kink)
        return np.where(v < kink, below, above)


StaticError = InversePlus | TwoSlopes


def through(airspeeds: Array, shares: Array) -> InversePlus:
    """The Inverse+ law through three points of indicated airspeed [m/s] and Δp_s/q_c."""
    q = impact_pressure(airspeeds)
    x = q / q[1]
    k = np.linalg.solve(np.stack([np.ones(3), x, 1.0 / x], axis=-1), shares)
    return InversePlus((float(k[0]), float(k[1]), float(k[2])), float(q[1]))


def draw_inverse_plus(low: float, high: float, dice: np.random.Generator) -> InversePlus:
    """A light airplane's source between two indicated airspeeds [m/s]: 2.5 to 5 % falling to 0.5 to 2 %."""
    at_low, at_high = dice.uniform(0.025, 0.05), dice.uniform(0.005, 0.02)
    at_middle = at_high + dice.uniform(0.3, 0.5) * (at_low - at_high)
    return through(np.array([low, (low + high) / 2.0, high]), np.array([at_low, at_middle, at_high]))


def draw_two_slopes(low: float, high: float, dice: np.random.Generator) -> TwoSlopes:
    """A source whose error falls to a kink near the middle of the range and is then nearly flat."""
    kink = low + dice.uniform(0.35, 0.65) * (high - low)
    at_low, at_kink = dice.uniform(0.035, 0.05), dice.uniform(0.005, 0.012)
    return TwoSlopes((low, kink, high), (float(at_low), float(at_kink), float(at_kink + dice.uniform(0.0, 0.006))))


def impact_from_indicated(error: StaticError, indicated_impact: Array) -> Array:
    """q_c [Pa] from q_ci [Pa]: q_ci = q_c − Δp_s."""
    return indicated_impact / (1.0 - error.share(indicated_impact))


def indicated_from_impact(error: StaticError, impact: Array) -> Array:
    """q_ci [Pa] from q_c [Pa], by fixed point: the error changes slowly with speed, so each turn gains a digit."""
    indicated = impact * (1.0 - error.share(impact))
    for _ in range(60):
        better = impact * (1.0 - error.share(indicated))
        done = bool(np.all(np.abs(better - indicated) <= 1e-12 * impact))
        indicated = better
        if done:
            break
    return indicated


def true_correction(error: StaticError, indicated_airspeed: Array) -> Array:
    """Calibrated minus indicated airspeed [m/s] at indicated airspeeds [m/s]."""
    impact = impact_from_indicated(error, impact_pressure(indicated_airspeed))
    return calibrated_airspeed(impact) - indicated_airspeed
