"""A large effect on the sensors, taken out of a log, leaves the log of the same flight without it."""

import numpy as np
import pytest

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting, fit_free_parameters
from pitotbench.reconciliation.layout import DAY, Layout, lay_out
from pitotbench.reconciliation.renewal import (
    Entries,
    with_corrected_track,
    without_sensor_effects,
)

FEW = Catalog(
    "effect", {name: EFFECTS[name] for name in ("pitot_lag", "recovery_deficit", "wind_drift", DAY)}
)


def test_effects_that_are_not_on_the_sensors_change_nothing(laid_out) -> None:
    layout = laid_out()
    assert without_sensor_effects(layout, {"belly_pod": {"drag_area_m2": 0.1}}) is layout
    assert without_sensor_effects(layout, {}) is layout


@pytest.mark.parametrize("name", ["recovery_deficit", "pitot_lag"])
def test_what_is_left_is_the_flight_without_the_effect(laid_out, name: str) -> None:
    """The residuals differ from those of a flight without it by a part of the change."""
    plain, log = laid_out(), laid_out(name)
    entries: Entries = {name: EFFECTS[name].typical()}
    left = with_corrected_track(log, entries)
    change, missed = (_differences(each, plain) for each in (log, left))
    moved = {n for n in plain.residuals.names if change[n] > 0.3}
    assert len(moved) > 3
    for channel in moved:
        assert missed[channel] < 0.35 * change[channel], channel


def test_the_answer_is_exact_where_a_propeller_meets_its_stop(laid_out) -> None:
    """There the model has no slope; to first order a third of the change was missed."""
    name = "recovery_deficit"
    plain, log = laid_out(), laid_out(name)
    left = with_corrected_track(log, {name: EFFECTS[name].typical()})
    place = plain.residuals.places["propeller_speed_left"]
    before, after = (
        np.abs(each.residuals.values - plain.residuals.values)[:, place].max()
        for each in (log, left)
    )
    assert before > 0.3  # rad/s, where it meets its stop
    assert after < 0.15 * before


def test_an_unknown_day_stays_unknown_as_an_effect_is_taken_out(sensed) -> None:
    layout = lay_out(
        sensed(das="20/20"), aircraft_model("navajo"), AnalysisSetting(day_known=False), FEW
    )
    again = without_sensor_effects(layout, {"pitot_lag": EFFECTS["pitot_lag"].typical()})
    assert any(name.startswith(DAY) for name in layout.free.names)
    assert again.free.names == layout.free.names


@pytest.fixture(scope="module")
def laid_out(sensed):
    kept: dict[tuple[str, ...], Layout] = {}

    def layout(*names: str) -> Layout:
        if names not in kept:
            log = sensed(*names, das="50/50")
            kept[names] = lay_out(
                log, aircraft_model("navajo"), AnalysisSetting(day_known=True), FEW
            )
        return kept[names]

    return layout


def _differences(layout: Layout, other: Layout) -> dict[str, float]:
    """The difference of two logs by channel, less the free parameters, in units of noise."""
    values = layout.residuals.values - other.residuals.values
    usable = layout.residuals.slack < 1.0
    fitted = fit_free_parameters(values, layout.free, usable).residuals
    noise = np.std(np.diff(other.residuals.values, axis=0), axis=0)
    size = np.sqrt(np.mean(np.where(usable, fitted, 0.0) ** 2, axis=0)) / noise
    return dict(zip(layout.residuals.names, size.tolist(), strict=True))
