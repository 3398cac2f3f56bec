"""A flight as a whole: reproducible, consistent, flown by a pilot, at another rate, or refused with
a reason.
"""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from tests.simulation.plant_record import digest
from tests.simulation.rates import corrections, differences, exact

from pitotbench import BadInputError, Case, UnknownNameError, air, fly
from pitotbench.records.case import PILOTS as CASE_PILOTS
from pitotbench.records.case import Wind
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.pilot import PILOTS
from pitotbench.simulation.properties import CHANNELS
from pitotbench.timeline import interval
from pitotbench.units import FOOT, KNOT, STANDARD_GRAVITY

SHORT = Case(maneuver="race_track", card={"dwell_s": 5.0, "speeds_kt": [140.0]}, turbulence="light")


@pytest.fixture(scope="module")
def short():
    return fly(SHORT)


def test_one_case_is_one_flight_bit_for_bit(short):
    first, second = short, fly(SHORT)
    assert digest(first) == digest(second)
    assert (first.segment == second.segment).all()
    assert digest(fly(replace(SHORT, truth_seed=2))) != digest(first)
    assert digest(fly(replace(SHORT, sensor_seed=2))) == digest(first)


def test_another_process_flies_the_same(short):
    script = (
        "import hashlib\n"
        "from pitotbench.records.case import Case\n"
        "from pitotbench.simulation.sortie import fly\n"
        f"flight = fly(Case(maneuver='race_track', card={dict(SHORT.card)!r}, "
        "turbulence='light'))\n"
        "rows = b''.join(flight[name].tobytes() for name in sorted(flight.channels))\n"
        "print(hashlib.sha256(rows).hexdigest())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == [digest(short)]  # and JSBSim's banner stays silent


@pytest.mark.parametrize("name", MANEUVERS)
def test_impact_pressure_reproduces_calibrated_airspeed(name, light_flights):
    flight = light_flights[name]
    speed = air.calibrated_airspeed(flight["total_pressure"] - flight["static_pressure"])
    assert np.abs(speed - flight["calibrated_airspeed"]).max() < 0.002 * KNOT


@pytest.mark.parametrize("name", MANEUVERS)
def test_wind_triangle_closes(name, light_flights):
    flight = light_flights[name]
    through_air = [
        flight[f"velocity_{axis}"] - flight[f"wind_{axis}"] for axis in ("north", "east", "down")
    ]
    speed = np.sqrt(sum(component**2 for component in through_air))
    assert np.abs(speed - flight["true_airspeed"]).max() < 1e-6
    q_c = flight["total_pressure"] - flight["static_pressure"]
    by_air = air.true_airspeed(q_c, flight["static_pressure"], flight["air_temperature"])
    assert np.abs(by_air - flight["true_airspeed"]).max() < 0.002 * KNOT


def test_accelerometer_agrees_with_the_velocity_it_integrates_to(light_flights):
    """In the middle of each interval, gravity and the turning earth aside (0.02 m/s²)."""
    flight = light_flights["step_decrease"]
    x, y, z = (flight[f"specific_force_{axis}"] for axis in "xyz")
    roll, pitch = flight["roll"], flight["pitch"]
    down = -x * np.sin(pitch) + (y * np.sin(roll) + z * np.cos(roll)) * np.cos(pitch)
    inside = np.flatnonzero(np.diff(flight["time"], n=2) < 1e-6) + 1
    rate = (flight["velocity_down"][inside + 1] - flight["velocity_down"][inside - 1]) / 0.02
    assert np.abs(np.mean(rate - down[inside]) - STANDARD_GRAVITY) < 0.02
    assert np.std(rate - down[inside]) < 0.02
    assert np.std(rate) > 0.05


def test_wind_is_what_the_case_says(smooth_flights):
    flight = smooth_flights["step_decrease"]
    wind = flight.case.wind
    assert np.allclose(flight["wind_north"], -wind.speed * np.cos(wind.from_direction), atol=1e-9)
    assert np.allclose(flight["wind_east"], -wind.speed * np.sin(wind.from_direction), atol=1e-9)


def test_every_channel_is_there_finite_and_read_only(smooth_flights):
    flight = smooth_flights["rapid_decel"]
    assert set(flight.channels) == {line.name for line in CHANNELS}
    assert all(np.isfinite(array).all() for array in flight.channels.values())
    assert not flight["time"].flags.writeable
    assert (np.diff(flight["time"]) > 0).all()


def test_a_hot_day_is_hot_and_a_strong_wind_is_flown():
    case = replace(
        SHORT, temperature_offset=15.0, turbulence="none", wind=Wind(40 * KNOT, 2.0, 1.0)
    )
    flight = fly(case)
    hot = float(air.standard_temperature(6000 * FOOT)) + 15.0
    assert flight["air_temperature"].mean() == pytest.approx(hot, abs=0.5)
    assert flight["wind_down"].mean() == pytest.approx(-1.0)
    assert flight.on_condition.any()


def test_progress_names_each_segment():
    heard: list[str] = []
    fly(replace(SHORT, turbulence="none"), progress=lambda seconds, label: heard.append(label))
    assert heard[:3] == ["set-up 140 kt 000°", "leg 140 kt 000°", "turn 140 kt 180°"]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"card": {"speeds_kt": [400.0]}}, "not reached|departed"),
        ({"card": {"speeds_kt": [40.0]}}, "not reached|departed"),
        (
            {"card": {"speeds_kt": [160.0, 300.0], "dwell_s": 5.0}},
            "300 KCAS in level flight was not reached",
        ),
        ({"altitude": 60000 * FOOT}, ""),
    ],
)
def test_an_impossible_speed_or_height_is_refused_in_its_set_up(changes, says):
    with pytest.raises(SimulationError, match=says or None):
        fly(replace(SHORT, turbulence="none", **changes))


