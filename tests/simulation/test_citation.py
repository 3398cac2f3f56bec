"""TU Delft's Citation: the loaded model has the published derivatives, and it flies level."""

import numpy as np
import pytest
from scipy.optimize import root

from pitotbench.simulation.aircraft import known_aircraft
from pitotbench.simulation.aircraft_files import load_fdm
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.properties import POUND_FORCE, SLUG
from pitotbench.units import FOOT, KNOT, POUND, PSF

# TU Delft, linear model of the Cessna Citation II (lecture notes of J. A. Mulder et al., Flight
# Dynamics, 2013). Signs and dimensionless rates are those of the source: c/V with pitch and alpha
# rate, b/2V with roll and yaw rate.
PUBLISHED = {
    "X": {"alpha rate": 0.08330, "pitch rate": -0.28170, "elevator": -0.03728},
    "Z": {"alpha": -5.74340, "alpha rate": -0.00350, "pitch rate": -5.66290, "elevator": -0.69612},
    "m": {"alpha": -0.5626, "alpha rate": 0.17800, "pitch rate": -8.79415, "elevator": -1.1642},
    "Y": {
        "beta": -0.7500,
        "roll rate": -0.0304,
        "yaw rate": 0.8495,
        "aileron": -0.0400,
        "rudder": 0.2300,
    },
    "l": {
        "beta": -0.10260,
        "roll rate": -0.71085,
        "yaw rate": 0.23760,
        "aileron": -0.23088,
        "rudder": 0.03440,
    },
    "n": {
        "beta": 0.1348,
        "roll rate": -0.0602,
        "yaw rate": -0.2061,
        "aileron": -0.0120,
        "rudder": -0.0939,
    },
}
AREA, SPAN, CHORD = 30.00, 15.911, 2.0569  # m², m, m
# Level flight before the log's Dutch roll; true airspeed.
SPEED, ALPHA, HEIGHT = 95.3, np.radians(5.29), 10_100 * FOOT
# One step a variable; the bank moves the alpha rate alone.
STEPS = {
    **dict.fromkeys(("alpha", "beta"), 0.01),
    **dict.fromkeys(("roll rate", "pitch rate", "yaw rate"), 0.05),
    **dict.fromkeys(("elevator", "aileron", "rudder"), 0.2),
    "bank": 1.0,
}


class Balance:
    """The loaded model, put into one state after another."""

    def __init__(self) -> None:
        self.fdm, _ = load_fdm("citation", known_aircraft()["citation"], 100.0)
        self.fdm["gear/gear-cmd-norm"] = 0.0

    def place(self, **moved: float) -> None:
        """Put the model into a state that differs from level flight."""
        now = dict.fromkeys(STEPS, 0.0) | moved
        alpha, beta = ALPHA + now["alpha"], now["beta"]
        fdm, speed = self.fdm, SPEED / FOOT
        for path, value in {
            "h-sl-ft": HEIGHT / FOOT,
            "phi-rad": now["bank"],
            "theta-rad": alpha,
            "u-fps": speed * np.cos(alpha) * np.cos(beta),
            "v-fps": speed * np.sin(beta),
            "w-fps": speed * np.sin(alpha) * np.cos(beta),
            "p-rad_sec": now["roll rate"],
            "q-rad_sec": now["pitch rate"],
            "r-rad_sec": now["yaw rate"],
        }.items():
            fdm[f"ic/{path}"] = value
        for control in ("elevator", "aileron", "rudder"):
            fdm[f"fcs/{control}-cmd-norm"] = now[control]
        fdm["gear/gear-pos-norm"] = 0.0  # JSBSim begins with the gear down
        for _ in range(3):  # the alpha rate that the forces read is that of the last run
            fdm.run_ic()

    def measure(self, **moved: float) -> tuple[dict[str, float], dict[str, float]]:
        """Return the variables of the source and the coefficients in a state that differs from
        level flight.
        """
        self.place(**moved)
        fdm = self.fdm
        x, y, z = (fdm[f"forces/fb{axis}-aero-lbs"] * POUND_FORCE for axis in "xyz")
        moments = [fdm[f"moments/{axis}-aero-lbsft"] * POUND_FORCE * FOOT for axis in "lmn"]
        scale = fdm["aero/qbar-psf"] * PSF * AREA
        lengths = (SPAN, CHORD, SPAN)
        found = {
            "X": (x * np.cos(ALPHA) + z * np.sin(ALPHA)) / scale,
            "Y": y / scale,
            "Z": (z * np.cos(ALPHA) - x * np.sin(ALPHA)) / scale,
            **{
                axis: m / scale / length
                for axis, m, length in zip("lmn", moments, lengths, strict=True)
            },
        }
        where = {
            "alpha": fdm["aero/alpha-rad"],
            "beta": fdm["aero/beta-rad"],
            "alpha rate": fdm["aero/alphadot-rad_sec"] * CHORD / SPEED,
            "pitch rate": fdm["velocities/q-aero-rad_sec"] * CHORD / SPEED,
            "roll rate": fdm["velocities/p-aero-rad_sec"] * SPAN / 2 / SPEED,
            "yaw rate": fdm["velocities/r-aero-rad_sec"] * SPAN / 2 / SPEED,
            "elevator": fdm["fcs/elevator-pos-rad"],
            "aileron": -fdm["fcs/left-aileron-pos-rad"],  # positive rolls left in the source
            "rudder": fdm["fcs/rudder-pos-rad"],
        }
        return where, found


