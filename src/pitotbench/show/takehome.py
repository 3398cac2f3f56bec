"""What people take home from a calibration: parameters to set, tables for the handbook, two curves compared."""

from collections.abc import Mapping, Sequence
from csv import writer
from dataclasses import dataclass
from html import escape
from io import StringIO
from typing import TYPE_CHECKING, Any

import numpy as np

from pitotbench import air
from pitotbench.records import BadInputError
from pitotbench.records.calibration import AutopilotSettings, ErrorCurve, Estimate, Setting
from pitotbench.show.columns import Column, html_table, json_rows, outside, print_table
from pitotbench.show.markup import render
from pitotbench.units import FOOT, KNOT, Array, Meters, MetersPerSecond

if TYPE_CHECKING:
    from rich.console import Console

# The parameters of an autopilot, for a terminal and as plain data.

SETTING_COLUMNS: tuple[Column[Setting], ...] = (
    Column("parameter", lambda s: s.name, key="name"),
    Column("set to", lambda s: s.value, style=".5g", key="value"),
    Column("±2σ", lambda s: s.two_sigma, style=".2g", key="two_sigma"),
    Column("old", lambda s: s.old, style=".5g", key="old"),
    Column("from", lambda s: s.source, key="from"),
)


def print_settings(found: AutopilotSettings, console: "Console") -> None:
    """Print the parameters to set, what they leave of the error, and a propeller's wash."""
    console.print()
    print_table(SETTING_COLUMNS, found.settings, console, f"parameters of {found.autopilot}")
    for line in settings_lines(found):
        console.print(outside(line))


