"""Write verdict, patch and report to a folder, and keep the patched aircraft under a name."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pitotbench.bench.workflow import FullReconciliation, bounds_of, entries
from pitotbench.effects import effect_of
from pitotbench.logbook.columns import write_text
from pitotbench.reconciliation.patches import (
    beyond_range,
    is_settled,
    name_in_case,
    not_told,
    with_choice,
)
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.case import EffectSpec
from pitotbench.records.verdict import SURE
from pitotbench.show.columns import answer_text
from pitotbench.show.reader_units import reader_units
from pitotbench.show.verdict_tree import account_page
from pitotbench.simulation.modified import install_variant, overlay_xml

# The files that a run writes.
WRITTEN = ("verdict.json", "patch.toml", "report.html", "overlay.xml")


def keep(
    outcome: FullReconciliation, document: Mapping[str, Any], out: Path, units: str = ""
) -> list[str]:
    """Write `verdict.json`, `patch.toml` and `report.html` to a folder, and return lines to print.

    Files of an earlier run are replaced. Where an effect acts on the aircraft, `overlay.xml` is
    written too. `units` as for `reader_units`.
    """
    texts = {
        "verdict.json": answer_text(document),
        "patch.toml": outcome.patch.text,
        "report.html": account_page(outcome.account, reader_units(units)),
    }
    aircraft = outcome.account.aircraft
    overlay = overlay_xml(aircraft, _of_aircraft(outcome)) if aircraft != "none" else ""
    if overlay:
        texts["overlay.xml"] = overlay
    return _write(out, texts)


def _write(out: Path, texts: Mapping[str, str]) -> list[str]:
    """Write files to a folder, delete an earlier run's, and return the line to print."""
    out.mkdir(parents=True, exist_ok=True)
    for name in set(WRITTEN) - texts.keys():
        (out / name).unlink(missing_ok=True)
    for name, text in texts.items():
        write_text(out / name, text)
    return ["written: " + ", ".join(str(out / name) for name in texts)]


def install(outcome: FullReconciliation, variant: str, shelf: Path | None = None) -> list[str]:
    """Write the aircraft with what is named, or was chosen, as `<aircraft>+<variant>`.

    Return the lines to print. One names the effects that belong in a case file instead, one those
    that the log does not tell apart. An existing aircraft is never overwritten. Raises
    BadInputError where no named effect acts on the aircraft, or where the name is taken,
    NoAnswerError where a set is told.
    """
    verdict, aircraft, account = outcome.verdict, outcome.account.aircraft, outcome.account
    chosen = [with_choice(gap, account.chosen) for gap in verdict.gaps if gap.causes]
    settled = [gap for gap in chosen if is_settled(gap, account.chosen)]
    beyond = [line for gap in settled for line in beyond_range(gap.causes[0])]
    patched = {name_in_case(g.causes[0].name) for g in settled if not [*beyond_range(g.causes[0])]}
    acting = [each for each in _of_aircraft(outcome) if each.name in patched]
    open_sets = not_told(verdict.gaps, account.chosen, [each.maneuver for each in account.flights])
    if not acting and (open_sets or beyond):
        raise NoAnswerError("; ".join(filter(None, [open_sets, *beyond])))
    if not acting and (verdict.kind in SURE or entries(outcome.patch)):
        raise BadInputError(
            "no named effect acts on the aircraft: put the entries of patch.toml into the case "
            "file instead"
        )
    if not acting:
        why = (
            "there is no significant gap"
            if verdict.kind == "no_gap"
            else "the cause of the gap is unknown"
        )
        raise BadInputError(f"nothing to apply: {why}, so there is no patch")
    provenance = {
        "log": outcome.account.log,
        "verdict": verdict.kind,
        "closure": round(verdict.closure.share, 3),
        "chosen": account.chosen,
    }
    folder = install_variant(
        aircraft, variant, acting, provenance | {"two_sigma": bounds_of(settled)}, shelf
    )
    of_aircraft = _of_aircraft(outcome)
    not_of_aircraft = [e.name for e in entries(outcome.patch) if e not in of_aircraft]
    lines = [f"written: {folder}; it flies as --aircraft {folder.name}"]
    lines += [*filter(None, [open_sets]), *beyond]
    if not_of_aircraft:
        names = ", ".join(not_of_aircraft)
        lines.append(f"not of the aircraft, to be put into the case file from patch.toml: {names}")
    return lines


def _of_aircraft(outcome: FullReconciliation) -> list[EffectSpec]:
    return [e for e in entries(outcome.patch) if effect_of(e.name).acts_on == "aircraft"]
