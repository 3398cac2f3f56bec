"""What people take home: parameters to set, tables for the handbook, two curves compared, records
for the file.
"""

from collections.abc import Iterable, Mapping, Sequence
from csv import writer
from dataclasses import dataclass, replace
from html import escape
from io import StringIO
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from pitotbench import air
from pitotbench.records import BadInputError
from pitotbench.records.calibration import (
    AutopilotSettings,
    CalibratedFlight,
    Calibration,
    ErrorCurve,
    Estimate,
    PublishedCurve,
    Setting,
    WindEstimate,
    WindowWind,
)
from pitotbench.records.log import Provenance
from pitotbench.records.verdict import Check
from pitotbench.show.calibration import (
    FAILED_BY,
    GEOMETRY,
    GLANCE_COLUMNS,
    HEADINGS,
    calibration_json,
    condition_lines,
    flight_json,
    glance_points,
    handbook_lines,
    headline,
    short_answer_of,
)
from pitotbench.show.columns import Column, html_table, json_rows, outside, print_table
from pitotbench.show.legs import points_json
from pitotbench.show.limits import AUTO, Limit, judgments
from pitotbench.show.markup import render
from pitotbench.show.words import words
from pitotbench.timeline import minutes_text
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


def settings_html(found: AutopilotSettings) -> str:
    """The parameters to set and what they leave of the error, as a part of a page."""
    lines = "".join(f"<p>{escape(line)}</p>" for line in settings_lines(found))
    return f"<h3>Parameters of {found.autopilot}</h3>{html_table(SETTING_COLUMNS, found.settings)}{lines}"


def settings_lines(found: AutopilotSettings) -> list[str]:
    """What the new parameters leave of the error, and the wash of a propeller where power was
    recorded.
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
            "A propeller's wash cannot be told: power follows airspeed here. Fly one speed in "
            "climb and descent."
        )
    size = (
        f"{wash.value / KNOT:+.2f} ± {wash.two_sigma / KNOT:.2f} kt at full power against idle (2σ)"
    )
    size = size.replace("-", "−")
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


def flight_document(
    name: str,
    flight: CalibratedFlight,
    found: AutopilotSettings | None = None,
    limit: Limit | str | None = AUTO,
) -> dict[str, Any]:
    """A calibrated flight of the log of a name as plain data: the document of
    `pitotbench calibrate --json`. `limit` as for `judgments`.
    """
    return {
        "log": name,
        "origin": "simulated" if flight.log.simulated else "measured",
        **calibration_json(flight.calibration, limit),
        **flight_json(flight),
        "fixed_speed": points_json(flight.calibration.points),
        **settings_json(found),
    }


# Two curves compared.

_FEWEST_COMMON = 2


@dataclass(frozen=True, slots=True)
class CurveDifference:
    """The correction of the second curve minus that of the first [m/s] at common indicated
    airspeeds [m/s], (n,).

    Where it is positive, the second airspeed indicator reads lower. `two_sigma` (n,) is pointwise;
    `simultaneous_two_sigma` (n,) holds at all airspeeds at once. Errors of the two curves are taken
    as independent.
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


