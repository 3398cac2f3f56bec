"""Real logs: nobody hid anything, so the report must say what it sees and how sure it is."""

from tests.shared_data import real_log

from pitotbench.bench.rounds import NamedLog
from pitotbench.bench.workflow import reconcile_fully
from pitotbench.cli.reconcile import _setting
from pitotbench.logbook.reading import read_log
from pitotbench.show.gap_page import account_page
from pitotbench.show.gap_words import sentences

ADVICE = {"error_location": "static", "mach_max": 0.93}  # of the mapping jmoss


def test_a_measured_log_without_an_aircraft_is_judged_with_its_doubt():
    path = real_log("jmoss", "CLASS55.csv")
    log = read_log(path, "jmoss")
    account = reconcile_fully(NamedLog(path.name, log), "none", setting=_setting(ADVICE)).account
    verdict = account.rounds[0].verdict
    late = {c.name: c for c in verdict.candidates}
    print(verdict.kind, [(c.name, c.score, [(s.value, s.two_sigma) for s in c.sizes]) for c in late.values()])
    assert account.null_flights == 0
    assert verdict.kind in ("unknown", "one_of", "named")  # something is there; which is told with its doubt
    assert any("no aircraft model" in note for note in verdict.notes)
    assert "no aircraft model" in account.flown.skipped
    told = " ".join(sentences(account))
    assert ("believe" in told) or ("no effect of the table" in told)
    page = account_page(account)
    assert "Skipped" in page
