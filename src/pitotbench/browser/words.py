"""What the page says beside its pictures, as plain texts: the sentences, tables and choices of the
desk. The page puts them in as text, never as HTML.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from pitotbench.browser.desk import Desk
from pitotbench.browser.work import FLAGS, Plain, plain_table
from pitotbench.channels import CHANNELS
from pitotbench.logbook.autopilot import AUTOPILOTS
from pitotbench.pressure_error import MODELS
from pitotbench.show.calibration import (
    GLANCE_COLUMNS,
    CurvePoint,
    assumption_lines,
    correction_sentence,
    glance_points,
    handbook_lines,
    headline,
    location_lines,
    part_lines,
    short_answer_of,
)
from pitotbench.show.columns import Column
from pitotbench.show.inspection import HELD_COLUMNS
from pitotbench.show.limits import judgments
from pitotbench.show.takehome import SETTING_COLUMNS, settings_lines
from pitotbench.units import KNOT, SUFFIXES, SYMBOLS

UNITS = ("kt", "kmh", "mph")
_KINDS = ("page", "card", "record", "parameters", "mapping", "json")  # to take away


def in_unit(columns: Sequence[Column[CurvePoint]], unit: str) -> list[Column[CurvePoint]]:
    """Columns of speeds in knots, by their keys, in another unit of speed."""
    factor, symbol = KNOT / SUFFIXES[unit].factor, SYMBOLS[unit]

    def scaled(value: Callable[[CurvePoint], object]) -> Callable[[CurvePoint], object]:
        return lambda row: factor * number if isinstance(number := value(row), float) else None

    return [
        replace(
            each,
            heading=each.heading.replace("KIAS", "IAS").replace("KCAS", "CAS"),
            unit=symbol,
            value=scaled(each.value),
        )
        if each.key.endswith("_kt") and unit != "kt"
        else each
        for each in columns
    ]


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
    result, settings, short = answer.result, answer.settings, short_answer_of(answer.result, "")
    known: Plain = {"parameters": settings, "mapping": asked.mapping}
    return {
        "doubts": headline(result),
        "usable": result.usable,
        "sentence": correction_sentence(short.corrections, desk.unit),
        "lines": [
            *handbook_lines(result.curve),
            short.wind_in(desk.unit),
            *(judgment.sentence for judgment in judgments(result)),
            *answer.flights,
        ],
        "warnings": list(short.warnings),
        "notes": [
            f"{line[:1].upper()}{line[1:]}"
            for lines in (part_lines, location_lines, assumption_lines)
            for line in lines(result)
        ],
        "card": plain_table(in_unit(GLANCE_COLUMNS, desk.unit), glance_points(result.curve)),
        "parameters": plain_table(SETTING_COLUMNS, settings.settings if settings else ()),
        "left": [] if settings is None else settings_lines(settings),
        "take": [kind for kind in _KINDS if answer.final and known.get(kind, kind)],
    }


def _draft(desk: Desk) -> Plain | None:
    rows = [[theirs, *told, *rest[::-1]] for theirs, told, _, *rest in desk.draft]
    ours = {*CHANNELS, *(told[0] for _, told, *_ in desk.draft)} - {""}
    return {"rows": rows, "ours": sorted(ours), "units": sorted(SUFFIXES)} if rows else None
