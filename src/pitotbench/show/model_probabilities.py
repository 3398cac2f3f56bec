"""The models that a calibration with `--model auto` weighed, with the probability and the criteria of each."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from pitotbench.records.calibration import Calibration
from pitotbench.show.columns import Column, html_table, print_table

if TYPE_CHECKING:
    from rich.console import Console

_Choice = dict[str, Any]  # a row of `model_choice` in the calibration's diagnostics


def probabilities_of(result: Calibration) -> list[_Choice]:
    """The rows of the choice, empty where the model was named."""
    return list((result.diagnostics or {}).get("model_choice", []))


def choice_columns(rows: Sequence[_Choice]) -> list[Column[_Choice]]:
    """The columns of the table. A criterion is shown as its difference from the best model's."""

    def criterion(heading: str, key: str, best: Callable[..., float]) -> Column[_Choice]:
        values = [row[key] for row in rows if key in row]  # a model that the log does not determine has none
        return Column(heading, lambda row: row[key] - best(values) if key in row else None, style="+.1f")

    return [
        Column("model", lambda row: row["model"]),
        Column("chosen", lambda row: "chosen" if row["chosen"] else ""),
        Column("parameters", lambda row: row.get("parameters"), style="d"),
        Column("probability", lambda row: 100.0 * row["weight"], "%", ".1f"),
        criterion("AICc − least", "aicc", min),
        criterion("BIC − least", "bic", min),
        criterion("ln likelihood − greatest", "log_likelihood", max),
        criterion("held-out ln likelihood − greatest", "held_out", max),
    ]


def print_choice(result: Calibration, console: "Console") -> None:
    """Print the weighed models; nothing where the model was named."""
    rows = probabilities_of(result)
    if not rows:
        return
    print_table(choice_columns(rows), rows, console, "models weighed")
    console.print(departure_line(result))
    console.print()


def choice_html(result: Calibration) -> str:
    """The same table as HTML, folded away; empty where the model was named."""
    rows = probabilities_of(result)
    if not rows:
        return ""
    return (
        f"<details><summary>The models weighed</summary>{html_table(choice_columns(rows), rows)}"
        f"<p>{departure_line(result)}</p></details>"
    )


def departure_line(result: Calibration) -> str:
    """The probability of each size of a departure of the true curve from every model."""
    sizes = (result.diagnostics or {}).get("departure", {})
    parts = ", ".join(f"{size} with {100 * p:.0f} %" for size, p in sizes.items())
    return f"departure of the curve from its model, rms in Δp/q_c, with its probability: {parts}"
