"""A table for the pages under docs/."""

import pandas as pd


def markdown_table(table: pd.DataFrame) -> str:
    """A frame as a Markdown table, its columns' names as headings, numbers with two decimals."""
    head = "| " + " | ".join(str(name) for name in table.columns) + " |\n|" + "---|" * len(table.columns)
    rows = ("| " + " | ".join(map(_cell, row)) + " |" for row in table.itertuples(index=False))
    return "\n".join([head, *rows])


def _cell(value: object) -> str:
    return f"{value:.2f}" if isinstance(value, float) else str(value)
