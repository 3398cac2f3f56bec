"""Forecasts: drawn gusts, identities of the bound, the ranking, flights that they foretell, and the
command.
"""

import json
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from itertools import count

import numpy as np
import pytest

import pitotbench
from pitotbench import (
    BadInputError,
    CalibrationOptions,
    Case,
    NoAnswerError,
    PlanRequest,
    read_case,
    write_case,
)
from pitotbench.bench import planner
from pitotbench.bench.card_search import best_card, free_numbers
from pitotbench.bench.forecasts import known_noise_two_sigma, smooth_flight
from pitotbench.bench.gusts import _dryden, gust_deviation, with_gusts
from pitotbench.calibration import calibrate
from pitotbench.calibration.expected_bound import ExpectedNoise, expected_two_sigma
from pitotbench.campaigns.flights import sense, wind_toward
from pitotbench.cli.app import BAD_INPUT, DONE, command_line, main
from pitotbench.cli.plan import request_of
from pitotbench.records.forecast import Forecast
from pitotbench.sensing.sampling import has_velocity_down
from pitotbench.show.plan import (
    LEG_COLUMNS,
    plan_advice,
    plan_columns,
    plan_json,
    plan_tree,
    remark,
)
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotbench.units import DEGREE, FOOT, KNOT

# The law of the source study: what is claimed of its maneuvers is claimed with it.
REQUEST = PlanRequest(
    Case(), draws=4, maneuvers=("step_decrease", "decel_circle"), options=CalibrationOptions()
)
WIND = np.array([-3.9, 6.7])  # m/s
SPEEDS = np.arange(100.0, 161.0, 10.0) * KNOT


@pytest.fixture(scope="module")
def plan():
    return pitotbench.plan(REQUEST, search_flights=0)


def known(flight, level):
    log = sense(flight, "20/1")
    return expected_two_sigma(
        log, CalibrationOptions(), WIND, ExpectedNoise(level, 400.0, 1e-4), SPEEDS
    )


def test_a_bound_is_proportional_to_the_gusts(smooth_flights):
    flight = smooth_flights["decel_circle"]
    assert known(flight, 2.0) == pytest.approx(2.0 * known(flight, 1.0), rel=0.02)


def test_one_heading_gives_no_forecast(smooth_flights):
    flight = smooth_flights["step_decrease"]
    log = sense(flight, "20/1")
    north = np.cos(flight["heading"]) > 0.99
    one = log.select(np.flatnonzero(log.time < flight["time"][np.flatnonzero(~north)[0]]))
    with pytest.raises(NoAnswerError, match="wind is not observable"):
        expected_two_sigma(one, CalibrationOptions(), WIND, ExpectedNoise(0.2), SPEEDS)


def test_the_decelerating_circle_has_about_half_the_bound_of_step_decrease(plan):
    circle, step = plan.forecasts
    assert (circle.maneuver, step.maneuver) == ("decel_circle", "step_decrease")
    assert circle.minutes <= step.minutes * 1.01
    assert circle.mean < 0.6 * step.mean
    assert plan.best is circle
    assert plan.gentle is step
    for each in plan.forecasts:  # not knowing the noise widens the bound
        assert 1.0 < each.noise_cost < 1.7


def test_information_adds_up(plan):
    each = plan.forecasts[0]
    assert each.mean_in(4.0 * each.minutes) == pytest.approx(0.5 * each.mean)
    assert each.within(4.5 * each.minutes) == pytest.approx(0.5 * each.mean)
    assert each.within(0.5 * each.minutes) == each.mean
    assert each.times_for(0.5 * each.mean) == 4
    assert each.times_for(2.0 * each.mean) == 1


