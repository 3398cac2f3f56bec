"""The command line: one file a command, each with `add(parser)` and `run(options)`; the table is in `commands`."""

from pitotbench.cli.app import main as main
