"""Cards: a case overrides their numbers in the units it writes."""

import pytest

from pitotbench import BadInputError, UnknownNameError
from pitotbench.simulation.card import override
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.units import DEGREE, INCH_OF_MERCURY, KNOT

CARD = MANEUVERS["step_decrease"].card


def test_numbers_come_in_written_units_and_are_held_in_si():
    changed = override(CARD, {"dwell_s": 20, "speeds_kt": [150.0, 110], "step_inhg": 2, "bank_limit_deg": 20.0})
    assert changed.dwell == 20.0
    assert changed.speeds == pytest.approx((150 * KNOT, 110 * KNOT))
    assert changed.step == pytest.approx(2 * INCH_OF_MERCURY)
    assert changed.bank_limit == pytest.approx(20 * DEGREE)
    assert CARD.dwell != 20.0
    # Another unit of the same dimension is taken.
    assert override(CARD, {"dwell_ms": 5000.0}).dwell == 5.0
    assert override(CARD, {"speeds_mps": [70.0, 60.0]}).speeds == (70.0, 60.0)
    assert override(MANEUVERS["rapid_decel"].card, {"repeats": 3}).repeats == 3


@pytest.mark.parametrize("key", ["dwel_s", "dwell", "dwell_kt", "speed_kt", "heading_"])
def test_a_wrong_key_names_the_known_ones(key):
    with pytest.raises(UnknownNameError, match=r"Known: speeds_kt, turn_rate_degps.*dwell_s"):
        override(CARD, {key: 1.0})


@pytest.mark.parametrize("speeds", [160.0, [], "160", [160.0, -1.0], [100.0, 160.0], [160.0]])
def test_speeds_of_the_wrong_shape_are_refused(speeds):
    with pytest.raises(BadInputError):
        override(CARD, {"speeds_kt": speeds})


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *(("dwell_s", value) for value in ([1.0], "20", True, float("nan"))),
        *(("turn_rate_degps", 0.0), ("settle_s", -1.0), ("step_inhg", 0.0)),
    ],
)
def test_a_value_of_the_wrong_kind_is_refused(key, value):
    with pytest.raises(BadInputError):
        override(CARD, {key: value})
    with pytest.raises(BadInputError, match="whole"):
        override(MANEUVERS["rapid_decel"].card, {"repeats": 1.5})


@pytest.mark.parametrize("name", MANEUVERS)
def test_every_number_of_every_card_has_a_known_suffix(name):
    override(MANEUVERS[name].card, {"speeds_kt": [150.0, 130.0, 120.0]})
