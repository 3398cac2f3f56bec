"""Pictures of a gap: its map, the part that each effect explains, the rest, and the card flown again."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import SymLogNorm
from matplotlib.patches import Rectangle

from pitotbench.records.gap import Account, GapMap, History, Trace
from pitotbench.records.verdict import Closure, Located
from pitotbench.show.field_units import unit_without_mass
from pitotbench.show.quantity_words import words
from pitotbench.show.style import BLUE, GREEN, GREY, INK, ORANGE, RED, Panel, broken, canvas, panel, svg, thin
from pitotbench.show.unused_instants import shade_unused
from pitotbench.units import Array

SHOWN = 6  # channels over time
VISIBLE = 0.1  # of the remaining gap: a smaller change by the patch cannot be read from a picture
BIN = 4.0  # s: long enough to average the sensor noise, short enough for the phases of a maneuver


def map_panels(found: GapMap) -> list[Panel]:
    """The map of the gap without and with the named effects in the model, on one scale."""
    scale = max(2.0 * found.threshold, float(np.nanmax(np.abs(found.before))))
    note = (
        f"Flights without an effect stay below {found.threshold:.1f}σ; cells above it are framed. "
        "Positive: the measured value is larger."
    )
    tables = [("Where the gap is [σ]", found.before)]
    if np.any(found.before != found.after):
        tables.append(("The remaining gap [σ]", found.after))
    return [_map_panel(title, found, values, scale, note) for title, values in tables]


def _map_panel(title: str, found: GapMap, values: Array, scale: float, note: str) -> Panel:
    width, height = 2.6 + 0.5 * len(found.places), 1.5 + 0.24 * len(found.channels)
    with canvas(1, 1, width, height) as (figure, (axes,)):
        norm = SymLogNorm(linthresh=found.threshold, vmin=-scale, vmax=scale)
        image = axes.imshow(values, cmap="RdBu_r", norm=norm, aspect="auto")
        axes.set_xticks(range(len(found.places)), [words(p) for p in found.places], rotation=55, ha="right")
        axes.set_yticks(range(len(found.channels)), [words(c) for c in found.channels])
        axes.tick_params(labelsize=9, length=0)
        axes.grid(visible=False)
        for row, column in zip(*np.nonzero(np.abs(np.nan_to_num(values)) > found.threshold), strict=True):
            _mark(axes, int(row), int(column), float(values[row, column]), float(norm(values[row, column])))
        bar = figure.colorbar(
            image, ax=axes, shrink=0.8, ticks=[-scale, -found.threshold, 0, found.threshold, scale]
        )
        bar.ax.set_yticklabels([f"{t:+.0f}" for t in (-scale, -found.threshold, 0, found.threshold, scale)])
        bar.set_label("significance [σ]", fontsize=9)
        bar.ax.tick_params(labelsize=9)
        return Panel(title, svg(figure, title), note)


def _mark(axes: Axes, row: int, column: int, value: float, shade: float) -> None:
    """Draw a frame and the number, light on a dark shade (0 to 1, 0.5 is white)."""
    axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fill=False, edgecolor=INK, linewidth=0.8))
    color = "white" if abs(shade - 0.5) > 0.33 else INK
    axes.text(column, row, f"{value:+.0f}", ha="center", va="center", fontsize=9, color=color)


def waterfall_panel(account: Account) -> Panel:
    """The explainable gap, and the part of it that remains as effect after effect is added."""
    closed = account.rounds[0].verdict.closure
    whole = max(closed.before - closed.noise, 1e-9)
    remaining = [100.0, *(100.0 * (step.left - closed.noise) / whole for step in account.waterfall)]
    names = ["as measured", *(f"with {words(step.effect)}" for step in account.waterfall)]

    def draw(axes: Axes) -> None:
        for i, rest in enumerate(remaining):
            axes.barh(i, rest, color=GREY if i == 0 else GREEN, height=0.6, label="remaining" if i == 1 else "_")
            if i:
                taken, name = remaining[i - 1] - rest, "closed by the effect" if i == 1 else "_"
                axes.barh(i, taken, left=rest, color=ORANGE, alpha=0.45, height=0.6, label=name)
            axes.text(max(rest, 0.0) + 1.0, i, f"{rest:.1f} %", va="center", fontsize=8)
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set(xlabel="remaining part of the explainable gap [%]", xlim=(min(0.0, *remaining), 114.0))
        axes.grid(axis="y", visible=False)

    sums = f"{closed.before:,.0f} before, {closed.after:,.0f} after, {closed.noise:,.0f} noise"
    note = f"Sums of squares over noise variance: {sums}."
    return panel("The gap, effect by effect", draw, note, size=(4.6, 1.3 + 0.42 * len(remaining)))


def before_after_panel(closures: Sequence[tuple[str, Closure]]) -> Panel:
    """The gap without and with the patch, on the fitted and on the held-out log."""
    size = (4.6, 1.3 + 0.6 * len(closures))
    return panel("Before and after", lambda axes: draw_closures(axes, closures), size=size)


def draw_closures(axes: Axes, closures: Sequence[tuple[str, Closure]]) -> None:
    """Draw two bars a log, the explainable gap without and with the patch, and the share closed, G."""
    for i, (_, closed) in enumerate(closures):
        axes.barh(
            i - 0.2, closed.before - closed.noise, color=GREY, height=0.36, label="_" if i else "without the patch"
        )
        after = max(closed.after - closed.noise, 0.0)
        axes.barh(i + 0.2, after, color=GREEN, height=0.36, label="_" if i else "with the patch")
        closed_share = f"{100.0 * closed.share:.1f} % closed (G = {closed.share:.3f})"
        axes.annotate(
            closed_share, (after, i + 0.2), (4.0, 0.0), textcoords="offset points", va="center", fontsize=8
        )
    axes.set_yticks(range(len(closures)), [name for name, _ in closures])
    axes.invert_yaxis()
    axes.set(xlabel="explainable gap, sum of squares over noise variance")
    axes.grid(axis="y", visible=False)


def trace_panels(traces: Sequence[Trace], located: Sequence[Located]) -> list[Panel]:
    """Channels over time: measured minus simulated, and the change by the patch."""
    return [_trace_panel(trace) for trace in telling(traces, located)[:SHOWN]]


def telling(traces: Sequence[Trace], located: Sequence[Located]) -> list[Trace]:
    """Return the channels that the patch changes visibly, the clearest first; without a patch, those of the gap."""
    clear = {trace.channel: _clearness(trace) for trace in traces}
    if max(clear.values()) > 0.0:
        visible = [trace for trace in traces if clear[trace.channel] > VISIBLE]
        return sorted(visible, key=lambda trace: -clear[trace.channel])
    by_name = {trace.channel: trace for trace in traces}
    return [by_name[place.channel] for place in located if place.channel in by_name]


def _clearness(trace: Trace) -> float:
    """The change by the patch over the remaining gap, root mean squares."""
    explained = trace.explained[trace.used]
    remaining = float(np.sqrt(np.mean((trace.gap[trace.used] - explained) ** 2)))
    return float(np.sqrt(np.mean(explained**2))) / max(remaining, 1e-12)


def _trace_panel(trace: Trace) -> Panel:
    return panel(unit_without_mass(trace.channel).title, lambda axes: draw_trace(axes, trace))


def draw_trace(axes: Axes, trace: Trace) -> None:
    """Draw a residual channel, and its means over a few seconds and the change by the patch where it was used."""
    since, used, shown = trace.time - trace.time[0], trace.used, unit_without_mass(trace.channel)
    measured, patched = trace.gap / shown.factor, trace.explained / shown.factor
    shade_unused(axes, since / 60.0, used)
    low, high = np.nanpercentile(measured[used], [0.5, 99.5])
    time, gap, explained = broken(since, measured, np.where(used, patched, np.nan))
    axes.plot(time / 60.0, np.clip(gap, low, high), color="#BBBBBB", lw=0.5, label="measured − simulated")
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


def history_panels(histories: Sequence[History]) -> list[Panel]:
    """The card flown again: the measured, the simulated and the patched history, segment after segment."""
    names = dict.fromkeys(history.quantity for history in histories)
    return [_history_panel(name, [h for h in histories if h.quantity == name]) for name in names]


def _history_panel(name: str, parts: Sequence[History]) -> Panel:
    def draw(axes: Axes) -> None:
        same = all(np.array_equal(h.simulated, h.patched) for h in parts)
        for i, part in enumerate(parts):
            time, *sides = thin(part.time / 60.0, part.measured, part.simulated, part.patched)
            for side, color, label, style in zip(
                sides,
                (INK, ORANGE, GREEN),
                ("measured", "simulated", "simulated with the patch"),
                ("-", "-", "--"),
                strict=True,
            ):
                if not (same and color == GREEN):
                    axes.plot(time, side, color=color, ls=style, lw=1.0, label="_" if i else label)
        axes.set(xlabel="time of the log [min]", ylabel=f"{name} [{parts[0].unit}]")

    return panel(name.capitalize(), draw)
