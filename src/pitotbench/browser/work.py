"""What a child process computes for the page: flights of files, drafts of mappings, pictures,
answers, downloads. Each function yields its replies as they are ready.
"""

import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from typing import Any

from pitotbench.records.calibration import (
    AutopilotSettings,
    CalibratedFlight,
    ErrorCurve,
    FixedSpeedPoint,
)
from pitotbench.records.legs import HandCard
from pitotbench.records.log import FlightLog, HeldFlight
from pitotbench.show.calibration import ShortAnswer
from pitotbench.units import Array, Meters, MetersPerSecond

_MOST_POINTS = 4000  # of a line on the page
_SLOW = (
    "pandas",
    "pyarrow.compute",
    "pyarrow.csv",
    "pydantic",
    "scipy.interpolate",
    "scipy.optimize",
)  # to load
_LONGEST = 40  # letters of a file in the list of flights
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
        stated = [part for flag, text in flags.items() if text for part in (flag, text)]
        left_out = [part for span in self.without for part in ("--without", span)]
        names = [each.name for each in self.logs]
        return shlex.join(["pitotbench", "calibrate", *names, *stated, *left_out])


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why there is no answer, in the words of the command."""

    words: str


@dataclass(frozen=True, slots=True)
class Found:
    """A flight of a file, or a file that was not read; `strange` where a mapping would help."""

    log: LogFile
    flight: HeldFlight
    strange: bool = False


@dataclass(frozen=True, slots=True)
class DraftRow:
    """A column of a log with unknown names, what it may be (empty: nothing), its unit, the factor
    of its numbers, its first values, and the question to answer.
    """

    theirs: str
    ours: str
    unit: str
    factor: float
    values: str
    question: str


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
    """An answer as the page shows it: sentences as the command prints them, the curve, and samples
    (minute, airspeed [m/s], correction [m/s]). `spans` [min] were used.
    """

    short: ShortAnswer
    flights: tuple[str, ...]
    headline: tuple[str, ...]
    usable: bool
    rules: tuple[str, ...]
    notes: tuple[str, ...]
    curve: ErrorCurve
    samples: tuple[Array, MetersPerSecond, MetersPerSecond]
    points: tuple[FixedSpeedPoint, ...]
    spans: tuple[tuple[float, float], ...]
    settings: AutopilotSettings | None
    autopilot: str  # whose parameters the log holds, empty for none


@dataclass(frozen=True, slots=True)
class LegAnswer:
    """The answer of typed legs: a card, or where no airspeeds were typed true airspeed and wind in
    words; and the command that gives the same.
    """

    card: HandCard | None
    sentences: tuple[str, ...]
    command: str


@dataclass(frozen=True, slots=True)
class Download:
    """A file to take away."""

    name: str
    text: str


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
    from pitotbench.logbook.draft import MissingColumnsError

    unknown = set()

    def read(path: Path) -> FlightLog:
        try:
            return _read(LogFile(path, ""))
        except MissingColumnsError:
            unknown.add(path)
            raise

    prefix = names.get("", "")
    if place.suffix.lower() == ZIP:
        prefix = f"{names.get(place.name, place.name)}/"
        unpack(place, unpacked)
        place = unpacked
    held = []
    for each in flights_of(place, read):
        path = place / each.file if place.is_dir() else place
        name = names.get(each.file, prefix + each.file)
        refusal = each.refusal.replace(str(path), name)
        short = name if len(name) <= _LONGEST else f"…{name[-_LONGEST:]}"
        told = replace(each, file=short, refusal=refusal)
        held.append(Found(LogFile(path, name), told, path in unknown))
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
    drafted = draft_mapping(table)
    known = {line.guess.theirs: line for line in drafted.lines}
    rows = []
    for name, column in zip(table.names, table.columns, strict=True):
        values = ", ".join(str(value) for value in column[:_SHOWN_VALUES])
        if name in known:
            line = known.pop(name)
            guess = line.guess
            rows.append(
                DraftRow(name, guess.quantity, line.unit, guess.factor, values, line.question)
            )
        elif name:
            rows.append(DraftRow(name, "", "", 1.0, values, ""))
    yield tuple(rows)


def mapping_of(rows: Sequence[DraftRow], title: str) -> str:
    """Return the mapping (TOML) that the rows of a draft state."""
    import tomli_w

    columns: dict[str, object] = {}
    for row in rows:
        if row.ours:
            target = f"{row.ours}_{row.unit}" if row.unit else row.ours
            plain = row.factor == 1.0
            columns[row.theirs] = target if plain else {"name": target, "factor": row.factor}
    return tomli_w.dumps({"title": title, "columns": columns})


def answer(request: Request, look: bool) -> Iterator[Look | Answer]:
    """Yield the picture of the first log where `look` asks for it, then the answer."""
    from pitotbench.logbook.autopilot import AUTOPILOTS
    from pitotbench.show.calibration import (
        assumption_lines,
        flight_lines,
        headline,
        location_lines,
        part_lines,
        samples_of,
        short_answer_of,
    )
    from pitotbench.show.limits import judgments

    if look:
        whole = replace(request, begin="", end="", without=())
        yield _look(_read(request.logs[0], whole))
    flights = _calibrated(request)
    first = flights[0].calibration
    time, speed, correction = samples_of(first)
    held = {} if first.autopilot is None else first.autopilot.parameters
    spans = {span for each in flights for span in each.calibration.parts if each.place == 0}
    yield Answer(
        replace(short_answer_of(first, ""), warnings=tuple(map(str, first.warnings))),
        tuple(line for each in flights for line in flight_lines(each)),
        tuple(headline(first)),
        first.usable,
        tuple(judgment.sentence for judgment in judgments(first)),
        (*part_lines(first), *location_lines(first), *assumption_lines(first)),
        first.curve,
        ((time - first.log_start) / 60.0, speed, correction),
        first.points,
        tuple(
            ((a - first.log_start) / 60.0, (b - first.log_start) / 60.0) for a, b in sorted(spans)
        ),
        _settings(request, flights[0]),
        next((name for name, each in AUTOPILOTS.items() if each.gain in held), ""),
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
        (log.time - log.start)[thinned] / 60.0,
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

    choices: dict[str, Any] = {"model": request.model} if request.model else {}
    if request.accuracy:
        choices["accuracies"] = parse_accuracies(request.accuracy)
    paths = [each.path for each in request.logs]
    logs = [_read(each, request) for each in request.logs]
    stated = request.mapping
    mapping = stated.path if stated else None
    flags = [
        flag_choice("mapping", stated.name if stated else None, "as recognized"),
        flag_choice("from", request.begin or None, "the first row"),
        flag_choice("to", request.end or None, "the last row"),
        flag_choice("without", ", ".join(request.without) or None, "none"),
        flag_choice("limit", None, "auto"),
        flag_choice("params", request.autopilot or None, "none"),
        flag_choice("temperature_c", request.temperature or None, "as logged, else a standard day"),
    ]
    own = [("mapping", mapping, None)] if mapping else []
    sources = [*sources_of("log", paths, logs), *own]
    flights = calibrate_each(logs, None, mapping, sources, flags, **choices)
    names = {each.path.name: each.name for each in request.logs}

    def named(flight: CalibratedFlight) -> CalibratedFlight:
        made = flight.calibration.provenance
        inputs = tuple(replace(i, name=names.get(i.name, i.name)) for i in made.inputs)
        return replace(
            flight,
            calibration=replace(flight.calibration, provenance=replace(made, inputs=inputs)),
        )

    return tuple(map(named, flights))


def _settings(request: Request, flight: CalibratedFlight) -> AutopilotSettings | None:
    from pitotbench.logbook.autopilot import autopilot_settings, stated_parameters

    if not request.autopilot:
        return None
    return autopilot_settings(flight.calibration, stated_parameters(request.autopilot)[0])


def take(request: Request, kind: str) -> Iterator[Download]:
    """Yield the file of a kind: `page`, `card`, `record`, `parameters` or `json`."""
    from pitotbench.show.calibration import card_csv, doubts_of, flight_lines
    from pitotbench.show.columns import json_text
    from pitotbench.show.takehome import (
        PARAMETER_FILES,
        calibration_record,
        flight_document,
        parameter_file,
    )

    flights = _calibrated(request)
    first = flights[0]
    names = [request.logs[each.place].name for each in flights]
    stem = Path(names[0]).name.partition(".")[0]
    settings = [_settings(request, each) for each in flights]
    if kind == "json":
        rows = zip(names, flights, settings, strict=True)
        documents = [flight_document(Path(n).name, each, found) for n, each, found in rows]
        text = json_text(documents[0] if len(documents) == 1 else documents)
        yield Download(f"{stem}.json", text)
    elif kind == "card":
        curve = first.calibration.curve
        yield Download(f"{stem}-card.csv", card_csv(curve, doubts_of(first.calibration)))
    elif kind == "record":
        yield Download(
            f"{stem}-record.html", calibration_record([each.calibration for each in flights])
        )
    elif kind == "parameters" and settings[0] is not None:
        suffix = PARAMETER_FILES[settings[0].autopilot][0]
        yield Download(stem + suffix, parameter_file(settings[0]))
    elif kind == "page":
        from pitotbench.show.pages import log_page, log_section

        sections = [
            log_section(n, each.log, each.calibration, lines=flight_lines(each), settings=found)
            for n, each, found in zip(names, flights, settings, strict=True)
        ]
        title = f"Pitot-static calibration: {', '.join(dict.fromkeys(names))}"
        yield Download(f"{stem}.html", log_page(title, sections))


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
        stated = accuracies_of(parse_accuracies(accuracy) if accuracy else None, {})
        card = reduce_card(*read_points(path), stated)
        doubts = [line for curve in card.curves.values() for line in doubts_of_curve(curve)]
        corrections = [
            Correction(*(each / KNOT for each in (p.indicated_airspeed, p.correction, p.two_sigma)))
            for p in card.points
            if p.correction is not None and p.two_sigma is not None
        ]
        first = [correction_sentence(corrections)] if corrections else []
        told = (*first, *card.warnings, *dict.fromkeys(doubts))
        yield LegAnswer(card, told, "pitotbench fixed-speed legs.csv")
        return
    speeds, tracks = read_csv(path).columns
    found = fixed_speed(speeds * KNOT, tracks * DEGREE)
    answer = legs_json(found.true_airspeed, found.spread, found.wind_speed, found.wind_from)
    flags = [",".join(f"{value:g}" for value in each) for each in (speeds, tracks)]
    words = [
        "pitotbench",
        "fixed-speed",
        f"--ground-speed-kt={flags[0]}",
        f"--track-deg={flags[1]}",
    ]
    yield LegAnswer(None, tuple(legs_sentences(answer)), shlex.join(words))
