"""A calibration in numbers and sentences, for the terminal and for a page."""

from html import escape
from typing import TYPE_CHECKING

from pitotbench.records.calibrated_flight import CalibratedFlight
from pitotbench.records.calibration import Calibration, Estimate
from pitotbench.show.airspeed_card import GLANCE_COLUMNS, glance_points
from pitotbench.show.assumptions import assumption_lines
from pitotbench.show.columns import html_table, print_table
from pitotbench.show.curve_table import CURVE_COLUMNS, curve_points
from pitotbench.show.limit import AUTO, Limit, judgments
from pitotbench.show.model_probabilities import choice_html, print_choice
from pitotbench.show.short_answer import short_answer_of
from pitotbench.show.terminal import outside, print_warnings
from pitotbench.units import KNOT

if TYPE_CHECKING:
    from rich.console import Console

_LEAST_SHARE = 0.005  # kt, below which a share would be printed as zero
_LOCATIONS = {"static": "the static source", "total": "the total source", "impact": "the impact pressure"}


def flight_lines(flight: CalibratedFlight) -> list[str]:
    """Which flight of its log a calibration is of, and with how many it shares the curve, in at most one line."""
    told = []
    if flight.count > 1:
        time = flight.log.time
        told.append(f"flight {flight.number} of {flight.count} in the log, {time[0]:.0f} to {time[-1]:.0f} s")
    if flight.joined > 1:
        told.append(f"one curve from {flight.joined} flights, the wind of this one")
    return ["; ".join(told)] if told else []


def print_calibration(
    result: Calibration, console: "Console", limit: Limit | str | None = AUTO, details: bool = False
) -> None:
    """Print one calibration: the short answer, the warnings, the curve at round airspeeds, and the assumptions.

    `limit` as for `judgments`. With `details` also every point of the curve, the models weighed and the fit.
    """
    answer = short_answer_of(result, "")
    sentences = [answer.correction_sentence, answer.wind_sentence, *(j.sentence for j in judgments(result, limit))]
    for line in sentences:
        console.print(outside(line))
    print_warnings(result.warnings, console)
    console.print()
    if not details:
        print_table(GLANCE_COLUMNS, glance_points(result.curve), console)
        console.print()
        for line in [*location_lines(result), *assumption_lines(result)]:
            console.print(outside(line))
        return
    title = f"error curve, model {result.model}, method {result.method}"
    print_table(CURVE_COLUMNS, curve_points(result.curve), console, title)
    console.print()
    print_choice(result, console)
    fit = [*parameter_lines(result), *location_lines(result), *wind_lines(result), *assumption_lines(result)]
    for line in [*fit, *share_lines(result), *fit_lines(result)]:
        console.print(outside(line))


def calibration_html(result: Calibration) -> str:
    """The curve in numbers, the fit behind it and the models weighed, as HTML, folded away."""
    lines = [*parameter_lines(result), *wind_lines(result), *share_lines(result), *fit_lines(result)]
    return (
        "<details><summary>The curve in numbers</summary>"
        f"{html_table(CURVE_COLUMNS, curve_points(result.curve))}</details>\n"
        "<details><summary>The fit</summary>" + "".join(f"<p>{escape(line)}</p>" for line in lines) + "</details>\n"
        f"{choice_html(result)}"
    )


def condition_lines(result: Calibration) -> list[str]:
    """What the answer holds for: the model, the place of the error and the accuracies assumed."""
    model = f"model of the curve: {result.model}; samples: {result.samples:,}"
    return [model, *location_lines(result), *assumption_lines(result)]


def parameter_lines(result: Calibration) -> list[str]:
    """The parameters of the pressure-error model with their bounds, and the variable of the model."""
    values = ", ".join(f"{p.name} = {p.value:+.5f} ± {p.two_sigma:.5f}" for p in result.parameters)
    return [f"parameters (± is 2σ): {values}; x = q_ci / {result.reference_pressure:.2f} Pa"]


def location_lines(result: Calibration) -> list[str]:
    """The place of the pressure error, which decides what it does to the altitude."""
    return [f"place of the error: {_LOCATIONS[result.error_location]}"]


def wind_lines(result: Calibration) -> list[str]:
    """The components of the wind velocity with their bounds."""
    wind = result.wind
    known: list[tuple[str, Estimate | None]] = [("north", wind.north), ("east", wind.east), ("down", wind.down)]
    parts = [f"{to} {v.value / KNOT:+.2f} ± {v.two_sigma / KNOT:.2f} kt" for to, v in known if v is not None]
    return [f"wind velocity (± is 2σ): toward {', '.join(parts)}"]


def share_lines(result: Calibration) -> list[str]:
    """How much each stated accuracy widens the bounds, the largest contribution first."""
    curve = result.curve.two_sigma / KNOT
    total = float((curve @ curve / len(curve)) ** 0.5)
    wind = max(result.wind.north.two_sigma, result.wind.east.two_sigma) / KNOT
    return [
        f"{share.name} (estimated {_found(share.estimate)} ± {share.estimate.two_sigma:.3g}) contributes "
        f"±{share.curve / KNOT:.2f} kt to the curve's ±{total:.2f} kt and ±{share.wind / KNOT:.2f} kt to the "
        f"wind's ±{wind:.2f} kt (2σ, added as squares)"
        for share in sorted(result.shares, key=lambda share: -share.curve - share.wind)
        if max(share.curve, share.wind) > _LEAST_SHARE * KNOT
    ]


def _found(estimate: Estimate) -> str:
    """Return a value, or zero where it is negligible against its bound and its digits come from rounding alone."""
    value = estimate.value if abs(estimate.value) > 1e-6 * estimate.two_sigma else 0.0
    return f"{value:+.3g}"


def fit_lines(result: Calibration) -> list[str]:
    """The residual and the state of the fit."""
    return [
        f"2σ of the residual {result.residual_two_sigma / KNOT:.2f} kt, {result.samples:,} samples, "
        f"condition number {result.condition_number:.1e}; {result.reason}"
    ]
