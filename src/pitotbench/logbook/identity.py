"""What a log says of its airplane, of its kind, and of its day."""

import re
from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench.logbook.columns import KIND, PARAMETERS, START
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog

# What names the airplane: entries of a header, and words in the first lines of a recorder.
_AIRPLANE = (
    "airframe_name",
    "aircraft_ident",
    "aircraft",
    "airplane",
    "glider",
    "registration",
    "tail",
)
_NAMED = re.compile(rf"\b({'|'.join(_AIRPLANE)})\s*[=:]\s*\"?([^\",]+)")


def _names_of(log: FlightLog) -> list[tuple[str, str]]:
    """What names the airplane of a log, with the entries that do."""
    case, lines = log.header.get("case"), log.header.get("comments", ())
    named = [(key, str(log.header[key])) for key in _AIRPLANE if key in log.header]
    named += _NAMED.findall("\n".join(map(str, lines if isinstance(lines, list) else ())))
    if isinstance(case, Mapping):  # an airplane with a patch is the same
        named.append(("case", str(case.get("aircraft", "")).partition("+")[0]))
    return [(key, name.strip()) for key, name in named if name.strip()]


def airplane_of(log: FlightLog) -> str:
    """Return the airplane as the header of a log names it; empty where it does not."""
    return next((name for _, name in _names_of(log)), "")


def day_of(log: FlightLog) -> str:
    """Return the day of a log's first row, such as `2011-08-12`, "" where only a time is known."""
    day = str(log.header.get(START, "")).replace("T", " ").partition(" ")[0]
    return day if "-" in day else ""


_LIGHTEST = 115.0  # kg: 254 lb, the lightest vehicle that 14 CFR 103.1 knows with a person to it


def kind_of(log: FlightLog) -> str:
    """Return the kind of aircraft that a log is of, `drone` or `glider`.

    A recorder tells it, the parameters of an autopilot, or a mass that carries nobody. Empty where
    nothing shows it.
    """
    light = log.mass is not None and float(np.max(log.mass)) < _LIGHTEST
    return str(log.header.get(KIND, "drone" if light or PARAMETERS in log.header else ""))


def require_one_airplane(logs: Sequence[FlightLog]) -> None:
    """Raise BadInputError where the headers of logs that are to be joined name two airplanes."""
    known: dict[str, str] = {}
    for log in logs:
        for key, name in _names_of(log):
            other = known.setdefault(key, name)
            if other.casefold() != name.casefold():
                raise BadInputError(
                    f"the logs are of two airplanes, {other!r} and {name!r} ({key} of their "
                    "headers), which have nothing in common: give each alone, or calibrate with "
                    "--separately"
                )
