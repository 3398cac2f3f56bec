"""Pictures of a simulated flight."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.flight import Flight
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    GRAY,
    NARROW,
    ORANGE,
    RED,
    Mark,
    Panel,
    band,
    broken,
    drawing,
    frame,
    ground,
    line,
    panel,
    thin,
)
from pitotbench.show.words import with_unit
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, NAUTICAL_MILE, Array

# half-widths: a stretch that spans more is a sweep or a turn, in which the channel is not held
_STEADY_WITHIN = 8.0


@dataclass(frozen=True, slots=True)
class _History:
    """A channel of the flight as it is drawn over time; `si` is the size of its unit in SI."""

    title: str
    label: str
    channel: str
    unit: str
    si: float


def flight_panels(
    flight: Flight, tolerances: Mapping[str, float], units: Units = BENCH
) -> list[Panel]:
    """Ground track and time histories of airspeed, altitude, heading, bank and power.

    `tolerances`: half-width of the band [SI] by channel of the flight, drawn where that channel is
    held.
    """
    channels = (
        _History("Airspeed", "calibrated airspeed", "calibrated_airspeed", "kt", KNOT),
        _History("Altitude", "geometric altitude", "altitude", "ft", FOOT),
        _History("Heading", "true heading, unwrapped", "heading", "°", DEGREE),
        _History("Bank", "bank angle", "roll", "°", DEGREE),
        _History(
            "Power", "manifold pressure, left", "manifold_pressure_left", "inHg", INCH_OF_MERCURY
        ),
    )
    track = panel("Ground track", drawing(*track_marks(flight)), size=NARROW)
    # An electric motor has no manifold.
    served = [each for each in channels if each.channel in flight.channels]
    return [
        track,
        *(
            _history_panel(flight, each, tolerances.get(each.channel, 0.0), units)
            for each in served
        ),
    ]


def _history_panel(flight: Flight, history: _History, tolerance: float, units: Units) -> Panel:
    values, half = flight[history.channel] / history.si, tolerance / history.si
    if history.channel == "heading":  # without jumps at north, starting between −180 and 180°
        values = np.unwrap(values, period=360.0)
        values = values - 360.0 * np.round(values[0] / 360.0)
    minutes = (flight["time"] - flight["time"][0]) / 60.0
    time, value, on = broken(*thin(minutes, values, flight.on_condition.astype(np.float64)))
    label = f"tolerance ±{with_unit(f'{half:.3g}', history.unit)}"
    draw = drawing(
        line(time, value, color=GRAY, lw=0.8),
        line(time, np.where(on > 0.5, value, np.nan), label="on condition"),
        *(
            band(minutes[piece], middle - half, middle + half, color=ORANGE, label=label)
            for piece, middle in _steady_stretches(flight, values, half)
        ),
        frame("time [min]", f"{history.label} [{history.unit}]"),
    )
    return panel(history.title, draw, size=NARROW, legend_columns=2, units=units)


def track_marks(flight: Flight) -> list[Mark]:
    """Return the marks of the ground track, with its on-condition parts in color.

    An arrow points in the direction of the wind.
    """
    east, north = flight["position_east"] / NAUTICAL_MILE, flight["position_north"] / NAUTICAL_MILE
    on = flight.on_condition.astype(np.float64)
    _, x, y, on = broken(*thin(flight["time"], east, north, on))
    return [
        line(x, y, color=GRAY, lw=0.8, label="flown"),
        line(np.where(on > 0.5, x, np.nan), y, lw=1.8, label="on condition"),
        partial(_draw_wind, flight=flight),
        ground,
        lambda axes: axes.margins(0.12),
        frame("east [nmi]", "north [nmi]"),
    ]


def _draw_wind(axes: Axes, flight: Flight) -> None:
    """Draw the wind as an arrow outside the axes, where it hides no track.

    Its length does not depend on the wind, whose speed is written beside it.
    """
    wind = flight.case.wind
    if wind.speed <= 0.0:
        return
    toward = wind.from_direction + np.pi
    east, north = 0.07 * np.sin(toward), 0.07 * np.cos(toward)
    axes.annotate(
        "",
        xy=(1.12 + east, 0.72 + north),
        xytext=(1.12 - east, 0.72 - north),
        xycoords="axes fraction",
        arrowprops={"arrowstyle": "-|>", "color": RED, "lw": 1.6},
        annotation_clip=False,
    )
    words = f"wind\n{wind.speed / KNOT:.0f} kt"
    axes.text(
        1.12, 0.56, words, transform=axes.transAxes, ha="center", va="top", fontsize=8, color=RED
    )


def _steady_stretches(flight: Flight, values: Array, half: float) -> list[tuple[list[int], float]]:
    """Return every on-condition stretch in which a channel is held, and its median there.

    A stretch is its first and its last row; held is what stays within some half-widths. There is
    none without a half-width.
    """
    on = np.concatenate([[False], flight.on_condition, [False]]).astype(np.int8)
    pieces = np.flatnonzero(np.diff(on)).reshape(-1, 2).tolist() if half > 0.0 else []
    return [
        ([start, stop - 1], float(np.median(values[start:stop])))
        for start, stop in pieces
        if np.ptp(values[start:stop]) <= _STEADY_WITHIN * half
    ]
