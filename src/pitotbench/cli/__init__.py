"""The command line: files with `FLAGS` and `run(options)` for each command; `app` has the table."""

from pitotbench.cli.app import main as main
