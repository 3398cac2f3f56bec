"""Errors with a period of their own: spectral lines that null flights do not have.

An error that follows neither a phase of flight nor a variable does not change any mean, and beneath
gusts it adds little to the sum of squares. But all of it stands at one frequency (Schuster 1898,
the periodogram). From each channel its prediction by the others is subtracted, because gusts show
in all of them and would hide the line. Louder noise raises every frequency, so a line counts by its
power over that of usual innovations.

A line is an unknown of the log: its two waves are free parameters of its channel. So it takes from
an effect what it can explain itself, and nothing else.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.estimation.information import Information
from pitotbench.reconciliation.equations import noise_residuals, scaled_to, whitened_equations
from pitotbench.reconciliation.evidence import widest
from pitotbench.reconciliation.layout import Layout, Line
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import (
    Measure,
    NullDistribution,
    measures_over,
)
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.scatter import robust_deviation
from pitotbench.units import Array

SMALLEST_POWER = 1e-12  # of a power whose logarithm is taken
BETWEEN = 8  # steps between two frequencies of the spectrum, in which a peak is looked for
MOST = 6  # lines of one log, so that the search ends
WIDE = 100.0  # noise deviations: the prior deviation of a wave


@dataclass(frozen=True, slots=True)
class SpectralLine:
    """The strongest line of a channel.

    `power` is a sum of squares, `log_ratio` the logarithm of the power over the mean square of
    usual innovations, and `period` is in s.
    """

    power: float
    log_ratio: float
    period: float


def spectral_lines(layout: Layout, noise: NoiseModel) -> dict[str, SpectralLine]:
    """Return the strongest line of each channel."""
    white = _unpredicted(layout, noise)
    power = 2.0 * np.abs(np.fft.rfft(white, axis=0)) ** 2 / len(white)
    period = len(white) * layout.grid.step / np.maximum(np.arange(len(power)), 1)
    power[: THRESHOLDS.line_periods] = 0.0
    usual = robust_deviation(white[np.any(white != 0.0, axis=1)]) ** 2
    strongest = power.argmax(axis=0)
    lines = {}
    for i, (name, k) in enumerate(zip(layout.residuals.names, strongest, strict=True)):
        ratio = float(np.log((power[k, i] + SMALLEST_POWER) / (usual[i] + SMALLEST_POWER)))
        lines[name] = SpectralLine(float(power[k, i]), ratio, float(period[k]))
    return lines


def _unpredicted(layout: Layout, noise: NoiseModel) -> Array:
    """The innovations of each channel less their prediction by the others, (n, c)."""
    innovations = noise.innovations(noise_residuals(layout), layout.grid, layout.residuals.slack)
    return noise.given_others(innovations)


def lines_over(flights: Sequence[Mapping[str, SpectralLine]]) -> dict[str, Measure]:
    """Return mean and deviation of ln of each channel's strongest line over null flights."""
    ratios = [{name: line.log_ratio for name, line in each.items()} for each in flights]
    return measures_over(ratios, THRESHOLDS.line_deviation_lowest)


def with_lines(layout: Layout, null: NullDistribution) -> Layout:
    """Return a layout with the lines that null flights do not have among its free parameters.

    Where there is none, it is the same object. Lines are looked for in what all signatures together
    leave, so that none stands for an effect. The strongest comes first, because the prediction of
    other channels by its own shows it there.
    """
    for _ in range(MOST if null.spectral_lines else 0):
        noise = scaled_to(null.noise, layout)
        rest = _without_signatures(layout, noise)
        found = _lines_of(rest, null)
        if not found:
            break
        strongest = max(found, key=lambda line: line.power)
        layout = _freed(layout, _at_peak(rest, strongest, noise), noise)
    return layout


def _without_signatures(layout: Layout, noise: NoiseModel) -> Layout:
    """A layout less what all its signatures together explain at plausible sizes.

    A signature that needs another size reproduces an error of the channel along which it was
    computed.
    """
    every = layout.signatures
    evidence = Information(whitened_equations(layout, noise, with_cells=False).inner)
    ranges = layout.parameters
    own = np.arange(len(every))
    while True:
        wide = [widest(ranges[c]) for c in own]
        sizes = evidence.posterior(own, wide).mean
        inside = [ranges[c].low <= s <= ranges[c].high for c, s in zip(own, sizes, strict=True)]
        if all(inside):
            return layout.without([every[c].column for c in own], sizes)
        own = own[inside]


def _lines_of(layout: Layout, null: NullDistribution) -> list[Line]:
    """The lines of a layout that null flights do not have."""
    each = spectral_lines(layout, null.noise)
    scores = {n: on.standardized(each[n].log_ratio) for n, on in null.spectral_lines.items()}
    told = [name for name, score in scores.items() if score > THRESHOLDS.remaining_line]
    return [Line(name, each[name].period, scores[name], each[name].power) for name in told]


def _at_peak(layout: Layout, line: Line, noise: NoiseModel) -> Line:
    """A line at its peak, which may stand between two frequencies of the spectrum."""
    own = _unpredicted(layout, noise)[:, layout.residuals.names.index(line.channel)]
    time = np.arange(len(own)) * layout.grid.step
    tried = 1.0 / line.period + np.linspace(-1.0, 1.0, 2 * BETWEEN + 1) / time[-1]
    power = np.abs(np.exp(-2.0j * np.pi * np.outer(tried, time)) @ own)
    return replace(line, period=float(1.0 / tried[int(np.argmax(power))]))


def _freed(layout: Layout, line: Line, noise: NoiseModel) -> Layout:
    """Return a layout with the waves of a line, at and around its frequency, as free parameters.

    Waves half a step of the spectrum to both sides let its amplitude change.
    """
    time = layout.track.time[layout.grid.rows]
    waves: dict[str, tuple[Array, float]] = {}
    channel = layout.residuals.names.index(line.channel)
    for aside in (-0.5, 0.0, 0.5):
        turns = (1.0 / line.period + aside / (time[-1] - time[0])) * time
        for wave in (np.cos, np.sin):
            column = np.zeros_like(layout.residuals.values)
            column[:, channel] = wave(2.0 * np.pi * turns)
            name = f"{line.channel} wave {len(layout.lines)} {len(waves)}"
            waves[name] = column, WIDE * float(noise.deviations[channel])
    return replace(layout, free=layout.free.with_columns(waves), lines=(*layout.lines, line))
