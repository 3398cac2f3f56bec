"""The effects on aircraft and air in JSBSim: each acts, by the amount it says, and is nothing at
zero.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.simulation.plant_record import digest

from pitotbench import BadInputError, Case, Flight, fly
from pitotbench.campaigns.flights import wind_toward
from pitotbench.effects import EFFECTS, FORMS
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.overlay import Baseline, Overlay
from pitotbench.effects.response import Signals
from pitotbench.records.case import EffectSpec
from pitotbench.simulation import modified, sortie
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.properties import HORSEPOWER
from pitotbench.units import FOOT, KNOT, POUND, STANDARD_GRAVITY

SHORT = {
    "maneuver": "race_track",
    "card": {"dwell_s": 5.0, "speeds_kt": [140.0]},
    "turbulence": "light",
    "integration_rate": 50.0,
}
BRIEF = SHORT | {
    "maneuver": "rapid_decel",
    "card": {"dwell_s": 12.0, "speeds_kt": [110.0, 100.0], "repeats": 1},
}
SIMULATED = [name for name, effect in EFFECTS.items() if isinstance(effect, AircraftEffect)]
POUND_FORCE = POUND * STANDARD_GRAVITY
# the channel that answers first, and to which side
ANSWERS = {
    "belly_pod": ("power_left", 1),
    "control_effectiveness": ("elevator", 1),
    "control_moments": ("elevator", 1),
    "induced_drag": ("power_left", 1),
    "mass": ("angle_of_attack", 1),
    "center_of_gravity": ("elevator", 1),
    "flap_not_up": ("angle_of_attack", -1),
    "gear_not_up": ("power_left", 1),
    "trim_offset": ("elevator", 1),
    "turn_drag": ("power_left", 1),
    "governor_speed": ("propeller_speed_left", -1),
    "power_deficit": ("manifold_pressure_left", 1),
    "propeller_efficiency": ("power_left", 1),
    "throttle_rigging": ("power_left", 1),
    "nonstandard_temperature": ("air_temperature", 1),
    "sea_breeze_front": ("wind_north", 1),
    "turbulence_level": ("wind_down", 0),
    "turbulence_scale": ("wind_down", 0),
    "updraft": ("wind_down", -1),
    "wind_drift": ("wind_north", 1),
    "wind_oscillation": ("wind_north", 1),
    "polar_bend": ("power_left", 1),
    "inclined_pod": ("power_left", 1),
    "turn_rate_drag": ("power_left", 1),
    "friction_loss": ("manifold_pressure_left", 1),
    "wind_shear": ("wind_east", 0),
    "lift_slope": ("angle_of_attack", -1),
    "zero_lift": ("angle_of_attack", -1),
    "pitch_stiffness": ("elevator", 0),
    "pitch_damping": ("elevator", 0),
    "side_force": ("sideslip", 0),
    "dihedral_effect": ("aileron", 0),
    "weathercock_stability": ("sideslip", 0),
    "roll_damping": ("aileron", 0),
    "yaw_damping": ("rudder", 0),
    "roll_by_yaw_rate": ("aileron", 0),
}


@pytest.fixture(scope="module")
def plain() -> Flight:
    return fly(Case(**SHORT))


@pytest.fixture(scope="module")
def brief() -> Flight:
    return fly(Case(**BRIEF))


def level(overlay: Overlay | None = None, seconds: float = 5.0, **controls: float) -> Plant:
    plant = Plant.load("navajo", overlay=overlay)
    plant.start(6000 * FOOT, 140 * KNOT)
    for name, value in controls.items():
        plant.set(name, value)
    plant.run(seconds)
    return plant


def overlay(name: str, **sizes: float) -> Overlay:
    effect = EFFECTS[name]
    return effect.overlay(sizes, read_baseline(find_aircraft("navajo")))


@pytest.mark.parametrize("name", SIMULATED)
def test_a_typical_effect_moves_its_channel(name, plain):
    sizes = EFFECTS[name].typical() | ({"at_s": 5.0} if name == "sea_breeze_front" else {})
    flight = fly(Case(effects=(EffectSpec(name, sizes),), **SHORT))
    channel, side = ANSWERS[name]
    n = min(len(flight), len(plain))
    change = flight[channel][:n] - plain[channel][:n]
    assert change.any()
    assert side == 0 or np.sign(np.mean(change)) == side
    assert (
        np.abs(np.mean(flight["calibrated_airspeed"]) - 140.0 * KNOT) < 1.5 * KNOT
    )  # still the same card


@pytest.mark.parametrize("name", [name for name in SIMULATED if f"{name}_from_a_time" in FORMS])
def test_an_effect_from_a_time_on_leaves_the_flight_before_it_bit_for_bit(name, brief):
    flight = fly(
        Case(effects=(EffectSpec(name, {**EFFECTS[name].typical(), "from_s": 8.0}),), **BRIEF)
    )
    since = brief["time"] - brief["time"][0]
    before, (channel, _) = int(np.searchsorted(since, 8.0)), ANSWERS[name]
    assert all(np.array_equal(flight[c][:before], brief[c][:before]) for c in brief.channels)
    n = min(len(flight), len(brief))
    assert np.any(flight[channel][before:n] != brief[channel][before:n])


def test_all_effects_of_zero_size_together_are_none(plain, monkeypatch):
    """With every function, mass, force and wind loaded, bit for bit: what is added is exactly zero."""
    entries = tuple(EffectSpec(name, EFFECTS[name].typical()) for name in SIMULATED)
    shapes = {
        f"/{p.name}".replace("_", "-")
        for name in SIMULATED
        for p in EFFECTS[name].parameters
        if p.shape
    }

    def zeroed(case: Case) -> Overlay:
        whole = modified.overlay_of(case)
        sizes = tuple(
            (path, v if any(path.endswith(s) for s in shapes) else 0.0) for path, v in whole.sizes
        )
        return replace(whole, sizes=sizes, temperature_offset=0.0)

    monkeypatch.setattr(sortie, "overlay_of", zeroed)
    assert digest(fly(Case(effects=entries, **SHORT))) == digest(plain)


def test_zero_in_a_case_is_none(plain):
    entries = tuple(
        EffectSpec(name, {p.name: 0.0 for p in EFFECTS[name].parameters if not p.shape})
        for name in SIMULATED
    )
    assert digest(fly(Case(effects=entries, **SHORT))) == digest(plain)


def test_a_pod_slows_the_airplane_at_the_same_power():
    held = {"throttle_mode": 2, "manifold_pressure_target": 26.0 * 3386.389}
    clean = level(seconds=120.0, **held)
    pod = level(overlay("belly_pod", drag_area_m2=0.1), seconds=120.0, **held)
    slower = (clean.get("calibrated_airspeed") - pod.get("calibrated_airspeed")) / KNOT
    assert pod.get("manifold_pressure_left") == pytest.approx(
        clean.get("manifold_pressure_left"), rel=1e-3
    )
    # Of 0.717 m² at 140 kt (0.0262 S, and 0.0614 C_L² S at 26.6 kN) 78 % is parasite drag. At
    # constant thrust power (0.78 + 0.1/0.717) v³ + 0.22/v = 1, so v = 0.941: 8.3 kt
    assert slower == pytest.approx(8.3, rel=0.1)


def test_added_drag_is_what_the_coefficients_say():
    for name, sizes, expected in (
        ("belly_pod", {"drag_area_m2": 0.1}, lambda p: 0.1 / FOOT**2),
        (
            "induced_drag",
            {"factor": 0.01},
            lambda p: 0.01 * p.get("aero/cl-squared") * p.get("metrics/Sw-sqft"),
        ),
        (
            "turn_drag",
            {"coefficient_at_30deg": 0.005},
            lambda p: 0.02 * np.sin(p.get("roll")) ** 2 * p.get("metrics/Sw-sqft"),
        ),
    ):
        plant = level(overlay(name, **sizes), 15.0, lateral_mode=2, bank_target=0.4)
        found = plant.get("effects/drag-0") / plant.get("aero/qbar-psf")
        assert found == pytest.approx(expected(plant), rel=0.01)
        assert found > 0.0


def test_loading_moves_mass_and_center_of_gravity():
    plain = level()
    heavy, aft = (
        level(overlay("mass", mass_kg=-150.0)),
        level(overlay("center_of_gravity", aft_m=0.06)),
    )
    assert heavy.get("mass") - plain.get("mass") == pytest.approx(-150.0, abs=1.0)
    moved = (aft.get("inertia/cg-x-in") - plain.get("inertia/cg-x-in")) * FOOT / 12.0
    assert moved == pytest.approx(0.06, rel=1e-3)
    assert aft.get("mass") == pytest.approx(plain.get("mass"), abs=0.5)


def test_a_weaker_elevator_moves_further_for_the_same_moment():
    plain, weak = level(), level(overlay("control_effectiveness", elevator_change=-0.2))
    baseline = read_baseline(find_aircraft("navajo"))
    assert [term.name for term in baseline.terms("PITCH", "elevator")] == [
        "aero/moment/pitch-elevator"
    ]
    added = weak.get("effects/pitch-1") / weak.get("aero/moment/pitch-elevator")  # 0 is its lift
    assert added == pytest.approx(-0.2)
    assert weak.get("elevator") / plain.get("elevator") == pytest.approx(1.25, rel=0.05)
    moments = overlay(
        "control_moments", elevator_change=-0.2, aileron_change=0.1, rudder_change=0.1
    ).functions
    assert [each.axis for each in moments] == [
        "PITCH",
        "ROLL",
        "YAW",
    ]  # the forces of the surfaces stay


def test_propulsion_loses_the_share_that_is_named():
    fixed = {"throttle_mode": 0, "throttle_command": 0.6}
    plain = level(**fixed)
    weak = level(overlay("power_deficit", left_fraction=0.1, right_fraction=0.0), **fixed)
    loss = plain.get("power_left") - weak.get("power_left")
    indicated = (
        plain.get("power_left") + 65.5 * HORSEPOWER
    )  # friction at 2,575 rpm: Engines/tio540a.xml
    assert loss / indicated == pytest.approx(0.1, rel=0.1)
    assert weak.get("power_right") == pytest.approx(plain.get("power_right"), rel=0.02)
    poor = level(overlay("propeller_efficiency", left_change=-0.05, right_change=-0.05), **fixed)
    thrust = (poor.get("thrust_left") + poor.get("thrust_right")) / POUND_FORCE
    assert poor.get("forces/fbx-external-lbs") == pytest.approx(-0.05 * thrust, rel=1e-2)
    slow = level(overlay("governor_speed", offset_rpm=-100.0), 20.0)
    assert slow.get("propulsion/engine/propeller-rpm") == pytest.approx(2475.0, abs=5.0)


def test_flaps_gear_and_throttles_stand_where_they_are_put():
    entries = ("flap_not_up", {"extension": 0.2}), ("gear_not_up", {"extension": 0.4})
    plant = level(overlay(entries[0][0], **entries[0][1]) + overlay(entries[1][0], **entries[1][1]))
    assert plant.get("fcs/flap-pos-deg") == pytest.approx(0.2 * 40.0, abs=1e-2)
    assert plant.get("fcs/gear-extension-norm") == pytest.approx(0.4, abs=1e-3)
    rigged = level(overlay("throttle_rigging", left=0.03, right=-0.01))
    assert rigged.get("throttle_left") - rigged.get("throttle_right") == pytest.approx(
        0.04, abs=1e-6
    )


def test_winds_are_those_of_the_same_formula_over_a_log(plain):
    """What JSBSim blew is what `wind` computes from nothing but the log's time and altitude."""
    sizes = {
        name: EFFECTS[name].typical()
        for name in ("wind_drift", "wind_shear", "sea_breeze_front", "updraft", "wind_oscillation")
    }
    sizes["sea_breeze_front"] |= {"at_s": 10.0, "width_s": 8.0}
    sizes["updraft"] |= {"from_s": 15.0, "for_s": 20.0}
    entries = tuple(EffectSpec(name, values) for name, values in sizes.items())
    calm = Case(**{**SHORT, "turbulence": "none"}, effects=entries)
    flight = fly(calm)
    signals = Signals(flight["time"], {"altitude": flight["altitude"]})
    blown = np.zeros((3, len(flight)))
    for name, values in sizes.items():
        effect = EFFECTS[name]
        blown += np.array(effect.wind(signals, values))
    for axis, base, expected in zip(
        ("north", "east", "down"), wind_toward(calm.wind), blown, strict=True
    ):
        assert np.abs(flight[f"wind_{axis}"] - base - expected).max() < 0.02
    assert np.ptp(flight["wind_north"]) > 2.0


