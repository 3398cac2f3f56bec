"""One answer of one log: from Python and from the command, whatever is printed, with its doubts and
with one residual.
"""

import csv
import json
import re
import shutil
from contextlib import redirect_stdout
from dataclasses import replace
from functools import cache
from html import unescape
from io import StringIO

import numpy as np
import pytest
from matplotlib.figure import Figure
from tests.calibration import trajectories as fixture
from tests.calibration.test_long_flights import circling
from tests.shared_data import real_log
from tests.show.test_voices import beside
from tests.show.voices import contradictions, left_in_knots

from pitotbench import (
    BadInputError,
    CalibrationOptions,
    Case,
    calibrate,
    fly,
    inspect,
    plan,
    read_log,
    reconcile,
    sense,
    write_case,
    write_log,
)
from pitotbench.bench.forecasts import PlanRequest
from pitotbench.cli.app import DONE, main
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.pressure_error.models import PressureErrorCurve
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.records.log import Provenance
from pitotbench.show import curves
from pitotbench.show.calibration import doubts_of
from pitotbench.show.calibration_json import calibration_json
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.columns import json_text
from pitotbench.show.curve_rows import points_json
from pitotbench.show.deliverables import table_text
from pitotbench.show.inspection import inspection_json, inspection_tree
from pitotbench.show.legs import card_sheet
from pitotbench.units import KNOT

pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")

C172S = ("garmin", "c172s-g1000-2011.csv.gz")
SEAWAY = ("seaway", "differential_pressure_0.csv")
THEIRS = {
    "time": "time_s",
    "qc": "impact_pressure_pa",
    "ps": "static_pressure_pa",
    "oat": "air_temperature_k",
    "vn": "velocity_north_mps",
    "ve": "velocity_east_mps",
}
MAPPING = (
    "[columns]\n"
    + "".join(f'{theirs} = "{ours}"\n' for theirs, ours in THEIRS.items())
    + '[calibrate]\nmodel = "bias"\nground_speed_min = 45.0\naccuracies = {temperature_k = 4.0}\n'
)


def told(capsys, *arguments):
    """What a command prints."""
    assert main([str(each) for each in arguments]) == DONE
    return capsys.readouterr().out


def require_same(found, document):
    speed, correction, bound = (
        [point[key] for point in document["curve"]]
        for key in ("indicated_airspeed_kt", "correction_kt", "two_sigma_kt")
    )
    np.testing.assert_allclose(found.curve.indicated_airspeed_kt, speed, atol=1e-6)
    np.testing.assert_allclose(found.curve.correction_kt, correction, atol=1e-6)
    np.testing.assert_allclose(found.curve.two_sigma_kt, bound, atol=1e-6)
    assert found.residual_two_sigma / KNOT == pytest.approx(document["residual_two_sigma_kt"])
    assert [each.kind for each in found.disagreements] == [
        each["kind"] for each in document["disagreements"]
    ]
    assert len(found.points) == len(document["fixed_speed"])


@pytest.fixture(scope="module")
def foreign(tmp_path_factory):
    """A log with the names of a foreign recorder, and the mapping for it with its choices."""
    folder = tmp_path_factory.mktemp("foreign")
    log = fixture.fly(fixture.circles(5), 5, 5, fixture.Air())
    frame = log.to_frame()
    frame["air_temperature_k"] = fixture.AIR_TEMPERATURE
    frame = frame[list(THEIRS.values())].set_axis(list(THEIRS), axis=1)
    frame.to_csv(folder / "theirs.csv", index=False)
    (folder / "theirs.toml").write_text(MAPPING, encoding="utf-8")
    return folder / "theirs.csv", folder / "theirs.toml", frame


def test_the_choices_of_a_mapping_are_kept_however_the_log_is_read(foreign, capsys, tmp_path):
    path, mapping, frame = foreign
    document = json.loads(told(capsys, "calibrate", path, "--mapping", mapping, "--json"))
    assert document["model"] == "bias"
    log = read_log(path, mapping)
    for found in (
        calibrate(path, mapping=mapping),
        calibrate(log),
        calibrate(frame, mapping=mapping),
        calibrate(write_log(log, tmp_path / "ours.parquet")),
    ):
        require_same(found, document)


