"""Both sides of a comparison through one filter, and the forces that a change of the model adds."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import BadInputError, FlightLog, air
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.overlay import (
    Overlay,
    evaluate,
    operation,
    product,
    properties_in,
    quotient,
    total,
)
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.replay import (
    REACTION_NAMES,
    added_forces,
    adds_forces,
    answer,
    motion_of,
    properties_of_forces,
    varied_states,
)
from pitotbench.reconciliation.residuals import AircraftModel
from pitotbench.reconciliation.track import Track, grid_of, track_of
from pitotbench.records.motion import Motion, UnitForces
from pitotbench.units import Array

PERIOD = 7.0  # s


def log_of(rate: float, gps_rate: float, seconds: float = 60.0, late: float = 0.0) -> FlightLog:
    """A log whose velocity and impact pressure swing alike; the GPS holds its last fix."""
    time = np.arange(0.0, seconds, 1.0 / rate)
    fix = np.floor(time * gps_rate + 1e-6) / gps_rate
    fresh = np.diff(fix, prepend=-1.0) > 0.0
    wave = 60.0 + 5.0 * np.sin(2.0 * np.pi * (time - late) / PERIOD)
    held = 60.0 + 5.0 * np.sin(2.0 * np.pi * fix / PERIOD)
    return FlightLog(
        time=time,
        impact_pressure=wave,
        static_pressure=np.full_like(time, 8e4),
        velocity_north=held,
        velocity_east=np.zeros_like(time),
        gps_fresh=fresh,
    )


def lateness(log: FlightLog) -> float:
    """Delay of the air data against the GPS [s] as the grid sees it, by least squares on the slope."""
    track = track_of(log)
    grid = grid_of(track)
    air_data = grid.smooth(track["impact_pressure"])
    gps = grid.smooth(track["velocity_north"], gps=True)
    slope = 2.0 * np.pi / PERIOD * 5.0 * np.cos(2.0 * np.pi * track.time[grid.rows] / PERIOD)
    return float(-(air_data - gps) @ slope / (slope @ slope))


@pytest.mark.parametrize(
    ("rate", "gps_rate"), [(20.0, 1.0), (20.0, 5.0), (50.0, 5.0), (50.0, 50.0), (100.0, 10.0)]
)
@pytest.mark.parametrize("marked", [True, False])
def test_no_phantom_delay_also_where_no_column_marks_the_fixes(
    rate: float, gps_rate: float, marked: bool
) -> None:
    log = log_of(rate, gps_rate)
    log = log if marked else replace(log, gps_fresh=None)
    assert abs(lateness(log)) < 0.004
    assert track_of(log).fix_period == pytest.approx(1.0 / gps_rate)


def test_a_delay_is_seen() -> None:
    assert lateness(log_of(50.0, 5.0, late=0.2)) == pytest.approx(0.2, abs=0.01)


def test_lost_rows_are_filled_and_gaps_split() -> None:
    log = log_of(50.0, 50.0)
    rows = np.ones(len(log), dtype=np.bool_)
    rows[500:503] = False  # 60 ms lost
    rows[1500:1700] = False  # 4 s without recording
    track = track_of(log.select(rows))
    assert len(track.start) == 3
    assert np.allclose(np.diff(track.time[: track.start[1]]), 0.02)
    assert abs(lateness(log.select(rows))) < 0.004


@pytest.mark.parametrize("gps_rate", [1.0, 2.0, 2.5, 20.0])
def test_the_step_is_the_time_between_instants(gps_rate: float) -> None:
    """Of a GPS of 2.5 Hz every second fix is taken; the step was told as 0.5 s, not as 0.8 s."""
    track = track_of(log_of(20.0, gps_rate))
    grid = grid_of(track)
    assert np.allclose(np.diff(track.time[grid.rows]), grid.step)


def test_mean_between_is_exact_for_a_constant_rate() -> None:
    track = track_of(log_of(50.0, 50.0))
    grid = grid_of(track)
    rate = grid.rate(grid.smooth(3.0 * track.time), track)
    assert np.allclose(rate[1:], 3.0)
    assert np.allclose(grid.mean_between(np.full(len(track.time), 3.0))[1:], 3.0)


def test_a_log_that_is_too_short_or_stands_still_is_refused() -> None:
    with pytest.raises(BadInputError, match="stretch"):
        track_of(log_of(50.0, 50.0, seconds=5.0))
    log = log_of(50.0, 50.0)
    with pytest.raises(BadInputError, match="fewer than two GPS fixes"):
        track_of(replace(log, velocity_north=np.full_like(log.time, 60.0), gps_fresh=None))


@pytest.mark.parametrize("warmer", [-15.0, 0.0, 8.0, 20.0])
def test_the_offset_of_a_day_is_that_of_its_air_at_every_height(warmer: float) -> None:
    """The air is made from its own law: hydrostatic balance through a standard lapse with an
    offset.
    """
    height = np.linspace(1000.0, 2500.0, 400)
    temperature = air.SEA_LEVEL_TEMPERATURE + warmer - air.LAPSE_RATE * height
    exponent = air.GRAVITY / (air.GAS_CONSTANT * air.LAPSE_RATE)
    pressure = (
        air.SEA_LEVEL_PRESSURE * (temperature / (air.SEA_LEVEL_TEMPERATURE + warmer)) ** exponent
    )
    still = np.zeros_like(height)
    channels = {
        "static_pressure": pressure,
        "impact_pressure": np.full_like(height, 3000.0),
        "air_temperature": temperature,
        "angle_of_attack": still,
        "sideslip": still,
    }
    time = 0.1 * np.arange(len(height))
    track = Track(time, channels, (0, len(time)), np.arange(len(time)), 0.1, 0.1)
    found = varied_states(track, np.arange(0, len(time), 5))["temperature_offset"]
    assert found == pytest.approx(warmer, abs=1e-6)


SAME = 1e-6  # of the largest change: the rate of the angle of attack is that of the call before
Measured = tuple[AircraftModel, Motion, Array, UnitForces]


@pytest.fixture(scope="module")
def measured(sensed) -> Measured:
    log = sensed(das="50/50")
    track = track_of(log.select(log.time < log.time[0] + 25.0))
    motion = motion_of(track, np.arange(0, len(track.time), 50))
    # Banked and at a high lift, so that every effect of the table shows.
    motion = replace(motion, roll=motion.roll + 0.5, angle_of_attack=motion.angle_of_attack + 0.08)
    model = aircraft_model("navajo")
    units = model.unit_forces(motion, properties_of_forces(model.baseline))
    return model, motion, answer(lambda m: model.react(m, Overlay(), False), motion), units


def sizes_of_forces() -> list[tuple[str, str]]:
    """Every size of the table that adds functions of force alone."""
    model = aircraft_model("navajo")
    aircraft = [e for e in EFFECTS.values() if isinstance(e, AircraftEffect)]
    sizes = [(e, p) for e in aircraft for p in e.parameters if not p.shape]
    return [
        (e.name, p.name)
        for e, p in sizes
        if adds_forces(e.overlay(e.complete({p.name: p.typical}), model.baseline))
    ]


def test_most_effects_of_the_airframe_add_forces() -> None:
    assert {"belly_pod", "induced_drag", "polar_bend", "trim_offset", "turn_drag"} <= dict(
        sizes_of_forces()
    ).keys()


@pytest.mark.parametrize(("name", "parameter"), sizes_of_forces())
def test_added_forces_are_those_of_the_force_meter(
    measured: Measured, name: str, parameter: str
) -> None:
    model, motion, held, units = measured
    effect = EFFECTS[name]
    sizes = {p.name: 1.7 * p.typical for p in effect.parameters if p.shape or p.name == parameter}
    overlay = effect.overlay(effect.complete(sizes), model.baseline)
    on_meter = answer(lambda m: model.react(m, overlay, False), motion) - held
    assert np.abs(on_meter).max() > 3e-4  # m/s², rad/s²: far above rounding
    assert np.allclose(
        added_forces(overlay, units), on_meter, rtol=0.0, atol=SAME * np.abs(on_meter).max()
    )


def test_an_added_moment_keeps_pace_with_a_quick_roll(sensed) -> None:
    """Ten states a second, at which a rate of half a hertz is whole; what a pound changes is
    measured once a second and interpolated.
    """
    log = sensed(das="50/50")
    track = track_of(log.select(log.time < log.time[0] + 12.0))
    motion = motion_of(track, np.arange(0, len(track.time), 5))
    motion = replace(motion, roll_rate=0.2 * np.sin(np.pi * motion.time))
    model, effect = aircraft_model("navajo"), EFFECTS["roll_damping"]
    overlay = effect.overlay(effect.complete({"change": 0.4}), model.baseline)
    units = model.unit_forces(motion, properties_of_forces(model.baseline))
    without, with_it = (
        answer(lambda m, o=each: model.react(m, o, False), motion) for each in (Overlay(), overlay)
    )
    damped = REACTION_NAMES.index("roll_acceleration")
    change = (with_it - without)[:, damped]
    assert np.abs(change).max() > 0.1  # rad/s²
    added = added_forces(overlay, units)[:, damped]
    assert np.allclose(added, change, rtol=0.0, atol=1e-3 * np.abs(change).max())


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("control_effectiveness", "elevator_change"),
        ("flap_not_up", "extension"),
        ("mass", "mass_kg"),
    ],
)
def test_forces_that_are_not_plain_additions_stay_on_the_force_meter(name: str, size: str) -> None:
    model, effect = aircraft_model("navajo"), EFFECTS[name]
    assert not adds_forces(effect.overlay(effect.complete({size: 0.1}), model.baseline))


def test_expression_has_the_values_that_its_operations_say() -> None:
    x = np.array([0.5, 2.0])
    nested = operation("max", 0.0, operation("difference", operation("sqrt", "a/x"), 1.0))
    assert properties_in(nested) == {"a/x"}
    assert evaluate(nested, {"a/x": x}) == pytest.approx([0.0, np.sqrt(2.0) - 1.0])
    share = quotient(total(1.0, product(2.0, "a/x")), "b")
    assert evaluate(share, {"a/x": x, "b": 4.0}) == pytest.approx([0.5, 1.25])
    with pytest.raises(KeyError):
        evaluate("<tan><value>1.0</value></tan>", {})


@pytest.mark.parametrize(("name", "column"), [("belly_pod", 0), ("flap_not_up", 2)])
def test_held_engines_fall_out_of_the_difference(sensed, name: str, column: int) -> None:
    log = sensed(das="50/50")
    track = track_of(log.select(log.time < log.time[0] + 25.0))
    motion = motion_of(track, np.arange(0, len(track.time), 50))
    model, effect = aircraft_model("navajo"), EFFECTS[name]
    overlay = effect.overlay(effect.typical(), model.baseline)
    changes = [
        answer(lambda m, run=run: model.react(m, overlay, run), motion)
        - answer(lambda m, run=run: model.react(m, Overlay(), run), motion)
        for run in (True, False)
    ]
    running, held = (change[:, column] for change in changes)
    assert np.abs(running).max() > 0.01
    assert np.allclose(held, running, rtol=0.02, atol=0.01 * np.abs(running).max())
