"""Pictures of an error curve, of the data behind it, and of columns of results."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num

from pitotbench import air
from pitotbench.records.calibration import Calibration, ErrorCurve
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.records.over_dates import OverDates
from pitotbench.show.curve_rows import method_words, samples_of
from pitotbench.show.limits import AUTO, Limit, limit_for
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    GRAY,
    GREEN,
    INK,
    ORANGE,
    PALE,
    PURPLE,
    RED,
    SKY,
    Mark,
    Panel,
    band,
    bars,
    broken,
    dots,
    drawing,
    frame,
    level,
    line,
    panel,
    stacked,
    stripe,
    svg,
    thin,
)
from pitotbench.units import FOOT, KNOT, Array, MetersPerSecond

if TYPE_CHECKING:
    import pandas as pd

_MODEL_COLORS = (GREEN, PURPLE, ORANGE, RED)
_MARKERS = {"turn": "o", "four_leg": "s", "three_leg": "^", "many_leg": "D"}
_MAIN = (5.2, 2.9)  # in, the first picture of a page
_LIMIT_WITHIN = 1.3  # times what the curve and its samples reach: a limit beyond is not drawn
AIRSPEED, CORRECTION = "indicated airspeed [kt]", "correction, CAS − IAS [kt]"


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
    marks = curve_marks(results, None if truth is None else truth[name], limit_for(first, limit))
    return [panel("Error curve", drawing(*marks), size=_MAIN, units=units)]


def bound_panels(
    result: Calibration, truth: MetersPerSecond | None = None, units: Units = BENCH
) -> list[Panel]:
    """The bounds of a curve, and the altitude error where the static source errs.

    `truth`: the true correction [m/s].
    """
    known = drawing(*bound_marks(result.curve, truth))
    found = [panel("How well the curve is known", known, legend_columns=2, units=units)]
    if result.curve.altitude_correction is not None:
        found.append(panel("Altitude error", drawing(*altitude_marks(result.curve)), units=units))
    return found


def curve_marks(
    results: Mapping[str, Calibration],
    truth: MetersPerSecond | None = None,
    limit: Limit | None = None,
) -> list[Mark]:
    """Return the marks of the correction over indicated airspeed, ±2σ, and what is beside it.

    Beside it are the data, other models' curves, the limit, and the truth where known.

    The points of fixed-speed methods of the first lie over its curve, as in Martos et al. (2011),
    Fig. 13.
    """
    (name, first), *others = results.items()
    speed, value, bound = _in_knots(first.curve)
    true = [] if truth is None else [(truth / KNOT, "black")]
    return [
        *data_marks(first),
        band(speed, value - bound, value + bound, label="±2σ of the curve"),
        *(
            line(*_in_knots(result.curve)[:2], color=color, label=other, lw=1.0)
            for color, (other, result) in zip(_MODEL_COLORS, others, strict=False)
        ),
        line(speed, value, label=f"curve ({name})"),
        *published_marks(first.curve),
        *(line(speed, v, color=c, ls="--", lw=1.2, label="truth (simulated)") for v, c in true),
        *point_marks(first.points),
        level(0.0),
        partial(_draw_limit, limit=limit, speed=speed),
        frame(AIRSPEED, CORRECTION),
        # By the axis' height it may change after the layout.
        lambda axes: axes.locator_params(axis="y", nbins=7),
    ]


def _draw_limit(axes: Axes, limit: Limit | None, speed: Array) -> None:
    """Draw a limit that is near what is drawn.

    A limit far beyond it would squeeze the curve to a stripe; the sentence of the rule tells its
    margin.
    """
    low, high = axes.get_ylim()
    if limit is not None and np.min(limit.airspeed(speed)) < _LIMIT_WITHIN * max(-low, high):
        for side, label in ((1.0, limit.label), (-1.0, "")):
            line(speed, side * limit.airspeed(speed), color=RED, ls=":", label=label)(axes)


def published_marks(curve: ErrorCurve) -> list[Mark]:
    """The corrections by a handbook between the airspeeds of a curve, a broken line each."""
    return [
        line(
            at,
            np.interp(at, each.indicated_airspeed / KNOT, each.correction / KNOT),
            color=color,
            ls="-.",
            lw=1.2,
            label=", ".join(filter(None, ("handbook", each.configuration))),
        )
        for color, each in zip((INK, PURPLE, ORANGE, RED), curve.published, strict=False)
        for at in [np.clip(each.indicated_airspeed / KNOT, *curve.indicated_airspeed_kt[[0, -1]])]
    ]


def banded(speed: Array, value: Array, bound: Array, color: str, label: str) -> list[Mark]:
    """Values with their ±2σ over airspeed, and the line of zero."""
    return [
        band(speed, value - bound, value + bound, color=color),
        line(speed, value, color=color, label=label),
        level(0.0),
    ]


def parts_panels(log: FlightLog | None, result: Calibration, units: Units = BENCH) -> list[Panel]:
    """Return the flight over time, the parts used in color; [] where all of it was used."""
    if log is None or not result.left_out:
        return []
    note = "Used in color, in gray what was left out: " + ", ".join(result.left_out) + "."
    time = (log.time - log.start) / 60.0
    used = [(log.time >= begin) & (log.time <= end) for begin, end in result.parts]

    def drawn(values: Array, x: str, y: str) -> Mark:
        return drawing(
            line(*thin(time, values), color=GRAY, lw=0.8, label="left out"),
            *(line(*thin(time[rows], values[rows]), label="used") for rows in used),
            frame(x, y),
        )

    speed = air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0)) / KNOT
    height = air.pressure_altitude(log.static_pressure) / FOOT
    draws = [
        drawn(speed, "", "indicated\nairspeed [kt]"),
        drawn(height, "time [min]", "pressure\naltitude [ft]"),
    ]
    return [panel("Parts of the flight", draws, note, units=units)]


def data_marks(result: Calibration) -> list[Mark]:
    """What single samples say."""
    _, speed, data = samples_of(result)
    return [
        dots(speed / KNOT, data / KNOT, color=PALE, ms=2.0, zorder=1),
        dots([], [], ms=5.0, label="samples without the wind"),  # large enough to be seen
    ]


def altitude_marks(curve: ErrorCurve) -> list[Mark]:
    """The altitude correction with its ±2σ; the curve must have one."""
    assert curve.altitude_correction is not None
    assert curve.altitude_two_sigma is not None
    value, bound = curve.altitude_correction / FOOT, curve.altitude_two_sigma / FOOT
    label = "correction of the altitude (±2σ)"
    return [
        *banded(curve.indicated_airspeed_kt, value, bound, GREEN, label),
        frame(AIRSPEED, "true − indicated pressure altitude [ft]"),
    ]


def point_marks(points: Sequence[FixedSpeedPoint]) -> list[Mark]:
    """The points' corrections with ±2σ bars over indicated airspeed [kt], a marker a method."""
    return [
        bars(
            [point.indicated_airspeed / KNOT for point in chosen],
            [point.correction / KNOT for point in chosen],
            [point.two_sigma / KNOT for point in chosen],
            fmt=_MARKERS[method], color=INK, ms=4.5, mfc="white", capsize=2.5, lw=1.0, zorder=4,
            label=f"{method_words(chosen[0])}, ±2σ",
        )
        for method in dict.fromkeys(point.method for point in points)
        for chosen in [[point for point in points if point.method == method]]
    ]  # fmt: skip


