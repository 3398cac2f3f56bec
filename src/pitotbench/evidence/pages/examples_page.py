"""Stories of hidden effects as a Markdown page with a picture each."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes

from pitotbench.records.gap import Account, Tolerance
from pitotbench.records.verdict import SURE, Candidate, Located
from pitotbench.show.gap_panels import draw_closures, draw_trace, telling
from pitotbench.show.gap_words import place_words, size_words, words
from pitotbench.show.style import BLUE, GREY, canvas
from pitotbench.show.verdict_text import SAID

_PLACES = 6
_HEAD = """# Reconcile, told on flights in which the cause is hidden

Each flight holds something that the model of the airplane does not. `pitotbench reconcile` sees the log, the model,
and null flights of the same card; the truth is told here only after its answer. Sizes are ± 2σ; G is the share of
the explainable gap that the patch closes, on the fitted flight and on another one of that card that was not used.
{provenance}

| story | verdict | named | truth | G, fitted | G, held out | looks |
|---|---|---|---|---|---|---|
{rows}
"""


@dataclass(frozen=True, slots=True)
class ExampleChapter:
    """What a page tells of one flight: `truth` are the hidden sizes by effect, or words where no effect of the
    table was hidden; `calibrations` are (what, residual 2σ [kt])."""

    name: str
    title: str
    told: str
    account: Account
    truth: Mapping[str, Mapping[str, float]] | str
    calibrations: tuple[tuple[str, float], ...] = ()


def examples_page(chapters: Sequence[ExampleChapter], provenance: str) -> str:
    """The Markdown of all chapters; their pictures are `stories/<name>.png`."""
    rows = "\n".join(_row(chapter) for chapter in chapters)
    return _HEAD.format(provenance=provenance, rows=rows) + "".join(_chapter(each) for each in chapters)


def _row(chapter: ExampleChapter) -> str:
    verdict = chapter.account.rounds[0].verdict
    sure = verdict.kind in SURE
    held = verdict.closure_holdout
    cells = [
        chapter.title,
        SAID[verdict.kind],
        "; ".join(_named(chapter.account)) if sure else "nothing",
        _truth(chapter),
        f"{verdict.closure.share:.3f}" if sure else "",
        f"{held.share:.3f}" if sure and held is not None else "",
        str(len(chapter.account.rounds)),
    ]
    return "| " + " | ".join(cells) + " |"


def _truth(chapter: ExampleChapter) -> str:
    if isinstance(chapter.truth, str):
        return chapter.truth
    return "; ".join(
        f"{words(name)}: " + ", ".join(size_words(key, value) for key, value in sizes.items())
        for name, sizes in chapter.truth.items()
    )


def _named(account: Account) -> list[str]:
    """Each effect of each look with its sizes, and what it was not told from with the size that would have."""
    found = []
    for number, each in enumerate(account.rounds):
        known = {candidate.name: candidate for candidate in each.verdict.candidates}
        for effect, others in zip(each.verdict.effects, each.verdict.alternatives, strict=True):
            beside = [_sized(known[name]) if name in known else words(name) for name in others]
            like = f" or {' or '.join(beside)}" if beside else ""
            found.append(_sized(effect) + like + (f" (look {number + 1})" if number else ""))
    return found if any(each.added for each in account.rounds) else []


def _sized(effect: Candidate) -> str:
    sizes = ", ".join(size_words(s.name, s.value, s.two_sigma) for s in effect.sizes)
    return f"{words(effect.name)}: {sizes}"


def _chapter(chapter: ExampleChapter) -> str:
    account, verdict = chapter.account, chapter.account.rounds[0].verdict
    lines = [f"\n## {chapter.title}\n", f"**Seen.** {chapter.told}{_turn_data(chapter)}\n"]
    lines.append(f"**Located.** {'; '.join(place_words(p) for p in verdict.located[:3])}.\n")
    said = f"**{SAID[verdict.kind].capitalize()}.**"
    if verdict.kind in SURE:
        lines.append(f"{said} {'; '.join(_named(account))}. Truth: {_truth(chapter)}.\n")
        lines.append(f"**Added.**\n\n```toml\n{_entries(account.patch)}```\n")
    else:
        best = verdict.candidates[0]
        ratio = f"held-out over in-sample gain {best.held_out_ratio:.2f}"
        lines.append(f"{said} Truth: {_truth(chapter)}.\n")
        lines.append(f"The best of the table would be {_sized(best)} ({best.score:.0f}σ, {ratio}).\n")
    lines.append(f"**The gap.** {_gap(account)}\n")
    lines.append(f"![{chapter.title}: where, when, and what is left](stories/{chapter.name}.png)\n")
    return "\n".join(lines)


def _turn_data(chapter: ExampleChapter) -> str:
    if not chapter.calibrations:
        return ""
    told = ", ".join(f"{what} {value:.2f} kt" for what, value in chapter.calibrations)
    return f" Residual 2σ of a calibration with these turn data: {told}."


def _entries(patch: str) -> str:
    return patch[patch.index("[[effects]]") :] if "[[effects]]" in patch else patch


def _gap(account: Account) -> str:
    verdict, last = account.rounds[0].verdict, account.rounds[-1].verdict
    closed, held = verdict.closure, verdict.closure_holdout
    told = f"Sum of squares in units of the noise: {closed.before:,.0f} before"
    if verdict.kind in SURE:
        told += f", {closed.after:,.0f} with the patch, {closed.noise:,.0f} noise (G = {closed.share:.3f})"
        if held is not None:
            told += f"; held out {held.before:,.0f}, {held.after:,.0f}, {held.noise:,.0f} (G = {held.share:.3f})"
        if len(account.rounds) > 1:
            told += f". Look {len(account.rounds)}, with all of that in the model: {SAID[last.kind]}"
    else:
        told += f", {closed.noise:,.0f} noise; nothing is added"
    return told + "." + _flown(account)


def _flown(account: Account) -> str:
    """What flying the card again says, of the quantity that it says most of."""
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
    """Where the gap is, when, and what is left of it, as PNG."""
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
    """The most significant place of every channel as bars [σ], with what null flights stay below."""
    names = [f"{words(p.channel)},\n{words(p.where)}" for p in places]
    axes.barh(range(len(places)), [p.significance for p in places], color=BLUE, height=0.6)
    for side in (-threshold, threshold):
        axes.axvline(side, color=GREY, ls="--", lw=0.9)
    axes.set_yticks(range(len(places)), names, fontsize=7.5)
    axes.invert_yaxis()
    axes.set(xlabel="measured − simulated [σ]; dashed: null flights")
    axes.grid(axis="y", visible=False)