def test_a_choice_overrides_the_mapping_and_names_no_other_accuracy(foreign, capsys):
    path, mapping, _ = foreign
    flags = ("--model", "linear", "--accuracy", "static_pressure_pa=60", "--wind", "constant")
    document = json.loads(told(capsys, "calibrate", path, "--mapping", mapping, *flags, "--json"))
    accuracies = {each["name"]: each["two_sigma"] for each in document["assumptions"]}
    assert (accuracies["temperature_k"], accuracies["static_pressure_pa"]) == (4.0, 60.0)
    choices = {"model": "linear", "wind": "constant", "accuracies": {"static_pressure_pa": 60.0}}
    require_same(calibrate(path, mapping=mapping, **choices), document)
    require_same(calibrate(path, CalibrationOptions(**choices), mapping=mapping), document)


def test_what_nobody_stated_is_the_same_in_every_function_and_published_options_stay():
    """The stored figures and the keys of the store hang on `CalibrationOptions()`."""
    published = CalibrationOptions()
    assert (published.wind, published.latency) == ("constant", "given")
    assert published == CalibrationOptions(wind="constant", latency="given")
    assert repr(published.wind) == "'constant'"
    log = fixture.fly(fixture.circles(5), 5, 5, fixture.Air())
    choices = {each.name: each.value for each in calibrate(log).provenance.choices}
    assert (choices["wind"], choices["latency"]) == ("checked", "checked")
    for stated in (
        calibrate(log, CalibrationOptions(wind="constant")),
        calibrate(log, wind="constant"),
    ):
        assert {each.name: each.value for each in stated.provenance.choices}["wind"] == "constant"


REAL = {
    "C172S": (C172S, None),
    "seaway": (SEAWAY, "seaway"),
    "CLASS65": (("jmoss", "CLASS65.csv"), "jmoss"),
}


@cache
def answer_of(name):
    """The answer of a real log from its path."""
    place, mapping = REAL[name]
    return calibrate(real_log(*place), mapping=mapping)


def test_python_and_the_command_agree_about_a_real_log(capsys):
    place, mapping = REAL["seaway"]
    path = real_log(*place)
    document = json.loads(told(capsys, "calibrate", path, "--mapping", mapping, "--json"))
    require_same(answer_of("seaway"), document)
    require_same(calibrate(read_log(path, mapping)), document)


def test_a_file_with_two_flights_has_the_curve_of_the_command(tmp_path, capsys):
    first, second = (circling(900.0, seed=seed) for seed in (3, 4))
    parts = {
        name: np.concatenate(
            [values, second.channels()[name] + (2700.0 if name == "time" else 0.0)]
        )
        for name, values in first.channels().items()
    }
    path = write_log(type(first)(**parts), tmp_path / "two.csv")
    documents = json.loads(told(capsys, "calibrate", path, "--json"))
    assert len(documents) == 2
    found = calibrate(path)
    np.testing.assert_allclose(
        found.curve.correction_kt, [point["correction_kt"] for point in documents[0]["curve"]]
    )
    assert found.samples == sum(each["samples"] for each in documents)
    assert [window.begin for window in found.winds] == [
        window["from_s"] for each in documents for window in each["winds"]
    ]
    assert found.residuals.used.sum() == found.samples


def test_inspect_and_reconcile_take_the_mapping_and_its_choices(foreign, capsys, monkeypatch):
    path, mapping, _ = foreign
    out = told(capsys, "inspect", path, "--mapping", mapping, "--json")
    for found in (inspect(path, mapping), inspect(read_log(path, mapping))):
        assert found.model == "bias"
        assert inspection_json(found)["expected"] == json.loads(out)["expected"]
    asked = []

    def reconcile_fully(measured, aircraft, holdout, card, progress, setting, refly, keep, choose):
        asked.append(([each.name for each in measured], setting))
        raise BadInputError("enough")

    monkeypatch.setattr("pitotbench.bench.workflow.reconcile_fully", reconcile_fully)
    static = mapping.with_name("static.toml")
    text = MAPPING.replace('"bias"', '"bias"\nerror_location = "static"\nmach_max = 0.5')
    static.write_text(text, encoding="utf-8")
    with pytest.raises(BadInputError, match="enough"):
        reconcile(path, "none", mapping=static)
    assert main(["reconcile", str(path), "--aircraft", "none", "--mapping", str(static)]) != DONE
    assert asked == [([path.name], AnalysisSetting(static_error=True, mach_max=0.5))] * 2


