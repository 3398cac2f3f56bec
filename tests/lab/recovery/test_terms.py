"""A term that was changed in an airplane's file is found again from maneuvers, and closes the gap
elsewhere.
"""

import json
from contextlib import redirect_stdout
from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from scipy.io import savemat

from pitotbench import BadInputError, Case, air, fly, sense
from pitotbench.bench import workflow
from pitotbench.bench.workflow import NamedLog, entries, reconcile_fully
from pitotbench.cli import main
from pitotbench.effects.overlay import FunctionScaling, Overlay, product
from pitotbench.models.maneuver_model import air_model, in_place_of_log
from pitotbench.models.maneuver_parts import align_vane, maneuvers_of
from pitotbench.models.sidpac import read_identification
from pitotbench.records.case import EffectSpec
from pitotbench.records.maneuver import Maneuver
from pitotbench.records.motion import Motion
from pitotbench.simulation.modified import install_variant, overlay_of
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.properties import POUND_FORCE
from pitotbench.simulation.unit_forces import UNIT_AXES, inertia_of, measure_terms, unit_overlay
from pitotbench.units import DEGREE, FOOT, PSF, SLUG, STANDARD_GRAVITY

SECONDS, RATE, SPEED, HEIGHT = 8.0, 50.0, 73.0, 2_190.0  # s, Hz, m/s, m
FORCE_NOISE, TURN_NOISE = 0.02, 0.01  # m/s², rad/s²


def _motion(seed, mass):
    """States and controls that all move apart from one another, about level flight."""
    draw = np.random.default_rng(seed)
    time = np.arange(0.0, SECONDS, 1.0 / RATE)

    def wave(size):
        phases, periods = draw.uniform(0.0, 2.0 * np.pi, 3), draw.uniform(0.8, 4.0, 3)
        return (
            size
            * sum(np.sin(2.0 * np.pi * time / t + p) for t, p in zip(periods, phases, strict=True))
            / 1.7
        )

    pressure = np.full(len(time), float(air.standard_pressure(HEIGHT)))
    sound = float(air.sound_speed(float(air.standard_temperature(HEIGHT))))
    names = (
        "elevator",
        "aileron",
        "rudder",
        "sideslip",
        "roll_rate",
        "pitch_rate",
        "yaw_rate",
        "angle_of_attack",
    )
    sizes = (0.02, 0.03, 0.03, 0.02, 0.1, 0.06, 0.05, 0.015)
    moved = {name: wave(size) for name, size in zip(names, sizes, strict=True)}
    return Motion(
        time=time,
        static_pressure=pressure,
        mach=np.full(len(time), SPEED / sound) + wave(0.002),
        roll=wave(0.02),
        pitch=wave(0.02),
        heading=np.zeros(len(time)),
        throttle_left=np.full(len(time), 0.5),
        throttle_right=np.full(len(time), 0.5),
        mass=np.full(len(time), mass),
        **moved,
    )


def _maneuver(seed, *scalings):
    """A maneuver of a DHC6 in whose file functions were scaled, with noise."""
    overlay = unit_overlay(UNIT_AXES) + Overlay(scalings=scalings)
    plant = Plant.load("DHC6", 100.0, overlay, at_once=True)
    mass = plant.get("mass")
    motion = _motion(seed, mass)
    by_rate = "aero/coefficient/Cmadot"
    felt = measure_terms(plant, motion, [by_rate])
    thrust = np.full(len(motion.time), 6_000.0)
    force = (felt.total[:, :3] * POUND_FORCE + thrust[:, None] * (1.0, 0.0, 0.0)) / mass
    moment = felt.total[:, 3:] * POUND_FORCE * FOOT
    # These states are no flight: the rate of the angle of attack is theirs, not that which the
    # forces would make.
    rate = np.gradient(motion.angle_of_attack, motion.time)
    moment[:, 1] += felt.values[by_rate] * (rate / felt.alpha_rate - 1.0) * POUND_FORCE * FOOT
    ixx, iyy, izz, ixz = measured = inertia_of(plant)
    inertia = np.array([[ixx, 0.0, -ixz], [0.0, iyy, 0.0], [-ixz, 0.0, izz]])
    rates = np.stack([motion.roll_rate, motion.pitch_rate, motion.yaw_rate], axis=1)
    turning = np.linalg.solve(inertia, (moment - np.cross(rates, rates @ inertia)).T).T
    draw = np.random.default_rng(seed + 1)
    return Maneuver(
        f"maneuver {seed}",
        motion,
        force + draw.normal(0.0, FORCE_NOISE, force.shape),
        turning + draw.normal(0.0, TURN_NOISE, turning.shape),
        thrust=thrust,
        mass=np.full(len(motion.time), mass),
        inertia=measured,
    )


