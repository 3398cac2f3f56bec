"""Further looks at judged cases: a set flown again, the card with the patch, a wrong effect forced
in.

`blind again` flies an opened set from its truth, with truth and seal beside the logs, for a later
build to judge. `blind reflown` and `blind forced` take cases of one flight whose effect was named
rightly. A gap flown again is the root mean square over the segments of the card, of measured less
simulated, in units of the chance between two flights; the chance itself is taken out. The effects
forced in are drawn among those that improve the log at a plausible size, and whose cause is neither
the hidden one nor left by the answer.
"""

import json
from argparse import ArgumentParser
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from pitotbench.bench.workflow import NamedLog, closure_on, reconcile_fully
from pitotbench.effects import FORMS
from pitotbench.effects.effect import Effect, SensorEffect
from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.equations import Fit
from pitotbench.reconciliation.evidence import significance
from pitotbench.reconciliation.regression import Sizes
from pitotbench.reconciliation.signatures import Signature, columns_of, returns
from pitotbench.records.gap import Feature
from pitotbench.records.log import FlightLog
from pitotlab.blind.case import JudgedCase, model_of
from pitotlab.blind.drawn import HiddenCase, HiddenEffect, bend_of, log_of, write_cases
from pitotlab.blind.flown import SETTINGS, Environment
from pitotlab.blind.outsiders import HIDDEN_EFFECTS
from pitotlab.blind.sealed import KEPT, PLACE, files_of, judged_in, opened


def case_of(told: Mapping[str, Any]) -> HiddenCase:
    """The hidden case of an entry of the truth."""
    effects = tuple(
        HiddenEffect(
            e["name"], e["sizes"], tuple(e["strengths"]), tuple(e["part"]) if e["part"] else None
        )
        for e in told["effects"]
    )
    return HiddenCase(
        told["kind"], tuple(told["settings"]), effects, Environment(**told["environment"])
    )


KNOWN: Mapping[str, Effect] = {**FORMS, **HIDDEN_EFFECTS}
SHOWN = 3.0  # gap before, in units of chance, from which a case shows anything
QUANTITIES = ("manifold pressure", "pitch", "change of airspeed")


def gap(features: Sequence[Feature], patched: bool) -> float:
    """The root mean square of the differences beyond chance, which is that of all segments of a
    quantity.
    """
    ratios: list[float] = []
    for name in {f.name for f in features}:
        own = [f for f in features if f.name == name]
        chance = float(np.mean([f.deviation**2 for f in own]))
        ratios += [
            (f.measured - (f.patched if patched else f.simulated)) ** 2 / chance for f in own
        ]
    return float(np.sqrt(max(0.0, float(np.mean(ratios)) - 1.0))) if ratios else 0.0


def reflown(logs: Path, cases: Sequence[JudgedCase], most: int) -> Iterator[Mapping[str, Any]]:
    """The gap of each case before and after the patch, by quantity."""
    told = 0
    for case in cases:
        names = [e["name"] for e in case.truth["effects"]]
        if (
            case.flights != 1
            or not case.named
            or any(isinstance(KNOWN[n], SensorEffect) for n in names)
        ):
            continue
        name = case.truth["name"]
        full = reconcile_fully(NamedLog(name, flown_log(logs / f"{name}.parquet", case.truth)))
        every = full.account.flown.features
        wanted = [f for f in every if f.name in QUANTITIES]
        if gap(wanted, patched=False) < SHOWN:
            continue
        told += 1
        rows = {q: [f for f in wanted if f.name == q] for q in QUANTITIES}
        yield {
            "case": name,
            "effect": names,
            "before": round(gap(wanted, patched=False), 2),
            "after": round(gap(wanted, patched=True), 2),
            **{
                q: [round(gap(r, patched=False), 2), round(gap(r, patched=True), 2)]
                for q, r in rows.items()
            },
        }
        if told == most:
            return


def flown_log(path: Path, told: Mapping[str, Any]) -> FlightLog:
    """The log of the first flight of a case, as it was written or flown anew."""
    if path.is_file():
        return read_log(path)
    bend = bend_of(told["seed"])
    log = log_of(case_of(told), SETTINGS[told["settings"][0]], told["seed"], bend)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_log(log, path)
    return read_log(path)


SEEN = 3.0  # σ by which a wrong effect improves the log that it is forced into; one of no gain is forced by nobody
CLOSES = 0.3  # share of the gap held out that a wrong effect must not close


