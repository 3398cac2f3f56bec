"""Real logs beside an independent truth: what this build answers, inside or outside, with a picture.

The logs are read in place, from the folder that PITOTBENCH_DATA names; an absent one is left out,
with its reason.
"""

import os
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from scipy.io import loadmat

from pitotbench.air import impact_pressure, mach_from_impact_pressure, standard_pressure
from pitotbench.bench.questions import calibrate
from pitotbench.bench.workflow import NamedLog, reconcile_fully
from pitotbench.calibration.fly_by import reduce_fly_bys
from pitotbench.logbook.columns import almost_numbers
from pitotbench.logbook.points_table import read_fly_bys
from pitotbench.logbook.spreadsheet import read_xlsx
from pitotbench.models.maneuver_model import in_place_of_log
from pitotbench.models.sidpac import read_identification
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.show.style import BLUE, GRAY, Mark, band, bars, canvas, drawing, frame, line
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
_PRESSURE_ERROR = "pressure error,\npart of the impact pressure"
GRID_FT = 31.4  # of a division of the tower's grid
LIFT_SLOPE = "lift_slope"


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
    independently, the command that answers, and how the two are held together.
    """

    title: str
    path: str
    source: str
    truth: str
    command: str
    hold: Callable[[Path], Held]

    @property
    def origin(self) -> str:
        """Where log and truth come from."""
        return f"Log: {self.source}. Truth: {self.truth}."


def _handbook(path: Path) -> Held:
    curve, (indicated, calibrated) = calibrate(path).curve, HANDBOOK.T
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


def _balloon(path: Path) -> Held:
    curve = calibrate(path, mapping="jmoss").curve
    speed = curve.indicated_airspeed_kt
    return Held(
        BALLOON_KT,
        np.interp(BALLOON_KT, speed, curve.normalized_pressure_error),
        np.interp(BALLOON_KT, speed, curve.normalized_two_sigma),
        np.array(BALLOON[path.stem]),
        BALLOON_PA / impact_pressure(BALLOON_KT * KNOT),
        "indicated airspeed [kt]",
        _PRESSURE_ERROR,
    )


def _sonde(path: Path) -> Held:
    """The wind of each window along the sonde's own wind at its height."""
    sonde = read_sonde(path.with_name(f"{path.name.partition('-')[0]}-sounding.txt.gz"))
    rows = []
    for each in calibrate(path).winds:
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


def _faired_curve(path: Path) -> Held:
    """The passes of a tower beside the curve that the school drew through those of three sorties."""
    read = _sheet(path)
    by_speed = np.argsort(read["Vic"])
    passes = {
        name: values[by_speed] for name, values in read.items() if len(values) == len(by_speed)
    }
    by_tower = {
        "indicated_airspeed_kt": passes["Vic"],
        "pressure_altitude_ft": passes["Hic"],
        "grid_height_ft": GRID_FT * passes["grid_reading"],
        "tower_pressure_pa": standard_pressure(passes["grid_pa"] * FOOT),
        "tower_temperature_degc": passes["tower_temp"],
    }
    rows = zip(*by_tower.values(), strict=True)
    lines = [",".join(by_tower), *(",".join(f"{cell:.6g}" for cell in row) for row in rows)]
    with TemporaryDirectory() as folder:
        card = Path(folder) / "card.csv"
        card.write_text("\n".join(lines) + "\n", encoding="utf-8")
        found = reduce_fly_bys(*read_fly_bys(card))
    curve = _sheet(path.with_name("hand_faired_curve.xlsx"))
    indicated = np.array([each.indicated_airspeed for each in found])
    mach = mach_from_impact_pressure(
        impact_pressure(indicated), standard_pressure(passes["Hic"] * FOOT)
    )
    return Held(
        indicated / KNOT,
        np.array([each.normalized_pressure_error for each in found]),
        np.array([each.normalized_two_sigma for each in found]),
        np.interp(mach, curve["Mic"], curve["dPp_qcic"]),
        np.zeros(len(found)),
        "indicated airspeed [kt]",
        _PRESSURE_ERROR,
    )


def _sheet(path: Path) -> dict[str, Array]:
    """The columns of numbers of an .xlsx file, without blank cells, by the names in its first row."""
    table = read_xlsx(path)
    numbers = zip(table.names, map(almost_numbers, table.columns), strict=True)
    return {name: each[np.isfinite(each)] for name, each in numbers if each is not None}


def _lift_slope(path: Path) -> Held:
    """The lift slope of a maneuver beside those that Morelli found of the same file."""
    log = in_place_of_log([read_identification(path)], "DHC6")
    found = reconcile_fully(NamedLog(path.name, log), "DHC6", refly=False).account.coefficients
    lift = next(each.measured for each in found if each.effect == LIFT_SLOPE)
    known = loadmat(path.with_name("totter_results.mat"))
    by_equation, by_output = (-float(known[name][0, 0]) for name in ("pZ", "p"))
    return Held(
        np.array([1.0]),
        np.array([lift.value]),
        np.array([lift.two_sigma]),
        np.array([0.5 * (by_equation + by_output)]),
        np.array([0.5 * abs(by_equation - by_output)]),
        "maneuver",
        "lift slope [per rad]",
    )


_PERLAN = "a glider in lee waves, 2018 (IGC, 1 Hz): Society of Flight Test Engineers, perlan-data"
_SONDE = "the radiosonde of the day at the airfield; in lee waves, hours and miles away, it may differ by 25 kt"
_JET = "a jet decelerates and turns, 20 Hz: SaguaroAerospaceResearch/JMOSS (MIT)"
_BALLOON = "the pressure of a weather balloon at GPS height, to 0.5 hPa"

