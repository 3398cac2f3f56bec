"""`pitotbench calibrate`: find the error curve and the wind of one log or of several."""

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.cli.shared_flags import (
    asked_flags,
    flag,
    read_logs,
    require_page,
    require_table,
    say,
    shared,
    stated_choices,
    stated_facts,
    stated_part,
    stated_request,
    tell,
    write_page,
    write_table,
)
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import (
    CalibrationChoices,
    CalibrationRequest,
    NamedFile,
)

if TYPE_CHECKING:
    from pitotbench.records.calibration import CalibratedFlight
    from pitotbench.records.log import FlightLog
    from pitotbench.records.over_dates import OverDates


FLAGS = (
    flag(
        "logs",
        nargs="+",
        type=Path,
        metavar="LOG",
        help="log (.csv, .xlsx, .igc, .ulg, .bin, .mat, .parquet …), or a folder or .zip of logs",
    ),
    *asked_flags(CalibrationRequest, CalibrationChoices),
    flag(
        "--separately",
        action="store_true",
        help="a curve for each of several logs, not one for all",
    ),
    flag("-v", "--verbose", action="store_true", help="print every point of the curve and the fit"),
    flag(
        "-o",
        dest="parameter_file",
        type=Path,
        metavar="FILE",
        help="also write the parameters of --params as a file that the ground station loads: "
        ".param of ArduPilot (Mission Planner, MAVProxy), .params of PX4 (QGroundControl)",
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
    from pitotbench.show.over_dates import over_dates_tree
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
    limit, units = limit_named(options.limit or "auto"), reader_units(options.units)
    reduced, course = _reduced(options, bundled)
    found = [
        NamedFlight(
            str(path),
            flight,
            autopilot_settings(flight.calibration, autopilot)
            if autopilot and (flight.calibration.usable or options.parameter_file)
            else None,
        )
        for path, flight in reduced
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
        write_page(options.report, lambda: flights_page(found, limit, units, course))
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
            *([] if course is None else [over_dates_tree(course)]),
            *(flight_tree(each, limit) for each in found),
            *([] if options.verbose else [Sentence(f"More: {more}.")]),
        ],
    )
    return 0


def _take_bundles(options: argparse.Namespace) -> bool:
    """Put the paths of its logs in the place of a folder or of a .zip file that holds several.

    Return whether there is one. A mapping may be of a folder, which is a log then.
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


def _reduced(
    options: argparse.Namespace, bundled: bool
) -> "tuple[list[tuple[Path, CalibratedFlight]], OverDates | None]":
    """Return each flight with its log's path and its calibration, and its course over dates.

    There is one curve for each log where asked for, else one for all. Of logs that are `bundled` in
    a folder, those that have an answer; the course of the correction over their dates is that of a
    folder alone.
    """
    from pitotbench.bench.calibration_request import (
        calibrate_request,
        choices_made,
        mapping_sources,
        published_by,
    )
    from pitotbench.bench.calibrations import options_of
    from pitotbench.bench.folder_logs import calibrate_folder
    from pitotbench.records.outputs import file_name

    choices = stated_choices(options)
    options_of((), options.mapping, **choices)  # a wrong flag is refused before a long log is read
    asked = stated_request(options, CalibrationRequest)
    published = published_by(asked)  # and a wrong table
    _, stated = _stated_autopilot(options)
    part = stated_part(options)

    def read(paths: list[Path]) -> "list[FlightLog]":
        return read_logs(
            paths, options.mapping, stated, part, options.airspeed_sensor, stated_facts(options)
        )

    if bundled:
        answers = calibrate_folder(
            options.logs,
            lambda path: read([path])[0],
            options.separately,
            say,
            "calibrating",
            sources=mapping_sources(asked),
            flags=choices_made(asked),
            published=published,
            **choices,
        )
        flights = [(each.given, flight) for each in answers for flight in each.flights]
        return flights, answers[0].over_dates
    logs = read(options.logs)
    files = [NamedFile(path, file_name(path)) for path in options.logs]
    groups = [(files, logs)]
    if options.separately:
        groups = [([file], [log]) for file, log in zip(files, logs, strict=True)]
    flights = [
        (own[flight.place].path, flight)
        for own, group in groups
        for flight in calibrate_request(own, group, asked, **choices)
    ]
    return flights, None


def _stated_autopilot(options: argparse.Namespace) -> tuple[str, dict[str, float]]:
    """Return the autopilot of `--params`, "" for none, and the old values that it states."""
    from pitotbench.logbook.autopilot import stated_parameters

    return ("", {}) if options.parameters is None else stated_parameters(options.parameters)


def _inputs(options: argparse.Namespace) -> list[Path]:
    """Return the files that the command reads: logs, the file of a mapping, a handbook."""
    others = (options.mapping, options.handbook)
    return [*options.logs, *(Path(each) for each in others if each)]
