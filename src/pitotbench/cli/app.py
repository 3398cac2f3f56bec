"""Choose the command, run it, and turn any error into one line and an exit code."""

import argparse
import codecs
import gc
import logging
import os
import re
import sys
import traceback
from argparse import Namespace, RawDescriptionHelpFormatter
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from io import TextIOWrapper
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from pitotbench.catalog import UnknownNameError
from pitotbench.cli.shared_flags import BAD_INPUT, DONE, INTERRUPTED, NO_ANSWER, UNFORESEEN
from pitotbench.records import BadInputError, NoAnswerError, error_words
from pitotbench.show.columns import printable

# The table of commands: a new command is one file with its `FLAGS` and `run(options) -> int`, and
# one line here. A module is named by a string, so that only the module of the chosen command is
# loaded.


# No dataclass: that import takes longer than all else that `--help` needs.
class Command(NamedTuple):
    """A command: its name, its module, and its description in one line."""

    name: str
    module: str
    summary: str


COMMANDS = (
    Command("fly", "pitotbench.cli.fly", "fly a case file and write the log"),
    Command(
        "calibrate", "pitotbench.cli.calibrate", "recover the error curve and the wind from a log"
    ),
    Command(
        "compare",
        "pitotbench.cli.compare",
        "two calibrations, two logs or two airplanes: what differs",
    ),
    Command(
        "inspect", "pitotbench.cli.inspect", "what a log holds, and what can be learned from it"
    ),
    Command("map", "pitotbench.cli.map", "draft a mapping for a log with unknown column names"),
    Command(
        "fixed-speed",
        "pitotbench.cli.fixed_speed",
        "leg and turn GPS methods: of a log, a card, typed legs",
    ),
    Command(
        "aircraft",
        "pitotbench.cli.aircraft",
        "what can be flown with an aircraft: yours, or one of JSBSim's",
    ),
    Command("campaign", "pitotbench.cli.campaign", "fly maneuvers, sense and calibrate them"),
    Command(
        "results", "pitotbench.cli.results", "list, filter and draw the stored results of campaigns"
    ),
    Command("open", "pitotbench.cli.open", "a page in the browser: drop a log, see the answer"),
    Command("reconcile", "pitotbench.cli.reconcile", "name the effect that a simulation lacks"),
    Command(
        "plan", "pitotbench.cli.plan", "what to fly: the 2σ of every maneuver, before it is flown"
    ),
    Command(
        "completion",
        "pitotbench.cli.completion",
        "print the script with which bash, zsh or fish completes",
    ),
)


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line.

    The flags `--debug` and `--version` are its own, and those of its commands.
    """

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        # A temperature of -5±2 and tracks of -178,85 are values, as -5 alone is. argparse has no
        # public way to say so; this attribute is as old as argparse.
        self._negative_number_matcher = re.compile(r"-\d")
        # No default: that of a command would overwrite a flag given before the command.
        shown = "show the traceback of an error"
        self.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=shown)
        self.add_argument(
            "--version", action=_ShowVersions, help="show the versions of pitotbench and JSBSim"
        )

    def error(self, message: str) -> NoReturn:
        self.exit(BAD_INPUT, printable(f"{self.prog}: {message}; see {self.prog} --help") + "\n")


class CommandParser(OneLineParser):
    """The parser of one command, which loads the command's module only when it parses."""

    def __init__(self, *args: Any, command: Command, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._command = command

    # argparse gives a subparser the arguments after the command's name through this method and no
    # other.
    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Add the command's flags if they are missing, then parse."""
        self.add_flags()
        found = super().parse_known_args(args, namespace)
        for action in self._actions:  # argparse takes `--to=--` for a flag without its value
            given = getattr(found[0], action.dest, None)
            if action.option_strings and isinstance(given, list) and (not given or [] in given):
                self.error(f"argument {'/'.join(action.option_strings)}: expected one argument")
        return found

    def add_flags(self) -> None:
        """Load the command's module and add its flags, unless that is done."""
        if self.get_default("run") is None:
            module = import_module(self._command.module)
            for each in module.FLAGS:
                self.add_argument(*each.names, **each.settings)
            self.set_defaults(run=module.run)


class _ShowVersions(argparse.Action):
    """The action of `--version`, which looks the versions up only when the flag is given."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(
            **{**settings, "nargs": 0, "dest": argparse.SUPPRESS, "default": argparse.SUPPRESS}
        )

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from pitotbench.version import version_of

        print(f"pitotbench {version_of('pitotbench')}, JSBSim {version_of('jsbsim')}")
        parser.exit(DONE)


_EPILOG = f"""\
example:
  pitotbench calibrate flight.csv --report flight.html

exit codes: {DONE} done, {BAD_INPUT} bad input, {NO_ANSWER} no answer (not converged or not observable), \
{UNFORESEEN} unexpected error, {INTERRUPTED} interrupted
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code."""
    _prepare_process(outside=arguments is None)
    parser, given = command_line(), sys.argv[1:] if arguments is None else arguments
    first = next((word for word in given if not word.startswith("-")), "")
    if first and first not in {command.name for command in COMMANDS}:
        parser.error(_no_command(first))
    return guarded(parser.parse_args(arguments))


def _no_command(word: str) -> str:
    """Say what a word in the place of a command may mean: a file, or a command written wrongly."""
    from pitotbench.catalog import explain

    path = Path(word)
    if path.suffix == ".toml":
        return f"{word} is no command: `pitotbench fly {word}` flies a case, `pitotbench campaign {word}` a plan"
    if path.suffix or path.exists():
        return f"{word} is no command: `pitotbench calibrate {word}` or `pitotbench open {word}`"
    return explain("command", word, [command.name for command in COMMANDS])


def run_alone(name: str, description: str | None) -> int:
    """Run one command of the table without its name on the command line; return its exit code."""
    _prepare_process(outside=True)
    command = next(command for command in COMMANDS if command.name == name)
    parser = CommandParser(
        description=description, formatter_class=RawDescriptionHelpFormatter, command=command
    )
    return guarded(parser.parse_args())


# How a terminal that does not know a letter shows it; any other letter becomes a question mark.
_PLAIN = {
    "±": "+/-",
    "−": "-",
    "–": "-",
    "σ": " sigma",
    "Δ": "d",
    "°": " deg",
    "→": "->",
    "×": "x",
    "²": "2",
}
_COLLECT_AFTER = 100_000  # new objects; Python's 700 suit a program that loads little


def _prepare_process(outside: bool) -> None:
    """Let no terminal stop a command: neither an old one, nor one that is closed.

    Collect garbage seldom: nearly all that a start makes stays.

    Of a command from `outside` this program, the warnings of Python and its libraries go to
    logging, where only `--debug` and the host's own settings show them. Their causes are for tests.
    """
    # Nearly all that a start makes stays to the end: searching it for garbage took a fifth of the
    # start.
    gc.set_threshold(_COLLECT_AFTER)
    codecs.register_error("plain", _in_plain_letters)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # closed: `>&-`
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="plain")
    if outside:
        # A second thread doubles the processor time of arrays of this size: the threads wait for
        # each other.
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if outside and "--debug" not in sys.argv and not sys.warnoptions:
        logging.captureWarnings(True)


def _in_plain_letters(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(
        _PLAIN.get(letter, "?") for letter in error.object[error.start : error.end]
    ), error.end


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
        commands.add_parser(command.name, help=command.summary, command=command)
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
        with suppress(OSError, ValueError):  # standard output is not a file, as in tests
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return UNFORESEEN
    except (Exception, KeyboardInterrupt) as error:
        if getattr(options, "debug", False):
            traceback.print_exc()
        code, words = _explain(error)
        # A case file may have several problems, one on each line.
        print("pitotbench:", printable(words, keep="\n"), file=sys.stderr)
        return code


def _explain(error: BaseException) -> tuple[int, str]:
    """Return the exit code of an error, and the line that explains it."""
    # Imported only here: NumPy takes longer to load than all the rest.
    from numpy.linalg import LinAlgError

    match error:
        case KeyboardInterrupt():
            text = str(error)
            return INTERRUPTED, text if text.startswith("stopped") else "interrupted"
        case NoAnswerError() | LinAlgError() | ArithmeticError():
            return NO_ANSWER, error_words(error)
        case BadInputError() | UnknownNameError() | OSError() | MemoryError() | RecursionError():
            return BAD_INPUT, error_words(error)
    return UNFORESEEN, f"{error_words(error)}; run again with --debug for the traceback"
