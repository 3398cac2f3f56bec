"""Cards written by hand: published examples, coverage on synthetic cards, slips of the pencil."""

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration.hand_cards import (
    DEG,
    FT,
    KT,
    STEPS,
    make_card,
    spoil,
    true_airspeed_kt,
    with_slips,
)

from pitotbench.calibration.card_model import USUAL_NOISE, CardModel
from pitotbench.calibration.card_slips import find_slips
from pitotbench.calibration.hand_card import reduce_card
from pitotbench.calibration.options import USUAL
from pitotbench.cli.app import main
from pitotbench.logbook.points_table import read_points

NAMES = ("point", "configuration", "indicated_airspeed_kt", "pressure_altitude_ft", "air_temperature_degc",
         "ground_speed_kt", "track_deg")  # fmt: skip


def write(path, rows, names=NAMES):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])
    return path


def as_rows(card):
    return [
        (leg.point, leg.configuration, round(leg.indicated_airspeed / KT), round(leg.pressure_altitude / FT),
         round(leg.air_temperature - 273.15), round(leg.ground_speed / KT), round(leg.track / DEG))
        for leg in card.legs
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("speeds", "tracks", "airspeed", "spread", "wind"),
    [
        ([178, 185, 188, 184], [178, 82, 355, 265], 183.7267, 0.8271, None),
        ([140, 112, 120], [192, 283, 20], 129.9985, None, (20.63, 314.76)),  # Gray 1998
    ],
)
def test_published_examples_to_the_last_digit(
    tmp_path, capsys, speeds, tracks, airspeed, spread, wind
):
    rows = [
        ("1", "clean", 150, 5000, 5, speed, track)
        for speed, track in zip(speeds, tracks, strict=True)
    ]
    assert main(["fixed-speed", str(write(tmp_path / "points.csv", rows)), "--json"]) == 0
    (point,) = json.loads(capsys.readouterr().out)["points"]
    assert point["true_airspeed_kt"] == pytest.approx(airspeed, abs=5e-5)
    assert point["spread_kt"] == (None if spread is None else pytest.approx(spread, abs=5e-5))
    if wind:
        assert (point["wind_speed_kt"], point["wind_from_deg"]) == pytest.approx(wind, abs=5e-3)


def test_the_correction_is_that_of_the_true_airspeed(tmp_path):
    """Without wind every leg says it: 6 kt at 100 KIAS, 8,000 ft, +3 °C; unequal airspeeds leave no
    trace.
    """
    rows = []
    for held, track in ((100, 10), (104, 130), (97, 250)):
        speed = true_airspeed_kt(held, 6.0, 8000.0, 276.15)
        rows.append(("a", "flaps", held, 8000, 3, f"{speed:.6f}", track))
    legs, steps = read_points(write(tmp_path / "points.csv", rows))
    (point,) = reduce_card(legs, steps).points
    assert point.correction / KT == pytest.approx(6.0, abs=0.02)
    assert point.wind_speed / KT == pytest.approx(0.0, abs=0.05)
    # q_c rises by 204 Pa from 100 to 106 kt; the static source reads as much too high: 71 ft at 9.4
    # Pa a meter.
    assert point.altitude_correction / FT == pytest.approx(71.0, abs=3.0)
    assert point.legs == 3


SLIPS = {  # seed: row, what is written wrong; what was meant is what stood there
    2001: (
        2,
        "track",
        lambda v: v + 400 if v < 100 else v + 360,
    ),  # 439 for 79: a digit too many, no track at all
    2002: (7, "track", lambda v: float(str(round(v))[:-1] or 0)),  # a digit lost
    2003: (11, "track", lambda v: (v + 180) % 360),  # the reciprocal
    2004: (
        5,
        "ground_speed",
        lambda v: float("".join([*str(round(v))[:-2], *str(round(v))[:-3:-1]])),
    ),  # exchanged
    2005: (14, "ground_speed", lambda v: v + 20),  # a digit misread
    2006: (3, "ground_speed", lambda v: v - 10),
    2007: (9, "indicated_airspeed", lambda v: v + 20),
    2008: (18, "track", lambda v: (v + 100) % 360),
    2009: (1, "ground_speed", lambda v: v * 10),  # a zero too many
    2010: (12, "track", lambda v: (v + 30) % 360),
}


