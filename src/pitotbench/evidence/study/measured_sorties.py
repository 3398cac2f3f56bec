"""Fly one sortie and measure it. This runs in any process."""

from dataclasses import dataclass

import numpy as np

from pitotbench import bench
from pitotbench.evidence.experiment import Row
from pitotbench.evidence.study.curve_points import curve_rows, data_rows, fixed_speed_rows
from pitotbench.evidence.study.looks import sense_look
from pitotbench.evidence.study.measures import density_rows, fit, flight_row
from pitotbench.evidence.study.settings import Sortie
from pitotbench.evidence.study.workload import TRAVEL
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense import CALIBRATION_CHANNELS
from pitotbench.units import NAUTICAL_MILE

_CHANNELS = (
    *CALIBRATION_CHANNELS, *TRAVEL, "position_north", "position_east", "calibrated_airspeed",
    "roll", "pitch", "heading", "angle_of_attack", "sideslip",
)  # fmt: skip
_TRACK_POINTS = 800


@dataclass(frozen=True, slots=True)
class Measured:
    """The rows of a sortie by table, and the failures in words."""

    fits: tuple[Row, ...] = ()
    flights: tuple[Row, ...] = ()
    density: tuple[Row, ...] = ()
    tracks: tuple[Row, ...] = ()
    curves: tuple[Row, ...] = ()
    failures: tuple[str, ...] = ()


def measure_sortie(sortie: Sortie) -> Measured:
    """Fly, sense, fit and measure a sortie. Raises BadInputError where the case cannot be flown."""
    case = sortie.case
    flight = bench.fly(case, channels=_CHANNELS)
    key: Row = {
        "setting": sortie.setting,
        "variant": sortie.variant,
        "maneuver": case.maneuver,
        "seed": case.truth_seed,
    }
    fits, curves = _fits(flight, sortie)
    return Measured(
        fits=tuple(key | row for row in fits),
        flights=(key | flight_row(flight),),
        density=tuple(key | row for row in density_rows(flight)) if case.truth_seed == 1 else (),
        tracks=tuple(key | row for row in _track(flight)) if sortie.track else (),
        curves=tuple(key | row for row in curves),
        failures=tuple(f"{' '.join(map(str, key.values()))}: {row['failed']}" for row in fits if row["failed"]),
    )


def lost_sortie(sortie: Sortie, reason: str) -> Measured:
    """Return the record of a sortie that gave no numbers, with the reason."""
    case = sortie.case
    return Measured(failures=(f"{case.maneuver} seed {case.truth_seed} {sortie.setting}: {reason}",))


def _fits(flight: Flight, sortie: Sortie) -> tuple[list[Row], list[Row]]:
    """Return one row for each look, and the points of the curves where the sortie asks for them."""
    logs: dict[tuple[object, ...], tuple[Flight, FlightLog]] = {}
    rows, curves = [], []
    for look in sortie.looks:
        if look.sensing not in logs:
            logs[look.sensing] = sense_look(flight, look)
        changed, log = logs[look.sensing]
        row, result = fit(changed, log, look)
        rows.append(row)
        if sortie.curves and result is not None:
            curves += curve_rows(changed, look, result)
            if look.options.method == "paper":
                curves += data_rows(log, look, result)
    if sortie.curves and flight.case.maneuver == "four_leg":
        curves += fixed_speed_rows(log)
    return rows, curves


def _track(flight: Flight) -> list[Row]:
    step = max(1, len(flight) // _TRACK_POINTS)
    rows = np.arange(0, len(flight), step)
    east, north = flight["position_east"][rows] / NAUTICAL_MILE, flight["position_north"][rows] / NAUTICAL_MILE
    on = flight.on_condition[rows]
    return [
        {"east_nm": float(e), "north_nm": float(n), "on_condition": bool(o)}
        for e, n, o in zip(east, north, on, strict=True)
    ]