def test_the_card_for_the_pilot_is_the_card_in_round_numbers(plan):
    """The decelerating circle is 160, 130, 100 KCAS at 45° of bank, for 72, 145 and 72 s."""
    circle = plan.forecasts[0]
    rows = plan_json(replace(plan, gentle=None))["pilot_card"]
    assert [row["leg"] for row in rows] == ["circle", "slow", "circle", "slow", "circle"]
    assert [row["calibrated_airspeed_kt"] for row in rows] == [160.0, 130.0, 130.0, 100.0, 100.0]
    assert [row["seconds"] for row in rows[::2]] == [70.0, 145.0, 70.0]
    assert {row["bank_deg"] for row in rows} == {45.0}
    assert all(0.0 <= row["heading_deg"] < 360.0 for row in rows)
    assert sum(leg.seconds for leg in circle.legs) < 60.0 * circle.minutes


def test_the_bound_of_a_forecast_is_that_of_the_calibrations_of_its_draws(plan):
    circle = plan.forecasts[0]
    flight = smooth_flight(REQUEST, circle.maneuver)
    logs = [sense(with_gusts(flight, Case().turbulence, seed), "20/1") for seed in range(1, 5)]
    curves = [calibrate(log, REQUEST.options).curve for log in logs]
    bounds = [np.interp(REQUEST.airspeeds, c.indicated_airspeed, c.two_sigma) for c in curves]
    # The place of the error is known to the forecast, and its fit starts from the answer.
    assert np.mean(bounds, axis=0) == pytest.approx(circle.two_sigma, rel=0.01)


def test_a_plan_for_minutes_answers_for_them(plan):
    circle = plan.forecasts[0]
    minutes = 2.1 * circle.minutes
    (first, *_) = plan_advice(replace(plan, minutes=minutes))
    assert f"2 times: ±{circle.mean / 2**0.5 / KNOT:.3f} kt" in first
    assert f"in {2.0 * circle.minutes:.1f} min" in first


def test_the_table_tells_what_is_as_good_and_no_bound_in_fewer_minutes_than_a_card_takes(plan):
    circle, step = plan.forecasts
    (bound,) = (
        column
        for column in plan_columns(replace(plan, minutes=6.0))
        if column.heading == "±2σ in 6 min"
    )
    assert bound.text(replace(circle, minutes=5.9)) == f"{circle.mean / KNOT:.3f}"
    assert bound.text(replace(circle, minutes=6.1)) == "–"
    twin = replace(circle, maneuver="cloverleaf", two_sigma=circle.two_sigma + 0.9 * circle.spread)
    worse = replace(circle, maneuver="cloverleaf", two_sigma=circle.two_sigma + 1.1 * circle.spread)
    longer = replace(twin, minutes=1.2 * circle.minutes)
    assert [remark(plan, each) for each in (circle, step)] == ["best", "best, no steep turn"]
    assert [remark(plan, each) for each in (twin, worse, longer)] == ["as good as the best", "", ""]


def _forecast(name: str, minutes: float, bound_kt: float) -> Forecast:
    speeds, bounds = np.array([100.0, 160.0]) * KNOT, np.full(2, bound_kt) * KNOT
    made = 0.5, (9e3, 8e3), speeds, bounds, bounds, 0.01, np.zeros((2, 2))
    return Forecast(name, {}, minutes, minutes, *made)


def test_the_first_row_is_the_advice_and_each_time_has_one_number(monkeypatch):
    """A circle of 6.2 min would be sooner at ±0.1 kt than the best card of at most 6 min."""
    known = {
        "circle": _forecast("circle", 6.2, 0.24),
        "step_both_ways": _forecast("step_both_ways", 5.56, 0.26),
        "rapid_decel": _forecast("rapid_decel", 4.8, 0.30),
    }
    monkeypatch.setattr(planner, "forecast", lambda request, maneuver: known[maneuver])
    request = replace(REQUEST, maneuvers=tuple(known), minutes=6.0, want=0.1 * KNOT)
    found = pitotbench.plan(request, search_flights=0)
    first, _, last = found.forecasts
    assert (first, last.maneuver) == (found.best, "circle")
    _, for_want, sooner = plan_advice(found)[:3]
    (time,) = (c for c in plan_columns(found) if c.heading == "time for them")
    assert for_want.endswith(f"7 times: {time.text(first)} min.")
    assert sooner == (
        "The circle would take 37.2 min for it (6 of 6.2 min each), but one is longer than 6 min."
    )
    assert time.text(last) == "37.2"
    assert remark(found, last) == "one is longer than 6 min"
    assert len(plan_advice(replace(found, forecasts=found.forecasts[:2]))) == 2


