"""The cells in which a gap is located: a channel, and a phase of flight or a variable.

Cells are columns without physics, fitted as the effects are, so that both have significances in the
same units: a gap that cells show and no effect explains is real, with an unknown cause. Phases and
variables come from the clean track, because a variable that contains the gusts, such as the angle
of attack, is correlated with the residuals by its noise.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.reconciliation.flight_path import (
    true_airspeed_along,
)
from pitotbench.reconciliation.residuals import (
    ChannelResiduals,
)
from pitotbench.reconciliation.track import Grid, Track
from pitotbench.records.verdict import where
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, Array

TURN = 12.0 * DEGREE  # bank from which the airplane turns; gusts bank it by less
VERTICAL = 2.0  # m/s of climb or descent
CHANGE = 0.25  # m/s² of airspeed
IDLE = 12.0 * INCH_OF_MERCURY
FEWEST = 12  # instants of a phase that is examined, so 6 s
SPAN = 4.0  # s over which rates are taken, so that gusts do not make a phase
MEAN_HALF_ROWS = 10  # rows on either side over which a value is averaged before its rate is taken
WITH_HEADING = ("airspeed_along", "airspeed_across", "airspeed_down")
LEAST_SPREAD = {"bank": 3.0 * DEGREE, "altitude": 30.0 * FOOT}  # less is the wander of a held state
LEAST_OTHER_SPREAD = 1e-9  # of any other variable: it has to vary at all


@dataclass(frozen=True, slots=True)
class Cell:
    """A place of the gap: a channel, and a phase of flight or a variable."""

    channel: str
    phase: str
    variable: str

    @property
    def where(self) -> str:
        """The phase of flight, or the variable."""
        return where(self.phase, self.variable)


def is_examined(cell: Cell) -> bool:
    """Return whether a cell is examined: of the heading for compass and GPS only.

    The heading does not matter to forces and engines.
    """
    return not cell.variable.startswith("heading") or cell.channel in WITH_HEADING


def phases(track: Track, grid: Grid) -> NDArray[np.str_]:
    """Return the phase of flight at every instant, (n,)."""
    speed, half = true_airspeed_along(track), max(1, round(0.5 * SPAN / track.row_period))
    names = np.full(len(grid), "level", dtype="<U12")
    acceleration = _slope(speed, grid, half, track)
    names[acceleration > CHANGE] = "acceleration"
    names[acceleration < -CHANGE] = "deceleration"
    if "altitude" in track:
        climb = _slope(track["altitude"], grid, half, track)
        names[climb > VERTICAL] = "climb"
        names[climb < -VERTICAL] = "descent"
    if "manifold_pressure_left" in track:
        names[grid.smooth(track["manifold_pressure_left"]) < IDLE] = "idle"
    if "roll" in track:
        names[np.abs(grid.smooth(track["roll"])) > TURN] = "turn"
    return names


def _slope(values: Array, grid: Grid, half: int, track: Track) -> Array:
    ahead = np.minimum(grid.rows + half, len(values) - 1)
    behind = np.maximum(grid.rows - half, 0)
    change = _mean_around(values, ahead) - _mean_around(values, behind)
    seconds = np.maximum(ahead - behind, 1) * track.row_period
    return np.asarray(change / seconds)


def _mean_around(values: Array, rows: NDArray[np.intp], half: int = MEAN_HALF_ROWS) -> Array:
    """Mean over the rows around each row."""
    around = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(values) - 1)
    return np.asarray(values[around].mean(axis=1))


def flight_variables(track: Track, grid: Grid) -> dict[str, Array]:
    """Return the variables that a gap may follow, at the instants, (n,) each [SI, radians]."""
    values = {"airspeed": grid.smooth(true_airspeed_along(track)), "time": track.time[grid.rows]}
    sources = {"bank": "roll", "altitude": "altitude", "power": "manifold_pressure_left"}
    for name, source in sources.items():
        if source in track:
            values[name] = grid.smooth(track[source])
    if "heading" in track:
        for name, way in (("heading_north", np.cos), ("heading_east", np.sin)):
            values[name] = grid.smooth(way(track["heading"]))
            values[f"{name}_twice"] = grid.smooth(way(2.0 * track["heading"]))
    if "bank" in values:
        values["bank"] = np.abs(values["bank"])
    return values


def variables(track: Track, grid: Grid) -> dict[str, Array]:
    """Return the variables of a flight that vary, each scaled to mean 0 and deviation 1, (n,)."""
    values = flight_variables(track, grid)
    spread = {name: float(np.std(each)) for name, each in values.items()}
    varying = [name for name in values if spread[name] > LEAST_SPREAD.get(name, LEAST_OTHER_SPREAD)]
    return {name: (values[name] - values[name].mean()) / spread[name] for name in varying}


def cells(track: Track, grid: Grid, base: ChannelResiduals) -> tuple[tuple[Cell, ...], Array]:
    """Return the cells of all channels, and the shape of each variable and phase, (n, k).

    Every channel has the same shapes.
    """
    phase = phases(track, grid)
    shapes = {("", name): values for name, values in variables(track, grid).items()}
    for name in np.unique(phase):
        if np.sum(phase == name) >= FEWEST:
            shapes[str(name), ""] = (phase == name).astype(np.float64)
    places = tuple(Cell(channel, *key) for channel in base.names for key in shapes)
    return places, np.stack(list(shapes.values()), axis=1)
