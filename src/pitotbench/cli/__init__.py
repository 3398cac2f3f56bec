"""The command line: one file for each command, with `add(parser)` and `run(options)`; `app` has the table."""

from pitotbench.cli.app import main as main