def test_time_in_the_air_is_that_recorded_where_nothing_is_left_out(plan):
    circle, step = plan.forecasts
    assert circle.elapsed_minutes == circle.minutes  # or 5.55 min is 5.6 and 5.5
    assert step.elapsed_minutes >= step.minutes


def test_short_legs_add_up_to_the_time_of_the_card(plan):
    """A power step of 8 s is not briefed as one of 10 s."""
    step = plan.forecasts[1]
    briefed = sum(row["seconds"] for row in plan_json(replace(plan, best=step))["pilot_card"])
    assert briefed == pytest.approx(sum(leg.seconds for leg in step.legs), rel=0.02)


def test_an_improved_card_has_a_name_of_its_own(plan):
    best = plan.best
    improved = replace(best, card={"dwells_s": [60.0, 120.0, 60.0]}, two_sigma=0.8 * best.two_sigma)
    found = replace(plan, improved=improved, gentle=None)
    said = plan_advice(found)
    assert said[0].startswith("Fly the decel circle: ")
    assert said[1].startswith(
        "Better by its card (dwells 60, 120, 60 s): fly the decel circle, improved"
    )
    (title,) = (n.text for n in plan_tree(found) if getattr(n, "text", "").startswith("The card"))
    assert title == "The card for the pilot: decel circle, improved"


def test_a_leg_of_more_than_a_turn_is_briefed_in_turns(plan):
    """At 130 KCAS and 45° of bank 145 s are about three turns: the heading at the end tells no
    number of them.
    """
    (bank,) = (c for c in LEG_COLUMNS if c.heading == "bank")
    said = [bank.text(leg) for leg in plan.forecasts[0].legs]
    assert said[2].startswith("45° right, 3 turns and ")
    for leg in plan.forecasts[0].legs:
        whole, _, rest = bank.text(leg).partition(", ")[2].rpartition(" and ")
        degrees = 360.0 * float(whole.split()[0] if whole else 0.0) + float(rest.rstrip("°"))
        assert degrees == pytest.approx(leg.turned / DEGREE, abs=2.5)
    level = replace(plan.forecasts[0].legs[0], bank=0.0)
    assert bank.text(level) == "level"
    assert bank.text(replace(level, bank=0.5, turned=2.0 * np.pi)).endswith(", 1 turn")


def test_box_and_minutes_exclude_and_what_cannot_be_flown_is_said():
    small = replace(REQUEST, maneuvers=("step_decrease",), draws=2, box=1852.0)
    assert pitotbench.plan(small).best is None
    assert pitotbench.plan(replace(small, box=None, minutes=1.0)).best is None
    with pytest.raises(NoAnswerError, match="no maneuver can be flown"):
        pitotbench.plan(
            replace(REQUEST, speeds=(45.0 * KNOT, 160.0 * KNOT), maneuvers=("decel_circle",))
        )


def test_speeds_of_a_card_keep_their_places_and_its_case_reads_back():
    request = replace(REQUEST, speeds=(90.0 * KNOT, 150.0 * KNOT))
    assert request.case("decel_circle").card["speeds_kt"] == [150.0, 120.0, 90.0]
    case = REQUEST.case("decel_circle", {"bank_deg": 40.0})
    assert read_case(write_case(case)) == case


@pytest.mark.parametrize("name", MANEUVERS)
def test_free_numbers_lie_inside_their_bounds(name):
    for number in free_numbers(name):
        value = getattr(MANEUVERS[name].card, number.entry)
        assert number.low <= (value if number.place is None else value[number.place]) <= number.high


