"""Hold the answers on edited airplanes against the truth: names, Wilson intervals, sizes, held-out
closure.
"""

import json
from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

from pitotbench.records.verdict import SURE
from pitotbench.show.columns import Column, json_rows, json_text, print_table
from pitotlab.experiment import OUT
from pitotlab.sealing import FAILED, opened
from pitotlab.sets import wilson

# The effects that name a derivative; of the controls, with the parameter that has to be beyond its
# 2σ.
NAMES: Mapping[str, tuple[str, ...]] = {
    "CL_alpha": ("lift_slope",),
    "CL_0": ("zero_lift",),
    "Cm_alpha": ("pitch_stiffness",),
    "Cm_q": ("pitch_damping",),
    "Cm_de": ("control_moments", "control_effectiveness"),
    "CY_beta": ("side_force",),
    "Cl_beta": ("dihedral_effect",),
    "Cl_p": ("roll_damping",),
    "Cl_da": ("control_moments", "control_effectiveness"),
    "Cn_beta": ("weathercock_stability",),
    "Cn_r": ("yaw_damping",),
    "Cn_dr": ("control_moments", "control_effectiveness"),
    "CD_0": ("belly_pod", "gear_not_up"),
    "CD_i": ("induced_drag",),
}
PARAMETERS = {"Cm_de": "elevator_change", "Cl_da": "aileron_change", "Cn_dr": "rudder_change"}
# Ends of the names of sizes that are shares.
SHARES = {"change": 1.0, "_share": 1.0, "_percent": 100.0}
# The size of the whole derivative of the file, where an effect tells a size and not a share.
WHOLE = {
    "drag_area_m2": {"navajo": 0.557, "c310": 0.455, "DHC6": 1.916, "c172x": 0.517},
    "factor": {"navajo": 0.0614, "DHC6": 0.0390},  # of induced drag; that of the others is a table
}
PARTIAL = ("_from_a_time", "_for_a_time")
STRONG = 7.0  # standard deviations
_SILENT = {"refused": "no answer", "crash": "no answer", "not flown": "not flown"}
OUTCOMES = (
    *("named alone", "in the set", "wrong name", "wrong set", "unknown", "none"),
    *("no answer", "not flown"),
)

Answer = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Group:
    """An effect that an answer names with its sizes, each with its 2σ, the others of its set, and
    whether a check doubts it.
    """

    name: str
    sizes: Mapping[str, Sequence[float]]
    others: tuple[str, ...]
    doubted: bool = False

    def says(self, derivative: str) -> bool:
        """Whether the effect is the changed derivative."""
        if self.name not in NAMES[derivative]:
            return False
        wanted = PARAMETERS.get(derivative)
        told = [name for name, (value, bound) in self.sizes.items() if abs(value) > bound]
        return wanted is None or wanted in told

    def holds(self, derivative: str) -> bool:
        """Whether the derivative is the effect or among the others."""
        return self.says(derivative) or any(name in NAMES[derivative] for name in self.others)


@dataclass(frozen=True, slots=True)
class ScoredTerm:
    """What became of one changed derivative.

    `significance` [σ] is that of the true effect by itself; where the answer has no such effect,
    that of the whole gap, if nothing else was changed. `inside`: the told share with its 2σ holds
    the hidden one (None where no share was told). `partial`: the right effect was named for a part
    of the flight, which is wrong.
    """

    case: str
    airplane: str
    derivative: str
    share: float
    pivot: str
    outcome: str
    significance: float | None
    inside: bool | None
    partial: bool


@dataclass(frozen=True, slots=True)
class ScoredCase:
    """A case with several changes: what was found, how many other names were told, the closures."""

    case: str
    airplane: str
    terms: tuple[ScoredTerm, ...]
    others: int
    closure: float | None
    held_out: float | None

    def found(self, *outcomes: str) -> int:
        """The number of changes with some outcome."""
        return sum(term.outcome in outcomes for term in self.terms)