_TPS = "a sortie of the USAF Test Pilot School, read from the tower's grid: jorgec00/tps_py_tools"
_FAIRED = (
    "the curve that the school drew by hand through the passes of three sorties, of which this is "
    "one; an altimeter's own error, which a tower cannot tell from the static source's, is in the passes, "
    "and the curve is the mean of three altimeters"
)

ENTRIES = (
    Entry(
        "An hour of a Cessna 172S with a G1000",
        "garmin/c172s-g1000-2011.csv.gz",
        "travisdesell/ngafid2.0, as the unit wrote it, 1 Hz",
        "the airspeed calibration of the airplane's handbook, flaps up; one airplane may differ by 3 kt",
        "calibrate {}",
        _handbook,
    ),
    *(
        Entry(
            f"{name}, a jet",
            f"jmoss/{name}.csv",
            _JET,
            _BALLOON,
            "calibrate {} --mapping jmoss",
            _balloon,
        )
        for name in BALLOON
    ),
    *(
        Entry(
            f"Perlan 2, flight {number}, {place} recorder",
            f"perlan/flight{number}-{place}.igc.gz",
            _PERLAN,
            _SONDE,
            "calibrate {}",
            _sonde,
        )
        for number in (50, 52)
        for place in ("front", "rear")
    ),
    *(
        Entry(
            f"A T-38 past the tower, {day}",
            f"t38/{name}.xlsx",
            _TPS,
            _FAIRED,
            "fixed-speed card.csv",
            _faired_curve,
        )
        for day, name in (
            ("7 March 2025", "TFB_20250307_378_DAS"),
            ("17 March 2025", "TFB_20250317_COBRA36_HAND"),
        )
    ),
    Entry(
        "NASA's Twin Otter",
        "sidpac/totter_lon_020213f1_018.mat",
        "an elevator maneuver of 8 s, 50 Hz, of NASA's DHC-6 (SIDPAC, in josemiguelbento/UAV-OAT-controlo)",
        "the lift slope (−C_Z by angle of attack) that Morelli found of the same maneuver, by equation error and by output error; halfway, and half their difference",
        "reconcile {} --aircraft DHC6 --terms",
        _lift_slope,
    ),
)


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print what real logs give beside their truths; with --page also write them into the gallery."""
    add = parser.add_argument
    add("--data", type=Path, default=Path(os.environ.get("PITOTBENCH_DATA", "../shared/data")))
    add("--page", action="store_true", help=f"write {PAGE} and its pictures")
    options = parser.parse_args(words)
    found, told = [], ""
    for entry in ENTRIES:
        lines = list(_section(entry, options.data, options.page, told))
        told = entry.origin
        print(*lines, "", sep="\n", flush=True)
        found += [*lines, ""]
    if options.page:
        text = PAGE.read_text(encoding="utf-8")
        head, rest = text.split(BEGIN)
        PAGE.write_text(
            f"{head}{BEGIN}\n\n" + "\n".join(found) + f"\n{END}{rest.split(END, 1)[1]}",
            encoding="utf-8",
        )


def _section(entry: Entry, data: Path, draw: bool, told: str = "") -> Iterator[str]:
    """Yield the lines of an entry; what is told of the origin of the one before is not said again."""
    path = data / entry.path
    yield f"### {entry.title}"
    yield ""
    if not path.is_file():
        yield f"Left out: {entry.path} is not in the folder of logs."
        return
    if entry.origin != told:
        yield entry.origin
        yield ""
    yield f"`pitotbench {entry.command.format(path.name)}`"
    yield ""
    try:
        held = entry.hold(path)
    except (BadInputError, NoAnswerError) as error:
        yield f"**No answer**: {error}."
        return
    yield _verdict(held)
    if draw:
        name = f"real-{path.name.partition('.')[0].lower()}.png"
        _draw(held, PICTURES / name)
        yield ""
        yield f"![{entry.title}: answer and truth](pictures/{name})"


def _verdict(held: Held) -> str:
    inside, count = int(held.inside.sum()), len(held.at)
    if inside == count:
        return f"**Inside** at all {count} places." if count > 1 else "**Inside.**"
    worst = int(np.argmax(np.abs(held.found - held.truth) / np.hypot(held.two_sigma, held.doubt)))
    digits = 1 if np.max(np.abs(held.truth)) > 1.0 else 3
    number = f"{held.found[worst]:+.{digits}f} ± {held.two_sigma[worst]:.{digits}f}"
    return (
        f"**Outside** at {count - inside} of {count} places, farthest at {held.at[worst]:.0f} "
        f"({held.along}): {number}, where the truth is {held.truth[worst]:+.{digits}f} ± "
        f"{held.doubt[worst]:.{digits}f}."
    )


def _draw(held: Held, path: Path) -> None:
    label = "truth, and how far it may be off"
    known: list[Mark] = [
        band(held.at, held.truth - held.doubt, held.truth + held.doubt, color=GRAY),
        line(held.at, held.truth, color=GRAY, label=label),
    ]
    if len(held.at) == 1:
        known = [
            bars(
                held.at,
                held.truth,
                held.doubt,
                color=GRAY,
                label=label,
                marker="s",
                lw=6.0,
                ls="none",
            )
        ]
    marks = drawing(
        *known,
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
        if len(held.at) == 1:
            axes.set_xticks([])
        figure.legend(loc="outside upper left", ncols=2)
        figure.savefig(path, dpi=130, metadata={"Software": None})
