"""What an autopilot computes its airspeed with.

ArduPilot shows √(ARSPD_RATIO·d), with d = ±(p − ARSPD_OFFSET) of the sensor's pressure p
(ArduPilot, libraries/AP_Airspeed/AP_Airspeed.cpp, `AP_Airspeed::read`; the sign is
ARSPD_TUBE_ORDR). PX4 shows ASPD_SCALE_1·√(2d/1.225), with d = p − SENS_DPRES_OFF (PX4-Autopilot,
src/lib/airspeed/airspeed.cpp, `calc_IAS` and `calc_CAS_from_IAS`; src/modules/sensors/sensors.cpp).
Both are V² = R·d, without the compression of the air.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.catalog import Catalog, explain
from pitotbench.logbook.columns import PARAMETERS, Table, numbers
from pitotbench.records import BadInputError

_DENSITY = 1.225  # kg/m³, the constant of both autopilots
_PX4_GAIN = 2.0 / _DENSITY  # R of PX4 at scale 1
_SWAPPED = 1  # of ARSPD_TUBE_ORDR: the tubes are exchanged
_EITHER = 2  # of ARSPD_TUBE_ORDR: whichever way round gives a positive pressure
_IN_PROPORTION = 0.1  # of the ratio V²/d: half of one sensor's messages lie closer to it


@dataclass(frozen=True, slots=True)
class Autopilot:
    """An autopilot: its name, those of its parameters, and how its ratio becomes its gain.

    The parameters of a sensor begin alike, or each has a name of its own. The ratio R is in m²/s²
    per Pa.

    `pressures` are the columns of a log that hold a pressure [Pa] on which R has not acted: d, or p
    with the name of the offset that is to be subtracted. `switches` are the further settings with
    their reasons.
    """

    title: str
    prefix: str
    gain: str
    offset: str
    prefixes: tuple[str, ...]
    ratio_of: Callable[[float], float]
    gain_of: Callable[[float], float]
    pressures: Mapping[str, str]
    switches: tuple[tuple[str, float, str], ...]

    def of_sensor(self, number: int) -> "Autopilot":
        """Return the autopilot with the names of the parameters of another sensor, from 2 on."""
        if number == 1:
            return self
        prefix = f"ARSPD{number}_" if self.prefix else ""

        def own(name: str) -> str:
            name = name.replace("ASPD_SCALE_1", f"ASPD_SCALE_{number}")
            return name.replace(self.prefix, prefix, 1) if prefix else name

        return replace(
            self,
            prefix=prefix,
            gain=own(self.gain),
            offset=own(self.offset),
            prefixes=tuple(map(own, self.prefixes)),
            pressures={name: own(offset) for name, offset in self.pressures.items()},
            switches=tuple((own(name), value, why) for name, value, why in self.switches),
        )


AUTOPILOTS: Catalog[Autopilot] = Catalog(
    "autopilot",
    {
        "ardupilot": Autopilot(
            "ArduPilot", "ARSPD_", "ARSPD_RATIO", "ARSPD_OFFSET", ("ARSPD_",), float, float,
            {"DiffPress": "", "RawPress": "ARSPD_OFFSET"},
            (
                ("ARSPD_SKIP_CAL", 1.0, "else each start measures the offset anew and replaces it"),
                ("ARSPD_AUTOCAL", 0.0, "else the flight replaces the ratio"),
            ),
        ),
        "px4": Autopilot(
            "PX4", "", "ASPD_SCALE_1", "SENS_DPRES_OFF", ("ASPD_SCALE_", "SENS_DPRES_", "SENS_EN_SDP3X"),
            lambda scale: _PX4_GAIN * scale**2, lambda ratio: float(np.sqrt(ratio / _PX4_GAIN)),
            # Up to 1.12 the driver subtracted the offset and called the result raw; since 1.13 it
            # comes afterwards.
            {"differential_pressure_pa": "SENS_DPRES_OFF", "differential_pressure_raw_pa": ""},
            (("ASPD_SCALE_APPLY", 0.0, "else the flight replaces the scale"),),
        ),
    },
)  # fmt: skip


def autopilot_of(parameters: Iterable[str], sensor: int = 1) -> str:
    """Return the name of the autopilot whose gain is among parameters, empty for none."""
    known = set(parameters)
    return next((n for n, kind in AUTOPILOTS.items() if kind.of_sensor(sensor).gain in known), "")


def as_shown(table: Table, values: Mapping[str, Any], sensor: int = 1) -> Table:
    """Return a table of an autopilot's log with the airspeed parameters that it was flown with.

    `values` are all parameters that are known of the flight, by name, of which those of the
    `sensor` act on it. A pressure that the autopilot logs before its ratio acts on it, known by its
    column, becomes the impact pressure [Pa] of the airspeed that was shown, √(R·d). A table without
    such a column, or without a known ratio, stays as it is.
    """
    for kind in AUTOPILOTS.values():
        autopilot = kind.of_sensor(sensor)
        raw = autopilot.pressures.keys() & set(table.names)
        known = {
            n: float(f"{v:.7g}") for n, v in values.items() if n.startswith(autopilot.prefixes)
        }
        used = _as_used(table, known, autopilot.prefix) if raw else {}
        if autopilot.gain not in used:
            continue
        ratio, columns = autopilot.ratio_of(used[autopilot.gain]), []
        for n, column in zip(table.names, table.columns, strict=True):
            if n in raw:
                pressure = numbers(n, column)
                if offset := autopilot.pressures[n]:
                    pressure = tube_sign(used, autopilot.prefix) * (
                        pressure - used.get(offset, 0.0)
                    )
                # The impact pressure of √(R·d); a negative d, near rest, in proportion.
                flying = air.impact_pressure(np.sqrt(ratio * np.maximum(pressure, 0.0)))
                column = np.where(pressure > 0.0, flying, 0.5 * _DENSITY * ratio * pressure)
            columns.append(column)
        notes = [
            f"the airspeed is as {autopilot.title} shows it with "
            + ", ".join(f"{n} {used[n]:g}" for n in (autopilot.gain, autopilot.offset) if n in used)
        ]
        before = known.get(autopilot.offset)
        if before is not None and f"{before:g}" != f"{used[autopilot.offset]:g}":
            notes.append(
                f"{autopilot.offset} {before:g} is not used: the flight's messages hold "
                f"{used[autopilot.offset]:g}"
            )
        return replace(
            table,
            columns=tuple(columns),
            header={**table.header, PARAMETERS: used},
            warnings=(*table.warnings, *notes),
        )
    return table


def _as_used(table: Table, known: dict[str, float], prefix: str) -> dict[str, float]:
    """Return the parameters with what ArduPilot's messages say of them.

    The offset in use, which tube led, and the ratio where it is not known.
    """
    used = dict(known)
    if {"Offset", "RawPress"} <= set(table.names):
        used[f"{prefix}OFFSET"] = float(np.median(numbers("Offset", table.column("Offset"))))
        order = used.get(f"{prefix}TUBE_ORDR", used.get(f"{prefix}TUBE_ORDER", _EITHER))
        if order == _EITHER and np.median(numbers("RawPress", table.column("RawPress"))) < 0.0:
            used[f"{prefix}TUBE_ORDR"] = _SWAPPED
    if f"{prefix}RATIO" not in used and {"Airspeed", "DiffPress"} <= set(table.names):
        speed, pressure = (numbers(n, table.column(n)) for n in ("Airspeed", "DiffPress"))
        flown = (speed > 0.0) & (pressure > 0.0)
        ratios = speed[flown] ** 2 / pressure[flown]
        ratio = float(np.median(ratios)) if flown.any() else 0.0
        # Both are noisy, and the airspeed is smoothed; but one that is not of this pressure, as of
        # another sensor, is in no proportion to it.
        if ratio and np.median(np.abs(ratios - ratio)) < _IN_PROPORTION * ratio:
            used[f"{prefix}RATIO"] = float(f"{ratio:.4g}")
    return used


def tube_sign(known: Mapping[str, float], prefix: str) -> float:
    """Return −1 where the tubes of a sensor are swapped, else 1."""
    order = known.get(f"{prefix}TUBE_ORDR", known.get(f"{prefix}TUBE_ORDER"))
    return -1.0 if order == _SWAPPED else 1.0


def stated_parameters(text: str) -> tuple[str, dict[str, float]]:
    """Return the autopilot that a text names, and the old values that it states.

    Such a text: `px4`, or `ardupilot,ARSPD_RATIO=1.99,ARSPD_OFFSET=3`. Raises BadInputError for an
    unknown autopilot or a value that is not a number.
    """
    name, *parts = [part.strip() for part in text.split(",") if part.strip()] or [""]
    if name not in AUTOPILOTS:
        raise BadInputError(explain("autopilot", name, list(AUTOPILOTS)))
    stated = {}
    for part in parts:
        key, _, number = part.partition("=")
        try:
            stated[key.strip()] = float(number)
        except ValueError as error:
            wanted = AUTOPILOTS[name]
            raise BadInputError(
                f"old parameter {part!r}: write NAME=value, such as "
                f"{wanted.gain}=1.99,{wanted.offset}=3"
            ) from error
    return name, stated
