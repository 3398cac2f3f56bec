"""`pitotbench fly`: fly a case file and write its log."""

import argparse
from pathlib import Path

from pitotbench.cli.shared_flags import flag

FLAGS = (
    flag("case", type=Path, help="case file (TOML)"),
    flag("-o", "--out", type=Path, required=True, help="log to write: .csv, .parquet or .mat"),
    flag("--truth", action="store_true", help="also write <name>.truth.parquet beside the log"),
)


def run(options: argparse.Namespace) -> int:
    """Fly the case and write the log; return exit code 0.

    Raises BadInputError before the flight for bad paths.
    """
    from pitotbench.campaigns.flights import fly_to_log
    from pitotbench.logbook.formats import FORMATS
    from pitotbench.records.case_file import read_case
    from pitotbench.records.outputs import require_file
    from pitotbench.sensing.recorder import truth_path
    from pitotbench.show.columns import printable

    case = read_case(options.case)
    require_file(options.out, FORMATS, [options.case])
    if options.truth:
        require_file(truth_path(options.out), FORMATS, [options.case])
    log = fly_to_log(case, options.out, options.truth)
    print(printable(f"{len(log):,} rows written to {options.out}"))
    return 0
