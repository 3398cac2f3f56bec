"""The account of a log: for the terminal and as plain data."""

from typing import Any

import numpy as np
from rich.console import Console

from pitotbench.records.log_inspection import HeldChannel, LogInspection, Question
from pitotbench.show.columns import Column, json_rows, print_table
from pitotbench.show.quantity_words import unit_words, words
from pitotbench.show.terminal import outside, print_warnings
from pitotbench.units import DEGREE, FOOT, KNOT


def _five_digits(value: float | None) -> float | None:
    """A number without the digits that nobody reads."""
    return None if value is None else float(f"{value:.5g}")


CHANNEL_COLUMNS: tuple[Column[HeldChannel], ...] = (
    Column("channel", lambda c: words(c.name)),
    Column("", lambda c: c.name, key="name"),
    Column("", lambda c: c.unit or "-", key="unit"),
    Column("unit", lambda c: unit_words(c.unit)),
    Column("", lambda c: c.low, key="low"),
    Column("", lambda c: c.high, key="high"),
    Column("5 %", lambda c: _five_digits(c.low), "", ",.10g"),
    Column("95 %", lambda c: _five_digits(c.high), "", ",.10g"),
    Column("changes", lambda c: c.rate, "1/s", ".3g", "rate_hz"),
)
QUESTION_COLUMNS: tuple[Column[Question], ...] = (
    Column("question", lambda q: q.name, key="question"),
    Column("answered", lambda q: q.answered, key="answered"),
    Column("what is missing", lambda q: q.words, key="missing"),
)


def inspection_sentences(found: LogInspection) -> list[str]:
    """The account in sentences: extent, speeds, headings, and the bound to expect."""
    minutes = sum(end - start for start, end in found.flights) / 60.0
    low, _, high = (value / KNOT for value in found.airspeeds)
    bottom, _, top = (value / FOOT for value in found.heights)
    count = len(found.flights)
    sentences = [
        f"{found.rows:,} rows at {found.rate:.3g} Hz: {count} flight{'s' if count > 1 else ''}, {minutes:.1f} min, "
        f"{len(found.pauses)} pause{'' if len(found.pauses) == 1 else 's'}.",
        f"Indicated airspeeds {low:.0f} to {high:.0f} kt, pressure altitudes {bottom:,.0f} to {top:,.0f} ft, "
        f"tracks in {found.headings} of 12 sectors of 30°.",
        f"Wind about {np.hypot(*found.wind) / KNOT:.0f} kt from "
        f"{np.arctan2(-found.wind[1], -found.wind[0]) / DEGREE % 360.0:03.0f}°.",
    ]
    if found.expected is None:
        return [*sentences, f"No error curve can be found: {found.refusal}."]
    speeds, bound = found.expected
    points = ", ".join(
        f"{bound[i] / KNOT:.2f} kt at {speeds[i] / KNOT:.0f} KIAS" for i in dict.fromkeys((0, len(speeds) // 2, -1))
    )
    if len(speeds) == 1:
        points = f"{bound[0] / KNOT:.2f} kt at {speeds[0] / KNOT:.0f} KIAS"
    return [*sentences, f"In light turbulence, expect an error curve with 2σ of {points} (Inverse+, noise known)."]


def print_inspection(found: LogInspection, console: Console) -> None:
    """Print the account: sentences, warnings, questions, channels and pauses."""
    for sentence in inspection_sentences(found):
        console.print(outside(sentence))
    print_warnings(found.warnings, console)
    console.print()
    print_table(QUESTION_COLUMNS, found.questions, console)
    console.print()
    print_table(CHANNEL_COLUMNS, found.channels, console)
    for start, length in found.pauses:
        console.print(outside(f"pause of {length:.0f} s after {start:.0f} s"))


def inspection_json(found: LogInspection) -> dict[str, Any]:
    """The account as plain data, in knots, feet, degrees and seconds."""
    expected = [] if found.expected is None else zip(*found.expected, strict=True)
    return {
        "rows": found.rows,
        "rate_hz": found.rate,
        "channels": json_rows(CHANNEL_COLUMNS, found.channels),
        "flights": [{"start_s": start, "end_s": end} for start, end in found.flights],
        "pauses": [{"start_s": start, "length_s": length} for start, length in found.pauses],
        "track_sectors": found.headings,
        "indicated_airspeed_kt": [value / KNOT for value in found.airspeeds],
        "pressure_altitude_ft": [value / FOOT for value in found.heights],
        "wind_speed_kt": float(np.hypot(*found.wind)) / KNOT,
        "wind_from_deg": float(np.arctan2(-found.wind[1], -found.wind[0]) / DEGREE) % 360.0,
        "questions": json_rows(QUESTION_COLUMNS, found.questions),
        "expected": [{"indicated_airspeed_kt": v / KNOT, "two_sigma_kt": b / KNOT} for v, b in expected],
        "refusal": found.refusal or None,
        "warnings": list(found.warnings),
    }