def test_a_small_airplane_has_the_usual_curve_from_python_as_from_a_file(tmp_path):
    case = Case(aircraft="aerosonde", maneuver="circle")
    (tmp_path / "case.toml").write_text(write_case(case), encoding="utf-8")
    flown = sense(fly(case))
    assert main(["fly", str(tmp_path / "case.toml"), "-o", str(tmp_path / "log.parquet")]) == DONE
    read = read_log(tmp_path / "log.parquet")
    np.testing.assert_allclose(read.impact_pressure, flown.impact_pressure)
    np.testing.assert_allclose(read.velocity_north, flown.velocity_north)
    # A plan for it is one for its speeds.
    request = PlanRequest(case)
    assert request.airspeeds[-1] < 100.0 * KNOT
    assert request.base.pressure_error.reference_pressure < 500.0


def test_a_case_stands_for_the_plan_of_what_it_expects(monkeypatch):
    asked = []

    def forecast(request, maneuver):
        asked.append(request)
        raise BadInputError("enough")

    monkeypatch.setattr("pitotbench.bench.planner.forecast", forecast)
    case = Case(turbulence="light")
    with pytest.raises(Exception, match="no maneuver can be flown"):
        plan(case)
    assert asked[0].base == case


@pytest.fixture(scope="module")
def doubtful(tmp_path_factory):
    """A log with a fixed-speed point off its curve: the first line of its answer, and the files
    that the command writes beside it.
    """
    folder, path = tmp_path_factory.mktemp("doubtful"), real_log(*C172S)
    written = {
        "--report": folder / "page.html",
        "--record": folder / "record.html",
        "--table": folder / "table.html",
        "--card": folder / "card.csv",
    }
    plain, more = StringIO(), StringIO()
    command = ["calibrate", str(path), "--no-altitude"]
    with redirect_stdout(plain):
        assert main(command) == DONE
    flags = [str(each) for pair in written.items() for each in pair]
    with redirect_stdout(more):
        assert main([*command, "-v", *flags]) == DONE
    return plain.getvalue(), more.getvalue(), written, calibrate(path, use_altitude=False)


def test_what_is_asked_for_in_print_changes_no_finding(doubtful):
    plain, more, written, found = doubtful
    doubt = plain.splitlines()[3]  # below the airplane, the correction and the wind
    assert doubt.startswith("Two findings of this log disagree: a fixed-speed point")
    assert more.splitlines()[3] == doubt
    for flag in ("--report", "--record"):
        assert doubt in unescape(written[flag].read_text(encoding="utf-8"))
    (told_in_json,) = calibration_json(found)["disagreements"]
    assert told_in_json["words"].partition(". ")[0] in doubt


def test_whatever_leaves_as_an_answer_carries_its_doubts(doubtful, tmp_path):
    plain, _, written, found = doubtful
    doubt = plain.splitlines()[3]
    curve, doubts = {"": found.curve}, {"": doubts_of(found)}
    texts = {
        "sheet": written["--table"].read_text(encoding="utf-8"),
        "card": written["--card"].read_text(encoding="utf-8"),
        "table as CSV": table_text(".csv", curve, "it", doubts),
        "system": table_text(".xml", curve, "it", doubts),
        "page": written["--report"].read_text(encoding="utf-8"),
        "notebook": found._repr_html_(),
    }
    for name, text in texts.items():
        assert doubt in unescape(text), name
        assert "holds only if the static port is at fault" in unescape(text), name
    assert doubt in repr(found)
    # What is only assumed of the altimeter is not for the cockpit.
    assert "add to the altimeter" not in texts["sheet"]
    assert "altitude_correction" not in texts["table as CSV"]
    rows = list(csv.DictReader(StringIO(texts["card"])))
    assert float(rows[0]["correction_kt"]) == pytest.approx(found.curve.correction_kt[0], abs=1e-3)
    found.write_card(tmp_path / "own.csv")
    assert (tmp_path / "own.csv").read_text(encoding="utf-8") == texts["card"]


