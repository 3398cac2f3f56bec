"""A case's effects: refused with one clear error, or taken."""

import pytest

from pitotbench.catalog import UnknownNameError
from pitotbench.effects import chosen
from pitotbench.records import BadInputError
from pitotbench.records.case import EffectSpec

BAD = {
    "unknown parameter": ({"lag_ms": 300.0, "lag_s": 0.3}, r"pitot_lag: unknown parameter 'lag_ms'.*lag_s"),
    "missing": ({}, r"pitot_lag: lag_s is missing \(typically 0.4"),
    "too large": ({"lag_s": 50.0}, r"pitot_lag: lag_s = 50 is not within 0.01 to 3"),
    "wrong sign": ({"lag_s": -0.2}, r"lag_s = -0.2 is not within"),
    "not a number": ({"lag_s": float("nan")}, r"lag_s = nan is not within"),
}


@pytest.mark.parametrize("what", BAD)
def test_each_problem_is_named(what):
    parameters, message = BAD[what]
    with pytest.raises(BadInputError, match=message):
        chosen([EffectSpec("pitot_lag", parameters)])


def test_all_problems_at_once():
    with pytest.raises(BadInputError, match=r"pitot_lag: lag_s is missing.*belly_pod: drag_area_m2 = 9"):
        chosen([EffectSpec("pitot_lag"), EffectSpec("belly_pod", {"drag_area_m2": 9.0})])


def test_an_unknown_effect_names_the_nearest():
    with pytest.raises(UnknownNameError, match="Did you mean 'pitot_lag'"):
        chosen([EffectSpec("pitot_lagg", {"lag_s": 0.3})])


def test_one_effect_twice_is_refused():
    with pytest.raises(BadInputError, match="pitot_lag: named 2 times"):
        chosen([EffectSpec("pitot_lag", {"lag_s": 0.3}), EffectSpec("pitot_lag", {"lag_s": 0.2})])


def test_shapes_may_be_left_out_and_zero_is_none():
    (choice,) = chosen([EffectSpec("second_order_line", {"lag_s": 0.3}), EffectSpec("pitot_lag", {"lag_s": 0.0})])
    assert choice.effect.complete(choice.sizes) == {"lag_s": 0.3, "damping": 0.6}
