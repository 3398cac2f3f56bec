"""The content of the study's page: the claims, the rankings, the open questions, and how it was
done.
"""

from collections import Counter

import numpy as np
import pandas as pd

from pitotbench.campaigns.flights import rms
from pitotlab.experiment import made_with
from pitotlab.study.claims import CLAIMS, Finding
from pitotlab.study.methods import parts
from pitotlab.study.parts import Chart, Lines, LineSeries, Part, StudyPage
from pitotlab.study.questions import Reply
from pitotlab.study.reductions import BOTH_WAYS, NAMES, PAPER_ORDER, named
from pitotlab.study.sweeps import SWEEPS
from pitotlab.study.tables import Spread, StudyTables, maneuver_bars, rank_agreement, signed

_FEWEST = 9  # seeds: a correlation of fewer means nothing
_SHOWN = ("step_decrease", "rapid_decel", "race_track", "four_leg", BOTH_WAYS)


def _column(evidence: StudyTables, column: str, maneuver: str, das: str) -> pd.Series:
    return evidence.fit(column, maneuver, setting="light", method="covering", das=das)


def _order(values: dict[str, float]) -> str:
    return " < ".join(NAMES[m] for m in sorted(values, key=lambda m: values[m]))


def both_rankings(evidence: StudyTables, das: str = "50/50") -> Reply:
    """Rank the maneuvers by residual, by true error and by covering 2σ in light turbulence, and
    compare.
    """
    error = {m: rms(_column(evidence, "rms_error_kt", m, das)) for m in PAPER_ORDER}
    bound = {m: Spread.of(_column(evidence, "two_sigma_kt", m, das)).mean for m in PAPER_ORDER}
    residual = {
        m: Spread.of(evidence.residual(m, setting="light", das=das)).mean for m in PAPER_ORDER
    }
    smooth = {m: Spread.of(evidence.residual(m, das=das)).mean for m in PAPER_ORDER}
    tau = rank_agreement(np.array(list(residual.values())), np.array(list(error.values())))
    cost = ", ".join(
        f"{NAMES[m]} {error[m] * np.sqrt(_minutes(evidence, m)):.2f}" for m in PAPER_ORDER
    )
    return Reply(
        f"By residual in smooth air: {_order(smooth)}. By residual in light turbulence: "
        f"{_order(residual)}. By "
        f"true error of the curve: {_order(error)}. By covering 2σ: {_order(bound)}. A small "
        "residual is no small "
        f"error: the orders by residual and by true error agree at Kendall's τ {signed(tau)}. Step "
        "Decrease has "
        f"the smallest published 2σ. Its curve is {error['step_decrease'] / error['four_leg']:.1f} "
        "times as wrong "
        "as that of 4-Leg, and it takes "
        f"{_minutes(evidence, 'step_decrease') / _minutes(evidence, 'four_leg'):.2f} of the time. "
        "A longer flight "
        "has a smaller error, as one over the square root of its time. With that taken out, true "
        "error times the "
        f"square root of the minutes is {cost} kt √min.",
        (_bars(evidence, das), _pairs(evidence, das)),
        (_numbers(evidence, das),),
    )


def _numbers(evidence: StudyTables, das: str) -> pd.DataFrame:
    def row(m: str) -> dict[str, object]:
        published = rms(evidence.fit("rms_error_kt", m, setting="light", das=das))
        return {
            "minutes": f"{_minutes(evidence, m):.1f}",
            "residual 2σ [kt]": Spread.of(evidence.residual(m, setting="light", das=das)).text(2),
            "true rms error of the curve "
            "[kt]": f"{rms(_column(evidence, 'rms_error_kt', m, das)):.3f}",
            "paper's method, true rms error [kt]": f"{published:.3f}",
            "covering 2σ of the curve [kt]": Spread.of(
                _column(evidence, "two_sigma_kt", m, das)
            ).text(3),
            "curve inside the 2σ [%]": f"{100.0 * Spread.of(_column(evidence, 'coverage', m, das)).mean:.0f}",
        }

    return named(row)


def _minutes(evidence: StudyTables, maneuver: str) -> float:
    return Spread.of(evidence.flight("minutes", maneuver, "light")).mean


