"""Read the first sheet of a spreadsheet (.xlsx) that holds a table.

Needs openpyxl, of the extra pitotbench[logs].
"""

import csv
import zipfile
from dataclasses import replace
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

from pitotbench.logbook.columns import Table
from pitotbench.logbook.csv import read_text
from pitotbench.logbook.damage import complete
from pitotbench.records import BadInputError

_MOST_UNPACKED = 100 << 20  # bytes of the XML of a workbook
_MOST_CELLS = 2_000_000  # of a sheet: an hour at 10 Hz of fifty columns


def read_xlsx(path: Path) -> Table:
    """Return the table of a workbook's first sheet that is not empty, as its CSV would be read.

    A formula has the value that was saved with it. Raises BadInputError where openpyxl is not
    installed, for a file that is no workbook or holds no table, and for one of more than 100 MB or
    of more than two million cells.
    """
    try:
        from openpyxl import load_workbook  # an extra: most users never read a spreadsheet
    except ImportError as error:
        raise BadInputError(
            "reading a spreadsheet needs openpyxl: pip install 'pitotbench[logs]', or save the "
            "sheet as CSV (UTF-8)"
        ) from error
    with complete("spreadsheet (.xlsx)", Exception):  # openpyxl lets errors of all kinds out
        with zipfile.ZipFile(path) as packed:
            size = sum(entry.file_size for entry in packed.infolist())
        if size > _MOST_UNPACKED:
            raise _too_large(f"{size >> 20:,} MB unpacked")
        book = load_workbook(path, read_only=True, data_only=True)
        sheets = [(sheet.title, _rows(sheet)) for sheet in book.worksheets]
        book.close()
    title, rows = next(((title, rows) for title, rows in sheets if rows), ("", []))
    if not rows:
        raise BadInputError("the spreadsheet holds no table: give the one with the readings")
    text = StringIO()
    csv.writer(text).writerows(rows)
    table = read_text(BytesIO(text.getvalue().encode()))
    others = [name for name, found in sheets if found and name != title]
    note = f"; not read: {', '.join(others)}" if others else ""
    words = f"read from the sheet {title!r}{note}"
    return replace(table, warnings=(words, *table.warnings))


def _too_large(what: str) -> BadInputError:
    return BadInputError(f"a spreadsheet of {what}, more than is read: save its sheet as CSV")


def _rows(sheet: Any) -> list[list[str]]:
    """Return the cells of a sheet as texts, without blank rows and columns at its end."""
    rows: list[list[str]] = []
    cells = 0
    for row in sheet.iter_rows(values_only=True):
        cells += len(row)
        if cells > _MOST_CELLS:
            raise _too_large(f"more than {_MOST_CELLS:,} cells")
        rows.append([_text(cell) for cell in row])
    rows = [row for row in rows if any(row)]
    width = max((max(i + 1 for i, cell in enumerate(row) if cell) for row in rows), default=0)
    return [(row + [""] * width)[:width] for row in rows]


def _text(cell: object) -> str:
    return "" if cell is None else " ".join(str(cell).split())
