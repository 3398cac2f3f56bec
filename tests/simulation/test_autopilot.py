"""What the autopilot of the Navajo promises the maneuvers, and the design of such loops on linear
models.
"""

import numpy as np
import pytest
from scipy.signal import welch
from tests.simulation.plant_record import record_channels

from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.autopilot.envelope import Trim
from pitotbench.simulation.autopilot.linear_model import Linear
from pitotbench.simulation.autopilot.loops import (
    LEAST_DAMPING,
    bank_loop,
    damping,
    pitch_loop,
    shape,
    step_response,
)
from pitotbench.simulation.plant import Air, Plant
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, STANDARD_GRAVITY, Array

ALTITUDE = 6000.0 * FOOT  # m
HEADING_HOLD, BANK_HOLD = 1.0, 2.0
DIRECT, MANIFOLD_PRESSURE_HOLD = 0.0, 2.0


def airborne(speed_kt: float, air: Air | None = None) -> Plant:
    """The aircraft level at 6,000 ft, settled for another half minute."""
    plant = Plant.load()
    plant.start(ALTITUDE, speed_kt * KNOT, air=air)
    plant.run(30.0)
    return plant


def height_error(flight: dict[str, Array]) -> float:
    """The largest departure from the height that was held [ft]."""
    return float(np.abs(flight["altitude"] - ALTITUDE).max() / FOOT)


def heading_error(flight: dict[str, Array], heading: float) -> Array:
    """Heading less the wanted one [deg], in (-180, 180]."""
    return np.asarray(np.angle(np.exp(1j * (flight["heading"] - heading))) / DEGREE)


@pytest.mark.parametrize("speed_kt", [100.0, 130.0, 160.0])
def test_steady_level_flight_is_held_and_leaves_longitudinal_acceleration_still(
    speed_kt: float,
) -> None:
    flight = record_channels(airborne(speed_kt), 60.0)
    assert np.abs(flight["calibrated_airspeed"] / KNOT - speed_kt).max() < 0.3
    assert height_error(flight) < 5.0
    assert np.abs(heading_error(flight, 0.0)).max() < 0.5
    force, mean = flight["specific_force_x"], np.ones(200) / 200.0
    assert np.std((force - np.convolve(force, mean, "same"))[201:-200]) < 1e-4 * STANDARD_GRAVITY


@pytest.mark.parametrize(("speed_kt", "bank_deg"), [(95.0, 30.0), (95.0, -30.0), (160.0, 30.0)])
def test_a_turn_of_30_degrees_of_bank_keeps_height_speed_and_coordination(
    speed_kt: float, bank_deg: float
) -> None:
    plant = airborne(speed_kt)
    plant.set("lateral_mode", BANK_HOLD)
    plant.set("bank_target", bank_deg * DEGREE)
    flight = record_channels(plant, 40.0)
    assert height_error(flight) < 20.0
    assert np.abs(flight["calibrated_airspeed"] / KNOT - speed_kt).max() < 1.0
    assert np.abs(flight["sideslip"] / DEGREE).max() < 1.5
    assert np.abs(flight["roll"] / DEGREE).max() < 33.0
    assert flight["roll"][1500:] / DEGREE == pytest.approx(bank_deg, abs=0.3)


@pytest.mark.parametrize("speed_kt", [100.0, 160.0])
def test_a_turn_at_constant_manifold_pressure_keeps_the_pressure(speed_kt: float) -> None:
    plant = airborne(speed_kt)
    pressure = plant.get("manifold_pressure_left")
    plant.set("throttle_mode", MANIFOLD_PRESSURE_HOLD)
    plant.set("manifold_pressure_target", pressure)
    plant.set("lateral_mode", BANK_HOLD)
    plant.set("bank_target", 30.0 * DEGREE)
    flight = record_channels(plant, 40.0)
    assert np.abs(flight["manifold_pressure_left"] - pressure).max() < 0.05 * INCH_OF_MERCURY
    assert height_error(flight) < 20.0


@pytest.mark.parametrize(("speed_kt", "bank_deg"), [(100.0, 30.0), (160.0, 16.0)])
def test_a_new_heading_is_captured(speed_kt: float, bank_deg: float) -> None:
    plant = airborne(speed_kt)
    plant.set("bank_limit", bank_deg * DEGREE)
    plant.set("heading_target", 90.0 * DEGREE)
    error = heading_error(record_channels(plant, 75.0), 90.0 * DEGREE)
    assert error.max() < 2.0
    assert np.abs(error[-500:]).max() < 0.5


