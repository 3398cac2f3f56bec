"""Judged by null flights, a fresh flight shows no gap; one whose altitude swings does, whatever it
follows.
"""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Flight, FlightLog, Verdict
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.null_distribution import NullDistribution, theoretical_distribution
from pitotbench.reconciliation.null_learning import (
    learn_null_distribution,
    wandering_channels,
)
from pitotbench.reconciliation.verdict import judge
from pitotbench.records.case import EffectSpec
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system

SETTING = AnalysisSetting(day_known=True)
OF_THE_HEIGHT = {"pressure_height", "climb_rate"}  # channels that hold the altitude of GPS


def sensed_anew(flight: Flight, seed: int) -> FlightLog:
    return record(flight, data_system("20/20"), seed)


def judge_one(layout: Layout, null: NullDistribution) -> Verdict:
    return judge(["flight"], [layout], [null]).verdict


@pytest.fixture(scope="module")
def null(flight: Flight) -> NullDistribution:
    return learn_null_distribution(
        [lay_out(sensed_anew(flight, seed), None, SETTING) for seed in range(101, 106)]
    )


def test_a_fresh_flight_shows_no_gap(flight: Flight, null: NullDistribution) -> None:
    verdict = judge_one(lay_out(sensed_anew(flight, 120), None, SETTING), null)
    assert verdict.kind == "no_gap"


def test_an_altitude_that_swings_is_a_gap_of_unknown_cause(
    flight: Flight, null: NullDistribution
) -> None:
    log = sensed_anew(flight, 121)
    swinging = replace(log, altitude=log.altitude + 3.0 * np.sin(2.0 * np.pi * log.time / 20.0))
    verdict = judge_one(lay_out(swinging, None, SETTING), null)
    assert verdict.kind == "unknown"
    assert verdict.located[0].channel in OF_THE_HEIGHT


def test_spikes_are_no_wander(flight: Flight, null: NullDistribution) -> None:
    """As a busy hand on the throttle makes them in what the engines tell, here in the height."""
    log = sensed_anew(flight, 124)
    spikes = np.where(np.random.default_rng(1).random(len(log)) < 0.003, 120.0, 0.0)
    before = lay_out(log, None, SETTING)
    moved = lay_out(replace(log, altitude=log.altitude + spikes), None, SETTING)
    lasting = np.where(log.time % 5.0 < 1.0, 30.0, 0.0)
    wandering = lay_out(replace(log, altitude=log.altitude + lasting), None, SETTING)
    assert wandering_channels(moved, before, null, 0.0) == ()
    found = wandering_channels(wandering, before, null, 0.0)
    assert {each.channel for each in found} == OF_THE_HEIGHT


def test_a_small_swing_is_found_by_its_period(flight: Flight, null: NullDistribution) -> None:
    """One that adds little to the sum of squares and follows nothing that is looked at."""
    log = sensed_anew(flight, 122)
    swing = 1.0 + 0.02 * np.sin(2.0 * np.pi * log.time / 23.0)
    verdict = judge_one(
        lay_out(replace(log, impact_pressure=log.impact_pressure * swing), None, SETTING), null
    )
    assert verdict.kind == "unknown"
    assert verdict.located[0].variable in (
        "a period of 23 s",
        "a period of 22 s",
        "a period of 24 s",
    )


def test_an_unknown_of_the_log_is_told_where_null_flights_do_not_show_it(
    flight: Flight, null: NullDistribution
) -> None:
    """A vane that stands 6° off, where no effect of the table can tell it."""
    log, few = sensed_anew(flight, 120), Catalog("effect", {"pitot_lag": EFFECTS["pitot_lag"]})
    good = lay_out(log, None, SETTING, few)
    usual = replace(theoretical_distribution(good), flights=8)
    assert not judge_one(good, usual).free
    layout = lay_out(replace(log, sideslip=log.sideslip + np.radians(6.0)), None, SETTING, few)
    told = {each.name: each for each in judge_one(layout, usual).free}
    assert told["sideslip bias"].value == pytest.approx(np.radians(6.0), rel=0.3)
    wide = replace(usual.scores, free=dict.fromkeys(told, 30.0))
    assert not judge_one(layout, replace(usual, scores=wide)).free
    # Vanes read gusts: their scales are farther from 1 on null flights than a workshop leaves them.
    assert null.scores.free["sideslip scale"] > 1.1


def with_curve(flight: Flight, times: float) -> FlightLog:
    usual = flight.case.pressure_error
    other = replace(usual, parameters=tuple(times * p for p in usual.parameters))
    return sensed_anew(replace(flight, case=replace(flight.case, pressure_error=other)), 123)


def test_an_error_curve_is_taken_out_before_forces_are_judged(
    flight: Flight, null: NullDistribution
) -> None:
    """It is unknown in every log; half as much again as usual would pass for drag."""
    log, true = with_curve(flight, 1.5), with_curve(flight, 0.0).impact_pressure
    layout = lay_out(log, None, SETTING)
    left, before = (
        np.std(q / true - 1.0) for q in (layout.track["impact_pressure"], log.impact_pressure)
    )
    assert np.mean(layout.track["impact_pressure"] / true - 1.0) == pytest.approx(0.0, abs=0.003)
    assert left < 0.2 * before
    assert judge_one(layout, null).kind == "no_gap"


def test_a_late_velocity_is_named_though_the_gusts_in_it_are_late_as_well(
    flight: Flight, null: NullDistribution
) -> None:
    late = (EffectSpec("gps_latency", {"latency_s": 0.3}),)
    log = sensed_anew(replace(flight, case=replace(flight.case, effects=late)), 124)
    verdict = judge_one(lay_out(log, None, SETTING), null)
    assert verdict.kind in ("named", "one_of")
    assert verdict.effects[0].name == "gps_latency"
