"""Real logs: nobody hid anything, so the report must say what it sees and how sure it is."""

from tests.shared_data import real_log

from pitotbench.bench.calibrations import setting_of
from pitotbench.bench.workflow import NamedLog, reconcile_fully
from pitotbench.logbook.reading import read_log
from pitotbench.show.gap_words import sentences
from pitotbench.show.verdict_tree import account_page

ADVICE = {"error_location": "static", "mach_max": 0.93}  # of the mapping jmoss


def test_a_measured_log_without_an_aircraft_has_a_remark_on_its_recorder_and_no_missing_effect():
    """Its pressures come every 0.3 s: that is a recorder, and no fault that a model lacks."""
    path = real_log("jmoss", "CLASS55.csv")
    log = read_log(path, "jmoss")
    account = reconcile_fully(NamedLog(path.name, log), "none", setting=setting_of(ADVICE)).account
    verdict = account.verdict
    assert account.null_flights == 0
    assert verdict.kind == "no_gap"
    assert any(c.status == "remark" and "0.3 s" in c.why for c in verdict.checks)
    assert any("no aircraft model" in note for note in verdict.notes)
    assert "no aircraft model" in account.flown.skipped
    told = " ".join(sentences(account))
    assert "The sensors agree with one another" in told
    page = account_page(account)
    assert "Skipped" in page
