"""The layout of pictures: nothing is cut or covered."""

import numpy as np
import pytest

from pitotbench.show.style import NARROW, WIDE, stacked

X = np.linspace(0.0, 9.7, 50)


def plain(axes):
    axes.plot(X, np.sin(X), label="curve")
    axes.fill_between(X, np.sin(X) - 1.0, np.sin(X) + 1.0, label="±2σ")
    axes.set(xlabel="indicated airspeed [kt]", ylabel="correction [kt]")


def large_numbers(axes):
    axes.plot(1e5 * X, -12345.6 * X, label="a name")
    axes.set(xlabel="x", ylabel="y")


def named_bars(axes):
    axes.bar([0, 1], [1.0, 2.0], label="first")
    axes.set_xticks([0, 1], ["step\ndecrease", "a maneuver of\nthree\nlines"])
    axes.grid(axis="x", visible=False)
    axes.set_ylabel("2σ [kt]")


def logarithmic(axes):
    axes.plot(X + 0.01, 1e4 * (X + 0.01) ** 3)
    axes.set(xscale="log", yscale="log", xlabel="x", ylabel="y")
    axes.set_xlim(0.5, 20.0)


def with_words(axes):
    axes.plot(X, X, label="line")
    axes.text(9.0, 5.0, "words that reach far beyond the axes")


def many_names(axes):
    for number, name in enumerate(
        ("samples without the wind", "short", "±2σ of the curve", "limit of FAR 25.1323(c)")
    ):
        axes.plot(X, number * X, label=name)


@pytest.mark.parametrize("size", [WIDE, NARROW])
@pytest.mark.parametrize("draw", [plain, large_numbers, named_bars, logarithmic, with_words, many_names])
def test_nothing_is_cut_and_the_legend_covers_nothing(draw, size):
    with stacked([draw], size, 3) as figure:
        figure.draw_without_rendering()
        box = figure.get_tightbbox()
        assert box.x0 >= -0.01
        assert box.y0 >= -0.01
        assert box.x1 <= size[0] + 0.01
        assert box.y1 <= size[1] + 0.01
        (axes,) = figure.axes
        for legend in figure.legends:
            assert legend.get_window_extent().y0 >= axes.get_window_extent().y1


def test_two_axes_leave_room_for_the_ticks_between_them():
    with stacked([plain, large_numbers], (4.6, 4.4), 2) as figure:
        figure.draw_without_rendering()
        upper, lower = figure.axes
        assert upper.get_tightbbox().y0 >= lower.get_window_extent().y1
        assert upper.get_position().x0 == lower.get_position().x0
        assert upper.get_xlim() == lower.get_xlim()


def test_long_names_take_fewer_columns():
    def named(axes):
        for number in range(3):
            axes.plot(X, number * X, label=f"name {number} of some length")

    left = {}
    for width in (20.0, 4.0, 2.0):
        with stacked([named], (width, 2.9), 3) as figure:
            figure.draw_without_rendering()
            (legend,) = figure.legends
            left[width] = len({round(text.get_window_extent().x0) for text in legend.get_texts()})
    assert left == {20.0: 3, 4.0: 2, 2.0: 1}
