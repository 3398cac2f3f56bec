"""The study in words: the claims, the rankings, the open questions, and how it was done."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np
import pandas as pd

from pitotbench.campaigns.flights import rms
from pitotbench.show.columns import frame_rows
from pitotlab.experiment import made_with
from pitotlab.study.questions import Finding, Reply
from pitotlab.study.reductions import BOTH_WAYS, NAMES, PAPER_ORDER, named
from pitotlab.study.rules import RULES
from pitotlab.study.sweeps import SWEEPS
from pitotlab.study.tables import StudyTables, mean, order, rank_agreement, signed, text
from pitotlab.tables import frame_columns, markdown_table

_FEWEST = 9  # seeds: a correlation of fewer means nothing
_SHOWN = ("step_decrease", "rapid_decel", "race_track", "four_leg", BOTH_WAYS)
_EXPLAINING = "busy"  # a setting that is flown only with the experiments that explain
TITLE = "The simulator study of Martos, Kiszely and Foster (2011), flown again"


def _column(evidence: StudyTables, maneuver: str, column: str) -> pd.Series:
    """Return a column of the covering fits in light turbulence."""
    return evidence.fit(column, maneuver, setting="light", method="covering")


def _minutes(evidence: StudyTables, maneuver: str) -> float:
    return mean(evidence.flight("minutes", maneuver, "light"))


def both_rankings(evidence: StudyTables) -> Reply:
    """Rank the maneuvers by residual, true error and covering 2σ in light turbulence."""
    error = {m: rms(_column(evidence, m, "rms_error_kt")) for m in PAPER_ORDER}
    bound = {m: mean(_column(evidence, m, "two_sigma_kt")) for m in PAPER_ORDER}
    smooth, residual = (
        {m: mean(evidence.residual(m, setting=air)) for m in PAPER_ORDER}
        for air in ("smooth", "light")
    )
    tau = rank_agreement(np.array([*residual.values()]), np.array([*error.values()]))
    minutes = {m: _minutes(evidence, m) for m in PAPER_ORDER}
    cost = ", ".join(f"{NAMES[m]} {error[m] * np.sqrt(minutes[m]):.2f}" for m in PAPER_ORDER)
    return Reply(
        f"By residual in smooth air: {order(smooth)}. By residual in light turbulence: "
        f"{order(residual)}. By true error of the curve: {order(error)}. By covering 2σ: "
        f"{order(bound)}. A small residual is no small error: the orders by residual and by true "
        f"error agree at Kendall's τ {signed(tau)}. Step Decrease has the smallest published 2σ. "
        f"Its curve is {error['step_decrease'] / error['four_leg']:.1f} times as wrong as that of "
        f"4-Leg, and it takes {minutes['step_decrease'] / minutes['four_leg']:.2f} of the time. A "
        "longer flight has a smaller error, as one over the square root of its time. With that "
        f"taken out, true error times the square root of the minutes is {cost} kt √min.",
        (named(partial(_numbers, evidence)),),
    )


def _numbers(evidence: StudyTables, maneuver: str) -> dict[str, object]:
    column = partial(_column, evidence, maneuver)
    published = rms(evidence.fit("rms_error_kt", maneuver, setting="light"))
    return {
        "minutes": f"{_minutes(evidence, maneuver):.1f}",
        "residual 2σ [kt]": text(evidence.residual(maneuver, setting="light")),
        "true rms error of the curve [kt]": f"{rms(column('rms_error_kt')):.3f}",
        "paper's method, true rms error [kt]": f"{published:.3f}",
        "covering 2σ of the curve [kt]": text(column("two_sigma_kt"), 3),
        "curve inside the 2σ [%]": f"{100.0 * mean(column('coverage')):.0f}",
    }


def confounding(evidence: StudyTables) -> Reply:
    """Explain how an error of the wind along the track bends the curve."""
    rows, found = [], {}
    for m in _SHOWN:
        wind, tilt = (_column(evidence, m, name) for name in ("wind_north_error_kt", "tilt_kt"))
        alike = signed(wind.corr(tilt), 2) if len(wind.dropna()) > _FEWEST else "few seeds"
        found[m] = rms(wind), rms(tilt), alike
        rows.append(
            {
                "maneuver": NAMES[m],
                "correlation [-]": alike,
                "wind along the track, rms error [kt]": f"{rms(wind):.2f}",
                "slope of the curve, rms error [kt]": f"{rms(tilt):.2f}",
            }
        )
    step, leg, both = found["step_decrease"], found["four_leg"], found[BOTH_WAYS]
    residual = [mean(evidence.residual(m, setting="light")) for m in ("step_decrease", BOTH_WAYS)]
    return Reply(
        "Step Decrease flies 160 to 130 kt toward north and 130 to 100 kt toward south. One knot "
        "more wind gives the same data as a curve one knot lower above 130 kt and one knot higher "
        "below. Only the turn tells them apart. Over seeds the errors of its wind and of its slope "
        f"are {step[0]:.2f} and {step[1]:.2f} kt rms (correlation {step[2]}). Those of 4-Leg are "
        f"{leg[0]:.2f} and {leg[1]:.2f} kt ({leg[2]}). The experiment flies the same power steps "
        f"with every speed on both headings. The errors are then {both[0]:.2f} and {both[1]:.2f} "
        f"kt. The residual is {residual[1]:.2f} kt instead of {residual[0]:.2f} kt, and so does "
        "not show the difference.",
        (pd.DataFrame(rows),),
    )


def study_text(evidence: StudyTables, findings: Mapping[str, Finding]) -> str:
    """Return the whole study as Markdown: what was found, and how."""
    return "\n\n".join(_paragraphs(evidence, findings)) + "\n"


def _paragraphs(evidence: StudyTables, findings: Mapping[str, Finding]) -> Iterator[str]:
    said = Counter(finding.verdict for finding in findings.values())
    yield f"# {TITLE}"
    yield (
        f"{_seeds(evidence.seeds)}, {len(evidence.flights):,} simulated flights, "
        f"{len(evidence.fits):,} calibrations; numbers are means ± standard deviations over seeds."
    )
    yield (
        f"Of {len(findings)} claims: "
        f"{', '.join(f'{count} {verdict}' for verdict, count in said.items())}. The 2σ of the "
        "claims is the paper's, of the residual in KCAS; it is no bound on the curve."
    )
    for number, finding in findings.items():
        yield from _claim(number, finding)
    yield "## What the residual does not show"
    for reply in (both_rankings(evidence), confounding(evidence)):
        yield from _told(reply)
    if _swept(evidence):
        yield "## Open questions"
        for name, sweep in SWEEPS.items():
            yield f"### {name.capitalize()}: {sweep.question}"
            yield from _told(sweep.answer(evidence))
    yield "## How it was done"
    yield from _method(evidence)


def _claim(number: str, finding: Finding) -> Iterator[str]:
    rule = RULES[number]
    yield f"## {number}: {finding.verdict}"
    yield f"The paper: {rule.words} ({rule.where})."
    yield f"Measured: {rule.quantity}."
    yield f"Reproduced means: {rule.criterion}."
    yield f"Ours: {finding.ours}."
    yield f"Experiment: {finding.experiment}"
    yield f"Why: {finding.why}"
    yield from map(table_text, finding.tables)


def _told(reply: Reply) -> Iterator[str]:
    yield reply.words
    yield from map(table_text, reply.tables)


def table_text(table: pd.DataFrame) -> str:
    """Return a table as Markdown."""
    return markdown_table(frame_columns(table), frame_rows(table))


def _swept(evidence: StudyTables) -> bool:
    """Return whether the flights of the open questions were flown."""
    flown = set(evidence.flights["variant"])
    return any(s.variant in flown for sweep in SWEEPS.values() for s in sweep.sorties(1))


def _seeds(seeds: Sequence[int]) -> str:
    if not seeds:
        return "No seed"
    return f"Seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"Seed {seeds[0]}"


def _method(evidence: StudyTables) -> tuple[str, ...]:
    seeds, flights = evidence.seeds, evidence.flights
    explained = sorted(flights.loc[flights["setting"] == _EXPLAINING, "seed"].unique())
    return (
        "Every flight is simulated: a stand-in for the Navajo on JSBSim, flown by a model of a "
        "pilot through the card of the maneuver, in 15 kt of wind from 300°, at 6,000 ft. The "
        "pressure error is Inverse+; white noise ten times the instrument's specification is added "
        "to the impact pressure, as in the paper, and to the other sensors their own. The fit of "
        "the claims is the paper's: output error, white residuals, velocity held between fixes. "
        "The covering 2σ is the bench's own bound. Both fits take the paper's case, stated in "
        "full: error in the impact pressure, no altitude equation, no constant errors of the "
        "sensors (`--accuracy none`), constant wind, and clocks that agree.",
        f"{_seeds(seeds)} for the claims; {_seeds(explained).lower()} also for the experiments "
        "that explain and the sweeps. Changes of wind, vertical speed, sideslip and sampling are "
        "applied to the same flights before sensing, so that only what is asked about differs.",
        f"{made_with()}. `python -m pitotlab study --first {seeds[0]} --seeds {len(seeds)}` repeats it.",
    )
