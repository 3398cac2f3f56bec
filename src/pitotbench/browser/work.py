"""What a child process computes for the page: flights of files, drafts of mappings, pictures,
answers, downloads. Each function yields its replies as they are ready.
"""

import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from importlib import import_module
from pathlib import Path
from typing import Any

from pitotbench.records.calibration import AutopilotSettings, CalibratedFlight, Calibration
from pitotbench.records.legs import CardPoint
from pitotbench.records.log import FlightLog, HeldFlight
from pitotbench.show.limits import AUTO
from pitotbench.units import Array, Meters, MetersPerSecond

_MINUTE = 60.0  # s
_MOST_POINTS = 4000  # of a line on the page
_SLOW = (
    "pandas",
    "pyarrow.compute",
    "pyarrow.csv",
    "pydantic",
    "scipy.interpolate",
    "scipy.optimize",
)  # to load
_SHOWN_VALUES = 3  # of a column in the draft of a mapping


@dataclass(frozen=True, slots=True)
class LogFile:
    """A file, and the name by which the user knows it."""

    path: Path
    name: str


@dataclass(frozen=True, slots=True)
class Request:
    """What an answer is asked from: logs, a mapping, and flags of `pitotbench calibrate` as texts,
    empty where not stated. `without` are spans that are left out.
    """

    logs: tuple[LogFile, ...]
    mapping: LogFile | None = None
    begin: str = ""
    end: str = ""
    without: tuple[str, ...] = ()
    model: str = ""
    accuracy: str = ""
    temperature: str = ""
    autopilot: str = ""

    def command(self) -> str:
        """The command that gives the same answer."""
        flags = {
            "--mapping": "" if self.mapping is None else self.mapping.name,
            "--from": self.begin,
            "--to": self.end,
            "--model": self.model,
            "--accuracy": self.accuracy,
            "--temperature-c": self.temperature,
            "--params": self.autopilot,
        }
        stated = [*flags.items(), *(("--without", span) for span in self.without)]
        words = ["pitotbench", "calibrate", *(each.name for each in self.logs)]
        return shlex.join([*words, *(part for each in stated if each[1] for part in each)])


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why there is no answer, in the words of the command."""

    words: str


@dataclass(frozen=True, slots=True)
class Found:
    """A flight of a file, or a file that was not read."""

    log: LogFile
    flight: HeldFlight


@dataclass(frozen=True, slots=True)
class DraftRow:
    """A column of a log with unknown names, what it may be (empty: nothing), its unit, the factor
    of its numbers, the question to answer, and its first values.
    """

    theirs: str
    ours: str
    unit: str
    factor: float
    question: str
    values: str


@dataclass(frozen=True, slots=True)
class Look:
    """A log over time: minutes from its first row, indicated airspeed, pressure altitude, and the
    way from its first row, NaN where a pause begins; arrays (n,) of at most some 4,000 rows.
    """

    minute: Array
    airspeed: MetersPerSecond
    height: Meters
    north: Meters
    east: Meters


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a request: the calibration of its first flight, which flights share it in
    words, the used spans [s, on the log's clock], and the autopilot's parameters where they were
    asked for.
    """

    result: Calibration
    flights: tuple[str, ...]
    spans: tuple[tuple[float, float], ...]
    settings: AutopilotSettings | None


@dataclass(frozen=True, slots=True)
class LegAnswer:
    """The answer of typed legs: sentences, the points of a card where airspeeds were typed, and the
    command that gives the same.
    """

    sentences: tuple[str, ...]
    points: tuple[CardPoint, ...]
    command: str


def warm() -> None:
    """Load what an answer needs, so that it does not wait for that."""
    from pitotbench.bench import contents, digests, questions
    from pitotbench.calibration import fit_checks, flights, leg_points
    from pitotbench.logbook import autopilot, drafting
    from pitotbench.show import takehome

    _ = (
        contents,
        digests,
        questions,
        fit_checks,
        flights,
        leg_points,
        autopilot,
        drafting,
        takehome,
    )
    for name in _SLOW:
        import_module(name)


def find_flights(place: Path, names: dict[str, str], unpacked: Path) -> Iterator[tuple[Found, ...]]:
    """Yield the flights of a file, a folder or a .zip file, which is unpacked into `unpacked`.
    `names` are those by which the user knows the files, by their path in the folder; that of the
    empty path stands before all others.
    """
    from pitotbench.bench.contents import flights_of
    from pitotbench.logbook.bundle import ZIP, unpack

    prefix = names.get("", "")
    if place.suffix.lower() == ZIP:
        prefix = f"{names.get(place.name, place.name)}/"
        unpack(place, unpacked)
        place = unpacked
    held = []
    for each in flights_of(place, lambda path: _read(LogFile(path, ""))):
        path = place / each.file if place.is_dir() else place
        name = "".join(filter(str.isprintable, names.get(each.file, prefix + each.file)))
        told = replace(each, file=name, refusal=each.refusal.replace(str(path), name))
        held.append(Found(LogFile(path, name), told))
    yield tuple(held)


