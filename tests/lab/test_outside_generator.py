"""The outside generator obeys the laws that it claims, by formulas written here once more."""

import ast
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import gamma, kv

from pitotlab.outside import moving_air
from pitotlab.outside import physics as physics
from pitotlab.outside.generator import generate, write_csv
from pitotlab.outside.motion import MANEUVERS, NOISE, RATE
from pitotlab.outside.moving_air import CELLS
from pitotlab.outside.physics import FOOT, KNOT

FOLDER = Path(physics.__file__).parent
JUDGES = ("judge.py",)
JUDGE_MAY_IMPORT = {
    "pitotbench.calibration": {"calibrate"},
    "pitotbench.calibration.options": {"CalibrationOptions"},
    "pitotbench.logbook.reading": {"read_log"},
    "pitotbench.records": {"BadInputError", "NoAnswerError"},
}


@pytest.fixture(scope="module")
def flights():
    """A flight of each cell, all of one seed."""
    return {n: generate(cell, cell.maneuvers[n == "jet"], 4) for n, cell in CELLS.items()}


# The mean impact pressure, and static pressure, velocity north, height and temperature of the last
# row, of the rapid deceleration with seed 4: what the cells were when their scores were published
PUBLISHED = {
    "base": (2868.16761, 81724.3506, -43.9027862, 1823.83532, 267.81303),
    "calm": (2859.17442, 81724.2076, -43.9027862, 1823.83532, 267.790883),
    "jet": (14697.1156, 46087.5516, -113.303454, 6098.77462, 248.294483),
    "probe_2k": (2868.16761, 81724.3506, -43.9027862, 1823.83532, 269.81303),
    "probe_5k": (2868.16761, 81724.3506, -43.9027862, 1823.83532, 272.81303),
    "length_100": (2864.34527, 81724.3266, -43.9027862, 1823.83532, 267.809295),
    "length_2000": (2883.12772, 81724.5207, -43.9027862, 1823.83532, 267.839792),
    "von_karman": (2875.21112, 81724.6011, -43.9027862, 1823.83532, 267.852606),
    "wave": (2868.16705, 81724.3491, -43.6388593, 1823.83532, 267.812804),
    "front": (2868.16786, 81724.3924, -46.5138844, 1823.83532, 267.81303),
    "linear": (2868.1679, 81724.3768, -45.2083353, 1823.83532, 267.81303),
    "steps": (2868.24777, 81724.3506, -43.9027862, 1823.83532, 267.81303),
    "calm_steps": (2858.87023, 81724.2076, -43.9027862, 1823.83532, 267.790883),
    "two_slope": (2868.10227, 81724.4549, -43.9088928, 1823.83532, 267.813449),
    "bursts": (2866.32795, 81724.3506, -43.9027862, 1823.83532, 267.81303),
    "thermals": (2865.08957, 81724.2954, -43.9027862, 1823.83532, 267.804447),
    "carried": (2865.15112, 81724.1847, -43.3457544, 1823.83532, 267.788165),
    "late": (2868.16761, 81724.3506, -43.9058343, 1823.59709, 267.81303),
    "uav": (332.317792, 100808.381, -9.7962884, 147.435318, 277.218117),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_the_flights_of_a_cell_are_those_whose_scores_were_published(name):
    columns = generate(CELLS[name], "rapid_decel", 4).columns
    last = ("static_pressure_pa", "velocity_north_mps", "altitude_m", "total_temperature_k")
    found = [np.mean(columns["impact_pressure_pa"]), *(columns[channel][-1] for channel in last)]
    np.testing.assert_allclose(found, PUBLISHED[name], rtol=1e-7)


def _imports(path):
    """(module, names) of every import of a file; names is empty for `import module`."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, set()) for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name}: a relative import hides where it leads"
            yield node.module, {alias.name for alias in node.names}


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.name)
def test_nothing_but_the_judges_imports_the_product_and_they_only_its_entry_points(path):
    allowed = {"numpy", "scipy"} | set(sys.stdlib_module_names) - {"importlib", "runpy"}
    for module, names in _imports(path):
        root = module.split(".")[0]
        if path.name in JUDGES and root == "pitotbench":
            assert names, f"import {module} gives the judge the whole module"
            assert names <= JUDGE_MAY_IMPORT.get(module, set()), (module, names)
            continue
        reached = {module, *(f"{module}.{name}" for name in names)}
        own = all(name.startswith(("pitotlab.outside", "pitotlab.sets")) for name in reached)
        assert root in allowed or own, (path.name, module)
        if path.name not in JUDGES:
            judges = {f"pitotlab.outside.{name.removesuffix('.py')}" for name in JUDGES}
            assert not judges & reached, f"{path.name} reaches the product through a judge"


@pytest.mark.parametrize("name", CELLS)
def test_the_wind_triangle_closes(flights, name):
    flight = flights[name]
    state = flight.state
    through_air = state.ground_velocity - flight.sky.wind - state.slow_wind - state.gust
    ratio = 1.0 + state.impact / state.pressure  # total over static pressure
    # J/kg, the rise to a stop.
    enthalpy = 1.4 / 0.4 * 287.053 * state.temperature * (ratio ** (0.4 / 1.4) - 1.0)
    speed = np.linalg.norm(through_air, axis=1)
    np.testing.assert_allclose(speed, state.true_airspeed, rtol=1e-12)
    np.testing.assert_allclose(np.sqrt(2.0 * enthalpy), state.true_airspeed, rtol=1e-9)


def test_the_pressure_is_the_integral_of_weight_over_the_warmth_of_the_day():
    day = physics.Day(warmer=11.0, sea_level_pressure=100300.0)
    heights = np.array([0.0, 500.0, 1828.8, 6096.0])

    def weight(height, pressure):
        return -9.80665 * pressure / (287.053 * (288.15 + 11.0 - 0.0065 * height))

    found = solve_ivp(weight, (0.0, 6096.0), [100300.0], t_eval=heights, rtol=1e-11, atol=1e-6).y[0]
    np.testing.assert_allclose(day.pressure(heights), found, rtol=1e-9)


@pytest.mark.parametrize("name", CELLS)
def test_the_total_pressure_is_right_and_the_static_source_takes_its_error_from_the_impact_pressure(
    flights, name
):
    flight = flights[name]
    state, columns = flight.state, flight.columns
    source = flight.error.share(state.indicated_impact) * state.impact  # Δp_s, by its definition
    np.testing.assert_allclose(state.indicated_impact, state.impact - source, rtol=1e-11)
    excess = columns["static_pressure_pa"] - (state.pressure + source)
    assert abs(np.mean(excess)) < 5.0 * NOISE.static / np.sqrt(len(excess))
    if flight.cell.airspeed_step == 0.0:
        total = columns["static_pressure_pa"] + columns["impact_pressure_pa"]
        error, noise = total - state.pressure - state.impact, np.hypot(NOISE.static, NOISE.impact)
        assert abs(np.mean(error)) < 5.0 * noise / np.sqrt(len(error))
        assert np.std(error) == pytest.approx(noise, rel=0.05)


def test_the_wind_has_low_pressure_on_its_left_at_0_8_pascals_a_kilometer_for_15_kt(flights):
    north_wind = np.array([15.0 * KNOT, 0.0, 0.0])  # toward north: its left is west
    sky = replace(flights["base"].sky, wind=north_wind)
    here, west = sky.pressure(np.array(1828.8), np.zeros(2), np.array([0.0, -1000.0]))
    north = sky.pressure(np.array(1828.8), np.array(1000.0), np.array(0.0))
    assert 0.7 < here - west < 0.9
    assert north == pytest.approx(here, abs=1e-9)


@pytest.mark.parametrize("name", CELLS)
def test_no_gust_moves_the_height(flights, name):
    state, still = flights[name].state, replace(CELLS[name], gust_sigma=0.0, thermals=False)
    calm = generate(still, flights[name].maneuver, 4)
    np.testing.assert_array_equal(state.height, calm.state.height)
    climbed = state.height[0] - np.cumsum(state.ground_velocity[:, 2]) / RATE
    assert np.max(np.abs(climbed - state.height)) < 0.1  # m: the error of the sum
    assert np.std(state.height) < 12.0


MINUTES = {"rapid_decel": 5, "step_decrease": 6, "circle": 6, "race_track": 15, "four_leg": 21}


@pytest.mark.parametrize("maneuver", MINUTES)
def test_a_maneuver_lasts_as_long_as_the_paper_says_and_ramps_by_a_knot_a_second(maneuver):
    state = generate(CELLS["calm"], maneuver, 4).state
    assert state.time[-1] / 60.0 == pytest.approx(MINUTES[maneuver], rel=0.05)
    airspeed = physics.calibrated_airspeed(state.indicated_impact) / KNOT
    assert np.quantile(airspeed, [0.01, 0.99]) == pytest.approx([100.0, 160.0], abs=1.5)
    over_five_seconds = np.abs(airspeed[100:] - airspeed[:-100]) / 5.0
    assert 0.6 < np.max(over_five_seconds) < 1.25  # the rest is the pilot's wandering


@pytest.mark.parametrize(
    ("maneuver", "turned"), [("rapid_decel", 180), ("step_decrease", 180), ("race_track", 1260)]
)
def test_a_maneuver_turns_as_far_as_its_legs_ask(maneuver, turned):
    assert sum(leg.turn for leg in MANEUVERS[maneuver]) == turned
    heading = generate(CELLS["calm"], maneuver, 4).state.heading
    found = np.degrees(abs(heading[-1] - heading[0]))
    assert found == pytest.approx(turned, abs=4.0 * turned / 180.0)


def test_the_true_curve_joins_what_was_indicated_with_what_was_true(flights):
    for name in ("base", "jet", "two_slope"):
        state = flights[name].state
        indicated = physics.calibrated_airspeed(state.indicated_impact)
        found, true = indicated + flights[name].correction(indicated), state.impact
        np.testing.assert_allclose(found, physics.calibrated_airspeed(true), rtol=1e-10)


def test_the_position_error_in_feet_is_the_source_error_over_the_weight_of_the_air(flights):
    flight = flights["base"]
    pressure = float(flight.sky.day.pressure(np.array(flight.cell.height)))
    shown = np.arange(100.0, 161.0, 5.0) * KNOT
    source = np.subtract(*map(physics.impact_pressure, (shown + flight.correction(shown), shown)))
    standard = 288.15 * (pressure / 101325.0) ** 0.190263  # K, at that pressure
    feet = source * 287.053 * standard / (pressure * 9.80665) / FOOT
    assert np.all(flight.position_error(shown) > 0.0)
    np.testing.assert_allclose(flight.position_error(shown), feet, rtol=0.01)


def test_one_seed_draws_one_day_and_one_source_in_all_cells(flights):
    base = flights["base"]
    for name in ("calm", "front", "probe_5k", "von_karman", "carried", "late"):
        assert flights[name].sky.day == base.sky.day
        assert flights[name].error == base.error
    assert generate(CELLS["base"], "circle", 5).error != base.error


def test_ou_gusts_have_their_size_and_forget_within_their_length():
    distance = np.arange(0.0, 400_000.0, 4.0)
    gust = moving_air.ou_gusts(distance, 0.5, 300.0, np.random.default_rng(3))
    assert np.std(gust, axis=0) == pytest.approx([0.5] * 3, rel=0.1)
    apart = 75  # rows: 300 m
    product = np.mean(gust[apart:] * gust[:-apart]) / np.mean(gust**2)
    assert product == pytest.approx(np.exp(-1.0), abs=0.06)


def test_von_karman_gusts_have_their_size_and_the_closed_correlation_along_the_path():
    distance = np.arange(0.0, 400_000.0, 4.0)
    path = distance, np.zeros_like(distance)
    gust = moving_air.von_karman_gusts(*path, 0.5, 533.0, np.random.default_rng(3))
    assert np.std(gust, axis=0) == pytest.approx([0.5] * 3, rel=0.1)
    for apart in (20, 100, 300):
        found = np.mean(gust[apart:, 0] * gust[:-apart, 0]) / np.mean(gust[:, 0] ** 2)
        z = 4.0 * apart / (1.339 * 533.0)
        known = 2.0 ** (2.0 / 3.0) / gamma(1.0 / 3.0) * z ** (1.0 / 3.0) * kv(1.0 / 3.0, z)
        assert found == pytest.approx(known, abs=0.08)


def test_the_slow_winds_are_as_large_as_their_cells_say():
    time, dice = np.arange(0.0, 600.05, 0.05), np.random.default_rng(1)
    wave, jump, change = (
        slow(time, dice)
        for slow in (moving_air.mountain_wave, moving_air.front, moving_air.steady_change)
    )
    assert np.max(np.hypot(wave[:, 0], wave[:, 1])) == pytest.approx(1.0, abs=1e-3)
    assert np.max(np.abs(wave[:, 2])) == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(wave[:6001], wave[6000:], atol=1e-9)  # 300 s
    for slow in (jump, change):
        assert np.linalg.norm(slow[-1] - slow[0]) == pytest.approx(3.0, abs=1e-9)
    moving = np.linalg.norm(np.diff(jump, axis=0), axis=1) > 1e-9
    assert np.sum(moving) / RATE == pytest.approx(20.0, abs=0.2)


def test_a_late_receiver_reports_what_was_half_a_second_ago(flights):
    flight = generate(CELLS["late"], "circle", 4)
    rows, late = flight.state.ground_velocity[:, 0], round(0.5 * RATE)
    error = flight.columns["velocity_north_mps"][late:] - rows[:-late]
    assert np.std(error) == pytest.approx(NOISE.velocity, rel=0.05)


def test_rows_between_two_fixes_repeat_the_first():
    columns = generate(CELLS["base"], "circle", 5).columns  # an odd seed: 1 Hz
    fresh = columns["gps_fresh"] == 1.0
    assert np.all(np.flatnonzero(fresh) % 20 == 0)
    for name in ("velocity_north_mps", "velocity_east_mps", "velocity_down_mps", "altitude_m"):
        assert np.all(np.diff(columns[name])[~fresh[1:]] == 0.0)
        assert np.all(np.diff(columns[name])[fresh[1:]] != 0.0)


def test_an_airspeed_in_steps_reads_whole_knots(flights):
    knots = physics.calibrated_airspeed(flights["steps"].columns["impact_pressure_pa"]) / KNOT
    np.testing.assert_allclose(knots, np.round(knots), atol=1e-6)


def test_a_probe_is_off_by_what_its_cell_says(flights):
    base = flights["base"].columns["total_temperature_k"]
    for name, offset in (("probe_2k", 2.0), ("probe_5k", 5.0)):
        off = np.abs(flights[name].columns["total_temperature_k"] - base)
        np.testing.assert_allclose(off, offset, atol=1e-9)


def test_the_file_holds_the_columns_and_no_truth(flights, tmp_path):
    write_csv(flights["base"].columns, tmp_path / "log.csv")
    names = (tmp_path / "log.csv").read_text(encoding="utf-8").split("\n", 1)[0].split(",")
    assert names == list(flights["base"].columns)
    rows = np.loadtxt(tmp_path / "log.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(rows[:, 2], flights["base"].columns["static_pressure_pa"], rtol=1e-8)
