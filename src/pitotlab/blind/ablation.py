"""Which steps of the reconciliation earn their place: judge logs of a kept set with one step off at
a time.

A log is flown again from the opened truth of its set and judged by the complete chain once.
Layouts, renewed signatures, looks and formulas are kept in memory by their inputs, so that a
further judgment needs neither the force meter nor the renewal; a step that acts on what a posterior
is told as needs no posterior either. Each pair of a log and a step is a line of JSON; a run that
was stopped goes on where it was. The table tells what each score changes by with the step off, on
the same logs, with the standard error of the paired differences.
"""

import json
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from time import monotonic, process_time
from typing import Any
from unittest.mock import patch

import numpy as np
import pandas as pd

from pitotbench.bench import rounds, workflow
from pitotbench.bench.rounds import JudgedLog, NamedLog
from pitotbench.effects.effect import SensorEffect
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.log import FlightLog
from pitotbench.units import Array
from pitotlab.blind.analyze import answer_in
from pitotlab.blind.case import JudgedCase
from pitotlab.blind.flown_again import KNOWN, flown_log
from pitotlab.blind.parts import hidden_parts, kept_table, named_parts, proper_scores
from pitotlab.blind.sealed import KEPT, judged_in, kept_sets, opened
from pitotlab.blind.told import rows_of_checks, rows_of_tellings
from pitotlab.experiment import OUT

COMPLETE, FIRST_LOOK = "complete", "further looks"
AIRCRAFT = "navajo"
NEVER = 1e9
Replacement = Callable[..., Any]


@dataclass(frozen=True, slots=True)
class Step:
    """How a step is switched off: thresholds with other values, and functions with others in their
    place.

    `of_null` changes the null distribution. A step that is `told` acts after the posterior, which
    stays as it is; any other one is tried on the first look alone, beside that of the complete
    chain. One that is `renewed` acts already where signatures are renewed.
    """

    values: Mapping[str, Any] = field(default_factory=dict)
    functions: Mapping[str, Replacement] = field(default_factory=dict)
    of_null: Callable[[NullDistribution], NullDistribution] | None = None
    told: bool = False
    renewed: bool = False

    @property
    def beside(self) -> str:
        """The step whose answers are those without this one off."""
        return COMPLETE if self.told else FIRST_LOOK

    @property
    def thresholds(self) -> Mapping[str, Any]:
        """The thresholds with other values."""
        return self.values if self.told else {**self.values, "looks_most": 1}


def _nothing(*given: Any) -> tuple[Any, ...]:
    return ()


