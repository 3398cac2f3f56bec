"""How an effect changes the residuals, and that rows beyond a sensor's range do not reach what
others teach.
"""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import Effect
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.equations import noise_of_log, noise_residuals
from pitotbench.reconciliation.free_parameters import (
    AnalysisSetting,
)
from pitotbench.reconciliation.layout import Layout, lay_out, mean_wind_of
from pitotbench.reconciliation.noise import autocovariance
from pitotbench.reconciliation.replay import REACTION_NAMES
from pitotbench.reconciliation.residuals import change_by_answer, channel_residuals
from pitotbench.reconciliation.signatures import residual_change

NO_EFFECTS = Catalog("effect", {})


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_of_the_table_acts_on_a_scene(name: str) -> None:
    assert residual_change.dispatch(type(EFFECTS[name])) is not residual_change.dispatch(Effect)


@pytest.fixture(scope="module")
def laid_out(sensed) -> Layout:
    log = sensed(das="50/50")
    part = log.select((log.time > log.time[0] + 20.0) & (log.time < log.time[0] + 60.0))
    return lay_out(part, aircraft_model("navajo"), AnalysisSetting(), Catalog("effect", {}))


def test_what_a_change_of_a_track_does_not_move_is_taken_over(laid_out: Layout) -> None:
    """Each channel of the log is moved alone: the residuals are those that are computed without any
    knowledge.
    """
    reference = laid_out.reference
    moved = 0
    for name, values in reference.clean.channels.items():
        track = reference.clean.replaced({name: values * 1.001 + 1e-4})
        anew = channel_residuals(track, reference.grid, reference.frame, reference.replay)
        known = reference.residuals_of(track)
        assert known.names == anew.names
        assert np.array_equal(known.values, anew.values), name
        moved += bool(np.any(known.values != reference.base.values))
    assert moved > 20


def test_change_by_an_answer_is_that_of_another_answer(laid_out: Layout) -> None:
    reference, replay = laid_out.reference, laid_out.reference.replay
    added = np.random.default_rng(3).normal(size=(len(replay.rows), len(REACTION_NAMES)))
    other = replace(replay, values=replay.values + added)
    expected = (
        channel_residuals(reference.clean, reference.grid, reference.frame, other).values
        - reference.base.values
    )
    change = change_by_answer(
        reference.base.names, reference.clean, reference.grid, replay.rows, added
    )
    scale = np.abs(replay.values).max(axis=0).max()
    assert np.abs(expected).max() > 0.1
    assert np.allclose(change, expected, rtol=0.0, atol=1e-12 * scale)


CHANNELS = ("airspeed_along", "airspeed_across")


@pytest.fixture(scope="module")
def pair(sensed) -> tuple[Layout, Layout]:
    """One flight on the instants below 146 kt, of 160: with a sensor that ends there, and one with
    more range.
    """
    logs = sensed(), sensed("saturation")
    plain, capped = (
        lay_out(log, None, AnalysisSetting(day_known=True), NO_EFFECTS) for log in logs
    )
    assert np.mean(~capped.measured) > 0.2
    same_instants = replace(plain.residuals, slack=capped.residuals.slack)
    return replace(plain, residuals=same_instants), capped


def test_the_rest_of_the_log_leaves_what_it_leaves_without_the_range(pair) -> None:
    """Error curve and wind come from the rest. From all rows, the curve would bend by 14 kt at the
    end.
    """
    plain, capped = (noise_residuals(layout) for layout in pair)
    for name in CHANNELS:
        i = pair[0].residuals.names.index(name)
        assert np.std(capped[:, i] - plain[:, i]) < np.std(plain[:, i]), (
            name
        )  # 6.5 times that from all rows


def test_the_wind_and_a_mean_product_are_those_of_the_rest(pair) -> None:
    plain, capped = pair
    same_rows = mean_wind_of(plain.track, capped.measured)
    np.testing.assert_allclose(mean_wind_of(capped.track, capped.measured), same_rows, atol=0.5)
    noise = np.random.default_rng(1).standard_normal((len(plain.grid), 1))
    unused = np.arange(len(noise)) % 40 < 20
    level = autocovariance(np.where(unused[:, None], 0.0, noise), plain.grid)[0, 0]
    assert level == pytest.approx(np.mean(noise[~unused] ** 2), rel=0.05)


def test_nothing_is_predicted_from_an_instant_that_is_not_used(pair) -> None:
    """What stood at the end of the range counted as the past of the next six seconds: a sea breeze
    was named.
    """
    layout = pair[1]
    random = np.random.default_rng(2)
    values = random.standard_normal(layout.residuals.values.shape)
    unused = ~layout.used[:, 0]
    assert 0 < unused.sum() < len(unused)
    noise = noise_of_log(layout)
    other = np.where(unused[:, None], 1e3 * random.standard_normal(values.shape), values)
    found = [
        noise.whiten(each, layout.grid, layout.residuals.slack)[~unused] for each in (values, other)
    ]
    np.testing.assert_array_equal(found[0], found[1])
