"""Fly an aircraft to its published figures: speeds, climb, ceiling, stall, power.

The figures are in `reference.toml` in the aircraft's folder, each with its weight, height,
tolerance and source. A test flies them all; `reference_table` prints them. The rows keep the
published units: knots, feet and horsepower.
"""

import tomllib
from argparse import ArgumentParser
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi

from pitotbench.catalog import Catalog
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.properties import HORSEPOWER
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT

RATED_POWER = 310.0  # hp an engine
FULL_PRESSURE = 40.0  # inHg
IDLE_PRESSURE = 9.5  # inHg
TEST_WEIGHT = 5990.0  # lb, as loaded
PRESSURE_PER_POWER = 1.0 / 9.2  # inHg/hp, the gain of the power loop
AIRSPEED, MANIFOLD_PRESSURE = 1, 2  # throttle modes
SPEED_BY_PITCH = 2  # pitch mode
MINUTE = 60.0  # s
STALLED = 20.0 * DEGREE  # angle of attack well above that of the greatest lift


@dataclass(frozen=True, slots=True)
class Figure:
    """One published figure: value in `unit`, tolerance in `tolerance_unit` (percent, or that unit)."""

    name: str
    maneuver: str
    value: float
    unit: str
    weight_lb: float
    altitude_ft: float
    tolerance: float
    tolerance_unit: str
    source: str
    speed_kt: float = 100.0
    power: float = 1.0
    flap: float = 0.0


@dataclass(frozen=True, slots=True)
class ReferenceRow:
    """A figure and the value of the model."""

    figure: Figure
    model: float

    @property
    def difference(self) -> float:
        """Return the model's value less the published one, in the unit of the tolerance."""
        if self.figure.tolerance_unit == "%":
            return 100.0 * (self.model / self.figure.value - 1.0)
        return self.model - self.figure.value

    @property
    def within(self) -> bool:
        """Return whether the model is within the figure's tolerance."""
        return abs(self.difference) <= self.figure.tolerance


def published_figures(aircraft: str = "navajo") -> list[Figure]:
    """Return the figures of an aircraft's `reference.toml`, in the order of the file."""
    text = (find_aircraft(aircraft) / "reference.toml").read_text(encoding="utf-8")
    return [Figure(**entry) for entry in tomllib.loads(text)["figure"]]


def fly_reference(aircraft: str = "navajo") -> list[ReferenceRow]:
    """Fly the aircraft to each of its published figures; return one row for each figure."""
    figures = published_figures(aircraft)
    return [ReferenceRow(figure, FLOWN[figure.maneuver](aircraft, figure)) for figure in figures]


def reference_table(aircraft: str = "navajo") -> str:
    """Return the rows as a Markdown table: figure, published value, model, difference, tolerance,
    within it.

    Difference and tolerance are in one unit, so that they can be compared: percent of the figure,
    or its unit.
    """
    lines = ["| figure | published | model | difference | tolerance | within |", f"|{'---|' * 6}"]
    return "\n".join(lines + [_table_line(row) for row in fly_reference(aircraft)])


def _table_line(row: ReferenceRow) -> str:
    figure, unit = row.figure, row.figure.tolerance_unit
    digits = 0 if figure.value >= 300.0 else 1
    cells = (
        figure.name,
        f"{figure.value:,.{digits}f} {figure.unit}",
        f"{row.model:,.{digits}f}",
        f"{row.difference:+.1f} {unit}",
        f"{figure.tolerance:g} {unit}",
        "yes" if row.within else "**no**",
    )
    return f"| {' | '.join(cells)} |"


def level_speed(aircraft: str, figure: Figure) -> float:
    """Return the true airspeed [kt] of level flight at a fraction of the rated power."""
    plant = airborne(aircraft, figure, 150.0)
    hold_power(plant, figure.power, 150.0)
    return plant.get("true_airspeed") / KNOT


def _at_full_pressure(aircraft: str, figure: Figure) -> Plant:
    plant = airborne(aircraft, figure, 150.0)
    hold_pressure(plant, FULL_PRESSURE)
    plant.run(30.0)
    return plant


def engine_power(aircraft: str, figure: Figure) -> float:
    """Return the power of one engine [hp] after 30 s of level flight at full manifold pressure."""
    return _at_full_pressure(aircraft, figure).get("power_left") / HORSEPOWER


def engine_speed(aircraft: str, figure: Figure) -> float:
    """Return the engine speed [rpm] 30 s after full manifold pressure was set."""
    return _at_full_pressure(aircraft, figure).get("propeller_speed_left") / (2.0 * pi / MINUTE)


def climb(aircraft: str, figure: Figure) -> float:
    """Return the rate of climb [ft/min] at full power and constant calibrated airspeed, around a
    height.

    The climb begins one minute below the height, so that the transient of the speed hold is over by
    then.
    """
    return climb_rate(aircraft, figure, figure.altitude_ft)