def _scaled(name, factor):
    return FunctionScaling(f"aero/coefficient/{name}", product(factor, 1.0), product(0.0, 1.0))


def test_a_patched_mass_is_added_to_the_measured_one_once(tmp_path, monkeypatch):
    """What a patch says that nobody weighed is moved as well, by the same forces of the air."""
    monkeypatch.chdir(tmp_path)
    install_variant("navajo", "heavier", [EffectSpec("mass", {"mass_kg": 150.0})])
    motion = _motion(5, 2_900.0)
    light, heavy = (air_model(name, ()) for name in ("navajo", "navajo+heavier"))
    assert heavy.mass == pytest.approx(light.mass)  # the weight sheet lacks it, as the log does
    here, there = (model.react(motion) for model in (light, heavy))
    # A heavier airplane turns its path less, and the terms over that rate change a little.
    for name in ("specific_force_x", "specific_force_y", "specific_force_z"):
        expected = getattr(here, name) * 2_900.0 / 3_050.0
        np.testing.assert_allclose(getattr(there, name), expected, rtol=2e-3, atol=1e-6)
    here, there = (model.unit_forces(motion, frozenset()) for model in (light, heavy))
    for axis, change in here.changes.items():
        expected = change[:, :3] * 2_900.0 / 3_050.0
        np.testing.assert_allclose(there.changes[axis][:, :3], expected, rtol=1e-6, atol=1e-9)


HIDDEN = {"CLalpha": 1.4, "CmDe": 0.75, "Cnb": 0.7, "Clp": 1.3}


@pytest.fixture(scope="module")
def changed():
    scalings = [_scaled(*each) for each in HIDDEN.items()]
    return [_maneuver(seed, *scalings) for seed in (1, 11)]


def _reconciled(maneuver):
    """The answer of the one regression on a maneuver."""
    named = NamedLog("a maneuver", in_place_of_log([maneuver], "DHC6"))
    return reconcile_fully(named, "DHC6", refly=False)


@pytest.fixture(scope="module")
def commanded(changed, tmp_path_factory):
    """The command on files of two maneuvers, the second held out: the answer of the one regression,
    what is printed, and the folder.
    """
    folder, answers = tmp_path_factory.mktemp("commanded"), []
    paths = [folder / f"{i}.mat" for i in range(2)]
    for path, maneuver in zip(paths, changed, strict=True):
        savemat(path, {"fdata": _array(maneuver)})

    def kept(*question, **settings):
        answers.append(reconcile_fully(*question, **settings))
        return answers[-1]

    words = ["reconcile", str(paths[0]), "--holdout", str(paths[1]), "--aircraft", "DHC6"]
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(StringIO()) as printed:
        patch.setattr(workflow, "reconcile_fully", kept)
        assert main([*words, "--out", str(folder / "out")]) == 0
    return answers[0], printed.getvalue(), folder / "out"


@pytest.fixture(scope="module")
def corrected(commanded):
    return commanded[0]


CAUSES = {
    "lift_slope": ("change", "CLalpha"),
    "control_moments": ("elevator_change", "CmDe"),
    "weathercock_stability": ("change", "Cnb"),
    "roll_damping": ("change", "Clp"),
}


def test_four_terms_changed_at_once_are_found_with_their_sizes(corrected):
    verdict = corrected.verdict
    assert verdict.kind == "named"
    found = {(gap.causes[0].name, s.name): s for gap in verdict.gaps for s in gap.causes[0].sizes}
    assert found.keys() == {(name, size) for name, (size, _) in CAUSES.items()}
    for name, (size, function) in CAUSES.items():
        told = found[name, size]
        assert abs(told.value - (HIDDEN[function] - 1.0)) < told.two_sigma < 0.06
    assert min(verdict.closure.share, verdict.closure_holdout.share) > 0.97
    assert not verdict.remains