def bound_marks(curve: ErrorCurve, truth: MetersPerSecond | None) -> list[Mark]:
    """Return the marks of a curve's bounds: of points, of the band, for white residuals, and truth.

    The truth is the absolute true error, where known.
    """
    speed, value, bound = _in_knots(curve)
    whole, white = curve.simultaneous_two_sigma / KNOT, curve.white_two_sigma / KNOT
    true = [] if truth is None else [(np.abs(value - truth / KNOT), "black")]
    return [
        line(speed, bound, label="±2σ bound"),
        line(speed, whole, lw=1.0, ls=":", label="±2σ band of the whole curve"),
        line(speed, white, color=ORANGE, lw=1.0, label="2σ for white residuals"),
        *(line(speed, v, color=c, ls="--", lw=1.2, label="absolute true error") for v, c in true),
        frame(AIRSPEED, "bound of the correction [kt]", ylim=(0.0, None)),
    ]


def _in_knots(curve: ErrorCurve) -> tuple[Array, Array, Array]:
    """Indicated airspeed, correction and 2σ of a curve [kt]."""
    return curve.indicated_airspeed_kt, curve.correction_kt, curve.two_sigma_kt


_BIN_KT = 2.0
_DENSITY = (
    "All samples that the fit uses, also those in turns: many samples at one airspeed need "
    "not mean many legs."
)
_LONGEST_LAG = 40  # s