def test_every_paper_names_the_airplane_and_the_day(doubtful):
    _, _, written, found = doubtful
    for name in ("--report", "--record", "--table", "--card"):
        text = written[name].read_text(encoding="utf-8")
        assert "Cessna 172S" in text, name
        assert "2011-08-12" in text, name
    unnamed = {"": replace(found, provenance=Provenance()).curve}
    assert "Airplane: ___" in table_text(".html", unnamed, "it", {})
    for blank in ("Airplane", "Date"):
        assert f'<span class="blank">{blank}' in card_sheet()
    seen = inspection_tree(inspect(real_log(*C172S)), read_log(real_log(*C172S)))
    assert seen[0].text == "Cessna 172S, 2011-08-12."


def test_a_card_says_its_doubts_once(doubtful):
    _, _, written, found = doubtful
    doubts = " ".join(doubts_of(found))
    for text in (
        written["--card"].read_text(encoding="utf-8"),
        table_text(".csv", {"": found.curve}, "it", {"": doubts_of(found)}),
    ):
        rows = [*csv.DictReader(StringIO(text))]
        assert len(rows) > 20
        assert [row["doubts"] for row in rows] == [doubts, *[""] * (len(rows) - 1)]


def test_a_log_in_the_folder_where_one_stands_has_a_name(tmp_path, monkeypatch, capsys):
    folder, deeper = tmp_path / "flown today", tmp_path / "flown today" / "none"
    deeper.mkdir(parents=True)
    shutil.copy(real_log(*C172S), folder)
    for place, here in ((folder, "."), (deeper, "..")):
        monkeypatch.chdir(place)
        said = told(capsys, "calibrate", here, "--no-altitude", "--record", "record.html")
        assert said.startswith("flown today (measured): Cessna 172S, 2011-08-12")
        assert ">flown today</td>" in (place / "record.html").read_text(encoding="utf-8")


ROW = re.compile(r"^\s*(\d+)\s+(\d+\.\d)\s+([+\-]\d+\.\d\d)\s+(\d+\.\d\d)", re.MULTILINE)
ADDED = re.compile(r"([+−]\d+\.\d\d) ± (\d+\.\d\d) \S+ at (\d+) ")
WIND = re.compile(r"The wind is (\d+\.\d) ± (\d+\.\d) \S+ from (\d{3})°")


def as_text(html):
    """A page as a reader sees it: a line a row, a cell apart from the next."""
    lines = re.sub(r"</t[dh]>", " ", re.sub(r"</(tr|p|li|h\d)>", "\n", html))
    return unescape(re.sub(r"<svg.*?</svg>|<[^>]*>", "", lines, flags=re.DOTALL))


def require_numbers(text, document, a_knot=1.0):
    """Every number of the answer in a text is that of the document, as far as it has digits."""
    points = np.array(
        [
            [p[f"{key}_kt"] for key in ("indicated_airspeed", "correction", "two_sigma")]
            for p in document["curve"]
        ]
    )
    rows = [[float(each) for each in row] for row in ROW.findall(text)]
    added = [[float(each.replace("−", "-")) for each in row] for row in ADDED.findall(text)]
    (wind,) = {tuple(map(float, each)) for each in WIND.findall(text)}
    assert len(rows) >= 3
    assert len(added) >= 3
    told = [(row[0], row[2], row[3]) for row in rows]
    told += [(speed, correction, bound) for correction, bound, speed in added[:3]]
    half = 0.5 * (1.0 + a_knot)  # a number is rounded as it is written, and once more in a unit
    for speed, *values in told:
        near = points[np.argmin(np.abs(a_knot * points[:, 0] - speed))]
        assert abs(a_knot * near[0] - speed) <= half
        np.testing.assert_allclose(values, a_knot * near[1:], atol=0.01 * half + 1e-6)
    for speed, calibrated, correction, _ in rows:
        assert calibrated - speed == pytest.approx(correction, abs=half + 0.1)
    keys = ("wind_speed_kt", "wind_from_deg")
    assert wind[0] == pytest.approx(a_knot * document[keys[0]], abs=0.1 * half)
    assert wind[2] == pytest.approx(document[keys[1]], abs=0.5)
    bound = max(document["wind"][f"{side}_two_sigma_kt"] for side in ("north", "east"))
    assert wind[1] == pytest.approx(a_knot * bound, abs=0.1 * half)


