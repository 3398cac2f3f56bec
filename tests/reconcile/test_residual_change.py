"""How an effect changes the residuals follows from its class."""

import pytest

from pitotbench.effects import EFFECTS, Effect
from pitotbench.reconcile.signatures.signatures import residual_change


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_of_the_table_acts_on_a_scene(name: str) -> None:
    assert residual_change.dispatch(type(EFFECTS[name])) is not residual_change.dispatch(Effect)
