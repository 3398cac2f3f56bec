"""Read column names, which are a quantity and a unit suffix, such as `static_pressure_hpa`."""

from pitotbench.catalog import explain
from pitotbench.channels import CHANNELS, Channel
from pitotbench.records.errors import BadInputError
from pitotbench.units import SUFFIXES

_CONVERTED = (Channel("pa", "air", 5e3, 270e3, essential=True, name="total_pressure"),)  # read, but not kept
QUANTITIES: dict[str, Channel] = CHANNELS | {quantity.name: quantity for quantity in _CONVERTED}
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
