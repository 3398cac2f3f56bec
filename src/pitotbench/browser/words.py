"""What the page says beside its pictures, as plain texts: the sentences, tables and choices of the
desk. The page puts them in as text, never as HTML.
"""

from pitotbench.browser.desk import Desk
from pitotbench.browser.work import FLAGS, Plain, plain_table
from pitotbench.channels import CHANNELS
from pitotbench.logbook.autopilot import AUTOPILOTS
from pitotbench.pressure_error import MODELS
from pitotbench.show.calibration import (
    GLANCE_COLUMNS,
    assumption_lines,
    doubts_of,
    glance_points,
    handbook_lines,
    is_doubt,
    location_lines,
    part_lines,
    short_answer_of,
)
from pitotbench.show.columns import shown_columns
from pitotbench.show.inspection import HELD_COLUMNS
from pitotbench.show.limits import judgments
from pitotbench.show.reader_units import Units
from pitotbench.show.takehome import SETTING_COLUMNS, settings_lines
from pitotbench.units import SUFFIXES, SYMBOLS

UNITS = ("kt", "kmh", "mph")
_KINDS = ("page", "card", "record", "parameters", "mapping", "json")  # to take away


def state_of(desk: Desk) -> Plain:
    """All that the page says now, ready for JSON."""
    asked = desk.request
    return {
        "status": desk.status,
        "refusal": desk.refusal,
        "flights": plain_table(HELD_COLUMNS, [each.flight for each in desk.found]),
        "refused": [str(each.flight) if each.flight.refusal else "" for each in desk.found],
        "books": [each.handbook for each in desk.found],
        "compared": [each.log == desk.handbook for each in desk.found],
        "chosen": list(desk.chosen),
        "several": any(desk.found[i].several for i in desk.chosen),
        "unit": desk.unit,
        "leave_out": desk.leave_out,
        "flags": {name: getattr(asked, name, "") for name in FLAGS},
        "without": list(getattr(asked, "without", ())),
        "choices": {
            "model": ["", *MODELS, "auto"],
            "autopilot": [*AUTOPILOTS],
            "unit": {each: SYMBOLS[each] for each in UNITS},
        },
        "command": asked.command() if asked is not None else "",
        "answer": _answer(desk),
        "draft": _draft(desk),
        "legs": desk.legs,
    }


def _answer(desk: Desk) -> Plain | None:
    answer, asked = desk.answer, desk.request
    if answer is None or asked is None or desk.refusal:
        return None
    result, settings = answer.result, answer.settings
    short = short_answer_of(result, "")
    known: Plain = {"parameters": settings, "mapping": asked.mapping}
    units, doubts = Units(speed=desk.unit), doubts_of(result)
    rules = [judgment.sentence for judgment in judgments(result)]
    notes = [*part_lines(result), *location_lines(result), *assumption_lines(result)]
    read = [str(each) for each in result.warnings if not is_doubt(each)]
    rows = glance_points(result.curve)
    lines = [*handbook_lines(result.curve), short.wind_sentence, *rules, *answer.flights]
    return {
        "doubts": [units.text(each) for each in doubts[:1]],
        "usable": result.usable,
        "sentence": units.text(short.correction_sentence),
        "lines": [units.text(each) for each in lines],
        "warnings": [units.text(each) for each in doubts[1:]],
        "notes": [units.text(f"{line[:1].upper()}{line[1:]}") for line in [*notes, *read]],
        "card": plain_table(units.columns(shown_columns(GLANCE_COLUMNS, rows)), rows),
        "parameters": plain_table(SETTING_COLUMNS, settings.settings if settings else ()),
        "left": [] if settings is None else settings_lines(settings),
        "take": [kind for kind in _KINDS if answer.final and known.get(kind, kind)],
    }


def _draft(desk: Desk) -> Plain | None:
    rows = [[theirs, *told, *rest[::-1]] for theirs, told, _, *rest in desk.draft]
    ours = {*CHANNELS, *(told[0] for _, told, *_ in desk.draft)} - {""}
    return {"rows": rows, "ours": sorted(ours), "units": sorted(SUFFIXES)} if rows else None
