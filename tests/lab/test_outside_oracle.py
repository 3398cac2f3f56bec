"""The oracle against brute force, and against the scatter of the flights whose bound it states."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.records import USUAL_ACCURACIES
from pitotlab.outside import oracle
from pitotlab.outside import physics as physics
from pitotlab.outside.generator import generate
from pitotlab.outside.motion import MANEUVERS, NOISE, RATE, Leg
from pitotlab.outside.moving_air import CELLS
from pitotlab.outside.oracle import Height
from pitotlab.outside.physics import KNOT

SHORT = (Leg(5.0, 1.0), Leg(0.0, 0.6, 90.0, steep=True), Leg(5.0, 0.4))
BLOCK = 20  # rows a second


@pytest.fixture
def short_flight(monkeypatch):
    """A minute of flight with one turn, with GPS at 20 Hz."""
    monkeypatch.setitem(MANEUVERS, "short", SHORT)
    return generate(CELLS["base"], "short", 2)


def test_the_bound_of_the_triangle_is_that_of_brute_force_over_all_rows(short_flight):
    """Slopes by hand, covariance of every row by definition, blocks by a matrix."""
    state, error = short_flight.state, short_flight.error
    count = len(state.time) // BLOCK
    rows = slice(0, count * BLOCK)
    mean = np.kron(np.eye(count), np.full((1, BLOCK), 1.0 / BLOCK))
    through_air = (state.ground_velocity - short_flight.sky.wind)[rows]
    direction = through_air / np.linalg.norm(through_air, axis=1, keepdims=True)
    pressure, temperature = state.pressure[rows], state.temperature[rows]
    sound = np.sqrt(1.4 * 287.053 * temperature)
    mach = state.quiet_airspeed[rows] / sound
    impact = pressure * ((1.0 + 0.2 * mach**2) ** 3.5 - 1.0)
    indicated = impact * (1.0 - error.share(impact))
    for _ in range(50):
        indicated = impact * (1.0 - error.share(indicated))
    # dM/dp at a fixed total pressure, and with it dV/dΔp
    by_source = sound * (1.0 + 0.2 * mach**2) / (1.4 * mach * pressure)
    x = indicated / error.reference
    basis = np.stack([np.ones_like(x), x, 1.0 / x], axis=-1)
    widened = indicated / (1.0 - error.share(indicated)) ** 2
    jacobian = mean @ np.column_stack([(by_source * widened)[:, None] * basis, direction[:, :2]])
    # one more pascal of q_ci moves q_c by itself and by the slope of the error
    slope = (error.k[1] - error.k[2] / x**2) / error.reference
    impact_slope = 1.0 / (1.0 - error.share(indicated)) + widened * slope
    by_total = -by_source * pressure / (pressure + impact)  # dV/dp_t is opposite, smaller by p/p_t
    by_impact = -by_total + by_source * (impact_slope - 1.0)
    by_static = -by_total - by_source
    distance = np.concatenate([[0.0], np.cumsum(state.quiet_airspeed[rows][1:])]) / RATE
    memory = np.exp(-np.abs(distance[:, None] - distance[None, :]) / 300.0)
    gust = 0.25 * memory * (direction @ direction.T)
    by_temperature = 0.5 * state.quiet_airspeed[rows] / temperature
    pressures = (by_impact * 10.0) ** 2 + (by_static * 10.0) ** 2
    white = pressures + (by_temperature * 0.05) ** 2 + 0.05**2
    covariance = mean @ (gust + np.diag(white)) @ mean.T
    spread = np.linalg.inv(jacobian.T @ np.linalg.inv(covariance) @ jacobian)
    points = physics.impact_pressure(short_flight.truth.indicated_airspeed)
    share, ratio = error.share(points), points / error.reference
    at_points = points / (1.0 - share) ** 2
    true_impact = points / (1.0 - share)
    above, below = (physics.calibrated_airspeed(true_impact + step) for step in (0.5, -0.5))
    terms = np.stack([np.ones(len(points)), ratio, 1.0 / ratio], axis=-1)
    curve = ((above - below) * at_points)[:, None] * terms
    expected = 2.0 * np.sqrt(np.einsum("ci,ij,cj->c", curve, spread[:3, :3], curve))
    found = oracle.bound(short_flight)
    np.testing.assert_allclose(found.curve, expected, rtol=0.01)
    np.testing.assert_allclose(found.wind, 2.0 * np.sqrt(np.diag(spread)[3:]), rtol=0.01)


def test_the_mean_of_the_correlation_over_blocks_is_that_of_its_rows():
    width, per, length = 80.0, 400, 300.0
    rows = (np.arange(6 * per) + 0.5) * width / per
    mean = np.kron(np.eye(6), np.full((1, per), 1.0 / per))
    expected = mean @ np.exp(-np.abs(rows[:, None] - rows[None, :]) / length) @ mean.T
    centers = (np.arange(6) + 0.5) * width
    apart = np.abs(centers[:, None] - centers[None, :])
    np.testing.assert_allclose(oracle.mean_exponential(apart, centers, length), expected, rtol=1e-5)


def _measured(flight, blocks, height):
    """The rows of the equations from the flight's log, with θ at its true value."""
    log, count = flight.columns, len(blocks.time)

    def mean(values):
        return values[: count * BLOCK].reshape(count, BLOCK).mean(axis=1)

    mach = physics.mach_number(flight.state.impact / flight.state.pressure)
    if "total_temperature_k" in log:
        temperature = log["total_temperature_k"] / (1.0 + 0.2 * mach**2)
    else:
        temperature = log["air_temperature_k"]
    pressures = (log["impact_pressure_pa"], log["static_pressure_pa"])
    velocity = (log[f"velocity_{axis}_mps"] for axis in ("north", "east", "down"))
    inputs = np.stack([mean(values) for values in (*pressures, temperature, *velocity)])
    theta = np.array([*blocks.error.k, *blocks.wind])
    rows = [oracle.triangle(blocks, theta, inputs)]
    if height is not Height.NONE:
        sky = flight.sky
        expected = sky.pressure(log["altitude_m"], *flight.state.position.T)
        source = blocks.error.share(inputs[0]) * inputs[0] / (1.0 - blocks.error.share(inputs[0]))
        rows.append(mean(log["static_pressure_pa"] - expected) - source)
        rows.append(mean(log["altitude_m"] + np.cumsum(log["velocity_down_mps"]) / RATE))
    return np.concatenate(rows)


