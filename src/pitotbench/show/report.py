"""The page of a campaign and that of calibrated logs: one self-contained file each, which opens offline."""

from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby
from typing import TYPE_CHECKING

from pitotbench.show.campaign_table import campaign_html
from pitotbench.show.columns import Column, html_table
from pitotbench.show.markup import render
from pitotbench.show.remarks import remarks
from pitotbench.show.section import Section
from pitotbench.show.short_answer import ShortAnswer
from pitotbench.show.summary import summary_panels

if TYPE_CHECKING:
    import pandas as pd

_MOST_NAMED = 2  # maneuvers that fit into a title


def _correction(heading: str, number: int) -> Column[ShortAnswer]:
    def value(answer: ShortAnswer) -> str:
        correction = answer.corrections[number]
        return f"{correction} at {correction.indicated_kt:.0f} KIAS"

    return Column(heading, value)


ANSWER_COLUMNS: tuple[Column[ShortAnswer], ...] = (
    Column("flight", lambda answer: answer.subject),
    Column("model", lambda answer: answer.model),
    *(_correction(heading, number) for number, heading in enumerate(("low speed", "middle speed", "high speed"))),
    Column("wind", lambda answer: answer.wind_kt, "kt", ".1f"),
    Column("wind from", lambda answer: answer.wind_from_deg, "°", "03.0f"),
    Column("±2σ of the wind", lambda answer: answer.wind_two_sigma_kt, "kt", ".2f"),
    Column("2σ of the residual", lambda answer: answer.residual_two_sigma_kt, "kt", ".2f"),
)


def campaign_page(
    subtitle: str, results: "pd.DataFrame", sections: Sequence[Section], failures: Sequence[str], case: str
) -> str:
    """The HTML of a campaign: the short answer, tables, summary pictures, a section a maneuver and data system.

    `results` as in results.parquet; `failures`: a sentence a flight that gave no result; `case`: the TOML of the
    first flight's case.
    """
    first = results[results["model"] == results["model"].iloc[0]]
    return _page(
        title=f"Pitot-static calibration: {_flown(results)}",
        subtitle=subtitle,
        sections=sections,
        notes=remarks(results, _several(sections)),
        failures=failures,
        table=campaign_html(first),
        all_models=campaign_html(results) if len(first) < len(results) else "",
        panels=summary_panels(results) if len(sections) > 1 else [],
        case=case,
    )


def log_page(title: str, sections: Sequence[Section]) -> str:
    """The HTML of calibrated logs; the line below the title says whether they were measured or simulated."""
    origins = " and ".join(dict.fromkeys(section.group for section in sections))
    subtitle = f"From {origins}" if len(sections) > 1 else f"From a {origins.removesuffix('s')}"
    notes = remarks(None, _several(sections))
    return _page(title=title, subtitle=subtitle, sections=sections, notes=notes)


def _several(sections: Sequence[Section]) -> list[ShortAnswer]:
    """The answers whose warnings stand at the top of the page; a single section has its own at its top."""
    return [section.answer for section in sections] if len(sections) > 1 else []


def _flown(results: "pd.DataFrame") -> str:
    names = [str(name).replace("_", " ") for name in results["maneuver"].unique()]
    return " and ".join(names) if len(names) <= _MOST_NAMED else f"{len(names)} maneuvers"


def _page(sections: Sequence[Section], **content: object) -> str:
    optional = {"failures": (), "table": "", "all_models": "", "panels": (), "case": ""}
    groups = [(name, list(group)) for name, group in groupby(sections, key=lambda section: section.group)]
    return render(
        "report.html",
        version=page_version(),
        sections=sections,
        groups=groups,
        answers=html_table(ANSWER_COLUMNS, [section.answer for section in sections]),
        **{**optional, **content},
    )


def page_version() -> str:
    """The version of the bench that made a page."""
    try:
        return version("pitotbench")
    except PackageNotFoundError:  # run from a checkout that was never installed
        return "(not installed)"
