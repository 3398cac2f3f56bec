"""The linear model of an airplane at a trim."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import log

from pitotbench.records import freeze_arrays
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode of motion: a real eigenvalue [1/s], or the upper one of a complex pair.

    `name` is the field's, `mode` where none fits, or `coupled mode` of one that is longitudinal and
    lateral at once.
    """

    name: str
    eigenvalue: complex

    @property
    def frequency(self) -> float:
        """The natural frequency [rad/s]: the size of the eigenvalue."""
        return abs(self.eigenvalue)

    @property
    def damping(self) -> float | None:
        """The damping ratio: 1 of a real mode that dies out, -1 of one that grows."""
        return -self.eigenvalue.real / self.frequency if self.eigenvalue else None

    @property
    def half(self) -> float | None:
        """The time to half the amplitude [s]; that to double it with a minus sign."""
        return -log(2.0) / self.eigenvalue.real if self.eigenvalue.real else None


@dataclass(frozen=True, slots=True, kw_only=True)
class LinearModel:
    """The linear model dx/dt = A x + B u of small changes from level flight, n states, m inputs.

    `mass` [kg], `height` [m] and `calibrated_airspeed` [m/s] are those of level flight.
    `roll_acceleration` [rad/s²] is left there, because ailerons and rudder are centered. `states`
    and `inputs` hold units by name in the order of rows and columns; `trim` (n,) and `setting` (m,)
    are their values in level flight. `system_matrix` is A (n, n), `input_matrix` B (n, m): an entry
    has the unit of its row per second and per unit of its column.
    """

    aircraft: str
    mass: float
    height: float
    calibrated_airspeed: float
    roll_acceleration: float
    states: Mapping[str, str]
    inputs: Mapping[str, str]
    trim: Array
    setting: Array
    system_matrix: Array
    input_matrix: Array
    modes: tuple[Mode, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, len(self.states), "setting", "system_matrix", "input_matrix")
