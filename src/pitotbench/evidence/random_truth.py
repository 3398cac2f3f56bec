"""Draw the truth of a trial from its seed: a wind and a pressure error, for the flights that prove the bounds."""

import numpy as np

from pitotbench.evidence.experiment import Trial
from pitotbench.records.case import Case, PressureErrorSpec, Wind
from pitotbench.units import KNOT, Array

FIRST_SCORED_SEED = 100_001  # development uses only seeds below this one
STRONGEST_WIND = 25.0 * KNOT
# The parameters of the error curve: those of the default curve, and their standard deviations.
CENTER = np.array(PressureErrorSpec().parameters)
SPREAD = np.array([0.03, 0.004, 0.03])
_CALM_FLIGHTS = 20


def random_parameters(rng: np.random.Generator) -> Array:
    """Draw the parameters of an Inverse+ error curve, (3,)."""
    return np.asarray(CENTER + SPREAD * rng.standard_normal(3))


def random_case(trial: Trial) -> Case:
    """Return the case of a trial, with its wind and its pressure error drawn from the seed.

    In calm air 20 flights in different winds are reused: only the sensor noise and the pressure error are new.
    """
    calm = trial.turbulence == "none"
    flown = FIRST_SCORED_SEED + (trial.seed - FIRST_SCORED_SEED) % _CALM_FLIGHTS if calm else trial.seed
    rng = np.random.default_rng([trial.seed, 77])
    # The wind of the flight comes from the seed that is flown, below. This draw is not used: it takes the first two
    # numbers of the stream, so that the parameters are those with which the committed campaign was flown.
    _random_wind(rng)
    parameters = tuple(float(k) for k in random_parameters(rng))
    return Case(
        maneuver=trial.maneuver,
        turbulence=trial.turbulence,
        wind=_random_wind(np.random.default_rng([flown, 77])),
        pressure_error=PressureErrorSpec(parameters=parameters),
        truth_seed=flown,
        sensor_seed=trial.seed,
    )


def _random_wind(rng: np.random.Generator) -> Wind:
    """Draw a wind of any direction, distributed evenly over a disk of velocities."""
    speed, direction = STRONGEST_WIND * np.sqrt(rng.uniform()), rng.uniform(0.0, 2.0 * np.pi)
    return Wind(speed=float(speed), from_direction=float(direction))
