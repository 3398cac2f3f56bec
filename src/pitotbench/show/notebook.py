"""Views of records in a notebook: one line, HTML, a picture, a table.

A new record adds one function to each.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pitotbench.channels import CHANNELS
from pitotbench.logbook.autopilot import stated_parameters
from pitotbench.logbook.columns import write_text
from pitotbench.pressure_error.autopilot_settings import autopilot_settings
from pitotbench.records.calibration import AutopilotSettings, Calibration, RecordedAutopilot
from pitotbench.records.case import Case
from pitotbench.records.case_file import case_columns
from pitotbench.records.forecast import Plan
from pitotbench.records.gap import Account
from pitotbench.records.log import FlightLog, LogInspection
from pitotbench.records.outputs import PAGES, require_file
from pitotbench.show.calibration import doubts_of as doubts_of
from pitotbench.show.calibration_json import calibration_json
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.columns import answer_text, json_rows
from pitotbench.show.curve_rows import CURVE_COLUMNS, card_csv, curve_points
from pitotbench.show.curves import curve_marks
from pitotbench.show.inspection import CHANNEL_COLUMNS, inspection_tree
from pitotbench.show.inspection_panels import speed_marks
from pitotbench.show.limits import LimitJudgment, judgments, limit_for, limit_named
from pitotbench.show.pages import calibration_record, log_page, log_section
from pitotbench.show.plan import plan_json, plan_tree
from pitotbench.show.plan_panels import draw_bounds
from pitotbench.show.reader_units import reader_units
from pitotbench.show.renderers import html_of
from pitotbench.show.style import BLUE, WIDE, Mark, drawing, frame
from pitotbench.show.tree import ANSWER, Doubt, Node, Sentence, nodes_in
from pitotbench.show.verdict_tree import account_tree
from pitotbench.show.words import size_words, words

View = Callable[[Any], Any]  # what shows a record of one type
_CAUSES = 8  # bars of a picture of causes
_WIDER = 1.5  # times a panel of a page


def in_one_line(record: object) -> str:
    """Return the record in one line of text: its first sentence and first doubt in tree order.

    Raises TypeError for a record without a tree.
    """
    nodes = [*nodes_in(_view_of(record, _TREES, "view in a notebook")(record), ANSWER)]
    firsts: dict[type, str] = {}
    for node in nodes:
        if isinstance(node, Doubt | Sentence):
            firsts.setdefault(type(node), node.text)
    return reader_units().text(" ".join(firsts.values()))


def to_html(record: object) -> str:
    """The record as a piece of HTML: what its tree says first, with its pictures.

    Raises TypeError for a record without a tree.
    """
    return html_of(_view_of(record, _TREES, "view in a notebook")(record), reader_units(), ANSWER)


def to_frame(record: object) -> pd.DataFrame:
    """The record as a table; each column ends in its unit.

    Raises TypeError for a record without one.
    """
    return pd.DataFrame(_view_of(record, _TABLES, "table")(record))


def _view_of(record: object, views: Mapping[type, View], name: str) -> View:
    """The view of a record. Raises TypeError for a record without one."""
    if type(record) not in views:
        raise TypeError(f"{type(record).__name__} has no {name}")
    return views[type(record)]


def plot(record: object, axes: Axes | None = None) -> Figure:
    """Draw the record on the axes given, or in a new figure, and return the figure.

    Raises TypeError for a record without a picture.
    """
    if axes is None:
        axes = Figure(figsize=(_WIDER * WIDE[0], _WIDER * WIDE[1]), layout="constrained").subplots()
    drawing(*_view_of(record, _PICTURES, "picture")(record))(axes)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize="small")
    figure = axes.get_figure(root=True)
    assert figure is not None
    return figure


def write_page(record: Calibration, path: Path, units: str) -> None:
    """Write a calibration with its pictures and its card as a page, in the units asked for."""
    require_file(path, PAGES)
    name = ", ".join(each.name for each in record.provenance.inputs) or "a log"
    section = log_section(name, None, record, units=reader_units(units))
    write_text(path, log_page("Pitot-static calibration", [section], reader_units(units)))


def write_record(record: Calibration, path: Path, rule: str, units: str) -> None:
    """Write the record of a calibration for the file, in the units asked for."""
    require_file(path, PAGES)
    write_text(path, calibration_record([record], limit_named(rule), reader_units(units)))


def write_card(record: Calibration, path: Path) -> None:
    """Write the airspeed card of a calibration."""
    require_file(path, (".csv",))
    write_text(path, card_csv(record))


def save(record: Calibration, path: Path) -> None:
    """Write a calibration in the form that the suffix of a file asks for."""
    suffix = path.suffix.lower()
    if suffix == ".csv":
        write_card(record, path)
    elif suffix in PAGES:
        write_page(record, path, "")
    else:
        require_file(path, (".json", ".csv", *PAGES))
        write_text(path, answer_text(calibration_json(record)))


def judge(record: Calibration, rule: str) -> list[LimitJudgment]:
    """Judge the curve of a calibration by a rule of the flag `--limit`."""
    return judgments(record, limit_named(rule))


def params(record: Calibration, autopilot: str) -> AutopilotSettings:
    """Derive the parameters of an autopilot from a calibration.

    Old values may follow its name, as on a flag.
    """
    name, stated = stated_parameters(autopilot)
    return autopilot_settings(
        replace(record, autopilot=RecordedAutopilot(stated)) if stated else record, name
    )


def _log_tree(record: FlightLog) -> list[Node]:
    rate = 1.0 / float(np.median(np.diff(record.time)))
    columns = [*to_frame(record).columns]
    rows = (
        f"{'simulated' if record.simulated else 'measured'}, {len(record):,} rows in "
        f"{(record.time[-1] - record.time[0]) / 60.0:.1f} min at {rate:.4g} Hz"
    )
    return [Sentence(f"{rows}, {len(columns)} channels"), Sentence(", ".join(columns))]


def _case_tree(record: Case) -> list[Node]:
    stated = case_columns(record).items()
    numbers = (
        size_words(key.replace(".", " "), v)
        for key, v in stated
        if isinstance(v, float) and "das." not in key
    )
    first = f"{record.aircraft}, {words(record.maneuver)}, {record.turbulence} turbulence"
    return [Sentence("; ".join([first, f"{record.das.label} Hz", *numbers]))]


def _plan_rows(record: Plan) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = plan_json(record)["forecasts"]
    return [{k: v for k, v in row.items() if not isinstance(v, (dict, list))} for row in rows]


def _cause_rows(record: Account) -> list[dict[str, Any]]:
    """A row for each size of each cause, the most probable first.

    Sizes are in the units of their names.
    """
    named = {effect.name: effect for effect in record.verdict.effects}
    return [
        {
            "effect": each.name,
            "probability": each.probability,
            "named": each.name in named,
            "parameter": size.name,
            "value": size.value,
            "two_sigma": size.two_sigma,
            "score": each.score,
        }
        for each in (
            named.get(candidate.name, candidate) for candidate in record.verdict.candidates
        )
        for size in each.sizes
    ]


def _cause_marks(record: Account) -> list[Mark]:
    """The probability of each cause."""
    causes = sorted(record.verdict.probabilities.items(), key=lambda item: -item[1])[:_CAUSES]
    return [
        lambda axes: axes.barh([words(c) for c, _ in causes], [p for _, p in causes], color=BLUE),
        lambda axes: axes.invert_yaxis(),
        frame("probability, given a gap", "", xlim=(0.0, 1.0)),
    ]


# A new record adds a line to each.
_TREES: dict[type, View] = {
    Case: _case_tree,
    Calibration: lambda record: calibration_tree("", {record.model: record}).nodes,
    FlightLog: _log_tree,
    LogInspection: inspection_tree,
    Plan: plan_tree,
    Account: account_tree,
}
_TABLES: dict[type, View] = {
    Calibration: lambda record: json_rows(CURVE_COLUMNS, curve_points(record.curve)),
    FlightLog: lambda record: {CHANNELS[n].column: v for n, v in record.channels().items()},
    LogInspection: lambda record: json_rows(CHANNEL_COLUMNS, record.channels),
    Plan: _plan_rows,
    Account: _cause_rows,
}
_PICTURES: dict[type, View] = {
    Calibration: lambda r: curve_marks({r.model: r}, limit=limit_for(r)),
    FlightLog: speed_marks,
    Plan: lambda record: [partial(draw_bounds, plan=record)],
    Account: _cause_marks,
}
