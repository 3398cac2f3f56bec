"""A calibration in numbers and sentences, as a card and as plain data. Loads no drawing library."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass, replace
from typing import Any

import numpy as np

from pitotbench.records.calibration import (
    CalibratedFlight,
    Calibration,
    ErrorCurve,
    Estimate,
    OneSided,
    PublishedCurve,
    Scale,
    Share,
    WindEstimate,
    WindowWind,
)
from pitotbench.show.columns import (
    Column,
    csv_text,
    json_rows,
    keyed,
    shown_columns,
)
from pitotbench.show.limits import AUTO, Limit, judgments_json
from pitotbench.timeline import minutes_text
from pitotbench.units import FOOT, KNOT, SUFFIXES, MetersPerSecond, Seconds

CurvePoint = dict[str, float | None]  # a point of an error curve, by the keys of its columns


CURVE_COLUMNS = (
    keyed("indicated_airspeed_kt", "IAS", "kt", ".0f"),
    keyed("calibrated_airspeed_kt", "CAS", "kt", ".2f"),
    keyed("correction_kt", "correction", "kt", "+.2f"),
    keyed("two_sigma_kt", "±2σ bound", "kt", ".2f"),
    keyed("simultaneous_two_sigma_kt", "±2σ of whole curve", "kt", ".2f"),
    keyed("white_two_sigma_kt", "2σ for white residuals", "kt", ".2f"),
    keyed("normalized_pressure_error", "Δp/q_c", "", "+.4f"),
    keyed("normalized_two_sigma", "±2σ of Δp/q_c", "", ".4f"),
    keyed("handbook_correction_kt", "by the handbook", "kt", "+.1f", optional=True),
    keyed("altitude_correction_ft", "altitude correction", "ft", "+.0f", optional=True),
    keyed("two_sigma_ft", "±2σ of altitude", "ft", ".0f", optional=True),
)


def curve_points(curve: ErrorCurve) -> list[CurvePoint]:
    """The points of a curve, the rows of its table."""
    none = (None,) * len(curve.correction)
    altitude, altitude_bound = curve.altitude_correction, curve.altitude_two_sigma
    published = none if not curve.published else published_at(curve, curve.published[0]) / KNOT
    columns = {
        "indicated_airspeed_kt": curve.indicated_airspeed / KNOT,
        "calibrated_airspeed_kt": (curve.indicated_airspeed + curve.correction) / KNOT,
        "correction_kt": curve.correction / KNOT,
        "two_sigma_kt": curve.two_sigma / KNOT,
        "simultaneous_two_sigma_kt": curve.simultaneous_two_sigma / KNOT,
        "white_two_sigma_kt": curve.white_two_sigma / KNOT,
        "normalized_pressure_error": curve.normalized_pressure_error,
        "normalized_two_sigma": curve.normalized_two_sigma,
        "handbook_correction_kt": [None if v is None or np.isnan(v) else v for v in published],
        "altitude_correction_ft": none if altitude is None else altitude / FOOT,
        "two_sigma_ft": none if altitude_bound is None else altitude_bound / FOOT,
    }
    rows = zip(*columns.values(), strict=True)
    numbers = ([None if value is None else float(value) for value in row] for row in rows)
    return [dict(zip(columns, row, strict=True)) for row in numbers]


def published_at(curve: ErrorCurve, published: PublishedCurve) -> MetersPerSecond:
    """Return the correction by a handbook at the airspeeds of a curve [m/s], (n,); NaN outside its
    table.
    """
    known = published.indicated_airspeed
    return np.interp(curve.indicated_airspeed, known, published.correction, np.nan, np.nan)


def handbook_lines(curve: ErrorCurve) -> list[str]:
    """Say where a curve agrees with that of a handbook, one line a configuration."""
    return [_handbook_line(curve, each) for each in curve.published]


def _handbook_line(curve: ErrorCurve, published: PublishedCurve) -> str:
    speed, bound = curve.indicated_airspeed_kt, curve.two_sigma_kt
    name = ", ".join(each for each in (published.source, published.configuration) if each)
    difference = (published_at(curve, published) - curve.correction) / KNOT
    known = np.isfinite(difference)
    if not known.any():
        flown = f"between {speed[0]:.0f} and {speed[-1]:.0f} KIAS"
        return f"The handbook ({name}) has no airspeed {flown}."
    inside = known & (np.abs(difference) <= bound)
    span = f"{speed[known][0]:.0f} to {speed[known][-1]:.0f} KIAS"
    if inside.sum() == known.sum():
        return f"The handbook's correction ({name}) lies inside ±2σ at all of {span}."
    at = int(np.nanargmax(np.abs(difference) - bound))
    where = (
        f"at {100.0 * inside.sum() / known.sum():.0f} % of {span}" if inside.any() else "nowhere"
    )
    by_log = Correction(float(speed[at]), float(curve.correction_kt[at]), float(bound[at]))
    by_book = f"{curve.correction_kt[at] + difference[at]:+.1f} kt".replace("-", "−")
    return (
        f"The handbook's correction ({name}) lies inside ±2σ {where}; at {speed[at]:.0f} KIAS it "
        f"is {by_book}, that of the log {by_log}."
    )


_MOST_DOTS = 900  # of the samples drawn: more make a page slow


def samples_of(result: Calibration) -> tuple[Seconds, MetersPerSecond, MetersPerSecond]:
    """What at most some 900 single samples say: their time [s], indicated airspeed and correction
    [m/s], which is the curve less the residual, (n,) each. The middle 99 % of them.
    """
    curve, residuals = result.curve, result.residuals
    thinned = slice(None, None, max(1, -(-len(residuals.time) // _MOST_DOTS)))
    speed = residuals.indicated_airspeed[thinned]
    data = (
        np.interp(speed, curve.indicated_airspeed, curve.correction) - residuals.airspeed[thinned]
    )
    low, high = np.quantile(data, [0.005, 0.995])
    shown = (data >= low) & (data <= high)
    return residuals.time[thinned][shown], speed[shown], data[shown]


_USUAL_KT = (
    100.0,
    130.0,
    160.0,
)  # the low end, the middle and the high end of the study's maneuvers


@dataclass(frozen=True, slots=True)
class Correction:
    """The correction to add to one indicated airspeed, and its ±2σ bound [kt]."""

    indicated_kt: float
    correction_kt: float
    two_sigma_kt: float

    def __str__(self) -> str:
        return f"{self.correction_kt:+.2f} ± {self.two_sigma_kt:.2f} kt".replace("-", "−")


def correction_sentence(corrections: Sequence[Correction]) -> str:
    """Some corrections of the indicated airspeed in one sentence."""
    parts = [f"{each} at {each.indicated_kt:.0f} KIAS" for each in corrections]
    return f"Add {'; '.join(parts)} to the indicated airspeed (± is 2σ)."


@dataclass(frozen=True, slots=True)
class ShortAnswer:
    """The short answer of a calibration, in knots and degrees. The wind comes from `wind_from_deg`."""

    subject: str
    model: str
    corrections: tuple[Correction, ...]
    wind_kt: float | None  # None for a wind that is unknown
    wind_from_deg: float | None
    wind_two_sigma_kt: float | None  # of the larger component
    residual_two_sigma_kt: float
    warnings: tuple[str, ...]

    @property
    def correction_sentence(self) -> str:
        """The corrections of the indicated airspeed in one sentence."""
        return correction_sentence(self.corrections)

    @property
    def wind_sentence(self) -> str:
        """The wind with the larger of its components' bounds, in one sentence."""
        if self.wind_kt is None or self.wind_two_sigma_kt is None:
            return "The wind is unknown."
        return (
            f"The wind is {self.wind_kt:.1f} kt from {self.wind_from_deg:03.0f}°; each of its "
            f"components is known to ±{self.wind_two_sigma_kt:.2f} kt (2σ) or better."
        )


