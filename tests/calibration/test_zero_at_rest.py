"""The zero of the gauge, read while the airplane stands before and after its flight."""

import numpy as np
import pandas as pd
import pytest

from pitotbench import calibrate
from pitotbench.airdata import rests_of
from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.records.log import AT_REST

HZ, REST = 10, 60.0


def columns(zero, wind=0.0, seed=5, rest=REST):
    """A flight of four legs at 55 to 75 kt, with `rest` seconds on the ground before and after it;
    `wind` [m/s] blows into the tube there."""
    dice = np.random.default_rng(seed)
    time = np.arange(0.0, 480.0 + 2.0 * rest, 1.0 / HZ)
    flying = (time >= rest) & (time < rest + 480.0)
    since = np.where(flying, time - rest, 0.0)
    heading = np.radians(90.0) * (since // 120.0)
    speed = 33.0 + 5.0 * np.sin(2.0 * np.pi * since / 60.0)
    density, pressure = 1.225, 101325.0
    impact = np.where(flying, 0.5 * density * speed**2, 0.0)
    slow = np.interp(time, time[:: 5 * HZ], dice.standard_normal(len(time[:: 5 * HZ])))
    gusty = wind * (1.0 + 0.22 * slow)
    impact += np.where(flying, 0.0, 0.5 * density * gusty**2)
    north = np.where(flying, speed * np.cos(heading) + 3.0, 0.0)
    east = np.where(flying, speed * np.sin(heading) - 2.0, 0.0)
    noise = dice.standard_normal((4, len(time)))
    return {
        "time_s": time,
        "impact_pressure_pa": impact + zero + 3.0 * noise[0],
        "static_pressure_pa": pressure + 3.0 * noise[1],
        "air_temperature_k": np.full(len(time), 288.15),
        "velocity_north_mps": north + 0.05 * noise[2],
        "velocity_east_mps": east + 0.05 * noise[3],
    }


@pytest.fixture
def read(tmp_path):
    def reads(made):
        pd.DataFrame(made).to_csv(tmp_path / "log.csv", index=False)
        return read_log(tmp_path / "log.csv")

    return reads


@pytest.mark.parametrize("zero", [-25.0, 30.0])
def test_the_zero_is_found_and_taken_out(zero, read):
    found = calibrate(read(columns(zero)))
    offset = found.impact_pressure_zero
    assert abs(offset.value - zero) < offset.two_sigma < 8.0
    assert [a.source for a in found.assumptions if a.name == offset.name] == ["read at rest"]
    assert np.all(np.abs(found.curve.normalized_pressure_error) < 0.02)


def test_a_known_zero_is_no_factor(read):
    """A tenth of the pressure in flight: without it the factor is 1."""
    scale = calibrate(read(columns(80.0))).scale
    assert abs(scale.factor - 1.0) < scale.two_sigma + 0.005


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_log_that_is_written_again_keeps_the_zero(suffix, read, tmp_path):
    """Its rows at rest are negative, and dropped when it is read first."""
    log = read(columns(-25.0))
    assert np.hypot(log.velocity_north, log.velocity_east)[0] > 1.0
    again = read_log(write_log(log, tmp_path / f"again.{suffix}"))
    first, second = (calibrate(each).impact_pressure_zero for each in (log, again))
    assert abs(first.value + 25.0) < first.two_sigma
    assert second == first


@pytest.mark.parametrize(
    "entry",
    ["5", "[{}]", "[{reading_pa = 1e30, scatter_pa = 1.0, gusts_pa = 1.0, noise_pa = 1.0}]"],
)
def test_a_zero_that_no_gauge_has_is_read_from_the_rows(entry, read, tmp_path):
    log = read(columns(-25.0, rest=0.0))
    path = write_log(log, tmp_path / "again.csv")
    path.write_text(f"# at_rest = {entry}\n{path.read_text('utf-8')}", "utf-8")
    assert AT_REST not in read_log(path).header


def test_without_rest_no_zero_is_assumed(read):
    assert calibrate(read(columns(0.0, rest=0.0))).impact_pressure_zero is None


def test_a_wind_at_rest_widens_the_zero(read):
    calm, windy = (calibrate(read(columns(0.0, wind))).impact_pressure_zero for wind in (0.0, 6.0))
    assert windy.two_sigma > 1.5 * calm.two_sigma
    assert abs(windy.value) < windy.two_sigma


def test_a_display_at_zero_shows_none(read):
    made = columns(0.0)
    still = np.hypot(made["velocity_north_mps"], made["velocity_east_mps"]) < 1.0
    made["impact_pressure_pa"][still] = 0.0
    assert calibrate(read(made)).impact_pressure_zero is None


def test_the_mean_of_white_noise_is_known_by_its_root():
    made = columns(12.0)
    channels = {
        "time": made["time_s"],
        "impact_pressure": made["impact_pressure_pa"],
        "velocity_north": made["velocity_north_mps"],
        "velocity_east": made["velocity_east_mps"],
    }
    before, after = rests_of(channels)
    for rest in (before, after):
        assert rest.noise_pa == pytest.approx(3.0 / np.sqrt(REST * HZ), rel=0.2)
        assert abs(rest.reading_pa - 12.0) < 6.0 * rest.noise_pa
        assert rest.gusts_pa < 0.5