def is_in_range(signatures: Sequence[Signature], fit: Fit) -> bool:
    """Whether all sizes lie within 2σ of their plausible ranges."""
    ranges = [FORMS[signatures[c].effect].parameter(signatures[c].parameter) for c in fit.columns]
    each = zip(ranges, fit.sizes, 2.0 * fit.deviations, strict=True)
    return all(
        p.low - slack <= size <= p.high + slack or abs(size) <= slack for p, size, slack in each
    )


def forced(logs: Path, cases: Sequence[JudgedCase], wrong: int) -> Iterator[Mapping[str, Any]]:
    """The share of the gap of the flight held out that each forced effect closes, beside that of
    the named one.
    """
    for case in cases:
        name = case.truth["name"]
        held = logs / f"{name}-held.parquet"
        if case.flights != 1 or not case.named or len(case.wanted) != 1 or not held.is_file():
            continue
        found = reconcile_fully(NamedLog("log", read_log(logs / f"{name}.parquet")), refly=False)
        other, aircraft, shown = read_log(held), aircraft_model("navajo"), found.judged.shown[0]
        signatures, equations = shown.block.layout.signatures, shown.block.equations
        fits = {
            n: equations.fit(own)
            for n, own in columns_of(signatures).items()
            if n in FORMS and returns(n)
        }
        fits = {n: fit for n, fit in fits.items() if is_in_range(signatures, fit)}
        likely = {model_of(c) for c, p in found.probabilities.items() if p > 0.01}
        open_to = [
            n
            for n, f in fits.items()
            if significance(f) > SEEN and model_of(n) not in case.wanted | likely
        ]
        random = np.random.default_rng(crc32(name.encode()))
        for effect in random.permutation(open_to)[:wrong].tolist():
            fit, fitted = fits[effect], found.judged.fitted
            member = replace(fitted.gaps[0].member, name=effect)
            wrongly = replace(
                fitted,
                gaps=(replace(fitted.gaps[0], member=member),),
                sizes=Sizes(
                    tuple((effect, signatures[c].parameter) for c in fit.columns),
                    fit.sizes,
                    fit.covariance,
                ),
            )
            first = found.logs[0]
            closed = closure_on(other, aircraft, first, wrongly)
            if closed is None:
                continue
            yield {
                "case": name,
                "effect": case.truth["effects"][0]["name"],
                "forced": effect,
                "significance": round(significance(fits[effect]), 1),
                "closure": round(closed.share, 3),
                "named": case.answer.get("held_out"),
            }


def again_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly a kept set again from its opened truth, and write its logs, its truth and its seal into a
    folder.
    """
    parser.add_argument("name", help="of the set: eleventh")
    parser.add_argument(
        "--folder", type=Path, default=PLACE, help="folder of the set (default: %(default)s)"
    )
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args(words)
    kept, seal = files_of(KEPT / f"{options.name}.tar.xz"), options.folder / "seal"
    seal.mkdir(parents=True, exist_ok=True)
    for name in ("truth.json", "truth.sha256"):
        (seal / name).write_bytes(kept[name])
    truth = opened(seal)
    cases, held = (
        [case_of(told) for told in truth["cases"]],
        [told["held_out"] for told in truth["cases"]],
    )
    write_cases(options.folder / "logs", truth["seed"], cases, held, options.jobs)


def reflown_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly the cards of named cases with the patch: how much of the gap in power, pitch and speed it
    closes.
    """
    logs, cases, most = _judged_cases(parser, words, "--most", 20)
    closed = 0
    for count, line in enumerate(reflown(logs, cases, most), start=1):
        closed += line["after"] <= 0.1 * line["before"]
        print(json.dumps(line), f"closed to a tenth: {closed} of {count}", flush=True)


def forced_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Force wrong effects into named cases: how much of the gap of the flight held out each closes."""
    logs, cases, wrong = _judged_cases(parser, words, "--wrong", 4)
    below = 0
    for count, line in enumerate(forced(logs, cases, wrong), start=1):
        below += line["closure"] < CLOSES
        print(json.dumps(line), f"below {CLOSES}: {below} of {count}", flush=True)


def _judged_cases(
    parser: ArgumentParser, words: Sequence[str], most: str, default: int
) -> tuple[Path, list[JudgedCase], int]:
    """The folder of logs, the cases, and the value of the flag `most`."""
    parser.add_argument("--logs", type=Path, default=PLACE / "logs")
    parser.add_argument("--results", type=Path, default=PLACE / "results.jsonl")
    parser.add_argument(
        "--seal", type=Path, default=PLACE / "seal", help="a folder, or an archive that holds all"
    )
    parser.add_argument(most, dest="most", type=int, default=default)
    options = parser.parse_args(words)
    answers = [] if options.seal.is_file() else [options.results]
    return options.logs, judged_in(options.seal, *answers), options.most
