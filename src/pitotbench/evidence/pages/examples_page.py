"""Examples of a reconciliation with a hidden cause, as a Markdown page with a picture each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes

from pitotbench.records.gap import Account, Tolerance
from pitotbench.records.verdict import SURE, Candidate, Located, Verdict
from pitotbench.show.columns import Column, markdown_table
from pitotbench.show.gap_panels import draw_closures, draw_trace, telling
from pitotbench.show.gap_words import place_words, told_rivals
from pitotbench.show.quantity_words import size_words, words
from pitotbench.show.style import BLUE, GREY, canvas
from pitotbench.show.verdict_tables import kind_words

_PLACES = 6
_HEAD = """# Reconcile, on flights with a hidden cause

Each flight contains an effect that the model of the airplane lacks. `pitotbench reconcile` gets the log, the
model, and simulated flights of the same card without an effect (null flights); it does not get the truth. ± is 2σ.
G is the share of the explainable gap that the patch closes, on the fitted flight and on another flight of that
card that was not used.
{provenance}

{table}
"""


@dataclass(frozen=True, slots=True)
class ExampleChapter:
    """The content of the page on one flight: `symptom` is the report of a crew, `truth` holds the hidden sizes by
    effect, or words where no effect of the table was hidden. `calibrations`: (turn data, 2σ of the residual [kt]).
    """

    name: str
    title: str
    symptom: str
    account: Account
    truth: Mapping[str, Mapping[str, float]] | str
    calibrations: tuple[tuple[str, float], ...] = ()


def examples_page(chapters: Sequence[ExampleChapter], provenance: str) -> str:
    """The Markdown of all chapters; their pictures are `reconcile-examples/<name>.png`."""
    table = markdown_table(_COLUMNS, chapters)
    return _HEAD.format(provenance=provenance, table=table) + "".join(_chapter(each) for each in chapters)


def _verdict(chapter: ExampleChapter) -> Verdict:
    return chapter.account.rounds[0].verdict


def _effects(chapter: ExampleChapter) -> str:
    return "; ".join(_named(chapter.account)) if _verdict(chapter).kind in SURE else "nothing"


def _fitted_closure(chapter: ExampleChapter) -> float | None:
    verdict = _verdict(chapter)
    return verdict.closure.share if verdict.kind in SURE else None


def _held_out_closure(chapter: ExampleChapter) -> float | None:
    verdict = _verdict(chapter)
    held = verdict.closure_holdout
    return held.share if verdict.kind in SURE and held is not None else None


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
    Column("named", _effects),
    Column("truth", _truth),
    Column("G, fitted", _fitted_closure, style=".3f"),
    Column("G, held out", _held_out_closure, style=".3f"),
    Column("passes", lambda chapter: len(chapter.account.rounds), style="d"),
)


def _chapter(chapter: ExampleChapter) -> str:
    account, verdict = chapter.account, chapter.account.rounds[0].verdict
    lines = [f"\n## {chapter.title}\n", f"**Symptom.** {chapter.symptom}{_turn_data(chapter)}\n"]
    lines.append(f"**Place of the gap.** {'; '.join(place_words(p) for p in verdict.located[:3])}.\n")
    said = f"**{kind_words(verdict).capitalize()}.**"
    if verdict.kind in SURE:
        lines.append(f"{said} {'; '.join(_named(account))}. Truth: {_truth(chapter)}.\n")
        lines.append(f"**Patch.**\n\n```toml\n{_entries(account.patch)}```\n")
    else:
        best = verdict.candidates[0]
        ratio = f"gain on held-out parts / gain on fitted parts {best.held_out_ratio:.2f}"
        lines.append(f"{said} Truth: {_truth(chapter)}.\n")
        lines.append(f"The best candidate is {_sized(best)} ({best.score:.0f}σ, {ratio}).\n")
    lines.append(f"**The gap.** {_gap(account)}\n")
    caption = f"{chapter.title}: where and when the gap is, and how much of it remains"
    lines.append(f"![{caption}](reconcile-examples/{chapter.name}.png)\n")
    return "\n".join(lines)


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
    """Draw where and when the gap is, and how much of it remains, as PNG."""
    verdict = account.rounds[0].verdict
    closures = [("fitted", verdict.closure)]
    if verdict.closure_holdout is not None:
        closures.append(("held out", verdict.closure_holdout))
    with canvas(1, 3, 13.5, 3.3) as (figure, (where, when, left)):
        draw_places(where, verdict.located[:_PLACES], account.gap_map.threshold)
        draw_trace(when, telling(account.traces, verdict.located)[0])
        when.legend(fontsize=7, loc="best")
        if verdict.kind in SURE:
            draw_closures(left, closures)
            left.legend(loc="lower right")
        else:
            left.set_axis_off()
            left.text(0.5, 0.5, "no patch: the cause is unknown", ha="center", va="center", fontsize=11)
        figure.savefig(path, dpi=100)


def draw_places(axes: Axes, places: Sequence[Located], threshold: float) -> None:
    """Draw the most significant place of every channel as bars [σ], and the threshold of the null flights."""
    names = [f"{words(p.channel)},\n{words(p.where)}" for p in places]
    axes.barh(range(len(places)), [p.significance for p in places], color=BLUE, height=0.6)
    for side in (-threshold, threshold):
        axes.axvline(side, color=GREY, ls="--", lw=0.9)
    axes.set_yticks(range(len(places)), names, fontsize=7.5)
    axes.invert_yaxis()
    axes.set(xlabel="measured − simulated [σ]; dashed: threshold of null flights")
    axes.grid(axis="y", visible=False)