def test_ten_slips_of_the_pencil():
    """At least nine of ten are named by their row, and most with what was meant."""
    units = {"track": DEG, "ground_speed": KT, "indicated_airspeed": KT}
    named = meant = 0
    for seed, (row, field, slip) in SLIPS.items():
        card = make_card(seed)
        right = round(getattr(card.legs[row - 1], field) / units[field])
        wrong = spoil(card, row, **{field: slip(right)})
        model, found = find_slips(wrong.legs, STEPS, USUAL)
        named += [each.row for each in found] == [row]
        meant += any(each.row == row and f" {right}" in each.probably for each in found)
        assert model.struck.sum() == len(found)
    assert named >= 9
    assert meant >= 6


def test_a_leg_that_says_nothing_is_predicted_on_a_long_card_too():
    """On a calm day, by the dense covariance of the others."""
    noise = USUAL_NOISE + np.log(0.3)
    card = make_card(91, points=12)
    rows = np.array([3, 25])
    model = CardModel(card.legs, STEPS, USUAL, frozenset(map(int, rows)))
    linear, passed = model.linear, model.wandered(noise)
    wind = 25.0**2 * np.exp(-np.abs(passed[:, None] - passed) / (2.0 * 25.0**2))
    white = linear.reading + np.exp(2.0 * noise[2])
    dense = wind * (linear.along @ linear.along.T) + np.diag(white)
    columns = model.problem.regressors[: len(white)]
    heard = np.setdiff1d(np.arange(len(white)), rows - 1)
    rivals = []
    for precision in model.problem.rivals:
        every = dense + (columns / precision) @ columns.T
        own, there = every[np.ix_(heard, heard)], every[np.ix_(heard, rows - 1)]
        seen, weights = linear.observed[heard], np.linalg.solve(own, there)
        variance = np.diag(every)[rows - 1] - np.sum(there * weights, axis=0)
        off = (linear.observed[rows - 1] - seen @ weights) / np.sqrt(variance)
        rivals.append((-np.linalg.slogdet(own)[1] - seen @ np.linalg.solve(own, seen), off))
    surprise = max(rivals, key=lambda each: each[0])[1]
    assert model.others(noise).surprise[rows - 1] == pytest.approx(surprise, abs=0.05)


def test_a_number_that_no_slip_makes_is_refused_in_words():
    card = make_card(2011)
    found = reduce_card(spoil(card, 4, ground_speed=17000.0).legs, STEPS)
    assert [slip.row for slip in found.slips] == [4]
    assert "17000 kt cannot be" in found.slips[0].words


def test_slips_are_found_in_any_order_of_the_tracks():
    """Each point of the card flies its tracks in an order of its own."""
    named = 0
    for seed, (row, field, slip) in SLIPS.items():
        card = make_card(seed)
        right = round(getattr(card.legs[row - 1], field) / (DEG if field == "track" else KT))
        wrong = spoil(card, row, **{field: slip(right)}).legs
        mixed = [
            leg
            for i, first in enumerate(range(0, 20, 4))
            for leg in np.roll(np.array(wrong[first : first + 4]), i)
        ]
        _, found = find_slips(mixed, STEPS, USUAL)
        named += [each.row for each in found] == [row]
    assert named >= 8


@pytest.mark.parametrize("seed", [8001, 8016, 8017])
def test_two_slips_that_hide_each_other_are_named(seed):
    """Under the noise of all legs, which is theirs, neither of them or another one stands out."""
    legs, rows = with_slips(make_card(seed, legs=3, points=8).legs[:22], seed, 2)
    _, found = find_slips(legs, STEPS, USUAL)
    assert {each.row for each in found} == rows


def test_legs_of_a_pilot_who_keeps_no_tracks_are_right():
    """Three legs in ten are flown some 25° off the others' tracks, in no order; none is a slip."""
    for seed in range(7124, 7131):
        card = make_card(seed, points=6, loose=0.3)
        _, found = find_slips(card.legs, STEPS, USUAL)
        assert not found, seed


