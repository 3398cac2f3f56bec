"""The parsers of the command line: errors in one line, versions looked up on demand, flags added when needed."""

import argparse
from importlib import import_module
from typing import Any, NoReturn

from pitotbench.cli.exit_codes import BAD_INPUT, DONE
from pitotbench.show.terminal import printable


class OneLineParser(argparse.ArgumentParser):
    """A parser whose errors are one line. It has `--debug` and `--version`, and so have its commands."""

    def __init__(self, *args: Any, **settings: Any) -> None:
        super().__init__(*args, **settings)
        # No default: that of a command would overwrite a flag given before the command.
        shown = "show the traceback of an error"
        self.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=shown)
        self.add_argument("--version", action=_ShowVersions, help="show the versions of pitotbench and JSBSim")

    def error(self, message: str) -> NoReturn:
        if message.endswith("expected one argument"):  # argparse takes a value such as -178,185 for a flag
            message += " (a value that begins with a minus sign is written FLAG=VALUE)"
        self.exit(BAD_INPUT, printable(f"{self.prog}: {message}; see {self.prog} --help") + "\n")


class CommandParser(OneLineParser):
    """The parser of one command. It loads the command's module only when it parses, not for other commands."""

    def __init__(self, *args: Any, module: str, **settings: Any) -> None:
        super().__init__(*args, **settings)
        self._module = module

    # argparse gives a subparser the arguments after the command's name through this method and no other.
    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Add the command's flags if they are missing, then parse."""
        if self.get_default("run") is None:
            command = import_module(self._module)
            command.add(self)
            self.set_defaults(run=command.run)
        return super().parse_known_args(args, namespace)


class _ShowVersions(argparse.Action):
    """The action of `--version`, which looks the versions up only when the flag is given."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{**settings, "nargs": 0, "dest": argparse.SUPPRESS, "default": argparse.SUPPRESS})

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        from pitotbench import __version__

        print(f"pitotbench {__version__}, JSBSim {version('jsbsim')}")
        parser.exit(DONE)
