"""A file with two flights: one curve for both, a wind for each, told as text, as JSON and on the
page.
"""

import json
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from shutil import make_archive

import numpy as np
import pytest

from pitotbench import BadInputError, FlightLog, write_log
from pitotbench.bench import questions
from pitotbench.bench.calibrations import options_of
from pitotbench.calibration import calibrate, calibrate_flights
from pitotbench.calibration import flights as flights_module
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns.flights import sense, true_correction
from pitotbench.cli.app import DONE, main
from pitotbench.units import KNOT

NORTH, EAST = 5.0, -3.0  # m/s: the second flight meets so much more wind
PAUSE = 1800.0  # s


def after(first: FlightLog, second: FlightLog, pause: float) -> FlightLog:
    """Two logs in one, the second so many seconds after the first."""
    shifted = replace(second, time=second.time - second.time[0] + first.time[-1] + pause)
    return FlightLog(
        **{
            name: np.concatenate([v, shifted.channels()[name]])
            for name, v in first.channels().items()
        },
        header=first.header,
    )


@pytest.fixture(scope="module")
def flights(light_flights):
    first, second = (sense(light_flights[name], "20/1") for name in ("rapid_decel", "circle"))
    more = {
        "velocity_north": second.velocity_north + NORTH,
        "velocity_east": second.velocity_east + EAST,
    }
    return first, replace(second, **more)


@pytest.fixture(scope="module")
def path(flights, tmp_path_factory):
    path = tmp_path_factory.mktemp("several") / "two.csv"
    write_log(after(*flights, PAUSE), path)
    return path


@pytest.fixture(scope="module")
def documents(path):
    printed = StringIO()
    with redirect_stdout(printed):
        assert main(["calibrate", str(path), "--json"]) == DONE
    return json.loads(printed.getvalue())


def test_one_curve_covers_and_is_narrower_than_that_of_each_alone(
    documents, flights, light_flights
):
    first, second = documents
    for point, other in zip(first["curve"], second["curve"], strict=True):
        assert {**point, "white_two_sigma_kt": 0.0} == {
            **other,
            "white_two_sigma_kt": 0.0,
        }  # of each log's own fit
    speed, correction, bound = (
        np.array([point[key] for point in first["curve"]])
        for key in ("indicated_airspeed_kt", "correction_kt", "two_sigma_kt")
    )
    truth = true_correction(light_flights["circle"].case.pressure_error, speed * KNOT) / KNOT
    assert np.mean(np.abs(correction - truth) <= bound) >= 0.9
    for log in flights:
        alone = calibrate(log, CalibrationOptions(model="smooth")).curve
        assert np.mean(bound) < np.mean(alone.two_sigma) / KNOT


def test_each_flight_has_its_own_wind_and_says_which_it_is(documents):
    first, second = (document["wind"] for document in documents)
    for axis, more in (("north", NORTH), ("east", EAST)):
        bound = np.hypot(first[f"{axis}_two_sigma_kt"], second[f"{axis}_two_sigma_kt"])
        assert second[f"{axis}_kt"] - first[f"{axis}_kt"] == pytest.approx(
            more / KNOT, abs=1.5 * bound
        )
    first, second = (document["flight"] for document in documents)
    assert (first["number"], second["number"], first["of"], first["flights_of_the_curve"]) == (
        1,
        2,
        2,
        2,
    )
    assert second["from_s"] - first["to_s"] == pytest.approx(PAUSE)


def test_text_and_page_say_which_flight_it_is(path, capsys, tmp_path):
    page = tmp_path / "page.html"
    assert main(["calibrate", str(path), "--report", str(page)]) == DONE
    text, html = capsys.readouterr().out, page.read_text(encoding="utf-8")
    for number in (1, 2):
        assert f"two.csv, flight {number} of 2" in text
        assert f"two.csv, flight {number} of 2" in html
    assert text.count("one curve from 2 flights") == html.count("one curve from 2 flights") == 2


def test_a_flight_that_determines_nothing_is_left_out_and_said(flights):
    first, second = flights
    leg = second.select(np.arange(60 * 20))
    three = after(after(first, leg, PAUSE), second, PAUSE)
    found = calibrate_flights([three])
    assert [(each.number, each.count, each.joined) for each in found] == [(1, 3, 2), (3, 3, 2)]
    assert all(
        any("flight 2 of this log" in text for text in each.calibration.warnings) for each in found
    )


