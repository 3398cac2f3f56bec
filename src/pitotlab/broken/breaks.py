"""Break the air data of good logs: ten kinds of broken pitots and lines, drawn from a seed.

The flights are those of the outside generator. What a broken line does is written here anew from
its physics, in terms of the pressures at the two ports; nothing of the product is used.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pitotlab.outside import physics
from pitotlab.outside.generator import OutsideFlight, generate
from pitotlab.outside.kinds import KINDS as AIRPLANES
from pitotlab.outside.motion import RATE
from pitotlab.outside.moving_air import CELLS, Cell
from pitotlab.outside.physics import FOOT, Array

Dice = np.random.Generator
NOISE = 10.0  # Pa, 1σ of each pressure, as the generator's sensors have
REST_SECONDS, PAUSE = 30.0, 120.0  # s at rest, and between rest and flight
TRANSITION = 1.0  # s, in which a bead of water moves
LIGHT = replace(CELLS["uav"], height=1500.0 * FOOT)
LIGHT_HIGH = replace(LIGHT, height=6000.0 * FOOT)
CLIMBING = replace(AIRPLANES["probe_lag_climbs"], probe_lag=0.0)
LIGHT_CLIMBING = replace(LIGHT, height_step=300.0 * FOOT)
PILOT = AIRPLANES["pilot"]
BASE = AIRPLANES["base"]
CIRCLING = ("race_track", "four_leg")  # where a zero shows: each speed on several headings
SLOW = 40.0  # m/s: a drone, whose log begins and ends at rest
ROUGH = replace(BASE, gust_sigma=1.0)
JET = AIRPLANES["jet"]


@dataclass(slots=True)
class Ports:
    """The pressures [Pa] and speeds [m/s] of a flight by row, before sensors add their noise."""

    time: Array
    total: Array  # at the total port
    static: Array  # at the static port
    ground_speed: Array  # as the receiver reports it, held between fixes
    true_airspeed: Array

    @property
    def impact(self) -> Array:
        """Indicated impact pressure [Pa]."""
        return self.total - self.static


@dataclass(frozen=True, slots=True)
class Broken:
    """What the sensors of a broken system measure: impact and static pressure [Pa], whether the
    impact pressure has the noise of a sensor, and whether the log begins and ends at rest.
    """

    impact: Array
    static: Array
    noisy: bool = True
    rests: bool = False


def _moment(ports: Ports, dice: Dice) -> float:
    """A moment in the middle of the log [s]."""
    return float(ports.time[0] + dice.uniform(0.3, 0.7) * np.ptp(ports.time))


def _stuck(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The sensor shows one number: from the first row on, or from a moment on."""
    start = ports.time[0] if variant % 2 else _moment(ports, dice)
    since = int(np.searchsorted(ports.time, start))
    impact = ports.impact + NOISE * dice.standard_normal(len(ports.time))
    impact[since:] = impact[since]
    return Broken(impact, ports.static, noisy=False)


def _trapped(ports: Ports, since: int, seconds: float) -> Array:
    """The pressure [Pa] in a blocked total line that leaks to the static pressure around it."""
    total, held = ports.total.copy(), ports.total[since]
    step = np.diff(ports.time, prepend=ports.time[0])
    for row in range(since, len(total)):
        held += (ports.static[row] - held) * step[row] / seconds
        total[row] = held
    return total


