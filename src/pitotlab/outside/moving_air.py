"""The air of the outside generator: slow winds and gusts, and the cells of flights in it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotlab.outside.motion import BANK, RATE, lagged
from pitotlab.outside.physics import (
    FOOT,
    KNOT,
    Array,
    SourceError,
    draw_inverse_plus,
    draw_two_slopes,
)

VON_KARMAN = 1.339  # the factor beside the length in the spectra of MIL-F-8785C


def ou_gusts(distance: Array, sigma: float, length: float, dice: np.random.Generator) -> Array:
    """Ornstein-Uhlenbeck gusts [m/s] along the distance flown [m]: (n, 3), exact at each row."""
    decay = np.exp(-np.diff(distance) / length)
    push = sigma * np.sqrt(1.0 - decay**2)
    noise = dice.standard_normal((len(distance), 3))
    gust = np.empty_like(noise)
    gust[0] = sigma * noise[0]
    for row in range(1, len(distance)):
        gust[row] = decay[row - 1] * gust[row - 1] + push[row - 1] * noise[row]
    return gust


def von_karman_gusts(
    distance: Array, heading: Array, sigma: float, length: float, dice: np.random.Generator
) -> Array:
    """Von Karman gusts [m/s]: (n, 3), by spectral synthesis along the path, turned to north and
    east.

    The spectra over the spatial frequency Ω [rad/m] are those of MIL-F-8785C: along the path
    (1 + a²)^(-5/6), across it (1 + 8/3 a²)/(1 + a²)^(11/6), with a = 1.339 L Ω.
    """
    step = 2.0  # m, finer than the distance between two rows
    count = int(2 ** np.ceil(np.log2((distance[-1] - distance[0] + 20.0 * length) / step)))
    a = VON_KARMAN * length * 2.0 * np.pi * np.fft.rfftfreq(count, step)
    along = (1.0 + a**2) ** (-5.0 / 6.0)
    across = 0.5 * (1.0 + 8.0 / 3.0 * a**2) / (1.0 + a**2) ** (11.0 / 6.0)
    s = distance - distance[0]
    u, v, w = (
        np.interp(s, step * np.arange(count), _synthesize(np.asarray(power), count, sigma, dice))
        for power in (along, across, across)
    )
    c, n = np.cos(heading), np.sin(heading)
    return np.stack([c * u - n * v, n * u + c * v, w], axis=-1)


def _synthesize(power: Array, count: int, sigma: float, dice: np.random.Generator) -> Array:
    """One record of a spectrum with the expected standard deviation `sigma`."""
    spectrum = np.fft.rfft(dice.standard_normal(count)) * np.sqrt(power)
    both_sides = 2.0 * power.sum() - power[0] - power[-1]
    return np.asarray(sigma * np.fft.irfft(spectrum, count) / np.sqrt(both_sides / count))


def bursts(time: Array, dice: np.random.Generator) -> Array:
    """A factor on the gusts: 1, and 4 in bursts of 8 s that come about every 80 s; (n, 1)."""
    factor = np.ones_like(time)
    start = dice.exponential(80.0)
    while start < time[-1]:
        factor = np.maximum(factor, 1.0 + 3.0 * np.exp(-0.5 * ((time - start) / 3.0) ** 2))
        start += 8.0 + dice.exponential(72.0)
    return factor[:, None]


def thermals(distance: Array, heading: Array, dice: np.random.Generator) -> Array:
    """Thermals: updrafts of 2 m/s, 150 m wide, about every 1,500 m, with 0.7 m/s of inflow; (n, 3)."""
    up, along = np.zeros_like(distance), np.zeros_like(distance)
    center = dice.exponential(1500.0)
    while center < distance[-1]:
        offset = (distance - center) / 150.0
        bell = np.exp(-0.5 * offset**2)
        up, along = up + 2.0 * bell, along - 0.7 * np.sqrt(np.e) * offset * bell
        center += 300.0 + dice.exponential(1200.0)
    return np.stack([along * np.cos(heading), along * np.sin(heading), -up], axis=-1)


def answer(gust: Array, heading: Array, rate: float) -> Array:
    """The ground velocity [m/s] with which an airplane answers gusts: 20 s along its path, 4 s
    across; (n, 3).

    It has no vertical part: the pilot holds the height.
    """
    c, n = np.cos(heading), np.sin(heading)
    along, across = c * gust[:, 0] + n * gust[:, 1], c * gust[:, 1] - n * gust[:, 0]
    u, v = lagged(along, 20.0, rate), lagged(across, 4.0, rate)
    return np.stack([c * u - n * v, n * u + c * v, np.zeros_like(u)], axis=-1)


SlowWind = Callable[[Array, np.random.Generator], Array]  # time [s] to velocities [m/s], (n, 3)


def still(time: Array, dice: np.random.Generator) -> Array:
    """No slow wind."""
    return np.zeros((len(time), 3))


def mountain_wave(time: Array, dice: np.random.Generator) -> Array:
    """A standing wave of 1 m/s, crossed in 300 s: horizontal, and vertical 90° later."""
    toward, phase = dice.uniform(0.0, 2.0 * np.pi, 2)
    angle = 2.0 * np.pi * time / 300.0 + phase
    level, up = np.cos(angle), np.sin(angle)
    return np.stack([level * np.cos(toward), level * np.sin(toward), -up], axis=-1)


def front(time: Array, dice: np.random.Generator) -> Array:
    """A change of 3 m/s within 20 s, somewhere in the middle of the log."""
    toward, middle = dice.uniform(0.0, 2.0 * np.pi), dice.uniform(0.25, 0.75) * time[-1]
    return _level(3.0 * np.clip((time - middle) / 20.0 + 0.5, 0.0, 1.0), toward)


def steady_change(time: Array, dice: np.random.Generator) -> Array:
    """A wind that changes by 3 m/s in ten minutes."""
    return _level(3.0 * time / 600.0, dice.uniform(0.0, 2.0 * np.pi))


def _level(speed: Array, toward: float) -> Array:
    parts = speed * np.cos(toward), speed * np.sin(toward), np.zeros_like(speed)
    return np.stack(parts, axis=-1)


def drift(time: Array, dice: np.random.Generator, *, size: float, seconds: float) -> Array:
    """A horizontal wind that wanders: Ornstein-Uhlenbeck, `size` [m/s] a component, in time."""
    level = ou_gusts(time, size, seconds, dice)
    level[:, 2] = 0.0
    return level


SHORT = ("step_decrease", "rapid_decel", "circle")
# Mostly the short ones, as the long ones cost time; an odd number, so that each meets both rates of
# GPS.
ALL = (*SHORT, *SHORT, "race_track", *SHORT, *SHORT, *SHORT, "four_leg")


Source = Callable[[float, float, np.random.Generator], SourceError]  # between two airspeeds
Display = Callable[[dict[str, Array]], dict[str, Array]]
Draw = Callable[["Cell", np.random.Generator], "Cell"]


@dataclass(frozen=True, slots=True)
class Cell:
    """One row of the judge's table; the defaults are those of the cell `base`."""

    name: str
    says: str
    maneuvers: tuple[str, ...] = SHORT  # flown in turn
    low: float = 100.0 * KNOT  # m/s, indicated airspeeds of the maneuver
    high: float = 160.0 * KNOT
    height: float = 6000.0 * FOOT  # m
    gusts: str = "ou"  # or von_karman
    gust_sigma: float = 0.5  # m/s, a component
    gust_length: float = 300.0  # m
    bursts: bool = False
    thermals: bool = False
    carried: bool = False
    slow_wind: SlowWind = still
    shear: tuple[float, float] = (0.0, 0.0)  # 1/s, of the wind toward north and east with height
    height_step: float = 0.0  # m, between the levels that the pilot flies
    height_wander: float = 4.0  # m, how well the pilot holds the height, and over how long
    height_seconds: float = 12.0  # s
    speed_wander: float = 0.15  # m/s, and the speed
    speed_seconds: float = 8.0  # s
    bank: float = BANK  # rad, at most, in turns
    source: Source = draw_inverse_plus
    # What a turn adds to the sources' errors, as shares of q_c. Lift and loss are what the level
    # curve holds of each at `low`: the one goes with n/q_c, the other with (n/q_c)².
    lift: float = 0.0  # of the static source
    loss: float = 0.0  # of the total source
    sideslip: float = 0.0  # of the static source in a right turn at 30° of bank; left: the opposite
    probe_offset: float = 0.0  # K, of either sign
    probe_bias: float = 0.0  # K
    probe_warm: float = 0.0  # K at `low`, falling with 1/q_c to none at `high`
    probe_lag: float = 0.0  # s
    recovery: float = 1.0  # share of the rise that a probe of the total temperature shows
    temperature: str = "by seed"  # what is logged: air, total, or one after the other
    static_bias: float = 0.0  # Pa
    impact_scale: float = 1.0  # on the reading of the impact pressure
    impact_zero: float = 0.0  # Pa, added to it
    airspeed_step: float = 0.0  # m/s
    velocity_bias: tuple[float, float] = (0.0, 0.0)  # m/s, north and east
    gps_filter: float = 0.0  # s, a lag of the first order
    gps_late: float = 0.0  # s
    height_late: float = 0.0  # s, by which the receiver's height is later than its velocity
    log_rate: float = RATE  # rows a second
    trim: float = 0.0  # s left out at both ends, where a late or early receiver has no truth
    shown: tuple[Display, ...] = ()  # what a display makes of the columns, one after the other
    drawn: Draw | None = None  # what is drawn anew for each flight
    calibrate: tuple[tuple[str, str], ...] = ()  # choices of the calibration that the cell needs
    named: str = ""  # pattern of the words by which a finding names what is wrong