def test_legs_that_are_recorded_apart_are_one_flight(flights):
    """Each stretch lies on one heading, so none gives a wind alone; together they do."""
    log = flights[0]
    track = np.arctan2(log.velocity_east, log.velocity_north)
    out, back = (np.flatnonzero(sign * np.cos(track - track[0]) > 0.97) for sign in (1.0, -1.0))
    parted = after(log.select(out[out < back[0]]), log.select(back), PAUSE)
    (found,) = calibrate_flights([parted])
    assert (found.number, found.count, len(found.log)) == (1, 1, len(parted))


@pytest.fixture
def card(flights, tmp_path):
    """A folder with two flights, a text and a broken log."""
    folder = tmp_path / "card"
    (folder / "day 2").mkdir(parents=True)
    for name, log in zip(("one.csv", "day 2/two.csv"), flights, strict=True):
        write_log(log, folder / name)
    (folder / "broken.csv").write_text("time_s,impact_pressure_pa\n0,1\n")
    (folder / "remarks.md").write_text("no log")
    return folder


def test_a_zip_gives_what_its_logs_give_together(card, flights, capsys):
    packed = Path(make_archive(str(card), "zip", card))
    assert main(["calibrate", str(packed), "--json"]) == DONE
    out, told = capsys.readouterr()
    documents = json.loads(out)
    assert [each["log"] for each in documents] == ["two.csv", "one.csv"]
    assert "3 logs, 2 with an answer" in told
    lines = told.splitlines()[:3]
    assert [line.split(":")[0] for line in lines] == ["broken.csv", "two.csv", "one.csv"]
    assert "left out: missing columns" in lines[0]
    assert all("KIAS" in line and "±" in line for line in lines[1:])
    together = calibrate_flights([flights[1], flights[0]], options_of())[0].calibration.curve
    found = [point["correction_kt"] for point in documents[0]["curve"]]
    np.testing.assert_allclose(found, together.correction_kt, atol=1e-6)


def test_python_answers_a_folder_as_the_command_does_with_one_fit_a_log_and_range(
    card, capsys, monkeypatch
):
    assert main(["calibrate", str(card), "--json"]) == DONE
    documents = json.loads(capsys.readouterr().out)
    fits: list[float] = []
    reduce_log = flights_module.reduce_log

    def counted(log, *rest):
        fits.append(float(log.time[-1]))
        return reduce_log(log, *rest)

    monkeypatch.setattr(flights_module, "reduce_log", counted)
    found = questions.calibrate(card)
    assert len(found) == len(documents) == len(set(fits)) == 2
    assert len(fits) <= 3  # a log of fewer speeds once more, over the range of both
    for mine, theirs in zip(found, documents, strict=True):
        told = [point["correction_kt"] for point in theirs["curve"]]
        np.testing.assert_allclose(mine.curve.correction_kt, told, atol=1e-6)
        words = "logs without an answer: broken.csv: missing columns"
        assert any(text.startswith(words) for text in mine.warnings)
        assert any(text.startswith(words) for text in theirs["warnings"])


def test_python_says_why_a_folder_has_no_answer(card):
    for name in ("one.csv", "day 2/two.csv"):
        (card / name).write_text("time_s,altitude_m\n0,1\n1,2\n")
    with pytest.raises(BadInputError, match=r"none of its logs .*broken\.csv: missing columns"):
        questions.calibrate([card])


def test_flights_of_two_airplanes_in_a_folder_have_a_curve_each(card, flights, capsys):
    (card / "broken.csv").unlink()
    other = replace(flights[0], header={"airplane": "N2"})
    write_log(replace(flights[1], header={"airplane": "N1"}), card / "day 2/two.csv")
    write_log(other, card / "one.csv")
    assert main(["calibrate", str(card), "--json"]) == DONE
    documents = json.loads(capsys.readouterr().out)
    alone = calibrate_flights([other], options_of())[0].calibration.curve
    found = [point["correction_kt"] for point in documents[1]["curve"]]
    np.testing.assert_allclose(found, alone.correction_kt, atol=1e-6)


def test_a_folder_without_an_answer_says_why_of_each(card, capsys):
    for name in ("one.csv", "day 2/two.csv"):
        (card / name).write_text("time_s,altitude_m\n0,1\n1,2\n")
    assert main(["calibrate", str(card)]) == 2
    told = capsys.readouterr().err
    assert "none of its logs has an answer" in told
    assert told.count("left out: missing columns") == 3


def test_a_card_of_curves_for_several_airplanes_is_refused(card, flights, tmp_path, capsys):
    for name, log in zip(("one.csv", "day 2/two.csv"), flights, strict=True):
        write_log(replace(log, header={"airplane": name}), card / name)
    out = tmp_path / "card.csv"
    assert main(["calibrate", str(card), "--card", str(out)]) == 2
    assert "--card holds one curve, and there would be 2" in capsys.readouterr().err
    assert not out.exists()
