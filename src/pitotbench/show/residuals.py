"""Pictures of the data behind a curve: samples by airspeed, residuals over time, and their autocorrelation."""

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.calibration import Calibration
from pitotbench.show.style import BLUE, GREY, PALE, RED, Panel, broken, panel, thin
from pitotbench.units import KNOT, Array

_BIN_KT = 2.0
_DENSITY = (
    "All samples that the fit uses, also those in turns: many samples at one airspeed need not mean many legs."
)


def residual_panels(result: Calibration) -> list[Panel]:
    """Data density, residuals over time and their autocorrelation."""
    return [
        panel("Data density", lambda axes: draw_density(axes, result), _DENSITY),
        panel("Residual", lambda axes: draw_residuals(axes, result)),
        panel("Autocorrelation of the residual", lambda axes: draw_autocorrelation(axes, result)),
    ]


def draw_density(axes: Axes, result: Calibration) -> None:
    """Draw the number of samples in each bin of indicated airspeed."""
    speed = result.residuals.indicated_airspeed / KNOT
    edges = np.arange(np.floor(speed.min()), speed.max() + _BIN_KT, _BIN_KT)
    axes.hist(speed, bins=edges.tolist(), color=BLUE, alpha=0.75)
    axes.set(xlabel="indicated airspeed [kt]", ylabel=f"samples per {_BIN_KT:g} kt")
    axes.grid(axis="x", visible=False)


def draw_residuals(axes: Axes, result: Calibration) -> None:
    """Draw measured minus predicted calibrated airspeed over time, with the ±2σ that the literature reports."""
    since = result.residuals.time - result.residuals.time[0]
    time, value = broken(*thin(since, result.residuals.airspeed / KNOT))
    bound = result.residual_two_sigma / KNOT
    axes.plot(time / 60.0, value, color=GREY, lw=0.5)
    axes.axhline(bound, color=RED, lw=1.2, ls="--")
    axes.axhline(-bound, color=RED, lw=1.2, ls="--", label=f"±2σ of the residual, {bound:.2f} kt")
    axes.set(xlabel="time [min]", ylabel="measured − predicted [kt]")


def draw_autocorrelation(axes: Axes, result: Calibration) -> None:
    """Draw the autocorrelation of one-second means of the residual; white noise stays inside the grey band."""
    lags, values, count = residual_autocorrelation(result)
    axes.axhspan(-2.0 / np.sqrt(count), 2.0 / np.sqrt(count), color=PALE, label="95 % band of white noise")
    axes.vlines(lags, 0.0, values, color=BLUE, lw=1.5)
    axes.axhline(0.0, color=GREY, lw=0.8)
    axes.set(xlabel="lag [s]", ylabel="correlation of 1 s means", ylim=(-0.6, 1.05))


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
