"""Try the files of other recorders as a user types them, and hold the answers against what is known.

Each is a command on a file that is read in place. The answer is right where it lies inside its own
bound about the truth; a refusal is right where the file holds no answer and the words say why.
"""

import json
import os
import time
from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from math import atan2, degrees, hypot
from pathlib import Path
from typing import Any

from pitotbench.cli.app import main as product
from pitotbench.cli.shared_flags import BAD_INPUT, DONE

_WIND_KT = 1.0  # by which the wind may differ beyond its bound
_FROM_DEG = 6.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a command gave: its exit code, its documents (JSON) and what it said beside them."""

    code: int
    documents: tuple[Mapping[str, Any], ...]
    said: str

    @property
    def points(self) -> list[Mapping[str, Any]]:
        """The points of the first curve, or those of the legs."""
        if not self.documents:
            return []
        first = self.documents[0]
        return list(first.get("curve") or first.get("points") or [])


Judge = Callable[[Outcome], bool]


def correction(
    truth: Callable[[float], float] | float,
    wind: tuple[float, float] | None = None,
    bound: float = 100.0,
    usable: bool = True,
) -> Judge:
    """A curve whose two ends and middle hold the true correction [kt], a number or a function of
    KIAS, with bounds [kt] that are not wider; `wind` is its speed [kt] and where it is from [°].
    """
    of = truth if callable(truth) else lambda _: truth

    def judge(outcome: Outcome) -> bool:
        points = outcome.points
        if outcome.code != DONE or not points:
            return False
        ends = (points[0], points[len(points) // 2], points[-1])
        inside = all(
            abs(p["correction_kt"] - of(p["indicated_airspeed_kt"])) <= p["two_sigma_kt"] <= bound
            for p in ends
        )
        trusted = bool(outcome.documents[0].get("usable", True)) or not usable
        return inside and trusted and (wind is None or _has_wind(outcome.documents[0], *wind))

    return judge


def _has_wind(document: Mapping[str, Any], speed: float, direction: float) -> bool:
    found = document.get("wind")
    legs = [p for p in document.get("points", ()) if p.get("wind_speed_kt") is not None]
    if found is None and not legs:
        return False
    size, where = (
        (legs[0]["wind_speed_kt"], legs[0]["wind_from_deg"])
        if found is None
        else _toward(found["north_kt"], found["east_kt"])
    )
    turned = (where - direction + 180.0) % 360.0 - 180.0
    return bool(abs(size - speed) <= _WIND_KT and abs(turned) <= _FROM_DEG)


def _toward(north: float, east: float) -> tuple[float, float]:
    """Return the speed of a wind toward north and east, and where it is from [°]."""
    return hypot(north, east), degrees(atan2(-east, -north))


def factor(size: float, wind: tuple[float, float] | None = None, bound: float = 100.0) -> Judge:
    """A curve of an airspeed that is to be multiplied by a size."""
    return correction(lambda shown: (size - 1.0) * shown, wind, bound)


def parameters(**known: float) -> Judge:
    """A usable answer whose parameters hold the known values."""

    def judge(outcome: Outcome) -> bool:
        if outcome.code != DONE or not outcome.documents[0].get("usable", True):
            return False
        found = {p["name"]: p for p in outcome.documents[0].get("params") or ()}
        return all(
            name in found and abs(found[name]["value"] - value) <= found[name]["two_sigma"]
            for name, value in known.items()
        )

    return judge


def refused(*words: str) -> Judge:
    """A refusal that holds some words, in this writing or another."""

    def judge(outcome: Outcome) -> bool:
        return outcome.code != DONE and all(w.lower() in outcome.said.lower() for w in words)

    return judge


def _half(outcome: Outcome) -> bool:
    named = "closed" in outcome.said or "blocked" in outcome.said
    return named or parameters(ARSPD_RATIO=8.0)(outcome)


def _factors(outcome: Outcome) -> bool:
    """The tunnel's table: 1.035 above 11 m/s, 1.11 at the slowest point, each with its bound."""
    points = outcome.points
    known = {0: 1.11, len(points) - 1: 1.035}
    return bool(points) and all(
        abs(points[at].get("factor", 0.0) - size) < 0.02 for at, size in known.items()
    )


@dataclass(frozen=True, slots=True)
class Tried:
    """A file with the command that is typed, and what is right."""

    file: str
    right: Judge
    command: str = "calibrate {} --json"


