"""The candidate for the calibration: held against dense algebra, differences, and known errors."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.calibration.observations import divide, observe
from pitotbench.calibration.options import Accuracies, CalibrationOptions
from pitotbench.calibration.prediction import wind_by_circle
from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.logbook.reading import read_log
from pitotbench.units import KNOT
from pitotlab import candidate
from pitotlab.candidate import laws
from pitotlab.candidate.heights import height_rows
from pitotlab.candidate.jumps import WithJump
from pitotlab.candidate.linear_gaussian import Equations, Hypothesis, LinearGaussian
from pitotlab.candidate.priors import Priors
from pitotlab.candidate.triangle import predict, triangle
from pitotlab.candidate.unknowns import unknowns_of
from pitotlab.outside.generator import generate, write_csv
from pitotlab.outside.kinds import KINDS, OTHERS

COUNT, UNKNOWNS = 40, 3


class _Noise:
    """White noise and one process, as a family of φ = ln(level, white)."""

    def __init__(self, loading):
        self.loading = loading

    def stack(self, phis):
        sizes = np.exp(phis)
        intervals = Intervals(np.arange(COUNT + 1.0), np.arange(COUNT))
        process = MarkovProcess(sizes[:, 0], np.full((len(phis), COUNT + 1), 6.0), self.loading)
        white = np.broadcast_to(sizes[:, 1, None, None] ** 2, (len(phis), 1, COUNT))
        return MarkovNoise(intervals, white.copy(), [process])


@pytest.fixture(scope="module")
def small():
    """A small problem, its columns, and its dense covariance as a function of φ."""
    rng = np.random.default_rng(5)
    columns, response = rng.standard_normal((COUNT, UNKNOWNS)), rng.standard_normal(COUNT)
    noise = _Noise(np.ones((COUNT, 1)))
    equations = Equations(
        response, np.zeros(UNKNOWNS), columns, columns, np.arange(UNKNOWNS), noise, slice(0, 2)
    )
    deviations = np.array([2.0, 0.5, 1.0])

    def precision(phis):
        return np.broadcast_to(deviations**-2.0, (len(phis), UNKNOWNS)).copy()

    def log_prior(phis):
        return -0.5 * np.sum(phis**2, axis=1)

    problem = LinearGaussian([equations], UNKNOWNS, [Hypothesis("one", 1.0, precision)], log_prior)

    def covariance(phi):
        return np.linalg.inv(noise.stack(phi[None]).weigh(np.eye(COUNT))[0])

    return problem, columns, response, deviations, covariance


def test_the_marginal_likelihood_is_that_of_dense_algebra(small):
    problem, columns, response, deviations, covariance = small
    phis = np.log([[0.7, 0.3], [1.5, 0.2], [0.2, 1.0]])

    def dense(phi):
        whole = covariance(phi) + columns * deviations**2 @ columns.T
        misfit = response @ np.linalg.solve(whole, response)
        return -0.5 * (np.linalg.slogdet(whole)[1] + misfit + phi @ phi)

    found, wanted = problem.heights(phis), np.array([dense(phi) for phi in phis])
    assert np.diff(found) == pytest.approx(np.diff(wanted), abs=1e-8)


def test_the_answer_is_that_of_dense_algebra(small):
    problem, columns, response, deviations, covariance = small
    phi = np.log([0.7, 0.3])
    weights = np.linalg.solve(covariance(phi), columns)
    wanted = np.linalg.inv(columns.T @ weights + np.diag(deviations**-2.0))
    mean, spread = problem.solve(phi)
    assert spread == pytest.approx(wanted, rel=1e-8)
    assert mean == pytest.approx(wanted @ weights.T @ response, rel=1e-8)


def test_a_jump_is_two_more_unknowns_at_a_time_that_nobody_knows(small):
    problem, columns, response, deviations, covariance = small
    rng, deviation, odds = np.random.default_rng(6), 0.8, 0.3
    further, times = 0.01 * rng.standard_normal((COUNT, 6)), np.arange(3.0)
    phi = np.log([0.7, 0.3])
    jump = WithJump(problem, 0, times, further, deviation, odds)
    noise = covariance(phi) + columns * deviations**2 @ columns.T

    def dense(whole):
        return -0.5 * (np.linalg.slogdet(whole)[1] + response @ np.linalg.solve(whole, response))

    each = [
        dense(noise + deviation**2 * pair @ pair.T) - dense(noise) + np.log(odds / len(times))
        for pair in np.split(further, 3, axis=1)
    ]
    gain = jump.heights(phi[None])[0] - problem.heights(phi[None])[0]
    assert gain == pytest.approx(np.logaddexp.reduce(each), abs=1e-8)
    answers = jump.answers(phi, 0, 1.0)
    assert [a.weight for a in answers] == pytest.approx(np.exp(each - np.logaddexp.reduce(each)))
    columns = np.column_stack([columns, further[:, :2]])
    weights = np.linalg.solve(covariance(phi), columns)
    prior = np.diag([*deviations**-2.0, *[deviation**-2.0] * 2])
    spread = np.linalg.inv(columns.T @ weights + prior)
    assert answers[0].covariance == pytest.approx(spread[:UNKNOWNS, :UNKNOWNS], rel=1e-7)
    assert answers[0].mean == pytest.approx((spread @ weights.T @ response)[:UNKNOWNS], rel=1e-7)


def test_what_smoothed_columns_take_off_an_answer_is_no_noise(small):
    """Of data that the regressors explain exactly, the likelihood sees no rest, whatever the
    instruments.
    """
    problem, columns, _, _, _ = small
    (own,) = problem.equations
    truth, phi = np.array([3.0, -2.0, 1.0]), np.log([[0.05, 0.01]])
    instruments = columns + 0.1 * np.random.default_rng(7).standard_normal(columns.shape)
    exact = replace(own, residual=np.zeros(COUNT), point=truth, instruments=instruments)
    flat = [Hypothesis("flat", 1.0, lambda phis: np.zeros((len(phis), UNKNOWNS)))]
    found = LinearGaussian([exact], UNKNOWNS, flat, problem.log_prior)
    same = LinearGaussian(
        [replace(exact, point=np.zeros(UNKNOWNS))], UNKNOWNS, flat, problem.log_prior
    )
    assert found.heights(phi) == pytest.approx(same.heights(phi), abs=1e-8)
    assert found.solve(phi[0])[0] == pytest.approx(truth, abs=1e-8)


def test_the_prior_of_a_smooth_curve_is_a_line_and_a_matern_departure():
    law = laws.smooth(1000.0, 4000.0, 1630.0, 0.05, 0.03, 0.7)
    q = np.geomspace(1000.0, 4000.0, laws.KNOTS)
    basis, size = law.basis(q), 0.002
    scale = np.where(law.departure, size, law.deviations)
    place = np.linspace(-1.0, 1.0, laws.KNOTS)
    apart = np.sqrt(3.0) * np.abs(place[:, None] - place) / 0.7
    wanted = 0.05**2 + 0.03**2 * np.outer(place, place)
    wanted = wanted + size**2 * (1.0 + apart) * np.exp(-apart)
    # Eigenvectors below 1 % of the largest are left out.
    assert (basis * scale**2) @ basis.T == pytest.approx(wanted, abs=0.1 * size**2)
    step = 1e-3
    slope = (law.basis(q + step) - law.basis(q - step)) / (2.0 * step)
    assert law.slope(q)[1:-1] == pytest.approx(slope[1:-1], abs=1e-7)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A Step Decrease of the independent generator: the flight and its log."""
    flight = generate(KINDS["base"], "step_decrease", 1003)
    path = tmp_path_factory.mktemp("flown") / "log.csv"
    write_csv(flight, path)
    return flight, read_log(path)


