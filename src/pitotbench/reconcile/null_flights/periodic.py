"""Errors with a period of their own: a line in the spectrum of a channel that null flights do not have.

An error that follows neither a phase of flight nor a variable does not change any mean, and beneath gusts it adds
little to the sum of squares. But all of it stands at one frequency (Schuster 1898, the periodogram). From each
channel its prediction by the others is subtracted, because gusts show in all of them and would hide the line.
Louder noise raises every frequency, so a line counts by its power over that of usual innovations.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.estimate.robust_scale import robust_deviation
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.null_flights.null_measure import Measure, measures_over
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import noise_residuals
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.records.verdict import Located

SMALLEST = 1e-12  # of a power whose logarithm is taken


@dataclass(frozen=True, slots=True)
class SpectralLine:
    """The strongest line of a channel.

    `power` is a sum of squares, `log_ratio` the logarithm of the power over the mean square of usual innovations,
    and `period` is in s.
    """

    power: float
    log_ratio: float
    period: float


def spectral_lines(layout: Layout, noise: NoiseModel) -> dict[str, SpectralLine]:
    """Return the strongest line of each channel."""
    innovations = noise.innovations(noise_residuals(layout), layout.grid, layout.residuals.slack)
    white = noise.given_others(innovations)
    power = 2.0 * np.abs(np.fft.rfft(white, axis=0)) ** 2 / len(white)
    period = len(white) * layout.grid.step / np.maximum(np.arange(len(power)), 1)
    power[: THRESHOLDS.line_periods] = 0.0
    usual = robust_deviation(white[np.any(white != 0.0, axis=1)]) ** 2
    strongest = power.argmax(axis=0)
    lines = {}
    for i, (name, k) in enumerate(zip(layout.residuals.names, strongest, strict=True)):
        ratio = float(np.log((power[k, i] + SMALLEST) / (usual[i] + SMALLEST)))
        lines[name] = SpectralLine(float(power[k, i]), ratio, float(period[k]))
    return lines


def lines_over(flights: Sequence[Mapping[str, SpectralLine]]) -> dict[str, Measure]:
    """Return mean and deviation of the logarithm of each channel's strongest line over null flights."""
    ratios = [{name: line.log_ratio for name, line in each.items()} for each in flights]
    return measures_over(ratios, THRESHOLDS.line_deviation_lowest)


def periodic_channels(layout: Layout, null: NullDistribution, explained: float) -> tuple[Located, ...]:
    """Return the channels with a line that null flights do not have, the worst one first.

    `explained` is the fall of the sum of squares by the named effects. A line counts if it is significant and is
    more than a share of `explained` that an imperfect signature may leave.
    """
    lines, located = spectral_lines(layout, null.noise), []
    for name, on_null in null.spectral_lines.items():
        score = on_null.standardized(lines[name].log_ratio)
        is_large = lines[name].power > THRESHOLDS.remaining_share * explained
        if score > THRESHOLDS.remaining_line and is_large:
            located.append(Located(name, "", f"a period of {lines[name].period:.0f} s", score))
    return tuple(sorted(located, key=lambda place: -place.significance))