def climb_rate(aircraft: str, figure: Figure, altitude_ft: float) -> float:
    """Return the rate of climb [ft/min] at full power through a height [ft]."""
    guess = 1500.0 if altitude_ft < 10000.0 else 300.0  # ft/min
    plant = airborne(aircraft, figure, figure.speed_kt, altitude_ft - 1.15 * guess)
    plant.set("pitch_mode", SPEED_BY_PITCH)
    hold_pressure(plant, FULL_PRESSURE)
    plant.run(60.0)
    low = plant.get("altitude")
    plant.run(20.0)
    return (plant.get("altitude") - low) / FOOT / 20.0 * MINUTE


def ceiling(aircraft: str, figure: Figure) -> float:
    """Return the height [ft] of a 100 ft/min climb at full power, from two measured rates."""
    low, high = figure.altitude_ft, figure.altitude_ft + 2500.0
    rate_low, rate_high = (climb_rate(aircraft, figure, height) for height in (low, high))
    return low + (rate_low - 100.0) / (rate_low - rate_high) * (high - low)


def stall(aircraft: str, figure: Figure) -> float:
    """Return the least calibrated airspeed [kt] at idle, slowing 1 kt/s (14 CFR 23.201)."""
    plant = airborne(aircraft, figure, 85.0)
    plant.set("fcs/flap-cmd-norm", figure.flap)
    plant.run(15.0)
    hold_pressure(plant, IDLE_PRESSURE)
    plant.set("pitch_mode", SPEED_BY_PITCH)
    plant.run(10.0)
    plant.set("airspeed_target", 40.0 * KNOT)
    slowest = plant.get("calibrated_airspeed")
    while plant.get("angle_of_attack") < STALLED:
        plant.advance(5)
        slowest = min(slowest, plant.get("calibrated_airspeed"))
    return slowest / KNOT


def level_power(aircraft: str, figure: Figure) -> float:
    """Return the power in level flight at a calibrated airspeed [% of the rated power]."""
    plant = airborne(aircraft, figure, figure.speed_kt)
    plant.run(60.0)
    return 100.0 * plant.get("power_left") / HORSEPOWER / RATED_POWER


def idle_deceleration(aircraft: str, figure: Figure) -> float:
    """Return the mean deceleration [kt/s] from 160 to 100 KCAS, level, throttles closed."""
    plant = airborne(aircraft, figure, 160.0)
    hold_pressure(plant, IDLE_PRESSURE)
    begun, speed = plant.get("time"), plant.get("calibrated_airspeed")
    while plant.get("calibrated_airspeed") > 100.0 * KNOT:
        plant.advance(5)
        plant.check()
    return (speed - plant.get("calibrated_airspeed")) / KNOT / (plant.get("time") - begun)


def airborne(
    aircraft: str, figure: Figure, speed_kt: float, altitude_ft: float | None = None
) -> Plant:
    """Return the aircraft in level flight at the weight of a figure, at a height [ft] and a speed
    [KCAS].

    Without `altitude_ft` the height is that of the figure. The terrain is put 5,000 ft below sea
    level, so that sea-level figures can be flown at sea level.
    """
    plant = Plant.load(aircraft)
    plant.set("position/terrain-elevation-asl-ft", -5000.0)
    plant.set("inertia/pointmass-weight-lbs[4]", figure.weight_lb - TEST_WEIGHT)
    height = figure.altitude_ft if altitude_ft is None else altitude_ft
    plant.start(height * FOOT, speed_kt * KNOT)
    return plant


def hold_pressure(plant: Plant, pressure_inhg: float) -> None:
    """Hold a manifold pressure [inHg] on both engines from now on."""
    plant.set("throttle_mode", MANIFOLD_PRESSURE)
    plant.set("manifold_pressure_target", pressure_inhg * INCH_OF_MERCURY)


def hold_power(plant: Plant, fraction: float, seconds: float) -> None:
    """Fly on for a time [s] at a fraction of the rated power; 1 is full manifold pressure."""
    pressure = FULL_PRESSURE * fraction
    for _ in range(round(seconds)):
        hold_pressure(plant, pressure)
        plant.run(1.0)
        missing = fraction * RATED_POWER - plant.get("power_left") / HORSEPOWER
        if fraction < 1.0:
            pressure += 0.3 * missing * PRESSURE_PER_POWER


FLOWN: Catalog[Callable[[str, Figure], float]] = Catalog(
    "performance maneuver",
    {
        "level speed": level_speed,
        "engine power": engine_power,
        "engine speed": engine_speed,
        "climb": climb,
        "ceiling": ceiling,
        "stall": stall,
        "level power": level_power,
        "idle deceleration": idle_deceleration,
    },
)


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly the model of the Navajo to its published figures and print the table."""
    parser.parse_args(words)
    print(reference_table("navajo"))
