"""What the page says beside its pictures, as plain texts: the answer and the choices.

The page puts them in as text, never as HTML.
"""

import re
from dataclasses import replace

from pitotbench.browser.desk import Desk
from pitotbench.browser.work import SETTINGS, Plain, Request
from pitotbench.channels import CHANNELS
from pitotbench.logbook.autopilot import AUTOPILOTS
from pitotbench.pressure_error import MODELS
from pitotbench.records.log import FlightSummary
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.inspection import SUMMARY_COLUMNS
from pitotbench.show.over_dates import over_dates_tree
from pitotbench.show.renderers import plain_of, plain_table
from pitotbench.show.tree import SOURCES
from pitotbench.units import KNOT, SUFFIXES, SYMBOLS

UNITS = ("kt", "kmh", "mph", "mps")
# What can be taken away.
_KINDS = ("page", "card", "record", "table", "sheet", "parameters", "mapping", "json")
_FLAGS = {each.metadata["flag"]: name for name, each in SETTINGS.items()}
_LABELS = {"begin": "from", "end": "to", "temperature_c": "temperature of the day"}  # of fields
# A flag with its value: a number, a quoted text or `name=value`, for a word goes on with the sentence.
_FLAG = re.compile(r"(--[a-z][a-z-]*)( (?=[-+−]?\d|'|\w+=)[^\s,;.)`]*[^\s,;.)`:])?")
_DRAFTED = re.compile(r"needs a mapping file: `pitotbench map.*", re.DOTALL)


def state_of(desk: Desk) -> Plain:
    """All that the page says now, ready for JSON."""
    asked = desk.request
    stated = asked or Request()
    return {
        "status": desk.status,
        "refusal": in_fields(desk.refusal),
        "flights": plain_table(SUMMARY_COLUMNS, _flights(desk)),
        "refused": [str(each.flight) if each.flight.refusal else "" for each in desk.found],
        "books": [each.handbook for each in desk.found],
        "compared": [each.log == desk.handbook for each in desk.found],
        "chosen": list(desk.chosen),
        "several": any(desk.found[i].several for i in desk.chosen),
        "unit": desk.units.speed,
        "leave_out": desk.leave_out,
        "flags": {name: stated.setting(name) for name in SETTINGS},
        "without": list(stated.without),
        "settings": settings_told(),
        "choices": {
            "model": ["", *MODELS, "auto"],
            "autopilot": [*AUTOPILOTS],
            "unit": {each: SYMBOLS[each] for each in UNITS},
        },
        "command": asked.command(desk.units) if asked is not None else "",
        "answer": _answer(desk),
        "course": _course(desk),
        "draft": _draft(desk),
        "legs": desk.legs,
    }


def in_fields(text: str) -> str:
    """A text of a command as the page says it: by the names of its fields, not by flags."""

    def field(found: re.Match[str]) -> str:
        name = _FLAGS.get(found[1])
        label = _LABELS.get(name, name.replace("_", " ")) if name else ""
        return f"“{label}”{(found[2] or '').replace(' ', ' = ', 1)}" if name else found[0]

    return _FLAG.sub(field, _DRAFTED.sub("is read by the draft below: correct it", text))


def settings_told() -> Plain:
    """Each setting of the page by name: its flag, help and unit, and whether it is a switch."""
    return {
        name: {
            "flag": each.metadata["flag"],
            "unit": each.metadata["unit"],
            "help": each.metadata["settings"]["help"],
            "switch": isinstance(each.default, bool),
        }
        for name, each in SETTINGS.items()
    }


def _answer(desk: Desk) -> Plain | None:
    answer, asked = desk.answer, desk.request
    if answer is None or asked is None or desk.refusal:
        return None
    result, settings = answer.result, answer.settings
    known = {"parameters": settings is not None, "mapping": asked.mapping is not None}
    tree = calibration_tree("", {result.model: result}, lines=answer.flights, settings=settings)
    return {
        "usable": result.usable,
        "tree": _said(plain_of(tree.nodes, desk.units, SOURCES)),
        "take": [kind for kind in _KINDS if answer.final and known.get(kind, True)],
    }


def _said(told: list[Plain]) -> list[Plain]:
    """The nodes of an answer in the words of the page."""
    return [
        node | {"text": in_fields(node["text"]), "nodes": _said(node["nodes"])} for node in told
    ]


def _flights(desk: Desk) -> list[FlightSummary]:
    """The flights of the list: of one that is answered, the airspeeds of the answer."""
    if desk.answer is None:
        return [each.flight for each in desk.found]
    low, *_, high = desk.answer.result.curve.indicated_airspeed.tolist()
    return [
        replace(each.flight, airspeeds=(low, high)) if i in desk.chosen else each.flight
        for i, each in enumerate(desk.found)
    ]


def _course(desk: Desk) -> Plain | None:
    """The course over dates: its sentences, the airspeeds of its picture, and its table."""
    if (found := desk.course) is None:
        return None
    told = plain_of(over_dates_tree(found).nodes, desk.units)
    return {
        "said": [each for each in told if each["kind"] != "table"],
        "speeds": [desk.units.text(f"{each / KNOT:.0f} KIAS") for each in found.airspeed],
        "table": [each for each in told if each["kind"] == "table"],
    }


def _draft(desk: Desk) -> Plain | None:
    rows = [[theirs, *chosen, *rest[::-1]] for theirs, chosen, _, *rest in desk.draft]
    ours = {*CHANNELS, *(chosen[0] for _, chosen, *_ in desk.draft)} - {""}
    return {"rows": rows, "ours": sorted(ours), "units": sorted(SUFFIXES)} if rows else None
