"""The closed table of what a log may hold, and how a column name is read: quantity, then unit suffix."""

from dataclasses import dataclass

from pitotbench.catalog import explain
from pitotbench.records.errors import BadInputError
from pitotbench.units import SUFFIXES

_PI = 3.141592653589793


@dataclass(frozen=True, slots=True)
class Quantity:
    """One quantity: its canonical unit suffix ("" for a plain number) and the kind of its values.

    `low` ≤ median of |x| and 95 % quantile of |x| ≤ `high` [SI] is what an airplane can show; outside it the unit
    is wrong or the sensor dead. Of an `essential` quantity that is an error, any other is left out.
    """

    name: str
    unit: str
    low: float
    high: float
    essential: bool = False
    kind: str = "number"

    @property
    def column(self) -> str:
        """The canonical column name."""
        return f"{self.name}_{self.unit}" if self.unit else self.name

    @property
    def suffixes(self) -> list[str]:
        """The unit suffixes that a column of this quantity may end in."""
        return [s for s, u in SUFFIXES.items() if self.unit and u.dimension == SUFFIXES[self.unit].dimension]


_ANY = float("inf")
_TABLE = (
    Quantity("time", "s", 0.0, _ANY, essential=True),
    Quantity("impact_pressure", "pa", 0.0, 150e3, essential=True),
    Quantity("total_pressure", "pa", 5e3, 270e3, essential=True),
    Quantity("static_pressure", "pa", 5e3, 120e3, essential=True),
    Quantity("total_temperature", "k", 180.0, 450.0, essential=True),
    Quantity("air_temperature", "k", 180.0, 335.0, essential=True),
    Quantity("velocity_north", "mps", 0.0, 700.0, essential=True),
    Quantity("velocity_east", "mps", 0.0, 700.0, essential=True),
    Quantity("velocity_down", "mps", 0.0, 300.0),
    Quantity("altitude", "m", 0.0, 25e3),
    Quantity("roll", "rad", 0.0, 2.0 * _PI),
    Quantity("pitch", "rad", 0.0, 0.5 * _PI),
    Quantity("heading", "rad", 0.0, 2.01 * _PI),
    Quantity("roll_rate", "radps", 0.0, 10.0),
    Quantity("pitch_rate", "radps", 0.0, 10.0),
    Quantity("yaw_rate", "radps", 0.0, 10.0),
    Quantity("specific_force_x", "mps2", 0.0, 100.0),
    Quantity("specific_force_y", "mps2", 0.0, 100.0),
    Quantity("specific_force_z", "mps2", 3.0, 100.0),
    Quantity("angle_of_attack", "rad", 0.0, 0.5 * _PI),
    Quantity("sideslip", "rad", 0.0, 0.5 * _PI),
    Quantity("throttle_left", "", 0.0, 1.1),
    Quantity("throttle_right", "", 0.0, 1.1),
    Quantity("elevator", "rad", 0.0, 0.5 * _PI),
    Quantity("aileron", "rad", 0.0, 0.5 * _PI),
    Quantity("rudder", "rad", 0.0, 0.5 * _PI),
    Quantity("manifold_pressure_left", "pa", 5e3, 400e3),
    Quantity("manifold_pressure_right", "pa", 5e3, 400e3),
    Quantity("propeller_speed_left", "radps", 0.0, 1000.0),
    Quantity("propeller_speed_right", "radps", 0.0, 1000.0),
    Quantity("fuel_flow_left", "kgps", 0.0, 3.0),
    Quantity("fuel_flow_right", "kgps", 0.0, 3.0),
    Quantity("mass", "kg", 0.1, 700e3),
    Quantity("gps_fresh", "", 0.0, 1.0, kind="flag"),
    Quantity("segment", "", 0.0, 0.0, kind="text"),
    Quantity("on_condition", "", 0.0, 1.0, kind="flag"),
)
QUANTITIES: dict[str, Quantity] = {q.name: q for q in _TABLE}
_LONGEST_FIRST = sorted(QUANTITIES, key=len, reverse=True)  # roll_rate before roll


def parse_column(column: str) -> tuple[Quantity, str] | None:
    """The quantity and unit suffix of a column name; None for a column that is none of ours.

    Raises BadInputError for a quantity of the table without a unit, or with one that is unknown or of another
    dimension.
    """
    for name in _LONGEST_FIRST:
        rest = column.removeprefix(name)
        if rest == column or (rest and (rest[0] != "_" or "_" in rest[1:])):
            continue
        quantity, suffix = QUANTITIES[name], rest[1:]
        _check_suffix(column, quantity, suffix)
        return quantity, suffix
    return None


def _check_suffix(column: str, quantity: Quantity, suffix: str) -> None:
    if suffix in quantity.suffixes or (not suffix and not quantity.unit):
        return
    if not quantity.unit:
        raise BadInputError(f"column {column!r}: {quantity.name} has no unit; name the column {quantity.name!r}")
    usable = ", ".join(f"{quantity.name}_{s}" for s in quantity.suffixes)
    if not suffix:
        raise BadInputError(f"column {column!r} does not say its unit; name it {usable}")
    if suffix in SUFFIXES:
        raise BadInputError(
            f"column {column!r}: {suffix!r} is a unit of {SUFFIXES[suffix].dimension}, but {quantity.name} is of "
            f"{SUFFIXES[quantity.unit].dimension}; name it {usable}"
        )
    raise BadInputError(f"column {column!r}: {explain('unit suffix', suffix, list(SUFFIXES))} Name it {usable}.")
