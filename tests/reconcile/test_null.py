"""What null flights teach: a fresh one shows no gap; one whose altitude swings does, whatever it follows."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.reconcile.judge import judge
from pitotbench.reconcile.nuisance import Setting
from pitotbench.reconcile.null import Knowledge, learn
from pitotbench.reconcile.study import study
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense import data_system, record

SETTING = Setting(day_known=True)


def sensed_anew(flight: Flight, seed: int) -> FlightLog:
    return record(flight, data_system("50/50"), seed)


@pytest.fixture(scope="module")
def known(flight: Flight) -> Knowledge:
    return learn([study(sensed_anew(flight, seed), None, SETTING) for seed in range(101, 106)])


def test_a_fresh_flight_shows_no_gap(flight: Flight, known: Knowledge) -> None:
    verdict, _ = judge(study(sensed_anew(flight, 120), None, SETTING), known)
    assert verdict.kind == "no_gap"


def test_an_altitude_that_swings_is_a_gap_of_unknown_cause(flight: Flight, known: Knowledge) -> None:
    log = sensed_anew(flight, 121)
    swinging = replace(log, altitude=log.altitude + 3.0 * np.sin(2.0 * np.pi * log.time / 20.0))
    verdict, _ = judge(study(swinging, None, SETTING), known)
    assert verdict.kind == "unknown"
    assert verdict.located[0].channel == "pressure_height"
