"""The command line: parse, one call to the bench, print. Slow packages load only where needed."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from pitotbench.catalog import UnknownNameError
from pitotbench.commands.calibrate import add_calibrate
from pitotbench.commands.fixed_speed import add_fixed_speed
from pitotbench.planner.command import add_flags as add_plan
from pitotbench.reconciler.command import add_reconcile
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.study.command import add_flags as add_study

DONE, BAD_INPUT, NO_ANSWER = 0, 2, 3


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code: 0 done, 2 bad input, 3 not converged or not observable."""
    return guarded(_parser().parse_args(arguments))


class OneLineParser(argparse.ArgumentParser):
    """A parser whose refusals are one line, like every other error of the command line."""

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def guarded(options: argparse.Namespace) -> int:
    """Run the parsed command; a refusal becomes one line on standard error and an exit code."""
    try:
        return int(options.run(options))
    except (BadInputError, UnknownNameError) as error:
        return _refuse(error, BAD_INPUT)
    except OSError as error:
        return _refuse(BadInputError(f"{error.filename or 'file'}: {error.strerror or error}"), BAD_INPUT)
    except NoAnswerError as error:
        return _refuse(error, NO_ANSWER)


def _refuse(error: Exception, code: int) -> int:
    print(f"pitotbench: {error}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = OneLineParser(
        prog="pitotbench", description="A simulated flight-test bench for pitot-static calibration."
    )
    commands = parser.add_subparsers(required=True, metavar="command")
    _add_fly(commands.add_parser("fly", help="fly a case file and write the log"))
    add_calibrate(commands.add_parser("calibrate", help="recover the error curve and the wind from a log"))
    add_fixed_speed(commands.add_parser("fixed-speed", help="leg and turn GPS methods, of a log or of typed legs"))
    add_campaign(commands.add_parser("campaign", help="fly maneuvers, sense and calibrate them"))
    add_reconcile(commands.add_parser("reconcile", help="name the effect that a simulation lacks"))
    add_study(commands.add_parser("study", help="the paper's simulator study, claim by claim"))
    add_plan(commands.add_parser("plan", help="what to fly: the 2σ of every maneuver, before it is flown"))
    return parser


def _add_fly(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("case", type=Path, help="case file (TOML)")
    parser.add_argument("-o", "--out", type=Path, required=True, help="log to write: .csv, .parquet or .mat")
    parser.add_argument("--truth", action="store_true", help="also write <name>.truth.parquet beside the log")
    parser.set_defaults(run=_fly)


def _fly(options: argparse.Namespace) -> int:
    from pitotbench.bench import fly_to_log
    from pitotbench.records.case_file import read_case

    log = fly_to_log(read_case(options.case), options.out, options.truth)
    print(f"{len(log):,} rows written to {options.out}")
    return DONE


def add_campaign(parser: argparse.ArgumentParser) -> None:
    """The flags of a campaign, shared by `pitotbench campaign` and `scripts/run_campaign.py`."""
    from pitotbench.simulate.maneuvers import MANEUVERS, PAPER_MANEUVERS

    parser.add_argument(
        "--maneuver",
        required=True,
        help=f"{', '.join(MANEUVERS)}, a comma list, or all ({', '.join(PAPER_MANEUVERS)})",
    )
    parser.add_argument("--das", required=True, help="20/1, 50/50, 100/100, any A/G in Hz, a comma list, or all")
    parser.add_argument(
        "--model",
        default="inverse+",
        help="model, comma list, auto, or all: inverse+, quadratic, linear, bias (default: %(default)s)",
    )
    parser.add_argument("--method", default="covering", help="covering or paper (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    parser.add_argument("--wind-kt", type=float, default=15.0, help="wind speed [kt] (default: %(default)g)")
    parser.add_argument(
        "--wind-from-deg", type=float, default=300.0, help="wind direction [°] (default: %(default)g)"
    )
    parser.add_argument("--pilot", default="none", help="none, good or busy (default: %(default)s)")
    parser.add_argument("--aircraft", default="navajo", help="aircraft to fly (default: %(default)s)")
    parser.add_argument(
        "--seeds", type=int, default=1, help="flights of each maneuver: truth and sensor seeds 1 to N (default: 1)"
    )
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument(
        "--scheduler", help="address of a dask scheduler, tcp://host:port, whose workers see the folder of --out"
    )
    parser.add_argument("--log-format", default="parquet", help="parquet, csv or mat (default: %(default)s)")
    parser.add_argument("--out", type=Path, help="folder for the results (default: out/<maneuver>-<das>)")
    parser.set_defaults(run=run_campaign)


def run_campaign(options: argparse.Namespace) -> int:
    """Fly a campaign, print its table and name its report."""
    from pitotbench.campaign.command import request_of, run_and_print

    return DONE if run_and_print(request_of(options)) else NO_ANSWER


if __name__ == "__main__":
    sys.exit(main())
