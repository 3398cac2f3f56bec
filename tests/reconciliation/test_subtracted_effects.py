"""A large effect on the sensors, taken out of a log, leaves the log of the same flight without it."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.bench.null_flights import aircraft_model
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import noise_of_log
from pitotbench.reconciliation.evidence import LogEvidence
from pitotbench.reconciliation.free_parameters import AnalysisSetting, fit_free_parameters
from pitotbench.reconciliation.layout import DAY, Layout, lay_out
from pitotbench.reconciliation.renewal import (
    NO_EFFECTS,
    Entries,
    with_effects,
    without_effects,
    without_sensor_effects,
)
from pitotbench.reconciliation.signatures import residual_change, signatures_of

FEW = Catalog(
    "effect", {name: EFFECTS[name] for name in ("pitot_lag", "recovery_deficit", "wind_drift", DAY)}
)


def test_effects_that_are_not_on_the_sensors_change_nothing(laid_out) -> None:
    layout = laid_out()
    assert without_sensor_effects(layout, {"belly_pod": {"drag_area_m2": 0.1}}) is layout
    assert without_sensor_effects(layout, {}) is layout


@pytest.mark.parametrize("name", ["recovery_deficit", "pitot_lag"])
def test_what_is_left_is_the_flight_without_the_effect(laid_out, name: str) -> None:
    """The residuals differ from those of the same flight without the effect by a part of the
    change.
    """
    plain, log = laid_out(), laid_out(name)
    entries: Entries = {name: EFFECTS[name].typical()}
    left = without_effects(log, entries)
    change, missed = (_differences(each, plain) for each in (log, left))
    moved = {n for n in plain.residuals.names if change[n] > 0.3}
    assert len(moved) > 3
    for channel in moved:
        assert missed[channel] < 0.35 * change[channel], channel


def test_the_answer_is_exact_where_a_propeller_meets_its_stop(laid_out) -> None:
    """There the answer of the model has no slope; to first order a third of the change was missed
    at the best.
    """
    name = "recovery_deficit"
    plain, log = laid_out(), laid_out(name)
    left = without_effects(log, {name: EFFECTS[name].typical()})
    place = plain.residuals.places["propeller_speed_left"]
    before, after = (
        np.abs(each.residuals.values - plain.residuals.values)[:, place].max()
        for each in (log, left)
    )
    assert before > 0.3  # rad/s, where it meets its stop
    assert after < 0.15 * before


def test_an_effect_in_the_model_stays_there_as_another_one_is_taken_out(laid_out) -> None:
    """A later look takes a further large effect out of the log; what is in the model must not come
    back.

    What that itself changes, because the further effect is not linear, is seen on a flight without
    the first one.
    """
    name = "pitot_lag"
    entries: Entries = {"recovery_deficit": EFFECTS["recovery_deficit"].typical()}
    alone, log = laid_out("recovery_deficit"), laid_out(name, "recovery_deficit")
    left = without_effects(log, {name: EFFECTS[name].typical()})
    again, bent = without_sensor_effects(left, entries), without_sensor_effects(alone, entries)
    change = _differences(left, log)
    own = bent.residuals.values - alone.residuals.values
    returned = _differences(
        again, replace(left, residuals=replace(left.residuals, values=left.residuals.values + own))
    )
    moved = [n for n in log.residuals.names if change[n] > 0.3]
    assert moved
    for channel in moved:
        assert returned[channel] < 0.35 * change[channel], channel


def test_an_unknown_day_stays_unknown_as_an_effect_is_taken_out(sensed) -> None:
    layout = lay_out(
        sensed(das="20/20"), aircraft_model("navajo"), AnalysisSetting(day_known=False), FEW
    )
    again = without_sensor_effects(layout, {"pitot_lag": EFFECTS["pitot_lag"].typical()})
    assert any(name.startswith(DAY) for name in layout.free.names)
    assert again.free.names == layout.free.names


def test_an_effect_in_the_model_keeps_its_form_error(laid_out) -> None:
    """A lag that grows over the flight is left by a plain one in the model: it is no further gap."""
    log = laid_out("pitot_lag")
    column = next(s.column for s in log.signatures if s.effect == "pitot_lag")
    size = EFFECTS["pitot_lag"].typical()["lag_s"]
    grown = 0.1 * size * column * np.linspace(-1.0, 1.0, len(column))[:, None]
    plain = replace(log, residuals=replace(log.residuals, values=grown), in_model={})
    known = replace(plain, in_model={("pitot_lag", "lag_s"): size})
    noise = noise_of_log(log)
    left = [LogEvidence(each, noise, {}).base.inner[-1, -1] for each in (plain, known)]
    assert left[1] < 0.3 * left[0]


@pytest.mark.parametrize(
    "name",
    [
        "mass",
        "center_of_gravity",
        "propeller_efficiency",
        "governor_speed",
        "power_deficit",
        "flap_not_up",
    ],
)
def test_an_effect_in_the_model_is_still_judged_by_its_whole_change(
    short: Layout, name: str
) -> None:
    """On top of a quarter of the size, a size changes what it changes from a quarter to five
    quarters.
    """
    scene, effect = short.scene, EFFECTS[name]
    quarter = {key: 0.25 * size for key, size in effect.typical().items()}
    patched = with_effects(short, aircraft_model("navajo"), {name: quarter})
    again = signatures_of(patched.scene, Catalog("effect", {name: effect}))
    assert [s.parameter for s in again] == [p.name for p in effect.parameters]
    for one in again:
        more, less = (
            residual_change(effect, scene, {**quarter, one.parameter: k * one.size})
            for k in (1.25, 0.25)
        )
        missed = more - less - one.size * one.column
        assert np.sum(missed**2) < 0.02**2 * np.sum((more - less) ** 2)


@pytest.fixture(scope="module")
def short(sensed) -> Layout:
    """A minute and a half of a flight, with the deceleration."""
    log = sensed(das="20/20")
    part = log.select(log.time - log.time[0] < 90.0)
    return lay_out(part, aircraft_model("navajo"), AnalysisSetting(day_known=True), NO_EFFECTS)


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
    """The difference of two logs by channel, without what free parameters take up, in units of the
    noise of one.
    """
    values = layout.residuals.values - other.residuals.values
    usable = layout.residuals.slack < 1.0
    fitted = fit_free_parameters(values, layout.free, usable).residuals
    noise = np.std(np.diff(other.residuals.values, axis=0), axis=0)
    size = np.sqrt(np.mean(np.where(usable, fitted, 0.0) ** 2, axis=0)) / noise
    return dict(zip(layout.residuals.names, size.tolist(), strict=True))