JUDGE, VERDICT = "pitotbench.reconciliation", "pitotbench.reconciliation.verdict"
NO_FLUCTUATION: Mapping[str, Replacement] = {
    f"{JUDGE}.evidence.LogEvidence._add_fluctuations": lambda log: {}
}
NO_WANDER: Mapping[str, Replacement] = {f"{JUDGE}.naming.wander_of": lambda null, channels: {}}
NO_CLOSURE_RULES: Mapping[str, Replacement] = {
    "pitotbench.bench.rounds.closure_checked": lambda looks: looks
}
NO_FORMULA: Mapping[str, Replacement] = {
    "pitotbench.bench.workflow._is_simpler": lambda *given: False
}
NO_DOUBT = {"doubt_least": 0.0, "doubt_most": 0.0, "doubt_objected": 0.0}
NO_POWERS = {"odds_above_even": 1.0, "odds_below_even": 1.0}
STEPS: Mapping[str, Step] = {
    COMPLETE: Step(told=True),
    # What the posterior weighs.
    "prior of four sizes: one": Step({"size_scales": (1.0,)}),
    "form error": Step({"form_error": 0.0}),
    "smooth error": Step({"smooth_error": 0.0}),
    "form and smooth error": Step({"form_error_from": NEVER}),
    "vanes": Step({"null_size_margin": 0.0}),
    "fluctuation": Step(functions=NO_FLUCTUATION),
    "left-over scores": Step(
        of_null=lambda null: replace(null, scores=replace(null.scores, left_over={}))
    ),
    "wander": Step(functions=NO_WANDER),
    "rest": Step({"prior_of_rest": 1e-9}),
    "temper": Step({"table_error": 0.0}),
    "sets of plain neighbors": Step(
        functions={f"{JUDGE}.posterior._with_plain_neighbors": lambda weights: weights}
    ),
    "five sizes of a rest: two": Step({"rest_sizes": (12.0, 108.0)}),
    "parts of the flight": Step(
        functions={f"{JUDGE}.naming.with_parts_of_flight": lambda layout, noise: layout},
        renewed=True,
    ),
    "sensor effects taken out": Step({"undone_from": NEVER}, renewed=True),
    # What is told of the posterior.
    "hold and power of odds above even": Step({"odds_above_even": 1.0}, told=True),
    "power of odds below even": Step({"odds_below_even": 1.0}, told=True),
    "powers and hold of the odds": Step(NO_POWERS, told=True),
    "doubt by what is left": Step({"doubt_most": THRESHOLDS.doubt_least}, told=True),
    "doubt by objections": Step({"doubt_objected": 0.0}, told=True),
    "all doubt": Step(NO_DOUBT, told=True),
    "powers, hold and doubt": Step({**NO_POWERS, **NO_DOUBT}, told=True),
    "effects of all looks at once": Step(
        functions={"pitotbench.bench.rounds.settled": lambda aircraft, looks: looks}, told=True
    ),
    "closure rules": Step(functions=NO_CLOSURE_RULES, told=True),
    "withdrawal by a formula": Step(functions=NO_FORMULA, told=True),
    "a rest asks for more closure": Step(
        {"closure_with_rest": THRESHOLDS.closure_lowest}, told=True
    ),
    "closure rules and formula": Step(functions={**NO_CLOSURE_RULES, **NO_FORMULA}, told=True),
    "a wander or line outweighs": Step(
        functions={f"{VERDICT}._outweighs": lambda *given: False}, told=True
    ),
    "lines": Step(functions={f"{VERDICT}.periodic_channels": _nothing}, told=True),
    "wandering channels": Step(functions={f"{VERDICT}.wandering_channels": _nothing}, told=True),
    "wanders and lines": Step(
        functions={
            f"{VERDICT}.wandering_channels": _nothing,
            f"{VERDICT}.periodic_channels": _nothing,
        },
        told=True,
    ),
    FIRST_LOOK: Step({"looks_most": 1}, told=True),
}


@contextmanager
def thresholds(values: Mapping[str, Any]) -> Iterator[None]:
    """The thresholds with other values, everywhere, within the context. Raises AttributeError for
    unknown ones.
    """
    before = {name: getattr(THRESHOLDS, name) for name in values}
    try:
        for name, value in values.items():
            object.__setattr__(THRESHOLDS, name, value)
        yield
    finally:
        for name, value in before.items():
            object.__setattr__(THRESHOLDS, name, value)


class Kept:
    """What the judgments of one log computed, by their inputs."""

    def __init__(self) -> None:
        self._found: dict[tuple[Any, ...], Any] = {}
        self._inputs: list[Any] = []  # an object whose address is a key must not go
        self.step = STEPS[COMPLETE]
        self.name = COMPLETE
        self.computed: dict[str, int] = {}

    @contextmanager
    def at_hand(self) -> Iterator[None]:
        """Take from here what was computed before, within the context."""
        keys: Mapping[str, Replacement] = {
            "pitotbench.bench.rounds._judged": lambda named, *others: named.name,
            "pitotbench.bench.rounds.with_effects": lambda layout, model, entries: (
                id(layout),
                repr(entries),
            ),
            f"{JUDGE}.naming.renewed_signatures": lambda layout, null: (
                id(layout),
                id(null.noise),
                self._of_step(True),
            ),
            f"{VERDICT}.name_effects": lambda layouts, nulls: (
                *map(id, layouts),
                self._of_step(False),
            ),
            "pitotbench.bench.workflow.find_formula": _formula_key,
            f"{JUDGE}.evidence.whitened_columns": lambda layout, noise: (id(layout), id(noise)),
        }
        with ExitStack() as stack:
            for path, key in keys.items():
                stack.enter_context(patch(path, self._keeping(path, key)))
            yield

    def _keeping(self, path: str, key: Replacement) -> Replacement:
        module, _, name = path.rpartition(".")
        function = getattr(import_module(module), name)

        def kept(*given: Any) -> Any:
            place = (path, key(*given))
            if place not in self._found:
                self._found[place] = function(*given)
                self._inputs.append(given)
                self.computed[name] = self.computed.get(name, 0) + 1
            found = self._found[place]
            if isinstance(found, JudgedLog) and self.step.of_null:
                return replace(found, null=self.step.of_null(found.null))
            return found

        return kept

    def _of_step(self, renewal: bool) -> str:
        """The step of a renewal or of a posterior: the complete chain where this one acts later."""
        acts = self.step.renewed if renewal else not self.step.told
        return self.name if acts else COMPLETE