@pytest.fixture(scope="module")
def balance() -> Balance:
    return Balance()


def test_finite_differences_give_the_published_derivatives(balance):
    sides = [
        [
            balance.measure(**{name: end})
            for end in ((step, 0.0) if name == "bank" else (step, -step))
        ]
        for name, step in STEPS.items()
    ]
    names = list(PUBLISHED["Z"] | PUBLISHED["l"])
    states = np.array([[up[0][name] - down[0][name] for name in names] for up, down in sides])
    for axis, published in PUBLISHED.items():
        slopes = np.linalg.solve(states, [up[1][axis] - down[1][axis] for up, down in sides])
        found = dict(zip(names, slopes, strict=True))
        assert {name: found[name] for name in published} == pytest.approx(published, rel=0.01)


def test_the_trimmed_state_is_that_of_the_log(balance):
    _, found = balance.measure()
    assert found["Z"] == pytest.approx(-0.494, abs=0.005)
    assert found["X"] == pytest.approx(-0.0515, abs=0.001)
    assert found["m"] == pytest.approx(0.0, abs=0.001)


def test_mass_and_inertia_are_those_of_mid_flight(balance):
    balance.measure()
    mass = balance.fdm["inertia/mass-slugs"] * SLUG
    assert mass == pytest.approx(6242.0, abs=5.0)
    found = [
        balance.fdm[f"inertia/i{axes}-slugs_ft2"] * SLUG * FOOT**2
        for axes in ("xx", "yy", "zz", "xz")
    ]
    # The last is the element of the tensor: less the product.
    expected = [0.019 * SPAN**2, 1.3925 * CHORD**2, 0.042 * SPAN**2, -0.002 * SPAN**2]
    assert found == pytest.approx([mass * each for each in expected], rel=0.01)


def test_its_free_motions_take_as_long_as_those_of_the_log(balance):
    """Phugoid 45 s and Dutch roll 3.2 s in the log; 50.8 and 3.0 s by the derivatives at constant
    density.
    """
    fdm = balance.fdm
    fdm["propulsion/set-running"] = -1

    def imbalance(x):
        for path in ("fcs/throttle-cmd-norm", "fcs/throttle-cmd-norm[1]"):
            fdm[path] = x[2]
        balance.place(alpha=x[0], elevator=x[1])
        return [
            fdm[f"accelerations/{axis}"]
            for axis in ("udot-ft_sec2", "wdot-ft_sec2", "qdot-rad_sec2")
        ]

    trimmed = root(imbalance, [0.0, 0.0, 0.6], options={"eps": 1e-6})
    assert trimmed.success

    def period(
        control: str, pulse: float, until: float, path: str, seconds: float
    ) -> tuple[float, float]:
        """Return the mean time between the maxima of a free motion after a pulse, and their ratio."""
        imbalance(trimmed.x)
        level, seen = fdm[path], []
        for k in range(round(seconds * 100)):
            fdm[control] = (trimmed.x[1] if "elevator" in control else 0.0) + pulse * (
                k < until * 100
            )
            fdm.run()
            seen.append(fdm[path] - level)
        after = np.array(seen[round((until + 1.0) * 100) :])
        top = np.flatnonzero((after[1:-1] > after[:-2]) & (after[1:-1] >= after[2:])) + 1
        return float(np.diff(top).mean() / 100.0), float(after[top[1]] / after[top[0]])

    phugoid = period("fcs/elevator-cmd-norm", 0.03, 8.0, "velocities/vc-kts", 120.0)
    dutch_roll = period("fcs/rudder-cmd-norm", 0.2, 1.0, "aero/beta-rad", 10.0)
    assert phugoid[0] == pytest.approx(50.0, abs=2.0)
    assert 0.5 < phugoid[1] < 0.8
    assert dutch_roll[0] == pytest.approx(3.02, abs=0.1)
    assert 0.3 < dutch_roll[1] < 0.6


@pytest.mark.parametrize(
    ("height_ft", "speed_kt"),
    [(5000, 160), (5000, 220), (18000, 160), (18000, 220), (10_100, 159.2)],
)
def test_it_flies_level(height_ft, speed_kt):
    plant = Plant.load("citation")
    plant.start(height_ft * FOOT, speed_kt * KNOT)
    plant.run(20.0)
    assert plant.get("calibrated_airspeed") / KNOT == pytest.approx(speed_kt, abs=1.0)
    assert plant.get("altitude") / FOOT == pytest.approx(height_ft, abs=20.0)
    assert abs(plant.get("roll")) < np.radians(0.5)
    if (
        height_ft * FOOT == HEIGHT
    ):  # as in the log before the Dutch roll, by the mean fuel flow of both engines
        assert plant.get("angle_of_attack") == pytest.approx(ALPHA, abs=np.radians(0.2))
        assert plant.get("elevator") == pytest.approx(np.radians(-0.04), abs=np.radians(0.2))
        assert plant.get("fuel_flow_left") == pytest.approx(438.0 * POUND / 3600.0, rel=0.06)
