"""Pictures of a calibration: the error curve, where the data lie, what is left over."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.calibration import Calibration
from pitotbench.show.style import BLUE, GREEN, GREY, ORANGE, PALE, PURPLE, RED, broken, canvas, svg, thin
from pitotbench.units import KNOT, Array, MetersPerSecond

_FAR_SHARE, _FAR_KNOTS = 0.03, 5.0  # FAR 25.1323(c): the larger of 3 % and 5 kt
_BIN_KT = 2.0
_MODEL_COLORS = (GREEN, PURPLE, ORANGE, RED)


def calibration_figure(
    results: Mapping[str, Calibration], truth: Mapping[str, MetersPerSecond] | None = None
) -> str:
    """Error curve, data density, residuals and their autocorrelation, as SVG.

    `results` by model, the first is the one explained; `truth` is the true correction [m/s] by model, at each
    model's own airspeeds, where it is known.
    """
    first = next(iter(results.values()))
    with canvas(2, 2, 10.0, 6.6) as (figure, (curve, density, residual, correlation)):
        draw_curve(curve, results, truth)
        draw_density(density, first)
        draw_residuals(residual, first)
        draw_autocorrelation(correlation, first)
        return svg(figure)


def draw_curve(axes: Axes, results: Mapping[str, Calibration], truth: Mapping[str, MetersPerSecond] | None) -> None:
    """The correction over indicated airspeed with ±2σ, the truth where known, and the FAR limit."""
    name, first = next(iter(results.items()))
    speed, value, bound = (
        a / KNOT for a in (first.curve.indicated_airspeed, first.curve.correction, first.curve.two_sigma)
    )
    axes.fill_between(speed, value - bound, value + bound, color=BLUE, alpha=0.2, lw=0, label="±2σ, meant to cover")
    for color, (other, result) in zip(_MODEL_COLORS, list(results.items())[1:], strict=False):
        curve = result.curve
        axes.plot(curve.indicated_airspeed / KNOT, curve.correction / KNOT, color=color, lw=1.0, label=other)
    axes.plot(speed, value, color=BLUE, label=name)
    if truth is not None:
        axes.plot(speed, truth[name] / KNOT, color="black", ls="--", lw=1.2, label="truth (simulated)")
    limit = np.maximum(_FAR_SHARE * speed, _FAR_KNOTS)
    axes.plot(speed, limit, color=GREY, ls=":", lw=1.2, label="FAR 25.1323(c) limit")
    axes.plot(speed, -limit, color=GREY, ls=":", lw=1.2)
    axes.set(title="Error curve", xlabel="indicated airspeed [kt]", ylabel="calibrated − indicated airspeed [kt]")
    axes.legend(ncols=2, loc="upper center", bbox_to_anchor=(0.5, 0.9), fontsize=7.5)


def draw_density(axes: Axes, result: Calibration) -> None:
    """How many samples each stretch of airspeed holds."""
    speed = result.residuals.indicated_airspeed / KNOT
    edges = np.arange(np.floor(speed.min()), speed.max() + _BIN_KT, _BIN_KT)
    axes.hist(speed, bins=edges.tolist(), color=BLUE, alpha=0.75)
    axes.set(title="Data density", xlabel="indicated airspeed [kt]", ylabel=f"samples per {_BIN_KT:g} kt [-]")
    axes.grid(axis="x", visible=False)


def draw_residuals(axes: Axes, result: Calibration) -> None:
    """Measured minus predicted airspeed over time, with the paper's 2σ of it."""
    since = result.residuals.time - result.residuals.time[0]
    time, value = broken(*thin(since, result.residuals.airspeed / KNOT))
    bound = result.residual_two_sigma / KNOT
    axes.plot(time / 60.0, value, color=GREY, lw=0.5)
    axes.axhline(bound, color=RED, lw=1.0, ls="--")
    axes.axhline(-bound, color=RED, lw=1.0, ls="--", label=f"2σ of the residual (as published): {bound:.2f} kt")
    axes.set(title="Residual", xlabel="time [min]", ylabel="measured − predicted [kt]")
    axes.legend(loc="upper right")


def draw_autocorrelation(axes: Axes, result: Calibration) -> None:
    """Autocorrelation of one-second means of the residual: white residuals would stay inside the grey band."""
    lags, values, count = residual_autocorrelation(result)
    axes.axhspan(-2.0 / np.sqrt(count), 2.0 / np.sqrt(count), color=PALE, label="95 % band of white noise")
    axes.vlines(lags, 0.0, values, color=BLUE, lw=1.5)
    axes.axhline(0.0, color=GREY, lw=0.8)
    axes.set(
        title="Autocorrelation of the residual",
        xlabel="lag [s]",
        ylabel="correlation of 1 s means [-]",
        ylim=(-0.6, 1.05),
    )
    axes.legend(loc="upper right")


def residual_autocorrelation(result: Calibration, longest: int = 40) -> tuple[Array, Array, int]:
    """Lags [s], autocorrelation [-] and number of one-second means of the residual; pauses are left out."""
    second = np.floor(result.residuals.time - result.residuals.time[0]).astype(np.intp)
    filled = np.full(second[-1] + 1, np.nan)
    count = np.bincount(second)
    total = np.bincount(second, result.residuals.airspeed)
    filled[count > 0] = total[count > 0] / count[count > 0]
    centered = filled - np.nanmean(filled)
    longest = min(longest, len(centered) // 2)
    variance = np.nanmean(centered**2)
    values = [1.0] + [float(np.nanmean(centered[k:] * centered[:-k]) / variance) for k in range(1, longest + 1)]
    return np.arange(longest + 1.0), np.array(values), int((count > 0).sum())
