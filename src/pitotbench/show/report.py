"""The page: static, self-contained, one file that opens offline and travels by mail."""

from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby

import pandas as pd

from pitotbench.show.markup import render
from pitotbench.show.remarks import remarks
from pitotbench.show.section_content import Section
from pitotbench.show.summary import summary_panels
from pitotbench.show.tables import campaign_html

_MOST_NAMED = 2  # maneuvers that fit into a title


def campaign_page(
    subtitle: str, results: pd.DataFrame, sections: Sequence[Section], failures: Sequence[str], case: str
) -> str:
    """The HTML of a campaign: the short answer, tables, summary pictures, a section a maneuver and data system."""
    first = results[results["model"] == results["model"].iloc[0]]
    return _page(
        title=f"Pitot-static calibration: {_flown(results)}",
        subtitle=subtitle,
        sections=sections,
        notes=remarks(results, [section.answer for section in sections]),
        failures=failures,
        table=campaign_html(first),
        all_models=campaign_html(results) if len(first) < len(results) else "",
        panels=summary_panels(results) if len(sections) > 1 else [],
        case=case,
    )


def log_page(title: str, subtitle: str, sections: Sequence[Section]) -> str:
    """The HTML of a calibration of measured logs."""
    notes = remarks(pd.DataFrame(), [section.answer for section in sections])
    return _page(title=title, subtitle=subtitle, sections=sections, notes=notes)


def _flown(results: pd.DataFrame) -> str:
    names = [str(name).replace("_", " ") for name in results["maneuver"].unique()]
    return " and ".join(names) if len(names) <= _MOST_NAMED else f"{len(names)} maneuvers"


def _page(sections: Sequence[Section], **content: object) -> str:
    optional = {"failures": (), "table": "", "all_models": "", "panels": (), "case": ""}
    groups = [(name, list(group)) for name, group in groupby(sections, key=lambda section: section.group)]
    return render(
        "report.html", version=page_version(), sections=sections, groups=groups, **{**optional, **content}
    )


def page_version() -> str:
    """The version of the bench that made a page."""
    try:
        return version("pitotbench")
    except PackageNotFoundError:  # run from a checkout that was never installed
        return "(not installed)"
