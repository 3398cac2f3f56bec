"""Make the content of the study's page from the findings."""

from collections import Counter

import pandas as pd

from pitotbench.evidence.experiment import made_with
from pitotbench.evidence.pages.chart_data import Chart, Lines, LineSeries
from pitotbench.evidence.pages.study_parts import Part, StudyPage
from pitotbench.evidence.study.claims import CLAIMS, Finding
from pitotbench.evidence.study.maneuver_names import NAMES
from pitotbench.evidence.study.rankings import both_rankings, confounding
from pitotbench.evidence.study.study_tables import StudyTables
from pitotbench.evidence.study.sweeps import SWEEPS, Reply

_EXPLAINING = "busy"  # a setting that is flown only with the experiments that explain
TITLE = "The simulator study of Martos, Kiszely and Foster (2011), flown again"


def study_page_of(evidence: StudyTables, findings: dict[str, Finding]) -> StudyPage:
    """Return the whole study as a page."""
    seeds, rankings = evidence.seeds, both_rankings(evidence)
    said = Counter(finding.verdict for finding in findings.values())
    short = (
        f"Of {len(findings)} claims: {', '.join(f'{count} {verdict}' for verdict, count in said.items())}. The "
        "2σ of the claims is the paper's, of the residual in KCAS; it is no bound on the curve."
    )
    return StudyPage(
        title=TITLE,
        subtitle=f"{_seeds(len(seeds))} (development seeds), {len(evidence.flights):,} simulated "
        f"flights, {len(evidence.fits):,} calibrations; numbers are means ± standard deviations over seeds.",
        short=(short, rankings.words),
        claims=[_claim(number, finding, evidence) for number, finding in findings.items()],
        summary=_summary(findings),
        truth=[
            _reply("both rankings", "Both rankings", rankings),
            _reply("confounding", "Why Step Decrease knows less than its residual says", confounding(evidence)),
        ],
        questions=_questions(evidence),
        method=_method(evidence),
    )


def _summary(findings: dict[str, Finding]) -> pd.DataFrame:
    return pd.DataFrame(
        [
            {"claim": number, "the paper": f"{CLAIMS[number].words} ({CLAIMS[number].where})", "ours": finding.ours,
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
        charts.append(Lines(title, "", "east [nmi]", "north [nmi]", series, f"fig3-{maneuver}", equal=True))
    return tuple(charts)


def _reply(anchor: str, heading: str, reply: Reply) -> Part:
    return Part(anchor.replace(" ", "-"), heading, [("", reply.words)], reply.charts, reply.tables)


def _questions(evidence: StudyTables) -> list[Part]:
    """Return the answers to the open questions of the paper; none where the sweeps were not flown."""
    flown = set(evidence.flights["variant"])
    if not any(sortie.variant in flown for sweep in SWEEPS.values() for sortie in sweep.sorties(1)):
        return []
    return [_reply(n, f"{n.capitalize()}: {s.question}", s.answer(evidence)) for n, s in SWEEPS.items()]


def _seeds(count: int) -> str:
    return f"Seeds 1 to {count}" if count > 1 else "Seed 1"


def _method(evidence: StudyTables) -> tuple[str, ...]:
    seeds = len(evidence.seeds)
    explained = len(evidence.flights.loc[evidence.flights["setting"] == _EXPLAINING, "seed"].unique())
    return (
        "Every flight is simulated: a stand-in for the Navajo on JSBSim, flown by a model of a pilot through the "
        "card of the maneuver, in 15 kt of wind from 300°, at 6,000 ft. The pressure error is Inverse+; white "
        "noise ten times the instrument's specification is added to the impact pressure, as in the paper, and to "
        "the other sensors their own. The fit of the claims is the paper's: output error, white residuals, "
        "velocity held between fixes. The covering 2σ is the bench's own bound. Both fits take the paper's case, "
        "stated in full: error in the impact pressure, no altitude equation, no constant errors of the sensors "
        "(`--accuracy none`), constant wind, and clocks that agree.",
        f"{_seeds(seeds)} for the claims; {_seeds(explained).lower()} also for the experiments that explain and "
        "the sweeps. Changes of wind, vertical speed, sideslip and sampling are applied to the same flights "
        "before sensing, so that only what is asked about differs.",
        f"{made_with()}. `pitotbench study --seeds {seeds}` repeats it.",
    )
