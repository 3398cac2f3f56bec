"""What another rate of integration changes: `python -m tests.simulation.rates` prints the table.

Two flights of one card at two rates are compared at the same time since the first recorded sample.
In gusts they fly through the same frozen field, which is not the simulator's: that draws its random
numbers step by step, so that at another rate it makes other gusts of the same kind.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from time import process_time
from unittest.mock import patch

import numpy as np

from pitotbench import Case, Flight, PlanRequest, fly
from pitotbench.bench import planner as forecasting
from pitotbench.calibration import calibrate
from pitotbench.campaigns.flights import sense
from pitotbench.records.case import USUAL_RATE, DataSystem
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.maneuvers import maneuvers_named
from pitotbench.units import DEGREE, FOOT, KNOT, Array
from pitotlab.blind.flown import Environment, flown

SYSTEMS = {50.0: "50/50", 40.0: "20/1"}  # by rate: a data system that it serves
CHANNELS = {"calibrated_airspeed": KNOT, "altitude": FOOT, "roll": DEGREE}
RECORDED = (*CALIBRATION_CHANNELS, "wind_north", "wind_east")
LOOK = 0.1  # s
AIRSPEEDS = np.arange(100.0, 161.0, 5.0) * KNOT


def differences(usual: Flight, other: Flight) -> list[float]:
    """Return the rms difference of each channel [kt, ft, deg] at the looks that both flights have."""
    rows = [
        np.arange(0, len(f), round(LOOK / np.median(np.diff(f["time"])))) for f in (usual, other)
    ]
    count = min(map(len, rows))
    return [
        float(
            np.sqrt(np.mean((other[name][rows[1][:count]] - usual[name][rows[0][:count]]) ** 2))
            / unit
        )
        for name, unit in CHANNELS.items()
    ]


def exact(system: DataSystem) -> DataSystem:
    """Return a data system whose sensors have neither noise nor resolution."""
    rough = [f for f in DataSystem.__dataclass_fields__ if f.endswith(("_noise", "_resolution"))]
    return replace(system, **dict.fromkeys(rough, 0.0))


def corrections(flight: Flight, system: DataSystem) -> tuple[Array, Array]:
    """Return the calibrated correction and its 2σ [kt] at the airspeeds."""
    curve = calibrate(sense(flight, system)).curve
    at = curve.indicated_airspeed
    return tuple(np.interp(AIRSPEEDS, at, y) / KNOT for y in (curve.correction, curve.two_sigma))  # type: ignore[return-value]


def _timed(case: Case, rate: float) -> tuple[Flight, float]:
    begun = process_time()
    flight = flown(case, Environment(rate=rate, own_gusts=True))
    return flight, process_time() - begun


def rows_of(maneuver: str, turbulence: str, seeds: int) -> dict[float, list[float]]:
    """Return a row of the table by rate: rms of the channels, rms and largest difference over 2σ,
    CPU times.
    """
    found: dict[float, list[tuple[list[float], Array, float, float]]] = {
        rate: [] for rate in SYSTEMS
    }
    for seed in range(1, seeds + 1):
        case = Case(maneuver=maneuver, turbulence=turbulence, truth_seed=seed, sensor_seed=seed)
        usual, seconds = _timed(case, USUAL_RATE)
        for rate, name in SYSTEMS.items():
            other, spent = _timed(case, rate)
            system = data_system(name)
            # Without noise: a flight that is a tick shorter would meet other noise, which is no
            # fault of the rate.
            before, after = (corrections(flight, exact(system))[0] for flight in (usual, other))
            share = np.abs(after - before) / corrections(usual, system)[1]
            found[rate].append((differences(usual, other), share, spent, seconds))
    return {rate: _row(flights) for rate, flights in found.items()}


def _row(flights: list[tuple[list[float], Array, float, float]]) -> list[float]:
    moved, shares, spent, seconds = (np.array(part) for part in zip(*flights, strict=True))
    ratio = spent.min() / seconds.min()
    return [*np.sqrt(np.mean(moved**2, axis=0)), np.sqrt(np.mean(shares**2)), shares.max(), ratio]


def own_turbulence(maneuver: str, rate: float, seeds: int) -> list[float]:
    """Return ratios of the flights at a rate to those at the usual one, in the simulator's own
    turbulence.

    They are those of the standard deviation of the gusts and of the mean 2σ, each with its standard
    error.
    """
    system = data_system(SYSTEMS[rate])
    gusts, bounds = [], []
    for seed in range(1, seeds + 1):
        case = Case(maneuver=maneuver, truth_seed=seed, sensor_seed=seed, das=system)
        pair = [
            fly(replace(case, integration_rate=r), channels=RECORDED) for r in (USUAL_RATE, rate)
        ]
        gusts.append(
            [np.sqrt(sum(np.var(f[f"wind_{axis}"]) for axis in ("north", "east"))) for f in pair]
        )
        bounds.append([corrections(f, system)[1].mean() for f in pair])
    return [part for pairs in (gusts, bounds) for part in _ratio(np.array(pairs))]


def _ratio(pairs: Array) -> tuple[float, float]:
    logs = np.log(pairs[:, 1] / pairs[:, 0])
    return float(np.exp(logs.mean())), float(logs.std(ddof=1) / np.sqrt(len(logs)))


def table(maneuvers: Sequence[str], seeds: int) -> Iterator[str]:
    """Yield the lines of the table of flights through the same gusts."""
    yield "| maneuver | gusts | rate, DAS [Hz] | airspeed [kt] | height [ft] | bank [°] | rms | largest | CPU |"
    yield "|---|---|---|---|---|---|---|---|---|"
    for maneuver in maneuvers:
        for turbulence in ("none", "light"):
            for rate, row in rows_of(
                maneuver, turbulence, 1 if turbulence == "none" else seeds
            ).items():
                figures = " | ".join(f"{value:.3f}" for value in row[:-1])
                yield f"| {maneuver} | {turbulence} | {rate:g}, {SYSTEMS[rate]} | {figures} | {row[-1]:.2f} |"


def table_of_own_turbulence(maneuvers: Sequence[str], seeds: int) -> Iterator[str]:
    """Yield the lines of the table of flights in the simulator's own turbulence."""
    yield "| maneuver | rate, DAS [Hz] | gusts, other / usual | 2σ, other / usual |"
    yield "|---|---|---|---|"
    for maneuver in maneuvers:
        for rate, name in SYSTEMS.items():
            gust, gust_error, bound, bound_error = own_turbulence(maneuver, rate, seeds)
            ratios = f"{gust:.3f} ± {gust_error:.3f} | {bound:.3f} ± {bound_error:.3f}"
            yield f"| {maneuver} | {rate:g}, {name} | {ratios} |"


