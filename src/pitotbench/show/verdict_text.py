"""The verdict of a reconciliation for the terminal: the answer first, then the evidence, then the next flight."""

from rich.console import Console

from pitotbench.records.gap import Account
from pitotbench.records.verdict import Verdict
from pitotbench.show.columns import print_table
from pitotbench.show.flight_tables import FLIGHT_COLUMNS
from pitotbench.show.gap_words import effect_words, evidence_words, sentences
from pitotbench.show.terminal import outside, print_warnings
from pitotbench.show.verdict_tables import PLACE_COLUMNS, TOLERANCE_COLUMNS, kind_words, pilot_words

_PLACES = 6


def print_account(account: Account, console: Console) -> None:
    """Print the verdict, the logs' warnings, the places of the gap, the later passes, and the card flown again."""
    verdict = account.rounds[0].verdict
    console.print(outside(kind_words(verdict), "bold"), soft_wrap=True)
    for sentence in sentences(account):
        console.print(outside(sentence), soft_wrap=True)
    print_warnings(account.warnings, console)
    console.print()
    for sentence in evidence_words(account):
        console.print(outside(sentence), soft_wrap=True)
    print_table(PLACE_COLUMNS, verdict.located[:_PLACES], console, "where the gap is, in standard deviations")
    if len(account.flights) > 1:
        print_table(FLIGHT_COLUMNS, account.flights, console, "the flights")
    for number, each in enumerate(account.rounds[1:], start=2):
        added = f": {'; '.join(effect_words(e) for e in each.verdict.effects)}" if each.added else ""
        line = f"pass {number}, with the effects of the passes before in the model: {kind_words(each.verdict)}"
        console.print(outside(line + added), soft_wrap=True)
    for flown, log in ((account.flown, account.log), (account.flown_holdout, account.holdout)):
        if flown.tolerances:
            console.print()
            title = f"the card of {log} flown again: share of the time within the tolerance"
            print_table(TOLERANCE_COLUMNS, flown.tolerances, console, title)
            if flown.pilot:
                console.print(outside(pilot_words(flown)), soft_wrap=True)
    _print_remarks(verdict, console)


def _print_remarks(verdict: Verdict, console: Console) -> None:
    failed = [f"failed check, {check.name}: {check.why}" for check in verdict.checks if check.status == "failed"]
    next_flights = [f"next: {line}" for line in verdict.advice]
    console.print()
    for line in [*failed, *next_flights, *(f"note: {line}" for line in verdict.notes)]:
        console.print(outside(line), soft_wrap=True)
