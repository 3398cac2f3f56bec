"""Pictures of an error curve: the correction, its bounds, and the limit of the certification rule."""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.records.calibration import Calibration
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.show.drawing.chart import DASHED, DOTTED, Chart
from pitotbench.show.drawing.panels import chart_panel
from pitotbench.show.far_limit import far_applies, far_limit, far_verdict
from pitotbench.show.fixed_speed_tables import method_words
from pitotbench.show.palette import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, RED, Panel
from pitotbench.units import KNOT, Array, MetersPerSecond

_MODEL_COLORS = (GREEN, PURPLE, ORANGE, RED)
_MARKERS = {"turn": "o", "four_leg": "s", "three_leg": "^", "horseshoe": "v", "many_leg": "D"}
_AIRSPEED, _CORRECTION = "indicated airspeed [kt]", "correction, CAS − IAS [kt]"


def curve_panels(
    results: Mapping[str, Calibration],
    truth: Mapping[str, MetersPerSecond] | None,
    points: Sequence[FixedSpeedPoint] = (),
) -> list[Panel]:
    """The error curve, its bounds and, for an airplane that the rule is made for, the curve inside the FAR limit.

    `results` by model; the first one is explained, the others are drawn for comparison. `truth`: the true
    correction [m/s] by model, at the airspeeds of that model's curve, or None for a measured log. `points` are
    drawn over the curve.
    """
    name, first = next(iter(results.items()))
    true = None if truth is None else truth[name]
    panels = [
        chart_panel("Error curve", lambda chart: draw_curve(chart, results, true, points)),
        chart_panel("How well the curve is known", lambda chart: draw_bound(chart, first, true), legend_columns=2),
    ]
    if far_applies(first):
        title = "Against the limit of FAR 25.1323(c)"
        panels.append(chart_panel(title, lambda chart: draw_limit(chart, first), far_verdict(first)))
    return panels


def draw_curve(
    chart: Chart,
    results: Mapping[str, Calibration],
    truth: MetersPerSecond | None,
    points: Sequence[FixedSpeedPoint] = (),
) -> None:
    """Draw the correction over indicated airspeed with ±2σ, the curves of other models, and the truth where known.

    Points of fixed-speed methods lie over the curve, as in Martos et al. (2011), Fig. 13.
    """
    name, first = next(iter(results.items()))
    speed, value, bound = _knots(first)
    chart.band(speed, value - bound, value + bound, BLUE, 0.2, "±2σ")
    for color, (other, result) in zip(_MODEL_COLORS, list(results.items())[1:], strict=False):
        curve = result.curve
        chart.line(curve.indicated_airspeed / KNOT, curve.correction / KNOT, color, 1.0, label=other)
    chart.line(speed, value, BLUE, label=name)
    if truth is not None:
        chart.line(speed, truth / KNOT, "black", 1.2, DASHED, "truth (simulated)")
    draw_points(chart, points)
    chart.xlabel, chart.ylabel = _AIRSPEED, _CORRECTION


def draw_points(chart: Chart, points: Sequence[FixedSpeedPoint]) -> None:
    """Draw the points' corrections with ±2σ bars on a chart of indicated airspeed and correction [kt]."""
    for method in dict.fromkeys(point.method for point in points):
        chosen = [point for point in points if point.method == method]
        speed, value, bound = (
            np.array([getattr(point, name) / KNOT for point in chosen])
            for name in ("indicated_airspeed", "correction", "two_sigma")
        )
        chart.points(speed, value, bound, _MARKERS[method], INK, f"{method_words(chosen[0])}, ±2σ")


def draw_bound(chart: Chart, result: Calibration, truth: MetersPerSecond | None) -> None:
    """Draw the bound of each point, the band of the whole curve, the bound for white residuals, and the true error
    where known."""
    speed, value, bound = _knots(result)
    chart.line(speed, bound, BLUE, label="±2σ bound")
    whole = result.curve.simultaneous_two_sigma / KNOT
    chart.line(speed, whole, BLUE, 1.0, DOTTED, "±2σ band of the whole curve")
    chart.line(speed, result.curve.white_two_sigma / KNOT, ORANGE, 1.1, label="2σ for white residuals")
    if truth is not None:
        chart.line(speed, np.abs(value - truth / KNOT), "black", 1.2, DASHED, "absolute true error")
    chart.xlabel, chart.ylabel = _AIRSPEED, "bound of the correction [kt]"
    chart.y.fixed = (0.0, None)


def draw_limit(chart: Chart, result: Calibration) -> None:
    """Draw the curve with ±2σ between the limits of the certification rule."""
    speed, value, bound = _knots(result)
    chart.band(speed, value - bound, value + bound, BLUE, 0.2, "±2σ")
    chart.line(speed, value, BLUE, label=result.model)
    chart.line(speed, far_limit(speed), GREY, 1.4, DOTTED, "FAR limit")
    chart.line(speed, -far_limit(speed), GREY, 1.4, DOTTED)
    chart.level(0.0, INK, 0.5)
    chart.xlabel, chart.ylabel = _AIRSPEED, _CORRECTION


def _knots(result: Calibration) -> tuple[Array, Array, Array]:
    """Indicated airspeed, correction and 2σ of the curve [kt]."""
    curve = result.curve
    return curve.indicated_airspeed / KNOT, curve.correction / KNOT, curve.two_sigma / KNOT
