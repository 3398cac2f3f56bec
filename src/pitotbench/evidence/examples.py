"""Demonstrations: flights with a hidden effect, judged by what their logs hold, then held against the truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pitotbench.bench import calibrate, fly, sense, write_text
from pitotbench.bench.reconcile.workflow import NamedLog, reconcile_fully
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.evidence.pages.examples_page import ExampleChapter, example_picture, examples_page
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.gap import Account
from pitotbench.records.log import FlightLog
from pitotbench.show.gap_page import account_page
from pitotbench.units import KNOT

SYSTEM = "50/50"
HELD_OUT = 1000  # added to the seeds of the flight that is not used for fitting

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Example:
    """A flight with something in it that the model does not have: `told` says what a crew would have noticed.

    `spoil` does to a log what no effect of the table does; `turn_data` asks for the calibration with and without
    the turns.
    """

    name: str
    title: str
    told: str
    maneuver: str
    seed: int
    effects: tuple[EffectSpec, ...] = ()
    spoil: Callable[[FlightLog], FlightLog] | None = None
    turn_data: bool = False


@dataclass(frozen=True, slots=True)
class WorkedExample:
    """A story with what came of it; `calibrations` are (what, residual 2σ [kt]) where turn data are at stake."""

    story: Example
    account: Account
    calibrations: tuple[tuple[str, float], ...] = ()


def fuel_flow_low(log: FlightLog) -> FlightLog:
    """The transducer of the left fuel flow reads 8 % low: nothing in the table does that."""
    assert log.fuel_flow_left is not None
    return replace(log, fuel_flow_left=0.92 * log.fuel_flow_left)


STORIES = (
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
        "right answer is a gap of unknown cause, at the right place.",
        "rapid_decel",
        9107,
        spoil=fuel_flow_low,
    ),
)


def work_out(story: Example, progress: Progress | None = None) -> WorkedExample:
    """Fly the story and one more flight to hold out, hide the cause, and reconcile what the logs hold."""
    measured, other = _log(story, story.seed), _log(story, story.seed + HELD_OUT)
    holdout = NamedLog(f"{story.name}-held-out.csv", other)
    outcome = reconcile_fully(
        NamedLog(f"{story.name}.csv", measured), "navajo", holdout, progress=progress, refly_holdout=False
    )
    return WorkedExample(
        story, outcome.account, _calibrations(story, measured, outcome.account) if story.turn_data else ()
    )


def write_examples(stories: Sequence[WorkedExample], out: Path, reports: Path | None = None) -> None:
    """Write `reconcile-stories.md` with a picture of each story into a folder, and the full reports into another
    one where it is given."""
    (out / "stories").mkdir(parents=True, exist_ok=True)
    chapters = []
    for told in stories:
        story, account = told.story, told.account
        example_picture(account, out / "stories" / f"{story.name}.png")
        if reports is not None:
            reports.mkdir(parents=True, exist_ok=True)
            write_text(reports / f"{story.name}.html", account_page(account))
        truth = {e.name: e.parameters for e in story.effects} or "no effect of the table"
        chapters.append(ExampleChapter(story.name, story.title, story.told, account, truth, told.calibrations))
    seeds = ", ".join(str(told.story.seed) for told in stories)
    provenance = (
        f"Seeds {seeds}, held out + {HELD_OUT}; {SYSTEM} Hz, light turbulence.\nWritten by "
        "`scripts/reconcile_stories.py`; with `--reports DIR` it writes the full report of each as well."
    )
    write_text(out / "reconcile-stories.md", examples_page(chapters, provenance))


def _case(story: Example, seed: int) -> Case:
    return Case(maneuver=story.maneuver, effects=story.effects, truth_seed=seed, sensor_seed=seed)


def _log(story: Example, seed: int) -> FlightLog:
    log = sense(fly(_case(story, seed)), SYSTEM)
    return log if story.spoil is None else story.spoil(log)


def _calibrations(story: Example, measured: FlightLog, account: Account) -> tuple[tuple[str, float], ...]:
    """Residual 2σ [kt] of a calibration of the simulator's flight and of the measured one, as it is and, where a
    GPS latency was named, with that taken off."""
    simulated = sense(fly(replace(_case(story, story.seed), effects=())), SYSTEM)
    given = CalibrationOptions(latency="given")
    found = [("simulator", simulated, given), ("flight", measured, given)]
    sizes = [s for e in account.rounds[0].verdict.effects for s in e.sizes if e.name == "gps_latency"]
    if sizes:
        late = replace(given, gps_latency=sizes[0].value)
        found.append(("flight with the named latency taken off", measured, late))
    return tuple((what, calibrate(log, options).residual_two_sigma / KNOT) for what, log, options in found)
