"""Panels drawn without a drawing library: the ticks are those of matplotlib, and marks lie where the data are."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from pitotbench.show.drawing.chart import Chart, Extent
from pitotbench.show.drawing.frame import drawing_of
from pitotbench.show.drawing.letters import text_width
from pitotbench.show.drawing.ticks import tick_words, ticks_between

LIMITS = [(-0.3, 6.2), (97.0, 163.0), (-2.05, 1.1), (0.0, 2805.0), (5953.0, 6046.0), (-5e-4, 3.1e-3), (0.0, 0.93)]


def drawing(chart, columns=3):
    return ElementTree.fromstring(drawing_of(chart, "a <title>", 331.2, 208.8, columns))


@pytest.mark.parametrize("most", [4, 7, 9])
@pytest.mark.parametrize(("low", "high"), LIMITS)
def test_ticks_are_those_of_matplotlib(low, high, most):
    theirs = MaxNLocator(most, steps=[1, 2, 2.5, 5, 10]).tick_values(low, high)
    inside = theirs[(theirs >= low - 1e-12) & (theirs <= high + 1e-12)]
    np.testing.assert_allclose(ticks_between(low, high, most), inside, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(("low", "high"), LIMITS[:5])
def test_words_of_ticks_are_those_of_matplotlib(low, high):
    from matplotlib.figure import Figure

    axis = Figure().subplots().yaxis
    axis.set_view_interval(low, high, ignore=True)
    formatter = ScalarFormatter(useOffset=False)
    formatter.set_axis(axis)
    ticks = ticks_between(low, high, 8)
    assert tick_words(ticks) == formatter.format_ticks(ticks)


def test_small_ticks_tell_each_other_apart():
    assert len(set(tick_words(np.array([1e-7, 2e-7, 3e-7])))) == 3
    assert tick_words(np.array([-0.0, 1.0])) == ["0", "1"]


def test_a_line_lies_at_its_data_and_breaks_where_one_is_missing():
    chart = Chart(xlabel="x", ylabel="y")
    chart.line([0.0, 1.0, np.nan, 3.0, 4.0], [0.0, 1.0, 2.0, 3.0, 4.0], "#0072B2", label="a & b")
    text = drawing_of(chart, "title", 331.2, 208.8, 3)
    (path,) = re.findall(r'd="(M[^"]*)" fill="none" stroke="#0072B2" stroke-width="1.4"/></svg>', text)
    runs = [np.array(run.split(), dtype=float).reshape(-1, 2) for run in path.split("M")[1:]]
    assert [len(run) for run in runs] == [2, 2]
    wide, high = (float(v) for v in re.search(r'<svg width="([\d.]+)" height="([\d.]+)"', text).groups())
    # Five hundredths of the range are left free on either side of the data.
    np.testing.assert_allclose(runs[0][0], [wide * 0.05 / 1.1, high * (1.0 - 0.05 / 1.1)], atol=0.1)
    np.testing.assert_allclose(runs[1][1], [wide * 1.05 / 1.1, high * 0.05 / 1.1], atol=0.1)
    words = [element.text for element in ElementTree.fromstring(text).iter() if element.tag.endswith("text")]
    assert {"x", "y", "a & b"} <= set(words)


def test_bars_stand_on_zero_and_equal_axes_have_one_scale():
    chart = Chart()
    chart.bars(np.array([0.0, 1.0]), 1.0, np.array([3.0, 5.0]), "#000000")
    assert chart.y.limits() == pytest.approx((0.0, 5.25))
    chart = Chart(equal=True)
    chart.line([0.0, 1.0], [0.0, 10.0], "#000000")
    text = drawing_of(chart, "t", 331.2, 208.8, 3)
    a, b = (np.array(p.split(), dtype=float) for p in re.search(r'd="M([\d. ]+) ([\d.]+ [\d.]+)" f', text).groups())
    assert abs(b[1] - a[1]) == pytest.approx(10.0 * abs(b[0] - a[0]), rel=0.03)


def test_limits_hold_without_data_and_for_one_value():
    assert Extent().limits() == pytest.approx((-0.05, 1.05))
    alone = Extent()
    alone.include([6000.0])
    low, high = alone.limits()
    assert low < 6000.0 < high
    assert drawing(Chart()) is not None


def test_a_chart_escapes_its_words_and_the_legend_fills_columns():
    chart = Chart()
    for name in ("first", "second <", "third", "fourth"):
        chart.line([0.0, 1.0], [0.0, 1.0], "#000000", label=name)
    texts = {
        e.text: (float(e.get("x")), float(e.get("y"))) for e in drawing(chart, 2).iter() if e.tag.endswith("text")
    }
    assert texts["first"][0] == texts["second <"][0] < texts["third"][0]
    assert texts["first"][1] == texts["third"][1] < texts["second <"][1]


def test_text_is_about_as_wide_as_matplotlib_measures_it():
    from matplotlib.textpath import TextPath

    for text in ("±2σ band of the whole curve", "manifold pressure, left [inHg]", "−2.0", "2 × true rms error"):
        assert text_width(text, 10.0) == pytest.approx(TextPath((0, 0), text, size=10.0).get_extents().x1, rel=0.06)
