"""The files that a job enters, by a profiler: no more than a reader can hold."""

from pathlib import Path

from pitotbench.campaigns.digests import _FLYING_CAMPAIGNS
from pitotlab.house import reach_of_jobs

REACH = {"fly": 40, "calibrate": 63, "run_campaign.py": 78}  # files that a job enters


def test_jobs_enter_no_more_files_than_a_reader_can_hold(tmp_path: Path) -> None:
    """The campaigns' files in the digest are among those that a campaign enters."""
    reach = reach_of_jobs(tmp_path, reconcile=False)
    assert {job: files for job, files in reach.items() if len(files) > REACH[job]} == {}
    assert set(_FLYING_CAMPAIGNS) <= set(reach["run_campaign.py"])
