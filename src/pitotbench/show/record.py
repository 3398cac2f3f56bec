"""The record for the file, of a calibration, and of a reconciliation as a qualification test."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from pitotbench.records.calibration import Calibration, WindEstimate, WindowWind
from pitotbench.records.log import Provenance
from pitotbench.records.verdict import Check
from pitotbench.show.calibration import findings_of
from pitotbench.show.columns import Column
from pitotbench.show.deliverables import who_and_when
from pitotbench.show.markup import render
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.renderers import html_of
from pitotbench.show.tree import SOURCES, Heading
from pitotbench.show.words import capital, words
from pitotbench.timeline import minutes_text
from pitotbench.units import FOOT, KNOT

# By the code of a warning or the kind of a disagreement, the check that fails with it.
_HEADINGS, _GEOMETRY = "heading and track agree", "headings and airspeeds suffice"
_COLUMNS = "columns hold what their names say"
_FAILED_BY = {
    "latency": "latency of the GPS velocity",
    "wind": "constant wind",
    "confounded": _GEOMETRY,
    "one heading": _GEOMETRY,
    "curve size": "curve of a possible size",
    "outside prior": "sensors within their accuracies",
    "faulty rows": "no faulty rows",
    **dict.fromkeys(
        ("flights disagree", "recorders disagree", "changed over dates"), "flights agree"
    ),
    "samples": "samples and curve agree",
    "height": "wind triangle and height agree",
    "fixed_speed": "fixed-speed points and curve agree",
    "broken pitot": "pitot and static lines work",
    "reading": _COLUMNS,
    "suspect": _COLUMNS,
    **dict.fromkeys(("heading", "mirrored", "axes turned", "track"), _HEADINGS),
}

_NOT_SHOWN = "the log does not show it, or it was not looked for"


def checks_of(result: Calibration) -> list[Check]:
    """Return the checks of a calibration, passed, failed or skipped, each with its finding."""
    found, wind, made = result.diagnostics, result.wind, result.provenance
    failed: dict[str, list[str]] = (
        {} if result.converged else {"the fit converged": [result.reason]}
    )
    for each in findings_of(result):
        failed.setdefault(_FAILED_BY.get(each.kind, ""), []).append(each.words)
    late, change, agreement = found.latency, found.wind_change, found.height_agreement
    delay = ""
    if late is not None and np.isfinite(late.two_sigma):
        delay = f"{late.value:+.2f} ± {late.two_sigma:.2f} s (2σ), taken out"
    known = (
        "the wind is unknown"
        if wind is None
        else f"wind known to ±{wind_two_sigma(wind):.2f} kt (2σ)"
    )
    largest = 100.0 * float(np.max(np.abs(result.curve.normalized_pressure_error)))
    passed = {  # no finding where it was not looked for
        "the fit converged": result.reason,
        _GEOMETRY: f"condition number {result.condition_number:.1e}, {known}",
        "samples and curve agree": ""
        if result.method == "height"
        else "none lie off it by more than chance",
        "wind triangle and height agree": ""
        if agreement is None
        else f"so much apart by chance in {100.0 * agreement:.2g} % of logs",
        "fixed-speed points and curve agree": f"{len(result.points)} points"
        if result.points
        else "",
        "latency of the GPS velocity": delay,
        "constant wind": ""
        if change is None
        else f"Bayes factor of a change {change.bayes_factor:.2g}",
        _HEADINGS: "no constant angle"
        if any("heading" in each.channels for each in made.inputs)
        else "",
        "curve of a possible size": f"Δp/q_c up to {largest:.1f} %",
        _COLUMNS: "none behaves as another quantity or unit",
        "sensors within their accuracies": "no estimate lies outside its prior",
        "no faulty rows": "no row disagrees with all others",
        "flights agree": "their curves differ by no more than chance"
        if len(made.inputs) > 1
        else "",
    }
    used = result.residuals.used
    rows = [] if used.all() else [f"{int(used.sum()):,} of {len(used):,} rows used"]
    left_out = [f"left out: {', '.join(result.left_out)}"] if result.left_out else []
    less = "; ".join([*rows, *left_out])
    return [
        *(check(name, ". ".join(failed.get(name, ())), why) for name, why in passed.items()),
        check("the whole log was used", "", "" if less else "no row was left out", less),
    ]


def check(name: str, failed: str, passed: str, skipped: str = _NOT_SHOWN) -> Check:
    """Return a check that fails with a reason, else passes with a finding, else was skipped."""
    return Check(
        name, "failed" if failed else "passed" if passed else "skipped", failed or passed or skipped
    )


def wind_two_sigma(wind: WindEstimate) -> float:
    """The 2σ of the larger component of a wind [kt]."""
    return max(wind.north.two_sigma, wind.east.two_sigma) / KNOT


_STATUSES = ("failed", "passed", "skipped")
CHECK_COLUMNS: tuple[Column[Check], ...] = (
    Column("check", lambda check: check.name, key="name"),
    Column("result", lambda check: check.status, key="status"),
    Column("reason", lambda check: check.why, key="why"),
)
WIND_COLUMNS: tuple[Column[WindowWind], ...] = (
    Column("begin", lambda w: minutes_text(w.begin)),
    Column("end", lambda w: minutes_text(w.end)),
    Column("mean height", lambda w: w.altitude / FOOT, "ft", ",.0f"),
    Column("wind", lambda w: WindEstimate(w.north, w.east).speed_kt, "kt", ".1f"),
    Column("from", lambda w: WindEstimate(w.north, w.east).from_deg, "°", "03.0f"),
    Column(
        "±2σ of its larger component",
        lambda w: wind_two_sigma(WindEstimate(w.north, w.east)),
        "kt",
        ".2f",
    ),
)


def flights_checks(flights: Sequence[Calibration]) -> list[Check]:
    """Return the checks of flights with one curve, each that of the flight where it is worst."""
    found = [
        [
            replace(c, why=f"flight {n}: {c.why}")
            if c.status == "failed" and len(flights) > 1
            else c
            for c in checks_of(each)
        ]
        for n, each in enumerate(flights, start=1)
    ]
    return [min(same, key=lambda c: _STATUSES.index(c.status)) for same in zip(*found, strict=True)]


def winds_of(flights: Sequence[Calibration]) -> list[WindowWind]:
    """Return the winds of flights, on the clock of each log."""
    return [
        replace(window, begin=window.begin - each.log_start, end=window.end - each.log_start)
        for each in flights
        for window in each.winds
    ]


def conditions_of(made: Provenance, lines: Sequence[str]) -> list[str]:
    """The ranges of the logs, in the field's units, before further lines."""
    ranges = [
        f"{f.name}: {f.airspeeds[0] / KNOT:.0f} to {f.airspeeds[1] / KNOT:.0f} KIAS, pressure "
        f"altitude {f.heights[0] / FOOT:,.0f} to {f.heights[1] / FOOT:,.0f} ft (5 % to 95 % of the "
        "rows)."
        for f in made.inputs
        if f.rows
    ]
    return [*ranges, *map(capital, lines)]


def record_page(
    title: str, objective: str, made: Provenance, parts: Iterable[Heading], units: Units = BENCH
) -> str:
    """The page of a record: inputs and settings, then its parts in order, nothing folded away."""
    choices = [f"{words(c.name)}: {c.value} ({c.source})" for c in made.choices]
    choices.append(f"units: {units.words} ({units.source})")
    used = ", ".join(f"{name} {number}" for name, number in made.versions.items())
    texts = [(each.text, html_of(each.nodes, units, SOURCES)) for each in parts]
    return render(
        "record.html",
        title=title,
        identity=who_and_when(made),
        objective=objective,
        inputs=made.inputs,
        choices=choices,
        versions=f"{used}. Made on {made.date} (UTC)." if used else "Not recorded.",
        parts=[(name, text.replace("<details>", "<details open>")) for name, text in texts],
    )
