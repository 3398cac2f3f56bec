"""A held-out log need not have the channels of the first one, and is not asked for events."""

from dataclasses import replace

import pytest

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconcile.decide.judgment import hold_out
from pitotbench.reconcile.decide.naming import name_effects
from pitotbench.reconcile.null_flights.null_distribution import theoretical_distribution
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import lay_out
from pitotbench.reconcile.residuals.layout_noise import noise_of_log
from pitotbench.reconcile.signatures.hypotheses import returns

LATE = Catalog("effect", {"gps_latency": EFFECTS["gps_latency"]})


@pytest.mark.parametrize("missing", [(), ("velocity_down", "altitude")])
def test_a_held_out_log_may_lack_channels(sensed, missing: tuple[str, ...]) -> None:
    """A log without the vertical velocity and the height ended with an error."""
    log = sensed("gps_latency", das="50/50")
    layout = lay_out(log, None, AnalysisSetting(), LATE)
    null = theoretical_distribution(noise_of_log(layout))
    naming = name_effects(layout, null)
    assert naming.chosen == ("gps_latency",)
    held = replace(log, **dict.fromkeys(missing))
    assert hold_out(held, None, null, naming, layout.setting).share > 0.9


@pytest.mark.parametrize("event", ["updraft", "sea_breeze_front"])
def test_an_event_does_not_return_in_another_flight(event: str) -> None:
    assert not returns(event)
    assert returns("gps_latency")
