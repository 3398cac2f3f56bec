"""What a notebook shows of a record: one line, HTML, a picture, a table; the notebooks of the
gallery.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from pitotbench import Case, UnknownNameError, fly, sense, write_log
from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.notebook import in_one_line, to_frame
from pitotbench.units import KNOT

NOTEBOOKS = [*(Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb")]


@pytest.fixture(scope="module")
def plan():
    speeds = np.array([100.0, 130.0, 160.0]) * KNOT
    bound = np.full(3, 0.2 * KNOT)
    forecast = Forecast(
        "circle", {}, 6.0, 9.0, 0.5, (9000.0, 9000.0), speeds, bound, bound, 0.0, np.zeros((2, 4))
    )
    return Plan("light turbulence", (forecast,), {}, forecast, None, None, 0)


@pytest.mark.parametrize("name", ["log", "result", "plan"])
def test_a_record_shows_itself_in_one_line_as_html_and_as_a_picture(name, request):
    record = request.getfixturevalue(name)
    line = repr(record)
    assert len(line) < 300
    assert "\n" not in line
    assert "array(" not in line
    assert "<" in record._repr_html_()
    figure = record.plot()
    assert isinstance(figure, Figure)
    for axes in figure.axes:
        assert "[" in axes.get_xlabel()
        # The names of maneuvers along an axis have no unit.
        named = any(each.get_text().isalpha() for each in axes.get_yticklabels())
        assert named or "[" in axes.get_ylabel()


def test_the_table_of_a_calibration_holds_its_curve_in_knots(result):
    table = result.to_frame()
    assert table["correction_kt"].to_numpy() == pytest.approx(result.curve.correction / KNOT)
    assert table["calibrated_airspeed_kt"].to_numpy() == pytest.approx(
        result.curve.calibrated_airspeed_kt
    )


def test_the_table_of_a_log_has_the_columns_of_the_file(log):
    table = log.to_frame()
    assert len(table) == len(log)
    assert table["velocity_north_mps"].to_numpy() == pytest.approx(log.velocity_north)


def test_a_picture_can_share_the_axes_of_the_caller(result):
    axes = Figure().subplots()
    assert result.plot(axes) is axes.figure
    assert len(axes.lines) > 1
    assert axes.get_legend() is not None  # it names curve and bound


def test_what_has_no_view_is_told(tmp_path):
    with pytest.raises(TypeError, match="no view in a notebook"):
        in_one_line(tmp_path)
    with pytest.raises(TypeError, match="no table"):
        to_frame(tmp_path)


@pytest.mark.parametrize(
    ("north", "east", "expected"), [(-5.0, 0.0, 0.0), (0.0, -5.0, 90.0), (5.0, 0.0, 180.0)]
)
def test_the_wind_is_named_by_the_direction_it_comes_from(result, north, east, expected):
    wind = result.wind
    turned = replace(
        wind, north=replace(wind.north, value=north), east=replace(wind.east, value=east)
    )
    assert turned.from_deg == pytest.approx(expected, abs=1e-9)
    assert turned.speed_kt == pytest.approx(5.0 / KNOT)


def test_a_case_shows_itself_in_the_units_of_a_card():
    assert "altitude 6000 ft" in repr(Case())
    line = repr(replace(Case(), wind=replace(Case().wind, speed=20.0 * KNOT)))
    assert "wind speed 20 kt; wind from direction 300°" in line


def test_a_maneuver_that_is_misspelled_is_told_with_the_nearest():
    with pytest.raises(UnknownNameError, match="Did you mean 'circle'"):
        fly("cirlce")


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_top_to_bottom(notebook, light_flights, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_log(sense(light_flights["circle"], "5/1"), Path("flight.csv"))
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    codes = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    assert len(codes) > 2
    known = {}
    for text in codes:
        exec(compile(text, notebook.name, "exec"), known)


def test_the_gallery_has_three_notebooks():
    assert sorted(each.stem for each in NOTEBOOKS) == ["flight", "log", "reconciliation"]
