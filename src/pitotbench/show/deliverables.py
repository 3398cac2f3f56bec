"""What people take home: parameters to set, and tables for the handbook."""

from collections.abc import Mapping, Sequence
from html import escape
from types import MappingProxyType
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.records import BadInputError
from pitotbench.records.calibration import (
    AutopilotSettings,
    ErrorCurve,
    Estimate,
    PublishedCurve,
    Setting,
)
from pitotbench.records.log import Provenance
from pitotbench.show.columns import Column, csv_text, json_rows
from pitotbench.show.tree import Doubt, Heading, Node, Sentence, Table
from pitotbench.units import FOOT, KNOT, Array, Meters

SETTING_COLUMNS: tuple[Column[Setting], ...] = (
    Column("parameter", lambda s: s.name, key="name"),
    Column("set to", lambda s: s.value, style=".5g", key="value"),
    Column("±2σ", lambda s: s.two_sigma, style=".2g", key="two_sigma"),
    Column("old", lambda s: s.old, style=".5g", key="old"),
    Column("from", lambda s: s.source, key="from"),
)


def settings_lines(found: AutopilotSettings) -> list[str]:
    """Return what the new parameters leave of the error.

    The wash of a propeller is said where power was recorded.
    """
    speed, bound = found.calibrated_airspeed / KNOT, found.bound / KNOT
    places = sorted({0, len(speed) // 2, len(speed) - 1})
    left = ", ".join(f"±{bound[at]:.2f} kt at {speed[at]:.0f} KCAS" for at in places)
    first = (
        f"With them the airspeed shown is right within {left} (2σ of the curve and what the "
        "formula leaves)."
    )
    return [first, _wash_line(found.wash)]


def _wash_line(wash: Estimate | None) -> str:
    if wash is None:
        return "A propeller's wash was not looked for: the log holds neither throttle nor power."
    if not np.isfinite(wash.two_sigma):
        return (
            "Not checked for propeller wash: power and speed changed together. Fly one speed in "
            "climb and in descent."
        )
    size = (
        f"{wash.value / KNOT:+.2f} ± {wash.two_sigma / KNOT:.2f} kt at full power against idle (2σ)"
    )
    if abs(wash.value) <= wash.two_sigma:
        return f"No wash of a propeller shows: the airspeed reads {size}."
    return (
        f"A propeller's wash shows: the airspeed reads {size}. No parameter takes it out: move "
        "the tube."
    )


# What a ground station loads, by autopilot: the suffix of the file, and a line of it for a setting
# and the kind of its number. Mission Planner and MAVProxy read NAME,VALUE. QGroundControl reads
# vehicle, component, name, value and MAVLink's type, 6 for whole numbers and 9 for others
# (`ParameterManager::writeParametersToStream`). All pass over `#`.
PARAMETER_FILES = {
    "ardupilot": (".param", "{0.name},{0.value:.9g}"),
    "px4": (".params", "1\t1\t{0.name}\t{0.value:.9g}\t{1}"),
}


def parameter_file(found: AutopilotSettings) -> str:
    """The parameters as a file that a ground station loads, with the source of each above them."""
    line = PARAMETER_FILES[found.autopilot][1]
    rows = (line.format(s, "6" if s.two_sigma is None else "9") for s in found.settings)
    return "\n".join([*(f"# {s.name}: {s.source}" for s in found.settings), *rows, ""])


def settings_json(found: AutopilotSettings | None) -> dict[str, Any]:
    """The parameters as plain data; nothing where they were not asked for."""
    if found is None:
        return {}
    wash = found.wash
    rows = zip(found.calibrated_airspeed / KNOT, found.bound / KNOT, strict=True)
    return {
        "params": json_rows(SETTING_COLUMNS, found.settings),
        "params_bound": [
            {"calibrated_airspeed_kt": float(v), "bound_kt": float(b)} for v, b in rows
        ],
        "wash": None
        if wash is None
        else {"value_kt": wash.value / KNOT, "two_sigma_kt": wash.two_sigma / KNOT},
    }


_HEIGHTS_FT = (0, 5000, 10000, 15000, 20000)  # of the columns of an altimeter table
TABLES = (".csv", ".html", ".xml")


def _handbook(curve: ErrorCurve) -> list[Column[int]]:
    """Return the columns for the airspeeds of a curve, and the altimeter's where its source errs.

    The static source has to be known to err. The heights go to the first above the flight.
    """

    def column(heading: str, unit: str, key: str, style: str, values: Array) -> Column[int]:
        return Column(heading, lambda row: float(values[row]), unit, style, key)

    known = curve.altitude_correction is not None and not curve.altitude_assumed
    above = next((h for h in _HEIGHTS_FT if h * FOOT >= curve.highest), _HEIGHTS_FT[-1])
    columns = [
        column("KIAS", "", "indicated_airspeed_kt", ".0f", curve.indicated_airspeed_kt),
        column("KCAS", "", "calibrated_airspeed_kt", ".1f", curve.calibrated_airspeed_kt),
        column("±2σ", "kt", "two_sigma_kt", ".1f", curve.two_sigma_kt),
    ]
    for height in [h for h in _HEIGHTS_FT if h <= above] if known else []:
        value, bound = (each / FOOT for each in altitude_correction(curve, height * FOOT))
        at, heading = f"at_{height}_ft", f"add to the altimeter at {height:,} ft"
        columns.append(column(heading, "ft", f"altitude_correction_{at}", "+.0f", value))
        columns.append(column("±2σ", "ft", f"altitude_two_sigma_{at}", ".0f", bound))
    return columns


def altitude_correction(curve: ErrorCurve, height: float) -> tuple[Meters, Meters]:
    """Return true minus indicated pressure altitude [m] and its 2σ at an indicated one [m], (n,).

    The static source reads Δp too high, with Δp/q_c of the curve at all heights (Gracey, NASA
    RP-1046, 1980). The 2σ grows with height as the correction does.
    """
    impact = air.impact_pressure(curve.indicated_airspeed + curve.correction)
    pressure = float(air.standard_pressure(height))

    def corrected(normalized: Array) -> Meters:
        return air.pressure_altitude(pressure - normalized * impact) - height

    found = corrected(curve.normalized_pressure_error)
    bound = np.abs(corrected(curve.normalized_pressure_error + curve.normalized_two_sigma) - found)
    # Where the place of the error is assumed, there may be no error of the altitude at all.
    return found, np.maximum(bound, np.abs(found)) if curve.altitude_assumed else bound


Doubts = Mapping[str, Sequence[str]]  # of the curve of a configuration
_NONE: Doubts = MappingProxyType({})
_UNKNOWN = Provenance()
_BLANK = "_" * 24


def who_and_when(made: Provenance) -> str:
    """Return the airplane and the day of the flight for the top of a sheet.

    A line is left to fill in what the log does not tell.
    """
    return f"Airplane: {made.airplane or _BLANK}. Flown on: {made.flown or _BLANK}."


def handbook_csv(
    curves: Mapping[str, ErrorCurve], doubts: Doubts = _NONE, made: Provenance = _UNKNOWN
) -> str:
    """Return the tables as CSV: one line an airspeed and configuration.

    The unit ends each column's name. The first row of a configuration has its doubts, that of the
    table the airplane and the day.
    """
    return csv_text(
        [
            ({"configuration": name} if any(curves) else {})
            | {column.key: column.value(row) for column in _handbook(curve)}
            | (
                {"doubts": " ".join(doubts.get(name, ()))}
                if row == 0 and any(doubts.values())
                else {}
            )
            for name, curve in curves.items()
            for row in range(len(curve.indicated_airspeed))
        ],
        airplane=made.airplane,
        flown_on=made.flown,
    )


def handbook_page(
    curves: Mapping[str, ErrorCurve],
    subject: str,
    doubts: Doubts = _NONE,
    made: Provenance = _UNKNOWN,
) -> str:
    """The tables as a page to print, a table for each configuration below its doubts."""
    from pitotbench.show.markup import page_of  # loads Jinja

    lines = (
        "Read KCAS beside KIAS. Add the altitude correction, where there is one, to the reading of "
        "the altimeter. ± is 2σ: the true value lies inside in 95 % of calibrations. KIAS is the "
        "instrument's reading without an error of its own."
    )
    parts = []
    for name, curve in curves.items():
        every = range(len(curve.indicated_airspeed))
        kept = [
            row for row in every if round(float(curve.indicated_airspeed_kt[row])) % 5 == 0
        ] or every
        nodes: list[Node] = [*map(Doubt, doubts.get(name, ())), Table(_handbook(curve), kept)]
        parts.append(Heading(name or "Airspeed and altimeter", tuple(nodes)))
    return page_of(
        f"Airspeed calibration: {subject}", [Sentence(who_and_when(made)), Sentence(lines), *parts]
    )


def jsbsim_system(
    curve: ErrorCurve | PublishedCurve, subject: str, doubts: Sequence[str] = ()
) -> str:
    """Return a JSBSim system whose airspeed indicator reads as the airplane's, by a curve.

    The curve, measured or published, gives the indicated airspeed by the calibrated one; beyond it
    the outer correction stays. The doubts stand in the system's comment. Raises BadInputError where
    an indicated airspeed belongs to two calibrated ones.
    """
    indicated = curve.indicated_airspeed / KNOT
    calibrated = indicated + curve.correction / KNOT
    if np.any(np.diff(calibrated) <= 0.0):
        raise BadInputError(
            "the calibrated airspeed does not grow with the indicated one: no instrument reads so"
        )
    off = float(indicated[0] - calibrated[0])
    # Beyond its rows a JSBSim table holds the outer value: far rows keep the outer correction
    # instead.
    rows = [
        (max(-off, 0.0), max(off, 0.0)),
        *zip(calibrated, indicated, strict=True),
        (calibrated[-1] + 1000.0, indicated[-1] + 1000.0),
    ]
    data = "\n".join(f"            {v:.4f} {i:.4f}" for v, i in rows)
    about = " ".join([subject, *doubts])
    return f"""<?xml version="1.0"?>
<!-- The airspeed indicator of {escape(about.replace("--", "-"))}. Put this file into the aircraft's folder
     Systems, and <system file="NAME"/> (this file's name without .xml) into the aircraft's file. -->
<system name="airspeed indicator">
  <channel name="indicated airspeed">
    <fcs_function name="instrumentation/airspeed-indicator/indicated-speed-kt">
      <function>
        <table>
          <independentVar lookup="row">velocities/vc-kts</independentVar>
          <tableData>
{data}
          </tableData>
        </table>
      </function>
    </fcs_function>
  </channel>
</system>
"""


def table_text(
    suffix: str,
    curves: Mapping[str, ErrorCurve],
    subject: str,
    doubts: Doubts = _NONE,
    made: Provenance | None = None,
) -> str:
    """Return the configurations' curves in the form of a suffix: .csv, .html or .xml (JSBSim).

    `made` names the airplane and the day. Raises BadInputError for an .xml of several
    configurations: the simulator has one airspeed indicator.
    """
    made = made or _UNKNOWN
    if suffix == ".csv":
        return handbook_csv(curves, doubts, made)
    if suffix == ".html":
        return handbook_page(curves, subject, doubts, made)
    if len(curves) > 1:
        raise BadInputError(
            f"a JSBSim system reads one curve, and there are {len(curves)} ({', '.join(curves)}): "
            "give one log, or a card of one configuration"
        )
    ((name, curve),) = curves.items()
    about = ", ".join(filter(None, (subject, made.airplane, made.flown)))
    return jsbsim_system(curve, about, doubts.get(name, ()))
