"""Rows at the end of the impact-pressure sensor's range do not reach what is learned from the other rows."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.reconciliation.equations import noise_of_log, noise_residuals
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out, mean_wind_of
from pitotbench.reconciliation.noise import autocovariance
from pitotbench.reconciliation.renewal import NO_EFFECTS

CHANNELS = ("airspeed_along", "airspeed_across")


@pytest.fixture(scope="module")
def pair(sensed) -> tuple[Layout, Layout]:
    """One flight on the instants below 146 kt, of 160: with a sensor that ends there, and one with more range."""
    logs = sensed(), sensed("saturation")
    plain, capped = (lay_out(log, None, AnalysisSetting(day_known=True), NO_EFFECTS) for log in logs)
    assert np.mean(~capped.measured) > 0.2
    same_instants = replace(plain.residuals, slack=capped.residuals.slack)
    return replace(plain, residuals=same_instants), capped


def test_the_rest_of_the_log_leaves_what_it_leaves_without_the_range(pair) -> None:
    """Error curve and wind come from the rest. From all rows, the curve would bend by 14 kt at the end."""
    plain, capped = (noise_residuals(layout) for layout in pair)
    for name in CHANNELS:
        i = pair[0].residuals.names.index(name)
        assert np.std(capped[:, i] - plain[:, i]) < np.std(plain[:, i]), name  # 6.5 times that from all rows


def test_the_wind_and_a_mean_product_are_those_of_the_rest(pair) -> None:
    plain, capped = pair
    same_rows = mean_wind_of(plain.track, capped.measured)
    np.testing.assert_allclose(mean_wind_of(capped.track, capped.measured), same_rows, atol=0.5)
    noise = np.random.default_rng(1).standard_normal((len(plain.grid), 1))
    unused = np.arange(len(noise)) % 40 < 20
    level = autocovariance(np.where(unused[:, None], 0.0, noise), plain.grid)[0, 0]
    assert level == pytest.approx(np.mean(noise[~unused] ** 2), rel=0.05)


def test_nothing_is_predicted_from_an_instant_that_is_not_used(pair) -> None:
    """What stood at the end of the range counted as the past of the next six seconds: a sea breeze was named."""
    layout = pair[1]
    random = np.random.default_rng(2)
    values = random.standard_normal(layout.residuals.values.shape)
    unused = ~layout.used[:, 0]
    assert 0 < unused.sum() < len(unused)
    noise = noise_of_log(layout)
    other = np.where(unused[:, None], 1e3 * random.standard_normal(values.shape), values)
    found = [noise.whiten(each, layout.grid, layout.residuals.slack)[~unused] for each in (values, other)]
    np.testing.assert_array_equal(found[0], found[1])
