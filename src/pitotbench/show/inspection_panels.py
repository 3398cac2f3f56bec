"""The pictures of a log, and of an aircraft's performance.

A log has speeds, height and track over time, the tracks flown, and the bound to expect.
"""

import numpy as np

from pitotbench import air
from pitotbench.records.log import FlightLog, LogInspection
from pitotbench.records.performance import Performance, PerformanceFigure
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    INK,
    ORANGE,
    WIDE,
    Mark,
    Panel,
    broken,
    dots,
    drawing,
    frame,
    line,
    named_rows,
    panel,
    thin,
    written,
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


def performance_panels(found: Performance, units: Units = BENCH) -> list[Panel]:
    """What the sentence of a performance says: the airspeeds, and the climb up to the ceiling."""
    return [*_airspeeds(found, units), *_climb(found, units)]


def _climb(found: Performance, units: Units) -> list[Panel]:
    """The best rate of climb over altitude, up to where the airplane climbs no more."""
    places = [
        (each.model, each.altitude / FOOT) for each in found.figures if each.altitude is not None
    ]
    places += [(0.0, each.model) for each in found.figures if each.name == "absolute ceiling"]
    draw = drawing(
        line(*np.array(places).reshape(-1, 2).T, marker="o", ms=4.0),
        frame(
            "best rate of climb, full throttle [ft/min]", "pressure altitude [ft]", xlim=(0.0, None)
        ),
    )
    return [panel("Climb", draw, units=units)] if places else []


def _airspeeds(found: Performance, units: Units) -> list[Panel]:
    """The airspeeds of an aircraft, each where it is found first, beside those of a handbook."""
    first: dict[str, PerformanceFigure] = {}
    for each in found.figures:
        if each.unit == "KCAS":
            name = f"{each.name}, flaps down" if "flaps down" in each.condition else each.name
            first.setdefault(name, each)
    known = sorted(first.items(), key=lambda item: item[1].model)
    if not known:
        return []
    marks: list[Mark] = []
    for row, (_, each) in enumerate(known):
        marks.append(dots([each.model], [row], color=BLUE, marker="o", ms=5.0, label="model"))
        marks.append(written(each.model, row, f"{each.model:.0f}"))
        if each.published is not None:
            ring = dots(
                [each.published], [row], color=INK, label="handbook", marker="o", mfc="white"
            )
            marks.append(ring)
    size = (WIDE[0], 0.9 + 0.3 * len(known))
    draw = drawing(
        *marks,
        named_rows([name for name, _ in known]),
        frame("calibrated airspeed [kt]", "", xlim=(0.0, 1.15 * known[-1][1].model)),
    )
    return [panel("Airspeeds", draw, size=size, units=units)]
