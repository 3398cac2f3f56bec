"""A held-out log need not have the channels of the first one, and is not asked for events."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, fly, sense
from pitotbench.bench.null_flights import aircraft_model
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.naming import name_effects
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.renewal import at_sizes
from pitotbench.reconciliation.signatures import returns
from pitotbench.reconciliation.verdict import hold_out
from pitotbench.records.case import EffectSpec

LATE = Catalog("effect", {"gps_latency": EFFECTS["gps_latency"]})


@pytest.mark.parametrize("missing", [(), ("velocity_down", "altitude")])
def test_a_held_out_log_may_lack_channels(sensed, missing: tuple[str, ...]) -> None:
    """A log without the vertical velocity and the height ended with an error."""
    log = sensed("gps_latency", das="20/20")
    layout = lay_out(log, None, AnalysisSetting(), LATE)
    null = theoretical_distribution(layout)
    (naming,) = name_effects([layout], [null]).namings
    assert naming.chosen == ("gps_latency",)
    held = replace(log, **dict.fromkeys(missing))
    assert hold_out(held, None, null, naming, layout.setting).share > 0.9


@pytest.mark.parametrize("event", ["updraft", "sea_breeze_front"])
def test_an_event_does_not_return_in_another_flight(event: str) -> None:
    assert not returns(event)
    assert returns("gps_latency")


def test_a_held_out_log_is_closed_by_the_shape_that_was_fitted() -> None:
    """A narrow error of the static source: with the typical airspeed instead of the fitted one nothing closes."""
    bump = Catalog("effect", {"local_static_bump": EFFECTS["local_static_bump"]})
    hidden = EffectSpec("local_static_bump", {"coefficient": 0.05, "center_mps": 55.0, "width_mps": 4.0})
    logs = [
        sense(fly(Case(maneuver="rapid_decel", truth_seed=seed, sensor_seed=seed, effects=(hidden,))), "20/20")
        for seed in (33_001, 33_002)
    ]
    layout = lay_out(logs[0], None, AnalysisSetting(), bump)
    null = theoretical_distribution(layout)
    (naming,) = name_effects([layout], [null]).namings
    assert naming.chosen == ("local_static_bump",)
    shapes = naming.layout.signatures[naming.fit.columns[0]].shapes
    assert shapes["center_mps"] == pytest.approx(55.0, abs=3.0)
    assert hold_out(logs[1], None, null, naming, layout.setting).share > 0.9


def test_a_shape_that_a_flight_does_not_reach_has_no_signature(flight) -> None:
    """A polar that bends at a lift coefficient of 1.2: the column of the typical one, 0.4, stood in its place."""
    bend = Catalog("effect", {"polar_bend": EFFECTS["polar_bend"]})
    layout = lay_out(sense(flight, "20/20"), aircraft_model("navajo"), AnalysisSetting(), bend)
    shown = at_sizes(layout, {("polar_bend", "factor"): 0.1}, {"polar_bend": {"onset": 1.2}})
    (old,), (new,) = layout.signatures, shown.signatures
    assert np.any(old.column)
    assert np.abs(new.column).max() < 0.05 * np.abs(old.column).max()
    assert new.shapes == {"onset": 1.2}
