"""The data of a reconciliation's pictures: the gap by place, over time, and after each effect."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.signal import lfilter

from pitotbench import air
from pitotbench.reconciliation.cells import flight_variables
from pitotbench.reconciliation.equations import Fit
from pitotbench.reconciliation.free_parameters import curve_share
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.regression import Block
from pitotbench.reconciliation.residuals import FAMILIES, UNITS
from pitotbench.records.gap import CalibrationChange, GapMap, Step, TellingChannel, Trace
from pitotbench.units import Array, Booleans, Seconds


def gap_map(block: Block, fit: Fit) -> GapMap:
    """Return the places of the gap before and after a fit, in σ beyond null flights."""
    index, cells = zip(*block.layout.places, strict=True)
    channels = tuple(dict.fromkeys(cell.channel for cell in cells))
    places = tuple(dict.fromkeys(cell.where for cell in cells))
    tables = []
    for given in ((), fit.columns):
        table = np.full((len(channels), len(places)), np.nan)
        for cell, value in zip(cells, block.equations.scores(index, given), strict=True):
            table[channels.index(cell.channel), places.index(cell.where)] = (
                block.null.scores.of_cell(cell, value)
            )
        tables.append(table)
    return GapMap(channels, places, tables[0], tables[1], block.null.cell_threshold)


OPEN = "what_the_forms_leave_open"  # step of the waterfall


def waterfall(block: Block, fit: Fit, effects: Collection[str]) -> tuple[Step, ...]:
    """Return the sum of squares that remains as the effects of a fit are added one by one.

    The sizes are those fitted together. The effect that removes most comes first, what their forms
    leave open last.
    """
    waiting: dict[str, list[int]] = {}
    for place, column in enumerate(fit.columns):
        effect = block.layout.signatures[column].effect
        waiting.setdefault(effect if effect in effects else OPEN, []).append(place)
    added, steps = list[int](), []
    while waiting:
        left = {name: _remaining(block, fit, [*added, *own]) for name, own in waiting.items()}
        best = min(left, key=lambda name: left[name])
        added += waiting.pop(best)
        steps.append(Step(best, left[best]))
    return tuple(steps)


def _remaining(block: Block, fit: Fit, places: Sequence[int]) -> float:
    """Return the sum of squares beyond the floor with some of a fit's columns at their sizes.

    The others are absent.
    """
    at = [fit.columns[i] for i in places]
    return float(block.beyond.less(at, fit.sizes[list(places)]).inner[-1, -1])


def traces(block: Block, fit: Fit) -> tuple[Trace, ...]:
    """Return every residual channel over time less free parameters, and the part of a fit."""
    layout = block.layout
    free = layout.free.columns @ block.equations.free_sizes(fit.columns)
    explained = _moved(layout, fit)
    time = layout.track.time[layout.grid.rows]
    gap, used = layout.residuals.values - free, layout.used
    return tuple(
        Trace(name, UNITS[name], time, gap[:, i], explained[:, i], used[:, i])
        for i, name in enumerate(layout.residuals.names)
    )


def _moved(layout: Layout, fit: Fit) -> Array:
    """The change of the residuals by a fit, (n, c)."""
    each = (
        layout.signatures[c].column * size for c, size in zip(fit.columns, fit.sizes, strict=True)
    )
    return np.asarray(sum(each, np.zeros_like(layout.residuals.values)))


# s: long enough to average the sensor noise, short enough for the phases of a maneuver
AVERAGED = 4.0
INSTANTS = 8  # the same, where they are close
MARKED = 0.75  # quantile of the size of the gap from which a place is marked
RESPONSE = 400  # instants after which an autoregression has forgotten an innovation
FLOWN = (2.0, 98.0)  # percentiles of the indicated airspeed between which a correction is reported
SPEEDS = 25  # airspeeds at which the correction is reported
TINY = 1e-30  # of a noise, so that it can be divided by
# variables over which the gap is drawn, in addition to acceleration
DRAWN = ("airspeed", "bank", "altitude", "power")
# Where a person looks for a gap of a part: its channels, of which the clearest is drawn. Of other
# parts, any.
_AIRSPEED = ("airspeed_along",)
_TRIANGLE = FAMILIES["air data"][:3]
LOOKED_AT: Mapping[str, tuple[str, ...]] = {
    "pitot line": _AIRSPEED,
    "pitot head": _AIRSPEED,
    "impact transducer": _AIRSPEED,
    "static ports and line": (*_AIRSPEED, "pressure_height"),
    "static transducer": (*_AIRSPEED, "pressure_height"),
    "thermometer, or the day": ("temperature",),
    "GPS receiver and its clock": _TRIANGLE,
    "attitude and inertial unit": (*_TRIANGLE, *FAMILIES["kinematic"]),
    "flow vanes": _TRIANGLE,
    "air": _TRIANGLE,
    "drag": ("specific_force_x",),
    "engine instruments": FAMILIES["engine"],
}


def clearest_channel(block: Block, part: str, found: Sequence[Trace]) -> TellingChannel:
    """Return the channel of a part whose gap stands out most from its noise.

    `found` are the residual channels over time. Where no channel of the part shows the effects, it
    is any channel.
    """
    layout, null = block.layout, block.null
    by_name = {trace.channel: trace for trace in found}
    names = list(null.noise.names)
    averaged = min(AVERAGED, INSTANTS * layout.grid.step)
    instants = max(1, round(averaged / layout.grid.step))
    noise = {
        n: deviation_of_mean(null.noise, names.index(n), instants) for n in by_name if n in names
    }
    shown = {
        n: _level(by_name[n], instants, np.hypot(d, _slack(layout, n))) for n, d in noise.items()
    }
    looked_at = [n for n in LOOKED_AT.get(part, ()) if shown.get(n, 0.0) > 0.0]
    name = max(looked_at or shown, key=lambda n: shown[n])
    trace = by_name[name]
    what = trace.explained if np.any(trace.explained) else _means(trace.gap, instants)
    variable, values = _variable(layout, what, trace.used)
    away = np.where(trace.used, np.abs(what), 0.0)
    north, east = _ground_track(layout)
    track = layout.track
    return TellingChannel(
        channel=name,
        unit=trace.unit,
        time=trace.time,
        gap=trace.gap,
        unexplained=trace.gap - trace.explained,
        noise=noise[name],
        averaged=averaged,
        variable=variable,
        values=values,
        north=north,
        east=east,
        marked=trace.used & (away >= np.quantile(away[trace.used], MARKED)),
        used=trace.used,
        mass=track["mass"][layout.grid.rows] if "mass" in track else None,
    )


def deviation_of_mean(noise: NoiseModel, channel: int, instants: int) -> float:
    """Return the deviation of the mean of a channel's noise over some instants.

    The unit is the channel's.

    The noise is the autoregression of the channel; its response to one innovation, summed over a
    window, gives the variance of the mean.
    """
    impulse = np.zeros(RESPONSE)
    impulse[0] = 1.0
    response = lfilter([1.0], np.concatenate([[1.0], -noise.coefficients[channel]]), impulse)
    mean = np.convolve(response, np.full(instants, 1.0 / instants))
    return float(noise.deviations[channel] * np.sqrt(np.sum(mean**2)))


def calibration_change(layout: Layout, fit: Fit) -> CalibrationChange | None:
    """Return what effects change in a calibration by the wind triangle, None without effects.

    Wind and error curve are fitted by least squares to what the effects of the fit do to the along-
    and across-track airspeed. What the curve takes of it is the error of a calibration that does
    not know the effects.
    """
    triangle = [
        layout.residuals.names.index(n)
        for n in FAMILIES["air data"][:2]
        if n in layout.residuals.names
    ]
    if not (fit.columns and triangle):
        return None
    moved = _moved(layout, fit)[:, triangle]
    names = layout.free.names
    wanted = [i for i, n in enumerate(names) if n.startswith(("curve ", "wind north", "wind east"))]
    design = layout.free.columns[:, triangle][:, :, wanted].reshape(-1, len(wanted))
    normal = design.T @ design + np.diag(1.0 / layout.free.deviations[wanted] ** 2)
    sizes = np.linalg.solve(normal, design.T @ np.reshape(moved, -1))
    of = {names[i]: float(size) for i, size in zip(wanted, sizes, strict=True)}
    indicated = air.calibrated_airspeed(np.maximum(layout.track["impact_pressure"], 1.0))
    low, high = np.percentile(indicated, FLOWN)
    airspeed = np.linspace(float(low), float(high), SPEEDS)
    pressure = air.impact_pressure(airspeed)
    corrected = pressure * (1.0 + curve_share(pressure, of))
    return CalibrationChange(airspeed, air.calibrated_airspeed(corrected) - airspeed)


def _slack(layout: Layout, channel: str) -> Array:
    """The deviation that adds to the noise of a channel where the model changes quickly, (n,)."""
    return layout.residuals.slack[:, layout.residuals.names.index(channel)]


def _level(trace: Trace, instants: int, noise: Array) -> float:
    """Return the root mean square of what is explained, else of the gap's means, in noise, (n,)."""
    values = trace.explained if np.any(trace.explained) else _means(trace.gap, instants)
    return float(np.sqrt(np.mean((values / np.maximum(noise, TINY)) ** 2)))


