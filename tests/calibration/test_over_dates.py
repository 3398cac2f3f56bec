"""The correction over the dates of flights: a change is dated, and chance makes none."""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.bench import folder_logs
from pitotbench.bench.calibrations import options_of
from pitotbench.calibration import calibrate_flights
from pitotbench.calibration.flights import DISAGREE
from pitotbench.calibration.over_dates import change_of, over_dates
from pitotbench.records.log import Caution
from pitotbench.units import KNOT

SPEED = np.array([90.0, 120.0, 150.0]) * KNOT


def course(rng: np.random.Generator, count: int, scatter: float = 1.0):
    """Corrections of flights without a change, and their 2σ."""
    bound = rng.uniform(0.3, 0.9, (count, 3)) * KNOT
    level = rng.normal(0.0, 1.0, (count, 1))  # what is wrong in a flight is so at all airspeeds
    return scatter * 0.5 * bound * level, bound


@pytest.mark.parametrize("first", [1, 6, 11])
def test_a_change_is_found_where_it_is(first):
    correction, bound = course(np.random.default_rng(first), 12)
    correction[first:] += np.array([0.2, 0.4, 2.5]) * KNOT
    change = change_of(SPEED, correction, bound)
    assert (change.first, change.airspeed) == (first, SPEED[2])
    assert abs(change.size - 2.5 * KNOT) < 1.5 * change.two_sigma


@pytest.mark.parametrize("scatter", [1.0, 3.0])
def test_chance_seldom_makes_a_change(scatter):
    """Also where flights scatter by three times their bounds."""
    rng = np.random.default_rng(5)
    found = [change_of(SPEED, *course(rng, 12, scatter)) for _ in range(400)]
    assert sum(each is not None for each in found) <= 10


@pytest.fixture(scope="module")
def flight():
    log = fixture.fly(fixture.circles(5), 5, 1, fixture.Air(), seed=7)
    (found,) = calibrate_flights([log], options_of())
    return found


def dated(flight, day: str, more: float = 0.0):
    """The flight on another day, with a curve that is higher by some m/s."""
    curve = flight.calibration.curve
    curve = replace(curve, correction=curve.correction + more)
    header = {**flight.log.header, "start": f"{day} 10:00:00"} if day else flight.log.header
    log = replace(flight.log, header=header)
    return replace(flight, log=log, calibration=replace(flight.calibration, curve=curve))


def test_flights_are_ordered_by_date_and_the_change_is_told_with_its_flight(flight):
    days = {"c": "2026-06-20", "a": "2026-04-02", "d": "2026-07-05", "b": "2026-05-11"}
    more = {"a": 0.0, "b": 0.0, "c": 1.5, "d": 1.5}
    flights = [[dated(flight, day, more[name])] for name, day in days.items()]
    found = over_dates([*days], flights)
    assert found.names == ("a", "b", "c", "d")
    assert found.change.first == 2
    assert found.change.size == pytest.approx(1.5)
    assert "between 2026-05-11 and 2026-06-20 (from c on)" in found.words


def test_a_change_between_dates_is_the_one_story_of_flights_that_disagree(flight, monkeypatch):
    """Both were told of the same flights, one with a date and one with the advice to find it."""
    more = {"2026-04-02": 0.0, "2026-05-11": 0.0, "2026-06-20": 1.5, "2026-07-05": 1.5}
    single = {day: dated(flight, day, each) for day, each in more.items()}
    differ = Caution("the flights disagree about the curve", DISAGREE)

    def calibrated(logs, *_, **__):
        found = [next(each for each in single.values() if each.log is log) for log in logs]
        joint = replace(found[0].calibration, warnings=(differ,))
        return [
            replace(each, place=place, calibration=joint) if len(found) > 1 else each
            for place, each in enumerate(found)
        ]

    monkeypatch.setattr(folder_logs, "calibrate_each", calibrated)
    answers = folder_logs.calibrate_folder([*more], lambda day: single[day].log)
    change = answers[0].over_dates.change
    assert change.first == 2
    for answer in answers:
        told = answer.flights[0].calibration.warnings
        assert [each.code for each in told if each.code != "logs left out"] == [
            "changed over dates"
        ]
        assert told[-1].moves.most == abs(change.size)


def test_no_course_without_dates_or_of_two_flights(flight):
    flights = [[dated(flight, day)] for day in ("2026-06-20", "2026-06-21", "")]
    assert over_dates("abc", flights) is None
    assert over_dates("ab", flights[:2]) is None
    same = over_dates("abc", [*flights[:2], [dated(flight, "2026-06-22")]])
    assert (same.change, same.words) == (None, "")
