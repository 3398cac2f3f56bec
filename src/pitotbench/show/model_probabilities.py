"""Which models a calibration with `--model auto` weighed, and what speaks for each."""

from html import escape
from typing import Any

from rich.box import SIMPLE_HEAVY
from rich.console import Console
from rich.table import Table

from pitotbench.records.calibration import Calibration

# Heading, and the key of the choice's row; of criteria the distance from the best model is shown.
_COLUMNS = {"model": "model", "parameters": "parameters [-]", "weight": "weight [%]"}
_LESS_IS_BETTER = {"aicc": "AICc − least [-]", "bic": "BIC − least [-]"}
_MORE_IS_BETTER = {"log_likelihood": "ln L − greatest [-]", "held_out": "held-out ln p − greatest [-]"}


def probabilities_of(result: Calibration) -> list[dict[str, Any]]:
    """The rows of the choice, empty where the model was named."""
    return list((result.diagnostics or {}).get("model_choice", []))


def print_choice(result: Calibration, console: Console) -> None:
    """Print the weighed models; nothing where the model was named."""
    rows = probabilities_of(result)
    if not rows:
        return
    table = Table(title="models weighed", title_justify="left", box=SIMPLE_HEAVY, pad_edge=False)
    for heading in _headings():
        table.add_column(heading.replace("[", "\\["), justify="left" if heading == "model" else "right")
    for cells in _cells(rows):
        table.add_row(*cells)
    console.print(table)
    sizes = (result.diagnostics or {}).get("departure", {})
    console.print(
        "departure from a law, rms in Δp/q_c: " + ", ".join(f"{size} {100 * p:.0f} %" for size, p in sizes.items())
    )


def choice_html(result: Calibration) -> str:
    """The same table as HTML, folded away; empty where the model was named."""
    rows = probabilities_of(result)
    if not rows:
        return ""
    head = "".join(f"<th>{escape(heading)}</th>" for heading in _headings())
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>" for cells in _cells(rows))
    return (
        '<details><summary>The models weighed</summary><div class="scroll"><table><thead>'
        f"<tr>{head}</tr></thead><tbody>{body}</tbody></table></div></details>"
    )


def _headings() -> list[str]:
    return [*_COLUMNS.values(), *_LESS_IS_BETTER.values(), *_MORE_IS_BETTER.values()]


def _cells(rows: list[dict[str, Any]]) -> list[list[str]]:
    best = {key: min(row[key] for row in rows if key in row) for key in _LESS_IS_BETTER}
    best |= {key: max(row[key] for row in rows if key in row) for key in _MORE_IS_BETTER}
    return [
        [
            f"{row['model']}{' (chosen)' if row['chosen'] else ''}",
            str(row.get("parameters", "-")),
            f"{100.0 * row['weight']:.1f}",
            *(f"{row[key] - best[key]:+.1f}" if key in row else "-" for key in best),
        ]
        for row in rows
    ]
