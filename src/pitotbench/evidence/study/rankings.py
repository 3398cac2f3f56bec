"""Rank the maneuvers by the published residual, and by the true error that only a simulator knows."""

import numpy as np
import pandas as pd

from pitotbench.bench.truth_comparison import rms
from pitotbench.evidence.pages.chart_data import Chart, Lines, LineSeries
from pitotbench.evidence.study.charting import maneuver_bars
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER, named
from pitotbench.evidence.study.settings import BOTH_WAYS
from pitotbench.evidence.study.study_tables import Spread, StudyTables, rank_agreement, signed
from pitotbench.evidence.study.sweeps.sweep import Reply

_FEWEST = 9  # seeds: a correlation of fewer means nothing
_SHOWN = ("step_decrease", "rapid_decel", "race_track", "four_leg", BOTH_WAYS)


def _column(evidence: StudyTables, column: str, maneuver: str, das: str) -> pd.Series:
    return evidence.fit(column, maneuver, setting="light", method="covering", das=das)


def _order(values: dict[str, float]) -> str:
    return " < ".join(NAMES[m] for m in sorted(values, key=lambda m: values[m]))


def both_rankings(evidence: StudyTables, das: str = "50/50") -> Reply:
    """Rank the maneuvers by residual, by true error and by covering 2σ in light turbulence, and compare."""
    error = {m: rms(_column(evidence, "rms_error_kt", m, das)) for m in PAPER_ORDER}
    bound = {m: Spread.of(_column(evidence, "two_sigma_kt", m, das)).mean for m in PAPER_ORDER}
    residual = {m: Spread.of(evidence.residual(m, setting="light", das=das)).mean for m in PAPER_ORDER}
    smooth = {m: Spread.of(evidence.residual(m, das=das)).mean for m in PAPER_ORDER}
    tau = rank_agreement(np.array(list(residual.values())), np.array(list(error.values())))
    cost = ", ".join(f"{NAMES[m]} {error[m] * np.sqrt(_minutes(evidence, m)):.2f}" for m in PAPER_ORDER)
    return Reply(
        f"By residual in smooth air: {_order(smooth)}. By residual in light turbulence: {_order(residual)}. By "
        f"true error of the curve: {_order(error)}. By covering 2σ: {_order(bound)}. A small residual is no small "
        f"error: the orders by residual and by true error agree at Kendall's τ {signed(tau)}. Step Decrease has "
        f"the smallest published 2σ. Its curve is {error['step_decrease'] / error['four_leg']:.1f} times as wrong "
        "as that of 4-Leg, and it takes "
        f"{_minutes(evidence, 'step_decrease') / _minutes(evidence, 'four_leg'):.2f} of the time. A longer flight "
        "has a smaller error, as one over the square root of its time. With that taken out, true error times the "
        f"square root of the minutes is {cost} kt √min.",
        (_bars(evidence, das), _pairs(evidence, das)),
        (_numbers(evidence, das),),
    )


def _numbers(evidence: StudyTables, das: str) -> pd.DataFrame:
    rows: dict[str, dict[str, object]] = {}
    for m in PAPER_ORDER:
        published = rms(evidence.fit("rms_error_kt", m, setting="light", das=das))
        rows[m] = {
            "minutes": f"{_minutes(evidence, m):.1f}",
            "residual 2σ [kt]": Spread.of(evidence.residual(m, setting="light", das=das)).text(2),
            "true rms error of the curve [kt]": f"{rms(_column(evidence, 'rms_error_kt', m, das)):.3f}",
            "paper's method, true rms error [kt]": f"{published:.3f}",
            "covering 2σ of the curve [kt]": Spread.of(_column(evidence, "two_sigma_kt", m, das)).text(3),
            "curve inside the 2σ [%]": f"{100.0 * Spread.of(_column(evidence, 'coverage', m, das)).mean:.0f}",
        }
    return named(rows)


