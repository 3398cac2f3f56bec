"""Recording faults are counted, not fitted; what is held in an outage of GPS or air data is no
measurement.
"""

from collections.abc import Collection
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from pitotbench import BadInputError, FlightLog
from pitotbench.catalog import Catalog
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.recording_checks import check_log
from pitotbench.reconciliation.track import AIR_CHANNELS, GPS_CHANNELS, track_of
from pitotbench.reconciliation.verdict import judge
from pitotbench.timeline import in_outage
from pitotbench.units import Booleans

NO_EFFECTS = Catalog("effect", {})

HELD = (60.0, 68.0)  # s after the start


def held(
    log: FlightLog, since: float, until: float, names: Collection[str] = GPS_CHANNELS
) -> FlightLog:
    """The log with some channels held at their last sample, as a recorder does when a receiver
    falls silent.
    """
    rows = _between(log, since, until)
    channels = {}
    for name, values in log.channels().items():
        if name in names:
            changed = values.copy()
            changed[rows] = values[np.flatnonzero(rows)[0] - 1]
            channels[name] = changed
    return replace(log, **channels, gps_fresh=None)


def _between(log: FlightLog, since: float, until: float) -> Booleans:
    time = log.time - log.time[0]
    return (time > since) & (time < until)


def test_rows_in_an_outage_are_those_of_a_loop_over_them() -> None:
    random = np.random.default_rng(4)
    time = 0.05 * np.arange(400)
    for share in (0.02, 0.1, 0.4, 0.9):
        fresh = random.random(400) < share
        fresh[120:160] = False
        fresh[0] = True
        new = [float(t) for t, one in zip(time, fresh, strict=True) if one]
        lengths = [after - before for before, after in pairwise([*new, float(time[-1])])]
        limit = max(2.5 * float(np.quantile(lengths, 0.95)), 0.5)
        expected = []
        for t, one in zip(time, fresh, strict=True):
            before = max(s for s in new if s <= t)
            after = min([s for s in new if s > t], default=float(time[-1]))
            expected.append(not one and after - before > limit)
        assert in_outage(time, fresh).tolist() == expected


def test_a_pause_of_the_recording_and_samples_lost_at_random_are_no_outage() -> None:
    """The rows that hold a fix before and after a pause were told as a failure of the GPS."""
    time = np.concatenate([0.05 * np.arange(1210), 90.0 + 0.05 * np.arange(1213)])
    fresh = np.round(time * 20.0).astype(int) % 20 == 7
    assert not in_outage(time, fresh).any()
    fresh = np.random.default_rng(8).random(1000) > 0.3
    for rate in (1.0, 4.0):
        assert in_outage(np.arange(1000) / rate, fresh).mean() < 0.02
    # A sensor that never renews is in outage throughout.
    fresh = np.array([True, False, False, False])
    assert in_outage(np.arange(4.0), fresh).tolist() == [False, True, True, True]


def test_a_coarse_velocity_that_repeats_itself_is_no_outage(sensed) -> None:
    log = replace(sensed(das="20/20"), gps_fresh=None)
    step = 0.5144  # 1 kt
    coarse = {
        n: step * np.round(getattr(log, n) / step) for n in ("velocity_north", "velocity_east")
    }
    coarse["velocity_down"] = 0.1 * np.round(log.velocity_down / 0.1)
    rounded = replace(log, **coarse)
    assert not in_outage(log.time, rounded.renewed_fixes()).any()
    assert len(track_of(rounded).time) == len(track_of(log).time)


def test_air_data_that_stand_still_are_told_and_not_used(sensed) -> None:
    log = held(sensed(das="20/20"), 60.0, 90.0, AIR_CHANNELS)
    checked = check_log(log)
    told = next(check for check in checked.checks if check.name == "repeated samples")
    assert (told.status, checked.effects) == ("failed", ())
    assert "stand still for 30" in told.why
    time = track_of(log, checked.fresh).time - log.time[0]
    assert not np.any((time > 60.1) & (time < 89.9))


