"""Real logs beside an independent truth: what this build answers, inside or outside, with a picture.

The logs are read in place, from the folder that PITOTBENCH_DATA names; an absent one is left out,
with its reason.
"""

import os
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pitotbench.air import impact_pressure
from pitotbench.bench.questions import calibrate
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.show.style import BLUE, GREY, Mark, band, bars, canvas, drawing, frame, line
from pitotbench.units import FOOT, KNOT, Array, Booleans
from pitotlab.real_logs import (
    AWAY,
    BALLOON,
    BALLOON_KT,
    BALLOON_PA,
    HANDBOOK,
    KNOWN,
    ONE_AIRPLANE,
    read_sonde,
)

PAGE = Path("docs/gallery.md")
PICTURES = Path("docs/pictures")
BEGIN, END = "<!-- real logs -->", "<!-- / -->"
_SIZE = (4.6, 2.4)  # in


@dataclass(frozen=True, slots=True)
class Held:
    """Answers (n,) with their 2σ at places `at`, and the truth with its own doubt."""

    at: Array
    found: Array
    two_sigma: Array
    truth: Array
    doubt: Array
    along: str
    what: str

    @property
    def inside(self) -> Booleans:
        """Whether answer and truth differ by no more than both bounds allow."""
        return np.abs(self.found - self.truth) <= np.hypot(self.two_sigma, self.doubt)


@dataclass(frozen=True, slots=True)
class Entry:
    """A log: what it is, its file in the folder of logs, where it comes from, what is known of it
    independently, the flags of its calibration, and how the two are held together.
    """

    title: str
    path: str
    source: str
    truth: str
    flags: str
    hold: Callable[[Path, Calibration], Held]


def _handbook(_: Path, found: Calibration) -> Held:
    curve, (indicated, calibrated) = found.curve, HANDBOOK.T
    speed = curve.indicated_airspeed_kt
    flown = (indicated >= speed[0] - 1.5) & (indicated <= speed[-1] + 1.5)
    at = indicated[flown]
    return Held(
        at,
        np.interp(at, speed, curve.correction_kt),
        np.interp(at, speed, curve.two_sigma_kt),
        (calibrated - indicated)[flown],
        np.full(len(at), ONE_AIRPLANE),
        "indicated airspeed [kt]",
        "correction [kt]",
    )


def _balloon(path: Path, found: Calibration) -> Held:
    curve = found.curve
    speed = curve.indicated_airspeed_kt
    return Held(
        BALLOON_KT,
        np.interp(BALLOON_KT, speed, curve.normalized_pressure_error),
        np.interp(BALLOON_KT, speed, curve.normalized_two_sigma),
        np.array(BALLOON[path.stem]),
        BALLOON_PA / impact_pressure(BALLOON_KT * KNOT),
        "indicated airspeed [kt]",
        "pressure error, part of the impact pressure",
    )


def _sonde(path: Path, found: Calibration) -> Held:
    """The wind of each window along the sonde's own wind at its height."""
    sonde = read_sonde(path.with_name(f"{path.name.partition('-')[0]}-sounding.txt.gz"))
    rows = []
    for each in found.winds:
        if max(each.north.two_sigma, each.east.two_sigma) > KNOWN * KNOT:
            continue
        wind = np.array([float(sonde.at(axis, each.altitude)) for axis in ("north", "east")])
        speed = float(np.hypot(*wind))
        toward = wind / speed
        own = np.array([each.north.value, each.east.value]) @ toward
        bound = np.hypot(*(toward * [each.north.two_sigma, each.east.two_sigma]))
        rows.append((each.altitude / FOOT / 1000.0, own / KNOT, bound / KNOT, speed / KNOT))
    at, own, bound, speed = np.array(sorted(rows)).T
    doubt = np.full(len(at), AWAY)
    return Held(at, own, bound, speed, doubt, "height [1,000 ft]", "wind along the sonde's [kt]")


_PERLAN = "Perlan 2 glider, flight {} of 2018, {} recorder (IGC, 1 Hz): Society of Flight Test Engineers, perlan-data"
_SONDE = "the radiosonde of the day at the airfield; in lee waves, hours and miles away, it may differ by 25 kt"
_JET = "a jet decelerates and turns, 20 Hz: SaguaroAerospaceResearch/JMOSS (MIT)"
_BALLOON = "the pressure of a weather balloon at GPS height, to 0.5 hPa"

