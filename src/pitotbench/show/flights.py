"""Pictures of a flight as it was flown: where it went, and how well it was held. Simulated flights only."""

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.flight import Flight
from pitotbench.show.style import BLUE, GREY, ORANGE, RED, broken, canvas, svg, thin
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, Array

_NAUTICAL_MILE = 1852.0
_ALTITUDE_BAND_FT, _SPEED_BAND_KT, _HEADING_BAND_DEG = 50.0, 1.0, 2.0
_HELD = 8.0  # a stretch that spans more than so many half-bands is not one of holding


def flight_figure(flight: Flight) -> str:
    """Ground track and time histories of airspeed, altitude, heading and bank, as SVG."""
    with canvas(2, 3, 12.0, 5.6) as (figure, (track, airspeed, altitude, heading, bank, power)):
        draw_track(track, flight)
        draw_history(airspeed, flight, flight["calibrated_airspeed"] / KNOT, "Airspeed", "calibrated airspeed [kt]")
        draw_history(altitude, flight, flight["altitude"] / FOOT, "Altitude", "geometric altitude [ft]")
        draw_history(heading, flight, _unwrapped(flight["heading"]), "Heading", "true heading [°]")
        draw_history(bank, flight, flight["roll"] / DEGREE, "Bank", "bank angle [°]")
        draw_history(
            power,
            flight,
            flight["manifold_pressure_left"] / INCH_OF_MERCURY,
            "Power",
            "manifold pressure, left [inHg]",
        )
        _band(airspeed, flight, flight["calibrated_airspeed"] / KNOT, _SPEED_BAND_KT)
        _band(altitude, flight, flight["altitude"] / FOOT, _ALTITUDE_BAND_FT)
        _band(heading, flight, _unwrapped(flight["heading"]), _HEADING_BAND_DEG)
        return svg(figure)


def draw_track(axes: Axes, flight: Flight) -> None:
    """Ground track, on-condition parts in color, an arrow the way the wind blows."""
    east, north = flight["position_east"] / _NAUTICAL_MILE, flight["position_north"] / _NAUTICAL_MILE
    time, x, y, on = thin(flight["time"], east, north, flight.on_condition.astype(np.float64))
    _, x, y, on = broken(time, x, y, on)
    axes.plot(x, y, color=GREY, lw=0.8, label="flown")
    axes.plot(np.where(on > 0.5, x, np.nan), y, color=BLUE, lw=1.8, label="on condition")
    wind = flight.case.wind
    if wind.speed > 0.0:
        toward = wind.from_direction + np.pi
        axes.annotate(
            f"wind {wind.speed / KNOT:.0f} kt",
            xy=(0.88 + 0.08 * np.sin(toward), 0.12 + 0.08 * np.cos(toward)),
            xytext=(0.88 - 0.08 * np.sin(toward), 0.12 - 0.08 * np.cos(toward)),
            xycoords="axes fraction",
            ha="center",
            fontsize=8,
            arrowprops={"arrowstyle": "-|>", "color": RED},
            color=RED,
        )
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(title="Ground track", xlabel="east [NM]", ylabel="north [NM]")
    axes.legend(loc="upper left")


def draw_history(axes: Axes, flight: Flight, values: Array, title: str, label: str) -> None:
    """One channel over time, on-condition parts in color."""
    time, value, on = thin(_minutes(flight), values, flight.on_condition.astype(np.float64))
    time, value, on = broken(time, value, on)
    axes.plot(time, value, color=GREY, lw=0.8)
    axes.plot(time, np.where(on > 0.5, value, np.nan), color=BLUE, lw=1.4)
    axes.set(title=title, xlabel="time [min]", ylabel=label)


def _minutes(flight: Flight) -> Array:
    begin = float(flight["time"][0])
    return (flight["time"] - begin) / 60.0


def _unwrapped(heading: Array) -> Array:
    """True heading [°] without jumps at north, starting between −180 and 180°."""
    degrees = np.unwrap(heading) / DEGREE
    whole_turns = 360.0 * np.round(degrees[0] / 360.0)
    return np.asarray(degrees - whole_turns, dtype=np.float64)


def _band(axes: Axes, flight: Flight, values: Array, half: float) -> None:
    """Tolerance bands around the median of every on-condition stretch in which the channel is held."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flight.on_condition, [False]]).astype(np.int8)))
    drawn = False
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        piece = values[start:stop]
        if np.ptp(piece) > _HELD * half:
            continue  # a sweep of speed or a turn: nothing is held here
        middle = float(np.median(piece))
        axes.fill_between(
            _minutes(flight)[[start, stop - 1]], middle - half, middle + half, color=ORANGE, alpha=0.25, lw=0
        )
        drawn = True
    if drawn:
        axes.plot([], [], color=ORANGE, alpha=0.5, lw=6, label=f"tolerance ±{half:g}")
        axes.legend(loc="best")
