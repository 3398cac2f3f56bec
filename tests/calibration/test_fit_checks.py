"""The checks of a fit: the size of its curve apart from its bound, and what lies far outside what
was assumed.
"""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.calibration import static_flights
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, NoAnswerError, air
from pitotbench.broken import BROKEN
from pitotbench.calibration import _named_cause, calibrate
from pitotbench.calibration.fit_checks import _nuisances_outside, judge_curve
from pitotbench.calibration.nuisances import Nuisance
from pitotbench.calibration.options import Accuracies, CalibrationOptions
from pitotbench.estimation.mixture import Posterior
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.pressure_error.models import PressureErrorCurve
from pitotbench.records.log import Caution
from pitotbench.units import KNOT

SPEED = np.linspace(100.0, 160.0, 7) * KNOT
SURE = np.full(7, 0.005)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("size", "kind"), [(0.09, "plausible"), (0.15, "doubtful"), (0.25, "impossible")]
)
def test_one_point_decides_and_either_sign_counts(sign, size, kind):
    error = np.zeros(7)
    error[4] = sign * size
    verdict = judge_curve(SPEED, error, SURE)
    assert verdict.kind == kind
    if kind != "plausible":
        assert verdict.worst == sign * size
        assert verdict.indicated_airspeed == SPEED[4]
        assert f"{100.0 * sign * size:+.0f} % of the impact pressure at 140 kt" in verdict.words


def test_a_large_error_that_is_hardly_known_is_not_impossible():
    assert judge_curve(SPEED, np.full(7, 0.3), np.full(7, 0.35)).kind == "plausible"
    assert judge_curve(SPEED, np.full(7, 0.3), np.full(7, 0.15)).kind == "doubtful"
    # The worst is named among the points that are known.
    error, bound = np.array([0.9, 0.25, 0.0]), np.array([2.0, 0.01, 0.01])
    assert judge_curve(SPEED[:3], error, bound).worst == 0.25


def test_a_handbook_near_the_stall_is_plausible_and_so_large_an_error_in_cruise_is_not():
    """Cessna 172S, flaps up: an error of 20 % of the impact pressure at 50 KIAS."""
    shown = np.array([50.0, 60.0, 70.0, 80.0, 90.0, 100.0, 110.0]) * KNOT
    right = np.array([56.0, 62.0, 70.0, 78.0, 87.0, 97.0, 107.0]) * KNOT
    error = 1.0 - air.impact_pressure(shown) / air.impact_pressure(right)
    assert error[0] > 0.2
    assert judge_curve(shown, error, SURE).kind == "plausible"
    assert judge_curve(shown, error[::-1].copy(), SURE).kind == "doubtful"


def test_a_curve_that_is_none_is_refused():
    with pytest.raises(ValueError, match="one length"):
        judge_curve(SPEED, np.zeros(6), SURE)
    with pytest.raises(ValueError, match="not finite"):
        judge_curve(SPEED, np.full(7, np.nan), SURE)


QUIET = fixture.Air(gust=0.05, pressure=2.0)


def _outside(result):
    return [warning for warning in result.warnings if warning.code == "outside prior"]


def test_a_zero_offset_beyond_its_accuracy_is_named_with_its_size():
    truth = PressureErrorCurve(MODELS["bias"], (-0.03,), REFERENCE_PRESSURE)
    log = fixture.fly(fixture.circles(20), 20, 20, QUIET, truth=truth)
    off = replace(log, impact_pressure=log.impact_pressure + 200.0)
    few = CalibrationOptions(model="bias", accuracies=Accuracies(impact_pressure_zero_pa=40.0))
    (warning,) = _outside(calibrate(off, few))
    assert "zero offset of the impact pressure" in warning
    assert "±40 Pa (2σ)" in warning
    assert warning.size == pytest.approx(200.0, rel=0.1)
    enough = CalibrationOptions(model="bias", accuracies=Accuracies(impact_pressure_zero_pa=400.0))
    assert not _outside(calibrate(off, enough))


def test_gusts_of_another_scale_are_named_with_their_length():
    """A wave of 300 s, some 20 km, where gusts of 533 m are expected."""
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.0, pressure=2.0))
    slow = replace(
        log, velocity_north=log.velocity_north + 1.5 * np.sin(2.0 * np.pi * log.time / 300.0)
    )
    result = calibrate(slow, CalibrationOptions(wind="constant"))
    assert any("gusts' length" in warning for warning in _outside(result)), result.diagnostics


