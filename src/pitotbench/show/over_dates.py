"""The correction of an airplane over the dates of its flights, in words and a table."""

from collections.abc import Callable

from pitotbench.records.over_dates import OverDates
from pitotbench.show.columns import Column
from pitotbench.show.tree import Doubt, Figure, Heading, Sentence, Table
from pitotbench.show.words import capital
from pitotbench.units import KNOT


def over_dates_tree(found: OverDates) -> Heading:
    """The course of the correction, the change first."""
    words = found.words
    days = [f"{each.date()}" for each in (found.dates[0], found.dates[-1])]
    course = (
        f"{len(found.names)} flights from {days[0]} to {days[1]}, each calibrated by itself"
        f"{'' if words else ': no change of the correction beyond what chance makes'}."
    )
    said = [Doubt(f"{capital(words)}.")] if words else []
    picture = Figure("pitotbench.show.curves.over_dates_panels", (found,), "single")
    rows = range(len(found.names))
    return Heading("Over dates", (*said, Sentence(course), picture, Table(_columns(found), rows)))


def _columns(found: OverDates) -> tuple[Column[int], ...]:
    def number(at: int) -> Callable[[int], str]:
        return lambda row: (
            f"{found.correction[row, at] / KNOT:+.2f} ± {found.two_sigma[row, at] / KNOT:.2f}"
        )

    return (
        Column("date", lambda row: f"{found.dates[row].date()}"),
        Column("flight", lambda row: found.names[row]),
        *(
            Column(f"correction at {speed / KNOT:.0f} KIAS", number(at), "kt")
            for at, speed in enumerate(found.airspeed)
        ),
    )