def short_answer_of(result: Calibration, subject: str) -> ShortAnswer:
    """The short answer of a calibration of `subject` (a maneuver and data system, or a file)."""
    wind = result.wind
    return ShortAnswer(
        subject=subject,
        model=result.model,
        corrections=_corrections(result),
        wind_kt=None if wind is None else wind.speed_kt,
        wind_from_deg=None if wind is None else wind.from_deg,
        wind_two_sigma_kt=None
        if wind is None
        else max(wind.north.two_sigma, wind.east.two_sigma) / KNOT,
        residual_two_sigma_kt=result.residual_two_sigma / KNOT,
        warnings=result.warnings,
    )


def _corrections(result: Calibration) -> tuple[Correction, ...]:
    """The curve at 100, 130 and 160 KIAS, or at its ends and middle where it does not reach so far."""
    curve = result.curve
    speed = curve.indicated_airspeed / KNOT
    covered = speed[0] <= _USUAL_KT[0] + 0.5 and speed[-1] >= _USUAL_KT[-1] - 0.5
    wanted: Sequence[float] = (
        _USUAL_KT if covered else speed[np.linspace(0, len(speed) - 1, 3).astype(int)]
    )
    values = np.interp(wanted, speed, curve.correction / KNOT)
    bounds = np.interp(wanted, speed, curve.two_sigma / KNOT)
    return tuple(Correction(*map(float, row)) for row in zip(wanted, values, bounds, strict=True))


