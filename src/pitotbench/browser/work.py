"""What a child process computes for the page: flights, drafts, pictures, answers, downloads.

Drafts are those of mappings. Each function calls its first argument with its replies, as they are
ready: what a reply is, as the desk calls it, and the reply itself.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from pitotbench.records.calibration import AutopilotSettings, CalibratedFlight, Calibration
from pitotbench.records.calibration_request import (
    CalibrationChoices,
    CalibrationRequest,
    NamedFile,
    asked_fields,
)
from pitotbench.records.log import FlightLog, FlightSummary
from pitotbench.records.over_dates import OverDates
from pitotbench.show.columns import command_line
from pitotbench.show.reader_units import Units, reader_units
from pitotbench.units import MINUTE, Array, Meters, MetersPerSecond

Tell = Callable[[str, Any], object]
Plain = dict[str, Any]
_MOST_POINTS = 4000  # of a line on the page
NEEDED = (  # modules that an answer loads, which are slow to load
    "pandas", "pyarrow.compute", "pyarrow.csv", "pydantic", "scipy.interpolate", "scipy.optimize",
    "pitotbench.bench.contents", "pitotbench.campaigns.digests",
    "pitotbench.calibration.fit_checks", "pitotbench.calibration.flights",
    "pitotbench.calibration.leg_points", "pitotbench.logbook.autopilot",
    "pitotbench.logbook.drafting", "pitotbench.show.deliverables",
)  # fmt: skip
# What the page asks in words, by name. The files are dropped, minutes are brushed too, and the page
# judges by the usual limit.
SETTINGS = {
    each.name: each
    for each in asked_fields(CalibrationRequest, CalibrationChoices)
    if each.name not in ("mapping", "handbook", "without", "limit")
}
_SHOWN_VALUES = 3  # of a column in the draft of a mapping


@dataclass(frozen=True, slots=True)
class Request(CalibrationRequest):
    """What an answer is asked from: logs, the command's other choices, and options by name.

    The options are those of the calibration that are stated.
    """

    logs: tuple[NamedFile, ...] = ()
    options: tuple[tuple[str, str], ...] = ()

    @property
    def reading(self) -> "Request":
        """What of it says how a log is read and cut."""
        stated = self.parameters if "," in self.parameters else ""  # old ones
        return replace(self, logs=(), handbook=None, options=(), parameters=stated)

    @property
    def whole(self) -> "Request":
        """What of it says how a log is read."""
        return replace(self.reading, begin="", end="", without=())

    def setting(self, name: str) -> str:
        """The text of one of `SETTINGS`; empty where it is not stated."""
        return str(getattr(self, name, dict(self.options).get(name, "")))

    def command(self, units: Units) -> str:
        """The command that gives the same answer in the same units."""
        asked = [*self.texts(), *((SETTINGS[name], [text]) for name, text in self.options)]
        words = ["pitotbench", "calibrate", *(each.name for each in self.logs)]
        for each, texts in asked:
            switch = isinstance(each.default, bool)
            for text in texts:
                words += [each.metadata["flag"], *([] if switch else [text])]
        words += ["--units", units.words] if units != reader_units() else []
        return command_line(words)

    def file_name(self, ending: str) -> str:
        """The name of a file with the answer: that of the first log, and the minutes used."""
        spans = [("from", self.begin), ("to", self.end), *(("without", s) for s in self.without)]
        span = "".join(f"-{word}-{text.replace(':', 'm')}" for word, text in spans if text)
        return f"{Path(self.logs[0].name).name.partition('.')[0]}{span}{ending}"


def fields_of(settings: Mapping[str, str]) -> Plain:
    """Return the fields of a request that state the texts of all `SETTINGS`."""
    own = {each.name for each in fields(Request)}
    return {
        **{name: text for name, text in settings.items() if name in own},
        "options": tuple(
            (name, text) for name, text in settings.items() if text and name not in own
        ),
    }


@dataclass(frozen=True, slots=True)
class Found:
    """A flight of a file, or a file that was not read: it may be the table of a handbook.

    `autopilot` is the name of the autopilot whose log it is, and `several` whether that has several
    airspeed sensors.
    """

    log: NamedFile
    flight: FlightSummary
    autopilot: str = ""
    several: bool = False
    handbook: bool = False


# A column of a log with unknown names, what it may be (empty: nothing) with its unit, the factor of
# its numbers, the question to answer, and its first values.
DraftRow = tuple[str, tuple[str, str], float, str, str]


@dataclass(frozen=True, slots=True)
class Look:
    """A log over time, as the page draws it.

    Minutes from its first row, indicated airspeed, pressure altitude, and the way from its first
    row, NaN where a pause begins; arrays (n,) of at most some 4,000 rows.
    """

    minute: Array
    airspeed: MetersPerSecond
    height: Meters
    north: Meters
    east: Meters


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a request.

    The calibration of its first flight, which flights share it in words, the used spans [s, on the
    log's clock], and the autopilot's parameters where they were asked for. What is not `final` is
    checked further.
    """

    result: Calibration
    flights: tuple[str, ...]
    spans: tuple[tuple[float, float], ...]
    settings: AutopilotSettings | None
    final: bool


