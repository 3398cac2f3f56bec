"""Pictures of a simulated flight and of a campaign's maneuvers."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.flight import Flight
from pitotbench.show.campaign import campaign_table
from pitotbench.show.style import BLUE, GREEN, GREY, NARROW, ORANGE, PURPLE, RED, SKY, Panel, broken, panel, thin
from pitotbench.show.words import with_unit
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, NAUTICAL_MILE, Array

if TYPE_CHECKING:
    import pandas as pd


# Pictures of a simulated flight: its ground track, and its channels over time with the card's tolerances.

_HELD = 8.0  # half-widths: a stretch that spans more is a sweep or a turn, in which the channel is not held


@dataclass(frozen=True, slots=True)
class _History:
    """A channel of the flight as it is drawn over time; `si` is the size of its unit in SI."""

    title: str
    label: str
    channel: str
    unit: str
    si: float


def flight_panels(flight: Flight, tolerances: Mapping[str, float]) -> list[Panel]:
    """Ground track and time histories of airspeed, altitude, heading, bank and power.

    `tolerances`: half-width of the band [SI] by channel of the flight, drawn where that channel is held.
    """
    channels = (
        _History("Airspeed", "calibrated airspeed", "calibrated_airspeed", "kt", KNOT),
        _History("Altitude", "geometric altitude", "altitude", "ft", FOOT),
        _History("Heading", "true heading, unwrapped", "heading", "°", DEGREE),
        _History("Bank", "bank angle", "roll", "°", DEGREE),
        _History("Power", "manifold pressure, left", "manifold_pressure_left", "inHg", INCH_OF_MERCURY),
    )
    track = panel("Ground track", lambda axes: draw_track(axes, flight), size=NARROW)
    served = [each for each in channels if each.channel in flight.channels]  # an electric motor has no manifold
    return [track, *(_history_panel(flight, each, tolerances.get(each.channel, 0.0)) for each in served)]


def _history_panel(flight: Flight, history: _History, tolerance: float) -> Panel:
    values, half = _values(flight, history), tolerance / history.si

    def draw(axes: Axes) -> None:
        draw_history(axes, flight, values)
        if half > 0.0:
            draw_tolerance(axes, flight, values, half, f"tolerance ±{with_unit(f'{half:.3g}', history.unit)}")
        axes.set(xlabel="time [min]", ylabel=f"{history.label} [{history.unit}]")

    return panel(history.title, draw, size=NARROW, legend_columns=2)


def draw_track(axes: Axes, flight: Flight) -> None:
    """Draw the ground track, with its on-condition parts in color and an arrow in the direction of the wind."""
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
    """Draw an arrow outside the axes, where it hides no track; its length does not depend on the wind."""
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
    """Draw one channel over time, with its on-condition parts in color."""
    time, value, on = broken(*thin(_minutes(flight), values, flight.on_condition.astype(np.float64)))
    axes.plot(time, value, color=GREY, lw=0.8)
    axes.plot(time, np.where(on > 0.5, value, np.nan), color=BLUE, lw=1.4, label="on condition")


def draw_tolerance(axes: Axes, flight: Flight, values: Array, half: float, label: str) -> None:
    """Draw a band around the median of every on-condition stretch in which the channel is held.

    `half` is the half-width of the band in the unit of the values.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flight.on_condition, [False]]).astype(np.int8)))
    minutes = _minutes(flight)
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        piece = values[start:stop]
        if np.ptp(piece) > _HELD * half:
            continue
        middle, span = float(np.median(piece)), minutes[[start, stop - 1]]
        axes.fill_between(span, middle - half, middle + half, color=ORANGE, alpha=0.3, lw=0, label=label)
        label = "_"  # one entry of the legend is enough


def _values(flight: Flight, history: _History) -> Array:
    values = flight[history.channel]
    return _unwrapped(values) if history.channel == "heading" else values / history.si


def _minutes(flight: Flight) -> Array:
    begin = float(flight["time"][0])
    return (flight["time"] - begin) / 60.0


