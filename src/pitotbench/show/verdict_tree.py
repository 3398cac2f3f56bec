"""The tree of a reconciliation, one for all voices, its page and its record.

The tree has the verdict, what is added to the model, where the gap is, and the card flown again.
"""

from collections.abc import Sequence
from dataclasses import replace

from pitotbench.effects import effect_of
from pitotbench.records.gap import Account, FlownAgain
from pitotbench.records.log import Provenance
from pitotbench.records.verdict import Check
from pitotbench.show.calibration import is_doubt
from pitotbench.show.gap_words import (
    closing_sentences,
    effect_words,
    evidence_words,
    features_limit,
    remaining_features,
    sentences,
)
from pitotbench.show.markup import page_of
from pitotbench.show.plan import pilot_card
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.record import CHECK_COLUMNS, check, conditions_of, record_page
from pitotbench.show.tree import (
    NUMBERS,
    SOURCES,
    Code,
    Doubt,
    Figure,
    Heading,
    Node,
    Notice,
    Sentence,
    Table,
)
from pitotbench.show.verdict import (
    COEFFICIENT_COLUMNS,
    DETECTABLE_COLUMNS,
    FEATURE_COLUMNS,
    FLIGHT_COLUMNS,
    PLACE_COLUMNS,
    TOLERANCE_COLUMNS,
    candidate_columns,
    closing_columns,
    kind_words,
    noticed,
)
from pitotbench.show.words import capital, listed, words
from pitotbench.units import percent_text

_PLACES = 6  # rows of the table of where the gap is
_SHORT = 0.02  # of the time within a tolerance: less than two flights of one airplane by chance
_MAP = (
    "The gap of a channel is its measured value minus the value that the other channels and the "
    "aircraft model predict. It is shown by phase of flight and by variable, in standard "
    "deviations. Wind, error curve, sensor biases and noise are fitted together with the gap, to "
    "all channels at once: a large gap in one channel can pull the fit and appear in others too. "
    "So look at the remaining gap first.",
    "Over the flight those channels are drawn that the patch changes most or, without a patch, "
    "those with the largest gap. Wind, error curve and sensor biases are taken out.",
    "G is the share of the explainable gap that the patch closes: (before − after)/(before − "
    "noise). The noise is the sum of squares that remains when every size is free and every place "
    "of the map above 4σ is fitted too.",
)
_FLIGHTS = (
    "Causes and sizes are shared; wind, error curve and sensor biases are each flight's own. A "
    "flight contradicts a cause where the size that it shows is more than 4σ from that of the "
    "other flights. G is the share of its explainable gap that the shared sizes close; left out, "
    "that by the sizes of the other flights alone. The pictures are of the flight with the "
    "largest gap."
)
_TOLERANCES = (
    "The simulator flies the card of the log again in the same wind with other gusts, before and "
    "with the patch. A sample is within tolerance where it is no farther from the measured one "
    "than 40 % of what 14 CFR Part 60 (Appendix A, Attachment 2) allows a simulator against "
    "flight: 3\u00a0kt of airspeed, 1.5° of pitch, 2° of bank, 3° of heading. Two flights of one "
    "airplane, which differ by gusts alone, say what can be reached."
)


def account_tree(account: Account) -> list[Node]:
    """Return an account's tree: answer, picture, patch, gap, reflown card, and what it rests on.

    The patch is what is added to the model; the gap has its places.
    """
    verdict, clearest = account.verdict, account.telling
    # The steps are of the flight with the largest gap, the closure is of all.
    steps = account.entries and account.waterfall and len(account.flights) < 2
    heads = {"failed": Doubt, "remark": Notice}
    checks = [heads[c.status](f"{c.name}: {c.why}") for c in verdict.checks if c.status in heads]
    nodes = [*_warnings(account), *checks]
    pictures = (
        Figure("pitotbench.show.gap_page.map_panels", (account.gap_map,), "whole"),
        Figure("pitotbench.show.gap_page.trace_panels", (account.traces, verdict.located)),
    )
    read = (Heading("How to read this", (*map(Sentence, _MAP),), NUMBERS),)
    return [
        Heading(kind_words(verdict), (*map(Sentence, sentences(account)),)),
        *(node for node in nodes if isinstance(node, Doubt)),
        *(Sentence(f"Next: {words(line)}.") for line in verdict.advice),
        *(
            [Figure("pitotbench.show.gap_page.telling_panels", (clearest,), "narrow")]
            if clearest
            else []
        ),
        *pilot_card(words(account.following), account.legs, SOURCES),
        *_closed(account),
        *_added(account),
        *_flights(account),
        Heading(
            "Where the gap is",
            (
                *map(Sentence, evidence_words(account)),
                Table(
                    PLACE_COLUMNS,
                    verdict.located[:_PLACES],
                    "where the gap is, in standard deviations",
                ),
                *(
                    [Figure("pitotbench.show.gap_page.waterfall_panels", (account,))]
                    if steps
                    else []
                ),
            ),
        ),
        *_flown_again(account),
        Heading(
            "The candidates, each as the only explanation",
            (Table(candidate_columns(verdict), verdict.candidates),),
            SOURCES,
        ),
        Heading("Maps of the gap, and its channels over time", (*pictures, *read), SOURCES),
        Heading("Checks of the log", (Table(CHECK_COLUMNS, _checks(account)),), SOURCES),
        Heading(
            "The smallest effects that a log like this one shows in half of all flights",
            (Table(DETECTABLE_COLUMNS, verdict.smallest_detectable),),
            NUMBERS,
        ),
        *(node for node in nodes if isinstance(node, Notice)),
    ]


