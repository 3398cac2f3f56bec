"""The study in words: the claims, the open questions, and how it was done."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import pandas as pd

from pitotbench.show.columns import frame_rows
from pitotlab.experiment import made_with
from pitotlab.study.questions import Finding, Reply
from pitotlab.study.reductions import PAPER_ORDER
from pitotlab.study.rules import RULES
from pitotlab.study.sweeps import SWEEPS
from pitotlab.study.tables import StudyTables
from pitotlab.tables import frame_columns, markdown_table

_EXPLAINING = "busy"  # a setting that is flown only with the experiments that explain
TITLE = "The simulator study of Martos, Kiszely and Foster (2011), flown again"


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
    """Return whether what the open questions change was fitted."""
    asked = {r.change for sweep in SWEEPS.values() for r in sweep.reductions(PAPER_ORDER[0])}
    return asked <= {*evidence.fits["change"]}


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