def _means(values: Array, instants: int) -> Array:
    return np.convolve(values, np.full(instants, 1.0 / instants), mode="same")


def _variable(layout: Layout, gap: Array, used: Booleans) -> tuple[str, Array]:
    """Return the variable that a gap, (n,), follows most, and its values at the instants [SI].

    Only instants that are `used` count.
    """
    values = {
        n: v for n, v in flight_variables(layout.reference.clean, layout.grid).items() if n in DRAWN
    }
    values["acceleration"] = np.gradient(values["airspeed"], layout.track.time[layout.grid.rows])
    follows = {n: _correlation(v[used], gap[used]) for n, v in values.items()}
    best = max(follows, key=lambda n: follows[n])
    return best, values[best]


def _correlation(values: Array, gap: Array) -> float:
    """The size of the correlation of a gap with a variable; 0 where one of them is constant."""
    spread = float(np.std(values) * np.std(gap))
    return (
        abs(float(np.mean((values - values.mean()) * (gap - gap.mean())))) / spread
        if spread > 0.0
        else 0.0
    )


def _ground_track(layout: Layout) -> tuple[Array, Array]:
    """Position north and east of the start [m] at the instants, from the ground velocity."""
    track, rows = layout.track, layout.grid.rows
    if "velocity_north" not in track:
        return np.zeros(len(rows)), np.zeros(len(rows))
    seconds: Seconds = np.diff(track.time, prepend=track.time[0])
    return (
        np.cumsum(track["velocity_north"] * seconds)[rows],
        np.cumsum(track["velocity_east"] * seconds)[rows],
    )
