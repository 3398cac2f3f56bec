"""Worked examples: flights with a hidden effect, reconciled from their logs alone and compared with the truth."""

from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.bench.flights import sense
from pitotbench.bench.rounds import NamedLog
from pitotbench.bench.workflow import reconcile_fully
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.catalog import Catalog
from pitotbench.logbook.columns import write_text
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.case_file import read_case
from pitotbench.records.gap import Account, Tolerance
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import SURE, Candidate, Verdict
from pitotbench.show.columns import Column, markdown_table
from pitotbench.show.gap_page import account_page, telling_drawings
from pitotbench.show.gap_words import place_words, reported_rivals, sentences
from pitotbench.show.style import canvas
from pitotbench.show.verdict import kind_words
from pitotbench.show.words import heading, size_words, words
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT
from pitotlab.experiment import OUT, say

_HEAD = """# Reconcile, on flights with a hidden cause

Each flight contains an effect that the model of the airplane lacks. `pitotbench reconcile` gets the log, the
model, and simulated flights of the same card without an effect (null flights); it does not get the truth. ± is 2σ.
G is the share of the explainable gap that the patch or the formula closes, on the fitted flight and on another
flight of that card that was not used. Where the answer leaves more than one cause and a card can part them, the
same airplane flies that card, and both logs are judged together.
{provenance}

{table}
"""


@dataclass(frozen=True, slots=True)
class ExampleChapter:
    """The content of the page on one flight: `symptom` is the report of a crew, `truth` holds the hidden sizes by
    effect, or words where no effect of the table was hidden. `calibrations`: (turn data, 2σ of the residual [kt]).
    `second` is the account of this flight and the one that was advised after it, None where none was flown.
    """

    name: str
    title: str
    symptom: str
    account: Account
    truth: Mapping[str, Mapping[str, float]] | str
    calibrations: tuple[tuple[str, float], ...] = ()
    second: Account | None = None


def examples_page(chapters: Sequence[ExampleChapter], provenance: str) -> str:
    """The Markdown of all chapters; their pictures are `reconcile-examples/<name>.png`."""
    table = markdown_table(_COLUMNS, chapters)
    return _HEAD.format(provenance=provenance, table=table) + "".join(_chapter(each) for each in chapters)


def _verdict(chapter: ExampleChapter) -> Verdict:
    return chapter.account.rounds[0].verdict


def _answer(account: Account) -> str:
    if account.rounds[0].verdict.kind in SURE:
        return "; ".join(_named(account))
    return "a formula" if account.formula is not None else "nothing"


def _after_second(chapter: ExampleChapter) -> str:
    if chapter.second is None:
        return "–"
    return f"{kind_words(chapter.second.rounds[0].verdict)}: {_answer(chapter.second)}"


def _fitted_closure(chapter: ExampleChapter) -> float | None:
    verdict, formula = _verdict(chapter), chapter.account.formula
    if verdict.kind in SURE:
        return verdict.closure.share
    return formula.closure.share if formula is not None else None


def _held_out_closure(chapter: ExampleChapter) -> float | None:
    verdict, formula = _verdict(chapter), chapter.account.formula
    held = verdict.closure_holdout if verdict.kind in SURE else (formula.closure_holdout if formula else None)
    return held.share if held is not None else None


def _truth(chapter: ExampleChapter) -> str:
    if isinstance(chapter.truth, str):
        return chapter.truth
    return "; ".join(
        f"{words(name)}: " + ", ".join(size_words(key, value) for key, value in sizes.items())
        for name, sizes in chapter.truth.items()
    )


def _named(account: Account) -> list[str]:
    """Each effect of each pass with its sizes, and the effects that cannot be distinguished from it."""
    named = []
    for number, each in enumerate(account.rounds):
        known = {candidate.name: candidate for candidate in each.verdict.candidates}
        for effect, others in zip(each.verdict.effects, reported_rivals(each.verdict), strict=True):
            rivals = [_sized(known[name]) if name in known else words(name) for name in others]
            like = f" or {' or '.join(rivals)}" if rivals else ""
            named.append(_sized(effect) + like + (f" (pass {number + 1})" if number else ""))
    return named if any(each.added for each in account.rounds) else []


def _sized(effect: Candidate) -> str:
    sizes = ", ".join(size_words(s.name, s.value, s.two_sigma) for s in effect.sizes)
    return f"{words(effect.name)}: {sizes}"


_COLUMNS: tuple[Column[ExampleChapter], ...] = (
    Column("example", lambda chapter: chapter.title),
    Column("verdict", lambda chapter: kind_words(_verdict(chapter))),
    Column("named", lambda chapter: _answer(chapter.account)),
    Column("with the second card", _after_second),
    Column("truth", _truth),
    Column("G, fitted", _fitted_closure, style=".3f"),
    Column("G, held out", _held_out_closure, style=".3f"),
    Column("passes", lambda chapter: len(chapter.account.rounds), style="d"),
)


