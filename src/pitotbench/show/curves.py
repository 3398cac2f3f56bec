"""Pictures of an error curve, of the data behind it, and of columns of results."""

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from pitotbench import air
from pitotbench.records.calibration import Calibration, ErrorCurve
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.show.calibration import ShortAnswer, samples_of
from pitotbench.show.deliverables import CurveDifference
from pitotbench.show.legs import method_words
from pitotbench.show.limits import AUTO, Limit, limit_for
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    SKY,
    WIDE,
    Panel,
    broken,
    panel,
    stacked,
    svg,
    thin,
)
from pitotbench.units import FOOT, KNOT, Array, MetersPerSecond

if TYPE_CHECKING:
    import pandas as pd

# Pictures of an error curve: the correction, its bounds, and the limit of the certification rule.

_MODEL_COLORS = (GREEN, PURPLE, ORANGE, RED)
_MARKERS = {"turn": "o", "four_leg": "s", "three_leg": "^", "horseshoe": "v", "many_leg": "D"}
_MAIN = (5.2, 2.9)  # in, the first picture of a page
_LIMIT_WITHIN = 1.3  # times what the curve and its samples reach: a limit beyond is not drawn
_AIRSPEED, _CORRECTION = "indicated airspeed [kt]", "correction, CAS − IAS [kt]"


def curve_panels(
    results: Mapping[str, Calibration],
    truth: Mapping[str, MetersPerSecond] | None,
    limit: Limit | str | None = AUTO,
    units: Units = BENCH,
) -> list[Panel]:
    """The picture of the error curve with its bound between its limits.

    `results` by model: the first is explained, the others are drawn beside it. `truth`: the true
    correction [m/s] by model, at the airspeeds of its curve, or None for a measured log. `limit` as
    for `judgments`.
    """
    name, first = next(iter(results.items()))
    true, chosen = None if truth is None else truth[name], limit_for(first, limit)
    return [
        panel(
            "Error curve",
            lambda axes: draw_curve(axes, results, true, chosen),
            size=_MAIN,
            units=units,
        )
    ]


def bound_panels(
    result: Calibration, truth: MetersPerSecond | None = None, units: Units = BENCH
) -> list[Panel]:
    """The bounds of a curve, and the altitude error where the static source errs. `truth`: the true
    correction [m/s].
    """
    known = panel(
        "How well the curve is known",
        lambda axes: draw_bound(axes, result, truth),
        legend_columns=2,
        units=units,
    )
    if result.curve.altitude_correction is None:
        return [known]
    return [
        known,
        panel("Altitude error", lambda axes: draw_altitude(axes, result.curve), units=units),
    ]


def draw_curve(
    axes: Axes,
    results: Mapping[str, Calibration],
    truth: MetersPerSecond | None,
    limit: Limit | None = None,
) -> None:
    """Draw the correction over indicated airspeed with ±2σ and the data behind it, the curves of
    other models, the limit, and the truth where known.

    The points of fixed-speed methods of the first lie over its curve, as in Martos et al. (2011),
    Fig. 13.
    """
    name, first = next(iter(results.items()))
    speed, value, bound = _knots(first)
    draw_data(axes, first)
    axes.fill_between(
        speed, value - bound, value + bound, color=BLUE, alpha=0.25, lw=0, label="±2σ of the curve"
    )
    for color, (other, result) in zip(_MODEL_COLORS, list(results.items())[1:], strict=False):
        curve = result.curve
        axes.plot(
            curve.indicated_airspeed / KNOT,
            curve.correction / KNOT,
            color=color,
            lw=1.0,
            label=other,
        )
    axes.plot(speed, value, color=BLUE, label=f"curve ({name})")
    draw_published(axes, first.curve)
    if truth is not None:
        axes.plot(speed, truth / KNOT, color="black", ls="--", lw=1.2, label="truth (simulated)")
    draw_points(axes, first.points)
    axes.axhline(0.0, color=INK, lw=0.5)
    # A limit far beyond the curve would squeeze it to a stripe; the sentence of the rule tells its
    # margin.
    low, high = axes.get_ylim()
    if limit is not None and np.min(limit.airspeed(speed)) < _LIMIT_WITHIN * max(-low, high):
        axes.plot(speed, limit.airspeed(speed), color=RED, ls=":", lw=1.4, label=limit.label)
        axes.plot(speed, -limit.airspeed(speed), color=RED, ls=":", lw=1.4)
    axes.set(xlabel=_AIRSPEED, ylabel=_CORRECTION)
    axes.locator_params(axis="y", nbins=7)  # by the axis' height it may change after the layout


