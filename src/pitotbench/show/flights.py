"""Pictures of a simulated flight."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.flight import Flight
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import BLUE, GREY, NARROW, ORANGE, RED, Panel, broken, panel, thin
from pitotbench.show.words import with_unit
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, NAUTICAL_MILE, Array

_HELD = 8.0  # half-widths: a stretch that spans more is a sweep or a turn, in which the channel is not held


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
    track = panel("Ground track", lambda axes: draw_track(axes, flight), size=NARROW)
    served = [
        each for each in channels if each.channel in flight.channels
    ]  # an electric motor has no manifold
    return [
        track,
        *(
            _history_panel(flight, each, tolerances.get(each.channel, 0.0), units)
            for each in served
        ),
    ]


def _history_panel(flight: Flight, history: _History, tolerance: float, units: Units) -> Panel:
    values, half = flight[history.channel], tolerance / history.si
    if history.channel == "heading":  # without jumps at north, starting between −180 and 180°
        degrees = np.unwrap(values) / DEGREE
        values = degrees - 360.0 * np.round(degrees[0] / 360.0)
    else:
        values = values / history.si

    def draw(axes: Axes) -> None:
        time, value, on = broken(
            *thin(_minutes(flight), values, flight.on_condition.astype(np.float64))
        )
        axes.plot(time, value, color=GREY, lw=0.8)
        axes.plot(time, np.where(on > 0.5, value, np.nan), color=BLUE, lw=1.4, label="on condition")
        if half > 0.0:
            draw_tolerance(
                axes, flight, values, half, f"tolerance ±{with_unit(f'{half:.3g}', history.unit)}"
            )
        axes.set(xlabel="time [min]", ylabel=f"{history.label} [{history.unit}]")

    return panel(history.title, draw, size=NARROW, legend_columns=2, units=units)


def draw_track(axes: Axes, flight: Flight) -> None:
    """Draw the ground track, with its on-condition parts in color and an arrow in the direction of
    the wind.
    """
    east, north = flight["position_east"] / NAUTICAL_MILE, flight["position_north"] / NAUTICAL_MILE
    on = flight.on_condition.astype(np.float64)
    _, x, y, on = broken(*thin(flight["time"], east, north, on))
    axes.plot(x, y, color=GREY, lw=0.8, label="flown")
    axes.plot(np.where(on > 0.5, x, np.nan), y, color=BLUE, lw=1.8, label="on condition")
    _draw_wind(axes, flight)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set(xlabel="east [nmi]", ylabel="north [nmi]")


def _draw_wind(axes: Axes, flight: Flight) -> None:
    """Draw an arrow outside the axes, where it hides no track; its length does not depend on the
    wind.
    """
    wind = flight.case.wind
    if wind.speed <= 0.0:
        return
    toward = wind.from_direction + np.pi
    east, north = 0.07 * np.sin(toward), 0.07 * np.cos(toward)
    arrow = {"arrowstyle": "-|>", "color": RED, "lw": 1.6}
    axes.annotate(
        "",
        xy=(1.12 + east, 0.72 + north),
        xytext=(1.12 - east, 0.72 - north),
        xycoords="axes fraction",
        arrowprops=arrow,
        annotation_clip=False,
    )
    words = f"wind\n{wind.speed / KNOT:.0f} kt"
    axes.text(
        1.12, 0.56, words, transform=axes.transAxes, ha="center", va="top", fontsize=8, color=RED
    )


def draw_tolerance(axes: Axes, flight: Flight, values: Array, half: float, label: str) -> None:
    """Draw a band around the median of every on-condition stretch in which the channel is held.

    `half` is the half-width of the band in the unit of the values.
    """
    edges = np.flatnonzero(
        np.diff(np.concatenate([[False], flight.on_condition, [False]]).astype(np.int8))
    )
    minutes = _minutes(flight)
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        piece = values[start:stop]
        if np.ptp(piece) > _HELD * half:
            continue
        middle, span = float(np.median(piece)), minutes[[start, stop - 1]]
        axes.fill_between(
            span, middle - half, middle + half, color=ORANGE, alpha=0.3, lw=0, label=label
        )
        label = "_"  # one entry of the legend is enough


def _minutes(flight: Flight) -> Array:
    begin = float(flight["time"][0])
    return (flight["time"] - begin) / 60.0
