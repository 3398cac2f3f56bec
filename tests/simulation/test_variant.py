"""Aircraft variants on disk: they fly as the effects do, stack, and overwrite nothing."""

from pathlib import Path

import pytest
from tests.simulation.plant_record import digest

from pitotbench import BadInputError, Case, UnknownNameError, fly
from pitotbench.effects.overlay import AxisFunction, Overlay
from pitotbench.records.case import EffectSpec
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.modified import install_variant
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.variant import write_variant
from pitotbench.units import FOOT, KNOT

POD, LOAD = EffectSpec("belly_pod", {"drag_area_m2": 0.1}), EffectSpec("mass", {"mass_kg": 100.0})
SHORT = {
    "maneuver": "rapid_decel",
    "turbulence": "none",
    "card": {"repeats": 1, "dwell_s": 5.0, "settle_s": 5.0},
}


def tree(folder: Path) -> dict[str, bytes]:
    return {
        str(f.relative_to(folder)): f.read_bytes() for f in sorted(folder.rglob("*")) if f.is_file()
    }


def test_an_installed_variant_flies_as_the_effects_of_a_case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = tree(find_aircraft("navajo"))
    folder = install_variant("navajo", "pod", [POD, LOAD], {"log": "flight.csv"})
    assert folder == tmp_path / "aircraft" / "navajo+pod"
    installed, named = (
        fly(Case(aircraft="navajo+pod", **SHORT)),
        fly(Case(effects=(POD, LOAD), **SHORT)),
    )
    assert digest(installed) == digest(named)
    assert tree(find_aircraft("navajo")) == before
    assert "belly_pod" in (folder / "variant.toml").read_text()
    assert "flight.csv" in (folder / "variant.toml").read_text()


def test_variants_stack_and_nothing_is_overwritten(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = install_variant("navajo", "pod", [POD])
    before = tree(folder)
    install_variant("navajo+pod", "more", [POD, LOAD])
    plant = Plant.load("navajo+pod+more")
    plant.start(6000 * FOOT, 140 * KNOT)
    drags = [
        plant.get(path) / plant.get("aero/qbar-psf") * FOOT**2
        for path in ("effects/drag-0", "effects-2/drag-0")
    ]
    assert drags == pytest.approx([0.1, 0.1])
    # A size is a property that may change in flight.
    plant.set("effects/belly-pod/drag-area-m2", 0.3)
    plant.run(0.1)
    assert plant.get("effects/drag-0") / plant.get("aero/qbar-psf") * FOOT**2 == pytest.approx(
        0.3, rel=1e-3
    )
    with pytest.raises(BadInputError, match="there already"):
        install_variant("navajo", "pod", [LOAD])
    assert tree(folder) == before
    assert sorted(f.name for f in (tmp_path / "aircraft").iterdir()) == [
        "navajo+pod",
        "navajo+pod+more",
    ]


BAD = {
    "a bad name": ("pod/../..", [POD], BadInputError, "use letters"),
    "an effect of the sensors": (
        "lag",
        [EffectSpec("pitot_lag", {"lag_s": 0.2})],
        BadInputError,
        "case file",
    ),
    "nothing": ("none", [EffectSpec("mass", {"mass_kg": 0.0})], BadInputError, "other than zero"),
    "an unknown effect": ("pod", [EffectSpec("pot")], UnknownNameError, "unknown effect"),
    "an impossible size": (
        "pod",
        [EffectSpec("mass", {"mass_kg": 1e6})],
        BadInputError,
        "not within",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_what_cannot_be_installed_is_refused_and_leaves_nothing(what, tmp_path):
    variant, effects, kind, message = BAD[what]
    with pytest.raises(kind, match=message):
        install_variant("navajo", variant, effects, shelf=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_an_axis_that_the_aircraft_lacks_is_named(tmp_path):
    overlay = Overlay(functions=(AxisFunction("UPWARD", "<value>0</value>"),))
    with pytest.raises(BadInputError, match="UPWARD"):
        write_variant(find_aircraft("navajo"), tmp_path, "navajo+bad", overlay)
    assert list(tmp_path.iterdir()) == []
