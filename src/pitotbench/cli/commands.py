"""The table of commands: a new command is one file with `add(parser)` and `run(options) -> int`, and one line here.

A module is named by a string, so that only the module of the chosen command is loaded.
"""

from typing import NamedTuple  # not a dataclass: that import takes longer than all else that `--help` needs


class Command(NamedTuple):
    """A command: its name, its module, and its description in one line."""

    name: str
    module: str
    summary: str


COMMANDS = (
    Command("fly", "pitotbench.cli.fly", "fly a case file and write the log"),
    Command("calibrate", "pitotbench.cli.calibrate", "recover the error curve and the wind from a log"),
    Command("inspect", "pitotbench.cli.inspect", "what a log holds, and what can be learned from it"),
    Command("map", "pitotbench.cli.map", "draft a mapping for a log with unknown column names"),
    Command("fixed-speed", "pitotbench.cli.fixed_speed", "leg and turn GPS methods: of a log, a card, typed legs"),
    Command("aircraft", "pitotbench.cli.aircraft", "what can be flown with an aircraft: yours, or one of JSBSim's"),
    Command("campaign", "pitotbench.cli.campaign", "fly maneuvers, sense and calibrate them"),
    Command("results", "pitotbench.cli.results", "list, filter and draw the stored results of campaigns"),
    Command("reproduce", "pitotbench.cli.reproduce", "fly one stored result again, and compare"),
    Command("reconcile", "pitotbench.cli.reconcile", "name the effect that a simulation lacks"),
    Command("plan", "pitotbench.cli.plan", "what to fly: the 2σ of every maneuver, before it is flown"),
    Command("completion", "pitotbench.cli.completion", "print the script with which bash, zsh or fish completes"),
)
