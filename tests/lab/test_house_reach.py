"""What a job makes somebody read who changes it, by a profiler, and what carries its tables."""

from pathlib import Path

import pytest
from tests.test_pages_run import readme_blocks

from pitotbench.campaigns.digests import _FLYING_CAMPAIGNS
from pitotlab.house import PRODUCT, reach_of_jobs, statements_in

# Statements of the functions that a job enters, on a circle at 20/1 in light turbulence. Somebody who
# changes what a job answers has to know them all, so what needs more takes something out. The goals
# are 4,000 for `calibrate` and 4,900 for `reconcile`: what the jobs entered before a probe, a zero and
# a log's own lines became unknowns, and before sizes grew with the airplane.
ENTERED = {"fly": 1_165, "calibrate": 5_076, "reconcile": 5_999, "run_campaign.py": 4_767}
# The pages of a package with the entries of its table, which anybody may extend, and the statements
# of what stands beside them. That carries every entry, and does not grow with their number: each
# limit is what it has and 2 %, so that a mended fault fits.
READERS = (
    "bundle csv dataflash displays handbook_table hdf5 matlab other_kinds parquet recorder_files"
    " spreadsheet ulog"
)
CARRIED = {
    "effects": ("air airframe pneumatic propulsion recorder stability", 600),
    "logbook": (READERS, 2_910),
    "pressure_error": ("models", 80),
    "sensing": ("sampling", 152),
    "simulation": ("maneuvers", 2_230),
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


@pytest.mark.parametrize("package", CARRIED)
def test_what_carries_the_entries_of_a_table_does_not_grow(package: str) -> None:
    pages, limit = CARRIED[package]
    own = [page for page in (PRODUCT / package).iterdir() if page.stem in pages.split()]
    assert len(own) == len(pages.split())
    assert statements_in(PRODUCT / package) - sum(map(statements_in, own)) <= limit
