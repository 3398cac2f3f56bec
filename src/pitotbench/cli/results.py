"""`pitotbench results`: list, filter, draw and join campaigns' stored results, or refly one."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.cli.shared_flags import DONE, NO_ANSWER, flag
from pitotbench.records import BadInputError

if TYPE_CHECKING:
    from pandas import DataFrame

_NAMES = "name,das,model"
_SHOWN = "minutes,residual_two_sigma_kt,two_sigma_kt,curve_rms_error_kt,curve_coverage,state"
_OF_FAILURES = "name,state,reason"


FLAGS = (
    flag("folders", nargs="+", type=Path, metavar="DIR", help="folder of a campaign, or several"),
    flag(
        "--where",
        metavar="EXPRESSION",
        help="rows, such as \"turbulence == 'light' and seed < 10\"",
    ),
    flag("--state", help="done, failed or quarantined"),
    flag(
        "--columns",
        help=f"comma list, or all (default: {_NAMES}, what varies, {_SHOWN}; of failures alone: "
        f"{_OF_FAILURES})",
    ),
    flag("--by", help="comma list of columns: the means over all others, and the number of rows"),
    flag("--limit", type=int, default=40, help="rows printed (default: %(default)s; 0: all)"),
    flag("--draw", metavar="Y,X", help="draw a column against another, with --out FILE.svg"),
    flag(
        "--page",
        metavar="FLIGHT",
        help="fly a flight of DIR again, compare every number, and draw its page, FLIGHT.html in DIR "
        "or --out",
    ),
    flag("--out", type=Path, help="write the rows to .parquet or .csv, or the figure to .svg"),
)


def run(options: argparse.Namespace) -> int:
    """Print the rows, or their means, or write them; return exit code 0.

    Raises BadInputError for options that do not go together.
    """
    from pitotbench.campaigns.result_table import (
        chosen_rows,
        means,
        require_columns,
        result_table,
        varied_columns,
        write_table,
    )

    if options.page:
        return _page(options)
    if options.draw and (options.out is None or options.out.suffix != ".svg"):
        raise BadInputError("--draw needs --out FILE.svg")
    table = chosen_rows(result_table(options.folders), options.where, options.state)
    if options.draw:
        return _draw(options, table)
    varied = varied_columns(table)
    by = options.by.split(",") if options.by else []
    averaged = means(table, by) if by else table
    if options.out is not None:
        write_table(averaged, options.out)
        print(f"{len(averaged):,} rows: {options.out}")
        return DONE
    usual = ",".join([_NAMES, *varied, _SHOWN])
    asked = options.columns or (usual if (table.state == "done").any() else _OF_FAILURES)
    columns = [*table.columns] if asked == "all" else asked.split(",")
    require_columns(table, columns)
    shown = averaged if by else table[columns]
    rows = len(shown) if options.limit == 0 else options.limit
    print(shown.head(rows).to_string(index=False, float_format="%.3f"))
    others = {"maneuver", "das", "model", *varied} - {*by}
    if pooled := sorted(n for n in others if by and n in table and len(table[n].unique()) > 1):
        print(
            f"A row is a mean over several values of {', '.join(pooled)}: add what matters to --by."
        )
    states = ", ".join(f"{count:,} {state}" for state, count in table.state.value_counts().items())
    print(f"{len(table):,} rows of {table.flight.nunique():,} flights: {states}")
    return DONE


def _page(options: argparse.Namespace) -> int:
    """Draw the page of one flight; return exit code 3 where its numbers are not those stored."""
    from pitotbench.campaigns.result_table import write_page
    from pitotbench.show.columns import printable

    if len(options.folders) > 1:
        raise BadInputError("--page takes the folder of one campaign")
    path, differences = write_page(options.folders[0] / options.page, options.out)
    lines = [printable(f"differs from the stored result: {line}") for line in differences]
    print(*(lines or ["every number is the same bit for bit"]), f"page: {path}", sep="\n")
    return NO_ANSWER if differences else DONE


def _draw(options: argparse.Namespace, table: "DataFrame") -> int:
    from pitotbench.campaigns.result_table import require_columns
    from pitotbench.logbook.columns import write_text
    from pitotbench.show.curves import scatter_svg

    columns = options.draw.split(",")
    if len(columns) != 2:
        raise BadInputError(
            f"--draw {options.draw}: give two columns, such as two_sigma_kt,minutes"
        )
    require_columns(table, columns)
    write_text(options.out, scatter_svg(table, *columns))
    print(f"drawn: {options.out}")
    return DONE