def test_a_card_is_shortened_to_the_minutes():
    """Rapid Decel takes 4.8 min; asked for 4.2, the search must find another dwell, and a better
    one per minute.
    """
    request = replace(REQUEST, draws=2)
    found = best_card(request, "rapid_decel", 4.2, flights=6)
    before, after = (smooth_flight(request, "rapid_decel", dict(card)) for card in ({}, found.card))
    assert set(found.card) == {"dwell_s"}
    assert after.duration / 60.0 <= 4.3
    work = [
        np.mean(known_noise_two_sigma(request, f)) * np.sqrt(f.duration) for f in (before, after)
    ]
    assert work[1] < 1.02 * work[0]


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"speeds": (100.0 * KNOT, 110.0 * KNOT)}, "20 kt apart"),
        ({"minutes": -1.0}, "--minutes"),
        ({"want": 0.0}, "--want-kt"),
        ({"draws": 1}, "--draws"),
    ],
)
def test_questions_that_make_no_sense(changes, says):
    with pytest.raises(BadInputError, match=says):
        replace(REQUEST, **changes)


RATE, STEP = 0.15, 0.2  # V/L [1/s], s


@pytest.fixture(scope="module")
def gusts():
    time = np.arange(60_000) * STEP
    return _dryden(time, np.full(len(time), RATE), np.random.default_rng(1))


def correlation(gust, lag):
    n = round(lag / STEP)
    return float(np.mean(gust[n:] * gust[:-n]))


def test_both_gusts_have_unit_variance_at_steps_of_any_length(gusts):
    rng = np.random.default_rng(2)
    time = np.cumsum(rng.exponential(5.0, 20_000))
    uneven = _dryden(time, np.full(len(time), RATE), rng)
    np.testing.assert_allclose([np.var(gust) for gust in (*gusts, *uneven)], 1.0, rtol=0.05)


@pytest.mark.parametrize("lag", [2.0, 6.0, 12.0])
def test_correlations_are_drydens(gusts, lag):
    """Longitudinal exp(−a τ), lateral (1 − a τ/2) exp(−a τ): Hoblit (1988), eqs. for f and g."""
    along, across = gusts
    decay = np.exp(-RATE * lag)
    assert correlation(along, lag) == pytest.approx(decay, abs=0.05)
    assert correlation(across, lag) == pytest.approx((1.0 - 0.5 * RATE * lag) * decay, abs=0.05)


@pytest.mark.parametrize("turbulence", ["light", "moderate"])
def test_level_is_that_of_the_simulator(turbulence, light_flights):
    """The level by the standard's figure, against the simulator's own turbulence at the same
    height.
    """

    case = Case(maneuver="circle", turbulence=turbulence)
    flight = light_flights["circle"] if turbulence == "light" else fly(case)
    mean = wind_toward(case.wind)
    parts = [flight[f"wind_{axis}"] - w for axis, w in zip(("north", "east"), mean, strict=False)]
    assert np.sqrt(np.mean(np.square(parts))) == pytest.approx(gust_deviation(case), rel=0.25)
    # Still air has no gusts, and high air fewer.
    assert gust_deviation(Case(turbulence="none")) == 0.0
    low, high = (
        gust_deviation(replace(case, altitude=h * FOOT, turbulence="moderate"))
        for h in (3000.0, 9000.0)
    )
    assert low > high > 0.0


def test_stirring_moves_the_airspeed_and_nothing_else(smooth_flights):
    flight = smooth_flights["circle"]
    rough = with_gusts(flight, "moderate", 3)
    moved = {name for name in flight.channels if not np.array_equal(flight[name], rough[name])}
    assert moved == {"true_airspeed", "total_pressure"}
    change = rough["true_airspeed"] - flight["true_airspeed"]
    assert np.std(change) == pytest.approx(gust_deviation(rough.case), rel=0.35)
    assert np.array_equal(
        rough["total_pressure"], with_gusts(flight, "moderate", 3)["total_pressure"]
    )
    assert np.array_equal(with_gusts(flight, "none", 3)["total_pressure"], flight["total_pressure"])