def test_the_columns_of_the_triangle_are_its_derivatives(flown):
    _, log = flown
    obs = observe(log, CalibrationOptions()).every(50)
    stated = Accuracies(1.5, 0.02, 30.0)
    unknowns = unknowns_of(stated, [(obs, None)], 1630.28, Priors())
    (flight,) = unknowns.flights
    beta = 0.3 * np.array(unknowns.rivals[0][2])
    beta[unknowns.departures] = 0.3 * unknowns.priors.departure
    beta[flight.winds] = wind_by_circle(obs)
    whole = predict(unknowns, flight, beta)
    for place in range(unknowns.count):
        step = np.zeros(unknowns.count)
        step[place] = 1e-4 * max(float(unknowns.rivals[-1][2][place]), 1e-3)
        ahead, behind = (predict(unknowns, flight, beta + s * step) for s in (1.0, -1.0))
        slope = (ahead.reading - behind.reading) / (2.0 * step[place]) / whole.slope
        if np.any(whole.columns[:, place]):  # the recovery factor is told to first order
            size = float(np.max(np.abs(slope)))
            assert whole.columns[:, place] == pytest.approx(slope, abs=0.03 * size), place


def test_late_air_data_show_with_one_sign_in_both_equations(flown):
    """Air data late by τ see an older airspeed and an older height: −τ in acceleration and climb."""
    _, log = flown
    obs = observe(log, CalibrationOptions())
    rows = height_rows(log, obs, wind_by_circle(obs))
    assert rows is not None
    unknowns = unknowns_of(Accuracies(), [(obs, rows)], 1630.28, Priors())
    (flight,) = unknowns.flights
    beta = np.zeros(unknowns.count)
    beta[flight.winds] = wind_by_circle(obs)
    own = triangle(unknowns, flight, divide(obs, 1.0), beta, 0.0)
    at = list(own.equations.places).index(flight.at["latency_s"])
    speed = own.blocks.mean(predict(unknowns, flight, beta).airspeed)
    rate = np.gradient(speed, own.blocks.middle())
    assert np.corrcoef(own.equations.regressors[:, at], rate)[0, 1] > 0.7