@pytest.mark.parametrize("maneuver", ["circle", "step_decrease", "rapid_decel"])
def test_a_flight_as_assumed_warns_of_nothing(maneuver):
    assert not _outside(calibrate(static_flights.fly(maneuver, 3)))


def test_a_temperature_that_the_log_hardly_knows_is_named_all_the_same():
    """The prior of 0.75 K draws an error of 5 K down to some 1 K, which such a log would find in 1
    % of cases. What is told is what the log says without that prior.
    """
    usual = CalibrationOptions(accuracies=Accuracies(temperature_k=1.5))
    log = static_flights.fly("rapid_decel", 3, conditions=static_flights.Conditions(gust=0.3))
    off = replace(log, total_temperature=log.total_temperature + 5.0)
    (warning,) = _outside(calibrate(off, usual))
    told, bound = re.search(r"the temperature needs is ([-+.\d]+) ± ([.\d]+) K", warning).groups()
    assert abs(float(told) + 5.0) < float(bound) < 5.0
    assert not _outside(calibrate(log, usual))


def test_a_finding_moves_the_curve_by_what_a_fit_without_it_changes_and_the_bound_holds_both():
    def curve(temperature: float):
        known = CalibrationOptions(accuracies=Accuracies(temperature_k=temperature))
        found = calibrate(off, known)
        return found, found.curve.correction

    log = static_flights.fly("rapid_decel", 3, conditions=static_flights.Conditions(gust=0.3))
    off = replace(log, total_temperature=log.total_temperature + 5.0)
    (found, between), (_, held) = curve(1.5), curve(1e-3)
    (warning,) = _outside(found)
    moved = 2.0 * np.abs(between - held)  # the answer is halfway
    assert warning.moves.most == pytest.approx(np.max(moved), rel=0.05)
    assert f"it moves the curve by up to {warning.moves.most / KNOT:.2f} kt" in warning
    assert np.all(found.curve.two_sigma > 0.5 * moved), "the bound holds both"


def test_estimates_scatter_as_the_prior_and_the_log_let_them():
    """One number with a prior of 1, seen by logs with errors of 3: estimates are 0.1 of it,
    scattered by √0.1.
    """
    structure = SimpleNamespace(
        nuisances=(Nuisance("temperature_k", 1.0, None),), model=SimpleNamespace(count=0)
    )

    def said(seen, error):
        known = 1.0 / (1.0 + error**2)
        answer = Posterior(np.ones(1), np.array([[known * seen]]), np.array([[[1.0 - known]]]))
        return bool(_nuisances_outside(structure, answer))

    one_in_a_hundred = 2.576 * np.sqrt(10.0)
    for share in (1.01, -1.01):
        assert said(share * one_in_a_hundred, 3.0)
        assert not said(share * 0.98 * one_in_a_hundred, 3.0)
    assert said(9.0, 3.0)  # moves the estimate by less than its prior's deviation
    assert not said(90.0, 100.0)  # a log that says nothing


def test_an_estimate_that_the_log_does_not_size_is_told_without_a_size():
    """An estimate beyond its prior whose spread is no less than that of the prior: without the prior
    it would be any number.
    """
    structure = SimpleNamespace(
        nuisances=(Nuisance("height_latency_s", 0.5, None),), model=SimpleNamespace(count=0)
    )
    answer = Posterior(np.ones(1), np.array([[1.35]]), np.array([[[0.49**2]]]))
    (told,) = _nuisances_outside(structure, answer)
    assert "lies beyond the ±1 s (2σ) that is assumed; the log does not tell by how much" in told
    assert "33" not in told


def test_a_broken_sensor_that_the_reading_found_is_the_cause_of_no_answer():
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(), seed=1)
    usual = CalibrationOptions()
    told = Caution("the static pressure stands still: the port is closed", BROKEN)
    broken = replace(log, header={"warnings": (Caution("a remark", "log"), told)})
    with pytest.raises(BadInputError, match="the port is closed"), _named_cause([broken], usual):
        raise NoAnswerError("the bound is 20 kt")
    with pytest.raises(NoAnswerError, match="20 kt"), _named_cause([log], usual):
        raise NoAnswerError("the bound is 20 kt")