@pytest.mark.parametrize("throttle", ["direct", "pressure"])
def test_idle_deceleration_is_level_straight_and_at_negative_thrust(throttle: str) -> None:
    plant = airborne(160.0)
    plant.set("throttle_mode", DIRECT if throttle == "direct" else MANIFOLD_PRESSURE_HOLD)
    plant.set("throttle_command", 0.0)
    plant.set("manifold_pressure_target", 9.5 * INCH_OF_MERCURY)
    flight = record_channels(plant, 40.0)
    slow = int(np.argmax(flight["calibrated_airspeed"] < 100.0 * KNOT))
    part = {name: values[:slow] for name, values in flight.items()}
    assert 25.0 < slow / 100.0 < 35.0
    assert height_error(part) < 20.0
    assert np.abs(heading_error(part, 0.0)).max() < 0.6
    assert part["thrust_left"][300:].max() < 0.0
    assert part["manifold_pressure_left"][500:] / INCH_OF_MERCURY == pytest.approx(9.5, abs=0.7)


@pytest.mark.parametrize(("first_kt", "second_kt"), [(160, 140), (120, 100), (140, 160)])
@pytest.mark.parametrize("rate_kt", [1.0, 2.0])
def test_a_new_speed_is_captured_without_overshoot(
    first_kt: float, second_kt: float, rate_kt: float
) -> None:
    plant = airborne(first_kt)
    plant.set("airspeed_rate_limit", rate_kt * KNOT)
    plant.set("airspeed_target", second_kt * KNOT)
    flight = record_channels(plant, 60.0)
    beyond = (flight["calibrated_airspeed"] / KNOT - second_kt) * np.sign(second_kt - first_kt)
    assert beyond.max() < (1.0 if rate_kt < 2.0 else 1.2)  # at 2 kt/s the throttles reach idle
    assert np.abs(beyond[2500:]).max() < 1.0
    assert height_error(flight) < 20.0


def test_speed_hold_takes_over_from_idle() -> None:
    plant = airborne(160.0)
    plant.set("throttle_mode", DIRECT)
    plant.set("throttle_command", 0.0)
    plant.run(25.0)
    plant.set("airspeed_target", 120.0 * KNOT)
    plant.set("throttle_mode", 1.0)
    speed = record_channels(plant, 60.0)["calibrated_airspeed"] / KNOT
    assert speed.max() < 122.0
    assert speed[4000:] == pytest.approx(120.0, abs=1.0)


def test_an_inch_of_manifold_pressure_settles_in_three_seconds() -> None:
    plant = airborne(150.0)
    plant.set("throttle_mode", MANIFOLD_PRESSURE_HOLD)
    plant.set("manifold_pressure_target", 28.0 * INCH_OF_MERCURY)
    plant.run(20.0)
    plant.set("manifold_pressure_target", 27.0 * INCH_OF_MERCURY)
    pressure = record_channels(plant, 8.0)["manifold_pressure_left"] / INCH_OF_MERCURY
    assert pressure.min() > 26.9
    assert pressure[300:] == pytest.approx(27.0, abs=0.1)
    assert pressure[50] > 27.2


def test_a_throttle_bias_stays_and_heading_is_held() -> None:
    plant = airborne(130.0)
    plant.set("throttle_bias_left", 0.02)
    flight = record_channels(plant, 40.0)
    split = flight["manifold_pressure_left"] - flight["manifold_pressure_right"]
    assert split[-1] > 1.0 * INCH_OF_MERCURY
    assert np.abs(heading_error(flight, 0.0)).max() < 1.0


@pytest.mark.parametrize("severity", [1, 2])
def test_turbulence_is_ridden_not_chased(severity: int) -> None:
    speed_kt = 130.0
    flight = record_channels(airborne(speed_kt, Air(severity=severity, seed=7)), 120.0)
    off = np.abs(flight["calibrated_airspeed"] / KNOT - speed_kt)
    assert np.mean(off < 1.0) > (0.95, 0.40)[severity - 1]
    assert height_error(flight) < (10.0, 25.0)[severity - 1]
    assert np.abs(heading_error(flight, 0.0)).max() < (1.0, 3.0)[severity - 1]
    moved = np.diff(flight["throttle_left"]) * 100.0
    assert np.std(moved) < (0.01, 0.03)[severity - 1]  # of full travel a second