# The assumptions of a bound in words: accuracies that no residual shows, and a zero offset that is
# corrected.

_WORDS = {
    "temperature_k": ("temperature", "K"),
    "recovery_factor": ("recovery factor", ""),
    "static_pressure_pa": ("static pressure", "Pa"),
    "impact_pressure_zero_pa": ("zero of the impact pressure", "Pa"),
    "velocity_mps": ("GPS velocity", "m/s"),
    "total_source": ("total source", "of q_c"),
    "latency_s": ("GPS latency", "s"),
}
_SOURCES = {"header": "stated by the log"}  # any other in its own word


def assumption_lines(result: Calibration) -> list[str]:
    """Return the accuracies on which the bounds depend, and the zero offset that the correction
    takes out.
    """
    parts, exact, sources = [], [], []
    for each in result.assumptions:
        name, unit = _WORDS[each.name]
        if each.two_sigma > 0.0:
            parts.append(
                f"{name} ±{f'{each.two_sigma:g} {unit}'.rstrip()} "
                f"({_SOURCES.get(each.source, each.source)})"
            )
        else:
            exact.append(name)
            sources.append(_SOURCES.get(each.source, each.source))
    if exact:
        parts.append(
            f"no constant error of {', '.join(exact)} ({', '.join(dict.fromkeys(sources))})"
        )
    lines = [f"The bounds assume these constant errors (2σ): {'; '.join(parts)}."] if parts else []
    zero = result.impact_pressure_zero
    if zero is not None:
        lines.append(
            "Add the correction to the raw reading: it takes out a zero offset of the impact "
            "pressure of "
            f"{zero.value:+.0f} ± {zero.two_sigma:.0f} Pa (2σ, if the model's curve is right: a "
            "constant part of "
            "Δp looks the same); Δp/q_c is the pressure error without it."
        )
    return lines


# The airspeed card: what to add at which indicated airspeed, for a terminal, a sheet and a file.

_STEPS = (5, 10, 20, 50, 100)  # kt
MOST_ROWS = 13  # of a table that is read at one glance

_COLUMN = {column.key: column for column in CURVE_COLUMNS}
# What a pilot needs of the curve; the bound's digits say how many of the correction's mean
# something.
GLANCE_COLUMNS: tuple[Column[CurvePoint], ...] = (
    replace(_COLUMN["indicated_airspeed_kt"], heading="KIAS", unit=""),
    replace(_COLUMN["calibrated_airspeed_kt"], heading="KCAS", unit="", style=".1f"),
    _COLUMN["correction_kt"],
    replace(_COLUMN["two_sigma_kt"], heading="±2σ"),
    _COLUMN["handbook_correction_kt"],
    _COLUMN["altitude_correction_ft"],
    _COLUMN["two_sigma_ft"],
)


def glance_points(curve: ErrorCurve) -> list[CurvePoint]:
    """The points of a curve at round airspeeds and at its ends, few enough to be read at one
    glance.
    """
    points = curve_points(curve)
    for step in _STEPS:
        inner = [p for p in points[1:-1] if round(p["indicated_airspeed_kt"] or 0.0) % step == 0]
        if len(shown := [*points[:1], *inner, *points[1:][-1:]]) <= MOST_ROWS:
            break
    return shown


