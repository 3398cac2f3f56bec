"""Flights of a prescribed motion through prescribed air, recorded by prescribed sensors: logs with
a known truth.

The error sits in the static source: p_i = p(h) + Δp_s, so q_ci = q_c − Δp_s where the total pressure
is right. An error of the total source takes its part of q_ci and leaves p_i as it is.
Nothing here comes from the product: the judge writes the log to a file and reads it as a user
would.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pitotlab.outside import moving_air
from pitotlab.outside import physics as physics
from pitotlab.outside.motion import (
    BANK,
    MANEUVERS,
    NOISE,
    RATE,
    Motion,
    fixes,
    fly_maneuver,
    in_steps,
    lagged,
    levels,
    receive,
    wander,
)
from pitotlab.outside.moving_air import Cell
from pitotlab.outside.physics import FOOT, Array, Day, SourceError, impact_from_indicated

WIND_RMS = 6.0  # m/s, a component of the mean wind
_AXES = ("north", "east", "down")
_PURPOSES = (
    *("card", "error", "wind", "pilot", "gust", "slow_wind", "thermals", "sensors", "receiver"),
    *("unknowns", "levels"),
)


@dataclass(frozen=True, slots=True)
class Sky:
    """The air of one flight: the day, the mean wind, and the pressure gradient that the wind needs."""

    day: Day
    wind: Array  # m/s toward north, east, down (3,)
    height: float  # m

    def gradient(self) -> Array:
        """Pressure gradient toward north and east [Pa/m] in geostrophic balance at 45° N."""
        rho_f = float(self.day.density(np.array(self.height))) * physics.CORIOLIS
        return np.array([-rho_f * self.wind[1], rho_f * self.wind[0]])

    def pressure(self, height: Array, north: Array, east: Array) -> Array:
        """True static pressure [Pa] at a height [m] and a place [m] from the start."""
        toward_north, toward_east = self.gradient()
        return np.asarray(self.day.pressure(height) + toward_north * north + toward_east * east)


@dataclass(frozen=True, slots=True)
class State:
    """The true state, one entry a row."""

    time: Array  # s
    height: Array  # m
    position: Array  # m, north and east of the start (n, 2)
    ground_velocity: Array  # m/s toward north, east, down (n, 3)
    slow_wind: Array  # m/s on top of the mean wind (n, 3)
    gust: Array  # m/s (n, 3)
    true_airspeed: Array  # m/s, gusts included
    quiet_airspeed: Array  # m/s, without gusts
    pressure: Array  # Pa
    temperature: Array  # K
    impact: Array  # Pa, true impact pressure
    indicated_impact: Array  # Pa
    total_error: Array  # Pa, by which the total pressure is read too low
    heading: Array  # rad
    turn_rate: Array  # rad/s


@dataclass(frozen=True, slots=True)
class OutsideFlight:
    """A flight, and its log."""

    cell: Cell
    maneuver: str
    seed: int
    fix_rate: float  # Hz
    sky: Sky
    error: SourceError
    state: State
    columns: dict[str, Array]

    @property
    def mean_wind(self) -> Array:
        """Wind toward north and east [m/s], (2,): the mean over the log, gusts aside."""
        return np.asarray(self.sky.wind[:2] + self.state.slow_wind[:, :2].mean(axis=0))

    def correction(self, indicated_airspeed: Array) -> Array:
        """True calibrated minus indicated airspeed [m/s] at airspeeds [m/s] of the log."""
        indicated = _impact_of_reading(self.cell, indicated_airspeed)
        impact = impact_from_indicated(self.error, indicated)
        return physics.calibrated_airspeed(impact) - indicated_airspeed

    def position_error(self, indicated_airspeed: Array) -> Array:
        """True minus indicated pressure altitude [ft] at indicated airspeeds [m/s] of the log."""
        indicated = _impact_of_reading(self.cell, indicated_airspeed)
        impact = impact_from_indicated(self.error, indicated)
        pressure = self.sky.day.pressure(np.full(len(indicated), self.cell.height))
        total = physics.total_share(self.error, indicated) * impact
        heights = map(physics.pressure_altitude, (pressure, pressure + impact - indicated - total))
        return np.asarray(np.subtract(*heights) / FOOT)


def generate(cell: Cell, maneuver: str, seed: int) -> OutsideFlight:
    """One flight. The same seed draws the same day, wind, error curve and heading in every cell.

    Even seeds have GPS at 20 Hz, odd ones at 1 Hz; every second pair of seeds logs the temperature
    of the air instead of the total temperature. Raises KeyError for an unknown maneuver.
    """
    children = np.random.SeedSequence(seed).spawn(len(_PURPOSES))
    dice = dict(zip(_PURPOSES, map(np.random.default_rng, children), strict=True))
    if cell.drawn:
        cell = cell.drawn(cell, dice["unknowns"])
    sky = _draw_sky(cell, dice["wind"])
    error = cell.source(cell.low, cell.high, dice["error"])
    state = _fly(cell, maneuver, sky, error, dice)
    fix_rate = 20.0 if seed % 2 == 0 else 1.0
    air_temperature = {"air": True, "total": False}.get(cell.temperature, seed // 2 % 2 == 1)
    columns = _logged(cell, _record(cell, state, fix_rate, air_temperature, dice))
    return OutsideFlight(cell, maneuver, seed, fix_rate, sky, error, state, columns)


def _draw_sky(cell: Cell, dice: np.random.Generator) -> Sky:
    day = Day(dice.normal(0.0, 8.0), physics.SEA_LEVEL_PRESSURE + dice.normal(0.0, 700.0))
    north, east = WIND_RMS * dice.standard_normal(2)
    return Sky(day, np.array([north, east, 0.0]), cell.height)


def _fly(
    cell: Cell, maneuver: str, sky: Sky, error: SourceError, dice: dict[str, np.random.Generator]
) -> State:
    card = dice["card"]
    motion = fly_maneuver(
        MANEUVERS[maneuver],
        cell.low,
        cell.high,
        _true_over_indicated(cell, sky.day),
        card.uniform(0.0, 2.0 * np.pi),
        float(card.choice([-1.0, 1.0])),
        cell.bank,
    )
    count = len(motion.time)
    height = cell.height + wander(count, cell.height_wander, cell.height_seconds, dice["pilot"])
    if cell.height_step:
        height = height + levels(motion.time, cell.height_step, dice["levels"])
    down = -np.gradient(height, 1.0 / RATE)
    slow = cell.slow_wind(motion.time, dice["slow_wind"])
    if any(cell.shear):
        slow[:, :2] += (height - cell.height)[:, None] * np.array(cell.shear)
    wandering = wander(count, cell.speed_wander, cell.speed_seconds, dice["pilot"])
    quiet = _commanded_airspeed(motion, sky.day, error, height, wandering)
    level = np.sqrt(quiet**2 - (down - slow[:, 2]) ** 2)
    through_air = np.stack(
        [level * np.cos(motion.heading), level * np.sin(motion.heading), down - slow[:, 2]], axis=-1
    )
    gust = _gust(cell, motion, quiet, dice)
    velocity = through_air + sky.wind + slow
    if cell.carried:
        velocity = velocity + moving_air.answer(gust, motion.heading, RATE)
    airspeed = np.linalg.norm(velocity - sky.wind - slow - gust, axis=1)
    position = _integrate(velocity[:, :2])
    pressure = sky.pressure(height, position[:, 0], position[:, 1])
    temperature = sky.day.temperature(height)
    impact = pressure * physics.impact_over_static(airspeed / physics.speed_of_sound(temperature))
    in_level = physics.indicated_from_impact(error, impact)
    static, total = _of_turns(cell, in_level, quiet * motion.turn_rate / physics.GRAVITY)
    return State(
        time=motion.time,
        height=height,
        position=position,
        ground_velocity=velocity,
        slow_wind=slow,
        gust=gust,
        true_airspeed=airspeed,
        quiet_airspeed=quiet,
        pressure=pressure,
        temperature=temperature,
        impact=impact,
        indicated_impact=in_level - (static + total) * impact,
        total_error=(physics.total_share(error, in_level) + total) * impact,
        heading=motion.heading,
        turn_rate=motion.turn_rate,
    )


def _of_turns(cell: Cell, in_level: Array, tangent: Array) -> tuple[Array, Array]:
    """What turns add to the errors of the static and of the total source, in shares of q_c.

    Parameters: in_level, the impact pressure that level flight would indicate [Pa]; tangent, that
    of the bank.
    """
    slow, load = physics.impact_pressure(np.array(cell.low)) / in_level, np.hypot(1.0, tangent)
    static = cell.lift * (load - 1.0) * slow + cell.sideslip * tangent / np.tan(BANK)
    return static, cell.loss * (load**2 - 1.0) * slow**2


def _true_over_indicated(cell: Cell, day: Day) -> float:
    """Ratio of true to indicated airspeed in mid range, near enough for the rate of a turn."""
    h = np.array(cell.height)
    middle = 0.5 * (cell.low + cell.high)
    mach = physics.mach_number(physics.impact_pressure(np.array(middle)) / day.pressure(h))
    return float(mach * physics.speed_of_sound(day.temperature(h)) / middle)


def _commanded_airspeed(
    motion: Motion, day: Day, error: SourceError, height: Array, wandering: Array
) -> Array:
    """True airspeed [m/s] at which the gauge shows what the card asks for, in air without gusts."""
    impact = impact_from_indicated(
        error, physics.impact_pressure(motion.indicated_airspeed + wandering)
    )
    mach = physics.mach_number(impact / day.pressure(height))
    return mach * physics.speed_of_sound(day.temperature(height))


def _gust(cell: Cell, motion: Motion, quiet: Array, dice: dict[str, np.random.Generator]) -> Array:
    distance = _integrate(quiet[:, None])[:, 0]
    if cell.gusts == "von_karman":
        gust = moving_air.von_karman_gusts(
            distance, motion.heading, cell.gust_sigma, cell.gust_length, dice["gust"]
        )
    else:
        gust = moving_air.ou_gusts(distance, cell.gust_sigma, cell.gust_length, dice["gust"])
    if cell.bursts:
        gust = gust * moving_air.bursts(motion.time, dice["thermals"])
    if cell.thermals:
        gust = gust + moving_air.thermals(distance, motion.heading, dice["thermals"])
    return gust


def _integrate(rate: Array) -> Array:
    """The integral of rows (n, k) from the first row, by the trapezoidal rule."""
    steps = 0.5 * (rate[1:] + rate[:-1]) / RATE
    return np.concatenate([np.zeros((1, rate.shape[1])), np.cumsum(steps, axis=0)])


def _record(
    cell: Cell,
    state: State,
    fix_rate: float,
    air_temperature: bool,
    dice: dict[str, np.random.Generator],
) -> dict[str, Array]:
    sensors, count = dice["sensors"], len(state.time)
    total_pressure = state.pressure + state.impact - state.total_error
    static = state.pressure + (state.impact - state.indicated_impact) - state.total_error
    reading = cell.impact_scale * (total_pressure - static) + cell.impact_zero
    impact = reading + NOISE.impact * sensors.standard_normal(count)
    if cell.airspeed_step:
        impact = in_steps(impact, cell.airspeed_step)
    temperature = state.temperature
    if not air_temperature:
        mach = physics.mach_number(state.impact / state.pressure)
        temperature = physics.total_temperature(temperature, mach, cell.recovery)
    temperature = lagged(temperature, cell.probe_lag, RATE)
    warm = cell.probe_warm * _slowness(cell, state.impact)
    offset = cell.probe_offset * float(sensors.choice([-1.0, 1.0])) + cell.probe_bias
    velocity, height = receive(
        state.time,
        np.stack([lagged(v, cell.gps_filter, RATE) for v in state.ground_velocity.T], axis=-1),
        lagged(state.height, cell.gps_filter, RATE),
        fix_rate,
        cell.gps_late,
        dice["receiver"],
        cell.height_late,
    )
    velocity[:, :2] += cell.velocity_bias
    attitude = _attitude(state) + NOISE.attitude * sensors.standard_normal((count, 3))
    return {
        "time_s": state.time,
        "impact_pressure_pa": impact,
        "static_pressure_pa": (
            static + NOISE.static * sensors.standard_normal(count) + cell.static_bias
        ),
        "air_temperature_k" if air_temperature else "total_temperature_k": (
            temperature + warm + offset + NOISE.temperature * sensors.standard_normal(count)
        ),
        **{f"velocity_{axis}_mps": velocity[:, i] for i, axis in enumerate(_AXES)},
        "gps_fresh": (fixes(state.time, fix_rate) == np.arange(count)).astype(float),
        "altitude_m": height,
        "roll_rad": attitude[:, 0],
        "pitch_rad": attitude[:, 1],
        "heading_rad": np.mod(attitude[:, 2], 2.0 * np.pi),
    }


def _slowness(cell: Cell, impact: Array) -> Array:
    """1 at the lowest airspeed of a cell, 0 at the highest, straight in 1/q_c."""
    low, high = physics.impact_pressure(np.array([cell.low, cell.high]))
    return np.asarray((1.0 / impact - 1.0 / high) / (1.0 / low - 1.0 / high))


def _logged(cell: Cell, columns: dict[str, Array]) -> dict[str, Array]:
    """The rows that the recorder keeps, as its display shows them."""
    margin, every = round(cell.trim * RATE), round(RATE / cell.log_rate)
    rows = slice(margin, len(columns["time_s"]) - margin, every)
    columns = {name: column[rows] for name, column in columns.items()}
    for show in cell.shown:
        columns = show(columns)
    return columns


def read_airspeed(cell: Cell, indicated_airspeed: Array) -> Array:
    """The airspeed [m/s] that the log shows for that of the sources [m/s]."""
    impact = physics.impact_pressure(indicated_airspeed)
    return physics.calibrated_airspeed(cell.impact_scale * impact + cell.impact_zero)


def _impact_of_reading(cell: Cell, airspeed: Array) -> Array:
    """The impact pressure [Pa] of the sources for an airspeed of the log [m/s]."""
    return (physics.impact_pressure(airspeed) - cell.impact_zero) / cell.impact_scale


def _attitude(state: State) -> Array:
    """Roll, pitch, heading [rad] of coordinated flight, (n, 3); 4° of attack at mean airspeed."""
    quiet = state.quiet_airspeed
    roll = np.arctan(quiet * state.turn_rate / physics.GRAVITY)
    attack = np.radians(4.0) * (float(np.mean(quiet)) / quiet) ** 2 / np.cos(roll)
    climb = -state.ground_velocity[:, 2] / quiet
    return np.stack([roll, attack * np.cos(roll) + climb, state.heading], axis=-1)


def write_csv(columns: Mapping[str, Array], path: Path) -> None:
    """Write the columns of a log as a table with a line of names."""
    forms = ["%d" if name == "gps_fresh" else "%.9g" for name in columns]
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, fmt=forms, delimiter=",", header=",".join(columns), comments="")
