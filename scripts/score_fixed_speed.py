"""How often fixed-speed points from simulated logs hold the truth: `python scripts/score_fixed_speed.py --seeds 10`."""

import argparse
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pitotbench.bench import fixed_speed_points, fly, sense, true_correction, wind_toward
from pitotbench.records.case import Case, Wind
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT, Array

WAYS: dict[str, tuple[str, Callable[[FlightLog], FlightLog]]] = {
    "four legs, labeled": ("four_leg", lambda log: log),
    "four legs, found": ("four_leg", lambda log: replace(log, segment=None, on_condition=None)),
    "three legs, labeled": ("four_leg", lambda log: log.select(np.char.find(log.segment, "270°") < 0)),
    "turn, labeled": ("circle", lambda log: log),
    "turn, found": ("circle", lambda log: replace(log, segment=None, on_condition=None)),
}


def case_of(maneuver: str, turbulence: str, seed: int) -> Case:
    """A case with a wind of its own, up to 25 kt from anywhere."""
    rng = np.random.default_rng(7000 + seed)
    wind = Wind(speed=rng.uniform(0.0, 25.0) * KNOT, from_direction=rng.uniform(0.0, 2.0 * np.pi))
    return Case(maneuver=maneuver, turbulence=turbulence, truth_seed=seed, sensor_seed=seed, wind=wind)


def errors(case: Case, log: FlightLog) -> Array:
    """A row a point: error, 2σ and spread of the airspeed, larger error and 2σ of the wind [kt]."""
    points, wind = fixed_speed_points(log), wind_toward(case.wind)
    truth = true_correction(case.pressure_error, np.array([p.indicated_airspeed for p in points]))
    off = [max(abs(p.wind_north - wind[0]), abs(p.wind_east - wind[1])) for p in points]
    spread = [np.nan if p.spread is None else p.spread for p in points]
    columns = [p.correction for p in points] - truth, [p.two_sigma for p in points], spread, off
    return np.column_stack([*columns, [p.wind_two_sigma for p in points]]) / KNOT


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--das", default="50/50")
    options = parser.parse_args()
    for turbulence in ("none", "light"):
        rows: dict[str, list[Array]] = {way: [] for way in WAYS}
        for maneuver in ("four_leg", "circle"):
            for seed in range(1, options.seeds + 1):
                case = case_of(maneuver, turbulence, seed)
                log = sense(fly(case), options.das)
                for way, (flown, seen) in WAYS.items():
                    if flown == maneuver:
                        rows[way].append(errors(case, seen(log)))
        for way, found in rows.items():
            error, bound, spread, wind, wind_bound = np.concatenate(found).T
            print(
                f"{turbulence:5s} | {way:19s} | {len(error):3d} points | inside {np.mean(abs(error) <= bound):4.0%} | "
                f"mean {error.mean():+.3f} rms {np.sqrt(np.mean(error**2)):.3f} 2σ {bound.mean():.3f} kt | "
                f"wind inside {np.mean(wind <= wind_bound):4.0%} | 2 spreads hold {np.mean(abs(error) <= 2 * spread):4.0%}"
            )


if __name__ == "__main__":
    main()