def draw_published(axes: Axes, curve: ErrorCurve) -> None:
    """Draw the corrections by a handbook between the airspeeds of a curve, a broken line each."""
    low, high = curve.indicated_airspeed_kt[[0, -1]]
    for color, each in zip((INK, PURPLE, ORANGE, RED), curve.published, strict=False):
        speed, value = each.indicated_airspeed / KNOT, each.correction / KNOT
        inner = speed[(speed > low) & (speed < high)]
        ends = [v for v in (low, high) if speed[0] <= v <= speed[-1]]
        at = np.sort(np.concatenate([inner, ends]))
        label = f"handbook{f', {each.configuration}' if each.configuration else ''}"
        axes.plot(at, np.interp(at, speed, value), color=color, ls="-.", lw=1.2, label=label)


def difference_panels(
    found: CurveDifference, one: ErrorCurve, other: ErrorCurve, units: Units = BENCH
) -> list[Panel]:
    """The picture of two curves, and below them their difference, each with its 2σ."""

    def draw_both(axes: Axes) -> None:
        for name, curve, color in ((found.first, one, ORANGE), (found.second, other, BLUE)):
            speed, value, bound = (
                a / KNOT for a in (curve.indicated_airspeed, curve.correction, curve.two_sigma)
            )
            _draw_banded(axes, speed, value, bound, color, f"{name} (±2σ)")
        axes.set(ylabel=_CORRECTION)

    def draw_difference(axes: Axes) -> None:
        speed, value, bound = (
            a / KNOT for a in (found.indicated_airspeed, found.difference, found.two_sigma)
        )
        label = "difference of the corrections (±2σ)"
        _draw_banded(axes, speed, value, bound, PURPLE, label)
        axes.set(xlabel=_AIRSPEED, ylabel="difference [kt]")

    with stacked([draw_both, draw_difference], _SIZE, 3, units) as figure:
        title = f"{found.second} against {found.first}".replace('"', "'")
        return [Panel(title, svg(figure, title))]


def _draw_banded(
    axes: Axes, speed: Array, value: Array, bound: Array, color: str, label: str
) -> None:
    """Draw values with their ±2σ over airspeed, and the line of zero."""
    axes.fill_between(speed, value - bound, value + bound, color=color, alpha=0.25, lw=0)
    axes.plot(speed, value, color=color, label=label)
    axes.axhline(0.0, color=INK, lw=0.5)


def parts_panels(log: FlightLog | None, result: Calibration, units: Units = BENCH) -> list[Panel]:
    """The flight over time, with the parts that the calibration used in color; nothing where all of
    it was.
    """
    if log is None or not result.left_out:
        return []
    note = "Used in color, in grey what was left out: " + ", ".join(result.left_out) + "."
    time = (log.time - log.start) / 60.0

    def draw_parts(axes: Axes, values: Array) -> None:
        axes.plot(*thin(time, values), color=GREY, lw=0.8, label="left out")
        for begin, end in result.parts:
            rows = (log.time >= begin) & (log.time <= end)
            axes.plot(*thin(time[rows], values[rows]), color=BLUE, lw=1.4, label="used")

    def draw_airspeed(axes: Axes) -> None:
        draw_parts(axes, air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0)) / KNOT)
        axes.set(ylabel="indicated\nairspeed [kt]")

    def draw_height(axes: Axes) -> None:
        draw_parts(axes, air.pressure_altitude(log.static_pressure) / FOOT)
        axes.set(xlabel="time [min]", ylabel="pressure\naltitude [ft]")

    with stacked([draw_airspeed, draw_height], WIDE, 3, units) as figure:
        return [Panel("Parts of the flight", svg(figure, "Parts of the flight"), note)]


def draw_data(axes: Axes, result: Calibration) -> None:
    """Draw what single samples say."""
    _, speed, data = samples_of(result)
    axes.plot(speed / KNOT, data / KNOT, ".", color=PALE, ms=2.0, zorder=1)
    axes.plot(
        [], [], ".", color=GREY, ms=5.0, label="samples without the wind"
    )  # large enough to be seen


def draw_altitude(axes: Axes, curve: ErrorCurve) -> None:
    """Draw the altitude correction with its ±2σ; the curve must have one."""
    assert curve.altitude_correction is not None
    assert curve.altitude_two_sigma is not None
    speed, value = curve.indicated_airspeed / KNOT, curve.altitude_correction / FOOT
    bound = curve.altitude_two_sigma / FOOT
    _draw_banded(axes, speed, value, bound, GREEN, "correction of the altitude (±2σ)")
    axes.set(xlabel=_AIRSPEED, ylabel="true − indicated pressure altitude [ft]")