def test_a_changed_coefficient_is_told_beside_that_of_the_file(corrected):
    told = {each.effect: each for each in corrected.account.coefficients}
    slope = told["lift_slope"]
    assert slope.measured.value / slope.model == pytest.approx(HIDDEN["CLalpha"], abs=0.02)
    assert (slope.measured.name, told["roll_damping"].measured.name) == ("per rad", "per p b/2V")


def test_a_coefficient_without_a_gap_is_told_with_its_bound(corrected):
    """It is fitted together with those that have one. A share of its own that is known to less than
    a fifth is told."""
    told = {(each.effect, each.parameter): each for each in corrected.account.coefficients}
    gaps = {(name, size) for name, (size, _) in CAUSES.items()}
    assert {key for key, each in told.items() if each.has_gap} == gaps
    rest = {key: each for key, each in told.items() if key not in gaps}
    assert {("pitch_stiffness", "change"), ("pitch_damping", "change")} <= rest.keys()
    for each in rest.values():
        assert abs(each.measured.value - each.model) < each.measured.two_sigma
        assert each.measured.two_sigma < 0.4 * abs(each.model)


def test_an_airplane_as_its_file_says_differs_in_nothing():
    outcome = _reconciled(_maneuver(3))
    assert outcome.verdict.kind == "no_gap"
    assert outcome.patch.entries == ()
    told = {each.effect: each for each in outcome.account.coefficients}
    assert not any(each.has_gap for each in told.values())
    slope = told["lift_slope"]
    assert abs(slope.measured.value - slope.model) < slope.measured.two_sigma < 0.1 * slope.model


def test_a_term_that_only_this_file_has_is_found_by_its_function():
    outcome = _reconciled(_maneuver(7, _scaled("Cnp", 1.9)))
    (gap,) = outcome.verdict.gaps
    assert outcome.account.legs == ()  # who flew no card of the bench is given none
    assert gap.causes[0].name == "yaw_moment_by_roll_rate/aero/coefficient/Cnp"
    assert abs(gap.causes[0].sizes[0].value - 0.9) < gap.causes[0].sizes[0].two_sigma < 0.3


def test_the_patched_model_feels_the_forces_of_the_maneuver_that_was_held_out(changed, corrected):
    """The overlay is loaded into JSBSim and measured: an oracle for the regression."""
    motion = changed[1].motion
    case = Case(aircraft="DHC6", effects=entries(corrected.patch))

    def felt(overlay):
        plant = Plant.load("DHC6", 100.0, unit_overlay(UNIT_AXES) + overlay, at_once=True)
        return measure_terms(plant, motion, []).total / motion.mach[:, None] ** 2

    truth = felt(Overlay(scalings=tuple(_scaled(*each) for each in HIDDEN.items())))
    before, after = (np.std(felt(each) - truth, axis=0) for each in (Overlay(), overlay_of(case)))
    for channel in (2, 3, 4, 5):  # down, roll, pitch, yaw
        assert after[channel] < 0.1 * before[channel]


def test_a_term_that_the_maneuver_does_not_move_is_no_hypothesis():
    still = _maneuver(5)
    quiet = replace(still, motion=replace(still.motion, sideslip=0.01 * still.motion.sideslip))
    (note,) = [n for n in _reconciled(quiet).verdict.notes if n.startswith("cannot be seen")]
    assert all(name in note for name in ("weathercock_stability", "dihedral_effect", "side_force"))


def test_a_late_vane_is_found(changed):
    motions = [each.motion for each in changed]
    vanes = [
        np.interp(motion.time - 0.2, motion.time, motion.angle_of_attack) for motion in motions
    ]
    late = [
        replace(each, motion=replace(each.motion, angle_of_attack=vane))
        for each, vane in zip(changed, vanes, strict=True)
    ]
    assert align_vane(changed)[1] == pytest.approx(0.0)
    assert align_vane(late)[1] == pytest.approx(0.2, abs=0.051)


# The array of SIDPAC: 90 columns, in feet, degrees, slugs and pounds.


