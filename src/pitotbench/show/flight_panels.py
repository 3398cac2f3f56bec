"""Pictures of a flight as it was flown: where it went, and how well it was held. Simulated flights only."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.flight import Flight
from pitotbench.show.style import BLUE, GREY, NARROW, ORANGE, RED, Panel, broken, panel, thin
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, Array

_NAUTICAL_MILE = 1852.0
_HELD = 8.0  # a stretch that spans more than so many half-bands is not one of holding


def flight_panels(flight: Flight, tolerances: Mapping[str, float]) -> list[Panel]:
    """Ground track and time histories of airspeed, altitude, heading, bank and power.

    `tolerances`: half-width of the band [SI] by channel of the flight, drawn where that channel is held.
    """
    channels = (
        ("Airspeed", "calibrated airspeed [kt]", "calibrated_airspeed", KNOT),
        ("Altitude", "geometric altitude [ft]", "altitude", FOOT),
        ("Heading", "true heading, unwrapped [°]", "heading", DEGREE),
        ("Bank", "bank angle [°]", "roll", DEGREE),
        ("Power", "manifold pressure, left [inHg]", "manifold_pressure_left", INCH_OF_MERCURY),
    )
    panels = [panel("Ground track", lambda axes: draw_track(axes, flight), size=NARROW)]
    for title, label, channel, unit in channels:
        values, half = _values(flight, channel, unit), tolerances.get(channel, 0.0) / unit
        panels.append(_history_panel(flight, title, label, values, half))
    return panels


def _history_panel(flight: Flight, title: str, label: str, values: Array, half: float) -> Panel:
    def draw(axes: Axes) -> None:
        draw_history(axes, flight, values)
        if half > 0.0:
            draw_tolerance(axes, flight, values, half)
        axes.set(xlabel="time [min]", ylabel=label)

    return panel(title, draw, size=NARROW, legend_columns=2)


def draw_track(axes: Axes, flight: Flight) -> None:
    """Ground track, on-condition parts in color, an arrow the way the wind blows."""
    east, north = flight["position_east"] / _NAUTICAL_MILE, flight["position_north"] / _NAUTICAL_MILE
    on = flight.on_condition.astype(np.float64)
    _, x, y, on = broken(*thin(flight["time"], east, north, on))
    axes.plot(x, y, color=GREY, lw=0.8, label="flown")
    axes.plot(np.where(on > 0.5, x, np.nan), y, color=BLUE, lw=1.8, label="on condition")
    _draw_wind(axes, flight)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.12)
    axes.set(xlabel="east [NM]", ylabel="north [NM]")


def _draw_wind(axes: Axes, flight: Flight) -> None:
    """An arrow beside the axes, where it hides no track; its length says nothing."""
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
    axes.text(1.12, 0.56, words, transform=axes.transAxes, ha="center", va="top", fontsize=8, color=RED)


def draw_history(axes: Axes, flight: Flight, values: Array) -> None:
    """One channel over time, on-condition parts in color."""
    time, value, on = broken(*thin(_minutes(flight), values, flight.on_condition.astype(np.float64)))
    axes.plot(time, value, color=GREY, lw=0.8)
    axes.plot(time, np.where(on > 0.5, value, np.nan), color=BLUE, lw=1.4, label="on condition")


def draw_tolerance(axes: Axes, flight: Flight, values: Array, half: float) -> None:
    """A band around the median of every on-condition stretch in which the channel is held."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flight.on_condition, [False]]).astype(np.int8)))
    minutes, label = _minutes(flight), f"tolerance ±{half:.3g}"
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        piece = values[start:stop]
        if np.ptp(piece) > _HELD * half:
            continue  # a sweep of speed or a turn: nothing is held here
        middle, span = float(np.median(piece)), minutes[[start, stop - 1]]
        axes.fill_between(span, middle - half, middle + half, color=ORANGE, alpha=0.3, lw=0, label=label)
        label = "_"  # one entry of the legend is enough


def _values(flight: Flight, channel: str, unit: float) -> Array:
    return _unwrapped(flight[channel]) if channel == "heading" else flight[channel] / unit


def _minutes(flight: Flight) -> Array:
    begin = float(flight["time"][0])
    return (flight["time"] - begin) / 60.0


def _unwrapped(heading: Array) -> Array:
    """True heading [°] without jumps at north, starting between −180 and 180°."""
    degrees = np.unwrap(heading) / DEGREE
    whole_turns = 360.0 * np.round(degrees[0] / 360.0)
    return np.asarray(degrees - whole_turns, dtype=np.float64)