@pytest.mark.parametrize("name", ["doubtful", "seaway", "CLASS65"])
def test_no_voice_of_a_real_log_contradicts_its_document(name, request):
    """Each number written by terminal, -v, page, record, notebook and panel, in two unit systems."""
    found = request.getfixturevalue(name)[3] if name == "doubtful" else answer_of(name)
    document = calibration_json(found) | {"fixed_speed": points_json(found.points)}
    nodes = calibration_tree("", {found.model: found}).nodes
    assert contradictions(nodes, document, beside(found)) == {}
    assert left_in_knots(nodes) == []


def test_every_voice_says_the_numbers_of_the_document(doubtful, tmp_path):
    """Terminal, page, record and notebook, in knots and in the reader's units; the card keeps its
    keys.
    """
    plain, more, written, found = doubtful
    document = json.loads(json_text(calibration_json(found)))
    page, record, card = (
        written[flag].read_text(encoding="utf-8") for flag in ("--report", "--record", "--card")
    )
    for text in (plain, more, *map(as_text, (page, record, found._repr_html_()))):
        require_numbers(text, document)
    found.write_page(tmp_path / "page.html", units="km/h,m")
    found.write_record(tmp_path / "record.html", units="km/h,m")
    for name, part in (("page.html", 0), ("record.html", 1)):
        text = as_text((tmp_path / name).read_text(encoding="utf-8"))
        require_numbers(text, document, 1.852)
        # Beside the answer, a page quotes rules in their own units, and a record the flags.
        parts = re.split("How to read this|Versions:", text)
        answer = re.sub("The rule allows .*", "", parts[part])
        assert re.findall(r".{0,80}\d (?:kt|ft|KIAS)\b.{0,40}", answer) == []
    rows = list(csv.DictReader(StringIO(card)))
    for key in ("indicated_airspeed_kt", "correction_kt", "two_sigma_kt"):
        np.testing.assert_allclose(
            [float(row[key]) for row in rows], [p[key] for p in document["curve"]], atol=5.1e-4
        )


