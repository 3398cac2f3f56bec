"""Worked examples: flights with a hidden effect, reconciled from their logs alone and compared with the truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from pitotbench.bench import calibrate, fly, sense
from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.bench.reconcile.workflow import NamedLog, reconcile_fully
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.evidence.pages.examples_page import ExampleChapter, example_picture, examples_page, second_name
from pitotbench.logbook import write_text
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.case_file import read_case
from pitotbench.records.gap import Account
from pitotbench.records.log import FlightLog
from pitotbench.show.gap_page import account_page
from pitotbench.units import KNOT

SYSTEM = "50/50"
HELD_OUT = 1000  # added to the seeds of a flight to get those of its held-out flight
SECOND = 2000  # the same for the flight of the advised card

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Example:
    """A flight with an effect that the model lacks. `symptom` is what a crew would notice.

    `fault` changes a log in a way that no effect of the table does. With `turn_data` the logs are also calibrated.
    """

    name: str
    title: str
    symptom: str
    maneuver: str
    seed: int
    effects: tuple[EffectSpec, ...] = ()
    fault: Callable[[FlightLog], FlightLog] | None = None
    turn_data: bool = False


@dataclass(frozen=True, slots=True)
class WorkedExample:
    """An example with its reconciliation; `calibrations` has pairs of a description and a residual 2σ [kt].

    `second` is the reconciliation of both flights where a second card was advised and flown, else None.
    """

    example: Example
    account: Account
    calibrations: tuple[tuple[str, float], ...] = ()
    second: Account | None = None


def fuel_flow_low(log: FlightLog) -> FlightLog:
    """Return a log whose left fuel flow reads 8 % low. No effect of the table does that."""
    assert log.fuel_flow_left is not None
    return replace(log, fuel_flow_left=0.92 * log.fuel_flow_left)


EXAMPLES = (
    Example(
        "belly_pod",
        "The belly pod",
        "The airplane carries a pod that the model does not know: idle decelerations are steeper than simulated, "
        "and level flight takes more power.",
        "rapid_decel",
        9101,
        (EffectSpec("belly_pod", {"drag_area_m2": 0.12}),),
    ),
    Example(
        "gps_latency",
        "Turn data: a GPS velocity that comes late",
        "Circles flown with a receiver whose velocity is stamped late. A calibration's residual does not show it.",
        "circle",
        9202,
        (EffectSpec("gps_latency", {"latency_s": 0.3}),),
        turn_data=True,
    ),
    Example(
        "alpha_static_error",
        "Turn data: a static source that feels the angle of attack",
        "The second cause: in a turn the wing works harder at the same airspeed, and a static source that errs "
        "with the angle of attack reads otherwise than on a leg.",
        "circle",
        9203,
        (EffectSpec("alpha_static_error", {"slope_per_rad": 0.15}),),
        turn_data=True,
    ),
    Example(
        "turn_drag",
        "The speed lost in turns",
        "Power had to be added in turns in flight, not in the simulator.",
        "circle",
        9204,
        (EffectSpec("turn_drag", {"coefficient_at_30deg": 0.008}),),
    ),
    Example(
        "pitot_lag",
        "A pneumatic lag during Rapid Decel",
        "The faster the airplane slows down, the more airspeed the log shows: the line to the pitot tube is long.",
        "rapid_decel",
        9105,
        (EffectSpec("pitot_lag", {"lag_s": 0.4}),),
    ),
    Example(
        "two_at_once",
        "Two effects at once",
        "A pod on the belly, and a GPS receiver whose velocity comes late.",
        "rapid_decel",
        9106,
        (EffectSpec("belly_pod", {"drag_area_m2": 0.12}), EffectSpec("gps_latency", {"latency_s": 0.25})),
    ),
    Example(
        "outside",
        "One outside the table",
        "The transducer of the left engine's fuel flow reads 8 % low. No effect of the table does that, and the "
        "right answer is a gap of unknown cause, at the right place, with a formula that closes it.",
        "rapid_decel",
        9107,
        fault=fuel_flow_low,
    ),
)


def work_out_examples(examples: Sequence[Example], progress: Progress | None = None) -> list[WorkedExample]:
    """Work out the examples one after the other, because each flies its null flights on all cores."""
    return require_all(run_tasks(partial(work_out, progress=progress), examples, jobs=1))


def work_out(example: Example, progress: Progress | None = None) -> WorkedExample:
    """Fly the example and one more flight to hold out, remove the cause from the logs, and reconcile them."""
    measured, other = _log(example, example.seed), _log(example, example.seed + HELD_OUT)
    holdout = NamedLog(f"{example.name}-held-out.csv", other)
    outcome = reconcile_fully(
        NamedLog(f"{example.name}.csv", measured), "navajo", holdout, progress=progress, refly_holdout=False
    )
    calibrations = _calibrations(example, measured, outcome.account) if example.turn_data else ()
    second = _with_second_card(example, measured, outcome.account, progress)
    return WorkedExample(example, outcome.account, calibrations, second)


def _with_second_card(
    example: Example, measured: FlightLog, account: Account, progress: Progress | None
) -> Account | None:
    """Return the reconciliation of a flight and of the one that was advised after it; None where none was.

    The card is flown by the same airplane, in the air that its case file tells.
    """
    advised = account.next_flight
    if account.rounds[0].verdict.kind != "one_of" or advised is None or not advised.parts:
        return None
    seed = example.seed + SECOND
    card = replace(read_case(advised.case), effects=example.effects, truth_seed=seed, sensor_seed=seed)
    second = NamedLog(f"{second_name(example.name)}.csv", _recorded(example, card))
    logs = [NamedLog(f"{example.name}.csv", measured), second]
    return reconcile_fully(logs, "navajo", progress=progress, refly=False).account


def write_examples(worked: Sequence[WorkedExample], out: Path, reports: Path | None = None) -> None:
    """Write `reconcile-examples.md` with a picture of each example into the folder `out`.

    With `reports` the full reports are written into that folder.
    """
    (out / "reconcile-examples").mkdir(parents=True, exist_ok=True)
    chapters = []
    for one in worked:
        example, account = one.example, one.account
        pictures = out / "reconcile-examples"
        example_picture(account, pictures / f"{example.name}.png")
        if one.second is not None:
            example_picture(one.second, pictures / f"{second_name(example.name)}.png")
        if reports is not None:
            reports.mkdir(parents=True, exist_ok=True)
            write_text(reports / f"{example.name}.html", account_page(account))
        truth = {e.name: e.parameters for e in example.effects} or "no effect of the table"
        chapters.append(
            ExampleChapter(
                example.name, example.title, example.symptom, account, truth, one.calibrations, one.second
            )
        )
    seeds = ", ".join(str(one.example.seed) for one in worked)
    provenance = (
        f"Seeds {seeds}, held out + {HELD_OUT}, second card + {SECOND}; {SYSTEM} Hz, light turbulence.\nWritten by "
        "`scripts/reconcile_examples.py`; with `--reports DIR` it writes the full report of each as well."
    )
    write_text(out / "reconcile-examples.md", examples_page(chapters, provenance))


def _case(example: Example, seed: int) -> Case:
    return Case(maneuver=example.maneuver, effects=example.effects, truth_seed=seed, sensor_seed=seed)


def _log(example: Example, seed: int) -> FlightLog:
    return _recorded(example, _case(example, seed))


def _recorded(example: Example, case: Case) -> FlightLog:
    log = sense(fly(case), SYSTEM)
    return log if example.fault is None else example.fault(log)


def _calibrations(example: Example, measured: FlightLog, account: Account) -> tuple[tuple[str, float], ...]:
    """Return the residual 2σ [kt] of calibrations of the simulated and of the measured flight.

    Where a GPS latency was named, the measured flight is also calibrated with the latency removed.
    """
    simulated = sense(fly(replace(_case(example, example.seed), effects=())), SYSTEM)
    given = CalibrationOptions(latency="given")
    found = [("simulator", simulated, given), ("flight", measured, given)]
    sizes = [s for e in account.rounds[0].verdict.effects for s in e.sizes if e.name == "gps_latency"]
    if sizes:
        late = replace(given, gps_latency=sizes[0].value)
        found.append(("flight with the named latency taken off", measured, late))
    return tuple((what, calibrate(log, options).residual_two_sigma / KNOT) for what, log, options in found)
