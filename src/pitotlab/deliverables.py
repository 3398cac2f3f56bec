"""Measure how well the parameters written for autopilots correct the airspeed."""

from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import options_from
from pitotbench.campaigns.flights import rms, sense
from pitotbench.logbook.columns import PARAMETERS
from pitotbench.logbook.mapping import find_mapping
from pitotbench.pressure_error import REFERENCE_PRESSURE
from pitotbench.pressure_error.autopilot_settings import autopilot_settings
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.case import Case, DataSystem, PressureErrorSpec, Wind
from pitotbench.sensing.recorder import known_curve
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.sortie import fly, scaled_case
from pitotbench.units import DEGREE, FOOT, KNOT, Array
from pitotlab.experiment import CENTER, FIRST_SCORED_SEED, SPREAD, Row
from pitotlab.sets import wilson

# The air data of a small autopilot: a membrane sensor, a barometer, and a receiver with five fixes
# a second.
SYSTEM = DataSystem(
    air_rate=10.0, gps_rate=5.0, impact_pressure_noise=4.0, impact_pressure_range=6895.0, static_pressure_noise=5.0,
    altitude_noise=1.0, altitude_drift=2.0, velocity_noise=0.1, vertical_velocity="recorded",
)  # fmt: skip
CARD = {"speeds_kt": (76.0, 66.0, 56.0, 46.0)}  # slower circles stall in gusts
# 1σ: of a scale [-], of a zero [Pa], of the day's temperature [K].
GAIN, ZERO, DAY = 0.05, 30.0, 5.0
# What the flights have: the error, the autopilots whose formulas are applied, and the model of the
# calibration.
KINDS = {
    "scale and offset": ("bias", ("ardupilot", "px4"), "bias"),
    "Inverse+": ("inverse+", ("ardupilot",), "bias"),
    "Inverse+, --model auto": ("inverse+", ("ardupilot",), "auto"),
}


def shown(name: str, values: Mapping[str, float], sensor: Array) -> Array:
    """Return the airspeed [m/s] that an autopilot shows of its sensor's pressure [Pa], by its own
    formula.

    ArduPilot: AP_Airspeed.cpp, `AP_Airspeed::read`. PX4: airspeed.cpp, `calc_IAS` and
    `calc_CAS_from_IAS`.
    """
    if name == "ardupilot":
        pressure = np.maximum(sensor - values["ARSPD_OFFSET"], 0.0)
        return np.asarray(np.sqrt(pressure * values["ARSPD_RATIO"]))
    pressure = np.maximum(sensor - values["SENS_DPRES_OFF"], 0.0)
    return np.asarray(values["ASPD_SCALE_1"] * np.sqrt(2.0 * pressure / 1.225))


