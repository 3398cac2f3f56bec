"""Tables for the terminal, for pages and for programs; units in every heading."""

from html import escape as escape_html
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAVY
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from pitotbench.records.calibration import Calibration, Estimate
from pitotbench.show.assumptions import assumption_lines, assumptions_json
from pitotbench.show.model_probabilities import choice_html, print_choice, probabilities_of
from pitotbench.show.terminal import outside
from pitotbench.units import DEGREE, FOOT, KNOT

if TYPE_CHECKING:
    import pandas as pd

CAMPAIGN_COLUMNS: dict[str, tuple[str, str]] = {
    "maneuver": ("maneuver", ""),
    "das": ("DAS\n[Hz]", ""),
    "model": ("model", ""),
    "minutes": ("time\n[min]", ".1f"),
    "samples": ("samples\n[-]", ",.0f"),
    "residual_two_sigma_kt": ("residual 2σ\n[kt]", ".2f"),
    "two_sigma_kt": ("mean curve 2σ\n[kt]", ".3f"),
    "curve_rms_error_kt": ("true rms error\n[kt]", ".3f"),
    "wind_error_kt": ("wind error\n[kt]", ".3f"),
    "curve_coverage": ("curve inside 2σ\n[%]", ".0%"),
}


_HEADINGS = (
    "indicated\n[kt]", "correction\n[kt]", "2σ\n[kt]", "2σ, whole\ncurve [kt]", "white 2σ\n[kt]", "Δp/q_c\n[-]",
    "2σ\n[-]",
)  # fmt: skip
_LEAST_SHARE = 0.005  # kt, below which a share would be printed as zero
_PLACES = {"static": "the static source", "total": "the total source", "impact": "the impact pressure"}
_ALTITUDE_HEADINGS = ("altitude\ncorr. [ft]", "2σ\n[ft]")
_STYLES = (".0f", "+.2f", ".2f", ".2f", ".2f", "+.4f", ".4f")


def campaign_table(results: "pd.DataFrame") -> "pd.DataFrame":
    """The mean over seeds of a campaign's results, one row a maneuver, data system and model."""
    keys = ["maneuver", "das", "model"]
    return results.groupby(keys, sort=False).mean(numeric_only=True).reset_index()


def print_campaign(results: "pd.DataFrame", console: Console) -> None:
    """Print the campaign's table."""
    table = Table(header_style="bold", pad_edge=False, box=SIMPLE_HEAVY)
    for heading, style in CAMPAIGN_COLUMNS.values():
        table.add_column(escape(heading), justify="right" if style else "left", no_wrap=True)
    for _, row in campaign_table(results).iterrows():
        table.add_row(*(_text(row[name], style) for name, (_, style) in CAMPAIGN_COLUMNS.items()))
    console.print(table)


def campaign_html(results: "pd.DataFrame") -> str:
    """The same table as HTML."""
    head = "".join(f"<th>{heading.replace(chr(10), '<br>')}</th>" for heading, _ in CAMPAIGN_COLUMNS.values())
    body = ""
    for _, row in campaign_table(results).iterrows():
        cells = (escape_html(_text(row[name], style)) for name, (_, style) in CAMPAIGN_COLUMNS.items())
        body += "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"
    table = f'<table class="campaign"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'
    return f'<div class="scroll">{table}</div>'


def _text(value: Any, style: str) -> str:
    return format(value, style).replace("%", "") if style else str(value)


def print_calibration(result: Calibration, console: Console) -> None:
    """Print one calibration: curve, parameters, wind, the two kinds of 2σ, warnings."""
    curve = result.curve
    table = Table(
        header_style="bold", pad_edge=False, title=f"{result.model}, method {result.method}", title_justify="left"
    )
    for heading in _HEADINGS:
        table.add_column(escape(heading), justify="right")
    altitudes = _altitudes(result)
    if altitudes[0]:
        for heading in _ALTITUDE_HEADINGS:
            table.add_column(escape(heading), justify="right")
    for row, altitude in zip(_curve_rows(result), altitudes, strict=True):
        cells = [format(value, style) for value, style in zip(row, _STYLES, strict=True)]
        table.add_row(
            *cells, *(format(value, "+.0f" if i == 0 else ".0f") for i, value in enumerate(altitude.values()))
        )
    console.print(table)
    for parameter in result.parameters:
        console.print(f"{parameter.name} = {parameter.value:+.5f} ± {parameter.two_sigma:.5f} (2σ)")
    for part in _winds(result):
        console.print(f"wind toward {part.name} {part.value / KNOT:+.2f} ± {part.two_sigma / KNOT:.2f} kt (2σ)")
    print_choice(result, console)
    for line in share_lines(result):
        console.print(outside(line))
    console.print(
        f"residual 2σ {result.residual_two_sigma / KNOT:.2f} kt, {result.samples:,} samples, "
        f"condition number {result.condition_number:.1e}; {result.reason}",
        markup=False,
    )
    for line in assumption_lines(result):
        console.print(outside(line))
    console.print(f"the error sits in: {_PLACES[result.error_location]}")
    console.print(f"x = q_ci / {result.reference_pressure:.2f} Pa; curve of {len(curve.correction)} points")
    for warning in result.warnings:
        console.print(outside(f"warning: {warning}", "yellow"))