def test_the_likelihood_of_a_card_is_that_of_its_covariance():
    """Noise and curves by the calibration's own algebra, and by the dense covariance of the legs,
    say the same; so does a leg left out.
    """
    legs = make_card(4001).legs
    model = CardModel(legs, STEPS, USUAL)
    linear, columns = model.linear, model.problem.regressors[: len(legs)]
    passed = model.wandered(USUAL_NOISE)
    assert passed[[0, 3, 4, 19]] == pytest.approx(KT**2 * np.array([0.0, 0.75, 7.25, 29.75]))
    wind = 25.0**2 * np.exp(-np.abs(passed[:, None] - passed) / (2.0 * 25.0**2))
    dense = wind * (linear.along @ linear.along.T) + np.diag(model.white(USUAL_NOISE))
    everyone = [dense + (columns / precision) @ columns.T for precision in model.problem.rivals]
    heights = [
        -0.5
        * (np.linalg.slogdet(each)[1] + linear.observed @ np.linalg.solve(each, linear.observed))
        for each in everyone
    ]
    likeliest = everyone[int(np.argmax(heights))]
    solved = np.linalg.solve(likeliest, linear.observed)
    surprise = solved / np.sqrt(np.diag(np.linalg.inv(likeliest)))
    assert model.others(USUAL_NOISE).surprise == pytest.approx(surprise, abs=0.03)
    struck = CardModel(legs, STEPS, USUAL, frozenset({legs[7].row}))
    assert struck.others(USUAL_NOISE).surprise[7] == pytest.approx(surprise[7], abs=0.05)
    gust = USUAL_NOISE + np.array([0.0, 0.0, 1.0])
    rougher = [
        each + (np.exp(2.0) - 1.0) * np.exp(2.0 * USUAL_NOISE[2]) * np.eye(20) for each in everyone
    ]
    change = np.logaddexp.reduce(
        [
            -0.5
            * (
                np.linalg.slogdet(each)[1]
                + linear.observed @ np.linalg.solve(each, linear.observed)
            )
            for each in rougher
        ]
    ) - np.logaddexp.reduce(heights)
    prior = -0.5 / np.log(2.2) ** 2
    assert model.log_evidence(gust) - model.log_evidence(USUAL_NOISE) == pytest.approx(
        change + prior, abs=0.1
    )


def test_a_card_without_points_is_grouped_by_airspeed(tmp_path):
    rows = [row[2:] for row in as_rows(make_card(2015))]
    legs, _ = read_points(write(tmp_path / "points.csv", rows, NAMES[2:]))
    points = {leg.point: [] for leg in legs}
    for leg in legs:
        points[leg.point].append(leg.row)
    assert sorted(points.values()) == [list(range(i, i + 4)) for i in range(1, 21, 4)]