def test_gusts_grow_by_their_level_and_slow_down_with_their_scale():
    card = {"maneuver": "circle", "card": {"speeds_kt": [120.0]}, "turbulence": "moderate"}

    def gusts(*entries: EffectSpec) -> np.ndarray:
        return fly(Case(**card, effects=entries))["wind_down"]

    plain = gusts()
    strong = gusts(EffectSpec("turbulence_level", {"change": 0.5}))
    assert np.std(strong) / np.std(plain) == pytest.approx(1.5, rel=0.1)
    quick = gusts(EffectSpec("turbulence_scale", {"change": -0.75}))
    rough = [float(np.std(g[100:] - g[:-100])) for g in (plain, quick)]
    assert rough[1] / rough[0] > 1.3
    assert np.std(quick) == pytest.approx(np.std(plain), rel=0.4)


def test_warmer_air_is_warmer():
    flight = fly(
        Case(**SHORT, effects=(EffectSpec("nonstandard_temperature", {"warmer_k": 10.0}),))
    )
    plain = fly(Case(**SHORT, temperature_offset=10.0))
    assert digest(flight) == digest(plain)


def test_an_aircraft_that_lacks_a_part_is_named():
    bare = Baseline("glider", (0.0, 0.0, 0.0))
    engines = ("power_deficit", "propeller_efficiency", "governor_speed", "throttle_rigging")
    for name in (*engines, "control_effectiveness"):
        effect = EFFECTS[name]
        with pytest.raises(BadInputError, match=r"'glider'"):
            effect.overlay(effect.typical(), bare)
