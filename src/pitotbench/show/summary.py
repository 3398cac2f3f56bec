"""Pictures of a campaign: its maneuvers compared, by data system and by model."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from pitotbench.show.campaign_table import campaign_table
from pitotbench.show.style import BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, Panel, panel
from pitotbench.units import Array

if TYPE_CHECKING:
    import pandas as pd

_COLORS = (BLUE, SKY, GREEN, ORANGE, PURPLE, RED, GREY)
_BARS = 0.8  # share of a maneuver's place that bars fill


def summary_panels(results: "pd.DataFrame") -> list[Panel]:
    """2σ of the residual, the bound of the curve with the true error, and the models where several were fitted."""
    table = campaign_table(results)
    models = list(table["model"].unique())
    first = table[table["model"] == models[0]]
    panels = [
        panel(
            f"2σ of the residual ({models[0]})",
            lambda axes: draw_summary_bars(axes, first, "das", "residual_two_sigma_kt", "2σ of the residual [kt]"),
            "The scatter that gusts and sensor noise leave: the figure that the literature reports.",
        ),
        panel(
            f"How well the curve is known ({models[0]})",
            lambda axes: draw_knowledge(axes, first),
            "Bars: mean ±2σ bound of the curve. Black marks: twice the true rms error of these flights.",
        ),
    ]
    if len(models) > 1:
        system = table["das"].iloc[0]
        one = table[table["das"] == system]
        panels += [
            panel(
                f"{title}, by model ({system} Hz)",
                lambda axes, column=column, label=label: draw_summary_bars(axes, one, "model", column, label),  # type: ignore[misc]
            )
            for title, column, label in (
                ("2σ of the residual", "residual_two_sigma_kt", "2σ of the residual [kt]"),
                ("True rms error of the curve", "curve_rms_error_kt", "rms error [kt]"),
            )
        ]
    return panels


def draw_summary_bars(axes: Axes, table: "pd.DataFrame", kind: str, column: str, label: str) -> None:
    """Draw one column of the campaign's table: a group of bars a maneuver, a bar a `kind` (das or model)."""
    maneuvers = list(table["maneuver"].unique())
    kinds = list(table[kind].unique())
    width = _BARS / len(kinds)
    for number, name in enumerate(kinds):
        rows = table[table[kind] == name].set_index("maneuver")[column].reindex(maneuvers)
        text = f"{name} Hz" if kind == "das" else str(name)
        axes.bar(_places(maneuvers, number, width), rows, 0.92 * width, color=_color(number), label=text)
    axes.set_xticks(np.arange(len(maneuvers)), [str(m).replace("_", "\n") for m in maneuvers])
    axes.set_ylabel(label)
    axes.grid(axis="x", visible=False)


def draw_knowledge(axes: Axes, table: "pd.DataFrame") -> None:
    """Draw the mean bound of the curve as bars, and twice the true rms error as marks on them."""
    draw_summary_bars(axes, table, "das", "two_sigma_kt", "mean ±2σ of the curve [kt]")
    maneuvers = list(table["maneuver"].unique())
    kinds = list(table["das"].unique())
    width, label = _BARS / len(kinds), "2 × true rms error"
    for number, name in enumerate(kinds):
        error = 2.0 * table[table["das"] == name].set_index("maneuver")["curve_rms_error_kt"].reindex(maneuvers)
        axes.hlines(
            error,
            _places(maneuvers, number, width) - 0.45 * width,
            _places(maneuvers, number, width) + 0.45 * width,
            color="black",
            lw=1.8,
            label=label,
        )
        label = "_"  # one entry of the legend is enough


def _places(maneuvers: list[object], number: int, width: float) -> Array:
    return np.arange(len(maneuvers), dtype=np.float64) + ((number + 0.5) * width - 0.5 * _BARS)


def _color(number: int) -> str:
    return _COLORS[number % len(_COLORS)]
