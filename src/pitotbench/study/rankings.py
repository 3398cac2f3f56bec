"""Both rankings: the published residual, and the truth that only a simulator knows."""

import numpy as np
import pandas as pd

from pitotbench.show.chart import Chart, Lines, LineSeries
from pitotbench.study.charting import maneuver_bars
from pitotbench.study.evidence import Evidence, Spread, rank_agreement
from pitotbench.study.names import NAMES, PAPER_ORDER, named
from pitotbench.study.sweeps.sweep import Reply, rms

_SHOWN = ("step_decrease", "rapid_decel", "race_track", "four_leg")


def _column(evidence: Evidence, column: str, maneuver: str, das: str) -> pd.Series:
    return evidence.fit(column, maneuver, setting="light", method="covering", das=das)


def _order(values: dict[str, float]) -> str:
    return " < ".join(NAMES[m] for m in sorted(values, key=lambda m: values[m]))


def both_rankings(evidence: Evidence, das: str = "50/50") -> Reply:
    """The maneuvers by residual, by true error and by covering 2σ, in light turbulence; and where they disagree."""
    residual = {m: Spread.of(evidence.residual(m, setting="light", das=das)) for m in PAPER_ORDER}
    bound = {m: Spread.of(_column(evidence, "two_sigma_kt", m, das)) for m in PAPER_ORDER}
    error = {m: rms(_column(evidence, "rms_error_kt", m, das)) for m in PAPER_ORDER}
    paper = {m: rms(evidence.fit("rms_error_kt", m, setting="light", das=das)) for m in PAPER_ORDER}
    rows: dict[str, dict[str, object]] = {
        m: {
            "minutes": Spread.of(evidence.flight("minutes", m, "light")).text(1),
            "residual 2σ [kt]": residual[m].text(2),
            "true rms error of the curve [kt]": f"{error[m]:.3f}",
            "paper's method, true rms error [kt]": f"{paper[m]:.3f}",
            "covering 2σ of the curve [kt]": bound[m].text(3),
            "curve inside the 2σ [%]": f"{100.0 * Spread.of(_column(evidence, 'coverage', m, das)).mean:.0f}",
        }
        for m in PAPER_ORDER
    }
    by_residual, by_error = ({m: residual[m].mean for m in PAPER_ORDER}, error)
    tau = rank_agreement(np.array(list(by_residual.values())), np.array(list(by_error.values())))
    smooth = {m: Spread.of(evidence.residual(m)).mean for m in PAPER_ORDER}
    ratio = error["step_decrease"] / error["four_leg"]
    return Reply(
        f"By residual, smooth air: {_order(smooth)}. By residual, light turbulence: {_order(by_residual)}. By true error of "
        f"the curve: {_order(by_error)}; by covering 2σ: {_order({m: s.mean for m, s in bound.items()})}. The residual's order "
        f"and the true one agree at Kendall's τ {tau:+.1f}. The maneuver with the smallest published 2σ, Step Decrease, has "
        f"a curve {ratio:.1f} times as wrong as 4-Leg's. Per minute of flight the picture is fairer: "
        + ", ".join(f"{NAMES[m]} {error[m] * np.sqrt(_minutes(evidence, m)):.2f}" for m in PAPER_ORDER)
        + " kt times the square root of a minute.",
        (_bars(evidence, das), _pairs(evidence, das)),
        (named(rows),),
    )


def _minutes(evidence: Evidence, maneuver: str) -> float:
    return Spread.of(evidence.flight("minutes", maneuver, "light")).mean


def _bars(evidence: Evidence, das: str) -> Chart:
    columns = {"residual": "residual_two_sigma_kt", "bound": "two_sigma_kt", "error": "rms_error_kt"}
    kinds = [
        ("residual", "2σ of the residual"),
        ("bound", "covering 2σ of the curve"),
        ("error", "true rms error of the curve"),
    ]
    return maneuver_bars(
        "rankings", "What is published, and what is known", f"Light turbulence, {das} Hz, Inverse+.", "[kt]", kinds,
        lambda m, kind: _column(evidence, columns[kind], m, das),
    )  # fmt: skip


def _pairs(evidence: Evidence, das: str) -> Chart:
    """Residual against true error, one mark a flight: two clouds that do not line up."""
    series = []
    for m in PAPER_ORDER:
        x = evidence.residual(m, setting="light", das=das)
        y = _column(evidence, "rms_error_kt", m, das)
        series.append(LineSeries(NAMES[m], x.tolist(), y.reindex(x.index).tolist(), style="marks"))
    return Lines("A small residual is not a small error", "One mark a flight.", "2σ of the residual [kt]",
                 "true rms error of the curve [kt]", series, "residual-against-error")  # fmt: skip


def confounding(evidence: Evidence, das: str = "50/50") -> Reply:
    """How the wind along the track and the slope of the curve stand in for one another."""
    series, found = [], {}
    for m in _SHOWN:
        wind, tilt = (_column(evidence, column, m, das) for column in ("wind_north_error_kt", "tilt_kt"))
        series.append(LineSeries(NAMES[m], wind.tolist(), tilt.tolist(), style="marks"))
        enough = len(wind.dropna()) > 2
        found[m] = (float(wind.corr(tilt)) if enough else float("nan"), rms(wind), rms(tilt))
    chart = Lines(
        "Wind and curve confounded", f"One mark a flight; light turbulence, {das} Hz.",
        "error of the wind along the track [kt]", "error of the curve, below minus above 130 kt [kt]", series, "confounding",
    )  # fmt: skip
    step, leg = found["step_decrease"], found["four_leg"]
    rows = pd.DataFrame(
        [
            {"maneuver": NAMES[m], "correlation [-]": f"{c:+.2f}", "wind along the track, rms error [kt]": f"{w:.2f}",
             "slope of the curve, rms error [kt]": f"{t:.2f}"}
            for m, (c, w, t) in found.items()
        ]
    )  # fmt: skip
    return Reply(
        "Step Decrease flies 160 to 130 kt toward north and 130 to 100 kt toward south. A knot more wind and a curve that is "
        "a knot lower on one side and higher on the other give the same data, and only the turn tells them apart: over seeds "
        f"the error of its wind and of its slope correlate at {step[0]:+.2f} (4-Leg {leg[0]:+.2f}), and they are {step[1]:.2f} "
        f"and {step[2]:.2f} kt rms (4-Leg {leg[1]:.2f} and {leg[2]:.2f} kt). None of it shows in the residual.",
        (chart,),
        (rows,),
    )