@pytest.mark.parametrize("height", [Height.NONE, Height.WITH_VELOCITY])
def test_flights_scatter_about_the_truth_as_the_oracle_says(height):
    """χ² of the estimates of wind and curve, over flights: its mean is the number of parameters."""
    found = []
    for seed in range(100, 140, 2):
        flight = generate(CELLS["base"], "rapid_decel", seed)
        blocks = oracle.blocks_of(flight)
        jacobian, covariance = oracle.equations(flight, blocks, height, NOISE)
        factor = np.linalg.cholesky(covariance)
        scale = np.linalg.norm(jacobian, axis=0)
        whitened = np.linalg.solve(factor, jacobian / scale)
        residual = np.linalg.solve(factor, _measured(flight, blocks, height))
        spread = np.linalg.inv(whitened.T @ whitened)
        estimate = (spread @ whitened.T @ residual)[:5]
        found.append(estimate @ np.linalg.solve(spread[:5, :5], estimate))
    standard_error = np.sqrt(2.0 * 5.0 / len(found))
    assert abs(np.mean(found) - 5.0) < 3.5 * standard_error


@pytest.mark.parametrize(
    ("maneuver", "alone", "both"),
    [("rapid_decel", 0.70, 0.64), ("step_decrease", 0.69, 0.47), ("circle", 0.85, 0.66)],
)
def test_the_height_equation_narrows_the_bound_as_an_earlier_computation_found(
    maneuver, alone, both
):
    """Bound of both equations over the triangle's; its sensors are known roughly."""
    flight = generate(CELLS["base"], maneuver, 2)
    triangle, with_height, with_velocity = (
        float(np.mean(oracle.bound(flight, h, 2.0).curve)) for h in Height
    )
    assert with_height / triangle == pytest.approx(alone, abs=0.08)
    assert with_velocity / triangle == pytest.approx(both, abs=0.08)