def _bars(evidence: StudyTables, das: str) -> Chart:
    kinds = [
        ("residual_two_sigma_kt", "2σ of the residual"),
        ("two_sigma_kt", "covering 2σ of the curve"),
        ("rms_error_kt", "true rms error of the curve"),
    ]
    return maneuver_bars(
        "rankings", "What is published, and what is "
                    "known", f"Light turbulence, {das} Hz, Inverse+.",
        "2σ or rms [kt]", kinds,
        lambda m, column: _column(evidence, column, m, das),
    )  # fmt: skip


def _pairs(evidence: StudyTables, das: str) -> Chart:
    """Draw residual against true error, one mark for each flight. The two are hardly correlated."""
    series = []
    for m in PAPER_ORDER:
        x = evidence.residual(m, setting="light", das=das)
        y = _column(evidence, "rms_error_kt", m, das)
        series.append(LineSeries(NAMES[m], x.tolist(), y.reindex(x.index).tolist(), style="marks"))
    return Lines("A small residual is not a small "
                 "error", "One mark a flight.", "2σ of the residual [kt]",
                 "true rms error of the curve [kt]", series, "residual-against-error")  # fmt: skip


_ERRORS = ("wind_north_error_kt", "tilt_kt")
_LABELS = (
    "correlation [-]",
    "wind along the track, rms error [kt]",
    "slope of the curve, rms error [kt]",
)


def _confounded(evidence: StudyTables, maneuver: str, das: str) -> tuple[str, str, str]:
    """Return the correlation of the errors of wind and slope over seeds, and the rms of each [kt]."""
    wind, tilt = (_column(evidence, column, maneuver, das) for column in _ERRORS)
    alike = signed(wind.corr(tilt), 2) if len(wind.dropna()) > _FEWEST else "few seeds"
    return alike, f"{rms(wind):.2f}", f"{rms(tilt):.2f}"


def _cloud(evidence: StudyTables, maneuver: str, das: str) -> LineSeries:
    wind, tilt = (_column(evidence, column, maneuver, das).tolist() for column in _ERRORS)
    return LineSeries(NAMES[maneuver], wind, tilt, style="marks")


def confounding(evidence: StudyTables, das: str = "50/50") -> Reply:
    """Explain how an error of the wind along the track is compensated by an error of the curve's
    slope.
    """
    found = {m: _confounded(evidence, m, das) for m in _SHOWN}
    series = [_cloud(evidence, m, das) for m in _SHOWN]
    rows = [{"maneuver": NAMES[m], **dict(zip(_LABELS, found[m], strict=True))} for m in _SHOWN]
    title, note = "Wind and curve confounded", f"One mark a flight; light turbulence, {das} Hz."
    axes = "error of the wind along the track [kt]", "error, slow minus fast half [kt]"
    step, leg, both = found["step_decrease"], found["four_leg"], found[BOTH_WAYS]
    residual = [
        Spread.of(evidence.residual(m, setting="light", das=das)).mean
        for m in ("step_decrease", BOTH_WAYS)
    ]
    return Reply(
        "Step Decrease flies 160 to 130 kt toward north and 130 to 100 kt toward south. One knot "
        "more wind gives "
        "the same data as a curve one knot lower above 130 kt and one knot higher below. Only the "
        "turn tells them "
        f"apart. Over seeds the errors of its wind and of its slope are {step[1]} and {step[2]} kt "
        "rms "
        f"(correlation {step[0]}). Those of 4-Leg are {leg[1]} and {leg[2]} kt ({leg[0]}). The "
        "experiment flies "
        f"the same power steps with every speed on both headings. The errors are then {both[1]} "
        f"and {both[2]} kt. "
        f"The residual is {residual[1]:.2f} kt instead of {residual[0]:.2f} kt, and so does not "
        "show the "
        "difference.",
        (Lines(title, note, *axes, series, "confounding"),),
        (pd.DataFrame(rows),),
    )


_EXPLAINING = "busy"  # a setting that is flown only with the experiments that explain
TITLE = "The simulator study of Martos, Kiszely and Foster (2011), flown again"


