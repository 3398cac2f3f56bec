"""A handbook beside the curve: the same in the terminal, in JSON, on the page and in Python; and as
an airspeed indicator of a simulator.
"""

import csv
import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from tests.calibration.test_long_flights import circling

from pitotbench import calibrate, read_log, write_log
from pitotbench.cli.app import DONE, main
from pitotbench.records.calibration import PublishedCurve
from pitotbench.show.handbook import handbook_advice, handbook_sentence
from pitotbench.timeline import minutes_text
from pitotbench.units import KNOT

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A log, its calibration, and a handbook that says the log's own curve but for 5 kt at its
    lower end.
    """
    folder = tmp_path_factory.mktemp("handbook")
    path = folder / "flight.csv"
    write_log(circling(900.0), path)
    curve = calibrate(read_log(path)).curve
    speed, right = curve.indicated_airspeed_kt, curve.calibrated_airspeed_kt
    rows = [
        (speed[0], right[0] - 5.0),
        *zip(speed[len(speed) // 2 :], right[len(speed) // 2 :], strict=True),
    ]
    book = folder / "poh.csv"
    book.write_text(
        "KIAS,KCAS\n" + "".join(f"{i:.3f},{c:.3f}\n" for i, c in rows), encoding="utf-8"
    )
    return path, book, curve


def test_every_voice_compares_the_curve_with_the_handbook_alike(flown, tmp_path, capsys):
    path, book, curve = flown
    page, card = tmp_path / "page.html", tmp_path / "card.csv"
    asked = ["calibrate", str(path), "--handbook", str(book)]
    assert main([*asked, "--json"]) == DONE
    found = json.loads(capsys.readouterr().out)
    (sentence,) = (each["words"] for each in found["handbook"])
    assert main([*asked, "--report", str(page), "--card", str(card)]) == DONE
    assert sentence in " ".join(capsys.readouterr().out.split())
    shown = unescape(page.read_text(encoding="utf-8"))
    assert sentence in shown
    assert "handbook" in shown.split("<svg", 1)[1].split("</svg>", 1)[0]
    by_python = calibrate(str(path), handbook=book)
    (book,) = by_python.curve.published
    assert handbook_sentence(by_python.curve, book) == sentence
    at_low_end = [
        found["curve"][0]["handbook_correction_kt"],
        float(next(csv.DictReader(card.open(encoding="utf-8")))["handbook_correction_kt"]),
        by_python.curve.published[0].correction[0] / KNOT,
    ]
    assert at_low_end == pytest.approx([curve.correction_kt[0] - 5.0] * 3, abs=2e-3)
    assert f"at {curve.indicated_airspeed_kt[0]:.0f} KIAS it is" in sentence


def test_where_a_handbook_differs_the_parts_flown_there_are_named(flown):
    """Of two parts, one below and one above the middle airspeed, the slow one is named where the
    table differs below it.
    """
    path, *_ = flown
    found = calibrate(path)
    curve, time = found.curve, found.residuals.time
    speed = np.sort(found.residuals.indicated_airspeed)
    split = 0.5 * float(time[0] + time[-1])
    begin, middle, end = (minutes_text(t - found.log_start) for t in (time[0], split, time[-1]))
    halves = ((float(time[0]), split), (split, float(time[-1])))
    apart = replace(
        found, residuals=replace(found.residuals, indicated_airspeed=speed), parts=halves
    )
    indicated = curve.indicated_airspeed
    slow = indicated < np.median(speed)

    def advice(result, wrong):
        table = PublishedCurve("poh.csv", "", indicated, indicated + curve.correction + wrong)
        return handbook_advice(result, table)

    assert advice(apart, np.zeros(len(slow))) == ""
    said = advice(apart, 9.0 * slow)
    assert said.startswith("1 of the 2 parts used are flown mostly where the two differ")
    assert f"(--without {begin}-{middle}), or fly {indicated[0] / KNOT:.0f} to " in said
    assert f"(--without {middle}-{end})" in advice(apart, 9.0 * ~slow)
    whole = advice(replace(apart, parts=((float(time[0]), float(time[-1])),)), 9.0 * slow)
    assert whole.startswith(f"Fly {indicated[0] / KNOT:.0f} to ")
    assert "--without" not in whole


def test_a_name_of_a_handbook_is_no_formula_and_no_markup(flown, tmp_path):
    path, book, _ = flown
    rows = book.read_text(encoding="utf-8").splitlines()[1:]
    name = r"$\bad{$ <script>"
    named = tmp_path / "poh.csv"
    named.write_text(
        "\n".join(["configuration,KIAS,KCAS", *(f"{name},{row}" for row in rows)]), encoding="utf-8"
    )
    page = tmp_path / "page.html"
    asked = ["calibrate", str(path), "--handbook", str(named), "--report", str(page)]
    assert main(asked) == DONE
    text = page.read_text(encoding="utf-8")
    assert name not in text
    assert name in unescape(text)


def test_a_curve_without_a_handbook_has_no_word_of_one(flown, capsys):
    path, *_ = flown
    assert main(["calibrate", str(path), "--json"]) == DONE
    found = json.loads(capsys.readouterr().out)
    assert "handbook" not in found
    assert "handbook_correction_kt" not in found["curve"][0]


def test_a_handbook_becomes_an_airspeed_indicator(flown, tmp_path, capsys):
    _, book, _ = flown
    out = tmp_path / "asi.xml"
    assert main(["aircraft", "indicator", str(book), "--out", str(out)]) == DONE
    rows = ET.parse(out).getroot().find(".//tableData").text.split()
    with book.open(encoding="utf-8") as table:
        first = next(csv.DictReader(table))
    calibrated, indicated = float(rows[2]), float(rows[3])
    assert (indicated, calibrated) == pytest.approx((float(first["KIAS"]), float(first["KCAS"])))
    assert "written" in capsys.readouterr().out


def test_a_table_of_the_other_kind_is_named(flown, tmp_path, capsys):
    path, book, _ = flown
    figures = tmp_path / "figures.csv"
    figures.write_text("figure,calibrated_airspeed_kt\nstall,48\n", encoding="utf-8")
    several = tmp_path / "several.csv"
    several.write_text("KIAS,KCAS up,KCAS down\n60,61,62\n80,81,82\n", encoding="utf-8")
    for arguments, says in (
        (["calibrate", str(path), "--handbook", str(figures)], "aircraft performance"),
        (["aircraft", "performance", "c172p", "--handbook", str(book)], "calibrate LOG --handbook"),
        (["calibrate", str(book)], "--handbook"),
        (["aircraft", "indicator", str(book)], "--out"),
        (["aircraft", "indicator", str(several), "--out", str(tmp_path / "a.xml")], "up, down"),
        (["aircraft", "check", "c172p", "--out", "a.xml"], "no flag of `aircraft check`"),
    ):
        assert main(arguments) == 2
        assert says in capsys.readouterr().err
