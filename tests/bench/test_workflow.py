"""One answer of a whole reconciliation: from Python, with a flight held out, its wind and warnings."""

from types import SimpleNamespace

import numpy as np
import pytest

from pitotbench import Case, fly, reconcile, sense
from pitotbench.bench.fly_again import wind_of_log
from pitotbench.bench.workflow import reported_warnings
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.case import EffectSpec
from pitotbench.records.log import Caution, FlightLog
from pitotbench.units import DEGREE, KNOT


def flight(seed: int) -> FlightLog:
    """A flight whose GPS is late."""
    case = Case(
        maneuver="rapid_decel",
        truth_seed=seed,
        effects=(EffectSpec("gps_latency", {"latency_s": 0.3}),),
    )
    return sense(fly(case), "20/20")


@pytest.fixture(scope="module")
def late() -> FlightLog:
    return flight(31)


def test_a_late_receiver_is_named_closes_another_flight_and_leaves_nothing(late):
    """Asked from Python, with another flight held out."""
    said: list[str] = []
    outcome = reconcile(
        late, aircraft="none", holdout=flight(32), refly=False, progress=said.append
    )
    verdict, account = outcome.verdict, outcome.account
    assert account.holdout
    (gap,) = verdict.gaps
    assert (verdict.kind, gap.part, gap.named) == ("named", "GPS receiver and its clock", True)
    assert gap.causes[0].sizes[0].value == pytest.approx(0.3, abs=0.05)
    assert gap.causes[0].probability == pytest.approx(THRESHOLDS.told_closed, abs=1e-3)
    assert gap.probability <= 1.0
    assert gap.closes_held_out > 0.9
    assert verdict.closure_holdout.share > 0.9
    assert not verdict.remains
    margin = THRESHOLDS.noise_without_null_flights
    tables = (account.gap_map.before, account.gap_map.after)
    largest = [margin * float(np.nanmax(np.abs(table))) for table in tables]
    # The largest of a hundred normal numbers is beyond 3.5 in one log of twenty.
    assert largest[1] < 3.5 < 5.0 < largest[0]
    assert account.waterfall[0].left == pytest.approx(verdict.closure.after)
    assert account.flown.skipped
    ((name, sizes),) = account.entries
    assert (name, sizes["latency_s"]) == ("gps_latency", pytest.approx(0.3, abs=0.05))


def test_the_wind_of_a_log_is_that_of_the_case(late):
    wind = wind_of_log(late)
    assert wind.speed / KNOT == pytest.approx(15.0, abs=1.5)
    assert wind.from_direction / DEGREE == pytest.approx(300.0, abs=6.0)


def test_a_warning_that_the_named_part_explains_is_withdrawn():
    turned, stuck = (
        Caution("the axes are turned by -7°", "axes turned"),
        Caution("stuck", "stuck", "heading_deg"),
    )
    log = SimpleNamespace(
        name="a.csv", log=SimpleNamespace(header={"warnings": [turned, stuck, "a text"]})
    )
    late, lag = (
        SimpleNamespace(named_parts=(part,))
        for part in ("GPS receiver and its clock", "pitot line")
    )
    assert reported_warnings([log], late) == ("stuck", "a text")
    assert reported_warnings([log], lag) == (turned, "stuck", "a text")
    assert reported_warnings([log, log], late)[0] == "a.csv: stuck"
