"""Examples of a reconciliation with a hidden cause, as a Markdown page with a picture each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from pitotbench.records.gap import Account, Tolerance
from pitotbench.records.verdict import SURE, Candidate, Verdict
from pitotbench.show.columns import Column, markdown_table
from pitotbench.show.gap_words import place_words, sentences, told_rivals
from pitotbench.show.quantity_words import heading, size_words, words
from pitotbench.show.style import canvas
from pitotbench.show.telling_panels import telling_drawings
from pitotbench.show.verdict_tables import kind_words

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
        for effect, others in zip(each.verdict.effects, told_rivals(each.verdict), strict=True):
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
