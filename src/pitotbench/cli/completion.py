"""`pitotbench completion`: the script with which a shell completes commands and flags."""

import argparse
from importlib import import_module

from pitotbench.cli.app import DONE

SHELLS = ("bash", "zsh", "fish")


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench completion`."""
    parser.add_argument("shell", choices=SHELLS, help="the shell; the script is printed")


def run(options: argparse.Namespace) -> int:
    """Print the completion script of a shell; return exit code 0."""
    import shtab

    from pitotbench.cli.app import COMMANDS, command_line

    parser = command_line()
    # argparse has no public list of its actions; this attribute is as old as argparse.
    commands = next(a.choices for a in parser._actions if isinstance(a.choices, dict))
    for command in COMMANDS:
        import_module(command.module).add(commands[command.name])
        for action in commands[command.name]._actions:
            if action.choices is None and action.nargs != 0:
                action.complete = shtab.FILE  # what has no list of names may be a file
    print(shtab.complete(parser, options.shell))
    return DONE
