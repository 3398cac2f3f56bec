"""The command line: parse, one call to the bench, print. Slow packages load only where needed."""

import argparse
import os
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

from pitotbench.catalog import UnknownNameError
from pitotbench.cli.calibrate import add_calibrate
from pitotbench.cli.fixed_speed import add_fixed_speed
from pitotbench.cli.plan import add_flags as add_plan
from pitotbench.cli.reconcile import add_reconcile
from pitotbench.flags import add_wind
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.show.terminal import printable

DONE, UNFORESEEN, BAD_INPUT, NO_ANSWER, INTERRUPTED = 0, 1, 2, 3, 130
LINE_BREAK = "\n"  # the problems of a case file are listed one a line


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code: 0 done, 2 bad input, 3 not converged or not observable, 1 an error that
    was not foreseen, 130 interrupted."""
    return guarded(_parser().parse_args(arguments))


class OneLineParser(argparse.ArgumentParser):
    """A parser whose refusals are one line; it knows `--debug` and `--version`, and so do its commands."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        # No default: that of a command would overwrite what stands before the command.
        shown = "show the traceback of an error"
        self.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=shown)
        self.add_argument("--version", action=_ShowVersions, help="show the versions of pitotbench and JSBSim")

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, printable(f"{self.prog}: {message}; see {self.prog} --help") + "\n")


class _ShowVersions(argparse.Action):
    """Looks versions up only when asked."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{**settings, "nargs": 0, "dest": argparse.SUPPRESS, "default": argparse.SUPPRESS})

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        from pitotbench import __version__

        print(f"pitotbench {__version__}, JSBSim {version('jsbsim')}")
        parser.exit(DONE)


def guarded(options: argparse.Namespace) -> int:
    """Run the parsed command; any error becomes one line on standard error and an exit code.

    With `--debug` the traceback stands above that line.
    """
    try:
        code = int(options.run(options))
        sys.stdout.flush()  # a reader that has gone is noticed here, not after the last line of Python
        return code
    except BrokenPipeError:
        return _go_silently()
    except (Exception, KeyboardInterrupt) as error:
        if getattr(options, "debug", False):
            traceback.print_exc()
        code, words = _explain(error)
        print(f"pitotbench: {printable(words, keep=LINE_BREAK)}", file=sys.stderr)
        return code


def _explain(error: BaseException) -> tuple[int, str]:
    """The exit code of an error, and the words for it."""
    from numpy.linalg import LinAlgError

    text = " ".join(str(error).split()) or type(error).__name__
    match error:
        case BadInputError() | UnknownNameError():
            return BAD_INPUT, str(error)
        case NoAnswerError():
            return NO_ANSWER, str(error)
        case OSError():
            return BAD_INPUT, f"{error.filename or 'file'}: {error.strerror or error}"
        case LinAlgError() | ArithmeticError():
            return NO_ANSWER, f"the log does not determine an answer ({text}); check its clock and its units"
        case MemoryError():
            return BAD_INPUT, f"the memory does not suffice ({text}); check the clock of the log, or cut the log"
        case RecursionError():
            return BAD_INPUT, f"the input is nested too deeply ({text})"
        case KeyboardInterrupt():
            return INTERRUPTED, "interrupted"
    return UNFORESEEN, f"unexpected: {type(error).__name__}: {text}; run again with --debug for the traceback"


def _go_silently() -> int:
    """Whoever read the output has closed it (`| head -1`): there is no one to complain to."""
    with suppress(OSError, ValueError):  # a standard output that is no file, as under test
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return UNFORESEEN


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
    # By name: the product never imports the evidence.
    add_study = import_module("pitotbench.evidence.study.command").add_flags
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
    from pitotbench.logbook import FORMATS
    from pitotbench.logbook.outputs import require_file
    from pitotbench.records.case_file import read_case
    from pitotbench.sense import truth_path

    case = read_case(options.case)
    require_file(options.out, FORMATS, [options.case])
    if options.truth:
        require_file(truth_path(options.out), FORMATS, [options.case])
    log = fly_to_log(case, options.out, options.truth)
    print(printable(f"{len(log):,} rows written to {options.out}"))
    return DONE


def add_campaign(parser: argparse.ArgumentParser) -> None:
    """The flags of a campaign, shared by `pitotbench campaign` and `scripts/run_campaign.py`."""
    from pitotbench.simulate.maneuvers import MANEUVERS, PAPER_MANEUVERS

    parser.add_argument(
        "--maneuver",
        required=True,
        help=f"{', '.join(MANEUVERS)}, a comma list, all ({', '.join(PAPER_MANEUVERS)}) or every",
    )
    parser.add_argument("--das", required=True, help="20/1, 50/50, 100/100, any A/G in Hz, a comma list, or all")
    parser.add_argument(
        "--model",
        default="inverse+",
        help="model, comma list, auto, or all: inverse+, quadratic, linear, bias (default: %(default)s)",
    )
    parser.add_argument("--method", default="covering", help="covering or paper (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    add_wind(parser)
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
    from pitotbench.cli.campaign import request_of, run_and_print

    return DONE if run_and_print(request_of(options)) else NO_ANSWER
