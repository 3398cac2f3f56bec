"""Close the loop: patch the airplane, judge its logs again with the patch, report what is left.

Each round patches what the last judgment found of the airplane, and judges the same logs again:
with the forces of the patched airplane, the floor of the first null flights, and the errors of the
patched sizes in it. What sensors and the air do is no airplane's: each judgment takes it out of the
log anew.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from math import hypot

from pitotbench.bench.fly_again import as_the_log_shows, fly_again
from pitotbench.bench.null_cache import Progress
from pitotbench.bench.workflow import (
    FullReconciliation,
    JudgedLog,
    bounds_of,
    coefficients_along,
    entries,
    judge_layouts,
    model_of,
    patch_of,
    prepare_layout,
)
from pitotbench.campaigns.progress import progress as progress_bar
from pitotbench.effects import effect_of
from pitotbench.reconciliation.fitting import fitted_by
from pitotbench.reconciliation.other_flights import for_channels
from pitotbench.reconciliation.patches import beyond_range, is_settled, not_told, with_choice
from pitotbench.reconciliation.regression import effect_and_size
from pitotbench.reconciliation.shown_flight import largest_gap
from pitotbench.reconciliation.verdict import Judged
from pitotbench.records.gap import Closing
from pitotbench.records.log import FlightLog
from pitotbench.records.maneuver import Maneuvers
from pitotbench.records.verdict import Candidate, Closure, Gap
from pitotbench.simulation.modified import FORM, install_variant, require_free

ROUNDS = 5  # at the most: each finds one gap more and patches it
LEAST_GROWTH = 0.01  # of the explainable gap, held out: below it a round is not worth a patch


def close_loop(
    found: FullReconciliation,
    name: str,
    holdout: FlightLog | Maneuvers | None = None,
    progress: Progress | None = None,
    refly: bool = True,
) -> FullReconciliation:
    """Patch the airplane of a reconciliation until nothing more closes held out.

    What is named is patched, and of a set the cause that the user chose, at sizes in their ranges.
    `<aircraft>+<name>` is written whole at the end of each round. `holdout` is the held-out log of
    the reconciliation. With `refly` the card of the log with the largest gap is flown again,
    without and with all that was found. Returns the reconciliation with its `closing`, and with the
    patch of all rounds. Raises BadInputError where the name is taken.
    """
    aircraft, log, say = found.account.aircraft, found.account.log, progress or (lambda text: None)
    chosen = found.account.chosen
    require_free(aircraft, name)
    airplane = f"{aircraft}+{name}"
    logs, judged, main = found.logs, found.judged, largest_gap(found.judged.shown)
    whole = max(1.0, main.closure.before - main.closure.noise)
    first_closure, after, date = (
        judged.verdict.closure_holdout,
        None,
        datetime.now(UTC).strftime("%Y-%m-%d"),
    )
    patched, closed, known = dict[str, Gap](), [0.0], dict[str, float]()
    with progress_bar("rounds of closing" if progress else "", ROUNDS) as step:
        for number in range(1, ROUNDS + 1):
            joined = _joined([*patched.values(), *_to_patch(judged, whole, chosen)])
            new = {name: gap for name, gap in joined.items() if not [*beyond_range(gap.causes[0])]}
            grown = [name for name, gap in new.items() if gap is not patched.get(name)]
            if not grown or (growth := _gained(judged, grown, chosen) / whole) < LEAST_GROWTH:
                break
            patched, after = patched | new, judged.verdict.closure_holdout
            closed.append(closed[-1] + growth)
            gaps = [*patched.values()]
            install_variant(
                aircraft,
                name,
                entries(patch_of(judged, log, date, gaps)),
                {
                    "log": log,
                    "closed_held_out": closed[-1],
                    "two_sigma": bounds_of(gaps),
                    "form": {gap.causes[0].name: _form(gap) for gap in gaps},
                    "covariance": (known := known | _covariance(judged, gaps)),
                    "chosen": chosen,
                },
                anew=True,
            )
            say(f"round {number}: judging again with {airplane}")
            logs, judged = _judged_again(logs, airplane, holdout)
            step()
    gaps_found = _shares(judged, whole)
    passing = (gap for gap in gaps_found if not _is_lasting(gap.causes[0].name))
    whole_patch = patch_of(judged, log, date, [*patched.values(), *passing])
    patch = whole_patch if patched else found.patch
    flown = [each.maneuver for each in found.account.flights]
    account = replace(
        found.account,
        patch=patch.text,
        entries=patch.entries,
        closing=Closing(
            airplane,
            tuple(closed[1:]),
            tuple(patched.values()),
            tuple(gaps_found),
            coefficients_along(aircraft, main, patched.values()),
            judged.verdict,
            tuple(
                line
                for gap in _joined([*patched.values(), *_to_patch(judged, whole, chosen)]).values()
                for line in beyond_range(gap.causes[0])
            ),
            Closure(first_closure.before, after.after, first_closure.noise).share
            if first_closure and after
            else None,
            not_told(gaps_found, chosen, flown),
        ),
    )
    if refly:
        say("flying the card again")
        each = next(i for i, shown in enumerate(found.judged.shown) if shown is main)
        card = as_the_log_shows(found.logs[each].card, main)
        account = replace(account, flown=fly_again(logs[each].log, card, entries(patch)))
    return replace(found, account=account, patch=patch)


def _is_lasting(name: str) -> bool:
    """Whether an effect is one of the airplane itself, for the whole flight."""
    effect = effect_of(name)
    return effect.acts_on == "aircraft" and not effect.part_of


def _shares(judged: Judged, whole: float) -> list[Gap]:
    """Return an answer's gaps, each with what it closes of the first explainable gap.

    A gap closes together with the others; `whole` is that first gap.
    """
    now = largest_gap(judged.shown).closure
    return [
        replace(gap, closes=part * gap.closes, closes_held_out=part * gap.closes_held_out)
        for part in ((now.before - now.noise) / whole,)
        for gap in judged.verdict.gaps
        if gap.causes
    ]


def _to_patch(judged: Judged, whole: float, chosen: str) -> list[Gap]:
    """The gaps of the airplane whose cause is named, or was chosen."""
    gaps = (with_choice(gap, chosen) for gap in _shares(judged, whole))
    return [g for g in gaps if is_settled(g, chosen) and _is_lasting(g.causes[0].name)]


def _gained(judged: Judged, names: Sequence[str], chosen: str) -> float:
    """Return what some causes close of the log with the largest gap, as sums of squares.

    The fall counts as far as it holds in parts of the logs to which the sizes were not fitted.
    Causes that share a gap close it together; the rivals of the chosen one take no part.
    """
    fitted, block = judged.fitted, largest_gap(judged.shown).block
    rivals = {c.name for g in judged.verdict.gaps for c in with_choice(g, chosen).causes[1:]}
    if chosen and chosen not in [effect_and_size(m.name)[0] for m in fitted.members]:
        fitted = fitted_by(fitted.regression, rivals)
    own, others = (
        [m for m in fitted.members if (effect_and_size(m.name)[0] in names) is is_own]
        for is_own in (True, False)
    )
    shown = fitted.regression.shown_columns
    gain = block.beyond.gain(shown(block, own), shown(block, others))
    return gain * fitted.regression.held_out(others, own)


def _form(gap: Gap) -> float:
    """Return the deviation of the form of a gap's patch, as a share.

    A cause of a set is off by what the others of the set have as well.
    """
    whole = sum(cause.probability for cause in gap.causes)
    return hypot(FORM, 1.0 - gap.causes[0].probability / max(whole, gap.causes[0].probability))


def _covariance(judged: Judged, gaps: Sequence[Gap]) -> dict[str, float]:
    """Return the covariances of an answer's patched sizes, by the names of two of them.

    That of a size with itself has the error of the method.
    """
    gaps_found = {(g.causes[0].name, s.name): s for g in gaps for s in g.causes[0].sizes}
    sizes = judged.fitted.told.among([*gaps_found])
    names, rows = [" ".join(key) for key in sizes.keys], sizes.covariance.tolist()
    found = {
        f"{a}, {b}": rows[i][k] for i, a in enumerate(names) for k, b in enumerate(names) if i != k
    }
    return found | {
        f"{' '.join(key)}, {' '.join(key)}": (0.5 * gaps_found[key].two_sigma) ** 2
        for key in sizes.keys
    }


def _joined(gaps: Iterable[Gap]) -> dict[str, Gap]:
    """Gaps by their first cause; what a later round finds of one adds to its sizes."""
    joined: dict[str, Gap] = {}
    for gap in gaps:
        name = gap.causes[0].name
        old = joined.get(name)
        joined[name] = (
            gap
            if old is None
            else replace(
                gap,
                causes=(_added(old.causes[0], gap.causes[0]), *gap.causes[1:]),
                closes=old.closes + gap.closes,
                closes_held_out=old.closes_held_out + gap.closes_held_out,
            )
        )
    return joined


def _added(old: Candidate, new: Candidate) -> Candidate:
    """A cause with the sizes of two rounds; the later bound is that of the sum."""
    before = {size.name: size for size in old.sizes}
    added = {
        size.name: replace(size, value=size.value + getattr(before.get(size.name), "value", 0.0))
        for size in new.sizes
    }
    sizes = tuple((before | added).values())
    return replace(new, sizes=sizes, probability=old.probability, score=old.score)


def _judged_again(
    logs: Sequence[JudgedLog], aircraft: str, holdout: FlightLog | Maneuvers | None
) -> tuple[tuple[JudgedLog, ...], Judged]:
    """Judge logs with another airplane and the same floor.

    Without null flights the floor is the log's own, which is lower where less is left.
    """
    model, again = model_of(aircraft, [each.log for each in logs]), list[JudgedLog]()
    for each in logs:
        layout = prepare_layout(each.log, model, each.layout.setting)
        kept = each.null.flights or layout.setting.maneuvers
        floor = for_channels(each.null if kept else None, layout)
        again.append(replace(each, layout=layout, null=floor))
    return tuple(again), judge_layouts(again, model, holdout)