def _blocked(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The total line is blocked before the log begins, and leaks slowly."""
    total = _trapped(ports, 0, dice.uniform(600.0, 3000.0))
    return Broken(total - ports.static, ports.static)


def _iced(ports: Ports, dice: Dice, variant: int) -> Broken:
    """Ice closes the tube: with an open drain the airspeed dies, with a closed one it freezes."""
    start = _moment(ports, dice)
    since = int(np.searchsorted(ports.time, start))
    leak = dice.uniform(5.0, 20.0) if variant % 2 else 1e9
    return Broken(_trapped(ports, since, leak) - ports.static, ports.static)


def _taped(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The static port is taped over: the line holds the pressure of the first row."""
    static = np.full_like(ports.static, ports.static[0])
    return Broken(ports.total - static, static)


def _water(ports: Ports, dice: Dice, variant: int) -> Broken:
    """A bead of water in the total line, which slides to and fro and lags the pressure by 2 s."""
    least = dice.uniform(12.0, 25.0) * physics.GRAVITY  # Pa: 12 to 25 mm of water
    bead = max(dice.uniform(0.12, 0.25) * float(np.median(ports.impact)), least)
    moments, now = [], float(ports.time[0])
    while now < ports.time[-1]:
        now += dice.uniform(15.0, 70.0)
        moments.append(now)
    turns = np.sum(
        [np.clip((ports.time - at) / TRANSITION, 0.0, 1.0) * (-1.0) ** n for n, at in enumerate(moments)],
        axis=0,
    )  # fmt: skip
    impact, lagged = ports.impact, np.empty_like(ports.impact)
    state = float(impact[0])
    for row, step in enumerate(np.diff(ports.time, prepend=ports.time[0])):
        state += (float(impact[row]) - state) * min(step / 2.0, 1.0)
        lagged[row] = state
    return Broken(lagged + bead * (turns - 0.5) * float(dice.choice([-1.0, 1.0])), ports.static)


def _exchanged(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The two lines are exchanged; every second recorder shows no airspeed below zero."""
    impact = -ports.impact
    return Broken(np.maximum(impact, 0.0) if variant % 2 else impact, ports.total, variant % 2 == 0)


def _half(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The sensor shows half of the pressure, or the computer half of the airspeed."""
    if variant % 2:
        return Broken(0.5 * ports.impact, ports.static)
    half = physics.impact_pressure(0.5 * physics.calibrated_airspeed(ports.impact))
    return Broken(half, ports.static)


def _copied(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The airspeed is the ground speed of the receiver, as it is or in steps of 0.1 m/s."""
    speed = np.round(ports.ground_speed, 1) if variant % 2 else ports.ground_speed
    return Broken(physics.impact_pressure(speed), ports.static, noisy=False)


def _true(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The true airspeed stands in the column of the indicated airspeed."""
    return Broken(physics.impact_pressure(ports.true_airspeed), ports.static)


def _drifts(ports: Ports, dice: Dice, variant: int) -> Broken:
    """The zero drifts as the sensor warms up after it was switched on."""
    size = dice.uniform(0.3, 0.6) * float(np.quantile(ports.impact, 0.1))
    since = ports.time - ports.time[0]
    level = 1.0 - np.exp(-since / dice.uniform(200.0, 600.0))
    size *= float(dice.choice([-1.0, 1.0])) / level[-1]
    return Broken(
        ports.impact + size * level,
        ports.static,
        rests=float(np.median(ports.true_airspeed)) < SLOW,
    )


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of broken pitot: what breaks it, where it is flown, and words to be told. What is
    `shown` stands in a column of the airspeed: no pressure holds it, nor an autopilot's log.
    """

    name: str
    broken: Callable[[Ports, Dice, int], Broken]
    cells: tuple[Cell, ...]
    words: tuple[str, ...]
    shown: bool = False


_USUAL = (BASE, LIGHT, PILOT)
_HEIGHTS = (CLIMBING, PILOT, LIGHT_CLIMBING)
_WARMING = tuple(replace(c, maneuvers=CIRCLING) for c in (LIGHT, BASE, LIGHT_CLIMBING))
KINDS = {
    kind.name: kind
    for kind in (
        Kind("stuck", _stuck, _USUAL, ("stuck", "stands still")),
        Kind("blocked", _blocked, (*_USUAL, *_HEIGHTS), ("total line is blocked",)),
        Kind("iced", _iced, (*_USUAL, *_HEIGHTS), ("--to",)),
        Kind("taped", _taped, _HEIGHTS, ("static port is closed",)),
        Kind("water", _water, (BASE, LIGHT, PILOT, ROUGH), ("water",)),
        Kind("exchanged", _exchanged, (*_USUAL, JET), ("exchanged",)),
        Kind("half", _half, (*_USUAL, JET), ("half",)),
        Kind("copied", _copied, (*_USUAL, JET), ("copy of the GPS",)),
        Kind("true airspeed", _true, (BASE, PILOT, LIGHT_HIGH, JET), ("true airspeed",), True),
        Kind("drifting zero", _drifts, _WARMING, ("zero drifts",)),
    )
}


def ports_of(flight: OutsideFlight) -> Ports:
    """The pressures at the ports of a flight whose log holds every row."""
    state = flight.state
    static = state.pressure + (state.impact - state.indicated_impact) - state.total_error
    columns = flight.columns
    return Ports(
        time=state.time,
        total=state.pressure + state.impact - state.total_error,
        static=static,
        ground_speed=np.hypot(columns["velocity_north_mps"], columns["velocity_east_mps"]),
        true_airspeed=state.true_airspeed,
    )


def broken_columns(kind: Kind, seed: int, variant: int) -> dict[str, Array]:
    """The columns of one broken log. `variant` counts the logs of a kind and picks cell and form."""
    cell = kind.cells[variant % len(kind.cells)]
    flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
    dice = np.random.default_rng([seed, 48])
    # Every second log in each cell has the other form.
    found = kind.broken(ports_of(flight), dice, variant + variant // len(kind.cells))
    count = len(found.impact)
    noise = NOISE * dice.standard_normal((2, count))
    impact = found.impact + noise[0] if found.noisy else found.impact
    pressures = {"impact_pressure_pa": impact, "static_pressure_pa": found.static + noise[1]}
    columns = flight.columns | pressures
    if found.rests:
        zeros = found.impact[[0, -1]] - ports_of(flight).impact[[0, -1]]
        columns = _with_rest(columns, flight, (float(zeros[0]), float(zeros[1])), dice)
    return as_shown(columns) if kind.shown else columns


def as_shown(columns: Mapping[str, Array]) -> dict[str, Array]:
    """The columns of a log with the airspeed in place of the impact pressure."""
    impact = np.maximum(columns["impact_pressure_pa"], 0.0)
    others = {name: column for name, column in columns.items() if name != "impact_pressure_pa"}
    return {"indicated_airspeed_mps": physics.calibrated_airspeed(impact), **others}


def _with_rest(
    columns: dict[str, Array], flight: OutsideFlight, zeros: tuple[float, float], dice: Dice
) -> dict[str, Array]:
    """The log of a flight with half a minute at rest on the ground before and after it; take-off and
    landing were not recorded. `zeros` are those of the sensor [Pa] then.
    """
    count = round(REST_SECONDS * RATE)
    ground = float(flight.sky.day.pressure(np.array(0.0)))
    air = float(flight.sky.day.temperature(np.array(0.0)))
    clocks = (columns["time_s"][0] - PAUSE, columns["time_s"][-1] + PAUSE)
    around: list[dict[str, Array]] = []
    for zero, clock, side in zip(zeros, clocks, (-1.0, 1.0), strict=True):
        still = {name: np.full(count, values[0]) for name, values in columns.items()}
        breeze = 0.6 * (3.0 + dice.standard_normal(count)) ** 2  # Pa of 3 m/s
        still["time_s"] = np.sort(clock + side * np.arange(count) / RATE)
        still["impact_pressure_pa"] = zero + breeze + NOISE * dice.standard_normal(count)
        still["static_pressure_pa"] = ground + NOISE * dice.standard_normal(count)
        still["altitude_m"] = 0.3 * dice.standard_normal(count)
        still["gps_fresh"] = np.ones(count)
        for axis in ("north", "east", "down"):
            still[f"velocity_{axis}_mps"] = 0.05 * dice.standard_normal(count)
        for name in ("air_temperature_k", "total_temperature_k"):
            if name in still:
                still[name] = np.full(count, air)
        around.append(still)
    first, last = around
    return {n: np.concatenate([first[n], columns[n], last[n]]) for n in columns}
