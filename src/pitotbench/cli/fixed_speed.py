"""`pitotbench fixed-speed`: the leg and turn methods for logs, written cards, and typed legs."""

import argparse
from pathlib import Path

from pitotbench.cli.shared_flags import (
    asked_flags,
    flag,
    read_logs,
    require_page,
    require_table,
    shared,
    stated_choices,
    stated_facts,
    stated_numbers,
    tell,
    tell_each,
    write_page,
    write_table,
)
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import FACTS, CalibrationChoices, Reading

FLAGS = (
    flag(
        "logs",
        nargs="*",
        type=Path,
        metavar="LOG",
        help="log files: legs and turns are found; or a card (CSV), one row a leg, a tower "
        "fly-by or a point with a known speed",
    ),
    *asked_flags(Reading, CalibrationChoices, only=("mapping", *FACTS, "accuracies", "priors")),
    *shared("table", "units", "json"),
    flag("--ground-speed-kt", help="instead of a log: ground speed of each leg, with commas [kt]"),
    flag("--track-deg", help="true track of each leg, with commas [°]"),
    flag(
        "--sheet", type=Path, metavar="FILE", help="write an empty card to print and fill in (HTML)"
    ),
)


def run(options: argparse.Namespace) -> int:
    """Print the answer; return exit code 0.

    Raises BadInputError unless files of one kind, legs, or a sheet are asked for.
    """
    from pitotbench.logbook.points_table import is_fly_by_card, is_known_speeds, is_points_table

    require_table(options, options.logs)
    typed = [options.ground_speed_kt is not None, options.track_deg is not None]
    given = {_LEGS: any(typed), _SHEET: options.sheet is not None}
    asked = {kind for kind in given if given[kind]} | {
        _FLY_BYS
        if is_fly_by_card(path)
        else _KNOWN
        if is_known_speeds(path)
        else _CARDS
        if is_points_table(path)
        else _LOGS
        for path in options.logs
    }
    if len(asked) != 1 or any(typed) != all(typed):
        raise BadInputError(
            "give either logs, or points tables, or fly-by cards, or both --ground-speed-kt and "
            "--track-deg, or --sheet"
        )
    unstated = {each.names[0]: each.settings.get("default") for each in FLAGS}
    for flag_name, (field, kinds, reason) in _ACTS_ON.items():
        if getattr(options, field) not in (unstated[flag_name], False) and not asked <= kinds:
            raise BadInputError(f"{flag_name} does nothing for {asked.pop()}: {reason}")
    {
        _LOGS: _of_logs,
        _CARDS: _of_cards,
        _FLY_BYS: _of_fly_bys,
        _KNOWN: _of_known_speeds,
        _LEGS: _of_legs,
        _SHEET: _write_sheet,
    }[asked.pop()](options)
    return 0


# What can be asked for.
_LOGS, _CARDS, _FLY_BYS = "logs", "points tables", "fly-by cards"
_KNOWN = "points with a known speed"
_LEGS, _SHEET = "typed legs", "a sheet"
_ACTS_ON = {  # flag: its field, what it acts on, and the way out
    "--table": ("table", {_CARDS}, "it writes a curve; use calibrate LOG --table, or give a card"),
    "--set": ("priors", {_LOGS, _CARDS}, "logs and points tables have a prior"),
    "--accuracy": (
        "accuracies",
        {_LOGS, _CARDS, _FLY_BYS},
        "ground speeds and tracks alone have no bound; give a card of legs (CSV)",
    ),
    "--mapping": ("mapping", {_LOGS}, "it names the columns of logs; leave it out"),
    "--json": (
        "json",
        {_LOGS, _CARDS, _FLY_BYS, _KNOWN, _LEGS},
        "it is a page to print; leave it out",
    ),
    "--units": (
        "units",
        {_LOGS, _CARDS, _FLY_BYS, _KNOWN, _LEGS},
        "it holds no numbers; leave it out",
    ),
}


