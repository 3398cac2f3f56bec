"""`pitotbench calibrate`: find the error curve and the wind of one log or of several."""

import argparse
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pitotbench.cli.shared_flags import (
    flag,
    read_logs,
    require_page,
    require_table,
    say,
    shared,
    stated_assumptions,
    stated_part,
    stated_reading,
    tell,
    write_page,
    write_table,
)
from pitotbench.records import BadInputError

if TYPE_CHECKING:
    from pitotbench.bench.calibration_request import CalibrationRequest
    from pitotbench.records.calibration import CalibratedFlight
    from pitotbench.records.log import FlightLog

_CHOICES = ("model", "method", "error_location", "mach_max", "wind")
_NAMED_LATENCIES = ("checked", "estimated")


FLAGS = (
    flag(
        "logs",
        nargs="+",
        type=Path,
        metavar="LOG",
        help="log file (.csv, .parquet, .mat, .ulg, .bin, .igc), or a folder or .zip of logs",
    ),
    flag("--model", help="pressure-error model (default: the mapping's, else smooth)"),
    *shared("mapping", "part", "temperature", "sensor", "accuracy", "priors"),
    flag("--mach-max", type=float, help="leave out rows above this Mach number"),
    flag("--ground-speed-min-kt", type=float, help="leave out rows below this ground speed [kt]"),
    flag("--on-condition", action="store_true", help="use only rows flagged on condition"),
    flag("--no-down", action="store_true", help="do not use the vertical GPS velocity"),
    flag("--no-altitude", action="store_true", help="do not use the height by GPS"),
    flag("--method", help="covering or paper (default: covering)"),
    flag(
        "--error-location",
        help="auto (by GPS height where the log has it), static, total or impact (as published) "
        "(default: the "
        "mapping's, else auto)",
    ),
    flag(
        "--wind",
        help="constant, checked (constant or changing, averaged by evidence; drifting in a long "
        "flight), linear "
        "(in time and height) or drifting (default: checked)",
    ),
    flag(
        "--latency",
        help="seconds by which GPS velocity trails the air data, or `estimated` from the log, or `checked` "
        "(default)",
    ),
    flag("--all-rows", action="store_true", help="keep faulty rows"),
    flag(
        "--separately",
        action="store_true",
        help="a curve for each of several logs, not one for all",
    ),
    flag("-v", "--verbose", action="store_true", help="print every point of the curve and the fit"),
    flag(
        "--limit",
        default="auto",
        help="judge the curve by far25, far23, none, or your own, such as 2%%,3kt,30ft (altitude "
        "for each 100 kt) "
        "(default: far23 below Mach 0.6, else far25, where the curve reaches 60 kt)",
    ),
    flag(
        "--params",
        metavar="AUTOPILOT",
        help="also the parameters to set: ardupilot or px4, with the old values where the log has "
        "none "
        "(px4,ASPD_SCALE_1=1,SENS_DPRES_OFF=0)",
    ),
    flag(
        "-o",
        dest="parameter_file",
        type=Path,
        metavar="FILE",
        help="also write the parameters of --params as a file that the ground station loads: "
        ".param of ArduPilot (Mission Planner, MAVProxy), .params of PX4 (QGroundControl)",
    ),
    flag(
        "--handbook",
        type=Path,
        metavar="TABLE.csv",
        help="compare the curve with that of a handbook: columns KIAS, KCAS and, where it has "
        "several, configuration",
    ),
    flag("--card", type=Path, help="also write the airspeed card (.csv)"),
    *shared("report", "record", "table", "units", "json"),
)


def run(options: argparse.Namespace) -> int:
    """Calibrate the logs and print the answers; return exit code 0.

    Raises BadInputError for options that do not go together, and as the steps that it joins do.
    """
    from pitotbench.pressure_error.autopilot_settings import autopilot_settings
    from pitotbench.records.outputs import PAGES, require_file
    from pitotbench.show.calibration import NamedFlight, doubts_of
    from pitotbench.show.calibration_json import flights_json
    from pitotbench.show.calibration_tree import flight_tree
    from pitotbench.show.curve_rows import card_csv
    from pitotbench.show.deliverables import PARAMETER_FILES, parameter_file
    from pitotbench.show.limits import limit_named
    from pitotbench.show.reader_units import reader_units
    from pitotbench.show.tree import Sentence

    bundled = _take_bundles(options)
    require_page(options.report, _inputs(options))
    autopilot, _ = _stated_autopilot(options)
    if options.parameter_file is not None and not autopilot:
        raise BadInputError("-o writes autopilot parameters: add --params ardupilot or px4")
    for name, path, suffixes in (
        ("--card", options.card, (".csv",)),
        ("--record", options.record, PAGES),
        ("-o", options.parameter_file, PARAMETER_FILES.get(autopilot, ("",))[:1]),
    ):
        if path is not None:
            _require_one_curve(name, len(options.logs) if options.separately and not bundled else 1)
            require_file(path, suffixes, _inputs(options))
    require_table(options, _inputs(options))
    limit, units = limit_named(options.limit), reader_units(options.units)
    found = [
        NamedFlight(
            str(path),
            flight,
            autopilot_settings(flight.calibration, autopilot)
            if autopilot and (flight.calibration.usable or options.parameter_file)
            else None,
        )
        for path, flight in _reduced(options, bundled)
    ]
    own = {each.name: each.flight.calibration for each in found if each.own_curve}
    curves = len({each.file for each in found if each.own_curve})
    for name, path in (("--card", options.card), ("--record", options.record)):
        _require_one_curve(name, 1 if path is None else curves)
    first = found[0].flight.calibration
    if options.report or options.record:
        from pitotbench.show.pages import calibration_record, flights_page

        # A flight with a curve of its own, as of `auto`, is no part of the record of the first one.
        same = [first, *(each.flight.calibration for each in found[1:] if not each.own_curve)]
        write_page(options.report, lambda: flights_page(found, limit, units))
        write_page(options.record, lambda: calibration_record(same, limit, units))
    write_page(options.card, lambda: card_csv(first))
    if (settings := found[0].settings) is not None:
        write_page(options.parameter_file, partial(parameter_file, settings))
    write_table(
        options,
        {name: each.curve for name, each in own.items()},
        {name: doubts_of(each) for name, each in own.items()},
        first.provenance,
    )
    more = "-v for all numbers" + ("" if options.report else ", --report PAGE.html for pictures")
    tell(
        options,
        lambda: flights_json(found, limit),
        lambda: [
            *(flight_tree(each, limit) for each in found),
            *([] if options.verbose else [Sentence(f"More: {more}.")]),
        ],
    )
    return 0