def _array(maneuver):
    motion, columns = maneuver.motion, np.zeros((len(maneuver.motion.time), 90))
    speed = motion.mach * float(air.sound_speed(float(air.standard_temperature(HEIGHT))))
    in_degrees = {
        3: "sideslip", 4: "angle_of_attack", 5: "roll_rate", 6: "pitch_rate", 7: "yaw_rate", 8: "roll", 9: "pitch",
        14: "elevator", 15: "aileron", 16: "rudder",
    }  # fmt: skip
    pairs = {
        1: motion.time,
        2: speed / FOOT,
        **{number: getattr(motion, name) / DEGREE for number, name in in_degrees.items()},
        15: -motion.aileron / DEGREE,
        27: 0.7 * motion.static_pressure * motion.mach**2 / PSF,
        28: motion.mach,
        38: maneuver.thrust / POUND_FORCE,
        48: maneuver.mass / SLUG,
        **{11 + i: maneuver.specific_force[:, i] / STANDARD_GRAVITY for i in range(3)},
        **{42 + i: maneuver.angular_acceleration[:, i] / DEGREE for i in range(3)},
        **{
            49 + i: np.full(len(motion.time), maneuver.inertia[i] / (SLUG * FOOT**2))
            for i in range(4)
        },
    }
    for number, values in pairs.items():
        columns[:, number - 1] = values
    return columns


def test_an_array_of_sidpac_is_the_maneuver_again(tmp_path, changed):
    path = tmp_path / "one.mat"
    savemat(path, {"fdata": _array(changed[0]), "pclab": np.arange(12.0), "sarea": 422.5})
    back = read_identification(path)
    for name in ("time", "mach", "static_pressure", "angle_of_attack", "aileron", "pitch_rate"):
        assert getattr(back.motion, name) == pytest.approx(
            getattr(changed[0].motion, name), rel=1e-6, abs=1e-9
        )
    assert back.specific_force == pytest.approx(changed[0].specific_force)
    assert back.inertia == pytest.approx(changed[0].inertia)
    assert back.motion.temperature_offset == pytest.approx(0.0, abs=0.01)


def test_the_command_takes_such_files_without_a_mapping(commanded):
    _, printed, folder = commanded
    assert "coefficients of the model's file" in printed
    told = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    assert told["verdict"] == "named"
    causes = [gap["causes"][0] for gap in told["gaps"]]
    assert {each["name"] for each in causes} == CAUSES.keys()
    assert {each["acts_on"] for each in causes} == {"file"}
    slope = next(each for each in told["coefficients"] if each["effect"] == "lift_slope")
    assert slope["measured"] / slope["model"] == pytest.approx(HIDDEN["CLalpha"], abs=0.02)
    assert min(told["closure"], told["closure_holdout"]) > 0.95
    assert told["gap_after"] < 0.1 * told["gap_before"]
    assert {each.name for each in folder.iterdir()} == {
        "verdict.json",
        "report.html",
        "patch.toml",
        "overlay.xml",
    }


def test_what_cannot_be_judged_is_refused_with_the_way_out(tmp_path, changed, capsys):
    array = _array(changed[0])
    path = tmp_path / "bad.mat"
    savemat(path, {"fdata": array * (np.arange(90) != 27)})  # no Mach number, and no density
    with pytest.raises(BadInputError, match=r"Mach number \(column 28\) or density \(column 29\)"):
        read_identification(path)
    savemat(path, {"fdata": array[::-1]})
    with pytest.raises(BadInputError, match="the time, does not increase"):
        read_identification(path)
    savemat(path, {"fdata": array})
    assert main(["reconcile", str(path), "--aircraft", "none"]) == 2
    assert "name the aircraft" in capsys.readouterr().err


def test_body_rates_that_are_renewed_once_a_second_are_refused():
    flown = sense(
        fly(Case(maneuver="race_track", card={"dwell_s": 5.0, "speeds_kt": [140.0]})), "20/1"
    )
    held = np.searchsorted(flown.time, np.floor(flown.time - flown.time[0]) + flown.time[0])
    slow = replace(
        flown,
        **{name: getattr(flown, name)[held] for name in ("roll_rate", "pitch_rate", "yaw_rate")},
    )
    with pytest.raises(BadInputError, match=r"the body rates are renewed 1\.\d times a second"):
        maneuvers_of(slow, "slow")
