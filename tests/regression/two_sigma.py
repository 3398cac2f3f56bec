"""The 2σ results of every maneuver, data system and model for fixed seeds, and of logs from a
formula:
`PYTHONPATH=../calibrate python two_sigma.py > two_sigma.csv`, `... two_sigma.py formula >
formula_two_sigma.csv`.

Run it only for a change that is meant to move the numbers, and say in the commit which moved and
why.
"""

import sys
from collections.abc import Iterator

import numpy as np
import pandas as pd
from tests.calibration import trajectories

from pitotbench import CalibrationOptions, Case, Flight, FlightLog, air, fly
from pitotbench.calibration import calibrate
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.units import KNOT

SYSTEMS = ("20/1", "50/50", "100/100")
MODELS = ("bias", "linear", "quadratic", "inverse+")
SENSOR_SEED = 1
LOW, HIGH = 100.0 * KNOT, 160.0 * KNOT


def rows(flight: Flight) -> Iterator[dict[str, object]]:
    """One row a data system and model: 2σ of the residual, mean bound and mean correction, 100 to
    160 KIAS.
    """
    for system in SYSTEMS:
        log = record(flight, data_system(system), SENSOR_SEED)
        for figures in _figures(log):
            yield {
                "maneuver": flight.case.maneuver,
                "turbulence": flight.case.turbulence,
                "das": system,
                **figures,
            }


def formula_rows() -> Iterator[dict[str, object]]:
    """The same of a decelerating log in light air whose gusts NumPy draws: alike on every platform."""
    for system in SYSTEMS:
        rate, gps_rate = (int(part) for part in system.split("/"))
        log = trajectories.fly(trajectories.step_decrease(rate), rate, gps_rate, trajectories.Air())
        for figures in _figures(log):
            yield {"das": system, **figures}


def _figures(log: FlightLog) -> Iterator[dict[str, object]]:
    """One row a model."""
    for model in MODELS:
        result = calibrate(log, CalibrationOptions(model=model))
        speed = result.curve.indicated_airspeed
        inside = (speed > LOW - 0.01) & (speed < HIGH + 0.01)
        yield {
            "model": model,
            "residual_two_sigma_kt": result.residual_two_sigma / KNOT,
            "two_sigma_kt": float(np.mean(result.curve.two_sigma[inside])) / KNOT,
            "correction_kt": float(np.mean(result.curve.correction[inside])) / KNOT,
        }


def turbulence_mark(flight: Flight) -> float:
    """A number that depends on the random generator of the platform's C++ library: mean true
    airspeed [m/s].
    """
    return float(
        np.mean(air.calibrated_airspeed(flight["total_pressure"] - flight["static_pressure"]))
    )


if __name__ == "__main__":
    if sys.argv[1:] == ["formula"]:
        table = pd.DataFrame(formula_rows())
    else:
        cases = [
            Case(maneuver=name, turbulence=level)
            for level in ("none", "light")
            for name in PAPER_MANEUVERS
        ]
        table = pd.DataFrame(row for case in cases for row in rows(fly(case)))
    table.to_csv(sys.stdout, index=False, float_format="%.5f", lineterminator="\n")
