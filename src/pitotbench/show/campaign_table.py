"""The table of a campaign: one row a maneuver, data system and model."""

from operator import itemgetter
from typing import TYPE_CHECKING, Any

from pitotbench.show.columns import Column, frame_rows, html_table, print_table

if TYPE_CHECKING:
    import pandas as pd
    from rich.console import Console


def _column(name: str, heading: str, unit: str = "", style: str = "") -> Column[dict[str, Any]]:
    return Column(heading, itemgetter(name), unit, style, key=name)


CAMPAIGN_COLUMNS = (
    _column("maneuver", "maneuver"),
    _column("das", "DAS", "Hz"),
    _column("model", "model"),
    _column("minutes", "time", "min", ".1f"),
    _column("samples", "samples", style=",.0f"),
    _column("residual_two_sigma_kt", "2σ of the residual", "kt", ".2f"),
    _column("two_sigma_kt", "mean ±2σ of the curve", "kt", ".3f"),
    _column("curve_rms_error_kt", "true rms error", "kt", ".3f"),
    _column("wind_error_kt", "wind error", "kt", ".3f"),
    _column("curve_coverage", "curve inside ±2σ", "%", ".0%"),
)


def campaign_table(results: "pd.DataFrame") -> "pd.DataFrame":
    """The mean over seeds of a campaign's results, one row a maneuver, data system and model."""
    keys = ["maneuver", "das", "model"]
    return results.groupby(keys, sort=False).mean(numeric_only=True).reset_index()


def print_campaign(results: "pd.DataFrame", console: "Console") -> None:
    """Print the campaign's table."""
    print_table(CAMPAIGN_COLUMNS, frame_rows(campaign_table(results)), console)


def campaign_html(results: "pd.DataFrame") -> str:
    """The campaign's table as HTML."""
    return html_table(CAMPAIGN_COLUMNS, frame_rows(campaign_table(results)))