def card_csv(curve: ErrorCurve, doubts: Sequence[str] = (), unit: str = "kt") -> str:
    """The card as CSV, speeds in a unit such as `kmh`: the unit ends each column's name; all points
    of the curve, each with the doubts.
    """
    points, factor = curve_points(curve), KNOT / SUFFIXES[unit].factor
    columns = shown_columns(GLANCE_COLUMNS, points)
    told: dict[str, object] = {"doubts": " ".join(doubts)} if doubts else {}

    def scaled(key: str, value: Any) -> object:
        return factor * value if key.endswith("_kt") and value is not None else value

    return csv_text(
        [
            {**{c.key.replace("_kt", f"_{unit}"): scaled(c.key, p[c.key]) for c in columns}, **told}
            for p in points
        ]
    )


def departure_line(result: Calibration) -> str:
    """The probability of each size of a smooth curve's departures."""
    parts = ", ".join(
        f"{size} with {100 * p:.0f} %" for size, p in (result.diagnostics.departures or {}).items()
    )
    return (
        "departure of the curve from level, slope and a part in 1/q_ci, rms in Δp/q_c, with its "
        f"probability: {parts}"
    )


# A calibration in numbers and sentences, for the terminal and for a page.

_MOST_PARTS = 6  # of the log that are named
_LEAST_SHARE = 0.005  # kt, below which a share would be printed as zero
_LOCATIONS = {
    "static": "the static source",
    "total": "the total source",
    "impact": "the impact pressure",
}


def flight_lines(flight: CalibratedFlight) -> list[str]:
    """Which flight of its log a calibration is of, and with how many it shares the curve, in at
    most one line.
    """
    told = []
    if flight.count > 1:
        times = flight.log.time[[0, -1]] - flight.log.start
        begin, end = map(minutes_text, times)
        told.append(f"flight {flight.number} of {flight.count} in the log, {begin} to {end}")
    if flight.joined > 1:
        told.append(f"one curve from {flight.joined} flights, the wind of this one")
    return ["; ".join(told)] if told else []


def parameter_lines(result: Calibration) -> list[str]:
    """The parameters of the pressure-error model with their bounds, and the variable of the model."""
    values = ", ".join(f"{p.name} = {p.value:+.5f} ± {p.two_sigma:.5f}" for p in result.parameters)
    return [f"parameters (± is 2σ): {values}; x = q_ci / {result.reference_pressure:.2f} Pa"]


# By the code of a warning or the kind of a disagreement, the check that fails with it.
HEADINGS, GEOMETRY = "heading and track agree", "headings and airspeeds suffice"
FAILED_BY = {
    "latency": "latency of the GPS velocity",
    "wind": "constant wind",
    "confounded": GEOMETRY,
    "one heading": GEOMETRY,
    "curve size": "curve of a possible size",
    "outside prior": "sensors within their accuracies",
    "faulty rows": "no faulty rows",
    "flights disagree": "flights agree",
    "samples": "samples and curve agree",
    "height": "wind triangle and height agree",
    "fixed_speed": "fixed-speed points and curve agree",
    "broken pitot": "pitot and static lines work",
    **dict.fromkeys(("heading", "mirrored", "axes turned", "track"), HEADINGS),
}
_ASSUMED = (
    "What the error does to the altimeter is assumed: nothing shows at which source it is, and the "
    "altimeter may be right."
)


_READ = ("log", "faulty rows", "flight left out", "own curves", "display steps")


def is_doubt(warning: str) -> bool:
    """Whether a warning tells of what may move the answer, not only how the log was read; one
    without a code does.
    """
    return getattr(warning, "code", "") not in _READ


def headline(result: Calibration) -> list[str]:
    """What contradicts an answer within its own log: a line for what forbids its use, one for all
    else.
    """
    fatal = [each.words for each in result.disagreements if each.fatal]
    others = [each.words.partition(". ")[0] for each in result.disagreements if not each.fatal]
    lines = [("Do not use this answer", fatal), ("Two findings of this log disagree", others)]
    return [f"{lead}: {'; '.join(told)}." for lead, told in lines if told]


