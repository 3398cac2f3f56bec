"""The first picture of a reconciliation: the telling channel over time, a variable, and the ground track."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from pitotbench.records.gap import TellingChannel
from pitotbench.show.field_units import CHANNELS, VARIABLES, FieldUnit, is_force, unit_without_mass
from pitotbench.show.style import BLUE, GREY, NARROW, PALE, RED, Panel, broken, panel, thin
from pitotbench.show.unused_instants import shade_unused
from pitotbench.units import NAUTICAL_MILE, Array

BINS = 12  # of the variable
FEWEST = 4  # instants of a bin that is drawn
BAND = 2.0  # standard deviations of the noise band


@dataclass(frozen=True, slots=True)
class TellingDrawing:
    """A drawing of the telling channel: `draw` fills axes, `title` and `note` are the text beside them."""

    title: str
    draw: Callable[[Axes], None]
    note: str


def telling_panels(telling: TellingChannel) -> list[Panel]:
    """The panels of the telling channel, in the units of the field."""
    return [panel(each.title, each.draw, each.note, NARROW) for each in telling_drawings(telling)]


def telling_drawings(telling: TellingChannel) -> list[TellingDrawing]:
    """The telling channel over time and over a variable, and the ground track, in the units of the field."""
    shown = _unit(telling)
    before, after, noise = _in_field_units(telling, shown)
    used, sides = telling.used, [(before, BLUE, "before the patch")]
    if not np.array_equal(before, after):
        sides.append((after, RED, "with the patch"))
    variable = VARIABLES[telling.variable]
    minutes = (telling.time - telling.time[0]) / 60.0
    label = f"measured − simulated [{shown.unit}]"
    seconds = f"{telling.averaged:g} s"

    def over_time(axes: Axes) -> None:
        instants = max(1, round(telling.averaged / float(np.median(np.diff(telling.time)))))
        shade_unused(axes, minutes, used)
        axes.axhspan(-BAND * noise, BAND * noise, color=PALE, label="noise (2σ)")
        for values, color, name in sides:
            means = np.full(len(values), np.nan)
            means[used] = _running(values[used], instants)
            time, mean = thin(*_without_pauses(telling.time, minutes, means))
            axes.plot(time, mean, color=color, lw=1.2, label=name)
        axes.set(xlabel="time [min]", ylabel=label)

    def over_variable(axes: Axes) -> None:
        axes.axhspan(-BAND * noise, BAND * noise, color=PALE, label="noise (2σ)")
        of = telling.values / variable.factor
        for values, color, name in sides:
            center, middle, spread = _binned(of[used], values[used])
            axes.errorbar(center, middle, spread, fmt="o", ms=4, color=color, lw=1.0, capsize=2, label=name)
        axes.set(xlabel=f"{variable.name} [{variable.unit}]", ylabel=label)

    def over_ground(axes: Axes) -> None:
        east, north = telling.east / NAUTICAL_MILE, telling.north / NAUTICAL_MILE
        axes.plot(*thin(east, north), color=GREY, lw=1.0, label="ground track")
        far = np.where(telling.marked, 1.0, np.nan)
        axes.plot(*thin(east * far, north * far), color=RED, lw=3.0, label="largest quarter of the gap")
        axes.plot(east[0], north[0], "o", color=GREY, ms=5)
        axes.set(xlabel="east of the start [nmi]", ylabel="north of the start [nmi]")
        axes.set_aspect("equal", adjustable="datalim")

    return [
        TellingDrawing(f"{shown.title}, over time", over_time, f"Means of {seconds}."),
        TellingDrawing(f"The same over {variable.name}", over_variable, "Means and standard deviations of bins."),
        TellingDrawing("Where it is", over_ground, "The dot is the start."),
    ]


def _unit(telling: TellingChannel) -> FieldUnit:
    return CHANNELS[telling.channel] if telling.mass is not None else unit_without_mass(telling.channel)


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


def _without_pauses(time: Array, minutes: Array, values: Array) -> tuple[Array, Array]:
    """Minutes and values with a NaN at each pause of the recording."""
    _, at, broken_values = broken(time, minutes, values)
    return at, broken_values


def _binned(of: Array, values: Array) -> tuple[Array, Array, Array]:
    """Centers, means and their standard deviations, of bins with equal numbers of instants."""
    edges = np.unique(np.quantile(of, np.linspace(0.0, 1.0, BINS + 1)))
    number = np.clip(np.searchsorted(edges, of, side="right") - 1, 0, max(len(edges) - 2, 0))
    used = [number == i for i in range(max(len(edges) - 1, 1)) if np.sum(number == i) >= FEWEST]
    center = np.array([of[here].mean() for here in used])
    middle = np.array([values[here].mean() for here in used])
    spread = np.array([values[here].std() for here in used])
    return center, middle, spread