ENTRIES = (
    Entry(
        "An hour of a Cessna 172S with a G1000",
        "garmin/c172s-g1000-2011.csv.gz",
        "travisdesell/ngafid2.0, as the unit wrote it, 1 Hz",
        "the airspeed calibration of the airplane's handbook, flaps up; one airplane may differ by 3 kt",
        "",
        _handbook,
    ),
    *(
        Entry(f"{name}, a jet", f"jmoss/{name}.csv", _JET, _BALLOON, " --mapping jmoss", _balloon)
        for name in BALLOON
    ),
    *(
        Entry(
            f"Perlan 2, flight {number}, {place} recorder",
            f"perlan/flight{number}-{place}.igc.gz",
            _PERLAN.format(number, place),
            _SONDE,
            "",
            _sonde,
        )
        for number in (50, 52)
        for place in ("front", "rear")
    ),
)


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print what real logs give beside their truths; with --page also write them into the gallery."""
    add = parser.add_argument
    add("--data", type=Path, default=Path(os.environ.get("PITOTBENCH_DATA", "../shared/data")))
    add("--page", action="store_true", help=f"write {PAGE} and its pictures")
    options = parser.parse_args(words)
    found = []
    for entry in ENTRIES:
        lines = list(_section(entry, options.data, options.page))
        print(*lines, "", sep="\n", flush=True)
        found += [*lines, ""]
    if options.page:
        text = PAGE.read_text(encoding="utf-8")
        head, rest = text.split(BEGIN)
        PAGE.write_text(
            f"{head}{BEGIN}\n\n" + "\n".join(found) + f"\n{END}{rest.split(END, 1)[1]}",
            encoding="utf-8",
        )


def _section(entry: Entry, data: Path, draw: bool) -> Iterator[str]:
    path = data / entry.path
    yield f"### {entry.title}"
    yield ""
    if not path.is_file():
        yield f"Left out: {entry.path} is not in the folder of logs."
        return
    mapping = entry.flags.removeprefix(" --mapping ") or None
    yield f"Log: {entry.source}. Truth: {entry.truth}."
    yield ""
    yield f"`pitotbench calibrate {path.name}{entry.flags}`"
    yield ""
    try:
        found = calibrate(path, mapping=mapping)
    except (BadInputError, NoAnswerError) as error:
        yield f"**No answer**: {error}."
        return
    held = entry.hold(path, found)
    yield _verdict(held)
    if draw:
        name = f"real-{path.name.partition('.')[0].lower()}.png"
        _draw(held, PICTURES / name)
        yield ""
        yield f"![{entry.title}: answer and truth](pictures/{name})"


def _verdict(held: Held) -> str:
    inside, count = int(held.inside.sum()), len(held.at)
    if inside == count:
        return f"**Inside** at all {count} places."
    worst = int(np.argmax(np.abs(held.found - held.truth) / np.hypot(held.two_sigma, held.doubt)))
    digits = 1 if np.max(np.abs(held.truth)) > 1.0 else 3
    number = f"{held.found[worst]:+.{digits}f} ± {held.two_sigma[worst]:.{digits}f}"
    return (
        f"**Outside** at {count - inside} of {count} places, farthest at {held.at[worst]:.0f} "
        f"({held.along}): "
        f"{number}, where the truth is {held.truth[worst]:+.{digits}f} ± "
        f"{held.doubt[worst]:.{digits}f}."
    )


def _draw(held: Held, path: Path) -> None:
    known: Mark = band(held.at, held.truth - held.doubt, held.truth + held.doubt, color=GREY)
    marks = drawing(
        known,
        line(held.at, held.truth, color=GREY, label="truth, and how far it may be off"),
        bars(
            held.at,
            held.found,
            held.two_sigma,
            color=BLUE,
            label="answer, ±2σ",
            marker="o",
            ms=3.5,
            ls="none",
        ),
        frame(held.along, held.what),
    )
    with canvas(1, 1, *_SIZE) as (figure, (axes,)):
        marks(axes)
        axes.legend(loc="best")
        figure.savefig(path, dpi=130, metadata={"Software": None})
