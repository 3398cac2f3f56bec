"""The older methods as sensors, two systems in one flight, and the committed tables of both."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pitotbench import air
from pitotbench.campaigns.flights import sense
from pitotbench.sensing.recorder import known_curve
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT
from pitotlab.study import conventional, methods
from pitotlab.study.conventional import AIRSPEEDS, Points, against_truth, fit_points
from pitotlab.study.methods import BANKS, SECOND, STATIC, SYSTEM
from pitotlab.study.reductions import PAPER_ORDER, case_of


def _points(passes, own=0.0, shared=0.0):
    impact = air.impact_pressure(np.repeat([100.0, 120.0, 140.0, 160.0], passes) * KNOT)
    error = known_curve(STATIC).impact_pressure(impact) - impact
    count = len(impact)
    return Points(impact, error, np.full(count, own), np.full((1, count), shared))


def test_points_without_error_give_the_curve():
    found = against_truth(fit_points(_points(1, own=1.0)), STATIC)
    assert np.abs(found.error).max() < 1e-6 * KNOT


def test_more_passes_help_against_the_own_error_alone():
    def bound(passes, own, shared):
        return fit_points(_points(passes, own, shared))[1].mean()

    assert bound(16, 10.0, 1e-3) == pytest.approx(0.25 * bound(1, 10.0, 1e-3), rel=1e-3)
    assert bound(16, 1.0, 10.0) > 0.9 * bound(1, 1.0, 10.0)


def test_the_bound_covers_drawn_errors():
    rng, clean = np.random.default_rng(1), _points(2, own=12.0, shared=8.0)
    inside = []
    for _ in range(400):
        drawn = clean.own * rng.standard_normal(len(clean.own))
        drawn += clean.shared[0] * rng.standard_normal()
        points = replace(clean, pressure_error=clean.pressure_error + drawn)
        inside.append(against_truth(fit_points(points), STATIC).inside)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.03)


class _Still:
    """A generator whose draws are zero: what is left is the flight and its sensors."""

    def standard_normal(self):
        return 0.0


@pytest.fixture(scope="module")
def flight():
    case = case_of("smooth", "race_track", 3, card={"dwell_s": 20.0}, pressure_error=STATIC)
    return fly(case, channels=methods._CHANNELS)


@pytest.mark.parametrize("name", ["tower", "pacer", "cone"])
def test_a_method_whose_instruments_are_exact_finds_the_curve(name, flight):
    read = getattr(conventional, name)
    found = against_truth(fit_points(read(flight, sense(flight, SYSTEM), _Still())), STATIC)
    assert found.rms_error < 0.15 * KNOT
    assert found.mean_two_sigma > 0.1 * KNOT  # the stated errors of the method stay in its bound


def test_two_systems_differ_by_what_they_were_given(flight):
    row = methods.two_systems(flight)
    assert row["difference_error_kt"] < 0.02
    assert row["difference_error_kt"] < 1.5 * row["difference_bound_kt"]
    assert row["wind_gap_kt"] < 0.1
    for system in "ab":
        assert row[f"{system}_both_error_kt"] < 0.02
        assert row[f"{system}_both_bound_kt"] < 0.02


def test_a_system_does_not_differ_from_itself(flight):
    log = sense(flight, SYSTEM)
    assert np.abs(methods.system_difference(log, log)[0]).max() == 0.0
    other = sense(replace(flight, case=replace(flight.case, pressure_error=SECOND)), SYSTEM)
    there, back = (methods.system_difference(*pair)[0] for pair in ((log, other), (other, log)))
    assert np.allclose(there, -back, atol=1e-9)
    assert len(there) == len(AIRSPEEDS)


def test_set_up_is_counted_between_airspeeds_alone():
    names = [*PAPER_ORDER, *methods.OLDER]
    table = pd.DataFrame({"method": names, "minutes": 10.0})
    added = dict(zip(names, methods.in_the_air(table) - 10.0, strict=True))
    without = {"step_decrease", "rapid_decel", "cone, slowing"}
    assert {name for name, minutes in added.items() if minutes == 0.0} == without
    assert {minutes for name, minutes in added.items() if name not in without} == {6.0}


def test_the_committed_tables_are_whole():
    folder = methods.RESULTS
    banks, flown, systems = (pd.read_csv(folder / f"{name}.csv") for name in methods.KEYS)
    assert tuple(banks["bank_deg"]) == BANKS
    assert set(flown["method"]) == {*PAPER_ORDER, *methods.OLDER}
    assert set(systems["maneuver"]) == set(PAPER_ORDER)
    seeds = {int(count) for table in (banks, flown, systems) for count in table["seeds"]}
    assert len(seeds) == 1  # all of one run
    assert min(seeds) > 1
    # Gusts are common to both.
    assert (systems["difference_bound_kt"] < 0.2 * systems["a_alone_bound_kt"]).all()


def test_tables_and_pictures_are_written_again_without_flights(tmp_path, capsys):
    from pitotlab.__main__ import main

    assert main(["study", "methods", "--again", "--pictures", str(tmp_path)]) == 0
    assert "covering 2σ" in capsys.readouterr().out
    pictures = {"residual-and-truth.png", "bound-and-minutes.png"}
    assert {path.name for path in tmp_path.iterdir()} == pictures


def test_summaries_leave_out_what_a_method_does_not_have():
    rows = pd.DataFrame(
        {"seed": [1, 2], "method": "pacer", "x_error_kt": [3.0, -4.0], "y_kt": [1.0, np.nan]}
    )
    (cell,) = methods.summarize(rows, "method", "now").to_dict("records")
    assert cell["x_error_kt"] == pytest.approx(np.sqrt(12.5))
    assert cell["y_kt"] == 1.0
    assert cell["seeds"] == 2