@lru_cache(maxsize=3)
def _table(
    path: Path, mapping: Path | None, stated: tuple[tuple[str, float], ...], temperature: str | None
) -> Any:
    from pitotbench.logbook.reading import whole_table

    return whole_table(path, mapping, dict(stated), temperature)


def _read(log: LogFile, request: Request | None = None) -> FlightLog:
    """Return a log as a request states it, else as it is. Raises BadInputError without the path."""
    from pitotbench.logbook.assembly import log_of, part_of
    from pitotbench.logbook.autopilot import stated_parameters

    asked = request or Request((log,))
    stated = stated_parameters(asked.autopilot)[1] if asked.autopilot else {}
    mapping = asked.mapping.path if asked.mapping else None
    table = _table(log.path, mapping, tuple(stated.items()), asked.temperature or None)
    # What checks a log may change its columns, and the table is read again for the next part.
    fresh = replace(table, columns=tuple(column.copy() for column in table.columns))
    return log_of(fresh, part_of(asked.begin, asked.end, asked.without))


def draft(log: LogFile) -> Iterator[tuple[DraftRow, ...]]:
    """Yield the draft of a mapping as a row a column, as `pitotbench map` drafts it."""
    from pitotbench.logbook.drafting import draft_mapping
    from pitotbench.logbook.reading import read_table

    table = read_table(log.path)
    known = {line.guess.theirs: line for line in draft_mapping(table).lines}
    rows = []
    for name, column in zip(table.names, table.columns, strict=True):
        line = known.pop(name, None)
        told = (
            ("", "", 1.0, "")
            if line is None
            else (line.guess.quantity, line.unit, line.guess.factor, line.question)
        )
        values = ", ".join(str(value) for value in column[:_SHOWN_VALUES])
        rows.append(DraftRow(name, *told, values))
    yield tuple(row for row in rows if row.theirs)


def mapping_of(rows: Sequence[DraftRow], title: str) -> str:
    """Return the mapping (TOML) that the rows of a draft state."""
    import tomli_w

    columns = {
        row.theirs: {
            "name": f"{row.ours}_{row.unit}" if row.unit else row.ours,
            "factor": row.factor,
        }
        for row in rows
        if row.ours
    }
    return tomli_w.dumps({"title": title, "columns": columns})


def answer(request: Request, look: bool) -> Iterator[Look | Answer]:
    """Yield the picture of the first log where `look` asks for it, then the answer."""
    from pitotbench.show.calibration import flight_lines

    if look:
        yield _look(_read(request.logs[0], replace(request, begin="", end="", without=())))
    flights = _calibrated(request)
    first = flights[0].calibration
    spans = {span for each in flights if each.place == 0 for span in each.calibration.parts}
    yield Answer(
        first,
        tuple(line for each in flights for line in flight_lines(each)),
        tuple(sorted(spans)),
        _settings(request, flights[0]),
    )


