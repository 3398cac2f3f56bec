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
    GRAY,
    GREEN,
    INK,
    NARROW,
    ORANGE,
    RED,
    Mark,
    Panel,
    bars,
    broken,
    canvas,
    dots,
    drawing,
    frame,
    ground,
    line,
    panel,
    stripe,
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

_SHADE = "#F0E0D0"  # unlike the gray of a noise band


def unused_words(trace: Trace) -> str:
    """Return why some instants are shaded, and their share; empty where all were used."""
    if np.all(trace.used):
        return ""
    share = 100.0 * float(np.mean(~trace.used))
    return (
        f"Shaded: {share:.1f} % of the flight that was not used, because the impact pressure stood "
        "at the end of its sensor's range or the Mach number was above the limit."
    )


def unused_marks(time: Array, used: Booleans) -> list[Mark]:
    """The stretches of time [min], (n,), that are not used, (n,), in a color of their own."""
    half = 0.5 * interval(time)
    changes = (
        np.flatnonzero((np.diff(used.astype(np.int8)) != 0) | (np.diff(time) > 3.0 * half)) + 1
    )
    spans = [
        (time[part.start] - half, time[part.stop - 1] + half)
        for part in stretches(time, changes)
        if not used[part.start]
    ]
    return [
        partial(Axes.axvspan, xmin=begin, xmax=end, color=_SHADE, lw=0.0, label="not used")
        for begin, end in spans
    ]


SHOWN = 6  # channels over time
VISIBLE = 0.1  # of the remaining gap: a smaller change by the patch cannot be read from a picture
BIN = 4.0  # s: long enough to average the sensor noise, short enough for the phases of a maneuver


def map_panels(found: GapMap, _: Units = BENCH) -> list[Panel]:
    """Return the map of the remaining gap, then that without the named effects, on one scale."""
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
            # light on a dark shade
            color = "white" if abs(float(norm(value)) - 0.5) > 0.33 else INK
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

    steps = range(len(remaining))
    taken = -np.diff(remaining)
    colors, labels = [GRAY, *[GREEN] * len(taken)], ["_", "remaining", *["_"] * len(taken)]
    draw = drawing(
        lambda axes: axes.barh(
            steps, remaining, color=colors, height=0.6, label=labels[: len(remaining)]
        ),
        lambda axes: axes.barh(
            steps[1:], taken, left=remaining[1:], color=ORANGE, alpha=0.45, height=0.6,
            label="closed by the effect",
        ),
        *(
            partial(
                Axes.text, x=max(share, 0.0) + 1.0, y=row, s=f"{share:.1f} %", va="center",
                fontsize=8,
            )
            for row, share in enumerate(remaining)
        ),
        lambda axes: axes.set_yticks(steps, names),
        lambda axes: axes.invert_yaxis(),
        frame(
            "remaining part of the explainable gap [%]", "",
            xlim=(min(0.0, *remaining), 1.14 * max(remaining)),
        ),
        lambda axes: axes.grid(axis="y", visible=False),
    )  # fmt: skip
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
            drawing(*trace_marks(trace)),
            unused_words(trace),
            units=units,
        )
        for trace in telling(traces, located)[:SHOWN]
    ]


def telling(traces: Sequence[Trace], located: Sequence[Located]) -> list[Trace]:
    """Return the channels that the patch changes visibly, else those of the gap.

    The clearest change comes first.
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


def trace_marks(trace: Trace) -> list[Mark]:
    """Return the marks of a residual channel and of its means over a few seconds.

    The change by the patch is drawn where it was used.
    """
    since, used, shown = trace.time - trace.time[0], trace.used, unit_without_mass(trace.channel)
    measured, patched = trace.gap / shown.factor, trace.explained / shown.factor
    low, high = np.nanpercentile(measured[used], [0.5, 99.5])
    time, gap, explained = broken(since, measured, np.where(used, patched, np.nan))
    middle, means = broken(*_averaged(since[used], measured[used]))
    change = [explained] if np.any(trace.explained) else []
    gray, minutes = "#BBBBBB", time / 60.0
    return [
        *unused_marks(since / 60.0, used),
        line(minutes, np.clip(gap, low, high), color=gray, lw=0.5, label="measured − simulated"),
        line(middle / 60.0, means, lw=1.1, label=f"{BIN:g} s means"),
        *(line(minutes, each, color=RED, lw=1.1, label="change by the patch") for each in change),
        frame("time [min]", f"{shown.name} [{shown.unit}]"),
    ]


def _averaged(time: Array, values: Array) -> tuple[Array, Array]:
    number = np.floor(time / BIN).astype(np.intp)
    count = np.maximum(np.bincount(number), 1)
    used = np.bincount(number) > 0
    return (np.bincount(number, time) / count)[used], (np.bincount(number, values) / count)[used]


def history_panels(histories: Sequence[History], units: Units = BENCH) -> list[Panel]:
    """Return a card's measured, simulated and patched history, segment after segment."""
    names = dict.fromkeys(history.quantity for history in histories)
    return [
        _history_panel(name, [h for h in histories if h.quantity == name], units) for name in names
    ]