def _formula_key(layout: Layout, null: NullDistribution) -> tuple[str, int]:
    return sha256(np.ascontiguousarray(layout.residuals.values).tobytes()).hexdigest(), id(
        null.noise
    )


def judged(
    name: str, log: FlightLog, steps: Sequence[str], aircraft: str = AIRCRAFT
) -> Iterator[dict[str, Any]]:
    """Yield the answer on one log for each step off, those of the chain beside which it is held
    before.
    """
    kept = Kept()
    for each in dict.fromkeys((*(STEPS[step].beside for step in steps), *steps)):
        kept.step, kept.name, begun = STEPS[each], each, process_time()
        with ExitStack() as stack:
            stack.enter_context(thresholds(kept.step.thresholds))
            stack.enter_context(kept.at_hand())
            for path, function in kept.step.functions.items():
                stack.enter_context(patch(path, function))
            try:
                answer = _answer(NamedLog(name, log), aircraft)
            except Exception as error:  # a step may be what keeps the arithmetic sound
                answer = {"kind": "crash", "why": f"{type(error).__name__}: {error}"}
        yield {
            "name": name,
            "step": each,
            "beside": kept.step.beside,
            **answer,
            "processor_s": round(process_time() - begun, 2),
        }


def _answer(named: NamedLog, aircraft: str) -> dict[str, Any]:
    first = rounds.reconcile_logs([named], aircraft)
    looks = rounds.closure_checked(rounds.settled(aircraft, rounds.iterate(aircraft, first)))
    beyond = workflow.beyond_the_table(aircraft, looks, None)
    told = rounds.with_calibrated_probabilities(beyond.looks).rounds
    return answer_in(told[0].verdict, told, beyond.formula)


# The scores of the steps.


@dataclass(frozen=True, slots=True)
class Counts:
    """The scores of one step on some logs: proper scores by log, (n, 4), and counts."""

    proper: Array
    named_right: int
    named_wrong: int
    outside_named: int
    false_alarms: int
    part_right: int
    part_wrong: int
    sure: int
    sure_right: int


PROPER = ("log_causes", "brier_causes", "log_parts", "brier_parts")
COUNTED = tuple(Counts.__dataclass_fields__)[1:]


def counts(cases: Sequence[JudgedCase]) -> Counts:
    """Score some logs: the proper scores of those with something hidden, whatever was answered."""
    hidden = [c for c in cases if c.kind != "none"]
    single = [c for c in hidden if c.kind != "outside"]
    proper = [
        [
            *proper_scores([c], lambda case: case.probabilities, lambda case: case.wanted),
            *proper_scores([c], kept_table(), hidden_parts),
        ]
        for c in hidden
    ]
    parts = named_parts(hidden, kept_table())
    sure = [
        cause in c.wanted
        for c in hidden
        for cause, p in c.probabilities.items()
        if p > THRESHOLDS.named_from
    ]
    return Counts(
        np.array(proper).reshape(-1, len(PROPER)),
        sum(c.named for c in single),
        sum(c.wrong_name for c in single),
        sum(c.wrong_name for c in hidden if c.kind == "outside"),
        sum(bool(c.groups) for c in cases if c.kind == "none"),
        parts.right,
        parts.wrong,
        len(sure),
        sum(sure),
    )


