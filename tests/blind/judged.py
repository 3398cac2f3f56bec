"""What the tool answers on one flight or several, as plain data. The only place that calls the tool.

The answer is that of the whole command: with the effects that later looks add, and the names that it takes back.
"""

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from time import monotonic
from typing import Any

from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.log_card import as_flown, card_of, tells_the_day
from pitotbench.bench.reconcile.null_cache import cache_entry
from pitotbench.bench.reconcile.null_learning import NULL_FLIGHTS
from pitotbench.bench.reconcile.reconciliation import AnalysisSetting
from pitotbench.bench.reconcile.workflow import FullReconciliation, NamedLog, reconcile_fully
from pitotbench.logbook import read_log
from pitotbench.reconcile.decide.judgment import hold_out
from pitotbench.reconcile.signatures.hypotheses import returns
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import SURE, Closure

LEAST = 1e-3  # probability of a cause that is written down


def spent() -> float:
    """Processor seconds of this process and of its children."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def is_warm(path: Path, aircraft: str) -> bool:
    """Whether the null flights of a log are in the cache, or none are needed."""
    if aircraft == "none":
        return True
    log = read_log(path)
    card = card_of(log.header, aircraft)
    if card is None:
        return True
    card = replace(as_flown(card, log), effects=(), truth_seed=1, sensor_seed=1)
    setting = AnalysisSetting(day_known=tells_the_day(log.header), instruments_known=True)
    return cache_entry(card, NULL_FLIGHTS, setting).is_file()


def judge(paths: Sequence[Path], aircraft: str, held: Path | None = None, advise: bool = False) -> dict[str, Any]:
    """Return the answer on the flights of one case. A crash of the tool is an answer as well.

    `held` is a flight to close with what was named. With `advise` the tool chooses the next flight where it did not
    come to a name: a minute of simulation.
    """
    wall, processor = monotonic(), spent()
    told: dict[str, Any] = {"name": paths[0].stem, "flights": len(paths), "warm": True}
    try:
        told["warm"] = all(is_warm(path, aircraft) for path in paths)
        made = _reconciled(paths, aircraft)
        told |= _told(made)
    except BadInputError as error:
        return {**told, "kind": "refused", "why": str(error), **_seconds(wall, processor)}
    except Exception as error:  # whatever it is, it is no answer
        return {**told, "kind": "crash", "why": f"{type(error).__name__}: {error}", **_seconds(wall, processor)}
    told |= _seconds(wall, processor)
    first = made.reconciliation
    if advise and told["kind"] == "one_of" and len(paths) == 1:
        with suppress(Exception):
            told |= _next_flight(first, read_log(paths[0]))
    if (
        held is not None
        and held.is_file()
        and told["kind"] in ("named", "one_of")
        and any(map(returns, first.naming.chosen))
    ):
        try:
            closed = hold_out(
                read_log(held), aircraft_model(aircraft), first.null, first.naming, first.layout.setting
            )
            told["held_out"] = _share(closed)
        except Exception as error:
            told["held_out_why"] = f"{type(error).__name__}: {error}"
    return told


def _reconciled(paths: Sequence[Path], aircraft: str) -> FullReconciliation:
    """One log or several as the command judges them, with all its looks and the formula of what they leave."""
    logs = [NamedLog(f"flight {i}", read_log(path)) for i, path in enumerate(paths, start=1)]
    return reconcile_fully(logs, aircraft, refly=False, next_flight=False)


def _told(made: FullReconciliation) -> dict[str, Any]:
    """The answer with what later looks add to it; the figures are those of the first look, the closure of all."""
    verdict, rounds = made.verdict, made.account.rounds
    effects = {e.name: list(others) for e, others in zip(verdict.effects, verdict.alternatives, strict=True)}
    sizes = {e.name: {s.name: [s.value, s.two_sigma] for s in e.sizes} for e in verdict.effects}
    for later in rounds[1:]:
        each = zip(later.verdict.effects, later.verdict.alternatives, strict=True) if later.added else ()
        for effect, others in each:
            effects.setdefault(effect.name, list(others))
            sizes.setdefault(effect.name, {s.name: [s.value, s.two_sigma] for s in effect.sizes})
    sure = verdict.kind in SURE and verdict.effects
    kind = ("one_of" if any(effects.values()) else "named") if sure else verdict.kind
    return {
        "kind": kind,
        "effects": list(effects),
        "alternatives": list(effects.values()),
        "sizes": sizes,
        "probabilities": {c: round(p, 5) for c, p in verdict.probabilities.items() if p > LEAST},
        "log_bayes_factor": round(verdict.log_bayes_factor, 2),
        "remains": rounds[-1].verdict.remains or rounds[-1].verdict.kind == "unknown",
        "closure": _share(verdict.closure),
        "looks": len(rounds),
        "doubts": list(verdict.doubts),
        "notes": [note for note in verdict.notes if "taken back" in note],
        "advice": list(verdict.advice),
        "located": [[p.channel, p.where, round(p.significance, 1)] for p in verdict.located[:4]],
        **_formula(made),
    }


def _formula(made: FullReconciliation) -> dict[str, Any]:
    """The closure of the gap by a formula, where the table leaves one."""
    found = made.account.formula
    if not (made.verdict.kind == "unknown" or made.verdict.doubts):
        return {}
    if found is None:
        return {"formula": None}
    return {"formula": {"closure": _share(found.closure), "terms": [t.effect for t in found.terms]}}


def _next_flight(made: Any, log: FlightLog) -> dict[str, Any]:
    """The case file of the flight that the tool advises, where it can choose one; empty where no card can part."""
    choose = import_module("pitotbench.bench.reconcile.next_flight").choose_next_flight
    begun = spent()
    found = choose(made.naming.posterior, log, made.card, made.layout, made.null)
    return {"advised": found.case if found is not None else "", "advised_s": round(spent() - begun, 2)}


def _share(closure: Closure) -> float:
    return round(closure.share, 4)


def _seconds(wall: float, processor: float) -> dict[str, float]:
    return {"wall_s": round(monotonic() - wall, 2), "processor_s": round(spent() - processor, 2)}
