"""The page: static, self-contained, one file that opens offline and travels by mail."""

from collections.abc import Sequence
from importlib.metadata import version
from importlib.resources import files

import numpy as np
import pandas as pd
from jinja2 import Environment

from pitotbench.show.section import anchor
from pitotbench.show.style import BLUE, ORANGE, SKY, canvas, svg
from pitotbench.show.tables import campaign_html, campaign_table


def campaign_page(
    title: str, subtitle: str, results: pd.DataFrame, sections: Sequence[str], failures: Sequence[str], case: str
) -> str:
    """The HTML of a campaign: table, summary picture, one section a maneuver and data system."""
    flown = flown_pairs(results)
    links = [(anchor(maneuver, das), f"{maneuver.replace('_', ' ')} {das}") for maneuver, das in flown]
    picture = f"<figure>{summary_figure(results)}</figure>" if len(flown) > 1 else ""
    summary = campaign_html(results) + picture if len(results) else ""
    return _page(
        title=title,
        subtitle=subtitle,
        links=links if len(links) > 1 else [],
        summary=summary,
        sections=sections,
        failures=failures,
        case=case,
        simulated=True,
    )


def log_page(title: str, subtitle: str, sections: Sequence[str]) -> str:
    """The HTML of a calibration of measured logs."""
    return _page(title=title, subtitle=subtitle, sections=sections)


def _page(**content: object) -> str:
    text = files("pitotbench.show").joinpath("templates/report.html").read_text(encoding="utf-8")
    template = Environment(autoescape=True, trim_blocks=True).from_string(text)
    return template.render(version=version("pitotbench"), **content)


def flown_pairs(results: pd.DataFrame) -> list[tuple[str, str]]:
    """Maneuver and data system of the results, each pair once, in their order."""
    return list(dict.fromkeys(zip(map(str, results["maneuver"]), map(str, results["das"]), strict=True)))


def summary_figure(results: pd.DataFrame) -> str:
    """Residual 2σ, and covering 2σ beside the true error, of each maneuver and data system (the first model)."""
    first = results[results.model == results.model.iloc[0]]
    table = campaign_table(first)
    labels = [f"{maneuver.replace('_', ' ')} {das}" for maneuver, das in flown_pairs(table)]
    place = np.arange(len(table))
    with canvas(1, 2, 12.0, 3.8) as (figure, (residual, bound)):
        residual.bar(place, table.residual_two_sigma_kt, color=SKY, width=0.7)
        residual.set(title=f"2σ of the residual ({table.model.iloc[0]})", ylabel="2σ [kt]")
        bound.bar(place - 0.2, table.two_sigma_kt, color=BLUE, width=0.4, label="mean 2σ of the curve")
        bound.bar(place + 0.2, 2.0 * table.curve_rms_error_kt, color=ORANGE, width=0.4, label="2 x true rms error")
        bound.set(title="How well the curve is known", ylabel="[kt]")
        bound.legend()
        for axes in (residual, bound):
            axes.set_xticks(place, labels, rotation=90 if len(place) > 6 else 0, fontsize=7.5)
            axes.grid(axis="x", visible=False)
        return svg(figure)
