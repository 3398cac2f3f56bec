"""A ground velocity from positions: an arc in a turn, whatever the wind and the time between fixes."""

import numpy as np
import pytest

from pitotbench import BadInputError, CalibrationOptions, air
from pitotbench.calibration import calibrate
from pitotbench.logbook.reading import read_log
from pitotbench.units import DEGREE, KNOT

WIND = np.array([5.0, -6.0])  # m/s toward north and east
HEIGHT, FINE = 1500.0, 0.05  # m; s, of the steps of the path
METERS_A_DEGREE = 110_903.6, 93_504.7  # of latitude and longitude at -33° on WGS 84


def _flown(rate: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Calibrated airspeed [m/s] and velocity over the ground (2, n) [m/s]: at each of four speeds
    circles and, slower in the turn than straight, a leg; and the time [s].
    """
    speed, turn = [], []
    for straight in (60.0, 70.0, 80.0, 65.0):
        circling, along = round(90.0 / FINE), round(60.0 / FINE)
        speed += [np.full(circling, 46.0 * KNOT), np.full(along, straight * KNOT)]
        turn += [np.full(circling, rate), np.zeros(along)]
    heading = np.cumsum(np.concatenate(turn)) * FINE
    change = round(4.0 / FINE)  # a glider takes some seconds to another speed
    speed = np.convolve(
        np.pad(np.concatenate(speed), change, "edge"), np.full(change, 1.0 / change)
    )
    speed = speed[change : change + len(heading)]
    # A pilot's hand and a gust: no reading stands still, and the air is felt by the airspeed alone.
    time = np.arange(len(speed)) * FINE
    speed += 0.3 * np.sin(time / 7.0)
    still = air.true_airspeed(
        air.impact_pressure(speed),
        air.standard_pressure(HEIGHT),
        air.standard_temperature(HEIGHT),
    )
    ground = still * np.stack([np.cos(heading), np.sin(heading)]) + WIND[:, None]
    return speed + 0.2 * np.sin(time * 0.83), ground, time


def _written(folder, apart: float, rate: float = 16.0 * DEGREE):
    """The log of a recorder with fixes `apart` [s], and the velocity over the ground there."""
    speed, ground, time = _flown(rate)
    place = np.cumsum(0.5 * FINE * (ground + np.roll(ground, 1, axis=1)), axis=1)
    every = round(apart / FINE)
    rows = zip(
        time[::every],
        speed[::every],
        -33.0 + place[0][::every] / METERS_A_DEGREE[0],
        146.0 + place[1][::every] / METERS_A_DEGREE[1],
        strict=True,
    )
    lines = [
        f"{t:.2f},{v:.4f},{HEIGHT},{air.standard_temperature(HEIGHT):.3f},{n:.8f},{e:.8f}"
        for t, v, n, e in rows
    ]
    head = (
        "time_s,indicated_airspeed_mps,pressure_altitude_m,air_temperature_k,latitude_deg,"
        "longitude_deg"
    )
    path = folder / "fixes.csv"
    path.write_text("\n".join([head, *lines]))
    return path, ground[:, ::every]


@pytest.mark.parametrize("apart", [1.0, 2.0, 4.0])
def test_a_turn_between_fixes_is_an_arc_and_no_chord(apart, tmp_path):
    """At 16°/s a chord over 2, 4 and 8 s is short by 1, 5 and 20 %."""
    path, ground = _written(tmp_path, apart)
    log = read_log(path)
    assert len(log) == ground.shape[1]
    off = np.hypot(log.velocity_north - ground[0], log.velocity_east - ground[1])
    # Three fifths of the log are turns, whose chords are short by 0.3, 1.3 and 5 m/s. Only where a
    # turn begins or ends within the chord is the arc off by more.
    assert np.quantile(off, 0.8) < 0.15
    # A turn is no noise of the fixes.
    assert log.header["accuracy"]["velocity_mps"] < 0.6  # a circle of chords gave 9


@pytest.mark.parametrize("apart", [1.0, 2.0, 4.0])
def test_circles_by_fixes_are_calibrated_as_those_by_velocity_are(apart, tmp_path):
    path, _ = _written(tmp_path, apart)
    found = calibrate(read_log(path), CalibrationOptions(model="smooth", latency="checked"))
    assert np.all(np.abs(found.curve.correction) < found.curve.two_sigma)
    assert found.curve.two_sigma[0] < 0.8 * KNOT
    smoothing = next(s.estimate for s in found.shares if s.name == "receiver_smoothing_s2")
    assert smoothing.value < 0.15  # s²; a chord over 2 s is one of 0.33, over 8 s of 5.3


def test_positions_in_steps_as_long_as_the_way_between_them_give_no_velocity(tmp_path):
    path, _ = _written(tmp_path, 1.0)
    head, *rows = path.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    coarse = [[*row[:4], f"{float(row[4]):.3f}", f"{float(row[5]):.4f}"] for row in cells]
    path.write_text("\n".join([head, *(",".join(row) for row in coarse)]))
    with pytest.raises(BadInputError, match="in steps of 111 m, too coarse for a velocity"):
        read_log(path)