def find_flights(tell: Tell, place: Path, names: Mapping[str, str], unpacked: Path) -> None:
    """Tell the flights of a file, a folder or a .zip file, which is unpacked into `unpacked`.

    `names` are those by which the user knows the files, by their path in the folder; that of the
    empty path stands before all others.
    """
    from pitotbench.bench.contents import flights_of
    from pitotbench.logbook.autopilot import autopilot_of
    from pitotbench.logbook.bundle import ZIP, unpack
    from pitotbench.logbook.columns import PARAMETERS, SENSOR
    from pitotbench.logbook.handbook_table import is_published

    prefix = names.get("", "")
    if place.suffix.lower() == ZIP:
        prefix = f"{names.get(place.name, place.name)}/"
        unpack(place, unpacked)
        place = unpacked
    found, plain = [], Request()
    for each in flights_of(place, lambda path: _part(path, plain)):
        path = place / each.file if place.is_dir() else place
        name = "".join(filter(str.isprintable, names.get(each.file, prefix + each.file)))
        book = bool(each.refusal) and is_published(path)
        described = replace(
            each,
            file=name,
            refusal=each.refusal.replace(str(path), name),
            strange=each.strange and not book,
        )
        header = {} if each.refusal else _part(path, plain).header
        autopilot = autopilot_of(header.get(PARAMETERS, ()), header.get(SENSOR, 1))
        found.append(Found(NamedFile(path, name), described, autopilot, SENSOR in header, book))
    tell("found", tuple(found))


EXAMPLE = "example flight.csv"  # of the bench


def fly_example(tell: Tell, place: Path, names: Mapping[str, str], unpacked: Path) -> None:
    """Fly circles on the bench in light turbulence, and write their log to a place.

    The flight is told as `find_flights` does.
    """
    from pitotbench.campaigns.flights import sense
    from pitotbench.logbook.formats import write_log
    from pitotbench.records.case import Case
    from pitotbench.simulation.sortie import fly

    tell("status", "flying an example")
    place.parent.mkdir()
    flight = fly(Case(maneuver="circle", turbulence="light"))
    write_log(sense(flight, "5/1"), place)
    find_flights(tell, place, names, unpacked)


@lru_cache(maxsize=3)
def _table(path: Path, whole: Request) -> Any:
    from pitotbench.logbook.autopilot import stated_parameters
    from pitotbench.logbook.reading import whole_table

    return whole_table(
        path,
        whole.mapping.path if whole.mapping else None,
        stated_parameters(whole.parameters)[1] if whole.parameters else {},
        int(whole.airspeed_sensor) if whole.airspeed_sensor else None,
        whole.facts(),
    )


@lru_cache(maxsize=4)
def _part(path: Path, reading: Request) -> FlightLog:
    """Return the log at a path, read and judged once. Raises BadInputError without the path."""
    from pitotbench.logbook.assembly import log_of, part_of

    table = _table(path, reading.whole)
    # What checks a log may change its columns, and the table is read again for the next part.
    fresh = replace(table, columns=tuple(column.copy() for column in table.columns))
    return log_of(fresh, part_of(reading.begin, reading.end, reading.without))


