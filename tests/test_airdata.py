"""The regression of a reading on the velocity over the ground gives back what it was made of."""

import numpy as np
import pytest

from pitotbench import air, read_log
from pitotbench.airdata import follow, mean_wind, part_of

HEIGHT = 3000.0  # m
WIND = np.array([9.0, -14.0])  # m/s toward north and east


def channels(speed, factor=1.0, zero=0.0):
    """Circles at changing speeds through still air of a standard day, 20 minutes of a row a second;
    the reading is a factor times the impact pressure, plus a zero.
    """
    time = np.arange(0.0, 1200.0)
    airspeed = speed * (1.0 + 0.2 * np.sin(time / 97.0))
    heading = 2.0 * np.pi * time / 120.0
    static = np.full_like(time, air.standard_pressure(HEIGHT))
    mach = airspeed / air.sound_speed(air.standard_temperature(HEIGHT))
    return {
        "time": time,
        "impact_pressure": factor * air.impact_pressure_from_mach(mach, static) + zero,
        "static_pressure": static,
        "velocity_north": airspeed * np.cos(heading) + WIND[0],
        "velocity_east": airspeed * np.sin(heading) + WIND[1],
    }


@pytest.mark.parametrize("speed", [18.0, 60.0, 220.0])
@pytest.mark.parametrize("factor", [0.25, 1.0, 3.8])
def test_factor_zero_and_wind_are_found(speed, factor):
    """From a drone in a wind as fast as itself to a jet, and in any unit."""
    log = channels(speed, factor, zero=20.0)
    fit = follow(part_of(log), log["impact_pressure"])
    assert fit.values[0] == pytest.approx(factor, rel=0.02)
    assert np.mean(fit.wind, axis=1) == pytest.approx(WIND, abs=0.3)
    assert fit.values[1] == pytest.approx(20.0, abs=0.02 * np.median(log["impact_pressure"]))


def test_faulty_rows_and_rows_at_rest_count_for_nothing():
    log = channels(60.0)
    log["velocity_north"][100:140] += 300.0
    log["impact_pressure"][700:720] = np.nan
    for name in ("velocity_north", "velocity_east"):
        log[name][:5] = 0.0
    assert mean_wind(log) == pytest.approx(WIND, abs=0.3)


def test_one_heading_tells_no_large_wind():
    """A wind and a factor look alike there: the wind keeps to what is usual."""
    log = channels(60.0, factor=1.5)
    rows = slice(0, 40)
    straight = {name: values[rows].copy() for name, values in log.items()}
    airspeed = np.hypot(straight["velocity_north"] - WIND[0], straight["velocity_east"] - WIND[1])
    straight["velocity_north"], straight["velocity_east"] = airspeed, np.zeros(40)
    assert np.hypot(*mean_wind(straight)) < 30.0
    assert np.array_equal(mean_wind({n: v[:10] for n, v in straight.items()}), [0.0, 0.0])


def test_a_wind_that_turns_within_half_an_hour_is_no_mistake_of_the_velocities(tmp_path):
    """With one wind for the whole log, a component of the velocity seemed to be feet a minute."""
    log = channels(18.0)
    turn = np.pi * log["time"] / log["time"][-1]
    for name, of_wind, still in (
        ("velocity_north", np.cos(turn), WIND[0]),
        ("velocity_east", np.sin(turn), WIND[1]),
    ):
        log[name] += 9.0 * of_wind - still
    names = [f"{name}_{unit}" for name, unit in _UNITS.items()]
    rows = np.stack([log[name] for name in _UNITS], axis=1)
    path = tmp_path / "log.csv"
    np.savetxt(path, rows, "%.4f", ",", header=",".join(names), comments="")
    assert not any("velocity" in each for each in read_log(path).cautions)


_UNITS = {
    "time": "s",
    "impact_pressure": "pa",
    "static_pressure": "pa",
    "velocity_north": "mps",
    "velocity_east": "mps",
}