def _chapter(chapter: ExampleChapter) -> str:
    account, verdict = chapter.account, chapter.account.rounds[0].verdict
    lines = [f"\n## {chapter.title}\n", f"**Symptom.** {chapter.symptom}{_turn_data(chapter)}\n"]
    lines.append(f"**Answer: {kind_words(verdict)}.** {' '.join(sentences(account))}\n")
    lines += _picture(account, chapter.name, f"{chapter.title}: {_title(account)}, before and after")
    lines.append(f"**Truth.** {_truth(chapter)[0].upper()}{_truth(chapter)[1:]}.\n")
    lines.append(f"**Place of the gap.** {'; '.join(place_words(p) for p in verdict.located[:3])}.\n")
    if "[[effects]]" in account.patch:
        lines.append(f"**Patch.**\n\n```toml\n{_entries(account.patch)}```\n")
    lines.append(f"**The gap.** {_gap(account)}\n")
    if verdict.advice and verdict.kind == "one_of":
        lines.append(f"**What to fly next.** {'. '.join(heading(line) for line in verdict.advice)}.\n")
    if chapter.second is not None and account.next_flight is not None:
        card, _, _ = account.next_flight.case.partition("\n[wind]")  # the rest is as in the first flight
        lines.append(f"Its case file begins:\n\n```toml\n{card.strip()}\n```\n")
        answer = kind_words(chapter.second.rounds[0].verdict)
        lines.append(f"**With the second card: {answer}.** {' '.join(sentences(chapter.second))}\n")
        caption = f"{chapter.title}: {_title(chapter.second)}, with the second card"
        lines += _picture(chapter.second, second_name(chapter.name), caption)
    return "\n".join(lines)


def second_name(name: str) -> str:
    """The name of an example's log and picture with the second card."""
    return f"{name}-second-card"


def _title(account: Account) -> str:
    return words(account.telling.channel) if account.telling else "no gap"


def _picture(account: Account, name: str, caption: str) -> list[str]:
    return [f"![{caption}](reconcile-examples/{name}.png)\n"] if account.telling else []


def _turn_data(chapter: ExampleChapter) -> str:
    if not chapter.calibrations:
        return ""
    residuals = ", ".join(f"{data} {value:.2f} kt" for data, value in chapter.calibrations)
    return f" 2σ of the residual of a calibration with these turn data: {residuals}."


def _entries(patch: str) -> str:
    return patch[patch.index("[[effects]]") :] if "[[effects]]" in patch else patch


def _gap(account: Account) -> str:
    verdict, last = account.rounds[0].verdict, account.rounds[-1].verdict
    closed, held = verdict.closure, verdict.closure_holdout
    text = f"Sum of squares over noise variance: {closed.before:,.0f} before"
    if verdict.kind in SURE:
        text += f", {closed.after:,.0f} with the patch, {closed.noise:,.0f} noise (G = {closed.share:.3f})"
        if held is not None:
            text += f"; held out {held.before:,.0f}, {held.after:,.0f}, {held.noise:,.0f} (G = {held.share:.3f})"
        if len(account.rounds) > 1:
            text += f". Pass {len(account.rounds)}, with all of that in the model: {kind_words(last)}"
    elif account.formula is not None:
        found = account.formula.closure
        text += f", {found.after:,.0f} with the formula, {found.noise:,.0f} noise (G = {found.share:.3f})"
    else:
        text += f", {closed.noise:,.0f} noise; nothing is added"
    return text + "." + _flown(account)


def _flown(account: Account) -> str:
    """The quantity that the patch changes most on the card flown again, in a sentence."""
    if not account.flown.tolerances:
        return ""
    most = max(account.flown.tolerances, key=_moved)
    limit = f"{most.half_width:g} {most.unit} of the measured {most.quantity}"
    shares = f"{most.before:.0%} of the time before and {most.after:.0%} with the patch"
    chance = f"two flights of one airplane: {most.by_chance:.0%}"
    return f" Flown again, the card is within {limit} for {shares} ({chance})."


def _moved(tolerance: Tolerance) -> float:
    return abs(tolerance.after - tolerance.before)


def example_picture(account: Account, path: Path) -> None:
    """Draw the telling channel over time, over a variable and over the ground as PNG; nothing without a gap."""
    if account.telling is None:
        return
    with canvas(1, 3, 13.5, 3.6) as (figure, axes):
        for each, drawing in zip(axes, telling_drawings(account.telling), strict=True):
            drawing.draw(each)
            each.set_title(drawing.title, fontsize=9)
            each.legend(fontsize=7, loc="best")
        figure.savefig(path, dpi=100)


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
        "`python -m pitotlab examples`; with `--reports DIR` it writes the full report of each as well."
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


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Hide an effect in a flight, reconcile, hold the answer against the truth: writes reconcile-examples.md."""
    parser.add_argument("--only", help="names with commas: " + ", ".join(example.name for example in EXAMPLES))
    parser.add_argument("--out", type=Path, default=OUT, help="folder of the page (default: %(default)s)")
    parser.add_argument("--reports", type=Path, help="folder for the full report of each")
    options = parser.parse_args(words)
    known = Catalog("example", {example.name: example for example in EXAMPLES})
    wanted = options.only.split(",") if options.only else list(known)
    write_examples(work_out_examples([known[name] for name in wanted], say), options.out, options.reports)
