"""`pitotbench completion`: the script with which a shell completes the commands."""

import argparse

from pitotbench.cli.shared_flags import DONE, flag

FLAGS = (flag("shell", choices=("bash", "zsh", "fish"), help="the shell; the script is printed"),)


def run(options: argparse.Namespace) -> int:
    """Print the completion script of a shell; return exit code 0."""
    import shtab

    from pitotbench.cli.app import command_line

    parser = command_line()
    # argparse has no public list of its actions; this attribute is as old as argparse.
    commands = next(a.choices for a in parser._actions if isinstance(a.choices, dict))
    for command in commands.values():
        command.add_flags()
        for action in command._actions:
            if action.choices is None and action.nargs != 0:
                action.complete = shtab.FILE  # what has no list of names may be a file
    print(shtab.complete(parser, options.shell))
    return DONE
