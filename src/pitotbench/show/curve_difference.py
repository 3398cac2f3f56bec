"""Two error curves compared: what differs, in a sentence, a table, a picture and as plain data."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pitotbench.records import BadInputError
from pitotbench.records.calibration import ErrorCurve
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.curve_rows import MOST_ROWS
from pitotbench.show.curves import AIRSPEED, CORRECTION, LARGE, banded
from pitotbench.show.reader_units import BENCH, Units
from pitotbench.show.style import BLUE, ORANGE, PURPLE, Mark, Panel, drawing, frame, panel
from pitotbench.show.tree import NUMBERS, Figure, Heading, Node, Sentence, Table
from pitotbench.units import KNOT, Array, MetersPerSecond

_FEWEST_COMMON = 2


@dataclass(frozen=True, slots=True)
class CurveDifference:
    """The correction of one curve minus another's [m/s], (n,), at common indicated airspeeds [m/s].

    The difference is the `second` minus the `first`: where it is positive, the second airspeed
    indicator reads lower. `two_sigma` (n,) is pointwise; `simultaneous_two_sigma` (n,) holds at all
    airspeeds at once. Errors of the two curves are taken as independent.
    """

    first: str
    second: str
    indicated_airspeed: MetersPerSecond
    difference: MetersPerSecond
    two_sigma: MetersPerSecond
    simultaneous_two_sigma: MetersPerSecond

    @property
    def differs(self) -> bool:
        """Whether the curves differ somewhere by more than the band of all airspeeds at once."""
        return bool(np.any(np.abs(self.difference) > self.simultaneous_two_sigma))


def compare_curves(first: str, one: ErrorCurve, second: str, other: ErrorCurve) -> CurveDifference:
    """Compare two curves with their names.

    Raises BadInputError where they have no airspeeds in common.
    """
    spans = [
        (float(c.indicated_airspeed[0]), float(c.indicated_airspeed[-1])) for c in (one, other)
    ]
    low, high = max(a for a, _ in spans), min(b for _, b in spans)
    every = np.union1d(one.indicated_airspeed, other.indicated_airspeed)
    speed = every[(every >= low) & (every <= high)]
    if len(speed) < _FEWEST_COMMON:
        sentences = " and ".join(f"{a / KNOT:.0f} to {b / KNOT:.0f} KIAS" for a, b in spans)
        raise BadInputError(
            f"the curves have no airspeeds in common ({sentences}): fly the same range with both"
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
    """Say in one sentence where the second airspeed indicator reads lower or higher, if it does."""
    speed, value, bound = (
        a / KNOT for a in (found.indicated_airspeed, found.difference, found.two_sigma)
    )
    if not found.differs:
        at = int(np.argmin(np.abs(speed - speed.mean())))
        return (
            f"{found.second} reads the same as {found.first} from {speed[0]:.0f} to "
            f"{speed[-1]:.0f} KIAS: no difference shows, and at {speed[at]:.0f} KIAS one of "
            f"±{bound[at]:.1f} kt (2σ) would."
        )
    clear = np.abs(value) > bound
    sentences = [
        f"{abs(value[at]):.1f} ± {bound[at]:.1f} kt {word} at {speed[at]:.0f} KIAS"
        for side, word in ((1.0, "lower"), (-1.0, "higher"))
        for rows in [np.flatnonzero(clear & (side * value > 0.0))]
        for at in rows[np.argsort(bound[rows] - np.abs(value[rows]))][:1]  # the clearest
    ]
    known = np.flatnonzero(clear)
    ends = [f"below {speed[known[0]]:.0f}"] if known[0] > 0 else []
    ends += [f"above {speed[known[-1]]:.0f}"] if known[-1] < len(speed) - 1 else []
    elsewhere = f"; no difference {' or '.join(ends)}" if ends else ""
    return (
        f"{found.second} reads {' and '.join(sentences)} than {found.first}{elsewhere} (± is 2σ)."
    )


_DifferenceRow = tuple[float, float, float]
DIFFERENCE_COLUMNS: tuple[Column[_DifferenceRow], ...] = (
    Column("KIAS", lambda r: r[0], "", ".0f", "indicated_airspeed_kt"),
    Column("difference of the corrections", lambda r: r[1], "kt", "+.2f", "difference_kt"),
    Column("±2σ", lambda r: r[2], "kt", ".2f", "two_sigma_kt"),
)


def _difference_rows(found: CurveDifference) -> list[_DifferenceRow]:
    columns = (a / KNOT for a in (found.indicated_airspeed, found.difference, found.two_sigma))
    return [(float(v), float(d), float(b)) for v, d, b in zip(*columns, strict=True)]


def difference_tree(found: CurveDifference, one: ErrorCurve, other: ErrorCurve) -> list[Node]:
    """Two curves compared: the sentence, a picture of both with their difference, the table."""
    rows = _difference_rows(found)
    step = max(1, -(-len(rows) // MOST_ROWS))
    return [
        Sentence(difference_sentence(found)),
        Figure("pitotbench.show.curve_difference.difference_panels", (found, one, other), "main"),
        Table(DIFFERENCE_COLUMNS, rows[::step], f"{found.second} less {found.first}"),
        Sentence(
            "The errors of the two curves are taken as independent. An error that both share, such "
            "as that of one thermometer, cancels: the 2σ is then too large."
        ),
        Heading("The difference in numbers", (Table(DIFFERENCE_COLUMNS, rows),), NUMBERS),
    ]


def difference_json(found: CurveDifference) -> dict[str, Any]:
    """Two curves compared as plain data."""
    return {
        "first": found.first,
        "second": found.second,
        "curve": json_rows(DIFFERENCE_COLUMNS, _difference_rows(found)),
        "differs": found.differs,
        "summary": difference_sentence(found),
    }


def difference_panels(
    found: CurveDifference, one: ErrorCurve, other: ErrorCurve, units: Units = BENCH
) -> list[Panel]:
    """The picture of two curves, and below them their difference, each with its 2σ."""

    def marks(
        each: ErrorCurve | CurveDifference, value: Array, color: str, name: str
    ) -> list[Mark]:
        speed, bound = each.indicated_airspeed / KNOT, each.two_sigma / KNOT
        return banded(speed, value / KNOT, bound, color, f"{name} (±2σ)")

    curves = [
        *marks(one, one.correction, ORANGE, found.first),
        *marks(other, other.correction, BLUE, found.second),
        frame("", CORRECTION),
    ]
    difference = [
        *marks(found, found.difference, PURPLE, "difference of the corrections"),
        frame(AIRSPEED, "difference [kt]"),
    ]
    title = f"{found.second} against {found.first}".replace('"', "'")
    return [panel(title, [drawing(*curves), drawing(*difference)], size=LARGE, units=units)]