def parameter_rows(seed: int, kind: str) -> list[Row]:
    """Fly the aerosonde once with an error drawn from the seed; return a row for each autopilot and
    airspeed.

    The sensor has a scale, a zero and, in two kinds, an Inverse+ pressure error. The log has no
    temperature, as those of autopilots. Its airspeed is shown with wrong old parameters. No row for
    a flight that departed.
    """
    rng = np.random.default_rng([seed, 34])
    scale, zero = 1.0 + GAIN * rng.standard_normal(), ZERO * rng.standard_normal()
    old_gain, old_zero = 1.0 + GAIN * rng.standard_normal(), zero + ZERO * rng.standard_normal()
    curve = CENTER + SPREAD * rng.standard_normal(3)
    truth, autopilots, model = KINDS[kind]
    known = {"bias": (0.0,), "inverse+": tuple(float(k) for k in curve)}
    error = PressureErrorSpec(truth, known[truth], REFERENCE_PRESSURE)
    wind = Wind(float(8.0 * np.sqrt(rng.uniform())), float(360.0 * DEGREE * rng.uniform()))
    case = Case(
        aircraft="aerosonde", maneuver="circle", card=CARD, altitude=1500.0 * FOOT, turbulence="light", wind=wind,
        temperature_offset=DAY * float(rng.standard_normal()), pressure_error=error, das=SYSTEM,
        truth_seed=seed, sensor_seed=seed,
    )  # fmt: skip
    case = scaled_case(case)
    try:
        log = sense(fly(case), SYSTEM)
    except SimulationError:  # the autopilot of the bench loses the small airplane in a gust
        return []
    ratio = 2.0 / 1.225 * old_gain
    old = {
        "ardupilot": {"ARSPD_RATIO": ratio, "ARSPD_OFFSET": old_zero, "ARSPD_TYPE": 1.0},
        "px4": {"ASPD_SCALE_1": float(np.sqrt(old_gain)), "SENS_DPRES_OFF": old_zero},
    }
    true_curve = known_curve(case.pressure_error)
    rows: list[Row] = []
    for name in autopilots:
        held = old[name]
        speed = shown(name, held, scale * log.impact_pressure + zero)
        # The log as the autopilot would write it: what it measures, and its parameters.
        flown = replace(
            log,
            impact_pressure=np.asarray(air.impact_pressure(speed)),
            total_temperature=None,
            header={PARAMETERS: dict(held)},
        )
        row: Row = {"kind": kind, "seed": seed, "autopilot": name}
        advised = {"latency": "checked", "wind": "checked", **find_mapping(name).calibrate}
        try:
            found = autopilot_settings(
                calibrate(flown, options_from(advised | {"model": model})), name
            )
        except (BadInputError, NoAnswerError) as reason:
            rows.append(row | {"failed": " ".join(str(reason).split())})
            continue
        new = {each.name: each.value for each in found.settings}
        impact = np.asarray(air.impact_pressure(found.calibrated_airspeed))
        sensor = scale * true_curve.indicated_impact_pressure(impact) + zero
        left = found.calibrated_airspeed - shown(name, new, sensor)
        before = found.calibrated_airspeed - shown(name, held, sensor)
        for place, (error_left, bound) in enumerate(zip(left, found.bound, strict=True)):
            rows.append(
                row | {
                    "failed": "", "place": place, "middle": place == len(left) // 2,
                    "left_kt": error_left / KNOT, "bound_kt": bound / KNOT, "before_kt": before[place] / KNOT,
                    "whole": bool(np.all(np.abs(left) <= found.bound)),
                }
            )  # fmt: skip
    return rows


def parameters_table(rows: pd.DataFrame) -> str:
    """Return how often the correction that remains lies inside its bound, and its size, as text."""
    lines = []
    for (kind, name), group in rows.groupby(["kind", "autopilot"], sort=False):
        good = group[group["failed"] == ""]
        if not len(good):
            lines.append(f"{kind} | {name}: no flight has an answer")
            continue
        inside = good["left_kt"].abs() <= good["bound_kt"]
        middle = inside[good["middle"].astype(bool)]
        whole = good.groupby("seed")["whole"].first()
        low, high = wilson(int(middle.sum()), len(middle))
        failed = int((group["failed"] != "").sum())
        before, left = (rms(good[column]) for column in ("before_kt", "left_kt"))
        lines.append(
            f"{kind} | {name}: {good['seed'].nunique()} flights, {failed} without an answer | in "
            f"the middle inside {int(middle.sum())} of {len(middle)} ({low:.0%} to {high:.0%}) | "
            f"all airspeeds {inside.mean():.1%} of {len(inside)} | whole curve {int(whole.sum())} "
            f"of {len(whole)} | rms before {before:.2f} kt, remaining {left:.2f} kt, mean bound "
            f"{good['bound_kt'].mean():.2f} kt"
        )
        lines += [f"  {r.seed}: {r.failed}" for r in group[group["failed"] != ""].itertuples()]
    return "\n".join(lines)


def parameters_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Apply the formulas of ArduPilot and PX4, with the parameters of `--params`, to flights of the
    aerosonde.

    Prints how often the correction that remains lies inside its bound. About 2 CPU seconds a
    flight.
    """
    add = parser.add_argument
    add("--flights", type=int, default=40, help="flights of each kind (default: %(default)s)")
    add("--first", type=int, default=FIRST_SCORED_SEED, help="first seed (default: %(default)s)")
    options = parser.parse_args(words)
    rows: list[Row] = []
    for kind in KINDS:
        flown, seed = 0, options.first
        while flown < options.flights:
            found = parameter_rows(seed, kind)
            rows += found
            flown, seed = flown + bool(found), seed + 1
        print(
            f"{kind}: {flown} flights from seeds {options.first} to {seed - 1}; the others "
            "departed in a gust"
        )
    print(parameters_table(pd.DataFrame(rows)))