def groups_of(answer: Answer) -> list[Group]:
    """What an answer names: of each gap the most probable cause, and the others of its set."""
    if answer["kind"] not in SURE:
        return []
    named, doubted = zip(answer["effects"], answer["alternatives"], strict=True), answer["doubts"]
    return [Group(n, answer["sizes"][n], tuple(rest), bool(doubted)) for n, rest in named]


def _significance(answer: Answer, derivative: str, alone: bool) -> float | None:
    """The significance of the true effect in the answer, or of the whole gap."""
    told = answer.get("scores", {})
    scores = [float(told[name]) for name in NAMES[derivative] if name in told]
    return max(scores, default=answer.get("significance") if alone else None)


def _inside(groups: Sequence[Group], airplane: str, derivative: str, share: float) -> bool | None:
    """Whether the told share with its 2σ holds the hidden one."""
    for group in groups:
        for name, (value, bound) in group.sizes.items() if group.says(derivative) else ():
            shares = [SHARES[end] for end in SHARES if name.endswith(end)]
            whole = shares[0] if shares else WHOLE.get(name, {}).get(airplane)
            if whole is not None and PARAMETERS.get(derivative, name) == name:
                return bool(abs(value - whole * share) <= bound)
    return None


def _outcome(answer: Answer, groups: Sequence[Group], derivative: str, alone: bool) -> str:
    kind = str(answer["kind"])
    if kind in _SILENT:
        return _SILENT[kind]
    holding = [group for group in groups if group.holds(derivative)]
    if any(group.says(derivative) and not (group.others or group.doubted) for group in holding):
        return "named alone" if len(groups) == 1 or not alone else "in the set"
    if holding:
        return "in the set"
    if groups:
        return "wrong name" if alone and len(groups) == 1 and not groups[0].others else "wrong set"
    return "none" if kind == "no_gap" else "unknown"


def score_case(truth: Mapping[str, Any], answer: Answer) -> ScoredCase:
    """Hold an answer against the truth of its case."""
    changes, groups = truth["changes"], groups_of(answer)
    case, airplane = truth["name"], truth["airplane"]
    alone, terms = len(changes) == 1, []
    partly = {g.name.removesuffix(end) for g in groups for end in PARTIAL if g.name.endswith(end)}
    for change in changes:
        name, share = change["derivative"], float(change["share"])
        outcome = _outcome(answer, groups, name, alone)
        significance = _significance(answer, name, alone)
        inside, partial = _inside(groups, airplane, name, share), bool(partly & set(NAMES[name]))
        about = (case, airplane, name, share, change["pivot"])
        terms.append(ScoredTerm(*about, outcome, significance, inside, partial))
    others = sum(not any(g.holds(change["derivative"]) for change in changes) for g in groups)
    closures = answer.get("closure"), answer.get("held_out")
    return ScoredCase(case, airplane, tuple(terms), others, *closures)


def score(out: Path) -> list[ScoredCase]:
    """Score the cases of a folder that have an answer, or could not be flown."""
    told = (out / "results.jsonl").read_text("utf-8").splitlines()
    answers = {each["name"]: each for each in map(json.loads, told)}
    lost = json.loads((out / FAILED).read_text("utf-8"))
    answers |= {name: {"kind": "not flown"} for name in lost}
    cases = opened(out / "seal")["cases"]
    return [score_case(c, answers[c["name"]]) for c in cases if c["name"] in answers]


# The tables: terms by strength, derivative and airplane; cases with several changes.

Row = tuple[str, Sequence[ScoredTerm]]