def test_a_leg_that_cannot_be_is_named_and_the_rest_is_used(tmp_path, capsys):
    card = make_card(2011)
    rows = as_rows(card)
    rows[4] = (*rows[4][:-1], 439)
    path = write(tmp_path / "points.csv", rows)
    assert main(["fixed-speed", str(path), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["slips"][0]["row"] == 5
    assert "439° cannot be" in answer["warnings"][0]
    point = next(p for p in answer["points"] if p["point"] == rows[4][0])
    assert point["legs"] == 3
    assert point["correction_kt"] is not None
    assert "without row 5" in point["remark"]
    table = tmp_path / "curves.html"
    right = write(tmp_path / "right.csv", as_rows(card))
    assert main(["fixed-speed", str(path), str(right), "--table", str(table)]) == 0
    assert "row 5" in capsys.readouterr().out
    # Once, and of the card that it is of.
    assert table.read_text(encoding="utf-8").count("439° cannot be") == 1


def test_numbers_with_a_zero_too_many_are_left_out_whatever_they_are():
    """1,420 kt of airspeed are beyond the air's own functions."""
    card = make_card(31116, legs=3, points=4)
    wrong = spoil(spoil(card, 8, ground_speed=1280.0), 12, indicated_airspeed=1420.0)
    found = reduce_card(wrong.legs, STEPS)
    assert {slip.row for slip in found.slips} == {8, 12}
    assert "an indicated airspeed of 1420 kt cannot be" in found.warnings[1]


def test_two_legs_left_or_one_track_are_no_point_but_serve_the_curve(tmp_path):
    found = reduce_card(spoil(make_card(2012, legs=3), 4, track=439.0).legs, STEPS)
    point = next(p for p in found.points if p.point == "2")
    assert point.correction is None
    assert "2 legs left" in point.remark
    assert len(found.curves["clean"].correction) == 13
    rows = [("1", "c", 100, 5000, 5, speed, 90) for speed in (110, 111, 110)]
    (point,) = reduce_card(*read_points(write(tmp_path / "points.csv", rows))).points
    assert point.correction is None
    assert "60° apart" in point.remark


def test_a_curve_for_each_configuration():
    clean, flaps = make_card(2013).legs, make_card(2014).legs
    other = [
        replace(leg, row=leg.row + 20, point=f"f{leg.point}", configuration="flaps")
        for leg in flaps
    ]
    found = reduce_card([*clean, *other], STEPS)
    assert set(found.curves) == {"clean", "flaps"}
    assert len(found.points) == 10


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ([("1", "c", 100, 5000, 5, 110, 90)] * 2, "at least three legs"),
        ([("1", "c", 100, 5000, "", 110, 90)] * 4, "row 1: a number is missing"),
        ([("1", "c", 100, 5000, 5, 110, "north")] * 4, "'north' is not a number"),
        (None, "missing columns pressure_altitude_ft, air_temperature_degc"),
    ],
)
def test_cards_that_cannot_be_read(tmp_path, capsys, rows, words):
    path = tmp_path / "points.csv"
    card = (
        write(path, rows) if rows else write(path, [(1, 100)], ("point", "indicated_airspeed_kt"))
    )
    assert main(["fixed-speed", str(card)]) == 2
    assert words in capsys.readouterr().err


def test_the_headings_of_the_sheet_are_those_of_the_card(tmp_path):
    """What was filled in on paper and typed as it stands is read as the same card."""
    sheet = tmp_path / "sheet.html"
    assert main(["fixed-speed", "--sheet", str(sheet)]) == 0
    text = sheet.read_text(encoding="utf-8")
    assert text.count("<tr") == 25
    assert all(name in text for name in NAMES)
    headings = [h.replace("<br>", " ") for h in re.findall(r"<th>(.*?)</th>", text)]
    rows = [
        ("1", "clean", 150, 5000, 5, speed, track)
        for speed, track in ((140, 192), (112, 283), (120, 20))
    ]
    typed = write(tmp_path / "typed.csv", [(*row, "") for row in rows], headings)
    assert read_points(typed) == read_points(write(tmp_path / "points.csv", rows))
    assert main(["fixed-speed", "--sheet", str(tmp_path / "sheet.pdf")]) == 2


def test_the_sheet_of_a_plan_holds_its_legs(tmp_path, capsys):
    sheet = tmp_path / "sheet.html"
    assert main(["plan", "--by-hand", "--minutes", "60", "--json", "--sheet", str(sheet)]) == 0
    fly, text = json.loads(capsys.readouterr().out)["fly"], sheet.read_text(encoding="utf-8")
    wanted = [f"{v:.0f} KIAS, {t:03.0f}°" for v in fly["airspeeds_kt"] for t in fly["tracks_deg"]]
    assert re.findall(r"<td>(\d+ KIAS, \d+°)</td>", text) == wanted


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        ("--by-hand --want-kt -1", "--want-kt"),
        ("--by-hand --speeds-kt 160,100", "--speeds-kt"),
        ("--by-hand --speeds-kt 1,2,3", "--speeds-kt"),
        ("--sheet sheet.html", "--sheet"),
        ("--by-hand --sheet sheet.txt", "must end in .html"),
    ],
)
def test_plans_by_hand_that_make_no_sense(flags, says, capsys):
    assert main(["plan", *flags.split()]) == 2
    assert says in capsys.readouterr().err