def _look(log: FlightLog) -> Look:
    import numpy as np

    from pitotbench import air
    from pitotbench.timeline import pauses

    step = np.diff(log.time, prepend=log.time[0])
    airspeed = np.array(air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0)))
    airspeed[pauses(log.time)] = np.nan
    thinned = slice(None, None, max(1, -(-len(log) // _MOST_POINTS)))
    return Look(
        (log.time - log.start)[thinned] / _MINUTE,
        airspeed[thinned],
        np.asarray(air.pressure_altitude(log.static_pressure))[thinned],
        np.cumsum(log.velocity_north * step)[thinned],
        np.cumsum(log.velocity_east * step)[thinned],
    )


@lru_cache(maxsize=1)
def _calibrated(request: Request) -> tuple[CalibratedFlight, ...]:
    """Return the flights of the logs with their calibration: the answer of the command."""
    from pitotbench.bench.questions import calibrate_each, flag_choice, sources_of
    from pitotbench.calibration.options import parse_accuracies

    stated = {"model": request.model, "accuracies": parse_accuracies(request.accuracy)}
    choices: dict[str, Any] = {name: value for name, value in stated.items() if value}
    logs = [_read(each, request) for each in request.logs]
    mapping = request.mapping
    flags = [
        flag_choice("mapping", mapping.name if mapping else None, "as recognized"),
        flag_choice("from", request.begin or None, "the first row"),
        flag_choice("to", request.end or None, "the last row"),
        flag_choice("without", ", ".join(request.without) or None, "none"),
        flag_choice("limit", None, "auto"),
        flag_choice("params", request.autopilot or None, "none"),
        flag_choice("temperature_c", request.temperature or None, "as logged, else a standard day"),
    ]
    sources = [
        *sources_of("log", [each.path for each in request.logs], logs),
        *([("mapping", mapping.path, None)] if mapping else []),
    ]
    found = calibrate_each(logs, None, mapping.path if mapping else None, sources, flags, **choices)
    names = {each.path.name: each.name for each in request.logs}
    made = found[0].calibration.provenance
    told = replace(
        made, inputs=tuple(replace(i, name=names.get(i.name, i.name)) for i in made.inputs)
    )
    return tuple(
        replace(each, calibration=replace(each.calibration, provenance=told)) for each in found
    )


def _settings(request: Request, flight: CalibratedFlight) -> AutopilotSettings | None:
    from pitotbench.logbook.autopilot import autopilot_settings, stated_parameters

    if not request.autopilot:
        return None
    return autopilot_settings(flight.calibration, stated_parameters(request.autopilot)[0])


def take(request: Request, kind: str) -> Iterator[tuple[str, str]]:
    """Yield name and text of a kind of file: `page`, `card`, `record`, `parameters` or `json`."""
    from pitotbench.show.calibration import card_csv, doubts_of, flight_lines
    from pitotbench.show.columns import json_text
    from pitotbench.show.pages import calibration_record, log_page, log_section
    from pitotbench.show.takehome import PARAMETER_FILES, flight_document, parameter_file

    flights = _calibrated(request)
    first = flights[0].calibration
    names = [request.logs[each.place].name for each in flights]
    found = [_settings(request, each) for each in flights]
    rows = list(zip(names, flights, found, strict=True))
    documents = [flight_document(Path(n).name, each, s) for n, each, s in rows]
    title = f"Pitot-static calibration: {', '.join(dict.fromkeys(names))}"
    makers: dict[str, tuple[str, Callable[[], str]]] = {
        "json": (".json", lambda: json_text(documents if len(rows) > 1 else documents[0])),
        "card": ("-card.csv", lambda: card_csv(first.curve, doubts_of(first))),
        "record": (
            "-record.html",
            lambda: calibration_record([each.calibration for each in flights]),
        ),
        "page": (
            ".html",
            lambda: log_page(
                title,
                [
                    log_section(n, each.log, each.calibration, AUTO, flight_lines(each), s)
                    for n, each, s in rows
                ],
            ),
        ),
    }
    if (settings := found[0]) is not None:
        ending = PARAMETER_FILES[settings.autopilot][0]
        makers["parameters"] = (ending, partial(parameter_file, settings))
    ending, make = makers[kind]
    yield Path(names[0]).name.partition(".")[0] + ending, make()


def reduce_legs(path: Path, accuracy: str) -> Iterator[LegAnswer]:
    """Yield the answer of the legs of a card (CSV), as `pitotbench fixed-speed` gives it; of one
    with ground speeds and tracks alone the true airspeed and the wind.
    """
    from pitotbench.calibration.hand_card import reduce_card
    from pitotbench.calibration.leg_points import fixed_speed
    from pitotbench.calibration.options import accuracies_of, parse_accuracies
    from pitotbench.logbook.csv import read_csv
    from pitotbench.logbook.points_table import is_points_table, read_points
    from pitotbench.show.calibration import Correction, correction_sentence, doubts_of_curve
    from pitotbench.show.legs import legs_json, legs_sentences
    from pitotbench.units import DEGREE, KNOT

    if is_points_table(path):
        stated = accuracies_of(parse_accuracies(accuracy), {})
        card = reduce_card(*read_points(path), stated)
        doubts = [line for curve in card.curves.values() for line in doubts_of_curve(curve)]
        corrections = [
            Correction(*(each / KNOT for each in (p.indicated_airspeed, p.correction, p.two_sigma)))
            for p in card.points
            if p.correction is not None and p.two_sigma is not None
        ]
        answers = [correction_sentence(corrections)] if corrections else []
        told = (*answers, *card.warnings, *dict.fromkeys(doubts))
        yield LegAnswer(told, card.points, "pitotbench fixed-speed legs.csv")
        return
    speeds, tracks = read_csv(path).columns
    found = fixed_speed(speeds * KNOT, tracks * DEGREE)
    answer = legs_json(found.true_airspeed, found.spread, found.wind_speed, found.wind_from)
    flags = [",".join(f"{value:g}" for value in each) for each in (speeds, tracks)]
    command = f"pitotbench fixed-speed --ground-speed-kt={flags[0]} --track-deg={flags[1]}"
    yield LegAnswer(tuple(legs_sentences(answer)), (), command)