def test_one_draw_serves_flights_of_any_rate(smooth_flights):
    flight = smooth_flights["circle"]
    half = replace(
        flight,
        channels={name: values[::2] for name, values in flight.channels.items()},
        segment=flight.segment[::2],
        on_condition=flight.on_condition[::2],
    )
    gusts, again = (
        with_gusts(f, "light", 3)["true_airspeed"] - f["true_airspeed"] for f in (flight, half)
    )
    np.testing.assert_allclose(again, gusts[::2], atol=1e-12)


FEW = ["plan", "--maneuver", "figure_eight,step_both_ways", "--draws", "2", "--search", "0"]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The exit code, the document and the folder of one plan."""
    folder, said = tmp_path_factory.mktemp("plan"), StringIO()
    asked = ["--want-kt", "0.1", "--minutes", "12", "--box-nm", "12", "--out", str(folder)]
    with redirect_stdout(said):
        code = main([*FEW, "--json", *asked])
    return code, json.loads(said.getvalue()), folder


def test_a_page_and_a_case_are_written(written):
    code, _, folder = written
    assert code == DONE
    page = (folder / "plan.html").read_text(encoding="utf-8")
    axes = ("mean ±2σ of the curve [kt]", "north [nmi]")
    case = read_case(folder / "plan.toml")
    best = f"Fly the {case.maneuver.replace('_', ' ')}"
    for text in ("the minutes recorded", *axes, "figure eight", best):
        assert text in page
    assert "log scale" not in page
    assert "http" not in page.replace("http://www.w3.org", "")
    assert case.turbulence == "light"


def test_the_document_has_units_and_the_ranking(written):
    _, document, _ = written
    assert document["best"] == "figure_eight"
    assert document["best_without_steep_turns"] == "step_both_ways"
    first, second = document["forecasts"]
    assert first["minutes_for_want"] == first["flights_for_want"] * first["minutes"]
    assert first["minutes_for_want"] < second["minutes_for_want"]
    assert 0.1 < first["two_sigma_kt"] < 0.3
    assert len(first["curve"]) == 13


def test_a_plan_in_a_pipe_says_how_far_it_is(monkeypatch, capsys):
    """A line for each maneuver and each flight of the search, were they all 20 s apart."""
    clock = count(0.0, 20.0)
    monkeypatch.setattr("pitotbench.campaigns.progress.monotonic", lambda: next(clock))
    assert main(["plan", "--maneuver", "rapid_decel", "--draws", "2", "--search", "2"]) == DONE
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "pitotbench: flying: 1 of 3"
    assert len(lines) >= 3


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--das", "fast"], "unknown data system"),
        (["--speeds-kt", "100"], "LOW,HIGH"),
        (["--maneuver", "looping"], "unknown maneuver"),
        (["--wind-kt", "-3"], "0 to 100 kt"),
        (["--wind-kt", "nan"], "--wind-kt"),
        (["--wind-from-deg", "nan"], "--wind-from-deg"),
        (["--turbulence", "severe"], "turbulence"),
        (["--error-location", "wing"], "--error-location"),
        (["--receiver-height-m", "0.3"], "WHITE,SLOW"),
        (["--receiver-height-m=-1,2"], "from 0 to 1000 m"),
        (["--vertical-velocity", "yes"], "--vertical-velocity"),
    ],
)
def test_bad_flags_are_one_line(flags, says, capsys):
    assert main(["plan", *flags]) == BAD_INPUT
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


def test_flags_state_the_receiver_and_the_location_of_the_error():
    flags = "--error-location static --receiver-height-m 0.3,2 --vertical-velocity recorded"
    request = request_of(command_line().parse_args(["plan", *flags.split()]))
    assert request.base.pressure_error.location == "static"
    assert (request.das.altitude_noise, request.das.altitude_drift) == (0.3, 2.0)
    assert has_velocity_down(request.das)
    assert request.base.das == request.das  # the case that is written flies the same receiver
