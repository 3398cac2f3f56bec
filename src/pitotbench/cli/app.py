"""Choose the command, run it, and turn any error into one line and an exit code."""

import os
import sys
import traceback
from argparse import Namespace, RawDescriptionHelpFormatter
from collections.abc import Sequence
from contextlib import suppress

from pitotbench.catalog import UnknownNameError
from pitotbench.cli.commands import COMMANDS
from pitotbench.cli.exit_codes import BAD_INPUT, DONE, INTERRUPTED, NO_ANSWER, UNFORESEEN
from pitotbench.cli.parsers import CommandParser, OneLineParser
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.show.terminal import printable

LINE_BREAK = "\n"  # a case file may have several problems, one on each line
_EPILOG = f"""\
example:
  pitotbench calibrate flight.csv --report flight.html

exit codes: {DONE} done, {BAD_INPUT} bad input, {NO_ANSWER} no answer (not converged or not observable), \
{UNFORESEEN} unexpected error, {INTERRUPTED} interrupted
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code (`cli.exit_codes`)."""
    return guarded(command_line().parse_args(arguments))


def run_alone(name: str, description: str | None) -> int:
    """Run one command of the table without its name on the command line; return its exit code."""
    module = next(command.module for command in COMMANDS if command.name == name)
    parser = CommandParser(description=description, formatter_class=RawDescriptionHelpFormatter, module=module)
    return guarded(parser.parse_args())


def command_line() -> OneLineParser:
    """Return the parser of `pitotbench`, with one subparser for each command."""
    parser = OneLineParser(
        prog="pitotbench",
        description="A simulated flight-test bench for pitot-static calibration.",
        epilog=_EPILOG,
        formatter_class=RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=CommandParser)
    for command in COMMANDS:
        commands.add_parser(command.name, help=command.summary, module=command.module)
    return parser


def guarded(options: Namespace) -> int:
    """Run the parsed command. Any error becomes one line on standard error and an exit code.

    With `--debug` the traceback is printed above that line.
    """
    try:
        code = int(options.run(options))
        sys.stdout.flush()  # a closed pipe raises here, where it is caught, not at exit
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
    """Return the exit code of an error, and the line that explains it."""
    from numpy.linalg import LinAlgError  # imported only here: NumPy takes longer to load than all the rest

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
            return INTERRUPTED, text if text.startswith("stopped") else "interrupted"
    return UNFORESEEN, f"unexpected: {type(error).__name__}: {text}; run again with --debug for the traceback"


def _go_silently() -> int:
    """Stop without a message: the reader has closed the pipe (`| head -1`)."""
    with suppress(OSError, ValueError):  # standard output is not a file, as in tests
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return UNFORESEEN