def table_of_forecasts(maneuvers: Sequence[str], draws: int) -> Iterator[str]:
    """Yield the lines of the table of forecasts from flights at the slowest rate, relative to the
    usual one.
    """
    yield "| maneuver | DAS [Hz] | mean 2σ, other / usual | largest change at an airspeed | draw to draw (1σ) |"
    yield "|---|---|---|---|---|"
    for maneuver in maneuvers:
        for name in SYSTEMS.values():
            system = data_system(name)
            request = PlanRequest(Case(das=system), system, draws=draws)
            with patch.object(forecasting, "rates_for", lambda _: (USUAL_RATE,)):
                usual = forecasting.forecast(request, maneuver)
            other = forecasting.forecast(request, maneuver)
            largest = np.abs(other.two_sigma / usual.two_sigma - 1.0).max()
            spread = usual.spread / usual.mean
            yield f"| {maneuver} | {name} | {other.mean / usual.mean:.4f} | {largest:.4f} | {spread:.3f} |"


TABLES = {
    "same-gusts": table,
    "own-turbulence": table_of_own_turbulence,
    "forecasts": table_of_forecasts,
}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--seeds",
        type=int,
        default=6,
        help="flights a cell in gusts, draws a forecast (default: %(default)s)",
    )
    parser.add_argument(
        "--maneuver", default="all", help="a name, a list with commas (default: %(default)s)"
    )
    parser.add_argument(
        "--of",
        choices=TABLES,
        default="same-gusts",
        help="flights through the same gusts, flights in the simulator's own, or forecasts "
        "(default: %(default)s)",
    )
    options = parser.parse_args()
    make = TABLES[options.of]
    for line in make(maneuvers_named(options.maneuver), options.seeds):
        print(line, flush=True)


if __name__ == "__main__":
    main()
