"""The linear model of an airplane: against the free response of JSBSim, and the identities of its
modes.
"""

import json

import jsbsim
import numpy as np
import pytest
from scipy.linalg import expm

from pitotbench.cli.app import main
from pitotbench.models.linear import LONGITUDINAL, STATES, find_modes, linearize
from pitotbench.units import FOOT

JET = "T37"  # its thrust follows the lever, and no propeller turns faster or slower in the response
STEP = 0.001  # s; with 0.005 s, JSBSim's integration alone is off by 4 %
NAMES = ["Dutch roll", "phugoid", "roll", "short period", "spiral"]
PATHS = {
    "Vt": "velocities/vt-fps",
    "Alpha": "aero/alpha-rad",
    "Theta": "attitude/theta-rad",
    "Q": "velocities/q-rad_sec",
    "Beta": "aero/beta-rad",
    "Phi": "attitude/phi-rad",
    "P": "velocities/p-rad_sec",
    "R": "velocities/r-rad_sec",
}


@pytest.fixture(scope="module")
def jet():
    return linearize(JET)


def _changed(**sizes):
    return np.array([sizes.get(state, 0.0) for state in STATES])


def _free_flight(model, changed, seconds):
    """The states (n, 8) of JSBSim's own flight from level flight with some of them changed."""
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.load_model(JET)
    fdm.set_dt(STEP)
    start = dict(zip(STATES, model.trim + changed, strict=True))
    forward = start["Vt"] * np.cos(start["Beta"])
    setting = dict(zip(model.inputs, model.setting, strict=True))
    controls = {
        "propulsion/fuel_freeze": 1,
        "gear/gear-cmd-norm": 0,
        "gear/gear-pos-norm": 0,
        "fcs/elevator-cmd-norm": setting["DeCmd"],
        "fcs/throttle-cmd-norm[0]": setting["ThtlCmd"],
        "fcs/throttle-cmd-norm[1]": setting["ThtlCmd"],
    }
    conditions = {
        "h-sl-ft": model.height / FOOT,
        "phi-rad": start["Phi"],
        "theta-rad": start["Theta"],
        "psi-true-rad": 0.0,
        "u-fps": forward * np.cos(start["Alpha"]),
        "v-fps": start["Vt"] * np.sin(start["Beta"]),
        "w-fps": forward * np.sin(start["Alpha"]),
        "p-rad_sec": start["P"],
        "q-rad_sec": start["Q"],
        "r-rad_sec": start["R"],
    }
    for path, value in (*controls.items(), *((f"ic/{k}", v) for k, v in conditions.items())):
        fdm[path] = value
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    for path, value in controls.items():
        fdm[path] = value
    flown = []
    for _ in range(round(seconds / STEP)):
        flown.append([fdm[PATHS[state]] for state in STATES])
        fdm.run()
    return np.array(flown)


@pytest.mark.parametrize(
    ("changed", "moved"),
    [
        (_changed(Vt=2.0, Alpha=0.01, Q=0.02), LONGITUDINAL),
        (_changed(Beta=0.01, Phi=0.01, P=0.02), ("Beta", "Phi", "P", "R")),
    ],
    ids=["longitudinal", "lateral"],
)
def test_the_model_has_the_free_response_of_the_airplane(jet, changed, moved):
    flown = _free_flight(jet, changed, 4.0) - _free_flight(jet, np.zeros(8), 4.0)
    step = expm(jet.system_matrix * STEP)
    state, expected = changed, []
    for _ in flown:
        expected.append(state)
        state = step @ state
    for name in moved:
        one, other = flown[:, STATES.index(name)], np.array(expected)[:, STATES.index(name)]
        assert np.abs(one - other).max() < 0.04 * np.abs(other).max(), name


def test_the_matrix_has_the_kinematics_of_level_flight(jet):
    speed, _, pitch, *_ = jet.trim
    gravity = 32.174 * (1.0 + jet.height / 6.371e6) ** -2
    for row, column, expected in (
        ("Vt", "Theta", -gravity),
        ("Theta", "Q", 1.0),
        ("Phi", "P", 1.0),
        ("Phi", "R", np.tan(pitch)),
        ("Beta", "Phi", gravity * np.cos(pitch) / speed),
    ):
        found = jet.system_matrix[STATES.index(row), STATES.index(column)]
        assert found == pytest.approx(expected, rel=5e-3), (row, column)


def test_the_modes_are_the_eigenvalues_in_any_unit(jet):
    assert sorted(mode.name for mode in jet.modes) == NAMES
    pairs = [2.0 if mode.eigenvalue.imag else 1.0 for mode in jet.modes]
    total = sum(n * mode.eigenvalue.real for n, mode in zip(pairs, jet.modes, strict=True))
    assert total == pytest.approx(np.trace(jet.system_matrix), rel=1e-9)
    units = np.array([0.3048, 57.3, 57.3, 57.3, 57.3, 57.3, 57.3, 57.3])
    other = find_modes(jet.system_matrix * units[:, None] / units)
    assert [mode.name for mode in other] == [mode.name for mode in jet.modes]
    for mode, same in zip(jet.modes, other, strict=True):
        assert same.eigenvalue == pytest.approx(mode.eigenvalue, rel=1e-6, abs=1e-9)
        damped = mode.frequency * np.sqrt(1.0 - mode.damping**2)
        assert damped == pytest.approx(mode.eigenvalue.imag, rel=1e-6, abs=1e-6)
        assert np.exp(mode.eigenvalue.real * mode.half) == pytest.approx(0.5)


def test_a_pair_without_oscillation_and_a_coupled_mode_have_no_name_of_the_field(jet):
    system = jet.system_matrix.copy()
    system[STATES.index("Q"), STATES.index("Alpha")] = 0.2  # statically unstable
    assert [mode.name for mode in find_modes(system)].count("mode") >= 2
    turn = np.eye(8)
    pair = [STATES.index("Alpha"), STATES.index("Beta")]
    turn[np.ix_(pair, pair)] = np.array([[0.6, -0.8], [0.8, 0.6]])
    names = [mode.name for mode in find_modes(turn @ jet.system_matrix @ turn.T)]
    assert "coupled mode" in names
    assert "Dutch roll" not in names


def test_the_command_tells_level_flight_and_modes_in_both_voices(capsys):
    assert main(["aircraft", "performance", JET, "--linear", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert sorted(mode["name"] for mode in told["modes"]) == NAMES
    assert [len(row) for row in told["A"]] == 8 * [len(told["states"])]
    assert [len(row) for row in told["B"]] == 8 * [len(told["inputs"])]
    assert main(["aircraft", "performance", JET, "--linear"]) == 0
    text = capsys.readouterr().out
    assert f"{told['calibrated_airspeed_kt']:.1f} KCAS" in text
    for mode in told["modes"]:
        assert f"{mode['damping_ratio']:.3f}" in text


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("check", JET), "--linear is no flag of `aircraft check`"),
        (("performance", JET, "--handbook", "poh.csv"), "--handbook has no figure"),
        (("performance", "SGS"), "no engine that holds a level speed"),
        (("performance", "navajo"), "does not keep the engines running"),
        (("performance", "nosuch"), "nosuch"),
    ],
)
def test_what_has_no_linear_model_is_refused(words, problem, capsys):
    assert main(["aircraft", *words, "--linear"]) == 2
    assert problem in capsys.readouterr().err
