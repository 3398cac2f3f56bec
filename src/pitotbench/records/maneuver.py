"""Measured maneuvers, each with the forces that were felt in it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from pitotbench.records import check_lengths, freeze
from pitotbench.records.motion import Motion
from pitotbench.units import Array

CHANNELS = ("drag", "side force", "lift", "roll moment", "pitch moment", "yaw moment")


@dataclass(frozen=True, slots=True)
class Maneuver:
    """A maneuver with what was felt in it; arrays (n,) in SI units and radians, body axes.

    `specific_force` (n, 3) [m/s²] and `angular_acceleration` (n, 3) [rad/s²] are measured. `thrust`
    [N] is that of all engines along the body's x axis; None where it was not measured. `mass` [kg]
    and `inertia` (I_xx, I_yy, I_zz, I_xz) [kg m²] are None where those of the model count.
    `channels` are those of `CHANNELS` that the log can show: without a measured sideslip, not those
    of side force, roll and yaw. `noise` are the deviations of the errors left in fields of the
    motion that change from sample to sample, in their units. Raises RecordError where lengths
    differ.
    """

    name: str
    motion: Motion
    specific_force: Array
    angular_acceleration: Array
    thrust: Array | None = None
    mass: Array | None = None
    inertia: tuple[float, ...] | None = None
    channels: tuple[str, ...] = CHANNELS
    noise: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        arrays = {
            name: value
            for name in ("specific_force", "angular_acceleration", "thrust", "mass")
            if (value := getattr(self, name)) is not None
        }
        columns = (
            (name, column)
            for name, each in arrays.items()
            for column in np.atleast_2d(np.transpose(each))
        )
        check_lengths("Maneuver", columns, len(self.motion.time))
        for name, array in arrays.items():
            object.__setattr__(self, name, freeze(np.asarray(array, dtype=np.float64)))


@dataclass(frozen=True, slots=True)
class Maneuvers:
    """The maneuvers of a file, which stand for a log: the vane in time, and each with a mass.

    `header` has what was corrected or assumed as `warnings`.
    """

    maneuvers: tuple[Maneuver, ...]
    header: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