def residual_panels(result: Calibration, units: Units = BENCH) -> list[Panel]:
    """Data density, residuals over time and their autocorrelation."""
    residuals, bound = result.residuals, result.residual_two_sigma / KNOT
    speed, of_residual = residuals.indicated_airspeed / KNOT, f"±2σ of the residual, {bound:.2f} kt"
    edges = np.arange(np.floor(speed.min()), speed.max() + _BIN_KT, _BIN_KT).tolist()
    time, value = broken(*thin(residuals.time - result.log_start, residuals.airspeed / KNOT))
    lags, values, count = residual_autocorrelation(result)
    white = 2.0 / np.sqrt(count)
    density = drawing(
        lambda axes: axes.hist(speed, bins=edges, color=BLUE, alpha=0.75),
        frame("indicated airspeed [kt]", f"samples per {_BIN_KT:g} kt"),
        lambda axes: axes.grid(axis="x", visible=False),
    )
    over_time = drawing(
        line(time / 60.0, value, color=GRAY, lw=0.5),
        level(bound, color=RED, lw=1.2, ls="--"),
        level(-bound, color=RED, lw=1.2, ls="--", label=of_residual),
        frame("time [min]", "measured − predicted [kt]"),
    )
    correlation = drawing(
        stripe(-white, white, label="95 % band of white noise"),
        lambda axes: axes.vlines(lags, 0.0, values, color=BLUE, lw=1.5),
        level(0.0, color=GRAY),
        frame("lag [s]", "correlation of 1 s means", ylim=(-0.6, 1.05)),
    )
    return [
        panel("Data density", density, _DENSITY, units=units),
        panel("Residual", over_time, units=units),
        panel("Autocorrelation of the residual", correlation),
    ]


def residual_autocorrelation(result: Calibration) -> tuple[Array, Array, int]:
    """Return lags [s], autocorrelation and number of a residual's one-second means.

    Pauses do not count.
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


MANEUVER_COLORS = (BLUE, ORANGE, GREEN, RED, SKY, PURPLE, GRAY)
LARGE = (7.0, 4.4)  # in
_MOST_POINTS = 20_000  # more cannot be distinguished


def scatter_svg(results: "pd.DataFrame", vertical: str, horizontal: str) -> str:
    """One column of results drawn against another, a color a maneuver, as text of an SVG."""
    marks = drawing(*scatter_marks(results, vertical, horizontal), frame(horizontal, vertical))
    with stacked([marks], LARGE, legend_columns=4) as figure:
        text = svg(figure, f"{vertical} against {horizontal}")
    return (
        text
        if "xmlns=" in text
        else text.replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1)
    )


def scatter_marks(results: "pd.DataFrame", vertical: str, horizontal: str) -> list[Mark]:
    """One column of results against another, a dot a row and a color a maneuver."""
    step = max(1, -(-len(results) // _MOST_POINTS))
    return [
        dots(
            rows[horizontal],
            rows[vertical],
            color=MANEUVER_COLORS[number % len(MANEUVER_COLORS)],
            label=str(name).replace("_", " "),
            ms=6.0,
            alpha=0.6,
        )
        for number, (name, rows) in enumerate(results.iloc[::step].groupby("maneuver", sort=False))
    ]


def over_dates_panels(found: OverDates, units: Units = BENCH) -> list[Panel]:
    """The correction at three airspeeds over the dates with its ±2σ, and when it changed."""
    dates = np.asarray(date2num(found.dates))  # type: ignore[no-untyped-call]
    marks: list[Mark] = [
        bars(
            dates,
            found.correction[:, at] / KNOT,
            found.two_sigma[:, at] / KNOT,
            color=color,
            label=f"{found.airspeed[at] / KNOT:.0f} KIAS",
            marker="o",
            ms=3.5,
            lw=1.0,
            ls="none",
        )
        for at, color in enumerate((BLUE, ORANGE, GREEN))
    ]
    title = "Correction over the dates of the flights, ±2σ"
    if found.change is not None:
        before, after = dates[found.change.first - 1 : found.change.first + 1]
        middle, label = float(0.5 * (before + after)), "the correction changed"
        marks.append(lambda axes: axes.axvline(middle, color=GRAY, ls="--", label=label))
    draw = drawing(level(0.0), *marks, frame("date (UTC)", "correction [kt]"), _dated)
    return [panel(title, draw, units=units)]


def _dated(axes: Axes) -> None:
    locator = AutoDateLocator(maxticks=6)  # type: ignore[no-untyped-call]
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator))  # type: ignore[no-untyped-call]
