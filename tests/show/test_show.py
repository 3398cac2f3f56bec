"""Pictures and tables: what a reader needs is on them, with units."""

import re

import numpy as np
import pytest
import trajectories as fixture

from pitotbench.calibrate import calibrate
from pitotbench.show.curves import calibration_figure, residual_autocorrelation
from pitotbench.show.flights import flight_figure
from pitotbench.show.section import words
from pitotbench.show.style import broken, thin
from pitotbench.units import KNOT


@pytest.fixture(scope="module")
def result():
    return calibrate(fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air()))


def test_calibration_figure_labels_carry_units(result):
    drawing = calibration_figure({"inverse+": result}, {"inverse+": result.curve.correction})
    text = " ".join(re.findall(r"<text[^>]*>([^<]*)</text>", drawing))
    for wanted in ("Error curve", "indicated airspeed [kt]", "FAR 25.1323(c)", "truth", "lag [s]", "time [min]"):
        assert wanted in text


def test_flight_figure_shows_wind_and_tolerances(smooth_flights):
    drawing = flight_figure(smooth_flights["rapid_decel"])
    assert "wind 15 kt" in drawing
    assert "tolerance ±50" in drawing
    assert "altitude [ft]" in drawing


def test_words_state_both_kinds_of_two_sigma(result):
    text = words(result, "20/1")
    assert f"{result.residual_two_sigma / KNOT:.2f} kt" in text
    assert "±" in text
    speed = np.hypot(*fixture.WIND) / KNOT
    assert f"Wind {speed:.0f}" in re.sub(r"Wind (\d+)\.\d", lambda m: f"Wind {round(float(m.group(0)[5:]))}", text)


def test_autocorrelation_of_a_gust_is_long(result):
    lags, values, count = residual_autocorrelation(result)
    assert lags[0] == 0.0
    assert values[0] == 1.0
    assert values[2] > 4.0 / np.sqrt(count)  # eight seconds of memory: far from white


def test_lines_are_thinned_and_broken_at_pauses():
    time = np.concatenate([np.arange(0.0, 10.0, 0.01), np.arange(60.0, 70.0, 0.01)])
    short, _ = thin(time, time)
    assert len(short) <= 2000
    gapped, value = broken(time, time)
    assert np.isnan(value).sum() == 1
    assert len(gapped) == len(time) + 1