def draft(tell: Tell, log: NamedFile) -> None:
    """Tell the draft of a mapping as a row a column, as `pitotbench map` drafts it."""
    from pitotbench.logbook.drafting import draft_mapping
    from pitotbench.logbook.reading import read_table

    table = read_table(log.path)
    known = {
        each.guess.theirs: (
            (each.guess.quantity, each.guess.units[0]),
            each.guess.factor,
            each.question,
        )
        for each in draft_mapping(table).lines
    }
    rows: list[DraftRow] = [
        (name, *known.get(name, (("", ""), 1.0, "")), ", ".join(map(str, column[:_SHOWN_VALUES])))
        for name, column in zip(table.names, table.columns, strict=True)
        if name
    ]
    tell("draft", rows)


def mapping_of(rows: Sequence[DraftRow], title: str) -> str:
    """Return the mapping (TOML) that the rows of a draft state."""
    import tomli_w

    columns = {
        theirs: {"name": f"{ours}_{unit}" if unit else ours, "factor": factor}
        for theirs, (ours, unit), factor, *_ in rows
        if ours
    }
    return tomli_w.dumps({"title": title, "columns": columns})


def answer(tell: Tell, request: Request, look: bool) -> None:
    """Tell the answer of a request: its curve first, and all of it at the end.

    Before the curve, tell in words what is done, and the picture of the first log where `look` asks
    for it.
    """
    if look:
        tell("look", (request.whole, _look(_part(request.logs[0].path, request.whole))))
    flights = _calibrated(tell, request)
    tell("answer", _answer(flights, _settings(request, flights[0]), True))
    if len(request.logs) > 2:
        tell("status", "each flight by itself")
        tell("course", _course(request))


def _course(request: Request) -> OverDates | None:
    """Return the correction of each log by itself over their dates; None where they tell none."""
    from pitotbench.calibration.over_dates import over_dates
    from pitotbench.records import BadInputError, NoAnswerError

    found = {}
    for each in request.logs:
        with suppress(BadInputError, NoAnswerError):
            found[each.name] = _calibrated.__wrapped__(_unheard, replace(request, logs=(each,)))
    return over_dates([*found], [*found.values()])


def _unheard(_name: str, _reply: object) -> None:
    """Take what is told of a step that has no place on the page."""


def _answer(
    flights: Sequence[CalibratedFlight], settings: AutopilotSettings | None, final: bool
) -> Answer:
    from pitotbench.show.calibration import flight_lines

    lines = tuple(dict.fromkeys(line for each in flights for line in flight_lines(each)))
    spans = {span for each in flights if each.place == 0 for span in each.calibration.parts}
    return Answer(flights[0].calibration, lines, tuple(sorted(spans)), settings, final)