def curve_difference(
    first: str, one: ErrorCurve, second: str, other: ErrorCurve
) -> CurveDifference:
    """Compare two curves with their names. Raises BadInputError where they have no airspeeds in
    common.
    """
    spans = [
        (float(c.indicated_airspeed[0]), float(c.indicated_airspeed[-1])) for c in (one, other)
    ]
    low, high = max(a for a, _ in spans), min(b for _, b in spans)
    every = np.union1d(one.indicated_airspeed, other.indicated_airspeed)
    speed = every[(every >= low) & (every <= high)]
    if len(speed) < _FEWEST_COMMON:
        told = " and ".join(f"{a / KNOT:.0f} to {b / KNOT:.0f} KIAS" for a, b in spans)
        raise BadInputError(
            f"the curves have no airspeeds in common ({told}): fly the same range with both"
        )

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
    """Say in one sentence where the second airspeed indicator reads lower or higher, and where none
    shows.
    """
    speed, value, bound = (
        a / KNOT for a in (found.indicated_airspeed, found.difference, found.two_sigma)
    )
    if not found.differs:
        at = int(np.argmin(np.abs(speed - speed.mean())))
        return (
            f"{found.second} reads the same as {found.first} from {speed[0]:.0f} to "
            f"{speed[-1]:.0f} KIAS: no "
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
    Column("KIAS", lambda r: r[0], "", ".0f", "indicated_airspeed_kt"),
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
    """The page of two curves compared: the sentence, a picture of both with their difference, the
    table.
    """
    from pitotbench.show.curves import difference_drawing

    return render(
        "takehome.html",
        title=f"{found.second} against {found.first}",
        lines=[difference_sentence(found)],
        drawing=difference_drawing(found, one, other),
        tables=[
            ("The difference in numbers", html_table(DIFFERENCE_COLUMNS, _difference_rows(found)))
        ],
        notes=[
            "The errors of the two curves are taken as independent. An error that both share, such "
            "as that of one "
            "thermometer, cancels: the 2σ is then too large."
        ],
    )


# Tables for a handbook: calibrated by indicated airspeed, and the altitude correction by height and
# airspeed.

_HEIGHTS_FT = (0, 5000, 10000, 15000, 20000)
TABLES = (".csv", ".html", ".xml")


def _handbook(curve: ErrorCurve) -> list[Column[int]]:
    """The columns for the airspeeds of a curve; those of the altimeter only where the static source
    is known to err, up to the first height above the flight.
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
    """Return true minus indicated pressure altitude [m] and 2σ at an indicated pressure altitude
    [m], (n,) each.

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


def handbook_csv(curves: Mapping[str, ErrorCurve], doubts: Doubts = _NONE) -> str:
    """The tables as CSV: one line an airspeed and configuration, each with the doubts; the unit
    ends each column's name.
    """
    tables = {
        name: {column.key: column for column in _handbook(curve)} for name, curve in curves.items()
    }
    keys = list(dict.fromkeys(key for columns in tables.values() for key in columns))
    named = ["configuration"] if any(curves) else []
    doubtful = ["doubts"] if any(doubts.values()) else []
    text = StringIO()
    lines = writer(text, lineterminator="\n")
    lines.writerow([*named, *keys, *doubtful])
    for name, columns in tables.items():
        for row in range(len(curves[name].indicated_airspeed)):
            cells = [f"{columns[key].value(row):.3f}" if key in columns else "" for key in keys]
            told = [" ".join(doubts.get(name, ()))] if doubtful else []
            lines.writerow([*([name] if named else []), *cells, *told])
    return text.getvalue()


def handbook_page(curves: Mapping[str, ErrorCurve], subject: str, doubts: Doubts = _NONE) -> str:
    """The tables as a page to print, a table for each configuration below its doubts."""
    tables = []
    for name, curve in curves.items():
        every = range(len(curve.indicated_airspeed))
        kept = [
            row for row in every if round(float(curve.indicated_airspeed_kt[row])) % 5 == 0
        ] or every
        told = "".join(f"<p><b>{escape(line)}</b></p>" for line in doubts.get(name, ()))
        table = html_table(_handbook(curve), kept)
        tables.append((name or "Airspeed and altimeter", told + table))
    return render(
        "takehome.html",
        title=f"Airspeed calibration: {subject}",
        lines=[
            "Read KCAS beside KIAS. Add the altitude correction, where there is one, to the "
            "altimeter's reading."
        ],
        drawing="",
        tables=tables,
        notes=[
            "± is 2σ: the true value lies inside in 95 % of calibrations. KIAS is the instrument's "
            "reading without "
            "an error of its own."
        ],
    )


_SYSTEM_PROPERTY = "instrumentation/airspeed-indicator/indicated-speed-kt"


def jsbsim_system(
    curve: ErrorCurve | PublishedCurve, subject: str, doubts: Sequence[str] = ()
) -> str:
    """A JSBSim system whose airspeed indicator reads as the airplane's, by a measured or published
    curve: the indicated airspeed by the calibrated one. The doubts stand in its comment.

    Beyond the curve the outer correction stays. Raises BadInputError where an indicated airspeed
    belongs to two calibrated ones.
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


def table_text(
    suffix: str, curves: Mapping[str, ErrorCurve], subject: str, doubts: Doubts = _NONE
) -> str:
    """The curves of the configurations in the form that a file's suffix asks for: .csv, .html or
    .xml (JSBSim).

    Raises BadInputError for an .xml of several configurations: the simulator has one airspeed
    indicator.
    """
    if suffix == ".csv":
        return handbook_csv(curves, doubts)
    if suffix == ".html":
        return handbook_page(curves, subject, doubts)
    if len(curves) > 1:
        raise BadInputError(
            f"a JSBSim system reads one curve, and there are {len(curves)} ({', '.join(curves)}): "
            "give one log, or "
            "a card of one configuration"
        )
    ((name, curve),) = curves.items()
    return jsbsim_system(curve, subject, doubts.get(name, ()))


# The record for the file: of a calibration, and of a reconciliation in the order of a qualification
# test.

_NOT_SHOWN = "the log does not show it, or it was not looked for"


def checks_of(result: Calibration) -> list[Check]:
    """Return the checks of a calibration, passed, failed or skipped, each with its finding."""
    found, wind, made = result.diagnostics, result.wind, result.provenance
    failed: dict[str, list[str]] = (
        {} if result.converged else {"the fit converged": [result.reason]}
    )
    told = [
        *((d.kind, d.words) for d in result.disagreements),
        *((w.code, str(w)) for w in result.warnings),
    ]
    for kind, why in told:
        failed.setdefault(FAILED_BY.get(kind, ""), []).append(why)
    late, change, agreement = found.latency, found.wind_change, found.height_agreement
    delay = ""
    if late is not None and np.isfinite(late.two_sigma):
        size = (
            f"{late.value:+.2f} ± {late.two_sigma:.2f} s (2σ), of which {late.left:+.2f} s is "
            "not taken out"
        )
        delay = size.replace("-", "−")
    known = (
        "the wind is unknown"
        if wind is None
        else f"wind known to ±{_wind_two_sigma(wind):.2f} kt (2σ)"
    )
    largest = 100.0 * float(np.max(np.abs(result.curve.normalized_pressure_error)))
    passed = {  # no finding where it was not looked for
        "the fit converged": result.reason,
        GEOMETRY: f"condition number {result.condition_number:.1e}, {known}",
        "samples and curve agree": ""
        if result.method == "height"
        else "none lie off it by more than chance",
        "wind triangle and height agree": ""
        if agreement is None
        else f"so much apart by chance in {100.0 * agreement:.2g} % of logs",
        "fixed-speed points and curve agree": f"{len(result.points)} points"
        if result.points
        else "",
        "latency of the GPS velocity": delay,
        "constant wind": ""
        if change is None
        else f"Bayes factor of a change {change.bayes_factor:.2g}",
        HEADINGS: "no constant angle"
        if any("heading" in each.channels for each in made.inputs)
        else "",
        "curve of a possible size": f"Δp/q_c up to {largest:.1f} %",
        "sensors within their accuracies": "no estimate lies outside its prior",
        "no faulty rows": "no row disagrees with all others",
        "flights agree": "their curves differ by no more than chance"
        if len(made.inputs) > 1
        else "",
    }
    used = result.residuals.used
    rows = [] if used.all() else [f"{int(used.sum()):,} of {len(used):,} rows used"]
    left_out = [f"left out: {', '.join(result.left_out)}"] if result.left_out else []
    less = "; ".join([*rows, *left_out])
    return [
        *(check(name, ". ".join(failed.get(name, ())), why) for name, why in passed.items()),
        check("the whole log was used", "", "" if less else "no row was left out", less),
    ]


def check(name: str, failed: str, passed: str, skipped: str = _NOT_SHOWN) -> Check:
    """Return a check that fails with a reason, else passes with a finding, else was skipped."""
    return Check(
        name, "failed" if failed else "passed" if passed else "skipped", failed or passed or skipped
    )


def _wind_two_sigma(wind: WindEstimate) -> float:
    return max(wind.north.two_sigma, wind.east.two_sigma) / KNOT


Part = tuple[
    str, Sequence[str], str
]  # of a record: heading, sentences, tables and drawings as HTML
_MOST_WINDS = 12  # rows, so that the record of a long flight keeps to two pages
_STATUSES = ("failed", "passed", "skipped")
WIND_COLUMNS: tuple[Column[WindowWind], ...] = (
    Column("begin", lambda w: minutes_text(w.begin)),
    Column("end", lambda w: minutes_text(w.end)),
    Column("mean height", lambda w: w.altitude / FOOT, "ft", ",.0f"),
    Column("wind", lambda w: WindEstimate(w.north, w.east).speed_kt, "kt", ".1f"),
    Column("from", lambda w: WindEstimate(w.north, w.east).from_deg, "°", "03.0f"),
    Column(
        "±2σ of its larger component",
        lambda w: _wind_two_sigma(WindEstimate(w.north, w.east)),
        "kt",
        ".2f",
    ),
)


def calibration_record(flights: Sequence[Calibration], limit: Limit | str | None = AUTO) -> str:
    """The record of one curve, from one flight or from several with a wind each, as a page of two
    sheets.

    `limit` as for `judgments`.
    """
    from pitotbench.show.curves import curve_panels
    from pitotbench.show.verdict import CHECK_COLUMNS

    result = flights[0]
    answer = [
        *headline(result),
        short_answer_of(result, "").correction_sentence,
        *handbook_lines(result.curve),
    ]
    drawing = curve_panels({result.model: result}, None, limit)[0].drawing
    card = html_table(GLANCE_COLUMNS, glance_points(result.curve))
    winds = [
        replace(window, begin=window.begin - each.log_start, end=window.end - each.log_start)
        for each in flights
        for window in each.winds
    ]
    step = max(1, -(-len(winds) // _MOST_WINDS))
    thinned = [] if step == 1 else [f"Of {len(winds)} windows of the wind, one in {step} is shown"]
    lines = [*condition_lines(result), *thinned]
    rule = [judgment.sentence for judgment in judgments(result, limit)]
    checks = []
    for number, each in enumerate(flights, start=1):
        of = f"flight {number}: " if len(flights) > 1 else ""
        found = checks_of(each)
        checks += [replace(c, why=of + c.why) if c.status == "failed" else c for c in found]
    by_status = sorted(checks, key=lambda each: _STATUSES.index(each.status))
    worst = {
        each.name: each for each in reversed(by_status)
    }  # of several flights the worst one is told
    warnings = dict.fromkeys(
        str(w) for each in flights for w in each.warnings if w.code not in FAILED_BY
    )
    parts: list[Part] = [
        (
            "Conditions",
            conditions_of(result.provenance, lines),
            html_table(WIND_COLUMNS, winds[::step]),
        ),
        ("Answer", answer, f'<div class="beside"><div>{card}</div>{drawing}</div>'),
        ("Rule", rule or ["No rule was asked for, or none holds at these speeds."], ""),
        ("Checks", [], html_table(CHECK_COLUMNS, [worst[each.name] for each in checks_of(result)])),
    ]
    title = "Record of a pitot-static calibration"
    return record_page(
        title,
        "Find the correction of the airspeed, with a bound.",
        result.provenance,
        parts,
        warnings,
    )


def conditions_of(made: Provenance, lines: Sequence[str]) -> list[str]:
    """The ranges of the logs, in the field's units, before further lines."""
    ranges = [
        f"{f.name}: {f.airspeeds[0] / KNOT:.0f} to {f.airspeeds[1] / KNOT:.0f} KIAS, pressure "
        "altitude "
        f"{f.heights[0] / FOOT:,.0f} to {f.heights[1] / FOOT:,.0f} ft (5 % to 95 % of the rows)."
        for f in made.inputs
        if f.rows
    ]
    return [*ranges, *(f"{line[:1].upper()}{line[1:]}" for line in lines)]


def record_page(
    title: str, objective: str, made: Provenance, parts: Sequence[Part], warnings: Iterable[str]
) -> str:
    """The page of a record: inputs and settings, then its parts in their order, then the warnings."""
    choices = [f"{words(c.name)}: {c.value} ({c.source})" for c in made.choices]
    used = ", ".join(f"{name} {number}" for name, number in made.versions.items())
    return render(
        "record.html",
        title=title,
        objective=objective,
        inputs=made.inputs,
        choices=choices,
        versions=f"{used}. Made on {made.date} (UTC)." if used else "Not recorded.",
        parts=parts,
        warnings=[*warnings],
    )