def test_the_flight_does_not_depend_on_the_channels_that_are_recorded(short):
    whole, part = short, fly(SHORT, channels=("total_pressure", "specific_force_z"))
    assert set(part.channels) == {"time", "mass", "total_pressure", "specific_force_z"}
    for name, values in part.channels.items():
        np.testing.assert_array_equal(values, whole[name])
    np.testing.assert_array_equal(part.on_condition, whole.on_condition)
    with pytest.raises(UnknownNameError, match="total_pressure"):
        fly(SHORT, channels=("total_presure",))


LEGS = Case(maneuver="race_track", card={"dwell_s": 60.0, "speeds_kt": [140.0]}, turbulence="none")


def wander(flight, name):
    """Standard deviation of a channel on the legs."""
    legs = np.char.startswith(flight.segment, "leg")
    return float(np.std(flight[name][legs]))


def test_height_and_speed_wander_more_the_busier_the_pilot():
    assert tuple(PILOTS) == CASE_PILOTS
    flights = {pilot: fly(replace(LEGS, pilot=pilot)) for pilot in PILOTS}
    height = {pilot: wander(flight, "altitude") / FOOT for pilot, flight in flights.items()}
    speed = {
        pilot: wander(flight, "calibrated_airspeed") / KNOT for pilot, flight in flights.items()
    }
    assert height["none"] < height["good"] < height["busy"] < 40.0
    assert speed["none"] < speed["good"] < speed["busy"] < 2.0


@pytest.mark.parametrize("maneuver", ["step_decrease", "circle"])
def test_a_good_pilot_keeps_the_tolerances_most_of_the_time(maneuver):
    flight = fly(Case(maneuver=maneuver, pilot="good", turbulence="none"))
    judged = np.char.startswith(flight.segment, maneuver.split("_")[0] + " ")
    assert flight.on_condition[judged].mean() > 0.85


def test_a_pilot_is_drawn_from_the_truth_seed():
    busy = replace(LEGS, pilot="busy", card={"dwell_s": 10.0, "speeds_kt": [140.0]})
    one, again, other = fly(busy), fly(busy), fly(replace(busy, truth_seed=2))
    assert (one["altitude"] == again["altitude"]).all()
    assert len(other) != len(one) or (one["altitude"] != other["altitude"]).any()


SMOOTH = Case(maneuver="rapid_decel", turbulence="none")


@pytest.mark.parametrize(("rate", "name"), [(50.0, "50/50"), (40.0, "20/1")])
def test_the_slower_flight_answers_the_same(rate, name, smooth_flights):
    usual, slow = smooth_flights["rapid_decel"], fly(replace(SMOOTH, integration_rate=rate))
    assert interval(slow["time"]) == pytest.approx(1.0 / rate)
    assert list(dict.fromkeys(slow.segment)) == list(dict.fromkeys(usual.segment))
    airspeed, altitude, bank = differences(usual, slow)
    assert airspeed < 0.2  # kt, ft and degrees: a tenth of the card's tolerances at most
    assert altitude < 0.2
    assert bank < 0.1
    system = data_system(name)
    change = corrections(slow, exact(system))[0] - corrections(usual, exact(system))[0]
    assert np.abs(change / corrections(usual, system)[1]).max() < 0.1


def test_a_rate_that_cannot_be_is_refused():
    with pytest.raises(
        BadInputError, match=r"a flight is integrated at 40, .* 100 Hz, not at 30 Hz"
    ):
        fly(replace(SMOOTH, integration_rate=30.0))
    short = {"maneuver": "race_track", "card": {"dwell_s": 2.0, "speeds_kt": [140.0]}}
    flight = fly(replace(SMOOTH, integration_rate=50.0, **short))
    assert len(record(flight, data_system("25/5"), 1)) > 100
    with pytest.raises(
        BadInputError, match=r"data system 20/1: 50 Hz is not a whole multiple of the 20 Hz"
    ):
        record(flight, data_system("20/1"), 1)
