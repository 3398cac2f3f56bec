"""The account of a log as a page: speeds, height and track over time, the tracks flown, the bound to expect."""

import numpy as np
from matplotlib.axes import Axes

from pitotbench import air
from pitotbench.records.log import FlightLog
from pitotbench.records.log_inspection import LogInspection
from pitotbench.show.columns import html_table
from pitotbench.show.inspection_text import CHANNEL_COLUMNS, QUESTION_COLUMNS, inspection_sentences
from pitotbench.show.markup import render
from pitotbench.show.style import BLUE, GREY, ORANGE, Panel, broken, panel, thin
from pitotbench.units import DEGREE, FOOT, KNOT, Array


def inspection_page(name: str, log: FlightLog, found: LogInspection) -> str:
    """The HTML of the account of a log."""
    return render(
        "inspection.html",
        title=f"What {name} holds",
        sentences=inspection_sentences(found),
        panels=inspection_panels(log, found),
        questions=html_table(QUESTION_COLUMNS, found.questions),
        channels=html_table(CHANNEL_COLUMNS, found.channels),
        warnings=found.warnings,
    )


def inspection_panels(log: FlightLog, found: LogInspection) -> list[Panel]:
    """The pictures of a log."""
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure)) / KNOT
    ground = np.hypot(log.velocity_north, log.velocity_east) / KNOT
    track = np.arctan2(log.velocity_east, log.velocity_north) / DEGREE % 360.0
    height = np.asarray(air.pressure_altitude(log.static_pressure)) / FOOT
    panels = [
        panel("Speeds", lambda axes: _draw_speeds(axes, log.time, speed, ground)),
        panel("Pressure altitude", lambda axes: _draw_line(axes, log.time, height, "pressure altitude [ft]")),
        panel("Tracks and airspeeds flown", lambda axes: _draw_tracks(axes, track, speed)),
    ]
    if found.expected is not None:
        speeds, bound = found.expected
        panels.append(panel("Bound to expect in light turbulence", lambda axes: _draw_bound(axes, speeds, bound)))
    return panels


def _draw_speeds(axes: Axes, time: Array, speed: Array, ground: Array) -> None:
    seconds, *lines = broken(*thin(time - time[0], speed, ground))
    for line, color, label in zip(lines, (BLUE, ORANGE), ("indicated airspeed", "ground speed"), strict=True):
        axes.plot(seconds / 60.0, line, color=color, label=label, lw=1.0)
    axes.set(xlabel="time [min]", ylabel="speed [kt]")


def _draw_line(axes: Axes, time: Array, values: Array, label: str) -> None:
    seconds, line = broken(*thin(time - time[0], values))
    axes.plot(seconds / 60.0, line, color=BLUE, lw=1.0)
    axes.set(xlabel="time [min]", ylabel=label)


def _draw_tracks(axes: Axes, track: Array, speed: Array) -> None:
    some, fast = thin(track, speed)
    axes.plot(some, fast, ".", color=GREY, ms=2.0)
    axes.set(xlabel="track [°]", ylabel="indicated airspeed [kt]", xlim=(0, 360), xticks=range(0, 361, 60))


def _draw_bound(axes: Axes, speeds: Array, bound: Array) -> None:
    axes.plot(speeds / KNOT, bound / KNOT, "o-", color=BLUE, ms=3.0)
    axes.set(xlabel="indicated airspeed [kt]", ylabel="2σ of the correction [kt]", ylim=(0.0, None))