def study_page_of(evidence: StudyTables, findings: dict[str, Finding]) -> StudyPage:
    """Return the whole study as a page."""
    seeds, rankings = evidence.seeds, both_rankings(evidence)
    said = Counter(finding.verdict for finding in findings.values())
    short = (
        f"Of {len(findings)} claims: "
        f"{', '.join(f'{count} {verdict}' for verdict, count in said.items())}. The "
        "2σ of the claims is the paper's, of the residual in KCAS; it is no bound on the curve."
    )
    return StudyPage(
        title=TITLE,
        subtitle=f"{_seeds(len(seeds))} (development seeds), {len(evidence.flights):,} simulated "
        f"flights, {len(evidence.fits):,} calibrations; numbers are means ± standard deviations "
        "over seeds.",
        short=(short, rankings.words),
        claims=[_claim(number, finding, evidence) for number, finding in findings.items()],
        summary=_summary(findings),
        truth=[
            _reply("both rankings", "Both rankings", rankings),
            _reply(
                "confounding",
                "Why Step Decrease knows less than its residual says",
                confounding(evidence),
            ),
            *parts(),
        ],
        questions=_questions(evidence),
        method=_method(evidence),
    )


def _summary(findings: dict[str, Finding]) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {"claim": number, "the paper": f"{CLAIMS[number].words} "
                                           f"({CLAIMS[number].where})", "ours": finding.ours,
             "verdict": finding.verdict}
            for number, finding in findings.items()
        ]
    )  # fmt: skip


def _claim(number: str, finding: Finding, evidence: StudyTables) -> Part:
    claim = CLAIMS[number]
    lines = [
        ("The paper", f"{claim.words} ({claim.where})."),
        ("Reproduced means", f"{claim.criterion}."),
        ("Ours", f"{finding.ours}."),
        ("Experiment", finding.experiment),
        ("Why", finding.why),
    ]
    charts = (*_patterns(evidence), *finding.charts) if number == "C1" else finding.charts
    return Part(number, number, lines, charts, finding.tables, finding.verdict)


def _patterns(evidence: StudyTables) -> tuple[Chart, ...]:
    """Draw Fig 3: the ground track of each maneuver without wind."""
    charts = []
    for maneuver, track in evidence.tracks.groupby("maneuver", sort=False):
        on = track.where(track["on_condition"])
        series = (
            LineSeries("flown", track.east_nm.tolist(), track.north_nm.tolist()),
            LineSeries("on condition", on.east_nm.tolist(), on.north_nm.tolist()),
        )
        title = f"Fig 3: {NAMES[str(maneuver)]}"
        charts.append(
            Lines(title, "", "east [nmi]", "north [nmi]", series, f"fig3-{maneuver}", equal=True)
        )
    return tuple(charts)


def _reply(anchor: str, heading: str, reply: Reply) -> Part:
    return Part(anchor.replace(" ", "-"), heading, [("", reply.words)], reply.charts, reply.tables)


def _questions(evidence: StudyTables) -> list[Part]:
    """Return the answers to the open questions of the paper; none where the sweeps were not flown."""
    flown = set(evidence.flights["variant"])
    if not any(sortie.variant in flown for sweep in SWEEPS.values() for sortie in sweep.sorties(1)):
        return []
    return [
        _reply(n, f"{n.capitalize()}: {s.question}", s.answer(evidence)) for n, s in SWEEPS.items()
    ]


def _seeds(count: int) -> str:
    return f"Seeds 1 to {count}" if count > 1 else "Seed 1"


def _method(evidence: StudyTables) -> tuple[str, ...]:
    seeds = len(evidence.seeds)
    explained = len(
        evidence.flights.loc[evidence.flights["setting"] == _EXPLAINING, "seed"].unique()
    )
    return (
        "Every flight is simulated: a stand-in for the Navajo on JSBSim, flown by a model of a "
        "pilot through the "
        "card of the maneuver, in 15 kt of wind from 300°, at 6,000 ft. The pressure error is "
        "Inverse+; white "
        "noise ten times the instrument's specification is added to the impact pressure, as in the "
        "paper, and to "
        "the other sensors their own. The fit of the claims is the paper's: output error, white "
        "residuals, "
        "velocity held between fixes. The covering 2σ is the bench's own bound. Both fits take the "
        "paper's case, "
        "stated in full: error in the impact pressure, no altitude equation, no constant errors of "
        "the sensors "
        "(`--accuracy none`), constant wind, and clocks that agree.",
        f"{_seeds(seeds)} for the claims; {_seeds(explained).lower()} also for the experiments "
        "that explain and "
        "the sweeps. Changes of wind, vertical speed, sideslip and sampling are applied to the "
        "same flights "
        "before sensing, so that only what is asked about differs.",
        f"{made_with()}. `python -m pitotlab study --seeds {seeds}` repeats it.",
    )