@pytest.mark.parametrize("speed_kt", [100.0, 160.0])
def test_no_narrow_line_in_longitudinal_acceleration(speed_kt: float) -> None:
    """A line of a two thousandth of g would be seen."""
    force = record_channels(airborne(speed_kt, Air(severity=1, seed=3)), 160.0)["specific_force_x"]
    frequency, height = most_prominent_line(force)
    assert height < 10.0, f"a line of {height:.1f} dB at {frequency:.2f} Hz: a limit cycle?"
    cycle = 5e-4 * STANDARD_GRAVITY * np.sin(2.0 * np.pi * 3.0 * np.arange(force.size) / 100.0)
    frequency, height = most_prominent_line(force + cycle)
    assert frequency == pytest.approx(3.0, abs=0.05)
    assert height > 20.0


def most_prominent_line(values: Array, rate: float = 100.0) -> tuple[float, float]:
    """Frequency [Hz] and height [dB] of the line that stands out most over its surroundings, 0.3–10
    Hz.
    """
    frequency, power = welch(values - values.mean(), rate, nperseg=4096)
    level = 10.0 * np.log10(power)
    around = np.array([np.median(level[max(0, i - 20) : i + 21]) for i in range(level.size)])
    band = (frequency > 0.3) & (frequency < 10.0)
    most = int(np.argmax(np.where(band, level - around, -np.inf)))
    return float(frequency[most]), float((level - around)[most])


def model(stiffness=-8.0, elevator=-6.0, aileron=3.0):
    trim = Trim(60.0, 55.0, 0.05, 0.0, 0.5, np.array([0.0, 1.0]), np.array([-1.0, 1.0]), 1.0)
    pitch = np.array([[-1.2, 0.97, -0.02], [stiffness, -3.0, elevator]])
    lateral = np.array(
        [
            [-0.12, 0.05, -0.99, 0.0, 0.02],
            [-4.0, -3.0, 0.8, aileron, 0.2],
            [3.0, -0.1, -0.5, -0.05, -0.8],
        ]
    )
    return Linear(trim, pitch, lateral, 9.8 / 60.0)


def test_a_step_response_is_the_exact_one():
    time = np.linspace(0.0, 5.0, 51)
    found = step_response(np.array([[0.0, 1.0], [-4.0, -2.0]]), np.array([0.0, 4.0]), 0, time)
    w = np.sqrt(3.0)
    exact = 1.0 - np.exp(-time) * (np.cos(w * time) + np.sin(w * time) / w)
    np.testing.assert_allclose(found, exact, atol=1e-12)


def test_damping_is_that_of_the_slowest_damped_pair():
    assert damping(np.array([[0.0, 1.0], [-4.0, -2.0]])) == pytest.approx(0.5)
    assert damping(np.array([[0.2]])) == -1.0


@pytest.mark.parametrize("stiffness", [-30.0, -8.0, 1.0])  # the last is statically unstable
@pytest.mark.parametrize(
    "sign", [1.0, -1.0]
)  # a control wired the other way round gets the other sign
def test_the_loops_found_are_damped_and_reach_their_targets(stiffness, sign):
    one = model(stiffness, elevator=-6.0 * sign, aileron=3.0 * sign)
    gains = shape("kite", [one], 1.0)
    time = np.linspace(0.0, 20.0, 401)
    pitch = pitch_loop(one, gains.pitch_rate[0], gains.pitch_integral[0])
    bank = bank_loop(one, gains.bank[0], gains.roll_rate[0], gains.yaw_rate[0])
    assert damping(pitch[0]) >= LEAST_DAMPING
    assert step_response(*pitch, 1, time)[-1] == pytest.approx(1.0, abs=0.02)
    assert step_response(*bank, 3, time)[60] == pytest.approx(1.0, abs=0.25)


def test_a_control_that_does_nothing_is_named():
    with pytest.raises(SimulationError, match="kite: the ailerons do nothing at 107 KCAS"):
        shape("kite", [model(aileron=0.0)], 1.0)
    with pytest.raises(SimulationError, match="kite: the elevator does nothing"):
        shape("kite", [model(elevator=0.0)], 1.0)
    # A slow engine slows the loop of the speed.
    assert shape("kite", [model()], 6.0).speed < 0.5 * shape("kite", [model()], 0.2).speed