BASE = Cell("base", "gusts 0.5 m/s of 300 m, every assumption holds", maneuvers=ALL)


CELLS: dict[str, Cell] = {
    cell.name: cell
    for cell in (
        BASE,
        Cell("calm", "no gusts at all", gust_sigma=0.0),
        Cell(
            "jet", "200-350 kt at 20,000 ft", low=200 * KNOT, high=350 * KNOT, height=20000 * FOOT
        ),
        Cell("probe_2k", "temperature 2 K off", probe_offset=2.0),
        Cell("probe_5k", "temperature 5 K off", probe_offset=5.0),
        Cell("length_100", "gusts of 100 m", gust_length=100.0),
        Cell("length_2000", "gusts of 2,000 m", gust_length=2000.0),
        Cell("von_karman", "von Karman gusts of 533 m", gusts="von_karman", gust_length=533.0),
        Cell("wave", "mountain wave 1 m/s, 300 s", slow_wind=mountain_wave),
        Cell("front", "front 3 m/s in 20 s", slow_wind=front),
        Cell("linear", "wind changes by 3 m/s in 10 min", slow_wind=steady_change),
        Cell("steps", "airspeed in steps of 1 kt", airspeed_step=KNOT),
        Cell("calm_steps", "airspeed in steps of 1 kt, calm", airspeed_step=KNOT, gust_sigma=0.0),
        Cell("two_slope", "error curve with a kink", source=draw_two_slopes),
        Cell("bursts", "gusts in bursts x 4", bursts=True),
        Cell("thermals", "thermals 2 m/s over gusts 0.3 m/s", thermals=True, gust_sigma=0.3),
        Cell("carried", "the airplane answers the gusts", carried=True),
        Cell("late", "GPS 0.5 s late", gps_late=0.5),
        Cell(
            "uav",
            "29-58 kt at 500 ft, gusts of 150 m",
            low=29 * KNOT,
            high=58 * KNOT,
            height=500 * FOOT,
            gust_length=150.0,
        ),
    )
}
