"""Do the bounds cover? Many flights with random truth in every cell; the noise stays unknown to the estimator."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from pitotbench import bench
from pitotbench.bench.flight_store import FlightStore
from pitotbench.evidence.bounds.figures import rms
from pitotbench.evidence.bounds.scorings import SCORINGS, Scoring
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case, PressureErrorSpec, Wind
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.units import KNOT, Array

TURBULENCE = ("none", "light", "moderate")
FIRST_SCORED_SEED = 100_001  # development uses seeds below; the two never meet
STRONGEST_WIND = 25.0 * KNOT

# Random truth: the default curve's terms, each times a random size (standard deviations below).
_CALM_FLIGHTS = 20
_CENTER = np.array([-0.06, 0.006, 0.06])
_SPREAD = np.array([0.03, 0.004, 0.03])


@dataclass(frozen=True, slots=True)
class Trial:
    """One flight of the coverage campaign."""

    maneuver: str
    turbulence: str
    seed: int

    def case(self) -> Case:
        """The case, its wind and its pressure error drawn from the trial's seed.

        In calm air only the sensors are random: 20 flights, each in its own wind, are sensed again and again.
        """
        calm = self.turbulence == "none"
        flown = FIRST_SCORED_SEED + (self.seed - FIRST_SCORED_SEED) % _CALM_FLIGHTS if calm else self.seed
        rng = np.random.default_rng([self.seed, 77])
        _random_wind(rng)
        parameters = tuple(float(k) for k in _CENTER + _SPREAD * rng.standard_normal(3))
        return Case(
            maneuver=self.maneuver,
            turbulence=self.turbulence,
            wind=_random_wind(np.random.default_rng([flown, 77])),
            pressure_error=PressureErrorSpec(parameters=parameters),
            truth_seed=flown,
            sensor_seed=self.seed,
        )


def _random_wind(rng: np.random.Generator) -> Wind:
    speed, direction = STRONGEST_WIND * np.sqrt(rng.uniform()), rng.uniform(0.0, 2.0 * np.pi)
    return Wind(speed=float(speed), from_direction=float(direction))


def trials(maneuvers: Sequence[str], seeds: int, first: int = FIRST_SCORED_SEED) -> list[Trial]:
    """All trials, seed by seed, so that a campaign cut short has every cell equally often."""
    return [Trial(m, t, s) for s in range(first, first + seeds) for m in maneuvers for t in TURBULENCE]


def score_trial(
    trial: Trial, store: FlightStore | None = None, asked: Sequence[str] = tuple(SCORINGS)
) -> list[dict[str, object]]:
    """Fly a trial once, sense it by every data system, calibrate as every asked scoring says; one row each."""
    case = trial.case()
    flight = bench.fly(case) if store is None else store.fly(case)
    return [row for name in asked for row in _rows(trial, flight, SCORINGS[name])]


def _rows(trial: Trial, flight: Flight, scoring: Scoring) -> Iterator[dict[str, object]]:
    flown, wind = scoring.blow(flight, trial.seed)
    for system in scoring.systems:
        log = scoring.spoil(bench.sense(flown, system), trial.seed)
        base = {"scoring": scoring.name, **_cell(trial), "das": system, "seed": trial.seed}
        try:
            ours = bench.calibrate(log, scoring.options)
            paper = (
                bench.calibrate(log, bench.CalibrationOptions(method="paper")) if scoring.against_paper else ours
            )
        except NoAnswerError as error:
            yield base | {"failed": str(error)}
            continue
        yield base | {"failed": ""} | _figures(flown, wind, ours, paper)


def _cell(trial: Trial) -> dict[str, object]:
    return {"maneuver": trial.maneuver, "turbulence": trial.turbulence}


def _figures(flight: Flight, wind: Array, ours: Calibration, paper: Calibration) -> dict[str, object]:
    curve, inside = ours.curve, bench.scored(ours.curve)
    truth = bench.true_correction(flight.case.pressure_error, curve.indicated_airspeed)
    error, bound = (curve.correction - truth)[inside], curve.two_sigma[inside]
    published = (paper.curve.correction - truth)[inside]
    wind_error = np.array([ours.wind.north.value, ours.wind.east.value]) - wind
    wind_bound = np.array([ours.wind.north.two_sigma, ours.wind.east.two_sigma])
    return {
        "coverage": float(np.mean(np.abs(error) <= bound)),
        "band_coverage": float(np.all(np.abs(error) <= curve.simultaneous_two_sigma[inside])),
        "white_coverage": float(np.mean(np.abs(error) <= curve.white_two_sigma[inside])),
        "wind_coverage": float(np.mean(np.abs(wind_error) <= wind_bound)),
        "two_sigma_kt": float(np.mean(bound)) / KNOT,
        "mean_error_kt": float(np.mean(error)) / KNOT,
        "rms_error_kt": float(np.sqrt(np.mean(error**2))) / KNOT,
        "paper_rms_error_kt": float(np.sqrt(np.mean(published**2))) / KNOT,
        "residual_two_sigma_kt": ours.residual_two_sigma / KNOT,
        "finite": bool(np.all(np.isfinite(bound)) and np.all(bound > 0.0)),
    }


def summarize(rows: pd.DataFrame) -> pd.DataFrame:
    """One line a cell: shares [%] with their standard errors, errors and bounds [kt]."""
    good = rows[rows["failed"] == ""]
    groups = good.groupby(["scoring", "maneuver", "turbulence", "das"], sort=False)
    table = pd.DataFrame({"flights": groups.size()})
    for name in ("coverage", "band_coverage", "wind_coverage", "white_coverage"):
        table[f"{name}_percent"] = 100.0 * groups[name].mean()
    table["coverage_se_percent"] = 100.0 * groups["coverage"].sem()
    table["two_sigma_kt"] = groups["two_sigma_kt"].mean()
    for name in ("rms_error_kt", "paper_rms_error_kt"):
        table[name] = groups[name].apply(rms)
    table["bias_kt"] = groups["mean_error_kt"].mean()
    table["bias_over_se"] = groups["mean_error_kt"].mean() / groups["mean_error_kt"].sem()
    table["residual_two_sigma_kt"] = groups["residual_two_sigma_kt"].mean()
    return table.reset_index()