def doubts_of(result: Calibration) -> list[str]:
    """What an answer must not go without, wherever it is taken: what contradicts it, what may move
    it, what is assumed. The first says which speeds and tracks the log lacks.
    """
    warnings = [
        f"{w[:1].upper()}{w[1:]}{'' if w.endswith('?') else '.'}"
        for w in result.warnings
        if is_doubt(w)
    ]
    told = [*headline(result), *warnings, *doubts_of_curve(result.curve)]
    return [f"{told[0]}{_one_sided_words(result.one_sided)}", *told[1:]] if told else []


def _one_sided_words(found: Sequence[OneSided]) -> str:
    flown = [
        f"{each.begin:03.0f}° to {each.end:03.0f}° from {each.low / KNOT:.0f} to "
        f"{each.high / KNOT:.0f} KIAS"
        for each in found
    ]
    told = f" Only these tracks were flown: {'; '.join(flown)}. Fly the opposite tracks as well."
    return told if found else ""


def doubts_of_curve(curve: ErrorCurve) -> list[str]:
    """What is assumed of a curve, in at most one line."""
    return [_ASSUMED] if curve.altitude_assumed else []


def part_lines(result: Calibration) -> list[str]:
    """Which parts of the log were used, in minutes of the log, and what was left out; empty where
    all was used.
    """
    if not result.left_out:
        return []
    start = result.log_start
    told = [
        f"{minutes_text(begin - start)} to {minutes_text(end - start)}"
        for begin, end in result.parts[:_MOST_PARTS]
    ]
    more = (
        f" and {len(result.parts) - _MOST_PARTS} more parts"
        if len(result.parts) > _MOST_PARTS
        else ""
    )
    return [
        f"used: {', '.join(told)}{more} (minutes of the log); left out: "
        f"{', '.join(result.left_out)}"
    ]


def location_lines(result: Calibration) -> list[str]:
    """The place of the pressure error, which decides what it does to the altitude."""
    assumed = (
        ", assumed (without a height by GPS the log does not show it)"
        if result.place_assumed
        else ""
    )
    return [f"place of the error: {_LOCATIONS[result.error_location]}{assumed}"]


def wind_lines(result: Calibration) -> list[str]:
    """The components of the wind velocity with their bounds."""
    wind = result.wind
    if wind is None:
        return ["wind velocity: unknown"]
    known: list[tuple[str, Estimate | None]] = [
        ("north", wind.north),
        ("east", wind.east),
        ("down", wind.down),
    ]
    parts = [
        f"{to} {v.value / KNOT:+.2f} ± {v.two_sigma / KNOT:.2f} kt"
        for to, v in known
        if v is not None
    ]
    return [f"wind velocity (± is 2σ): toward {', '.join(parts)}"]


def share_lines(result: Calibration) -> list[str]:
    """How much each stated accuracy widens the bounds, the largest contribution first."""
    curve = result.curve.two_sigma / KNOT
    total = float((curve @ curve / len(curve)) ** 0.5)
    if result.wind is None:
        return []
    wind = max(result.wind.north.two_sigma, result.wind.east.two_sigma) / KNOT
    lines = []
    for share in sorted(result.shares, key=lambda share: -share.curve - share.wind):
        found = share.estimate
        # The digits of a value that is negligible against its bound come from rounding alone.
        value = found.value if abs(found.value) > 1e-6 * found.two_sigma else 0.0
        if max(share.curve, share.wind) > _LEAST_SHARE * KNOT:
            lines.append(
                f"{share.name} (estimated {value:+.3g} ± {found.two_sigma:.3g}) contributes "
                f"±{share.curve / KNOT:.2f} kt to the curve's ±{total:.2f} kt and "
                f"±{share.wind / KNOT:.2f} kt to "
                f"the wind's ±{wind:.2f} kt (2σ, as squares; parts overlap)"
            )
    return lines


def fit_lines(result: Calibration) -> list[str]:
    """The residual and the state of the fit."""
    return [
        f"2σ of the residual {result.residual_two_sigma / KNOT:.2f} kt, {result.samples:,} "
        "samples, "
        f"condition number {result.condition_number:.1e}; {result.reason}"
    ]


# A calibration as plain data, by the keys of the command line's contract.