def _look(log: FlightLog) -> Look:
    import numpy as np

    from pitotbench import air
    from pitotbench.timeline import pauses

    step = np.diff(log.time, prepend=log.time[0])
    airspeed = np.array(air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0)))
    airspeed[pauses(log.time)] = np.nan
    thinned = slice(None, None, max(1, -(-len(log) // _MOST_POINTS)))
    return Look(
        (log.time - log.start)[thinned] / MINUTE,
        airspeed[thinned],
        np.asarray(air.pressure_altitude(log.static_pressure))[thinned],
        np.cumsum(log.velocity_north * step)[thinned],
        np.cumsum(log.velocity_east * step)[thinned],
    )


@lru_cache(maxsize=4)
def _calibrated(tell: Tell, request: Request) -> tuple[CalibratedFlight, ...]:
    """Return the flights of the logs with their calibration: the answer of the command.

    Where it is not known yet, tell what is done, and the curve as soon as it is.
    """
    from pitotbench.bench.calibration_request import calibrate_request
    from pitotbench.calibration.options import choices_of

    choices = choices_of(dict(request.options))
    logs = [_part(each.path, request.reading) for each in request.logs]
    tell("status", f"fitting {sum(map(len, logs)):,} rows")

    def first(flights: Sequence[CalibratedFlight]) -> None:
        tell("answer", _answer(flights, None, False))
        tell("status", "looking for a factor on the airspeed")

    return calibrate_request(request.logs, logs, request, first, **choices)


def _settings(request: Request, flight: CalibratedFlight) -> AutopilotSettings | None:
    from pitotbench.logbook.autopilot import stated_parameters
    from pitotbench.pressure_error.autopilot_settings import autopilot_settings

    name = stated_parameters(request.parameters)[0] if request.parameters else ""
    known = name and flight.calibration.usable
    return autopilot_settings(flight.calibration, name) if known else None


def take(tell: Tell, request: Request, kind: str, units: Units) -> None:
    """Tell the name and the text of a kind of file.

    The kinds are `page`, `card`, `record`, `table`, `sheet`, `parameters` and `json`. What is read
    is in `units`, where the name says that of speed.
    """
    from pitotbench.show.calibration import NamedFlight, doubts_of
    from pitotbench.show.calibration_json import flights_json
    from pitotbench.show.columns import answer_text
    from pitotbench.show.curve_rows import card_csv
    from pitotbench.show.deliverables import PARAMETER_FILES, parameter_file, table_text
    from pitotbench.show.legs import card_sheet
    from pitotbench.show.pages import calibration_record, flights_page

    found = [
        NamedFlight(request.logs[each.place].name, each, _settings(request, each))
        for each in _calibrated(tell, request)
    ]
    first = found[0].flight.calibration
    subject = Path(request.logs[0].name).stem
    tabled = ({"": first.curve}, subject, {"": doubts_of(first)}, first.provenance)
    every, unit = [each.flight.calibration for each in found], units.speed
    makers: dict[str, tuple[str, Callable[[], str]]] = {
        "json": (".json", lambda: answer_text(flights_json(found))),
        "card": (f"-card-{unit}.csv", lambda: card_csv(every[0], unit)),
        "record": (f"-record-{unit}.html", lambda: calibration_record(every, units=units)),
        "table": ("-table.html", lambda: table_text(".html", *tabled)),
        "sheet": ("-legs.html", card_sheet),
        "page": (f"-page-{unit}.html", lambda: flights_page(found, units=units)),
    }
    if (settings := found[0].settings) is not None:
        ending, _ = PARAMETER_FILES[settings.autopilot]
        makers["parameters"] = (ending, partial(parameter_file, settings))
    ending, make = makers[kind]
    tell("file", (request.file_name(ending), make()))


def reduce_legs(tell: Tell, path: Path, accuracy: str) -> None:
    """Tell the answer of the legs of a card (CSV), as `pitotbench fixed-speed` gives it.

    A card with ground speeds and tracks alone gives the true airspeed and the wind.
    """
    import numpy as np

    from pitotbench.calibration.hand_card import reduce_card
    from pitotbench.calibration.leg_methods import fixed_speed
    from pitotbench.calibration.options import accuracies_of, parse_accuracies
    from pitotbench.logbook.points_table import is_points_table, read_ground_legs, read_points
    from pitotbench.show.legs import card_tree, legs_json, legs_tree
    from pitotbench.show.renderers import plain_of
    from pitotbench.units import DEGREE, KNOT

    if is_points_table(path):
        nodes = card_tree(
            reduce_card(*read_points(path), accuracies_of(parse_accuracies(accuracy), {}))
        )
        typed = ["legs.csv", *(["--accuracy", accuracy] if accuracy else [])]
    else:
        speeds, tracks = map(np.array, read_ground_legs(path))
        found = fixed_speed(speeds, tracks)
        nodes = legs_tree(legs_json(found))
        stated = (speeds / KNOT, tracks / DEGREE)
        one, other = (",".join(f"{value:g}" for value in each) for each in stated)
        typed = [f"--ground-speed-kt={one}", f"--track-deg={other}"]
    tell(
        "legs",
        {
            "tree": plain_of(nodes),
            "command": command_line(["pitotbench", "fixed-speed", *typed]),
        },
    )
