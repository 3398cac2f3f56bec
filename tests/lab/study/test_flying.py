"""Real flights: what is kept of them, workload, the fixed-speed points; and the plan that asks for
them.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories

from pitotbench.calibration import calibrate
from pitotbench.campaigns.flights import sense, true_correction
from pitotbench.records import BadInputError
from pitotbench.records.case import Case
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT
from pitotlab.study import measures
from pitotlab.study.conduct import EXPLAINED, fly_sorties, plan_sorties
from pitotlab.study.measures import FELT, fit, fixed_speed_rows, reversals, workload
from pitotlab.study.reductions import (
    BOTH_WAYS,
    COVERING,
    PAPER,
    SETTINGS,
    Reduction,
    Sortie,
    sense_for,
)
from pitotlab.study.velocity_fit import fit_velocity


def test_a_control_reverses_twice_a_period_if_it_is_felt():
    phase = np.linspace(0.0, 20.0 * np.pi, 2001)
    assert reversals(2.0 * FELT * np.sin(phase)) == pytest.approx(20, abs=1)
    assert reversals(0.4 * FELT * np.sin(phase)) == 0
    assert reversals(np.linspace(0.0, 1.0, 100)) == 0


def test_a_person_works_more_than_the_autopilot(smooth_flights):
    person = workload(fly(Case(maneuver="rapid_decel", turbulence="none", pilot="busy")))
    autopilot = workload(smooth_flights["rapid_decel"])
    assert sum(person.reversals.values()) > 2.0 * sum(autopilot.reversals.values())
    assert person.duty > autopilot.duty


def test_density_and_times_are_the_flight(light_flights):
    row = measures.flight_row(light_flights["rapid_decel"])
    assert row["minutes"] == pytest.approx(light_flights["rapid_decel"].duration / 60.0)
    assert 0.0 < row["on_condition_minutes"] < row["minutes"]


def test_a_sortie_gives_what_the_bench_gives():
    case = Case(maneuver="rapid_decel", turbulence="none")
    measured = measures.measure_sortie(Sortie("smooth", case, (Reduction("20/1"),), density=True))
    log = sense(fly(case), "20/1")
    expected = calibrate(log, PAPER).residual_two_sigma / KNOT
    assert measured.fits[0]["residual_two_sigma_kt"] == pytest.approx(expected)
    assert sum(row["seconds"] for row in measured.density) == pytest.approx(
        60.0 * measured.flights[0]["minutes"]
    )


def test_the_papers_case_takes_no_default_of_the_calibrator(light_flights):
    """By default the calibrator weighs the locations by the height; the study does not."""
    flight = light_flights["rapid_decel"]
    log = sense(flight, "50/50")
    assert calibrate(log).diagnostics.static_probability is not None
    for options in (PAPER, COVERING):
        found = calibrate(log, options)
        assert found.error_location == "impact"
        assert found.diagnostics.static_probability is found.diagnostics.height is None
        assert all(each.two_sigma == 0.0 for each in found.assumptions)


def test_the_fit_of_ground_velocity_recovers_the_truth_in_calm_air():
    log = trajectories.fly(trajectories.step_decrease(10), 10, 10, trajectories.CALM)
    found = fit_velocity(log, PAPER)
    np.testing.assert_allclose(
        found.theta, [*trajectories.TRUTH.parameters, *trajectories.WIND], atol=1e-6
    )
    with pytest.raises(BadInputError, match="attitude"):
        fit_velocity(replace(log, roll=None), PAPER)


def test_a_third_output_without_residual_lowers_the_pooled_one(smooth_flights):
    """With noise on the impact pressure alone the fall is 1 − √(2/3); else there is none."""
    flight = smooth_flights["rapid_decel"]
    fall = {}
    for alone in (True, False):
        pooled = []
        for down in (True, False):
            options, how = replace(PAPER, use_down=down), {"given_down": alone, "alone": alone}
            reduction = Reduction(options=options, form="vector", **how)
            row, _ = fit(*sense_for(flight, reduction), reduction)
            pooled.append(row["pooled_two_sigma_kt"])
        fall[alone] = 1.0 - pooled[0] / pooled[1]
    assert fall[True] == pytest.approx(1.0 - (2.0 / 3.0) ** 0.5, abs=0.002)
    assert fall[False] < 0.0


def test_a_case_that_cannot_be_flown_is_named():
    impossible = Sortie("smooth", Case(maneuver="circle", card={"speeds_kt": [400.0]}), ())
    (measured,) = fly_sorties([impossible], jobs=1)
    assert not measured.flights
    assert "circle" in measured.failures[0]


def test_fixed_speed_points_lie_on_the_truth(smooth_flights):
    flight = smooth_flights["four_leg"]
    points = fixed_speed_rows(sense(flight, "50/50"))
    assert sorted(round(p["airspeed_kt"], -1) for p in points) == [100.0, 120.0, 140.0, 160.0]
    speed = np.array([p["airspeed_kt"] for p in points]) * KNOT
    truth = true_correction(flight.case.pressure_error, speed) / KNOT
    np.testing.assert_allclose([p["correction_kt"] for p in points], truth, atol=0.1)


def test_fixed_speed_needs_four_legs(smooth_flights):
    assert fixed_speed_rows(sense(smooth_flights["rapid_decel"], "50/50")) == []


@pytest.mark.parametrize("seeds", [1, 6])
def test_the_plan_explains_a_fifth_of_the_seeds(seeds):
    flown = plan_sorties(seeds)
    for name, setting in SETTINGS.items():
        expected = -(-seeds // EXPLAINED) if setting.rare else seeds
        found = {s.case.truth_seed for s in flown if s.setting == name and s.variant == "standard"}
        assert found == set(range(1, expected + 1)), name
    keys = [(s.setting, s.variant, s.case.maneuver, s.case.truth_seed) for s in flown]
    assert len(keys) == len(set(keys))
    assert {s.case.maneuver for s in flown} == {*PAPER_MANEUVERS, BOTH_WAYS}


def test_the_curves_of_the_airplane_are_of_one_wind():
    """Other walks are fitted from the same flight; the claim is judged by one."""
    case = Case(maneuver="rapid_decel", turbulence="none")
    walks = tuple(
        Reduction("20/1", replace(PAPER, on_condition=True), "wind walk", level)
        for level in (0.5, 1.0, 2.0)
    )
    measured = measures.measure_sortie(Sortie("airplane", case, walks, curves=True))
    speeds = [row["airspeed_kt"] for row in measured.curves if row["kind"] == "paper"]
    assert len(speeds) == len(set(speeds)) > 10
    residuals = {row["residual_two_sigma_kt"] for row in measured.fits}
    assert len(residuals) == len(walks)
