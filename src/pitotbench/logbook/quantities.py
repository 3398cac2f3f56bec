"""Read column names, which are a quantity and a unit suffix, such as `static_pressure_hpa`."""

from math import pi

from pitotbench.catalog import explain
from pitotbench.channels import CHANNELS, Channel
from pitotbench.records.errors import BadInputError
from pitotbench.units import SUFFIXES

# Read, but not kept: `derived` and `checks` turn them into channels of a log.
CONVERTED = (
    Channel("pa", "air", 5e3, 270e3, essential=True, name="total_pressure"),
    Channel("mps", "air", 0.0, 350.0, essential=True, name="indicated_airspeed"),
    Channel("mps", "air", 0.0, 350.0, essential=True, name="calibrated_airspeed"),
    Channel("m", "air", 0.0, 25e3, essential=True, name="pressure_altitude"),
    Channel("m", "air", 0.0, 25e3, essential=True, name="indicated_altitude"),
    Channel("pa", "air", 80e3, 120e3, essential=True, name="altimeter_setting"),
    Channel("mps", "gps", 0.0, 700.0, essential=True, name="ground_speed"),
    Channel("rad", "gps", 0.0, 2.0 * pi, essential=True, wraps=True, name="track"),
    Channel("rad", "gps", 0.0, 2.0 * pi, essential=True, wraps=True, name="magnetic_track"),
    Channel("rad", "inertial", 0.0, 2.0 * pi, wraps=True, name="magnetic_heading"),
    Channel("rad", "inertial", 0.0, pi, name="magnetic_variation"),
    Channel("", "clock", 0.0, 0.0, essential=True, kind="text", name="clock_time"),
    Channel("", "clock", 0.0, 0.0, kind="text", name="date"),
)
QUANTITIES: dict[str, Channel] = CHANNELS | {quantity.name: quantity for quantity in CONVERTED}
_LONGEST_FIRST = sorted(QUANTITIES, key=len, reverse=True)  # roll_rate before roll


def parse_column(column: str) -> tuple[Channel, str] | None:
    """Return the quantity and the unit suffix of a column name; None for a name that is not in the table.

    Raises BadInputError for a quantity of the table whose unit is missing, unknown or of another dimension.
    """
    for name in _LONGEST_FIRST:
        rest = column.removeprefix(name)
        # `altitude_m` is ours; `altitude_mean_m`, with two words after the quantity, is another quantity.
        if rest == column or (rest and (rest[0] != "_" or "_" in rest[1:])):
            continue
        quantity, suffix = QUANTITIES[name], rest[1:]
        _check_suffix(column, quantity, suffix)
        return quantity, suffix
    return None


def _check_suffix(column: str, quantity: Channel, suffix: str) -> None:
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
