"""Say what a file is from which no log can be read, and what its owner can do."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from pitotbench.logbook.columns import Table
from pitotbench.logbook.draft import has_our_names, names_of_ours
from pitotbench.logbook.drafting import DraftedMapping, draft_mapping
from pitotbench.logbook.guess import NEEDED
from pitotbench.logbook.handbook_table import is_published
from pitotbench.logbook.points_table import (
    is_known_speeds,
    is_points_table,
    seems_a_calibration,
    seems_fly_bys,
)
from pitotbench.records import BadInputError

# What a file is that is no log, with the command that reads it: the first that holds is told.
_KINDS: tuple[tuple[Callable[[Path], bool], str], ...] = (
    (
        lambda path: path.stem.endswith(".truth"),
        "the truth of a simulated flight, no log: give the log beside it, {1}",
    ),
    (
        is_published,
        "a handbook's table of airspeeds, no log: `pitotbench calibrate LOG --handbook {0}` "
        "compares a log's curve with it, `pitotbench aircraft indicator {0} --out indicator.xml` "
        "makes it the airspeed indicator of a JSBSim airplane",
    ),
    (
        is_known_speeds,
        "points with a known speed, no log: `pitotbench fixed-speed {0}` gives factor, scale and "
        "zero",
    ),
    (is_points_table, "a card of legs or passes, no log: `pitotbench fixed-speed {0}` reads it"),
    (
        seems_fly_bys,
        "tower fly-bys under other names, no log: name its columns indicated_airspeed_kt, "
        "pressure_altitude_ft (on 1013.25 hPa), grid_height_ft (of the airplane above the tower's "
        "barometer), tower_pressure_inhg and tower_temperature_degc; then `pitotbench fixed-speed` "
        "reads it",
    ),
    (
        seems_a_calibration,
        "a table without a time, as points of a tunnel or a car, no log: name the column of the "
        "true speed known_airspeed_mps, and that of the sensor indicated_airspeed_mps or "
        "impact_pressure_kpa; then `pitotbench fixed-speed` gives factor, scale and zero",
    ),
)

# What a log needs, in the order of `drafting.NEEDED`: what is not there, and what to do.
_HOLES = (
    ("no time", "write the time of each row as time_s"),
    (
        "no airspeed",
        "no column is one, nor an impact pressure; give the log of the box that shows the airspeed",
    ),
    ("no height", "state the one that was flown, such as --height 2000 (ft) or 600m"),
    ("no ground speed", "record the GPS with its speed and track, or with its positions"),
    ("no track", "record the GPS with its track, or with its positions"),
)
_MOST_HOLES = 3  # a table that lacks more is none of a flight
_MOST_NAMES = 8  # of such a table that are told


def kind_of(path: Path, name: Path) -> str:
    """Return what a file, called `name`, is and which command reads it; "" if it may be a log."""
    return next(
        (
            words.format(name, name.name.replace(".truth", ""))
            for holds, words in _KINDS
            if holds(path)
        ),
        "",
    )


def what_it_lacks(
    table: Table, drafted: DraftedMapping | None, name: Path, error: BadInputError
) -> str:
    """Return what a table holds that lacks columns of a log, and the way on.

    The draft of its columns tells it, which is made for None; it is the words of the `error` where
    its names are ours or none is recognized.
    """
    if drafted is None and not has_our_names(table):
        with suppress(BadInputError):
            drafted = draft_mapping(table)
    lacks_most = drafted is not None and len(drafted.missing) > _MOST_HOLES
    if drafted is None or (lacks_most and names_of_ours(table)):
        return str(error)
    if lacks_most:
        names = ", ".join(table.names[:_MOST_NAMES]) + ", …" * (len(table.names) > _MOST_NAMES)
        return (
            f"hardly a column is one of a flight log: the file holds {names}. Give the log that "
            "holds time, airspeed, height and the velocity by GPS; if this is it, name its columns "
            "so, such as time_s, indicated_airspeed_kt, pressure_altitude_ft, ground_speed_kt, "
            "track_deg"
        )
    way = f"`pitotbench map {name} -o mapping.toml` drafts how its columns are read"
    known = (f"{each.guess.theirs} ({each.guess.quantity})" for each in drafted.lines)
    held = f"{holes_of(drafted)}The file holds {', '.join(known).replace('_', ' ')}"
    if drafted.missing:
        return f"{held}. Where a column was not recognized, {way}"
    asked = sum(bool(line.question) for line in drafted.lines)
    refused = f"; with them the log is refused: {drafted.refusal}" if drafted.refusal else ""
    return (
        f"the names of its columns are another recorder's, and {asked} raise a question. {held}"
        f"{refused}. {way}: answer its questions, then --mapping mapping.toml reads by it"
    )


def holes_of(drafted: DraftedMapping) -> str:
    """Return in sentences what a draft has no column for, and the way to each; "" for none."""
    holes = [
        hole
        for names, hole in zip(NEEDED, _HOLES, strict=True)
        if " or ".join(names) in drafted.missing
    ]
    if _HOLES[-2] in holes:  # without a ground speed a track tells nothing
        holes = [hole for hole in holes if hole != _HOLES[-1]]
    return "".join(f"{what} is logged: {way}. " for what, way in holes)