def _warnings(account: Account) -> list[Node]:
    """Return what was said of the logs: doubts of the answer, and notices of the reading."""
    return [
        *(Doubt(each) if is_doubt(each) else Notice(each) for each in account.warnings),
        *map(Notice, map(words, account.verdict.notes)),
    ]


def _closed(account: Account) -> list[Node]:
    """What is in the airplane's file of what was found: its coefficients, the loop closed."""
    nodes: list[Node] = []
    if account.coefficients:
        nodes.append(
            Table(COEFFICIENT_COLUMNS, account.coefficients, "coefficients of the model's file")
        )
    if (closing := account.closing) is not None:
        table = Table(closing_columns(closing), closing.gaps, "the gaps, closed")
        said = map(Sentence, closing_sentences(closing))
        is_quiet = closing.closed and closing.verdict.kind == "no_gap"
        title = "The loop closed" if is_quiet else "The loop, and what stays"
        nodes.append(Heading(title, (*said, table)))
    return nodes


def _added(account: Account) -> list[Node]:
    """What is added to the model, and the patch with the commands that fly it."""
    nodes: list[Node] = [
        Sentence(f"{capital(effect_words(effect))}: {what}")
        for effect in account.verdict.effects
        for what in [effect_of(effect.name).what]
    ]
    if account.entries:
        fly = "Put these lines into the case file of the flight, and fly it:"
        commands = "\n".join(flying_words(account))
        patch = (Code(account.patch), Sentence(fly), Code(commands))
        nodes.append(Heading("The patch", patch, SOURCES))
    return [Heading("What is added to the model", tuple(nodes))] if nodes else []


def flying_words(account: Account) -> list[str]:
    """The commands that fly the patch: those of its aircraft, and those of a case file."""
    lines = ["cat patch.toml >> case.toml", "pitotbench fly case.toml -o patched.csv"]
    if account.aircraft != "none" and any(
        effect_of(name).acts_on == "aircraft" for name, _ in account.entries
    ):
        apply = (
            f"pitotbench reconcile {account.log.replace(', ', ' ')} --aircraft "
            f"{account.aircraft} --apply NAME"
        )
        lines += ["", apply, f'# fly it with aircraft = "{account.aircraft}+NAME" in the case file']
    return lines


def _flights(account: Account) -> list[Node]:
    if len(account.flights) < 2:
        return []
    read = (Heading("How to read this", (Sentence(_FLIGHTS),), NUMBERS),)
    return [Heading("The flights", (Table(FLIGHT_COLUMNS, account.flights), *read))]


def _flown_again(account: Account) -> list[Node]:
    """The card of the log flown again; or why it was not."""
    shown = account.flown.tolerances or account.flown.skipped
    title = f"The card of {account.log} flown again"
    return [Heading(title, tuple(_flown(account.flown)))] if shown else []