def _minutes(evidence: StudyTables, maneuver: str) -> float:
    return Spread.of(evidence.flight("minutes", maneuver, "light")).mean


def _bars(evidence: StudyTables, das: str) -> Chart:
    columns = {"residual": "residual_two_sigma_kt", "bound": "two_sigma_kt", "error": "rms_error_kt"}
    kinds = [
        ("residual", "2σ of the residual"),
        ("bound", "covering 2σ of the curve"),
        ("error", "true rms error of the curve"),
    ]
    return maneuver_bars(
        "rankings", "What is published, and what is known", f"Light turbulence, {das} Hz, Inverse+.",
        "2σ or rms [kt]", kinds,
        lambda m, kind: _column(evidence, columns[kind], m, das),
    )  # fmt: skip


def _pairs(evidence: StudyTables, das: str) -> Chart:
    """Draw residual against true error, one mark for each flight. The two are hardly correlated."""
    series = []
    for m in PAPER_ORDER:
        x = evidence.residual(m, setting="light", das=das)
        y = _column(evidence, "rms_error_kt", m, das)
        series.append(LineSeries(NAMES[m], x.tolist(), y.reindex(x.index).tolist(), style="marks"))
    return Lines("A small residual is not a small error", "One mark a flight.", "2σ of the residual [kt]",
                 "true rms error of the curve [kt]", series, "residual-against-error")  # fmt: skip


_ERRORS = ("wind_north_error_kt", "tilt_kt")
_LABELS = ("correlation [-]", "wind along the track, rms error [kt]", "slope of the curve, rms error [kt]")


def _confounded(evidence: StudyTables, maneuver: str, das: str) -> tuple[str, str, str]:
    """Return the correlation of the errors of wind and slope over seeds, and the rms of each [kt]."""
    wind, tilt = (_column(evidence, column, maneuver, das) for column in _ERRORS)
    alike = signed(wind.corr(tilt), 2) if len(wind.dropna()) > _FEWEST else "few seeds"
    return alike, f"{rms(wind):.2f}", f"{rms(tilt):.2f}"


def _cloud(evidence: StudyTables, maneuver: str, das: str) -> LineSeries:
    wind, tilt = (_column(evidence, column, maneuver, das).tolist() for column in _ERRORS)
    return LineSeries(NAMES[maneuver], wind, tilt, style="marks")


def confounding(evidence: StudyTables, das: str = "50/50") -> Reply:
    """Explain how an error of the wind along the track is compensated by an error of the curve's slope."""
    found = {m: _confounded(evidence, m, das) for m in _SHOWN}
    series = [_cloud(evidence, m, das) for m in _SHOWN]
    rows = [{"maneuver": NAMES[m], **dict(zip(_LABELS, found[m], strict=True))} for m in _SHOWN]
    title, note = "Wind and curve confounded", f"One mark a flight; light turbulence, {das} Hz."
    axes = "error of the wind along the track [kt]", "error, slow minus fast half [kt]"
    step, leg, both = found["step_decrease"], found["four_leg"], found[BOTH_WAYS]
    residual = [
        Spread.of(evidence.residual(m, setting="light", das=das)).mean for m in ("step_decrease", BOTH_WAYS)
    ]
    return Reply(
        "Step Decrease flies 160 to 130 kt toward north and 130 to 100 kt toward south. One knot more wind gives "
        "the same data as a curve one knot lower above 130 kt and one knot higher below. Only the turn tells them "
        f"apart. Over seeds the errors of its wind and of its slope are {step[1]} and {step[2]} kt rms "
        f"(correlation {step[0]}). Those of 4-Leg are {leg[1]} and {leg[2]} kt ({leg[0]}). The experiment flies "
        f"the same power steps with every speed on both headings. The errors are then {both[1]} and {both[2]} kt. "
        f"The residual is {residual[1]:.2f} kt instead of {residual[0]:.2f} kt, and so does not show the "
        "difference.",
        (Lines(title, note, *axes, series, "confounding"),),
        (pd.DataFrame(rows),),
    )
