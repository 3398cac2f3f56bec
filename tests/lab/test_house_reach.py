"""What a job makes somebody read who changes it, by a profiler; and the room for new entries."""

from pathlib import Path

import pytest
from tests.test_pages_run import readme_blocks

from pitotbench.campaigns.digests import _FLYING_CAMPAIGNS
from pitotlab.house import PRODUCT, reach_of_jobs, statements_in

# Statements of the functions that a job enters, on a circle at 20/1 in light turbulence. Each limit
# is what the job entered when this gauge was made (1,103; 4,609; 5,565; 4,441) and 3 % of it: a
# mended fault and a new entry of a table must fit. What needs more takes something out. The goals
# are 4,000 for `calibrate` and 4,900 for `reconcile`. The limits of all but `fly` are 3 % above that
# while columns of the calibration stand beside the decisions that they are to replace, and while a
# log is compared with the others so that a flight counts once; these 3 % go with the decisions.
# `fly` has 30 besides: the limits of a foreign file and airplane, a mass that a patch carries, and a
# case that refuses an unknown name. `calibrate` has 150 besides and a campaign 60: what a probe that
# is 5 K off and turns to one side would move stand in the answer, each finding tells what it moves,
# and somebody may state wind, height and slowest airspeed. Both `calibrate` and `reconcile` have 15
# for reading what a gauge shows at rest, and `calibrate` 25 for the prior of the zero that it is.
# `reconcile` has 28 for the spectral lines that it looks for before it looks for causes, and 57 for
# sizes of the airplane's own, for steps in which a light propeller settles, and for two causes that
# no log without vanes separates, or gusts from a moment, and for what a line leaves.
ENTERED = {"fly": 1_165, "calibrate": 5_076, "reconcile": 5_999, "run_campaign.py": 4_767}
# Statements of the packages with a table that others extend: what they had and 3 % of it, and in
# `cli`, where a command is a file, 40 for one. A maneuver is 30, a reader 10, an effect 1 to 10. The
# logbook has the 120 besides by which it finds logs of one flight, and 200 for kinds of files, for
# facts that somebody states, and for the arcs between fixes; further the 58 of the handbook's table,
# which pressure_error gave it, 25 by which it names what a file is, 38 for spreadsheets, and 15 for
# what a table holds that is none of a flight, and for one draft a reading, and 10 by which a written
# log keeps what its gauge showed at rest. The simulation has 4
# besides by which a patched airplane names the one before the patch, and 10 by which an airplane tells
# its mass, wing and chord.
ROOM = {
    "cli": 726,
    "effects": 973,
    "logbook": 3_547,
    "pressure_error": 228,
    "sensing": 229,
    "simulation": 2_443,
}


def test_a_job_enters_no_more_statements_than_its_limit(tmp_path: Path) -> None:
    """The campaigns' files in the digest are among those that a campaign enters. The README's case
    without its effect ends as the README says.
    """
    reached = reach_of_jobs(tmp_path)
    *_, quiet = readme_blocks()
    assert quiet.strip() in reached["reconcile"].said.splitlines()
    assert reached.keys() == ENTERED.keys()
    told = {job: each.statements for job, each in reached.items()}
    assert {job: entered for job, entered in told.items() if entered > ENTERED[job]} == {}
    assert min(told.values()) > 500  # a profile that sees nothing keeps every limit
    assert set(_FLYING_CAMPAIGNS) <= set(reached["run_campaign.py"].files)


@pytest.mark.parametrize("package", ROOM)
def test_a_package_with_a_table_keeps_room_for_a_new_entry(package: str) -> None:
    assert statements_in(PRODUCT / package) <= ROOM[package]
