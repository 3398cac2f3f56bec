"""The airspeed sensors of a log: which there are, and the one whose airspeed is calibrated."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TypeVar

from pitotbench.logbook.columns import SENSOR, Table, numbered
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution

T = TypeVar("T")


def chosen(sensors: Mapping[int, tuple[str, T]], number: int | None) -> tuple[int, T, list[str]]:
    """Return the sensor of a number, the first for None, and remarks that name the others.

    `sensors` hold a name and what it is, by number; the number and what it is are returned. Raises
    BadInputError for a sensor that the log does not hold.
    """
    taken = min(sensors) if number is None else number
    names = ", ".join(f"{each} {name}" for each, (name, _) in sorted(sensors.items()))
    if taken not in sensors:
        raise BadInputError(
            f"--airspeed-sensor {number}: the log holds "
            + (
                f"the airspeed sensors {names}"
                if len(sensors) > 1
                else f"one airspeed sensor, {names}"
            )
        )
    name, found = sensors[taken]
    notes: list[str] = [  # a Caution: another sensor would give another number
        Caution(
            f"the log holds {len(sensors)} airspeed sensors ({names}): this is {name}; "
            f"--airspeed-sensor {other} takes {sensors[other][0]}",
            "several sensors",
        )
        for other in sorted(sensors.keys() - {taken})[:1]
    ]
    return taken, found, notes


def of_sensor(table: Table, number: int | None) -> Table:
    """Return a table with the columns of one of its airspeed sensors in the place of the first.

    `impact_pressure_2_pa` and its like are the second sensor's; a static pressure that it does not
    have is the first one's. Raises as `chosen` does.
    """
    if SENSOR in table.header:
        return table
    found = [(*numbered(name), name) for name in table.names]
    sensors = {
        each: (name, None) for plain, each, name in reversed(found) if plain.startswith(AIRSPEEDS)
    }
    if not sensors:
        return table
    taken, _, notes = chosen(sensors, number)
    if not notes:
        return table
    static = any(each == taken and plain.startswith(_STATIC) for plain, each, _ in found)
    kept = {
        plain: place
        for place, (plain, each, _) in enumerate(found)
        if each == taken or (each == 1 and not plain.startswith((*AIRSPEEDS, *[_STATIC] * static)))
    }
    return replace(
        table,
        names=tuple(kept),
        columns=tuple(table.columns[place] for place in kept.values()),
        units=tuple(table.units[place] for place in kept.values()) if table.units else (),
        header={**table.header, SENSOR: taken},
        warnings=(*table.warnings, *notes),
    )


_STATIC = "static_pressure"
AIRSPEEDS = ("impact_pressure", "total_pressure", "indicated_airspeed", "calibrated_airspeed")
