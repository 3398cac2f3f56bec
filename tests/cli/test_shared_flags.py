"""Flags that several commands share mean the same in each."""

import pytest

from pitotbench.bench.campaign_plan import plan_tasks as campaign_plan
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.cli.app import command_line
from pitotbench.cli.plan import request_of as plan_request
from pitotbench.records import BadInputError
from pitotbench.records.case import Case
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS, maneuvers_named


def test_a_word_for_several_maneuvers_means_the_same_everywhere():
    """`all` is the paper's five, `every` the whole table, for campaigns and plans alike."""
    parse = command_line().parse_args
    for word, flown in (("all", PAPER_MANEUVERS), ("every", tuple(MANEUVERS)), ("circle,circle", ("circle",))):
        assert maneuvers_named(word) == flown
        assert plan_request(parse(["plan", "--maneuver", word])).maneuvers == flown
        tasks = campaign_plan(Case(), word, "20/1", "bias", 1, CalibrationOptions())
        assert tuple(task.case.maneuver for task in tasks) == flown
    assert maneuvers_named("all,cloverleaf") == (*PAPER_MANEUVERS, "cloverleaf")
    for wrong in ("", " , "):
        with pytest.raises(BadInputError, match="no maneuver is named"):
            maneuvers_named(wrong)
