"""A guess: what a column of a foreign log may be; and what a log needs."""

from collections.abc import Sequence
from dataclasses import dataclass

from pitotbench.logbook.columns import HEIGHT, Table, clock_seconds, is_clock, numbers
from pitotbench.units import Array, to_si


@dataclass(frozen=True, slots=True)
class Guess:
    """What a column may be.

    Our quantity, the units that are possible (the likeliest first), and how well the name fits, 0
    to 1. `stated` says that the unit is written in the file, or that the values prove it. `factor`
    turns the number into the unit's. `doubt` is a question that the values raise.
    """

    theirs: str
    quantity: str
    units: tuple[str, ...]
    score: float
    stated: bool
    factor: float = 1.0
    doubt: str = ""

    def target(self) -> str:
        """Return our column name, with the likeliest unit."""
        return f"{self.quantity}_{self.units[0]}" if self.units[0] else self.quantity

    def values(self, table: Table) -> Array:
        """Return the values [SI] of the column, (n,), in the likeliest unit."""
        column = table.column(self.theirs)
        if self.quantity == "time" and is_clock(column):
            return clock_seconds(self.theirs, column)
        return to_si(numbers(self.theirs, column) * self.factor, self.units[0])


HEIGHTS = ("static_pressure", "pressure_altitude", "indicated_altitude", "height_above_takeoff")
NEEDED = (
    ("time",),
    (
        "impact_pressure",
        "total_pressure",
        "indicated_airspeed",
        "calibrated_airspeed",
        "mach",
        "true_airspeed",
    ),
    HEIGHTS,
    ("velocity_north", "ground_speed", "latitude"),
    ("velocity_east", "track", "magnetic_track", "longitude"),
)


def missing(table: Table, chosen: Sequence[Guess]) -> tuple[str, ...]:
    """The needed quantities that neither a guess nor what is stated of the flight gives."""
    here = {guess.quantity for guess in chosen} | (
        {HEIGHTS[0]} if HEIGHT in table.header else set()
    )
    return tuple(" or ".join(names) for names in NEEDED if not here & set(names))