def _take_bundles(options: argparse.Namespace) -> bool:
    """Put the paths of its logs in the place of a folder or of a .zip file that holds several;
    return whether there is one. A mapping may be of a folder, which is a log then.
    """
    from pitotbench.logbook.bundle import logs_given

    given = len(options.logs)
    if options.mapping is None:
        options.logs = [log for path in options.logs for log in logs_given(path)]
    return len(options.logs) > given


def _require_one_curve(name: str, curves: int) -> None:
    if curves > 1:
        raise BadInputError(
            f"{name} holds one curve, and there would be {curves}: leave out --separately, or give "
            "the logs one by one"
        )


def _reduced(options: argparse.Namespace, bundled: bool) -> "list[tuple[Path, CalibratedFlight]]":
    """Return each flight with the path of its log and its calibration: one curve for each log where
    asked for, else one for all. Of logs that are `bundled` in a folder, those that have an answer.
    """
    from pitotbench.bench.calibration_request import NamedFile, calibrate_request
    from pitotbench.bench.calibrations import options_of
    from pitotbench.bench.folder_logs import calibrate_folder

    choices = _choices(options)
    options_of((), options.mapping, **choices)  # a wrong flag is refused before a long log is read
    asked = _request(options)
    published = asked.published()  # and a wrong table
    _, stated = _stated_autopilot(options)
    part = stated_part(options)

    def read(paths: list[Path]) -> "list[FlightLog]":
        return read_logs(
            paths, options.mapping, stated, options.temperature_c, part, options.airspeed_sensor
        )

    if bundled:
        answers = calibrate_folder(
            options.logs,
            lambda path: read([path])[0],
            options.separately,
            say,
            "calibrating",
            sources=asked.sources(),
            flags=asked.choices(),
            published=published,
            **choices,
        )
        return [(each.given, flight) for each in answers for flight in each.flights]
    logs = read(options.logs)
    files = [NamedFile(path, path.name) for path in options.logs]
    groups = [(files, logs)]
    if options.separately:
        groups = [([file], [log]) for file, log in zip(files, logs, strict=True)]
    return [
        (own[flight.place].path, flight)
        for own, group in groups
        for flight in calibrate_request(own, group, asked, **choices)
    ]


def _request(options: argparse.Namespace) -> "CalibrationRequest":
    from pitotbench.bench.calibration_request import NamedFile

    book, sensor = options.handbook, options.airspeed_sensor
    return replace(
        stated_reading(options),
        handbook=None if book is None else NamedFile(book, book.name),
        limit="" if options.limit == "auto" else options.limit,
        parameters=options.params or "",
        airspeed_sensor="" if sensor is None else str(sensor),
        temperature_c=options.temperature_c or "",
    )


def _stated_autopilot(options: argparse.Namespace) -> tuple[str, dict[str, float]]:
    """Return the autopilot of `--params`, empty where none is named, and the old values that it
    states.
    """
    from pitotbench.logbook.autopilot import stated_parameters

    return ("", {}) if options.params is None else stated_parameters(options.params)


def _inputs(options: argparse.Namespace) -> list[Path]:
    """Return the files that the command reads: the logs, the mapping if it is a file, the table of
    a handbook.
    """
    others = (options.mapping, options.handbook)
    return [*options.logs, *(Path(each) for each in others if each)]


_SWITCHES = {  # the choice that a flag without a value stands for
    "no_down": ("use_down", False),
    "no_altitude": ("use_altitude", False),
    "on_condition": ("on_condition", True),
    "all_rows": ("robust", False),
}


def _choices(options: argparse.Namespace) -> dict[str, Any]:
    """Return the choices of the flags by name."""
    from pitotbench.units import KNOT

    stated = {
        name: getattr(options, name) for name in _CHOICES if getattr(options, name) is not None
    }
    if options.ground_speed_min_kt is not None:
        stated["ground_speed_min"] = options.ground_speed_min_kt * KNOT
    stated |= dict(choice for flag, choice in _SWITCHES.items() if getattr(options, flag))
    stated |= stated_assumptions(options)
    if options.latency is not None:
        stated |= _latency(options.latency)
    return stated


def _latency(text: str) -> dict[str, object]:
    if text in _NAMED_LATENCIES:
        return {"latency": text}
    try:
        return {"gps_latency": float(text), "latency": "given"}
    except ValueError as error:
        raise BadInputError(
            f"--latency {text!r}: give seconds, or {' or '.join(_NAMED_LATENCIES)}"
        ) from error
