"""The pictures of a reconciliation, the telling channel first."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import SymLogNorm
from matplotlib.patches import Rectangle

from pitotbench.records.gap import (
    Account,
    GapMap,
    History,
    TellingChannel,
    Trace,
)
from pitotbench.records.verdict import Located
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import (
    BLUE,
    GREEN,
    GREY,
    INK,
    NARROW,
    ORANGE,
    PALE,
    RED,
    Panel,
    broken,
    canvas,
    panel,
    svg,
    thin,
)
from pitotbench.show.words import (
    CHANNELS,
    VARIABLES,
    FieldUnit,
    is_force,
    unit_without_mass,
    words,
)
from pitotbench.timeline import interval, stretches
from pitotbench.units import NAUTICAL_MILE, Array, Booleans

# Instants of a log that the comparison did not use, in words and as shaded stretches of a picture
# over time.

_SHADE = "#F0E0D0"  # unlike the grey of a noise band


def unused_words(trace: Trace) -> str:
    """Return why some instants are shaded, and their share; empty where all were used."""
    if np.all(trace.used):
        return ""
    share = 100.0 * float(np.mean(~trace.used))
    return (
        f"Shaded: {share:.1f} % of the flight that was not used, because the impact pressure stood "
        "at the end of its sensor's range or the Mach number was above the limit."
    )


def shade_unused(axes: Axes, time: Array, used: Booleans) -> None:
    """Shade the stretches of time [min], (n,), that are not used, (n,), with one entry in the
    legend.
    """
    half = 0.5 * interval(time)
    changes = (
        np.flatnonzero((np.diff(used.astype(np.int8)) != 0) | (np.diff(time) > 3.0 * half)) + 1
    )
    label = "not used"
    for part in stretches(time, changes):
        if not used[part.start]:
            axes.axvspan(
                time[part.start] - half,
                time[part.stop - 1] + half,
                color=_SHADE,
                lw=0.0,
                label=label,
            )
            label = "_"


# Pictures of a gap: its map, the part that each effect explains, the rest, and the card flown
# again.

SHOWN = 6  # channels over time
VISIBLE = 0.1  # of the remaining gap: a smaller change by the patch cannot be read from a picture
BIN = 4.0  # s: long enough to average the sensor noise, short enough for the phases of a maneuver


def map_panels(found: GapMap, _: Units = BENCH) -> list[Panel]:
    """The map of the remaining gap first, then that without the named effects in the model, on one
    scale.
    """
    scale = max(2.0 * found.threshold, float(np.nanmax(np.abs(found.before))))
    note = (
        f"Flights without an effect stay below {found.threshold:.1f}σ; cells above it are framed. "
        "Positive: the measured value is larger."
    )
    tables = [("Where the gap is [σ]", found.before)]
    if np.any(found.before != found.after):
        tables = [
            ("The remaining gap [σ]", found.after),
            ("The gap before the patch [σ]", found.before),
        ]
    return [_map_panel(title, found, values, scale, note) for title, values in tables]


def _map_panel(title: str, found: GapMap, values: Array, scale: float, note: str) -> Panel:
    width, height = 2.6 + 0.5 * len(found.places), 1.5 + 0.24 * len(found.channels)
    with canvas(1, 1, width, height) as (figure, (axes,)):
        norm = SymLogNorm(linthresh=found.threshold, vmin=-scale, vmax=scale)
        image = axes.imshow(values, cmap="RdBu_r", norm=norm, aspect="auto")
        axes.set_xticks(
            range(len(found.places)), [words(p) for p in found.places], rotation=55, ha="right"
        )
        axes.set_yticks(range(len(found.channels)), [words(c) for c in found.channels])
        axes.tick_params(labelsize=9, length=0)
        axes.grid(visible=False)
        for row, column in np.argwhere(np.abs(np.nan_to_num(values)) > found.threshold).tolist():
            value = float(values[row, column])
            axes.add_patch(
                Rectangle((column - 0.5, row - 0.5), 1, 1, fill=False, edgecolor=INK, linewidth=0.8)
            )
            color = (
                "white" if abs(float(norm(value)) - 0.5) > 0.33 else INK
            )  # light on a dark shade
            axes.text(
                column, row, f"{value:+.0f}", ha="center", va="center", fontsize=9, color=color
            )
        ticks = [-scale, -found.threshold, 0, found.threshold, scale]
        bar = figure.colorbar(image, ax=axes, shrink=0.8, ticks=ticks)
        bar.ax.set_yticklabels([f"{t:+.0f}" for t in ticks])
        bar.set_label("significance [σ]", fontsize=9)
        bar.ax.tick_params(labelsize=9)
        return Panel(title, svg(figure, title), note)


def waterfall_panels(account: Account, _: Units = BENCH) -> list[Panel]:
    """The explainable gap, and the part of it that remains as effect after effect is added."""
    closed = account.verdict.closure
    whole = max(closed.before - closed.noise, 1e-9)
    remaining = [100.0, *(100.0 * (step.left - closed.noise) / whole for step in account.waterfall)]
    names = ["as measured", *(f"with {words(step.effect)}" for step in account.waterfall)]

    def draw(axes: Axes) -> None:
        for i, rest in enumerate(remaining):
            axes.barh(
                i,
                rest,
                color=GREY if i == 0 else GREEN,
                height=0.6,
                label="remaining" if i == 1 else "_",
            )
            if i:
                taken, name = remaining[i - 1] - rest, "closed by the effect" if i == 1 else "_"
                axes.barh(i, taken, left=rest, color=ORANGE, alpha=0.45, height=0.6, label=name)
            axes.text(max(rest, 0.0) + 1.0, i, f"{rest:.1f} %", va="center", fontsize=8)
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set(
            xlabel="remaining part of the explainable gap [%]", xlim=(min(0.0, *remaining), 114.0)
        )
        axes.grid(axis="y", visible=False)

    sums = f"{closed.before:,.0f} before, {closed.after:,.0f} after, {closed.noise:,.0f} noise"
    note = f"Sums of squares over noise variance: {sums}."
    size = (4.6, 1.3 + 0.42 * len(remaining))
    return [panel("The gap, effect by effect", draw, note, size=size)]


def trace_panels(
    traces: Sequence[Trace], located: Sequence[Located], units: Units = BENCH
) -> list[Panel]:
    """Channels over time: measured minus simulated, and the change by the patch."""
    return [
        panel(
            f"{unit_without_mass(trace.channel).title}: measured minus simulated",
            partial(draw_trace, trace=trace),
            unused_words(trace),
            units=units,
        )
        for trace in telling(traces, located)[:SHOWN]
    ]


def telling(traces: Sequence[Trace], located: Sequence[Located]) -> list[Trace]:
    """Return the channels that the patch changes visibly, the clearest first; without a patch,
    those of the gap.
    """
    clear: dict[
        str, float
    ] = {}  # the change by the patch over the remaining gap, root mean squares
    for trace in traces:
        explained = trace.explained[trace.used]
        remaining = float(np.sqrt(np.mean((trace.gap[trace.used] - explained) ** 2)))
        clear[trace.channel] = float(np.sqrt(np.mean(explained**2))) / max(remaining, 1e-12)
    if max(clear.values()) > 0.0:
        visible = [trace for trace in traces if clear[trace.channel] > VISIBLE]
        return sorted(visible, key=lambda trace: -clear[trace.channel])
    by_name = {trace.channel: trace for trace in traces}
    return [by_name[place.channel] for place in located if place.channel in by_name]


def draw_trace(axes: Axes, trace: Trace) -> None:
    """Draw a residual channel, and its means over a few seconds and the change by the patch where
    it was used.
    """
    since, used, shown = trace.time - trace.time[0], trace.used, unit_without_mass(trace.channel)
    measured, patched = trace.gap / shown.factor, trace.explained / shown.factor
    shade_unused(axes, since / 60.0, used)
    low, high = np.nanpercentile(measured[used], [0.5, 99.5])
    time, gap, explained = broken(since, measured, np.where(used, patched, np.nan))
    axes.plot(
        time / 60.0, np.clip(gap, low, high), color="#BBBBBB", lw=0.5, label="measured − simulated"
    )
    middle = broken(*_averaged(since[used], measured[used]))
    axes.plot(middle[0] / 60.0, middle[1], color=BLUE, lw=1.1, label=f"{BIN:g} s means")
    if np.any(trace.explained):
        axes.plot(time / 60.0, explained, color=RED, lw=1.1, label="change by the patch")
    axes.set(xlabel="time [min]", ylabel=f"{shown.name} [{shown.unit}]")


def _averaged(time: Array, values: Array) -> tuple[Array, Array]:
    number = np.floor(time / BIN).astype(np.intp)
    count = np.maximum(np.bincount(number), 1)
    used = np.bincount(number) > 0
    return (np.bincount(number, time) / count)[used], (np.bincount(number, values) / count)[used]


def history_panels(histories: Sequence[History], units: Units = BENCH) -> list[Panel]:
    """The card flown again: the measured, the simulated and the patched history, segment after
    segment.
    """
    names = dict.fromkeys(history.quantity for history in histories)
    return [
        _history_panel(name, [h for h in histories if h.quantity == name], units) for name in names
    ]


def _history_panel(name: str, parts: Sequence[History], units: Units) -> Panel:
    def draw(axes: Axes) -> None:
        same = all(np.array_equal(h.simulated, h.patched) for h in parts)
        for i, part in enumerate(parts):
            time, *sides = thin(part.time / 60.0, part.measured, part.simulated, part.patched)
            looks = (
                (INK, "-", "measured"),
                (ORANGE, "-", "simulated"),
                (GREEN, "--", "simulated with the patch"),
            )
            for side, (color, style, label) in zip(sides, looks, strict=True):
                if not (same and color == GREEN):
                    axes.plot(time, side, color=color, ls=style, lw=1.0, label="_" if i else label)
        axes.set(xlabel="time of the log [min]", ylabel=f"{name} [{parts[0].unit}]")

    return panel(name.capitalize(), draw, units=units)


# The first picture of a reconciliation: the telling channel over time, a variable, and the ground
# track.

BINS = 12  # of the variable
FEWEST = 4  # instants of a bin that is drawn
BAND = 2.0  # standard deviations of the noise band


def telling_panels(telling: TellingChannel, units: Units = BENCH) -> list[Panel]:
    """The telling channel over time and over a variable, and the ground track, in the units of the
    field.
    """
    shown = (
        CHANNELS[telling.channel]
        if telling.mass is not None
        else unit_without_mass(telling.channel)
    )
    before, after, noise = _in_field_units(telling, shown)
    used, sides = telling.used, [(before, BLUE, "before the patch")]
    if not np.array_equal(before, after):
        sides.append((after, RED, "with the patch"))
    variable = VARIABLES[telling.variable]
    minutes = (telling.time - telling.time[0]) / 60.0
    label = f"measured − simulated [{shown.unit}]"

    def over_time(axes: Axes) -> None:
        instants = max(1, round(telling.averaged / float(np.median(np.diff(telling.time)))))
        shade_unused(axes, minutes, used)
        axes.axhspan(-BAND * noise, BAND * noise, color=PALE, label="noise (2σ)")
        for values, color, name in sides:
            means = np.full(len(values), np.nan)
            means[used] = _running(values[used], instants)
            _, time, mean = broken(telling.time, minutes, means)
            time, mean = thin(time, mean)
            axes.plot(time, mean, color=color, lw=1.2, label=name)
        axes.set(xlabel="time [min]", ylabel=label)

    def over_variable(axes: Axes) -> None:
        axes.axhspan(-BAND * noise, BAND * noise, color=PALE, label="noise (2σ)")
        of = telling.values / variable.factor
        for values, color, name in sides:
            center, middle, spread = _binned(of[used], values[used])
            axes.errorbar(
                center, middle, spread, fmt="o", ms=4, color=color, lw=1.0, capsize=2, label=name
            )
        axes.set(xlabel=f"{variable.name} [{variable.unit}]", ylabel=label)

    def over_ground(axes: Axes) -> None:
        east, north = telling.east / NAUTICAL_MILE, telling.north / NAUTICAL_MILE
        axes.plot(*thin(east, north), color=GREY, lw=1.0, label="ground track")
        far = np.where(telling.marked, 1.0, np.nan)
        axes.plot(
            *thin(east * far, north * far), color=RED, lw=3.0, label="largest quarter of the gap"
        )
        axes.plot(east[0], north[0], "o", color=GREY, ms=5)
        axes.set(xlabel="east of the start [nmi]", ylabel="north of the start [nmi]")
        axes.set_aspect("equal", adjustable="datalim")

    return [
        panel(
            f"{shown.title}, over time",
            over_time,
            f"Means of {telling.averaged:g} s.",
            NARROW,
            units=units,
        ),
        panel(
            f"The same over {variable.name}",
            over_variable,
            "Means and standard deviations of bins.",
            NARROW,
            units=units,
        ),
        panel("Where it is", over_ground, "The dot is the start.", NARROW),
    ]


def _in_field_units(telling: TellingChannel, unit: FieldUnit) -> tuple[Array, Array, float]:
    """Gap, rest and noise in the field's unit; a specific force times the mass is a force."""
    if is_force(telling.channel) and telling.mass is not None:
        scale = telling.mass / unit.factor
    else:
        scale = np.full(len(telling.gap), 1.0 / unit.factor)
    return telling.gap * scale, telling.rest * scale, telling.noise * float(np.mean(scale))


def _running(values: Array, instants: int) -> Array:
    weights = np.ones(instants)
    return np.convolve(values, weights, "same") / np.convolve(np.ones(len(values)), weights, "same")


def _binned(of: Array, values: Array) -> tuple[Array, Array, Array]:
    """Centers, means and their standard deviations, of bins with equal numbers of instants."""
    edges = np.unique(np.quantile(of, np.linspace(0.0, 1.0, BINS + 1)))
    number = np.clip(np.searchsorted(edges, of, side="right") - 1, 0, max(len(edges) - 2, 0))
    used = [number == i for i in range(max(len(edges) - 1, 1)) if np.sum(number == i) >= FEWEST]
    found = [(of[here].mean(), values[here].mean(), values[here].std()) for here in used]
    center, middle, spread = np.array(found).reshape(-1, 3).T
    return center, middle, spread