def calibration_json(result: Calibration, limit: Limit | str | None = AUTO) -> dict[str, Any]:
    """A calibration as plain data; the unit is in each key. `limit` as for `judgments`."""
    answer, found, zero = (
        short_answer_of(result, ""),
        _plain(result.diagnostics),
        result.impact_pressure_zero,
    )
    return {
        "model": result.model,
        "parameters": [asdict(each) for each in result.parameters],
        "wind": None if result.wind is None else _components(result.wind, "north", "east", "down"),
        "wind_speed_kt": answer.wind_kt,
        "wind_from_deg": answer.wind_from_deg,
        "winds": [
            {"from_s": each.begin, "to_s": each.end, "altitude_m": each.altitude}
            | _components(each, "north", "east")
            for each in result.winds
        ],
        "curve": json_rows(CURVE_COLUMNS, curve_points(result.curve)),
        **handbook_json(result.curve),
        "error_location": result.error_location,
        "error_location_assumed": result.place_assumed,
        "usable": result.usable,
        "scale": None if result.scale is None else scale_json(result.scale),
        "disagreements": [
            {"kind": each.kind, "words": each.words, "size_kt": each.size / KNOT}
            for each in result.disagreements
        ],
        "one_sided": [
            {
                "indicated_airspeed_kt": [each.low / KNOT, each.high / KNOT],
                "track_deg": [each.begin, each.end],
            }
            for each in result.one_sided
        ],
        "parts": [{"from_s": begin, "to_s": end} for begin, end in result.parts],
        "left_out": list(result.left_out),
        "assumptions": [asdict(each) for each in result.assumptions],
        "impact_pressure_zero_pa": None
        if zero is None
        else {"value": zero.value, "two_sigma": zero.two_sigma},
        "residual_two_sigma_kt": result.residual_two_sigma / KNOT,
        "samples": result.samples,
        "converged": result.converged,
        "warnings": list(result.warnings),
        "limits": judgments_json(result, limit),
        "shares": [_share(share) for share in result.shares],
        "diagnostics": found,
    }


def handbook_json(curve: ErrorCurve) -> dict[str, Any]:
    """The curves of a handbook as plain data; no key without one."""
    found = [
        {
            "file": each.source,
            "configuration": each.configuration or None,
            "indicated_airspeed_kt": (each.indicated_airspeed / KNOT).round(3).tolist(),
            "calibrated_airspeed_kt": (each.calibrated_airspeed / KNOT).round(3).tolist(),
            "words": words,
        }
        for each, words in zip(curve.published, handbook_lines(curve), strict=True)
    ]
    return {"handbook": found} if found else {}


def scale_json(scale: Scale) -> dict[str, Any]:
    """The factor on the airspeed as plain data; `units` is null where nothing else explains it."""
    return asdict(scale) | {"units": list(scale.units) or None}


def _plain(found: Any) -> dict[str, Any]:
    """A record as plain data, with those inside it in their places; what was not looked for has no
    key.
    """
    plain: dict[str, Any] = {}
    for each in fields(found):
        value = getattr(found, each.name)
        if is_dataclass(value):
            plain |= _plain(value)
        elif value is not None:
            plain[each.metadata.get("key", each.name)] = value
    return plain


def flight_json(flight: CalibratedFlight) -> dict[str, Any]:
    """Which flight of its log a calibration is of, as plain data; nothing where a log alone holds
    one flight.
    """
    if flight.count == 1 and flight.joined == 1:
        return {}
    return {
        "flight": {
            "number": flight.number,
            "of": flight.count,
            "from_s": float(flight.log.time[0]),
            "to_s": float(flight.log.time[-1]),
            "flights_of_the_curve": flight.joined,
        }
    }


def _components(wind: WindEstimate | WindowWind, *axes: str) -> dict[str, Any]:
    found: dict[str, Estimate | None] = {axis: getattr(wind, axis) for axis in axes}
    return {f"{axis}_kt": each.value / KNOT if each else None for axis, each in found.items()} | {
        f"{axis}_two_sigma_kt": each.two_sigma / KNOT if each else None
        for axis, each in found.items()
    }


def _share(share: Share) -> dict[str, Any]:
    return {
        "name": share.name,
        "value": share.estimate.value,
        "two_sigma": share.estimate.two_sigma,
        "curve_two_sigma_kt": share.curve / KNOT,
        "wind_two_sigma_kt": share.wind / KNOT,
    }
