"""The force meter against a flight of the same aircraft, and the mass that is aboard."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pitotbench import BadInputError, Case, air, fly
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.overlay import AxisFunction, Overlay, product
from pitotbench.models.aircraft_model import aircraft_model, coarse_rate
from pitotbench.records.case import EffectSpec
from pitotbench.records.motion import Motion, Reaction
from pitotbench.simulation import force_meter
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.force_meter import GUIDANCE, measure
from pitotbench.simulation.modified import (
    Loading,
    ballast_for,
    ballast_overlay,
    install_variant,
    loaded_fuel,
    loaded_mass,
    loading_of,
    mass_of,
)
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.unit_forces import inertia_of
from pitotbench.units import FOOT, POUND, POUND_FORCE

EVERY = 10  # samples of the flight a state
STATES = (
    *(
        "time",
        "static_pressure",
        "angle_of_attack",
        "sideslip",
        "roll",
        "pitch",
        "heading",
        "roll_rate",
    ),
    *(
        "pitch_rate",
        "yaw_rate",
        "elevator",
        "aileron",
        "rudder",
        "throttle_left",
        "throttle_right",
        "mass",
    ),
)
LOADINGS = {"full tanks": {}, "40 % of the fuel": {"fuel": 0.4}, "200 kg more": {"ballast": 200.0}}


def felt_by_the_model(motion: Motion) -> Reaction:
    ballast = ballast_for("navajo", float(motion.mass.min()), float(motion.mass.max()))
    plant = Plant.load("navajo", overlay=ballast_overlay("navajo", ballast))
    return measure(plant, motion, loaded_mass("navajo") + ballast)


def motion_of(flight, rows):
    impact = flight["total_pressure"] - flight["static_pressure"]
    mach = air.mach_from_impact_pressure(impact, flight["static_pressure"])
    return Motion(**{name: flight[name][rows].copy() for name in STATES}, mach=mach[rows].copy())


@cache
def flown(fuel=1.0, ballast=0.0):
    case = Case(maneuver="rapid_decel", turbulence="light", truth_seed=5)
    return fly(replace(case, fuel=fuel, ballast=ballast))


@pytest.fixture(scope="module", params=LOADINGS.values(), ids=LOADINGS.keys())
def pair(request):
    flight = flown(**request.param)
    motion = motion_of(flight, slice(None, None, EVERY))
    return flight, motion, felt_by_the_model(motion)


@pytest.mark.parametrize(
    ("name", "mean", "deviation"),
    [
        ("specific_force_x", 0.002, 0.01),
        ("specific_force_y", 0.002, 0.01),
        ("specific_force_z", 0.01, 0.03),
        ("manifold_pressure_left", 50.0, 400.0),
        ("propeller_speed_right", 0.05, 0.4),
        ("fuel_flow_left", 1e-5, 1e-4),
    ],
)
def test_it_says_what_the_flight_felt(pair, name: str, mean: float, deviation: float) -> None:
    flight, _, reaction = pair
    error = getattr(reaction, name) - flight[name][::EVERY]
    assert abs(error.mean()) < mean
    assert error.std() < deviation < flight[name].std()


def test_angular_acceleration_agrees_with_the_rates(pair) -> None:
    flight, _, reaction = pair
    turned = np.gradient(flight["roll_rate"], flight["time"])[::EVERY]
    assert np.std(reaction.roll_acceleration - turned) < 0.5 * turned.std()


def test_the_measured_mass_decides_the_force(pair) -> None:
    """40 kg are 1.5 % of the weight, so of the specific force along z in level flight."""
    _, motion, reaction = pair
    lighter = felt_by_the_model(replace(motion, mass=motion.mass - 40.0))
    expected = 40.0 / motion.mass.mean()
    assert np.mean(lighter.specific_force_z / reaction.specific_force_z) == pytest.approx(
        1.0 + expected, rel=2e-3
    )


AT_THE_ENDS = [
    (name, parameter.name, end)
    for name, effect in EFFECTS.items()
    if isinstance(effect, AircraftEffect) and effect.acts_on == "aircraft"
    if name
    != "throttle_rigging"  # it moves the very levers by which the measured throttles are set
    for parameter in effect.parameters
    if not parameter.shape
    for end in (parameter.low, parameter.high)
]


@pytest.fixture(scope="module")
def few():
    """A quarter of a minute of a flight with full tanks, a state every half second."""
    return motion_of(flown(), slice(0, 1500, 5 * EVERY))


def react(motion: Motion, name: str, sizes: dict[str, float]) -> Reaction:
    effect = EFFECTS[name]
    overlay = effect.overlay(effect.complete(sizes), read_baseline(find_aircraft("navajo")))
    return measure(Plant.load("navajo", 25.0, overlay), motion, loaded_mass("navajo"))


@pytest.mark.parametrize(("name", "parameter", "end"), AT_THE_ENDS)
def test_it_answers_for_an_effect_at_the_end_of_its_range(
    few, name: str, parameter: str, end: float
) -> None:
    """No autopilot could hold some of these, and no starter turn an engine that loses 80 kW."""
    reaction = react(few, name, {parameter: end})
    assert all(np.isfinite(getattr(reaction, field)).all() for field in Reaction.__slots__)


def test_a_patched_airplane_is_measured_as_any_airplane(few, tmp_path, monkeypatch) -> None:
    """A pound changes as much on it, and on one that is patched again. What reads a function of an
    earlier patch reads that one, and not the function of the same name that it adds.
    """
    monkeypatch.chdir(tmp_path)
    pod = EffectSpec("belly_pod", {"drag_area_m2": 0.1})
    install_variant("navajo", "pod", [pod])
    install_variant("navajo+pod", "more", [pod])
    names = ("navajo", "navajo+pod", "navajo+pod+more")
    models = [aircraft_model(name) for name in names]
    first, *others = [model.unit_forces(few, frozenset({"aero/qbar-psf"})) for model in models]
    for other in others:
        assert other.properties["aero/qbar-psf"] == pytest.approx(first.properties["aero/qbar-psf"])
        for axis, changes in first.changes.items():
            close = pytest.approx(changes[:, :3], rel=1e-3, abs=1e-4 * np.abs(changes).max())
            assert other.changes[axis][:, :3] == close
    again = Overlay(functions=(AxisFunction("DRAG", product("effects/drag-0", 1.0)),))
    pulls = [model.react(few).specific_force_x for model in models]
    pulls.append(models[1].react(few, again).specific_force_x)
    one, two, read = (pulls[0] - pull for pull in pulls[1:])
    assert two == pytest.approx(2.0 * one, rel=0.01)
    assert read == pytest.approx(two, rel=0.01)


def test_an_engine_that_no_starter_turns_runs_and_lacks_its_power(few) -> None:
    sound, slight, lossy = (
        react(few, "friction_loss", {"left_kw": loss}) for loss in (1e-9, 8.0, 80.0)
    )
    assert lossy.fuel_flow_left == pytest.approx(
        sound.fuel_flow_left, rel=1e-3
    )  # it does not stand still
    pull, slight_pull = (sound.specific_force_x - less.specific_force_x for less in (lossy, slight))
    assert pull == pytest.approx(10.0 * slight_pull, rel=0.02)


def test_the_modes_of_the_autopilot_have_no_part_in_a_reaction(few, monkeypatch) -> None:
    """The meter leaves them out. They run along in a meter that finds no switch for them, and
    nothing changes.
    """
    without = react(few, "power_deficit", {"left_kw": 4.0})
    monkeypatch.setattr(force_meter, "GUIDANCE", "ap/no-such-switch")
    along = react(few, "power_deficit", {"left_kw": 4.0})
    for field in Reaction.__slots__:
        np.testing.assert_array_equal(getattr(without, field), getattr(along, field))


def test_the_switch_stops_the_modes_of_the_autopilot() -> None:
    plant = Plant.load("navajo")
    assert plant.get(GUIDANCE) == 1.0
    heard = []
    for switch, target in ((1.0, 90.0), (0.0, 180.0), (1.0, 180.0)):
        plant.set(GUIDANCE, switch)
        plant.set("ap/heading-target-deg", target)
        plant.advance(1)
        heard.append(plant.get("ap/heading-error-rad"))
    assert heard[0] == heard[1] != heard[2]


def test_a_frozen_aircraft_stays_where_it_is_until_it_is_released() -> None:
    plant = Plant.load("navajo", 25.0)
    plant.start_frozen(1828.8, 70.0)
    assert plant.get("altitude") == pytest.approx(1828.8, abs=0.01)
    plant.advance(100)
    assert plant.get("altitude") == pytest.approx(1828.8, abs=0.01)
    plant.release()
    plant.advance(100)
    assert abs(plant.get("altitude") - 1828.8) > 1.0


BURNT = 3.0  # kg, at most, until the card begins


def test_an_aircraft_as_loaded_weighs_its_structure_crew_and_fuel():
    """5,990 lb: 4,060 lb empty, 804 lb of crew and instruments, twice 563 lb of fuel."""
    assert loaded_mass("navajo") == pytest.approx(5990.0 * POUND, abs=0.1)
    assert loaded_fuel("navajo") == pytest.approx(2 * 563.0 * POUND)


@pytest.mark.parametrize(("fuel", "ballast"), [(1.0, 0.0), (0.4, 0.0), (1.0, 250.0), (0.5, -100.0)])
def test_a_flight_begins_at_the_mass_of_its_case(fuel: float, ballast: float) -> None:
    short = {"repeats": 1, "dwell_s": 5.0}
    case = Case(maneuver="rapid_decel", card=short, turbulence="none", fuel=fuel, ballast=ballast)
    flight = fly(case)
    assert 0.0 < mass_of("navajo", Loading(fuel, ballast)) - flight["mass"][0] < BURNT


@pytest.mark.parametrize("mass", [2100.0, 2300.0, 2504.0, 2717.0, 2950.0])
def test_a_loading_gives_the_mass_it_was_asked_for(mass: float) -> None:
    loading = loading_of("navajo", mass)
    assert mass_of("navajo", loading) == pytest.approx(mass, abs=1e-6)
    assert 0.1 - 1e-9 <= loading.fuel <= 1.0
    # Fuel goes first, and ballast only takes what fuel cannot.
    assert mass > 2717.0 or loading.ballast == 0.0 or loading.fuel == pytest.approx(0.1)
    assert mass < 2950.0 or loading.fuel == pytest.approx(1.0)
    assert ballast_for("navajo", 2880.0, 2900.0) == pytest.approx(2900.0 - loaded_mass("navajo"))


@pytest.mark.parametrize("mass", [300.0, 5990.0])
def test_the_mass_of_another_airplane_is_refused(mass: float) -> None:
    with pytest.raises(BadInputError, match="check the unit"):
        ballast_for("navajo", mass, mass)


def test_a_lift_slope_that_does_not_change_is_a_zero_lift():
    motion = motion_of(flown(), slice(None, None, 2000))
    baseline = read_baseline(find_aircraft("navajo"))
    felt = [
        measure(
            Plant.load("navajo", overlay=EFFECTS[name].overlay(sizes, baseline)),
            motion,
            loaded_mass("navajo"),
        )
        for name, sizes in (
            ("lift_slope", {"change": 0.0, "zero_coefficient": 0.1}),
            (EFFECTS["lift_slope"].neighbor, {"lift_coefficient": 0.1}),
            ("lift_slope", {"change": 0.2, "zero_coefficient": 0.1}),
        )
    ]
    slope, zero, changed = (each.specific_force_z for each in felt)
    np.testing.assert_allclose(slope, zero, rtol=1e-9)
    assert np.all(np.abs(changed - zero) > 0.5)  # m/s²


@pytest.mark.parametrize("aircraft", ["DHC6", "aerosonde"])
def test_the_product_of_inertia_has_the_sign_that_the_motion_has(aircraft: str) -> None:
    """L = Ixx p' - Ixz r', N = Izz r' - Ixz p' at rest in roll and yaw (Etkin, Dynamics of Flight,
    1996, eq. 4.5,9): of a sideslip the differences of moments and of accelerations.
    """
    plant = Plant.load(aircraft, 100.0)
    seen = []
    for beta in (2.0, -2.0):
        plant.set("ic/vt-kts", 80.0)
        plant.set("ic/h-sl-ft", 3000.0)
        plant.set("ic/beta-deg", beta)
        plant.run_initial_conditions()
        paths = ("moments/l-total-lbsft", "moments/n-total-lbsft")
        rates = ("accelerations/pdot-rad_sec2", "accelerations/rdot-rad_sec2")
        seen.append([plant.get(path) for path in (*paths, *rates)])
    ixx, _, izz, ixz = inertia_of(plant)  # JSBSim has none before
    roll, yaw, p, r = np.subtract(*seen)
    assert abs(ixz) > 0.01 * ixx
    assert roll * POUND_FORCE * FOOT == pytest.approx(ixx * p - ixz * r, rel=1e-3)
    assert yaw * POUND_FORCE * FOOT == pytest.approx(izz * r - ixz * p, rel=1e-3)


def test_the_power_of_a_turboprop_does_not_depend_on_how_often_its_state_is_set():
    """JSBSim puts its gas generator to idle with every initial condition: 1.2 m/s² of thrust."""
    told = []
    for step, rate in ((0.1, 100.0), (1.0, 25.0)):
        time = np.arange(0.0, 6.0 + step, step)
        same = dict.fromkeys(STATES, np.zeros_like(time)) | {"time": time}
        steady = {"static_pressure": 84e3, "throttle_left": 0.8, "throttle_right": 0.8}
        steady |= {"mass": loaded_mass("DHC6")}
        motion = Motion(
            **same | {name: np.full_like(time, value) for name, value in steady.items()},
            mach=np.full_like(time, 0.2),
        )
        felt = measure(Plant.load("DHC6", rate, at_once=True), motion, loaded_mass("DHC6"))
        told.append(
            [felt.specific_force_x[-1], felt.roll_acceleration[-1], felt.fuel_flow_left[-1]]
        )
    assert told[0] == pytest.approx(told[1], rel=1e-3)


def test_a_light_propeller_is_followed_in_steps_that_it_settles_in():
    """At 25 Hz the thrust of the aerosonde alternated by 5,000 m/s² from state to state."""
    assert coarse_rate("aerosonde", 30.0) == 50.0
    assert coarse_rate("navajo", 60.0) == 25.0


def test_a_shifted_center_of_gravity_leaves_the_moments_of_inertia_of_a_small_airplane():
    """The ballast that moves it stands a few chords away: a moment about the pitch axis alone."""
    baseline = read_baseline(find_aircraft("aerosonde"))
    effect = EFFECTS["center_of_gravity"]
    shift = effect.parameter("aft_m").of_airplane(baseline).typical
    inertias = []
    for sizes in ({}, {"aft_m": shift}):
        plant = Plant.load("aerosonde", 100.0, effect.overlay(sizes, baseline), at_once=True)
        plant.run_initial_conditions()
        inertias.append(inertia_of(plant))
    assert np.allclose(*inertias, rtol=0.05)
