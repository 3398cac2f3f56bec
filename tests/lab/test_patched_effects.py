"""An effect that is patched into an airplane is in it once: what was a gap is none any more, and a
size that a later judgment finds adds to the one that is there.
"""

import numpy as np
import pytest

from pitotbench import Case, fly, sense
from pitotbench.bench.closing import _is_lasting
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import Sizes
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.replay import motion_of
from pitotbench.reconciliation.signatures import residual_change
from pitotbench.records.case import EffectSpec
from pitotbench.simulation.modified import install_variant

PATCHED = [name for name in EFFECTS if _is_lasting(name)]
SHAPES = {"polar_bend": {"onset": 0.2}}  # the card does not reach the usual one
NEAR = 0.03  # of a size: a column is computed once a second, the airplane ten times


@pytest.fixture(scope="module")
def reference():
    """The state of a log without an effect, in gusts, with a sideslip and a turn."""
    flown = fly(Case(maneuver="diagnostic", turbulence="light", truth_seed=31))
    log = sense(flown, "20/5")
    time = log.time - log.time[0]
    part = log.select((time > 140.0) & (time < 230.0))
    none = Catalog("effect", {})
    return lay_out(part, aircraft_model("navajo"), AnalysisSetting(), none).reference


def test_the_loop_can_write_these_effects():
    assert len(PATCHED) == 28


@pytest.mark.parametrize("name", PATCHED)
def test_a_patch_takes_its_effect_off_the_log_once(name, reference, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    effect = EFFECTS[name]
    typical = {p.name: p.typical for p in effect.parameters if not p.shape}
    sizes = effect.complete(typical | SHAPES.get(name, {}))
    install_variant("navajo", "patched", [EffectSpec(name, dict(sizes))])
    model, clean = reference.force_model, reference.clean
    motion = motion_of(clean, model.replay.rows)
    flown = [
        reference.moved(clean, model.along(motion, aircraft_model(each)))
        for each in ("navajo", "navajo+patched")
    ]
    off = flown[0].base.values - flown[1].base.values
    column = residual_change(effect, flown[0], sizes)
    half = {p.name: 0.5 * sizes[p.name] for p in effect.parameters if not p.shape}
    again = residual_change(effect, flown[1], {**sizes, **half})
    grown = residual_change(effect, flown[0], {**sizes, **_grown(name, sizes, half)}) - column
    column, again, grown, off = (
        each / np.std(reference.base.values, axis=0) for each in (column, again, grown, off)
    )
    left = 1.0 - np.sum(column * off) / np.sum(column**2)
    assert left == pytest.approx(0.0, abs=NEAR)
    assert np.sum(grown * again) / np.sum(grown**2) == pytest.approx(1.0, abs=NEAR)


def _grown(name: str, sizes: Sizes, more: Sizes) -> Sizes:
    """The sizes that an airplane with some `sizes` has when `more` is patched into it: the sum, but
    a lift curve that is scaled is scaled again, with the constant that was added to it.
    """
    grown = {key: sizes[key] + more[key] for key in more}
    if name == "lift_slope":
        both = sizes["change"] * more["change"], sizes["zero_coefficient"] * more["change"]
        grown["change"] += both[0]
        grown["zero_coefficient"] += both[1]
    return grown