def draw_points(axes: Axes, points: Sequence[FixedSpeedPoint]) -> None:
    """Draw the points' corrections with ±2σ bars on axes of indicated airspeed and correction [kt]."""
    for method in dict.fromkeys(point.method for point in points):
        chosen = [point for point in points if point.method == method]
        axes.errorbar(
            [point.indicated_airspeed / KNOT for point in chosen],
            [point.correction / KNOT for point in chosen],
            yerr=[point.two_sigma / KNOT for point in chosen],
            fmt=_MARKERS[method], color=INK, ms=4.5, mfc="white", capsize=2.5, lw=1.0, zorder=4,
            label=f"{method_words(chosen[0])}, ±2σ",
        )  # fmt: skip


def draw_bound(axes: Axes, result: Calibration, truth: MetersPerSecond | None) -> None:
    """Draw the bound of each point, the band of the whole curve, the bound for white residuals, and
    the true error where known."""
    speed, value, bound = _knots(result)
    axes.plot(speed, bound, color=BLUE, label="±2σ bound")
    whole = result.curve.simultaneous_two_sigma / KNOT
    axes.plot(speed, whole, color=BLUE, lw=1.0, ls=":", label="±2σ band of the whole curve")
    axes.plot(
        speed,
        result.curve.white_two_sigma / KNOT,
        color=ORANGE,
        lw=1.1,
        label="2σ for white residuals",
    )
    if truth is not None:
        axes.plot(
            speed,
            np.abs(value - truth / KNOT),
            color="black",
            ls="--",
            lw=1.2,
            label="absolute true error",
        )
    axes.set(xlabel=_AIRSPEED, ylabel="bound of the correction [kt]")
    axes.set_ylim(bottom=0.0)


def _knots(result: Calibration) -> tuple[Array, Array, Array]:
    """Indicated airspeed, correction and 2σ of the curve [kt]."""
    curve = result.curve
    return curve.indicated_airspeed / KNOT, curve.correction / KNOT, curve.two_sigma / KNOT


# Pictures of the data behind a curve: samples by airspeed, residuals over time, and their
# autocorrelation.

_BIN_KT = 2.0
_DENSITY = (
    "All samples that the fit uses, also those in turns: many samples at one airspeed need "
    "not mean many legs."
)
_LONGEST_LAG = 40  # s


def residual_panels(result: Calibration, units: Units = BENCH) -> list[Panel]:
    """Data density, residuals over time and their autocorrelation."""
    residuals, bound = result.residuals, result.residual_two_sigma / KNOT

    def draw_density(axes: Axes) -> None:
        speed = residuals.indicated_airspeed / KNOT
        edges = np.arange(np.floor(speed.min()), speed.max() + _BIN_KT, _BIN_KT)
        axes.hist(speed, bins=edges.tolist(), color=BLUE, alpha=0.75)
        axes.set(xlabel="indicated airspeed [kt]", ylabel=f"samples per {_BIN_KT:g} kt")
        axes.grid(axis="x", visible=False)

    def draw_residuals(axes: Axes) -> None:
        time, value = broken(*thin(residuals.time - result.log_start, residuals.airspeed / KNOT))
        axes.plot(time / 60.0, value, color=GREY, lw=0.5)
        axes.axhline(bound, color=RED, lw=1.2, ls="--")
        axes.axhline(
            -bound, color=RED, lw=1.2, ls="--", label=f"±2σ of the residual, {bound:.2f} kt"
        )
        axes.set(xlabel="time [min]", ylabel="measured − predicted [kt]")

    def draw_autocorrelation(axes: Axes) -> None:
        lags, values, count = residual_autocorrelation(result)
        axes.axhspan(
            -2.0 / np.sqrt(count),
            2.0 / np.sqrt(count),
            color=PALE,
            label="95 % band of white noise",
        )
        axes.vlines(lags, 0.0, values, color=BLUE, lw=1.5)
        axes.axhline(0.0, color=GREY, lw=0.8)
        axes.set(xlabel="lag [s]", ylabel="correlation of 1 s means", ylim=(-0.6, 1.05))

    return [
        panel("Data density", draw_density, _DENSITY, units=units),
        panel("Residual", draw_residuals, units=units),
        panel("Autocorrelation of the residual", draw_autocorrelation),
    ]