def share_lines(result: Calibration) -> list[str]:
    """What each stated accuracy contributes to the bounds, largest first, in words."""
    curve = result.curve.two_sigma / KNOT
    total = float((curve @ curve / len(curve)) ** 0.5)
    wind = max(result.wind.north.two_sigma, result.wind.east.two_sigma) / KNOT
    return [
        f"of ±{total:.2f} kt on the curve (±{wind:.2f} kt on the wind), {share.curve / KNOT:.2f} "
        f"({share.wind / KNOT:.2f}) is {share.name} ({_found(share.estimate)} ± {share.estimate.two_sigma:.3g})"
        for share in sorted(result.shares, key=lambda share: -share.curve - share.wind)
        if max(share.curve, share.wind) > _LEAST_SHARE * KNOT
    ]


def _found(estimate: Estimate) -> str:
    """A value that is nothing beside its bound as zero: only rounding gave it digits."""
    value = estimate.value if abs(estimate.value) > 1e-6 * estimate.two_sigma else 0.0
    return f"{value:+.3g}"


def curve_html(result: Calibration) -> str:
    """The curve as an HTML table that folds away."""
    head = "".join(
        f"<th>{h}</th>"
        for h in (
            "indicated [kt]",
            "correction [kt]",
            "2σ [kt]",
            "2σ, whole curve [kt]",
            "white 2σ [kt]",
            "Δp/q<sub>c</sub> [-]",
            "2σ [-]",
        )
    )
    body = "".join(
        f"<tr><td>{s:.0f}</td><td>{v:+.2f}</td><td>{b:.2f}</td><td>{a:.2f}</td><td>{w:.2f}</td>"
        f"<td>{r:+.4f}</td><td>{rb:.4f}</td></tr>"
        for s, v, b, a, w, r, rb in _curve_rows(result)
    )
    parameters = ", ".join(f"{p.name} = {p.value:+.5f} ± {p.two_sigma:.5f}" for p in result.parameters)
    lines = [*assumption_lines(result), *share_lines(result)]
    shares = "".join(f"<p>{escape_html(line)}</p>" for line in lines)
    return (
        f'<details><summary>The curve in numbers</summary><div class="scroll"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
        f"<p>{parameters} (2σ), x = q<sub>ci</sub> / {result.reference_pressure:.2f} Pa. "
        f"{result.reason}.</p>{shares}"
        f"</details>{choice_html(result)}"
    )


def _curve_rows(result: Calibration) -> list[tuple[float, ...]]:
    c = result.curve
    columns = (
        c.indicated_airspeed / KNOT,
        c.correction / KNOT,
        c.two_sigma / KNOT,
        c.simultaneous_two_sigma / KNOT,
        c.white_two_sigma / KNOT,
        c.normalized_pressure_error,
        c.normalized_two_sigma,
    )
    return [tuple(float(v) for v in row) for row in zip(*columns, strict=True)]


def _altitudes(result: Calibration) -> list[dict[str, float]]:
    """What the error does to the altitude at each point of the curve; nothing where the static source is right."""
    curve = result.curve
    if curve.altitude_correction is None or curve.altitude_two_sigma is None:
        return [{} for _ in curve.indicated_airspeed]
    pairs = zip(curve.altitude_correction / FOOT, curve.altitude_two_sigma / FOOT, strict=True)
    return [{"altitude_correction_ft": float(value), "two_sigma_ft": float(bound)} for value, bound in pairs]


def _winds(result: Calibration) -> list[Estimate]:
    return [part for part in (result.wind.north, result.wind.east, result.wind.down) if part is not None]


def calibration_json(result: Calibration) -> dict[str, Any]:
    """A calibration as plain data with the keys of the command line's contract."""
    names = (
        "indicated_airspeed_kt",
        "correction_kt",
        "two_sigma_kt",
        "simultaneous_two_sigma_kt",
        "white_two_sigma_kt",
        "normalized_pressure_error",
        "normalized_two_sigma",
    )
    down = result.wind.down
    return {
        "model": result.model,
        "parameters": [{"name": p.name, "value": p.value, "two_sigma": p.two_sigma} for p in result.parameters],
        "wind": {
            "north_kt": result.wind.north.value / KNOT,
            "east_kt": result.wind.east.value / KNOT,
            "down_kt": down.value / KNOT if down else None,
            "north_two_sigma_kt": result.wind.north.two_sigma / KNOT,
            "east_two_sigma_kt": result.wind.east.two_sigma / KNOT,
            "down_two_sigma_kt": down.two_sigma / KNOT if down else None,
        },
        "curve": [
            dict(zip(names, row, strict=True)) | altitude
            for row, altitude in zip(_curve_rows(result), _altitudes(result), strict=True)
        ],
        "error_location": result.error_location,
        **assumptions_json(result),
        "residual_two_sigma_kt": result.residual_two_sigma / KNOT,
        "samples": result.samples,
        "converged": result.converged,
        "warnings": list(result.warnings),
        "shares": [
            {
                "name": s.name,
                "value": s.estimate.value,
                "two_sigma": s.estimate.two_sigma,
                "curve_two_sigma_kt": s.curve / KNOT,
                "wind_two_sigma_kt": s.wind / KNOT,
            }
            for s in result.shares
        ],
        "diagnostics": {k: v for k, v in (result.diagnostics or {}).items() if k != "model_choice"},
        **({"model_choice": probabilities_of(result)} if probabilities_of(result) else {}),
    }


def fixed_speed_json(
    true_airspeed: float, spread: float | None, wind_speed: float, wind_from: float
) -> dict[str, Any]:
    """A fixed-speed answer (SI) as plain data in knots and degrees."""
    return {
        "true_airspeed_kt": true_airspeed / KNOT,
        "spread_kt": None if spread is None else spread / KNOT,
        "wind_speed_kt": wind_speed / KNOT,
        "wind_from_deg": wind_from / DEGREE,
    }
