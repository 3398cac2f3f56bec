"""Where the gap is: residual by channel, phase of flight and variable, as columns that know no physics.

They are fitted as the effects are, so that their significance is in the same coin: a gap that they see and no
effect explains is a real one with an unknown cause. Phases and variables come from the clean track: a variable
that holds the gusts, as the angle of attack does, runs with the residuals by its own noise.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.reconcile.residuals.grid import Grid
from pitotbench.reconcile.residuals.predicted_channels import ChannelResiduals, true_airspeed_along
from pitotbench.reconcile.residuals.track import Track
from pitotbench.records.verdict import where
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, Array

TURN = 12.0 * DEGREE  # bank from which it is a turn
VERTICAL = 2.0  # m/s of climb or descent
CHANGE = 0.25  # m/s² of airspeed
IDLE = 12.0 * INCH_OF_MERCURY
FEWEST = 12  # instants of a phase that is looked at
SPAN = 4.0  # s over which rates are taken
WITH_HEADING = ("airspeed_along", "airspeed_across", "airspeed_down")
LEAST_SPREAD = {"bank": 3.0 * DEGREE, "altitude": 30.0 * FOOT}


@dataclass(frozen=True, slots=True)
class Cell:
    """One place to look: a channel, and a phase of flight or a variable."""

    channel: str
    phase: str
    variable: str

    @property
    def where(self) -> str:
        """The phase, or the variable over which one looks."""
        return where(self.phase, self.variable)


def is_looked_at(cell: Cell) -> bool:
    """Whether a place is one to look at: the heading matters to compass and GPS, not to forces and engines."""
    return not cell.variable.startswith("heading") or cell.channel in WITH_HEADING


def phases(track: Track, grid: Grid) -> NDArray[np.str_]:
    """The phase of flight at every instant, (n,)."""
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
    change = grid_mean(values, ahead) - grid_mean(values, behind)
    seconds = np.maximum(ahead - behind, 1) * track.row_period
    return np.asarray(change / seconds)


def grid_mean(values: Array, rows: NDArray[np.intp], half: int = 10) -> Array:
    """Mean over a few rows around each."""
    around = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(values) - 1)
    return np.asarray(values[around].mean(axis=1))


def variables(track: Track, grid: Grid) -> dict[str, Array]:
    """The variables over which a gap may run, each scaled to mean 0 and deviation 1, (n,); only those that vary."""
    found = {"airspeed": grid.smooth(true_airspeed_along(track)), "time": track.time[grid.rows]}
    sources = {"bank": "roll", "altitude": "altitude"}
    for name, source in (sources | {"power": "manifold_pressure_left"}).items():
        if source in track:
            found[name] = grid.smooth(track[source])
    if "heading" in track:
        for name, way in (("heading_north", np.cos), ("heading_east", np.sin)):
            found[name] = grid.smooth(way(track["heading"]))
            found[f"{name}_twice"] = grid.smooth(way(2.0 * track["heading"]))
    if "bank" in found:
        found["bank"] = np.abs(found["bank"])
    spread = {name: float(np.std(values)) for name, values in found.items()}
    kept = [name for name in found if spread[name] > LEAST_SPREAD.get(name, 1e-9)]
    return {name: (found[name] - found[name].mean()) / spread[name] for name in kept}


def cells(track: Track, grid: Grid, base: ChannelResiduals) -> tuple[tuple[Cell, ...], Array]:
    """The places to look and the shape in each, (n, k): one column a phase and a variable, for every channel
    alike."""
    phase = phases(track, grid)
    shapes = {("", name): values for name, values in variables(track, grid).items()}
    for name in np.unique(phase):
        if np.sum(phase == name) >= FEWEST:
            shapes[str(name), ""] = (phase == name).astype(np.float64)
    places = tuple(Cell(channel, *key) for channel in base.names for key in shapes)
    return places, np.stack(list(shapes.values()), axis=1)