def _write_sheet(options: argparse.Namespace) -> None:
    from pitotbench.show.columns import printable
    from pitotbench.show.legs import card_sheet

    require_page(options.sheet)
    write_page(options.sheet, card_sheet)
    print(printable(f"written: {options.sheet}"))


def _of_cards(options: argparse.Namespace) -> None:
    from pitotbench.calibration.hand_card import reduce_card
    from pitotbench.calibration.options import accuracies_of
    from pitotbench.logbook.points_table import read_points
    from pitotbench.show.calibration import doubts_of_curve
    from pitotbench.show.legs import card_json, card_tree

    stated = stated_choices(options)
    accuracies, priors = accuracies_of(stated.get("accuracies"), {}), stated.get("priors")
    found = [(path, reduce_card(*read_points(path), accuracies, priors)) for path in options.logs]
    named = [
        (" ".join(filter(None, (path.stem if len(found) > 1 else "", name))), curve, card)
        for path, card in found
        for name, curve in card.curves.items()
    ]
    write_table(
        options,
        {name: curve for name, curve, _ in named},
        {name: [*card.warnings, *doubts_of_curve(curve)] for name, curve, card in named},
    )
    tell_each(options, found, card_json, card_tree)


def _of_fly_bys(options: argparse.Namespace) -> None:
    from pitotbench.calibration.fly_by import reduce_fly_bys
    from pitotbench.calibration.options import accuracies_of
    from pitotbench.logbook.points_table import read_fly_bys
    from pitotbench.show.legs import fly_bys_json, fly_bys_tree

    stated = accuracies_of(stated_choices(options).get("accuracies"), {})
    found = [(path, reduce_fly_bys(*read_fly_bys(path), stated)) for path in options.logs]
    tell_each(options, found, fly_bys_json, fly_bys_tree)


def _of_known_speeds(options: argparse.Namespace) -> None:
    from pitotbench.calibration.known_speed import reduce_known_speeds
    from pitotbench.logbook.points_table import read_known_speeds
    from pitotbench.show.legs import known_speeds_json, known_speeds_tree

    found = [(path, reduce_known_speeds(*read_known_speeds(path))) for path in options.logs]
    tell_each(options, found, known_speeds_json, known_speeds_tree)


def _of_logs(options: argparse.Namespace) -> None:
    from pitotbench.bench.calibrations import options_of
    from pitotbench.calibration.leg_points import fixed_speed_points
    from pitotbench.calibration.observations import range_end
    from pitotbench.calibration.options import stated_of
    from pitotbench.records import NoAnswerError
    from pitotbench.show.curve_rows import points_json, points_tree

    logs = read_logs(options.logs, options.mapping, facts=stated_facts(options))
    choice = options_of(logs, options.mapping, **stated_choices(options))
    found = []
    for path, log in zip(options.logs, logs, strict=True):
        end = range_end(log)
        try:
            points = fixed_speed_points(log, choice)
        except NoAnswerError as error:
            raise error if end is None else NoAnswerError(f"{error}; {end.words}") from error
        found.append(
            (
                path,
                (points, [*log.header.get("warnings", ()), *([] if end is None else [end.words])]),
            )
        )

    tell_each(
        options,
        found,
        lambda a: {
            "fixed_speed": points_json(a[0]),
            "priors": stated_of(choice.priors),
            "warnings": a[1],
        },
        lambda a: points_tree(*a, stated_of(choice.priors)),
    )


def _of_legs(options: argparse.Namespace) -> None:
    import numpy as np

    from pitotbench.calibration.leg_methods import fixed_speed
    from pitotbench.show.legs import legs_json, legs_tree
    from pitotbench.units import DEGREE, KNOT

    form = "numbers with commas between them, such as 178,185,188"
    speeds = stated_numbers("--ground-speed-kt", options.ground_speed_kt, form)
    tracks = stated_numbers("--track-deg", options.track_deg, form)
    found = fixed_speed(np.multiply(KNOT, speeds), np.multiply(DEGREE, tracks))
    answer = legs_json(found)
    tell(options, lambda: answer, lambda: legs_tree(answer))
