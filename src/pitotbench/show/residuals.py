"""Pictures of the data behind a curve: samples by airspeed, residuals over time, and their autocorrelation."""

import numpy as np

from pitotbench.records.calibration import Calibration
from pitotbench.show.drawing.chart import DASHED, Chart
from pitotbench.show.drawing.panels import chart_panel
from pitotbench.show.palette import BLUE, GREY, PALE, RED, Panel, broken, thin
from pitotbench.units import KNOT, Array

_BIN_KT = 2.0
_DENSITY = (
    "All samples that the fit uses, also those in turns: many samples at one airspeed need not mean many legs."
)


def residual_panels(result: Calibration) -> list[Panel]:
    """Data density, residuals over time and their autocorrelation."""
    return [
        chart_panel("Data density", lambda chart: draw_density(chart, result), _DENSITY),
        chart_panel("Residual", lambda chart: draw_residuals(chart, result)),
        chart_panel("Autocorrelation of the residual", lambda chart: draw_autocorrelation(chart, result)),
    ]


def draw_density(chart: Chart, result: Calibration) -> None:
    """Draw the number of samples in each bin of indicated airspeed."""
    speed = result.residuals.indicated_airspeed / KNOT
    edges = np.arange(np.floor(speed.min()), speed.max() + _BIN_KT, _BIN_KT)
    counts, _ = np.histogram(speed, edges)
    chart.bars(edges[:-1], _BIN_KT, counts.astype(np.float64), BLUE, 0.75)
    chart.xlabel, chart.ylabel = "indicated airspeed [kt]", f"samples per {_BIN_KT:g} kt"
    chart.vertical_grid = False


def draw_residuals(chart: Chart, result: Calibration) -> None:
    """Draw measured minus predicted calibrated airspeed over time, with the ±2σ that the literature reports."""
    since = result.residuals.time - result.residuals.time[0]
    time, value = broken(*thin(since, result.residuals.airspeed / KNOT))
    bound = result.residual_two_sigma / KNOT
    chart.line(time / 60.0, value, GREY, 0.5)
    chart.level(bound, RED, 1.2, DASHED)
    chart.level(-bound, RED, 1.2, DASHED, f"±2σ of the residual, {bound:.2f} kt")
    chart.xlabel, chart.ylabel = "time [min]", "measured − predicted [kt]"


def draw_autocorrelation(chart: Chart, result: Calibration) -> None:
    """Draw the autocorrelation of one-second means of the residual; white noise stays inside the grey band."""
    lags, values, count = residual_autocorrelation(result)
    white = 2.0 / float(np.sqrt(count))
    chart.zone(-white, white, PALE, "95 % band of white noise")
    chart.sticks(lags, values, BLUE, 1.5)
    chart.level(0.0, GREY, 0.8)
    chart.xlabel, chart.ylabel = "lag [s]", "correlation of 1 s means"
    chart.y.fixed = (-0.6, 1.05)


def residual_autocorrelation(result: Calibration, longest: int = 40) -> tuple[Array, Array, int]:
    """Lags [s], autocorrelation and number of one-second means of the residual; pauses do not count."""
    second = np.floor(result.residuals.time - result.residuals.time[0]).astype(np.intp)
    filled = np.full(second[-1] + 1, np.nan)
    count = np.bincount(second)
    total = np.bincount(second, result.residuals.airspeed)
    filled[count > 0] = total[count > 0] / count[count > 0]
    centered = filled - np.nanmean(filled)
    variance = np.nanmean(centered**2)
    products = [centered[k:] * centered[: len(centered) - k] for k in range(min(longest, len(centered) // 2) + 1)]
    lags = [k for k, product in enumerate(products) if np.isfinite(product).any()]
    values = [float(np.nanmean(products[k]) / variance) for k in lags]
    return np.array(lags, dtype=np.float64), np.array(values), int((count > 0).sum())
