"""What the sensors make of the true state: noise, held GPS rows, lateness, steps."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tests.outside.compressible import Array, calibrated_airspeed, impact_pressure
from tests.outside.kinematics import RATE


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations of the sensors' errors; one record for the generator and the oracle."""

    impact: float = 10.0  # Pa, white
    static: float = 10.0  # Pa, white
    temperature: float = 0.05  # K, white
    velocity: float = 0.05  # m/s, white, a fix and component
    height: float = 0.3  # m, white, a fix
    slow_height: float = 2.0  # m, Ornstein-Uhlenbeck
    slow_height_seconds: float = 90.0  # s
    attitude: float = float(np.radians(0.2))  # rad, white


NOISE = Noise()


def fixes(time: Array, fix_rate: float) -> NDArray[np.int_]:
    """The row of the last GPS fix at each row."""
    every = round(RATE / fix_rate)
    return np.asarray(np.arange(len(time)) // every * every)


def receive(
    time: Array, velocity: Array, height: Array, fix_rate: float, late: float, dice: np.random.Generator
) -> tuple[Array, Array]:
    """Velocity (n, 3) and height (n,) as a standalone receiver reports them, held between fixes.

    `late` is by how much a fix trails the state that it describes [s].
    """
    row = fixes(time, fix_rate)
    then = time[row] - late
    described = np.stack([np.interp(then, time, v) for v in velocity.T], axis=-1)
    noise = NOISE.velocity * dice.standard_normal(velocity.shape)
    white = NOISE.height * dice.standard_normal(len(time))
    slow = _slow_height(time, dice)
    return described + noise[row], np.interp(then, time, height) + (white + slow)[row]


def _slow_height(time: Array, dice: np.random.Generator) -> Array:
    decay = float(np.exp(-1.0 / (RATE * NOISE.slow_height_seconds)))
    noise = NOISE.slow_height * dice.standard_normal(len(time))
    push = float(np.sqrt(1.0 - decay**2))
    slow = np.empty_like(noise)
    slow[0] = noise[0]
    for row in range(1, len(noise)):
        slow[row] = decay * slow[row - 1] + push * noise[row]
    return slow


def in_steps(impact: Array, step: float) -> Array:
    """Impact pressure [Pa] of an airspeed that is read in steps [m/s]."""
    return impact_pressure(np.round(calibrated_airspeed(impact) / step) * step)
