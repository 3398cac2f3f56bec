"""Kinds of flights beyond the judge's cells, and the sets in which they are written and judged.

A kind is a cell with other fields. What a cockpit's display makes of the columns is a function of
the columns, and what is drawn anew for each flight a function of the cell.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from pitotlab.outside.motion import RATE
from pitotlab.outside.moving_air import BASE, CELLS, SHORT, Cell, Display, drift
from pitotlab.outside.physics import (
    FOOT,
    KNOT,
    Array,
    calibrated_airspeed,
    draw_lifting,
    draw_losing,
    draw_smooth,
    handbook,
    line_in_log,
    pressure_altitude,
)

Columns = dict[str, Array]

# A Cessna 172S by its handbook, flaps up: indicated airspeed and what is added to it [kt]
C172S_KIAS = np.array([40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0, 130.0])
C172S_ADD = np.array([12.0, 6.0, 2.0, 0.0, -2.0, -3.0, -3.0, -3.0, -3.0])


def barometric(columns: Columns) -> Columns:
    """The height is that of the static source in the standard atmosphere, not of the receiver."""
    return columns | {"altitude_m": pressure_altitude(columns["static_pressure_pa"])}


def air_data(columns: Columns) -> Columns:
    """Indicated airspeed and pressure altitude in place of the two pressures."""
    return _without(columns, "impact_pressure_pa", "static_pressure_pa") | {
        "indicated_airspeed_kt": calibrated_airspeed(columns["impact_pressure_pa"]) / KNOT,
        "pressure_altitude_ft": pressure_altitude(columns["static_pressure_pa"]) / FOOT,
    }


def corrected_altitude(columns: Columns, share: float) -> Columns:
    """The outputs of an air-data computer that adds a share of the impact pressure to the static
    pressure before it makes the altitude of it.
    """
    impact = columns["impact_pressure_pa"]
    return air_data(
        columns | {"static_pressure_pa": columns["static_pressure_pa"] + share * impact}
    )


def means(columns: Columns, seconds: float) -> Columns:
    """What a recorder keeps that stores the mean of each span."""
    rows = round(seconds * RATE)
    count = len(columns["time_s"]) // rows
    turned = columns | {"heading_rad": np.unwrap(columns["heading_rad"])}
    kept = {
        name: column[: count * rows].reshape(count, rows).mean(axis=1)
        for name, column in turned.items()
    }
    return kept | {
        "heading_rad": np.mod(kept["heading_rad"], 2.0 * np.pi),
        "gps_fresh": np.ones(count),
    }


def ground_track(columns: Columns) -> Columns:
    """Ground speed and true track in place of the velocities toward north and east."""
    north, east = columns["velocity_north_mps"], columns["velocity_east_mps"]
    return _without(columns, "velocity_north_mps", "velocity_east_mps") | {
        "ground_speed_kt": np.hypot(north, east) / KNOT,
        "track_deg": np.mod(np.degrees(np.arctan2(east, north)), 360.0),
    }


def celsius(columns: Columns) -> Columns:
    """The temperature of the air in °C."""
    return _without(columns, "air_temperature_k") | {
        "air_temperature_degc": columns["air_temperature_k"] - 273.15
    }


def stepped(name: str, step: float, to: Callable[[Array], Array] = np.round) -> Display:
    """A display that shows one column in steps, rounded, or cut off with `to=np.trunc`."""
    return lambda columns: columns | {name: to(columns[name] / step) * step}


def _without(columns: Columns, *names: str) -> Columns:
    return {name: column for name, column in columns.items() if name not in names}


def _factor(dice: np.random.Generator, by: float) -> float:
    """A log-normal factor of median 1; one standard deviation is a factor of `by`."""
    return float(by ** dice.standard_normal())


def draw_priors(cell: Cell, dice: np.random.Generator) -> Cell:
    """Every unknown of a calibration but the curve, drawn from the priors that are stated for it."""
    probe, recovery, static, late, height_late = dice.standard_normal(5) * (
        np.array([0.75, 0.01, 15.0, 0.3, 0.15])
    )
    return replace(
        cell,
        gust_sigma=min(0.5 * _factor(dice, 2.5), 3.0),
        gust_length=533.0 * _factor(dice, 2.5),
        slow_wind=partial(drift, size=0.4 * _factor(dice, 2.5), seconds=300.0 * _factor(dice, 2.5)),
        shear=tuple(0.015 * dice.standard_normal(2)),
        probe_bias=float(probe),
        recovery=1.0 + float(recovery),
        static_bias=float(static),
        velocity_bias=tuple(0.025 * dice.standard_normal(2)),
        gps_late=float(late),
        height_late=float(height_late),
    )


def draw_scale(cell: Cell, dice: np.random.Generator) -> Cell:
    """A factor of 0.7 to 1.5 on the impact pressure; a third of the flights has a zero as well."""
    factor, zero, which = dice.uniform(0.7, 1.5), dice.uniform(20.0, 80.0), dice.random()
    return replace(cell, impact_scale=factor, impact_zero=zero if which < 1.0 / 3.0 else 0.0)


def draw_good(cell: Cell, dice: np.random.Generator) -> Cell:
    """Turns at 15 to 45° of bank in gusts of many sizes and lengths."""
    return replace(
        cell,
        bank=float(np.radians(dice.uniform(15.0, 45.0))),
        gust_sigma=0.5 * _factor(dice, 1.8),
        gust_length=300.0 * _factor(dice, 1.8),
    )


def draw_side(cell: Cell, dice: np.random.Generator) -> Cell:
    """An air-data computer that corrects the altitude by 5 % of the impact pressure, up or down."""
    share = 0.05 * float(dice.choice([-1.0, 1.0]))
    return replace(cell, shown=(partial(corrected_altitude, share=share),))


def draw_shear(cell: Cell, dice: np.random.Generator) -> Cell:
    """A wind that changes by 0.03 m/s a meter of height, toward anywhere."""
    toward = dice.uniform(0.0, 2.0 * np.pi)
    return replace(cell, shear=(0.03 * float(np.cos(toward)), 0.03 * float(np.sin(toward))))


_OF_THE_CELLS = (
    *("calm", "jet", "probe_2k", "probe_5k", "length_2000", "wave", "front", "linear"),
    *("calm_steps", "bursts"),
)
_TRACK = (ground_track, stepped("ground_speed_kt", 1.0), stepped("track_deg", 1.0))
_WHOLE = (celsius, stepped("air_temperature_degc", 1.0, np.trunc))
_COCKPIT = (
    air_data,
    stepped("indicated_airspeed_kt", 1.0),
    stepped("pressure_altitude_ft", 10.0),
    *_TRACK,
    *_WHOLE,
)
_FILTERED = Cell("filtered", "GPS filter 0.3 s, late 0.2 s", gps_filter=0.3, gps_late=0.2)
_LAG = Cell("probe_lag", "the probe lags 10 s", probe_lag=10.0)
_PILOT = Cell(
    "pilot",
    "the pilot is off by 100 ft and 5 kt (rms)",
    height_wander=100.0 * FOOT,
    height_seconds=40.0,
    speed_wander=5.0 * KNOT,
    speed_seconds=20.0,
)


def _like(cell: Cell, name: str, says: str, **fields: Any) -> Cell:
    return replace(cell, name=name, says=says, **fields)


KINDS: dict[str, Cell] = {
    cell.name: cell
    for cell in (
        replace(BASE, maneuvers=SHORT),
        *(CELLS[name] for name in _OF_THE_CELLS),
        replace(CELLS["two_slope"], calibrate=(("model", "auto"),)),
        _FILTERED,
        _like(_FILTERED, "filtered_calm", "the same, calm", gust_sigma=0.0),
        _like(CELLS["steps"], "steps_1hz", "airspeed in 1 kt, rows at 1 Hz", log_rate=1.0),
        Cell("slow_turns", "turns at 10° of bank", bank=float(np.radians(10.0))),
        Cell(
            "shear",
            "shear 0.03/s, two heights 150 ft apart",
            height_step=150.0 * FOOT,
            drawn=draw_shear,
        ),
        *(
            Cell(
                f"altitude_{step}ft",
                f"indicated airspeed, and pressure altitude in {step} ft",
                shown=(air_data, stepped("pressure_altitude_ft", float(step))),
            )
            for step in (10, 1)
        ),
        _LAG,
        _like(
            _LAG, "probe_lag_climbs", "the same, two heights 500 ft apart", height_step=500.0 * FOOT
        ),
        _PILOT,
        Cell("ground_track", "ground speed in 1 kt, track in 1°", shown=_TRACK),
        Cell(
            "whole_degrees",
            "temperature of the air in whole °C, cut off",
            temperature="air",
            shown=_WHOLE,
        ),
        Cell("recovery", "the probe recovers 0.9, not stated", temperature="total", recovery=0.9),
        Cell(
            "barometric",
            "the height is that of the source",
            shown=(barometric,),
            named="barometric",
        ),
        _like(
            _PILOT,
            "cockpit",
            "1 Hz, 1 kt, 10 ft, 1 kt, 1°, whole °C that lag 10 s, 100 ft and 5 kt off",
            temperature="air",
            probe_lag=10.0,
            log_rate=1.0,
            shown=_COCKPIT,
        ),
    )
}

_SLOW = partial(Cell, log_rate=1.0)  # a recorder of one row a second, as of most logs of users
_CIRCLE = partial(_SLOW, maneuvers=("circle",))
_LEAKING = partial(_SLOW, maneuvers=("step_decrease", "rapid_decel", "race_track"))
_LIFT, _LOSS = 0.06, 0.04  # of q_c, at the lowest airspeed
# What a calibration has to hold or to name: a fault of the instruments, or an error that only
# turns show.
FAULTS: dict[str, Cell] = {
    cell.name: cell
    for cell in (
        _CIRCLE(
            "smoothed",
            "the receiver smooths over 2 s",
            gps_filter=2.0,
            named="smoothed|filter|means",
        ),
        _CIRCLE(
            "smoothed_velocity",
            "the same, and its height is in time",
            gps_filter=2.0,
            height_late=-2.0,
            named="smoothed|filter|means",
        ),
        Cell(
            "means",
            "the recorder stores means of 5 s",
            maneuvers=("circle",),
            shown=(partial(means, seconds=5.0),),
            named="smoothed|filter|means",
        ),
        _CIRCLE(
            "lift",
            "a static error in n/q_c, circles at 45° of bank",
            bank=float(np.radians(45.0)),
            source=partial(draw_lifting, lift=_LIFT),
            lift=_LIFT,
            named="lift|load factor",
        ),
        _CIRCLE(
            "loss",
            "the pitot tube loses 4 % at the lowest airspeed, with (n/q_c)²",
            source=partial(draw_losing, loss=_LOSS, power=2.0),
            loss=_LOSS,
            named="incidence|angle of attack",
        ),
        _SLOW(
            "warm_slow",
            "the probe is 6 K warm at the lowest airspeed, right at the highest",
            maneuvers=("race_track",),
            probe_warm=6.0,
            named="temperature|probe",
        ),
        _CIRCLE(
            "sideslip",
            "the static pressure changes by 1.5 % of q_c in turns, all to one side",
            sideslip=0.015,
            named="one side|sideslip",
        ),
        _LEAKING(
            "leak",
            "the pitot line loses 6 %",
            source=partial(draw_losing, loss=0.06, power=0.0),
            named="leak|scale|pitot|total",
        ),
        *(
            _LEAKING(
                f"scale_{sign}4",
                f"the impact pressure is read {sign}4 %",
                impact_scale=scale,
                named="leak|scale|pitot|total",
            )
            for sign, scale in (("+", 1.04), ("-", 0.96))
        ),
        _SLOW(
            "height_off",
            "an air-data computer that corrects its altitude by 5 % of q_c",
            drawn=draw_side,
            named=r"(height|altitude)[^|]* kt",
        ),
        _SLOW(
            "climbs_20k",
            "temperature 20 K off, two heights 1,500 ft apart",
            maneuvers=("step_decrease", "circle", "race_track"),
            height_step=1500.0 * FOOT,
            probe_offset=20.0,
            named="temperature|probe",
        ),
        _SLOW(
            "good",
            "nothing is wrong: banks of 15 to 45°, gusts of many sizes",
            maneuvers=("step_decrease", "rapid_decel", "circle", "race_track"),
            drawn=draw_good,
        ),
    )
}

_LIGHT = Cell(
    "light",
    "Δp/q_c 0.1 at 55 KIAS to -0.05 at 115, straight in ln q_ci",
    low=55.0 * KNOT,
    high=115.0 * KNOT,
    height=3000.0 * FOOT,
    source=lambda low, high, dice: line_in_log(low, high, 0.1, -0.05),
)
_FOUR = ("step_decrease", "rapid_decel", "circle", "race_track")
OTHERS: dict[str, Cell] = {
    cell.name: cell
    for cell in (
        _like(
            CELLS["uav"],
            "scale",
            "uav with 0.7 to 1.5 on the impact pressure, a third with 20 to 80 Pa",
            drawn=draw_scale,
        ),
        _like(CELLS["uav"], "scale_none", "the flights of scale without a factor"),
        Cell("probe_-20k", "temperature 20 K low", probe_bias=-20.0),
        Cell("probe_-5k", "temperature 5 K low", probe_bias=-5.0),
        _LIGHT,
        _like(
            _LIGHT,
            "c172s",
            "the handbook of a C172S",
            source=lambda low, high, dice: handbook(C172S_KIAS * KNOT, C172S_ADD * KNOT),
        ),
        Cell(
            "priors",
            "every unknown drawn from its prior",
            # in 16 seeds each maneuver meets each rate of GPS and each temperature once
            maneuvers=tuple(_FOUR[(row + column) % 4] for row in range(4) for column in range(4)),
            source=draw_smooth,
            trim=2.0,
            drawn=draw_priors,
        ),
    )
}
# The kinds that have gusts, in rougher air: bounds are then twice as wide
ROUGH = {
    f"{name}_rough": _like(cell, f"{name}_rough", f"{cell.says}, gusts 1 m/s", gust_sigma=1.0)
    for name, cell in KINDS.items()
    if cell.gust_sigma
}
SETS: dict[str, tuple[Cell, ...]] = {
    "kinds": tuple(KINDS.values()),
    "rough": tuple(ROUGH.values()),
    "faults": tuple(FAULTS.values()),
    "cells": tuple(CELLS.values()),
    **{name: (cell,) for name, cell in (CELLS | KINDS | ROUGH | FAULTS | OTHERS).items()},
}
