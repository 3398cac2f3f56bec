"""One simulated flight as a file of every format, read back, calibrated and compared with its CSV.

A file whose clock shows whole seconds holds the rows of whole seconds, as does its CSV.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from tests.logbook import foreign_files as foreign

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.sortie import fly
from pitotbench.units import DEGREE, FOOT, KNOT, Array

SYSTEM = "5/1"  # air data over GPS [Hz]
CASE = Case(maneuver="circle", turbulence="light")
SPEEDS_KT = (110.0, 130.0, 150.0)
EXACT = 1e-9  # of the unit: what arithmetic in another unit leaves
Flown = dict[str, Array]


@dataclass(frozen=True)
class Readings:
    """Steps or differences: airspeed [kt], altitude [ft], temperature [K], ground speed, track."""

    airspeed: float
    altitude: float
    temperature: float
    ground_speed: float
    track: float  # °


@dataclass(frozen=True)
class Format:
    """How a format is written, the steps of its digits, and whether its clock shows seconds."""

    write: Callable[[Path, Flown], Path]
    steps: Callable[[Flown], Readings]
    suffix: str = ".csv"
    whole_seconds: bool = False


@dataclass(frozen=True)
class Result:
    """What a format gave: differences, steps, and those of the correction [kt] and its 2σ."""

    difference: Readings
    steps: Readings
    correction_kt: Array
    share: Array


def flight() -> Flown:
    """The channels [SI] of a simulated flight in light turbulence, from the record of its sensors."""
    log = record(fly(CASE), data_system(SYSTEM), 1)
    assert log.total_temperature is not None
    names = ("impact_pressure", "static_pressure", "velocity_north", "velocity_east")
    down = np.zeros(len(log)) if log.velocity_down is None else np.array(log.velocity_down)
    return {
        "time": log.time - log.time[0],
        "air_temperature": np.asarray(air.air_temperature(log.total_temperature, _mach(log))),
        "velocity_down": down,
        **{name: np.array(getattr(log, name)) for name in (*names, "altitude", "heading")},
    }


def _mach(log: FlightLog) -> Array:
    return air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)


def shown(*steps: float) -> Callable[[Flown], Readings]:
    """The steps of a display."""
    return lambda flown: Readings(*steps)


def binary32(flown: Flown) -> Readings:
    """The steps of 32-bit numbers."""
    names = ("impact_pressure", "static_pressure", "air_temperature", "velocity_north")
    values = (np.abs(flown[name]).astype(np.float32) for name in names)
    return measured(flown, *(float(np.max(np.spacing(each))) for each in values))


def measured(
    flown: Flown, impact: float, static: float, temperature: float, velocity: float
) -> Readings:
    """The steps of a file of pressures [Pa], temperature [K] and velocities [m/s]."""
    slowest, lowest = (float(np.min(flown[n])) for n in ("impact_pressure", "static_pressure"))
    ground_speed = np.hypot(flown["velocity_north"], flown["velocity_east"])
    return Readings(
        float(air.calibrated_airspeed(slowest + impact) - air.calibrated_airspeed(slowest)) / KNOT,
        float(air.pressure_altitude(lowest) - air.pressure_altitude(lowest + static)) / FOOT,
        temperature,
        velocity / KNOT,
        velocity / float(np.min(ground_speed)) / DEGREE,
    )


def dataflash_steps(flown: Flown) -> Readings:
    """The same, with a course [°] instead of components."""
    return replace(binary32(flown), track=float(np.spacing(np.float32(359.0))))


def g3x_steps(flown: Flown) -> Readings:
    """A display with components of the velocity to 0.01 m/s."""
    of_velocity = measured(flown, 0.0, 0.0, 0.0, 0.01)
    return replace(of_velocity, airspeed=0.1, altitude=1.0, temperature=0.1)


def own(path: Path, flown: Flown) -> Path:
    """What `write_log` makes of the flight."""
    write_log(FlightLog(**flown), path)
    return path


FULL = shown(0.0, 0.0, 0.0, 0.0, 0.0)
WHOLE = ("hms", "iso", "iso-zone", "us", "german")  # clocks without fractions of a second
FORMATS = {
    "KIAS card, as displayed": Format(foreign.kias, shown(1, 10, 1, 1, 1), whole_seconds=True),
    "Garmin G1000": Format(foreign.g1000, shown(0.01, 0.1, 0.1, 0.01, 0.1), whole_seconds=True),
    "Garmin G3X": Format(foreign.g3x, g3x_steps, whole_seconds=True),
    "Garmin GI 275": Format(foreign.gi275, shown(0.1, 1, 0.1, 0.1, 1), whole_seconds=True),
    "Dynon SkyView": Format(foreign.dynon, shown(0.1, 1, 1, 0.1, 0.1)),
    "ArduPilot DataFlash .bin": Format(foreign.dataflash, dataflash_steps, ".bin"),
    "PX4 ULog, GPS up to 1.13": Format(foreign.ulog, binary32, ".ulg"),
    "PX4 ULog, GPS from 1.14": Format(lambda path, flown: foreign.ulog(path, flown, True), binary32, ".ulg"),
    ".mat 5, SIDPAC matrix": Format(foreign.sidpac, FULL, ".mat"),
    ".mat 7.3, SIDPAC matrix": Format(lambda path, flown: foreign.sidpac(path, flown, True), FULL, ".mat"),
    ".mat 5, struct of channels": Format(foreign.mat_channels, FULL, ".mat"),
    ".mat 7.3, variables": Format(foreign.mat73, FULL, ".mat"),
    ".mat 7.3, struct": Format(lambda path, flown: foreign.mat73(path, flown, "fdata/"), FULL, ".mat"),
    "Parquet": Format(own, FULL, ".parquet"),
    "JSBSim CSV": Format(foreign.jsbsim, FULL),
    "UTF-16, decimal commas": Format(
        foreign.german, lambda flown: measured(flown, 1e-5, 1e-3, 1e-5, 1e-5 / 3.6)
    ),
    **{
        f"clock: {name}": Format(foreign.clocked(write), FULL, whole_seconds=name in WHOLE)
        for name, write in foreign.CLOCKS.items()
    },
}  # fmt: skip


def readings(log: FlightLog) -> tuple[Array, ...]:
    """The quantities of `Readings` in each row; a temperature that the log lacks is not a number."""
    north, east, temperature = log.velocity_north, log.velocity_east, log.air_temperature
    if temperature is None and log.total_temperature is not None:
        temperature = np.asarray(air.air_temperature(log.total_temperature, _mach(log)))
    if temperature is None:
        temperature = np.full(len(log), np.nan)
    return (
        np.asarray(air.calibrated_airspeed(log.impact_pressure)) / KNOT,
        np.asarray(air.pressure_altitude(log.static_pressure)) / FOOT,
        temperature,
        np.hypot(north, east) / KNOT,
        np.arctan2(east, north) / DEGREE,
    )


def difference(log: FlightLog, reference: FlightLog) -> Readings:
    """The largest differences of two logs of the same rows."""
    apart = [np.abs(a - b) for a, b in zip(readings(log), readings(reference), strict=True)]
    apart[-1] = np.minimum(apart[-1], 360.0 - apart[-1])
    return Readings(*(float(np.max(values)) for values in apart))


def corrections(found: Calibration) -> tuple[Array, Array]:
    """The corrections at three airspeeds and their 2σ [kt], (3,) each."""
    curve = found.curve
    at = curve.indicated_airspeed_kt
    values = (curve.correction_kt, curve.two_sigma_kt)
    return tuple(np.interp(SPEEDS_KT, at, each) for each in values)


def compare(name: str, flown: Flown, folder: Path) -> Result:
    """Write the flight in a format, read it, calibrate it, and compare it with the CSV of its rows
    and channels.

    A file may lack a channel that the CSV holds, such as the vertical velocity, and the complete
    rows of its start. What the lack of these does to the correction is no question of the format.
    """
    form = FORMATS[name]
    whole = np.abs(flown["time"] - np.round(flown["time"])) < 1e-6
    rows = {key: values[whole] for key, values in flown.items()} if form.whole_seconds else flown
    path = form.write(folder / f"log{form.suffix}", rows)
    mapping = path.with_suffix(".toml")
    log = read_log(path, mapping if mapping.exists() else None)
    left = {key: values[len(rows["time"]) - len(log) :] for key, values in rows.items()}
    reference = read_log(foreign.plain(folder / "reference.csv", left))
    lacking = reference.channels().keys() - log.channels().keys()
    reference = replace(reference, **dict.fromkeys(lacking))
    assert np.allclose(np.diff(log.time), np.diff(reference.time), atol=1e-5), name
    (ours, _), (theirs, two_sigma) = corrections(calibrate(log)), corrections(calibrate(reference))
    apart = np.abs(ours - theirs)
    return Result(difference(log, reference), form.steps(rows), apart, apart / two_sigma)