def table(
    truth: Mapping[str, Mapping[str, Any]], answers: Sequence[Mapping[str, Any]]
) -> list[dict[str, Any]]:
    """The scores of the complete chain, and what each changes by with a step off, on the logs that
    both judged.
    """
    by_step: dict[tuple[str, str], dict[str, JudgedCase]] = {}
    for each in answers:
        by_step.setdefault((each["aircraft"], each["step"]), {})[each["name"]] = JudgedCase(
            truth[each["name"]], each
        )
    rows = []
    for (aircraft, step), found in by_step.items():
        pairs = [
            (c, by_step.get((aircraft, c.answer["beside"]), {}).get(name))
            for name, c in found.items()
        ]
        held = [(case, before) for case, before in pairs if before is not None]
        off, whole = (counts(list(each)) for each in zip(*held, strict=True))
        row: dict[str, Any] = {
            "step off": step,
            "measured on": f"logs again, {aircraft}",
            "logs": len(held),
        }
        difference = off.proper if step == COMPLETE else off.proper - whole.proper
        for i, name in enumerate(PROPER):
            row[name] = f"{difference[:, i].mean():.4f}"
            row[f"{name}_se"] = (
                f"{difference[:, i].std() / np.sqrt(max(1, len(difference) - 1)):.4f}"
            )
        for name in COUNTED:
            row[name] = getattr(off, name) - (0 if step == COMPLETE else getattr(whole, name))
        rows.append(
            row | {"answers_changed": sum(case.groups != before.groups for case, before in held)}
        )
    return rows


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Judge logs of a kept set, flown again, with each step off in turn; print the table and write
    it.
    """
    parser.add_argument(
        "--set",
        default="eleventh",
        dest="kept",
        help="a set whose truth is open (default: eleventh)",
    )
    parser.add_argument("--settings", default="H,J,F,A", help="of the set, in their order")
    parser.add_argument(
        "--kinds", default="above 7=5,none=2,outside=2", help="of each setting, and how many"
    )
    parser.add_argument(
        "--aircraft",
        default=AIRCRAFT,
        help="none: the sensors alone, of which few seconds are needed",
    )
    parser.add_argument("--steps", default="", help="names with ; between them (default: all)")
    parser.add_argument(
        "--minutes",
        type=float,
        default=0.0,
        help="after which no further log begins; 0: only score",
    )
    parser.add_argument("--logs", type=Path, default=OUT / "ablation" / "logs")
    parser.add_argument("--results", type=Path, default=OUT / "ablation" / "results.jsonl")
    parser.add_argument("--table", type=Path, default=OUT / "ablation" / "ablation.csv")
    options = parser.parse_args(words)
    cases = {c["name"]: c for c in opened(KEPT / f"{options.kept}.tar.xz")["cases"]}
    steps = options.steps.split(";") if options.steps else list(STEPS)
    kinds = {
        kind: int(most)
        for kind, _, most in (each.partition("=") for each in options.kinds.split(","))
    }
    lines = options.results.read_text("utf-8").splitlines() if options.results.is_file() else []
    answers = [json.loads(line) for line in lines]
    done = {(a["name"], a["step"]) for a in answers if a["aircraft"] == options.aircraft}
    chosen = [
        case
        for letter in options.settings.split(",")
        for kind, most in kinds.items()
        for case in [c for c in cases.values() if c["settings"] == [letter] and c["kind"] == kind][
            :most
        ]
        if options.aircraft != "none"
        or all(isinstance(KNOWN[e["name"]], SensorEffect) for e in case["effects"])
    ]
    begun = monotonic()
    options.results.parent.mkdir(parents=True, exist_ok=True)
    for case in chosen:
        todo = [step for step in steps if (case["name"], step) not in done]
        if not todo or monotonic() - begun > 60.0 * options.minutes:
            continue
        log = flown_log(options.logs / f"{case['name']}.parquet", case)
        with options.results.open("a", encoding="utf-8") as out:
            for answer in judged(case["name"], log, todo, options.aircraft):
                if (case["name"], answer["step"]) not in done:
                    answers.append(answer)
                    out.write(json.dumps(answer) + "\n")
        print(
            f"{case['name']} ({case['kind']}): {(monotonic() - begun) / 60.0:.1f} min", flush=True
        )
    sets = {path.name.split(".")[0]: judged_in(path) for path in kept_sets()}
    _write(options.table, [*table(cases, answers), *rows_of_tellings(sets)])
    _write(options.table.with_name("ablation-checks.csv"), list(rows_of_checks(sets)))


def _write(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows as a table, and print it."""
    pd.DataFrame(list(rows), dtype=object).to_csv(path, index=False, lineterminator="\n")
    print(path.read_text("utf-8"))