def _flown(flown: FlownAgain) -> list[Node]:
    if flown.skipped:
        return [Sentence(f"Skipped: {flown.skipped}.")]
    features, left = noticed(flown.features), len(remaining_features(flown.features))
    hand = "the autopilot alone" if flown.pilot == "none" else f"a {flown.pilot} pilot"
    is_patched = any(each.patched != each.simulated for each in flown.features)
    patched = "With the patch" if is_patched else "Flown again"
    many = f"{left} of {len(flown.features)} characteristic numbers of the card"
    said = {
        f"Flown by {hand}: bank, pitch and heading of the log move as under this hand.": flown.pilot,
        _shortfall(flown): True,
        f"{patched}, {many} differ by more than chance.": flown.features,
    }
    limit = (
        "σ is the standard deviation between two flights of one airplane, from six flights; one of "
        f"{len(flown.features)} numbers exceeds {features_limit(flown.features):.1f}σ by chance in "
        "one card of twenty."
    )
    title = (
        "Characteristic numbers of the segments that differ by more than chance, before or with "
        f"the patch ({len(features)} of {len(flown.features)})"
    )
    table = (Sentence(limit), Table(FEATURE_COLUMNS, features))
    judged = {each.quantity for each in flown.tolerances}
    shown = [each for each in flown.histories if each.quantity in judged]
    others = [each for each in flown.histories if each.quantity not in judged]
    drawn = Figure("pitotbench.show.gap_page.history_panels", (shown,))
    more = (Figure("pitotbench.show.gap_page.history_panels", (others,)),)
    return [
        Table(TOLERANCE_COLUMNS, flown.tolerances, "share of the time within the tolerance"),
        *(Sentence(text) for text, known in said.items() if text and known),
        *([Heading(title, table, NUMBERS)] if features else []),
        Heading("The card over time", (drawn,), SOURCES),
        *([Heading("Other quantities of the card", more, NUMBERS)] if others else []),
        Heading("How to read this", (Sentence(_TOLERANCES),), NUMBERS),
    ]


def _shortfall(flown: FlownAgain) -> str:
    """Return what the patch brings within the tolerance less often than it is between two flights.

    The two flights are of one airplane.
    """
    short = [t.quantity for t in flown.tolerances if t.after < t.by_chance - _SHORT]
    if not short:
        return ""
    within = "is within its" if len(short) == 1 else "are within their"
    return (
        f"With the patch, {listed(short)} {within} tolerance less often than between two flights "
        "of one airplane: the replay has another hand and other gusts, so it drifts from the log."
    )


def _checks(account: Account) -> list[Check]:
    """The checks of the log, and what is held against the answer."""
    verdict, holdout_closure = account.verdict, account.verdict.closure_holdout
    share = f"closes {percent_text(verdict.closure.share)} of the explainable gap of the log"
    closed = share if verdict.effects else ""
    also = (
        ""
        if holdout_closure is None
        else f"closes {percent_text(holdout_closure.share)} of the explainable gap of "
        f"{account.holdout}"
    )
    skipped = account.flown.skipped or "nothing is named"
    fits = "as often as two flights of one airplane" if account.flown.tolerances else ""
    against, none = "; ".join(verdict.doubts), "nothing is named"
    remains = "a gap remains" if verdict.remains else ""
    return [
        *verdict.checks,
        check("nothing speaks against the answer", against, closed, none),
        check("nothing remains beside it", remains, closed and "no gap remains"),
        check("a log that was not used is explained", "", also, "no log was held out"),
        check("flown again within the tolerances", _shortfall(account.flown), fits, skipped),
    ]


_EVIDENCE = ("Where the gap is", "The card of ")  # parts that a page folds: a terminal has no fold


def account_page(account: Account, units: Units = BENCH) -> str:
    """The HTML of an account, in the reader's units."""
    nodes = [
        replace(node, depth=SOURCES)
        if isinstance(node, Heading) and node.text.startswith(_EVIDENCE)
        else node
        for node in account_tree(account)
    ]
    return page_of(f"Reconcile: {account.log} against {account.aircraft}", nodes, units)


def reconciliation_record(account: Account, made: Provenance, units: Units = BENCH) -> str:
    """Return the record of a reconciliation, in the order of a qualification test, with the checks.

    The order leads from objective to statement.
    """
    lines = [
        f"Card of {each.log}: {words(each.maneuver or 'not known')}" for each in account.flights
    ]
    if account.null_flights:
        lines.append(
            f"{account.null_flights} simulated flights of the card without an effect give the "
            "thresholds"
        )
    warned = _warnings(account)
    parts: dict[str, Sequence[Node]] = {
        "Conditions": [*map(Sentence, conditions_of(made, lines))],
        "Tolerances": [Sentence(_TOLERANCES)],
        "Results": _flown_again(account),
        "Statement": [*map(Sentence, [*sentences(account), *evidence_words(account)])],
        "Checks": [Table(CHECK_COLUMNS, _checks(account))],
        **({"Warnings": warned} if warned else {}),
    }
    sides = "the sensors of the log disagree with one another"
    if account.aircraft != "none":
        sides = f"the flight model {account.aircraft} and the measured flight disagree"
    objective = f"Find where {sides}, because of what, and how far what is named closes the gap."
    title = f"Record of a comparison of simulation and flight: {kind_words(account.verdict)}"
    found = [Heading(name, tuple(nodes)) for name, nodes in parts.items()]
    return record_page(title, objective, made, found, units)