def test_a_held_fix_is_not_used_and_names_nothing(sensed) -> None:
    """Eight seconds of held fixes, joined by a curve, once made two names with a Bayes factor of
    e^12,000.
    """
    log = held(sensed(das="20/20"), *HELD)
    track = track_of(log)
    time = track.time - log.time[0]
    assert not np.any((time > HELD[0] + 0.05) & (time < HELD[1] - 0.05))
    assert len(track.start) == 3
    told = next(check for check in check_log(log).checks if check.name == "GPS")
    assert told.status == "failed"
    assert "stand still for 7.9" in told.why or "stand still for 8.0" in told.why
    assert "from 60 s" in told.why
    layout = lay_out(log, None, AnalysisSetting())
    verdict = judge(["flight"], [layout], [theoretical_distribution(layout)]).verdict
    assert verdict.kind == "no_gap"


def test_a_log_with_an_outage_is_that_with_a_pause(sensed) -> None:
    log = sensed(das="20/20")
    cut = replace(log, gps_fresh=None).select(~_between(log, *HELD))
    layouts = [
        lay_out(each, None, AnalysisSetting(), NO_EFFECTS) for each in (held(log, *HELD), cut)
    ]
    np.testing.assert_allclose(*(each.residuals.values for each in layouts), atol=1e-9)


@pytest.mark.parametrize("seconds", [15.0, 30.0])
def test_a_piece_that_is_too_short_is_refused_with_the_length_that_would_do(
    sensed, seconds: float
) -> None:
    """It ended with an error of linear algebra, or with a name."""
    log = sensed(das="20/1")
    with pytest.raises(
        BadInputError, match=r"instants to compare, and 40 are needed: give at least 44 s"
    ):
        lay_out(log.select(log.time - log.time[0] < seconds), None, AnalysisSetting())
    long_enough = log.select(log.time - log.time[0] < 44.0)
    assert len(lay_out(long_enough, None, AnalysisSetting(), NO_EFFECTS).grid) >= 40
    # So is a log that is mostly an outage.
    with pytest.raises(BadInputError, match="no stretch of 10 s without a pause or an outage"):
        lay_out(held(log, 9.0, float(log.time[-1] - log.time[0]) - 9.0), None, AnalysisSetting())


TYPICAL = {
    "sample_and_hold": 0.25,
    "dropped_samples": 0.05,
    "quantization": 40.0,
    "saturation": 3500.0,
}


@pytest.mark.parametrize("das", ["20/1", "50/50"])
def test_a_sound_log_passes(sensed, das: str) -> None:
    found = check_log(sensed(das=das))
    assert found.effects == ()
    assert {c.status for c in found.checks} == {"passed"}
    if das == "20/1":  # where no column marks the fixes
        (gps,) = [
            c for c in check_log(replace(sensed(das=das), gps_fresh=None)).checks if c.name == "GPS"
        ]
        assert gps.why == "velocity is renewed every 1 s and interpolated between"


@pytest.mark.parametrize("name", TYPICAL)
def test_a_fault_is_named_with_its_size(sensed, name: str) -> None:
    log = sensed(name, das="50/50")
    found = check_log(log)
    assert [effect.name for effect in found.effects] == [name]
    size = found.effects[0].sizes[0]
    assert size.value == pytest.approx(TYPICAL[name], rel=0.15)
    assert any(c.status == "failed" for c in found.checks)
    if name in (
        "dropped_samples",
        "sample_and_hold",
    ):  # the chance that coarse pressures repeat hides no loss
        pressures = ("impact_pressure", "static_pressure")
        coarse = {each: np.round(getattr(log, each) / 2.0) * 2.0 for each in pressures}
        assert name in [effect.name for effect in check_log(replace(log, **coarse)).effects]


def held_pressures(log: FlightLog, rows: int, steps: float) -> FlightLog:
    """The log of a recorder whose pressures come every `rows` rows, and whose probe has steps of
    its own [K].
    """
    source = np.arange(len(log)) // rows * rows
    pressures = {
        name: getattr(log, name)[source] for name in ("impact_pressure", "static_pressure")
    }
    probe = np.round(log.total_temperature / steps) * steps
    return replace(log, **pressures, total_temperature=probe)


@pytest.mark.parametrize("steps", [0.05, 0.5])
def test_pressures_of_a_slower_bus_are_a_remark_and_no_lost_sample(sensed, steps: float) -> None:
    """Whole rows repeat where the probe happens to repeat as well: a jet's log lost a fifth of its
    rows so.
    """
    found = check_log(held_pressures(sensed(das="20/1"), 6, steps))
    assert found.effects == ()
    assert found.fresh.all()
    told = next(check for check in found.checks if check.name == "repeated samples")
    assert told.status == "remark"
    assert "renewed every 0.3 s" in told.why