def test_without_gusts_the_bound_is_that_of_the_sensors_and_falls_with_them():
    flight = generate(CELLS["calm"], "circle", 2)
    quiet = replace(NOISE, impact=5.0, static=5.0, temperature=0.025, velocity=0.025)
    half = oracle.bound(flight, noise=quiet).curve / oracle.bound(flight).curve
    np.testing.assert_allclose(half, 0.5, rtol=1e-6)
    assert 0.005 < np.mean(oracle.bound(flight).curve) / KNOT < 0.05


def test_a_cell_without_a_known_covariance_has_no_oracle():
    with pytest.raises(ValueError, match="no covariance in closed form"):
        oracle.bound(generate(CELLS["bursts"], "rapid_decel", 2))


def test_in_calm_air_the_level_is_no_better_than_the_temperature(short_flight):
    """TAS grows with the root of the temperature: 0.75 K of 280 K is 0.13 % of the airspeed, 1σ."""
    calm = replace(short_flight, cell=replace(short_flight.cell, gust_sigma=1e-4))
    only = oracle.Accuracy(temperature=0.75)
    found = oracle.bound(calm, accuracy=only).curve ** 2 - oracle.bound(calm).curve ** 2
    temperature = float(np.mean(calm.state.temperature))
    expected = calm.truth.indicated_airspeed * 0.75 / temperature  # 2σ
    assert np.sqrt(found) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("height", [Height.NONE, Height.WITH_VELOCITY])
def test_a_constant_error_of_known_size_is_an_unknown_with_a_prior(short_flight, height):
    """Errors in the covariance, and as unknowns observed to be zero, give one bound."""
    blocks = oracle.blocks_of(short_flight)
    jacobian, covariance = oracle.equations(short_flight, blocks, height, NOISE)
    errors = oracle.constant_errors(blocks, height, oracle.USUAL_ONE_SIGMA)
    inverse = np.linalg.inv(covariance)
    wide = np.hstack([jacobian, errors])
    information = wide.T @ inverse @ wide
    unknowns = jacobian.shape[1]
    information[unknowns:, unknowns:] += np.eye(errors.shape[1])
    scale = np.sqrt(np.diag(information))
    spread = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    slope = oracle.curve_slope(blocks.error, short_flight.truth.indicated_airspeed)
    expected = 2.0 * np.sqrt(np.einsum("ci,ij,cj->c", slope, spread[:3, :3], slope))
    found = oracle.bound(short_flight, height, accuracy=oracle.USUAL_ONE_SIGMA).curve
    assert found == pytest.approx(expected, rel=1e-5)
    assert np.all(found > oracle.bound(short_flight, height).curve)


def test_the_oracle_takes_the_accuracies_that_the_calibration_takes_for_usual():
    """Half of the product's 2σ, written again; the total source is exact for the oracle."""
    stated = {"temperature_k": "temperature", "recovery_factor": "recovery", "static_pressure_pa": "static",
              "velocity_mps": "velocity"}  # fmt: skip
    one_sigma = oracle.USUAL_ONE_SIGMA
    doubled = {ours: 2.0 * getattr(one_sigma, theirs) for ours, theirs in stated.items()}
    usual = {name: value for name, value in USUAL_ACCURACIES.items() if name != "total_source"}
    assert doubled == pytest.approx(usual)