def test_every_voice_has_every_doubt(doubtful):
    plain, _, written, found = doubtful
    texts = [plain, found._repr_html_(), *(path.read_text("utf-8") for path in written.values())]
    doubts = doubts_of(found)
    assert len(doubts) > 1
    for text in map(as_text, texts):
        for doubt in doubts:
            assert doubt in text
    # What was only read is no doubt: it stands on the page and in the record.
    read = [each for each in found.warnings if each not in " ".join(doubts).lower()]
    assert read
    for flag in ("--report", "--record"):
        for each in read:
            assert each in as_text(written[flag].read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", REAL)
def test_the_mean_residual_is_near_zero_and_its_2_sigma_is_that_of_what_is_drawn(name):
    found = answer_of(name)
    airspeed = found.residuals.airspeed
    assert abs(airspeed.mean()) < 0.1 * found.residual_two_sigma
    assert 0.85 < np.mean(np.abs(airspeed) <= found.residual_two_sigma) < 0.99
    # The samples drawn are the curve less the residual: they lie about the curve.
    drawn = Figure().subplots()
    curves.data_marks(found)[0](drawn)
    speed, samples = drawn.lines[0].get_xdata(), drawn.lines[0].get_ydata()
    curve = np.interp(speed, found.curve.indicated_airspeed_kt, found.curve.correction_kt)
    assert abs(np.median(samples - curve)) < 0.15 * found.residual_two_sigma / KNOT


def test_a_zero_offset_moves_the_samples_with_the_curve():
    """A drone at 18 m/s whose sensor reads 60 Pa too much."""
    truth = PressureErrorCurve(MODELS["bias"], (-0.05,), REFERENCE_PRESSURE)
    quiet = fixture.Air(gust=0.1, pressure=1.0)
    log = fixture.fly(fixture.circles(5, (35, 40, 45, 50)), 5, 5, quiet, truth=truth)
    parts = log.channels() | {"impact_pressure": log.impact_pressure + 60.0}
    zero = {"impact_pressure_zero_pa": 400.0}
    found = calibrate(type(log)(**parts), model="bias", accuracies=zero, error_location="impact")
    assert found.impact_pressure_zero.value == pytest.approx(60.0, abs=15.0)
    assert abs(found.residuals.airspeed.mean()) < 0.05 * found.residual_two_sigma + 0.01
    assert found.residual_two_sigma < 1.0


def test_the_record_says_how_many_rows_were_used_and_why_not_the_others(tmp_path):
    found = answer_of("seaway")
    found.write_record(tmp_path / "record.html")
    record = unescape((tmp_path / "record.html").read_text(encoding="utf-8"))
    assert "254 of 973 rows used; left out: below 10 kt over the ground" in record
    assert "no row was left out" not in record
    assert sum(end - begin for begin, end in found.parts) < 600.0


def test_all_times_are_those_of_the_file(tmp_path, capsys, monkeypatch):
    """Used parts, the residual's axis and `--from`: minutes from the first row of the file."""
    log = circling(1200.0)
    path = write_log(log, tmp_path / "log.csv")
    whole, part = calibrate(log), calibrate(log.part(log.time > 600.0))
    assert (whole.log_start, part.log_start) == (0.0, 0.0)
    axes = Figure().subplots()

    def panel(title, draw, *rest, **more):
        if title == "Residual":
            draw(axes)

    with monkeypatch.context() as patched:
        patched.setattr(curves, "panel", panel)
        curves.residual_panels(part)
    assert 9.9 < axes.lines[0].get_xdata()[0] < 10.1
    document = json.loads(told(capsys, "calibrate", path, "--from", "10:00", "--json"))
    assert document["parts"][0]["from_s"] == pytest.approx(600.0)


def glitch(seconds, step, rows, seed):
    """A drifting flight with a row every `step` seconds, of which some read 25 kt too much."""
    flown = circling(seconds, seed=seed)
    log = flown.select(np.arange(0, len(flown), round(2 * step)))
    pressure = log.impact_pressure.copy()
    pressure[rows] *= 1.7
    return log, type(log)(**(log.channels() | {"impact_pressure": pressure}))


def test_a_faulty_row_that_empties_a_block_is_left_out_of_all():
    """Rows no denser than a block: without its row, the path of the wind has a point less."""
    rows = [150, 300, 301]
    clean, bad = glitch(1400.0, 4.0, rows, 5)
    found, good = (calibrate(log, model="linear", wind="drifting") for log in (bad, clean))
    assert not found.residuals.used[rows].any()
    bound = np.hypot(found.curve.two_sigma, good.curve.two_sigma)
    assert np.all(np.abs(found.curve.correction - good.curve.correction) < 0.5 * bound)


@pytest.mark.parametrize(("legs", "curves"), [(3, 0), (6, 1)])
def test_a_card_of_one_point_has_one_answer(legs, curves, tmp_path, capsys):
    """Its curve, over a knot or two, said another correction with another bound."""
    path = tmp_path / "legs.csv"
    path.write_text(
        "point,indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,"
        "ground_speed_kt,track_deg\n"
        + "\n".join(
            f"{1 + row // 3},{100 + 20 * (row // 3)},5000,5,{speed + 22 * (row // 3)},{track}"
            for row, (speed, track) in enumerate(2 * [(118, 358), (104, 92), (96, 181)])
            if row < legs
        ),
        encoding="utf-8",
    )
    assert told(capsys, "fixed-speed", path).count("\ncurve\n") == curves
