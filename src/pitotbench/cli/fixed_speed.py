"""`pitotbench fixed-speed`: the leg and turn methods, for logs, for cards written by hand, for legs
typed.
"""

import argparse
import sys
from pathlib import Path

from pitotbench.cli.shared_flags import (
    flag,
    read_logs,
    require_page,
    require_table,
    shared,
    stated_accuracies,
    stated_numbers,
    tell,
    tell_each,
    write_page,
    write_table,
)
from pitotbench.records import BadInputError

FLAGS = (
    flag(
        "logs",
        nargs="*",
        type=Path,
        metavar="LOG",
        help="log files: legs and turns are found; or a card (CSV), one row a leg, or a tower "
        "fly-by",
    ),
    *shared("mapping", "accuracy", "table", "units", "json"),
    flag("--ground-speed-kt", help="instead of a log: ground speed of each leg, with commas [kt]"),
    flag("--track-deg", help="true track of each leg, with commas [°]"),
    flag(
        "--sheet", type=Path, metavar="FILE", help="write an empty card to print and fill in (HTML)"
    ),
)


def run(options: argparse.Namespace) -> int:
    """Print the answer; return exit code 0. Raises BadInputError unless either logs or legs are
    given.
    """
    from pitotbench.logbook.points_table import is_fly_by_card, is_points_table

    require_table(options, options.logs)
    typed = [options.ground_speed_kt, options.track_deg]
    if options.sheet is not None and not options.logs and typed == [None, None]:
        _write_sheet(options.sheet)
    elif options.sheet is None and options.logs and typed == [None, None]:
        cards = [is_points_table(path) for path in options.logs]
        if any(cards) and not all(cards):
            raise BadInputError("give either logs or points tables")
        if options.table is not None and not (
            any(cards) and not any(map(is_fly_by_card, options.logs))
        ):
            raise BadInputError(
                "--table: points are no curve; use calibrate LOG --table, or give a card of legs"
            )
        fly_bys = [is_fly_by_card(path) for path in options.logs]
        if any(fly_bys) and not all(fly_bys):
            raise BadInputError("give either points tables or fly-by cards")
        (_of_fly_bys if any(fly_bys) else _of_cards if any(cards) else _of_logs)(options)
    elif not options.logs and None not in typed:
        _of_legs(options)
    else:
        raise BadInputError(
            "give either logs, or a points table, or both --ground-speed-kt and --track-deg, or "
            "--sheet"
        )
    return 0


def _write_sheet(path: Path) -> None:
    from pitotbench.show.columns import printable
    from pitotbench.show.legs import card_sheet

    require_page(path)
    write_page(path, card_sheet)
    sys.stdout.write(printable(f"written: {path}") + "\n")


def _of_cards(options: argparse.Namespace) -> None:
    from pitotbench.calibration.hand_card import reduce_card
    from pitotbench.calibration.options import accuracies_of
    from pitotbench.logbook.points_table import read_points
    from pitotbench.show.calibration import doubts_of_curve
    from pitotbench.show.legs import card_json, card_tree

    stated = accuracies_of(stated_accuracies(options).get("accuracies"), {})
    read = [(path, *read_points(path)) for path in options.logs]
    found = [(path, reduce_card(legs, steps, stated)) for path, legs, steps in read]
    several = len(found) > 1
    curves = {
        " ".join(filter(None, (path.stem if several else "", name))): curve
        for path, card in found
        for name, curve in card.curves.items()
    }
    told = [each for _, card in found for each in (*card.warnings, *(s.words for s in card.slips))]
    doubts = {name: [*told, *doubts_of_curve(curve)] for name, curve in curves.items()}
    write_table(options, curves, doubts)
    tell_each(options, found, card_json, card_tree)


def _of_fly_bys(options: argparse.Namespace) -> None:
    from pitotbench.calibration.fly_by import reduce_fly_bys
    from pitotbench.calibration.options import accuracies_of
    from pitotbench.logbook.points_table import read_fly_bys
    from pitotbench.show.legs import fly_bys_json, fly_bys_tree

    stated = accuracies_of(stated_accuracies(options).get("accuracies"), {})
    found = [(path, reduce_fly_bys(*read_fly_bys(path), stated)) for path in options.logs]
    tell_each(options, found, fly_bys_json, fly_bys_tree)


def _of_logs(options: argparse.Namespace) -> None:
    from pitotbench.bench.questions import options_of
    from pitotbench.calibration.leg_points import fixed_speed_points
    from pitotbench.calibration.observations import range_end
    from pitotbench.records import NoAnswerError
    from pitotbench.show.legs import points_json, points_tree

    logs = read_logs(options.logs, options.mapping)
    choice = options_of(logs, options.mapping, **stated_accuracies(options))
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
        lambda a: {"fixed_speed": points_json(a[0]), "warnings": a[1]},
        lambda a: points_tree(*a),
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
    answer = legs_json(found.true_airspeed, found.spread, found.wind_speed, found.wind_from)
    tell(options, lambda: answer, lambda: legs_tree(answer))
