"""The pictures of a log: speeds, height and track over time, the tracks flown, the bound to expect."""

import numpy as np

from pitotbench import air
from pitotbench.records.log import FlightLog, LogInspection
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    ORANGE,
    Mark,
    Panel,
    broken,
    dots,
    drawing,
    frame,
    line,
    panel,
    thin,
)
from pitotbench.units import DEGREE, FOOT, KNOT, Array


def inspection_panels(log: FlightLog, found: LogInspection, units: Units = BENCH) -> list[Panel]:
    """The pictures of a log."""
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure)) / KNOT
    track = np.arctan2(log.velocity_east, log.velocity_north) / DEGREE % 360.0
    height = np.asarray(air.pressure_altitude(log.static_pressure)) / FOOT
    pictures = {
        "Speeds": drawing(*speed_marks(log)),
        "Pressure altitude": drawing(
            line(*_over_minutes(log, height), lw=1.0), frame("time [min]", "pressure altitude [ft]")
        ),
        "Tracks and airspeeds flown": drawing(
            dots(*thin(track, speed), ms=2.0),
            frame("track [°]", "indicated airspeed [kt]", xlim=(0, 360), xticks=range(0, 361, 60)),
        ),
    }
    if found.expected is not None:
        pictures["Bound to expect in light turbulence"] = drawing(
            line(*(each / KNOT for each in found.expected), marker="o", ms=3.0),
            frame("indicated airspeed [kt]", "2σ of the correction [kt]", ylim=(0.0, None)),
        )
    return [panel(title, draw, units=units) for title, draw in pictures.items()]


def speed_marks(log: FlightLog) -> list[Mark]:
    """The indicated airspeed and the ground speed of a log over its minutes."""
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure)) / KNOT
    ground = np.hypot(log.velocity_north, log.velocity_east) / KNOT
    return [
        line(*_over_minutes(log, speed), lw=1.0, label="indicated airspeed"),
        line(*_over_minutes(log, ground), lw=1.0, color=ORANGE, label="ground speed"),
        frame("time [min]", "speed [kt]"),
    ]


def _over_minutes(log: FlightLog, values: Array) -> list[Array]:
    """Minutes since the first row and values, thinned, with gaps where recording paused."""
    time, *thinned = broken(*thin(log.time - log.time[0], values))
    return [time / 60.0, *thinned]
