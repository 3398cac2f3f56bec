"""What the page says beside its pictures, as plain texts: the sentences, tables and choices of the
desk. The page puts them in as text, never as HTML.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

from pitotbench.browser.desk import FLAGS, Desk
from pitotbench.browser.work import LegAnswer, Refusal
from pitotbench.channels import CHANNELS
from pitotbench.logbook.autopilot import AUTOPILOTS
from pitotbench.pressure_error import MODELS
from pitotbench.show.calibration import GLANCE_COLUMNS, CurvePoint, glance_points
from pitotbench.show.columns import Column, shown_columns
from pitotbench.show.inspection import HELD_COLUMNS
from pitotbench.show.legs import CARD_POINT_COLUMNS
from pitotbench.show.takehome import SETTING_COLUMNS, settings_lines
from pitotbench.units import KNOT, SUFFIXES, SYMBOLS

UNITS = ("kt", "kmh", "mph")
Row = TypeVar("Row")
Plain = dict[str, Any]


def plain_table(columns: Sequence[Column[Row]], rows: Iterable[Row]) -> Plain:
    """A table as texts: headings with their units, and rows of cells."""
    rows = list(rows)
    shown = shown_columns(columns, rows)
    return {
        "head": [column.title for column in shown],
        "rows": [[column.text(row) for column in shown] for row in rows],
    }


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
        "chosen": list(desk.chosen),
        "unit": desk.unit,
        "leave_out": desk.leave_out,
        "flags": {name: getattr(asked, name, "") for name in FLAGS},
        "without": list(getattr(asked, "without", ())),
        "choices": {
            "model": ["", *MODELS, "auto"],
            "autopilot": ["", *AUTOPILOTS],
            "unit": {each: SYMBOLS[each] for each in UNITS},
        },
        "command": asked.command() if asked is not None else "",
        "answer": _answer(desk),
        "draft": _draft(desk),
        "legs": _legs(desk.legs),
    }


def _answer(desk: Desk) -> Plain | None:
    answer, asked = desk.answer, desk.request
    if answer is None or asked is None:
        return None
    short, settings = answer.short, answer.settings
    return {
        "doubts": list(answer.headline),
        "usable": answer.usable,
        "sentence": short.correction_in(desk.unit),
        "lines": [short.wind_in(desk.unit), *answer.rules, *answer.flights],
        "warnings": list(short.warnings),
        "notes": [f"{line[:1].upper()}{line[1:]}" for line in answer.notes],
        "card": plain_table(in_unit(GLANCE_COLUMNS, desk.unit), glance_points(answer.curve)),
        "autopilot": answer.autopilot,
        "parameters": None if settings is None else plain_table(SETTING_COLUMNS, settings.settings),
        "left": [] if settings is None else settings_lines(settings),
        "take": [
            "page",
            "card",
            "record",
            *(["parameters"] if settings is not None else []),
            *(["mapping"] if asked.mapping is not None else []),
            "json",
        ],
    }


def _draft(desk: Desk) -> Plain | None:
    if not desk.draft:
        return None
    numbers = [name for name, each in CHANNELS.items() if each.kind == "number"]
    units = {name: list(CHANNELS[name].suffixes) for name in numbers}
    rows = [[r.theirs, r.ours, r.unit, r.values, r.question] for r in desk.draft]
    ours = sorted({*units, *(row.ours for row in desk.draft if row.ours)})
    return {"rows": rows, "ours": ours, "units": sorted(SUFFIXES)}


def _legs(found: LegAnswer | Refusal | None) -> Plain | None:
    if found is None:
        return None
    if isinstance(found, Refusal):
        return {"refusal": found.words}
    return {
        "sentences": list(found.sentences),
        "table": None if found.card is None else plain_table(CARD_POINT_COLUMNS, found.card.points),
        "command": found.command,
    }