def _unwrapped(heading: Array) -> Array:
    """True heading [°] without jumps at north, starting between −180 and 180°."""
    degrees = np.unwrap(heading) / DEGREE
    whole_turns = 360.0 * np.round(degrees[0] / 360.0)
    return np.asarray(degrees - whole_turns, dtype=np.float64)


# Pictures of a campaign: its maneuvers compared, by data system and by model.

_COLORS = (BLUE, SKY, GREEN, ORANGE, PURPLE, RED, GREY)
_BARS = 0.8  # share of a maneuver's place that bars fill


def summary_panels(results: "pd.DataFrame") -> list[Panel]:
    """2σ of the residual, and the models where several were fitted."""
    table = campaign_table(results)
    models = list(table["model"].unique())
    first = table[table["model"] == models[0]]
    panels = [
        panel(
            f"2σ of the residual ({models[0]})",
            lambda axes: draw_summary_bars(axes, first, "das", "residual_two_sigma_kt", "2σ of the residual [kt]"),
            "The scatter that gusts and sensor noise leave: the figure that the literature reports.",
        ),
    ]
    if len(models) > 1:
        system = table["das"].iloc[0]
        one = table[table["das"] == system]
        panels += [
            panel(
                f"{title}, by model ({system} Hz)",
                lambda axes, column=column, label=label: draw_summary_bars(axes, one, "model", column, label),  # type: ignore[misc]
            )
            for title, column, label in (
                ("2σ of the residual", "residual_two_sigma_kt", "2σ of the residual [kt]"),
                ("True rms error of the curve", "curve_rms_error_kt", "rms error [kt]"),
            )
        ]
    return panels


def draw_summary_bars(axes: Axes, table: "pd.DataFrame", kind: str, column: str, label: str) -> None:
    """Draw one column of the campaign's table: a group of bars a maneuver, a bar a `kind` (das or model)."""
    maneuvers = list(table["maneuver"].unique())
    kinds = list(table[kind].unique())
    width = _BARS / len(kinds)
    for number, name in enumerate(kinds):
        rows = table[table[kind] == name].set_index("maneuver")[column].reindex(maneuvers)
        text = f"{name} Hz" if kind == "das" else str(name)
        axes.bar(_places(maneuvers, number, width), rows, 0.92 * width, color=_color(number), label=text)
    axes.set_xticks(np.arange(len(maneuvers)), [str(m).replace("_", "\n") for m in maneuvers])
    axes.set_ylabel(label)
    axes.grid(axis="x", visible=False)


def all_flights_panel(results: "pd.DataFrame") -> Panel:
    """The bound and the true error of every flight against its minutes, for the first model."""
    first = results[results["model"] == results["model"].iloc[0]]
    return panel(
        f"How well the curve is known ({first['model'].iloc[0]})",
        lambda axes: draw_all_flights(axes, first),
        "A dot: the mean ±2σ bound of the curve of one flight, as one data system recorded it. A black mark: twice "
        "its true rms error.",
    )


def draw_all_flights(axes: Axes, results: "pd.DataFrame") -> None:
    """Draw the bound of each flight as a dot, a color a maneuver, and twice its true rms error as a mark."""
    for number, (name, rows) in enumerate(results.groupby("maneuver", sort=False)):
        label = str(name).replace("_", " ")
        axes.plot(rows["minutes"], rows["two_sigma_kt"], "o", ms=4.0, alpha=0.7, color=_color(number), label=label)
    error = 2.0 * results["curve_rms_error_kt"]
    axes.plot(results["minutes"], error, "_", ms=7.0, mew=1.3, color="black", label="2 × true rms error")
    axes.set(xlabel="time [min]", ylabel="mean ±2σ of the curve [kt]", xlim=(0.0, None), ylim=(0.0, None))


def _places(maneuvers: list[object], number: int, width: float) -> Array:
    return np.arange(len(maneuvers), dtype=np.float64) + ((number + 0.5) * width - 0.5 * _BARS)


def _color(number: int) -> str:
    return _COLORS[number % len(_COLORS)]