def _history_panel(name: str, parts: Sequence[History], units: Units) -> Panel:
    sides = {"measured": (INK, "-"), "simulated": (ORANGE, "-")}
    if not all(np.array_equal(h.simulated, h.patched) for h in parts):
        sides["patched"] = (GREEN, "--")
    draw = drawing(
        *(
            line(*thin(part.time / 60.0, getattr(part, side)), color=color, ls=style, lw=1.0,
                 label=side.replace("patched", "simulated with the patch"))
            for side, (color, style) in sides.items()
            for part in parts
        ),
        frame("time of the log [min]", f"{name} [{parts[0].unit}]"),
    )  # fmt: skip
    return panel(name.capitalize(), draw, units=units)


BINS = 12  # of the variable
FEWEST = 4  # instants of a bin that is drawn
BAND = 2.0  # standard deviations of the noise band


def telling_panels(telling: TellingChannel, units: Units = BENCH) -> list[Panel]:
    """Return the telling channel over time and a variable, and the ground track, in field units."""
    shown = (
        CHANNELS[telling.channel]
        if telling.mass is not None
        else unit_without_mass(telling.channel)
    )
    before, after, noise = _in_field_units(telling, shown)
    sides = [(before, BLUE, "before the patch")]
    if not np.array_equal(before, after):
        sides.append((after, RED, "with the patch"))
    variable, used = VARIABLES[telling.variable], telling.used
    minutes = (telling.time - telling.time[0]) / 60.0
    label = f"measured − simulated [{shown.unit}]"
    instants = max(1, round(telling.averaged / float(np.median(np.diff(telling.time)))))
    noise_band = stripe(-BAND * noise, BAND * noise, label="noise (2σ)")

    def means(values: Array) -> list[Array]:
        averaged = np.full(len(values), np.nan)
        averaged[used] = _running(values[used], instants)
        return thin(*broken(telling.time, minutes, averaged)[1:])

    over_time = drawing(
        *unused_marks(minutes, used),
        noise_band,
        *(line(*means(values), color=c, lw=1.2, label=name) for values, c, name in sides),
        frame("time [min]", label),
    )
    of = telling.values[used] / variable.factor
    look = {"fmt": "o", "ms": 4, "lw": 1.0, "capsize": 2}
    over_variable = drawing(
        noise_band,
        *(bars(*_binned(of, v[used]), color=c, label=name, **look) for v, c, name in sides),
        frame(f"{variable.name} [{variable.unit}]", label),
    )
    east, north = telling.east / NAUTICAL_MILE, telling.north / NAUTICAL_MILE
    far = np.where(telling.marked, 1.0, np.nan)
    largest = "largest quarter of the gap"
    over_ground = drawing(
        line(*thin(east, north), color=GRAY, lw=1.0, label="ground track"),
        line(*thin(east * far, north * far), color=RED, lw=3.0, label=largest),
        dots(east[:1], north[:1], marker="o", ms=5),
        frame("east of the start [nmi]", "north of the start [nmi]"),
        ground,
    )
    averaged = f"Means of {telling.averaged:g} s."
    bins = "Means and standard deviations of bins."
    return [
        panel(f"{shown.title}, over time", over_time, averaged, NARROW, units=units),
        panel(f"The same over {variable.name}", over_variable, bins, NARROW, units=units),
        panel("Where it is", over_ground, "The dot is the start.", NARROW),
    ]


def _in_field_units(telling: TellingChannel, unit: FieldUnit) -> tuple[Array, Array, float]:
    """Return gap, unexplained part and noise in the field's unit.

    A specific force times the mass is a force.
    """
    if is_force(telling.channel) and telling.mass is not None:
        scale = telling.mass / unit.factor
    else:
        scale = np.full(len(telling.gap), 1.0 / unit.factor)
    return telling.gap * scale, telling.unexplained * scale, telling.noise * float(np.mean(scale))


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
