"""How the outside generator's airplane moves, and what its instruments make of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from pitotlab.outside.physics import GRAVITY, Array, calibrated_airspeed, impact_pressure

RATE = 20.0  # rows a second
RAMP_SECONDS = 60.0  # from the highest speed to the lowest: 1 kt/s between 160 and 100 kt
STANDARD_TURN = np.radians(3.0)  # rad/s
BANK = np.radians(30.0)
CLIMB = 2.54  # m/s: 500 ft/min, from one level to another
CORNER = 0.7  # s, over which ramps and turns begin


@dataclass(frozen=True, slots=True)
class Leg:
    """A part of a maneuver, until its seconds are over, its angle turned, its speed reached."""

    seconds: float
    speed: float  # 0: the lowest of the maneuver, 1: the highest
    turn: float = 0.0  # degrees
    steep: bool = False  # a turn at 30° of bank that goes on through the whole leg


def _step_decrease() -> tuple[Leg, ...]:
    levels = 1.0 - np.arange(13) / 12.0  # steps of 5 kt
    high, low = levels[:7], levels[6:]
    fly = [Leg(22.1 if k else 17.1, float(v)) for k, v in enumerate(high)]
    fly.append(Leg(0.0, 0.5, 180.0))
    return (*fly, *(Leg(22.1 if k else 17.1, float(v)) for k, v in enumerate(low)))


def _rapid_decel() -> tuple[Leg, ...]:
    down = (Leg(30.0, 1.0), Leg(0.0, 0.0), Leg(30.0, 0.0))
    return (*down, Leg(0.0, 1.0, 180.0), *down)


def _circle() -> tuple[Leg, ...]:
    legs: list[Leg] = []
    for k in range(4):
        ramp = [Leg(0.0, 1.0 - k / 3.0, steep=True)] if k else []
        legs += [*ramp, Leg(50.0, 1.0 - k / 3.0, 330.0, steep=True)]
    return tuple(legs)


def _race_track() -> tuple[Leg, ...]:
    legs: list[Leg] = []
    for k in range(4):
        v, following = 1.0 - k / 3.0, 1.0 - (k + 1) / 3.0
        legs += [Leg(60.0, v), Leg(0.0, v, 180.0), Leg(60.0, v)]
        if k < 3:
            legs.append(Leg(0.0, following, 180.0))
    return tuple(legs)


def _four_leg() -> tuple[Leg, ...]:
    legs: list[Leg] = []
    for k in range(4):
        v, following = 1.0 - k / 3.0, max(1.0 - (k + 1) / 3.0, 0.0)
        legs += [Leg(48.0, v), Leg(0.0, v, 90.0)] * 3
        legs += [Leg(48.0, v), Leg(0.0, following, 90.0)]
    return tuple(legs)


MANEUVERS: dict[str, tuple[Leg, ...]] = {
    "four_leg": _four_leg(),
    "race_track": _race_track(),
    "step_decrease": _step_decrease(),
    "rapid_decel": _rapid_decel(),
    "circle": _circle(),
}


@dataclass(frozen=True, slots=True)
class Motion:
    """Rows of a prescribed motion."""

    time: Array  # s
    indicated_airspeed: Array  # m/s
    turn_rate: Array  # rad/s, right turns positive
    heading: Array  # rad, of the velocity through the air, not wrapped


def fly_maneuver(
    legs: tuple[Leg, ...],
    low: float,
    high: float,
    true_over_indicated: float,
    start: float,
    side: float,
    bank: float = BANK,
) -> Motion:
    """Fly legs between two indicated airspeeds [m/s], from a heading [rad], turning to one side (1
    right, -1 left).

    `true_over_indicated` is the ratio of the airspeeds that fixes the rate of a turn at `bank`.
    """
    speeds, rates = [], []
    speed, ramp = legs[0].speed, 1.0 / (RAMP_SECONDS * RATE)
    for leg in legs:
        rows, turned = 0, 0.0
        target_angle = np.radians(leg.turn)
        while rows < leg.seconds * RATE or turned < target_angle or abs(speed - leg.speed) > 1e-9:
            speed += float(np.clip(leg.speed - speed, -ramp, ramp))
            banked = GRAVITY * np.tan(bank) / ((low + speed * (high - low)) * true_over_indicated)
            gentle = min(STANDARD_TURN, banked) if turned < target_angle else 0.0
            rate = banked if leg.steep else gentle
            turned += rate / RATE
            rows += 1
            speeds.append(speed)
            rates.append(rate)
    smooth = CORNER * RATE
    rate_array = side * gaussian_filter1d(np.array(rates), smooth, mode="nearest")
    speed_array = low + (high - low) * gaussian_filter1d(np.array(speeds), smooth, mode="nearest")
    turned_to = np.cumsum(0.5 * (rate_array[1:] + rate_array[:-1])) / RATE
    heading = start + np.concatenate([[0.0], turned_to])
    return Motion(np.arange(len(speeds)) / RATE, speed_array, rate_array, heading)


def wander(count: int, rms: float, seconds: float, dice: np.random.Generator) -> Array:
    """A smooth random motion of a pilot: Gaussian, with the given rms and time scale."""
    margin = int(5 * seconds * RATE)
    noise = gaussian_filter1d(dice.standard_normal(count + 2 * margin), seconds * RATE)
    expected = 1.0 / np.sqrt(2.0 * np.sqrt(np.pi) * seconds * RATE)  # rms after the filter
    return np.asarray(rms * noise[margin : margin + count] / expected)


def levels(time: Array, step: float, dice: np.random.Generator) -> Array:
    """Height [m] over the middle of two levels: the pilot climbs after one to three minutes."""
    level, now = float(dice.choice([-0.5, 0.5])), 0.0
    corners = [(now, level)]
    while now < time[-1]:
        now += dice.uniform(60.0, 180.0)
        corners.append((now, level))
        now, level = now + step / CLIMB, -level
        corners.append((now, level))
    flown = np.interp(time, *np.array(corners).T)
    return np.asarray(step * gaussian_filter1d(flown, 2.0 * RATE, mode="nearest"))


def lagged(signal: Array, seconds: float, rate: float) -> Array:
    """The signal behind a lag of the first order, at rest in the first row."""
    if not seconds:
        return signal
    gain, state = 1.0 / (seconds * rate), float(signal[0])
    out = np.empty_like(signal)
    for row, value in enumerate(signal):
        state += gain * (float(value) - state)
        out[row] = state
    return out


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations of the sensors' errors."""

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
    time: Array,
    velocity: Array,
    height: Array,
    fix_rate: float,
    late: float,
    dice: np.random.Generator,
    height_late: float = 0.0,
) -> tuple[Array, Array]:
    """Velocity (n, 3) and height (n,) as a standalone receiver reports them, held between fixes.

    `late` is by how much a fix trails the state that it describes [s], `height_late` by how much
    more its height does.
    """
    row = fixes(time, fix_rate)
    then = time[row] - late
    described = np.stack([np.interp(then, time, v) for v in velocity.T], axis=-1)
    noise = NOISE.velocity * dice.standard_normal(velocity.shape)
    white = NOISE.height * dice.standard_normal(len(time))
    slow = _slow_height(time, dice)
    return described + noise[row], np.interp(then - height_late, time, height) + (white + slow)[row]


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
