"""The scene of a log: the clean track, its residuals, and the force meter where there is an aircraft model.

All that depends on a hypothesis starts here: signatures of effects and columns of free parameters are changes of
the residuals of the scene.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from pitotbench.effects import Baseline, Overlay
from pitotbench.reconcile.residuals.clean import clean_track
from pitotbench.reconcile.residuals.grid import Grid, grid_of
from pitotbench.reconcile.residuals.predicted_channels import ChannelResiduals, Frame, channel_residuals
from pitotbench.reconcile.residuals.replay import COARSE, Replay, answer, motion_of, replay_rows
from pitotbench.reconcile.residuals.track import Track
from pitotbench.reconcile.signatures.added_forces import properties_of_forces
from pitotbench.records.motion import Motion, Reaction, UnitForces
from pitotbench.units import Array

# The force meter: a motion, the overlay to put on the aircraft, and whether the engines run along.
ReactWith = Callable[[Motion, Overlay, bool], Reaction]
# The changes by unit forces: a motion, the overlay on the aircraft, and the paths of properties to record.
UnitForcesWith = Callable[[Motion, Overlay, frozenset[str]], UnitForces]


@dataclass(frozen=True, slots=True)
class AircraftModel:
    """The analyst's model of an aircraft: a force meter that takes overlays, and the data that effects need."""

    name: str
    react: ReactWith
    unit_forces: UnitForcesWith
    baseline: Baseline


@dataclass(frozen=True, slots=True)
class ForceModel:
    """An aircraft model on the force meter along one log.

    `replay` is its answer along the measured track. `coarse` is the motion of the clean track in steps of 1 s.
    `units` are the changes by unit forces in that motion, with the properties that the functions of all effects
    read. What was measured in that motion is kept: `unchanged` by whether the engines run, `kept` by overlay.
    """

    replay: Replay
    aircraft: AircraftModel
    coarse: Motion
    units: UnitForces
    kept: dict[Overlay, Array] = field(default_factory=dict)
    unchanged: dict[bool, Array] = field(default_factory=dict)

    def missing(self, overlay: Overlay, engines_run: bool) -> Array:
        """Return the reaction without an overlay less that with it, on the force meter, (m, 12)."""
        if overlay not in self.kept:
            self.kept[overlay] = self._without(engines_run) - self._measured(self.coarse, overlay, engines_run)
        return self.kept[overlay]

    def moved_by(self, motion: Motion) -> Array:
        """Return the reaction to another motion at the instants of `coarse` less that to `coarse`, (m, 12)."""
        return self._measured(motion, Overlay(), True) - self._without(True)

    def _without(self, engines_run: bool) -> Array:
        if engines_run not in self.unchanged:
            self.unchanged[engines_run] = self._measured(self.coarse, Overlay(), engines_run)
        return self.unchanged[engines_run]

    def _measured(self, motion: Motion, overlay: Overlay, engines_run: bool) -> Array:
        return answer(lambda motion: self.aircraft.react(motion, overlay, engines_run), motion)


@dataclass(frozen=True, slots=True)
class Scene:
    """The data from which signatures and free parameters are computed.

    `base` are the residuals of the clean track. `force_model` is None where sensors alone are judged.
    """

    clean: Track
    grid: Grid
    frame: Frame
    base: ChannelResiduals
    force_model: ForceModel | None

    @property
    def replay(self) -> Replay | None:
        """The model's answer along the measured track; None without a model."""
        return None if self.force_model is None else self.force_model.replay

    def residuals_of(self, track: Track) -> ChannelResiduals:
        """Return the residual channels of a track, with the grid, frame and model of this scene."""
        return channel_residuals(track, self.grid, self.frame, self.replay, (self.clean, self.base))

    def change_by(self, track: Track) -> Array:
        """Return the residuals of a track less those of the clean track, (n, c)."""
        return self.residuals_of(track).values - self.base.values

    def blank(self) -> Array:
        """Return zeros of the shape of the residuals, (n, c), to be filled for single channels."""
        return np.zeros_like(self.base.values)

    def channel(self, name: str) -> int | None:
        """Return the column of a residual channel; None where the log does not have it."""
        return self.base.places.get(name)


def set_scene(
    track: Track,
    wind: Array,
    replay: Replay | None,
    aircraft: AircraftModel | None,
    kept: Mapping[Overlay, Array] | None = None,
) -> Scene:
    """Return the scene of a track.

    `wind` toward north, east, down [m/s], (3,), is the wind of the clean track. `replay` and `aircraft` are both
    None where sensors alone are judged. `kept` holds what is already measured of the aircraft in this track.
    """
    grid = grid_of(track)
    frame = Frame.of(track, grid)
    clean = clean_track(track, wind)
    base = channel_residuals(clean, grid, frame, replay)
    if replay is None or aircraft is None:
        return Scene(clean, grid, frame, base, None)
    coarse = motion_of(clean, replay_rows(clean, COARSE))
    units = aircraft.unit_forces(coarse, Overlay(), properties_of_forces(aircraft.baseline))
    return Scene(clean, grid, frame, base, ForceModel(replay, aircraft, coarse, units, dict(kept or {})))