@pytest.mark.parametrize(("kind", "seed"), [("base", 1001), ("jet", 1002), ("shear", 1004)])
def test_a_known_error_is_found(kind, seed, tmp_path):
    cell = {**KINDS, **OTHERS}[kind]
    flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
    write_csv(flight, tmp_path / "log.csv")
    found = candidate.calibrate(read_log(tmp_path / "log.csv"))
    airspeed = found.curve.indicated_airspeed
    inside = (airspeed > cell.low) & (airspeed < cell.high)
    error = found.curve.correction[inside] - flight.correction(airspeed[inside])
    assert np.mean(np.abs(error) < found.curve.two_sigma[inside]) > 0.8
    assert np.all(found.curve.two_sigma[inside] < 3.0 * KNOT)
    assert found.agreement is None or found.agreement > 1e-3


@pytest.mark.parametrize(("kind", "jumps"), [("front", True), ("calm", False)])
def test_a_front_is_told_and_smooth_air_is_smooth(kind, jumps, tmp_path):
    """Noise that a jump explains is no slow wind; without one the air is as calm as it is."""
    cell = {**KINDS, **OTHERS}[kind]
    flight = generate(cell, "circle", 4600001)
    write_csv(flight, tmp_path / "log.csv")
    found = candidate.calibrate(read_log(tmp_path / "log.csv"))
    assert any("jumped" in text for text in found.warnings) == jumps
    airspeed = found.curve.indicated_airspeed
    inside = (airspeed > cell.low) & (airspeed < cell.high)
    error = np.abs(found.curve.correction[inside] - flight.correction(airspeed[inside]))
    assert np.all(error < found.curve.two_sigma[inside])


def test_a_sensor_that_nobody_calibrated_is_told_as_a_scale(tmp_path):
    cell = OTHERS["scale"]
    flight = generate(cell, cell.maneuvers[1000 % len(cell.maneuvers)], 1000)
    write_csv(flight, tmp_path / "log.csv")
    found = candidate.calibrate(read_log(tmp_path / "log.csv"))
    assert found.unknown > 0.9
    assert any("factor" in text for text in found.warnings)


def test_two_logs_have_one_curve_and_two_winds(flown, tmp_path):
    _, log = flown
    both = candidate.calibrate([log, log])
    alone = candidate.calibrate(log)
    assert len(both.winds) == 2
    assert np.mean(both.curve.two_sigma) < np.mean(alone.curve.two_sigma)