_LEGS = "fixed-speed {} --json"
_ARDUPILOT = "calibrate {} --params ardupilot --json"
CASES = (
    Tried("01b-hand-card-other-order.csv", correction(1.5, (10.0, 200.0)), _LEGS),
    Tried("02-g3x-touch-whole-mps.csv", correction(2.0)),
    Tried("03-garmin-g5.csv", correction(2.0)),
    Tried("05-one-glitch-at-a-quarter-hertz.csv", correction(2.0)),
    Tried("06-inav-blackbox.csv", factor(1.25)),
    Tried("07a-qgroundcontrol.csv", factor(1.0 / 0.88)),
    Tried("08-x-plane-data.txt", correction(0.0)),
    Tried("09-edgetx.csv", factor(1.0 / 0.88)),
    Tried(
        "10-ardupilot-csv-with-old-ratio",
        parameters(ARSPD_RATIO=2.0),
        "calibrate {} --params ardupilot,ARSPD_RATIO=2 --json",
    ),
    Tried("10-ardupilot-same-flight.bin", parameters(ARSPD_RATIO=2.0), _ARDUPILOT),
    Tried("12-airspeed-reads-half.bin", _half, _ARDUPILOT),
    Tried("13a-pitot-ices-halfway.bin", refused("dies", "--to 2:3")),
    Tried("14a-igc-tas-without-temperature.igc", correction(0.0)),
    Tried("14b-igc-tas-26-kmh-high.igc", correction(-12.8, bound=2.0)),
    Tried("15-dashlink-rates.mat", correction(2.0)),
    Tried("16-dataflash-text.log", parameters(ARSPD_RATIO=2.0), _ARDUPILOT),
    Tried("17-handbook-kias-kcas.csv", refused("handbook", "aircraft indicator")),
    Tried("18-headings-written-as-tracks.csv", correction(0.0, (20.0, 270.0)), _LEGS),
    Tried("18b-headings-card.csv", correction(0.0, (20.0, 270.0)), _LEGS),
    Tried("19-tas-in-the-ias-column.csv", lambda o: "true airspeed" in json.dumps(o.documents)),
    Tried("20-msfs-simvars.csv", correction(0.0)),
    Tried("21-dynon-d180-no-gps.csv", refused("no ground speed")),
    Tried("22a-glider-circles-2s-positions.csv", correction(0.0, (8.0, 250.0))),
    Tried("22c-same-flight-with-velocity.csv.gz", correction(0.0, (8.0, 250.0))),
    Tried("22d-glider-circles-1s-positions.csv.gz", correction(0.0, (8.0, 250.0))),
    Tried("23-uav-struct-two-rates-kpa.mat", factor(1.06, (9.0, 276.0))),
    Tried("24-px4-topics-of-2017", factor(1.03, (5.0, 292.0))),
    Tried("26-tunnel-points.csv", _factors, _LEGS),
    Tried("28-default-ratio", parameters(ARSPD_RATIO=1.633, ARSPD_OFFSET=7.0), _ARDUPILOT),
    Tried("29-no-altitude.mat", factor(1.033, bound=2.0), "calibrate {} --height 300 --json"),
    Tried("30-mode-s-held-values.csv.gz", correction(3.0, bound=3.0)),
    Tried("32-car-on-a-road.csv.gz", factor(1.0 / 0.84, bound=2.0), "calibrate {} --wind 0 --json"),
)


def run(typed: str, file: Path) -> tuple[Outcome, float]:
    """Type a command on a file; return what it gave and its CPU time [s]."""
    out, err, began = StringIO(), StringIO(), time.process_time()
    words = [str(file) if word == "{}" else word for word in typed.split()]
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = product(words)
        except SystemExit as stop:  # a wrong flag
            code = stop.code if isinstance(stop.code, int) else BAD_INPUT
    text = out.getvalue()
    found = json.loads(text) if text and "--json" in words else []
    documents = tuple(found if isinstance(found, list) else [found])
    return Outcome(code, documents, err.getvalue()), time.process_time() - began


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Type a command on each file and print which answers are right, with what the others say."""
    add = parser.add_argument
    data = Path(os.environ.get("PITOTBENCH_DATA", "../shared/data"))
    add("--cases", type=Path, default=data / ".." / "cases", help="folder of the small files")
    add("--only", default="", help="files whose names begin so")
    options = parser.parse_args(words)
    tried = [each for each in CASES if each.file.startswith(options.only)]
    right = 0
    for each in tried:
        path = options.cases / each.file
        if not path.exists():
            print(f"absent  {each.file}")
            continue
        outcome, seconds = run(each.command, path)
        good = each.right(outcome)
        right += good
        print(f"{'right' if good else 'WRONG'} {seconds:5.1f} s  {each.file}")
        if not good:
            print(f"        {each.command}: {outcome.code}, {_summary(outcome)}")
    print(f"{right} of {len(tried)} right")


def _summary(outcome: Outcome) -> str:
    points = outcome.points
    told = [
        f"{p['correction_kt']:+.2f} ± {p['two_sigma_kt']:.2f} at {p['indicated_airspeed_kt']:.0f}"
        for p in (points[:1] + points[len(points) // 2 : len(points) // 2 + 1] + points[-1:])
        if "correction_kt" in p
    ]
    return "; ".join(told) or " ".join(outcome.said.split())[:240]