def rows_of(terms: Sequence[ScoredTerm], label: str) -> list[Row]:
    """Terms in groups that are not empty: all, by significance, by derivative and by airplane."""
    known = [term for term in terms if term.significance is not None]
    rows: list[Row] = [
        (label, terms),
        (f"{label}, {STRONG:g}σ or more", [t for t in known if (t.significance or 0.0) >= STRONG]),
        (f"{label}, below {STRONG:g}σ", [t for t in known if (t.significance or 0.0) < STRONG]),
    ]
    planes = sorted({term.airplane for term in terms})
    rows += [(name, [term for term in terms if term.derivative == name]) for name in NAMES]
    rows += [(name, [term for term in terms if term.airplane == name]) for name in planes]
    return [row for row in rows if row[1]]


def _judged(row: Row) -> int:
    return sum(term.outcome not in _SILENT.values() for term in row[1])


def _count(*outcomes: str) -> Callable[[Row], int]:
    return lambda row: sum(term.outcome in outcomes for term in row[1])


def _interval(*outcomes: str) -> Callable[[Row], str]:
    def text(row: Row) -> str:
        low, high = wilson(_count(*outcomes)(row), _judged(row))
        return f"{100.0 * low:.0f} to {100.0 * high:.0f}"

    return text


def _sizes(row: Row) -> str | None:
    told = [term.inside for term in row[1] if term.inside is not None]
    return f"{sum(told)} of {len(told)}" if told else None


TERM_COLUMNS: tuple[Column[Row], ...] = (
    Column("changes", lambda row: row[0], key="changes"),
    Column("judged", _judged, style="d", key="judged"),
    *(Column(name, _count(name), style="d", key=name.replace(" ", "_")) for name in OUTCOMES),
    Column("for a part", lambda row: sum(t.partial for t in row[1]), style="d", key="for_a_part"),
    Column("named alone, 95 %", _interval("named alone"), "%", key="alone_percent"),
    Column("alone or in the set", _interval("named alone", "in the set"), "%", key="found_percent"),
    Column("wrong", _interval("wrong name", "wrong set"), "%", key="wrong_percent"),
    Column("share within 2σ", _sizes, key="share_inside"),
)
CASE_COLUMNS: tuple[Column[ScoredCase], ...] = (
    Column("case", lambda case: case.case, key="case"),
    Column("airplane", lambda case: case.airplane, key="airplane"),
    Column("changes", lambda case: len(case.terms), style="d", key="changes"),
    Column("named alone", lambda case: case.found("named alone"), style="d", key="named_alone"),
    Column("in a set", lambda case: case.found("in the set"), style="d", key="in_a_set"),
    Column("other names", lambda case: case.others, style="d", key="others"),
    Column("closure", lambda case: case.closure, style=".2f", key="closure"),
    Column("closure held out", lambda case: case.held_out, style=".2f", key="held_out"),
)


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Hold the answers against the truth and print the tables: single changes, and several at once."""
    add = parser.add_argument
    add("--out", type=Path, default=OUT / "derivatives", help="folder of the set, judged")
    add("--json", action="store_true", help="print one JSON document, with every case")
    options = parser.parse_args(words)
    cases = score(options.out)
    single = [case.terms[0] for case in cases if len(case.terms) == 1]
    several = [case for case in cases if len(case.terms) > 1]
    among = [term for case in several for term in case.terms]
    tables = rows_of(single, "single"), rows_of(among, "among several")
    if options.json:
        document = {
            "single": json_rows(TERM_COLUMNS, tables[0]),
            "among_several": json_rows(TERM_COLUMNS, tables[1]),
            "several": json_rows(CASE_COLUMNS, several),
            "cases": [asdict(case) for case in cases],
        }
        print(json_text(document), end="")
        return
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True)
    titles = ("One derivative changed", "Each of several changed at once")
    for title, rows in zip(titles, tables, strict=True):
        print_table(TERM_COLUMNS, rows, console, title)
    print_table(CASE_COLUMNS, several, console, "Several changed at once")
    if held := [case.held_out for case in several if case.held_out is not None]:
        told = f"{median(held):.2f}, {len(held)} cases"
        console.print(f"median closure of the flight held out: {told}")