def settings_lines(found: AutopilotSettings) -> list[str]:
    """What the new parameters leave of the error, and the wash of a propeller where power was recorded."""
    speed, bound = found.calibrated_airspeed / KNOT, found.bound / KNOT
    places = sorted({0, len(speed) // 2, len(speed) - 1})
    left = ", ".join(f"±{bound[at]:.2f} kt at {speed[at]:.0f} KCAS" for at in places)
    return [f"With them the airspeed shown is right within {left} (2σ of the curve and what the formula leaves).",
            _wash_line(found.wash)]  # fmt: skip


def _wash_line(wash: Estimate | None) -> str:
    if wash is None:
        return "A propeller's wash was not looked for: the log holds neither throttle nor power."
    if not np.isfinite(wash.two_sigma):
        return "A propeller's wash cannot be told: power follows airspeed here. Fly one speed in climb and descent."
    size = f"{wash.value / KNOT:+.2f} ± {wash.two_sigma / KNOT:.2f} kt at full power against idle (2σ)".replace(
        "-", "−"
    )
    if abs(wash.value) <= wash.two_sigma:
        return f"No wash of a propeller shows: the airspeed reads {size}."
    return f"A propeller's wash shows: the airspeed reads {size}. No parameter takes it out: move the tube."


def settings_json(found: AutopilotSettings | None) -> dict[str, Any]:
    """The parameters as plain data; nothing where they were not asked for."""
    if found is None:
        return {}
    wash = found.wash
    rows = zip(found.calibrated_airspeed / KNOT, found.bound / KNOT, strict=True)
    return {
        "params": json_rows(SETTING_COLUMNS, found.settings),
        "params_bound": [{"calibrated_airspeed_kt": float(v), "bound_kt": float(b)} for v, b in rows],
        "wash": None if wash is None else {"value_kt": wash.value / KNOT, "two_sigma_kt": wash.two_sigma / KNOT},
    }


# Two curves compared.

_STEP_KT = 10.0  # between the airspeeds of a sentence
_FEWEST_COMMON = 2


@dataclass(frozen=True, slots=True)
class CurveDifference:
    """The correction of the second curve minus that of the first [m/s] at common indicated airspeeds [m/s], (n,).

    Where it is positive, the second airspeed indicator reads lower. `two_sigma` (n,) is pointwise;
    `simultaneous_two_sigma` (n,) holds at all airspeeds at once. Errors of the two curves are taken as independent.
    """

    first: str
    second: str
    indicated_airspeed: MetersPerSecond
    difference: MetersPerSecond
    two_sigma: MetersPerSecond
    simultaneous_two_sigma: MetersPerSecond

    @property
    def differs(self) -> bool:
        """Whether the curves differ somewhere by more than the band that holds everywhere at once."""
        return bool(np.any(np.abs(self.difference) > self.simultaneous_two_sigma))


def curve_difference(first: str, one: ErrorCurve, second: str, other: ErrorCurve) -> CurveDifference:
    """Compare two curves with their names. Raises BadInputError where they have no airspeeds in common."""
    spans = [(float(c.indicated_airspeed[0]), float(c.indicated_airspeed[-1])) for c in (one, other)]
    low, high = max(a for a, _ in spans), min(b for _, b in spans)
    every = np.union1d(one.indicated_airspeed, other.indicated_airspeed)
    speed = every[(every >= low) & (every <= high)]
    if len(speed) < _FEWEST_COMMON:
        told = " and ".join(f"{a / KNOT:.0f} to {b / KNOT:.0f} KIAS" for a, b in spans)
        raise BadInputError(f"the curves have no airspeeds in common ({told}): fly the same range with both")

    def at(curve: ErrorCurve, values: Array) -> Array:
        return np.interp(speed, curve.indicated_airspeed, values)

    return CurveDifference(
        first,
        second,
        speed,
        at(other, other.correction) - at(one, one.correction),
        np.hypot(at(one, one.two_sigma), at(other, other.two_sigma)),
        np.hypot(at(one, one.simultaneous_two_sigma), at(other, other.simultaneous_two_sigma)),
    )


def difference_sentence(found: CurveDifference) -> str:
    """Say in one sentence where the second airspeed indicator reads lower or higher, and where none shows."""
    speed, value, bound = (a / KNOT for a in (found.indicated_airspeed, found.difference, found.two_sigma))
    if not found.differs:
        at = int(np.argmin(np.abs(speed - speed.mean())))
        return (
            f"{found.second} reads the same as {found.first} from {speed[0]:.0f} to {speed[-1]:.0f} KIAS: no "
            f"difference shows, and at {speed[at]:.0f} KIAS one of ±{bound[at]:.1f} kt (2σ) would."
        )
    clear = np.abs(value) > bound
    told = []
    for side, word in ((1.0, "lower"), (-1.0, "higher")):
        rows = np.flatnonzero(clear & (side * value > 0.0))
        if len(rows):
            at = int(rows[np.argmax(np.abs(value[rows]) - bound[rows])])
            told.append(f"{abs(value[at]):.1f} ± {bound[at]:.1f} kt {word} at {speed[at]:.0f} KIAS")
    known = np.flatnonzero(clear)
    ends = []
    if known[0] > 0:
        ends.append(f"below {speed[known[0]]:.0f}")
    if known[-1] < len(speed) - 1:
        ends.append(f"above {speed[known[-1]]:.0f}")
    rest = f"; no difference {' or '.join(ends)}" if ends else ""
    return f"{found.second} reads {' and '.join(told)} than {found.first}{rest} (± is 2σ)."


_DifferenceRow = tuple[float, float, float]
DIFFERENCE_COLUMNS: tuple[Column[_DifferenceRow], ...] = (
    Column("KIAS", lambda r: r[0], "kt", ".0f", "indicated_airspeed_kt"),
    Column("difference of the corrections", lambda r: r[1], "kt", "+.2f", "difference_kt"),
    Column("±2σ", lambda r: r[2], "kt", ".2f", "two_sigma_kt"),
)


def _difference_rows(found: CurveDifference) -> list[_DifferenceRow]:
    columns = (a / KNOT for a in (found.indicated_airspeed, found.difference, found.two_sigma))
    return [(float(v), float(d), float(b)) for v, d, b in zip(*columns, strict=True)]


def print_difference(found: CurveDifference, console: "Console") -> None:
    """Print the sentence and the table of two curves compared."""
    console.print(outside(difference_sentence(found)))
    console.print()
    rows = _difference_rows(found)
    step = max(1, -(-len(rows) // 13))
    print_table(DIFFERENCE_COLUMNS, rows[::step], console, f"{found.second} less {found.first}")


def difference_json(found: CurveDifference) -> dict[str, Any]:
    """Two curves compared as plain data."""
    return {
        "first": found.first,
        "second": found.second,
        "curve": json_rows(DIFFERENCE_COLUMNS, _difference_rows(found)),
        "differs": found.differs,
        "summary": difference_sentence(found),
    }


def difference_page(found: CurveDifference, one: ErrorCurve, other: ErrorCurve) -> str:
    """The page of two curves compared: the sentence, a picture of both with their difference, the table."""
    from pitotbench.show.curves import difference_drawing

    return render(
        "takehome.html",
        title=f"{found.second} against {found.first}",
        lines=[difference_sentence(found)],
        drawing=difference_drawing(found, one, other),
        tables=[("The difference in numbers", html_table(DIFFERENCE_COLUMNS, _difference_rows(found)))],
        notes=[
            "The errors of the two curves are taken as independent. An error that both share, such as that of one "
            "thermometer, cancels: the 2σ is then too large."
        ],
    )


# Tables for a handbook: calibrated by indicated airspeed, and the altitude correction by height and airspeed.

_HEIGHTS_FT = (0, 5000, 10000, 15000, 20000)
TABLES = (".csv", ".html", ".xml")


@dataclass(frozen=True, slots=True)
class HandbookRow:
    """A line of the tables: a configuration, an indicated airspeed and its calibrated one [m/s] with 2σ, and the
    altitude correction [m] with 2σ at each of `heights` [m]; none where the static source is right."""

    configuration: str
    indicated: float
    calibrated: float
    two_sigma: float
    heights: tuple[float, ...]
    altitude: tuple[tuple[float, float], ...]


def handbook_rows(curves: Mapping[str, ErrorCurve], heights_ft: Sequence[float] = _HEIGHTS_FT) -> list[HandbookRow]:
    """Return a line for each airspeed of each configuration; airspeeds are those of the curves."""
    heights = tuple(h * FOOT for h in heights_ft)
    rows = []
    for name, curve in curves.items():
        by_height = (
            [altitude_correction(curve, height) for height in heights]
            if curve.altitude_correction is not None
            else []
        )
        for at, speed in enumerate(curve.indicated_airspeed):
            rows.append(
                HandbookRow(
                    name, float(speed), float(speed + curve.correction[at]), float(curve.two_sigma[at]),
                    heights if by_height else (), tuple((float(v[at]), float(b[at])) for v, b in by_height),
                )
            )  # fmt: skip
    return rows


def altitude_correction(curve: ErrorCurve, height: float) -> tuple[Meters, Meters]:
    """Return true minus indicated pressure altitude [m] and 2σ at an indicated pressure altitude [m], (n,) each.

    The static source reads Δp too high, with Δp/q_c of the curve at all heights (Gracey, NASA RP-1046, 1980). The
    2σ grows with height as the correction does.
    """
    impact = air.impact_pressure(curve.indicated_airspeed + curve.correction)
    pressure = float(air.standard_pressure(height))

    def corrected(normalized: Array) -> Meters:
        return air.pressure_altitude(pressure - normalized * impact) - height

    found = corrected(curve.normalized_pressure_error)
    bound = np.abs(corrected(curve.normalized_pressure_error + curve.normalized_two_sigma) - found)
    if curve.altitude_correction is not None and curve.altitude_two_sigma is not None:
        # Where the place of the error is assumed, the curve's own 2σ holds zero, and so does this one.
        assumed = curve.altitude_two_sigma >= np.abs(curve.altitude_correction)
        bound = np.where(assumed, np.maximum(bound, np.abs(found)), bound)
    return found, bound


def _handbook_columns(rows: Sequence[HandbookRow]) -> list[Column[HandbookRow]]:
    columns: list[Column[HandbookRow]] = [
        Column("configuration", lambda r: r.configuration or None, key="configuration", optional=True),
        Column("KIAS", lambda r: r.indicated / KNOT, "kt", ".0f", "indicated_airspeed_kt"),
        Column("KCAS", lambda r: r.calibrated / KNOT, "kt", ".1f", "calibrated_airspeed_kt"),
        Column("±2σ", lambda r: r.two_sigma / KNOT, "kt", ".1f", "two_sigma_kt"),
    ]
    heights = next((row.heights for row in rows if row.heights), ())
    for place, height in enumerate(heights):
        label = f"{height / FOOT:,.0f} ft"
        key = f"_at_{height / FOOT:.0f}_ft"

        def value(row: HandbookRow, place: int = place) -> float | None:
            return row.altitude[place][0] / FOOT if row.altitude else None

        def bound(row: HandbookRow, place: int = place) -> float | None:
            return row.altitude[place][1] / FOOT if row.altitude else None

        columns.append(Column(f"add to the altimeter at {label}", value, "ft", "+.0f", f"altitude_correction{key}"))
        columns.append(Column("±2σ", bound, "ft", ".0f", f"altitude_two_sigma{key}"))
    return columns


def handbook_csv(curves: Mapping[str, ErrorCurve]) -> str:
    """The tables as CSV: one line an airspeed and configuration; the unit ends each column's name."""
    rows = handbook_rows(curves)
    columns = [c for c in _handbook_columns(rows) if not (c.optional and all(c.value(r) is None for r in rows))]
    text = StringIO()
    lines = writer(text, lineterminator="\n")
    lines.writerow(column.key for column in columns)
    for row in rows:
        values = [column.value(row) for column in columns]
        lines.writerow("" if v is None else format(v, ".3f") if isinstance(v, float) else v for v in values)
    return text.getvalue()


def handbook_page(curves: Mapping[str, ErrorCurve], subject: str) -> str:
    """The tables as a page to print, a table for each configuration."""
    tables = []
    for name, curve in curves.items():
        rows = handbook_rows({"": curve})
        kept = [row for row in rows if round(row.indicated / KNOT) % 5 == 0] or rows
        tables.append((name or "Airspeed and altimeter", html_table(_handbook_columns(rows), kept)))
    return render(
        "takehome.html",
        title=f"Airspeed calibration: {subject}",
        lines=["Read KCAS beside KIAS. Add the altitude correction to the altimeter's reading."],
        drawing="",
        tables=tables,
        notes=[
            "± is 2σ: the true value lies inside in 95 % of calibrations. KIAS is the instrument's reading without "
            "an error of its own."
        ],
    )


_SYSTEM_PROPERTY = "instrumentation/airspeed-indicator/indicated-speed-kt"


def jsbsim_system(curve: ErrorCurve, subject: str) -> str:
    """A JSBSim system whose airspeed indicator reads as the airplane's: the indicated airspeed by calibrated one.

    Beyond the curve the outer correction stays. Raises BadInputError where an indicated airspeed belongs to two
    calibrated ones.
    """
    indicated = curve.indicated_airspeed / KNOT
    calibrated = indicated + curve.correction / KNOT
    if np.any(np.diff(calibrated) <= 0.0):
        raise BadInputError("the calibrated airspeed does not grow with the indicated one: no instrument reads so")
    off = float(indicated[0] - calibrated[0])
    # Beyond its rows a JSBSim table holds the outer value: far rows keep the outer correction instead.
    rows = [
        (max(-off, 0.0), max(off, 0.0)),
        *zip(calibrated, indicated, strict=True),
        (calibrated[-1] + 1000.0, indicated[-1] + 1000.0),
    ]
    data = "\n".join(f"            {v:.4f} {i:.4f}" for v, i in rows)
    return f"""<?xml version="1.0"?>
<!-- The airspeed indicator of {escape(subject.replace("--", "-"))}. Put this file into the aircraft's folder
     Systems, and <system file="NAME"/> (this file's name without .xml) into the aircraft's file. -->
<system name="airspeed indicator">
  <channel name="indicated airspeed">
    <fcs_function name="{_SYSTEM_PROPERTY}">
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


def table_text(suffix: str, curves: Mapping[str, ErrorCurve], subject: str) -> str:
    """The curves of the configurations in the form that a file's suffix asks for: .csv, .html or .xml (JSBSim).

    Raises BadInputError for an .xml of several configurations: the simulator has one airspeed indicator.
    """
    if suffix == ".csv":
        return handbook_csv(curves)
    if suffix == ".html":
        return handbook_page(curves, subject)
    if len(curves) > 1:
        raise BadInputError(
            f"a JSBSim system reads one curve, and there are {len(curves)} ({', '.join(curves)}): give one log, or "
            "a card of one configuration"
        )
    return jsbsim_system(next(iter(curves.values())), subject)