def residual_autocorrelation(result: Calibration) -> tuple[Array, Array, int]:
    """Lags [s], autocorrelation and number of one-second means of the residual; pauses do not
    count.
    """
    second = np.floor(result.residuals.time - result.residuals.time[0]).astype(np.intp)
    filled = np.full(second[-1] + 1, np.nan)
    count = np.bincount(second)
    total = np.bincount(second, result.residuals.airspeed)
    filled[count > 0] = total[count > 0] / count[count > 0]
    centered = filled - np.nanmean(filled)
    variance = np.nanmean(centered**2)
    longest = min(_LONGEST_LAG, len(centered) // 2)
    products = [centered[k:] * centered[: len(centered) - k] for k in range(longest + 1)]
    lags = [k for k, product in enumerate(products) if np.isfinite(product).any()]
    values = [float(np.nanmean(products[k]) / variance) for k in lags]
    return np.array(lags, dtype=np.float64), np.array(values), int((count > 0).sum())


_COLORS = (BLUE, ORANGE, GREEN, RED, SKY, PURPLE, GREY)
_SIZE = (7.0, 4.4)  # in
_MOST_POINTS = 20_000  # more cannot be distinguished
_SIDE_BY_SIDE = 6.0  # kt, over which the flights at one airspeed are drawn beside one another


def scatter_svg(results: "pd.DataFrame", vertical: str, horizontal: str) -> str:
    """One column of results drawn against another, a color a maneuver, as the text of an SVG file."""
    with stacked(
        [lambda axes: draw_scatter(axes, results, vertical, horizontal)], _SIZE, legend_columns=4
    ) as figure:
        text = svg(figure, f"{vertical} against {horizontal}")
    return (
        text
        if "xmlns=" in text
        else text.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1)
    )


def draw_scatter(axes: Axes, results: "pd.DataFrame", vertical: str, horizontal: str) -> None:
    """Draw one column of results against another, a dot a row and a color a maneuver."""
    step = max(1, -(-len(results) // _MOST_POINTS))
    for number, (name, rows) in enumerate(results.iloc[::step].groupby("maneuver", sort=False)):
        color = _COLORS[number % len(_COLORS)]
        label = str(name).replace("_", " ")
        axes.plot(
            rows[horizontal], rows[vertical], ".", markersize=6, alpha=0.6, color=color, label=label
        )
    axes.set(xlabel=horizontal, ylabel=vertical)


def all_flights_panels(results: "pd.DataFrame", units: Units = BENCH) -> list[Panel]:
    """The bound of every flight against its minutes, with twice its true error, for the first
    model.
    """
    first = results[results["model"] == results["model"].iloc[0]]

    def draw(axes: Axes) -> None:
        draw_scatter(axes, first, "two_sigma_kt", "minutes")
        error = 2.0 * first["curve_rms_error_kt"]
        axes.plot(first["minutes"], error, "_", ms=7.0, color="black", label="2 × true rms error")
        axes.set(
            xlabel="time [min]",
            ylabel="mean ±2σ of the curve [kt]",
            ylim=(0.0, None),
        )

    note = (
        "A dot: the bound of the curve from one flight, as one data system recorded it; in "
        "black its true error."
    )
    title = f"How well the curve is known ({first['model'].iloc[0]})"
    return [panel(title, draw, note, units=units)]


def corrections_panels(answers: Sequence[ShortAnswer], units: Units = BENCH) -> list[Panel]:
    """The corrections of each flight with their bounds, side by side at each airspeed, a color a
    maneuver.
    """
    groups = [re.sub(r"(-seed\d+)? \S+$", "", a.subject).replace("_", " ") for a in answers]
    maneuvers = list(dict.fromkeys(groups))

    def draw(axes: Axes) -> None:
        for place, (group, answer) in enumerate(zip(groups, answers, strict=True)):
            speed, value, bound = (
                [getattr(each, part) for each in answer.corrections]
                for part in ("indicated_kt", "correction_kt", "two_sigma_kt")
            )
            shift = _SIDE_BY_SIDE * ((place + 0.5) / len(answers) - 0.5)
            color = _COLORS[maneuvers.index(group) % len(_COLORS)]
            at = np.array(speed) + shift
            axes.errorbar(
                at, value, bound, fmt="o-", ms=3.0, lw=0.8, capsize=1.5, color=color, label=group
            )
        axes.axhline(0.0, color=INK, lw=0.5)
        axes.set(xlabel=_AIRSPEED, ylabel=_CORRECTION)

    return [panel("The corrections over one another", draw, "Bars are ±2σ.", units=units)]
