"""Evidence without flying: every reduction of the plan gets the numbers that a function makes up."""

from collections.abc import Callable

import numpy as np

from pitotlab.study.conduct import plan_sorties
from pitotlab.study.measures import DENSITY_EDGES, TRAVEL, Measured, reduction_row
from pitotlab.study.reductions import BOTH_WAYS, Reduction, Sortie
from pitotlab.study.tables import StudyTables

FLOWN = ("step_decrease", "race_track", "four_leg", "circle", "rapid_decel", BOTH_WAYS)
MINUTES = dict(zip(FLOWN, (6.0, 15.0, 21.0, 6.0, 5.0, 6.0), strict=True))
RATINGS = dict(zip(FLOWN, (3.0, 2.0, 3.0, 4.0, 2.0, 3.0), strict=True))
EFFORTS = (
    *(f"reversals_{control}" for control in TRAVEL),
    *("reversals_a_minute", "duty_percent", "out_of_tolerance_percent"),
)
Residual = Callable[[Sortie, Reduction], float]


def evidence(
    residual: Residual, minutes: dict[str, float] = MINUTES, seeds: int = 2, sweeps: bool = True
) -> StudyTables:
    """The tables of a study in which every residual 2σ is what a function says."""
    return StudyTables.of(
        [_measured(sortie, residual, minutes) for sortie in plan_sorties(seeds, sweeps)]
    )


def _measured(sortie: Sortie, residual: Residual, minutes: dict[str, float]) -> Measured:
    case, time = sortie.case, minutes[sortie.case.maneuver]
    key = {"setting": sortie.setting, "variant": sortie.variant}
    key |= {"maneuver": case.maneuver, "seed": case.truth_seed}
    rng = np.random.default_rng(case.truth_seed)
    flight = {
        "minutes": time,
        "vertical_speed_fpm": 50.0,
        "altitude_ft": 8.0,
        "turning_percent": 30.0,
        "slowing_kt_a_second": 1.0,
        **dict.fromkeys(EFFORTS, RATINGS[case.maneuver]),
    }
    curves = []
    if sortie.curves:
        for speed in (100.0, 130.0, 160.0):
            curves += [_point("paper", speed, 0.5) | {"on_condition": True}]
        curves += [_point("fixed speed", 120.0, 0.6)]
    density = [{"airspeed_kt": float(v), "seconds": 10.0} for v in DENSITY_EDGES[:-1] + 1.25]
    return Measured(
        fits=tuple(
            key | _fit(reduction, residual(sortie, reduction), time, rng)
            for reduction in sortie.reductions
        ),
        flights=(key | flight,),
        density=tuple(key | row for row in density),
        curves=tuple(key | row for row in curves),
    )


def _fit(
    reduction: Reduction, residual: float, minutes: float, rng: np.random.Generator
) -> dict[str, object]:
    outputs = [f"two_sigma_{axis}_kt" for axis in ("north", "east", "down")]
    kinds = [f"{kind}_two_sigma_kt" for kind in ("residual", "pooled", "smooth")]
    numbers = {
        "samples": 3000.0 * minutes,
        **dict.fromkeys([*kinds, *outputs], residual),
        "two_sigma_kt": 1.0 / minutes,
        "rms_error_kt": 0.3 / minutes * (1.0 + reduction.level),
        "coverage": 1.0,
        "wind_north_error_kt": rng.standard_normal(),
        "white_criterion": rng.standard_normal(),
        "block_criterion": rng.standard_normal(),
    }
    return reduction_row(reduction) | {"failed": ""} | numbers


def _point(kind: str, speed: float, value: float) -> dict[str, object]:
    numbers = {"two_sigma_kt": 0.2, "residual_two_sigma_kt": 0.9, "truth_kt": 0.4}
    return {"kind": kind, "airspeed_kt": speed, "correction_kt": value, **numbers}
