"""List the flights of a folder or of a .zip file, such as the card of a display."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from pitotbench import air
from pitotbench.logbook.bundle import logs_in, opened
from pitotbench.logbook.columns import START
from pitotbench.logbook.draft import MissingColumnsError
from pitotbench.logbook.flight_parts import flights_in
from pitotbench.logbook.identity import airplane_of
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog, FlightSummary


def flights_of(path: Path, read: Callable[[Path], FlightLog] = read_log) -> list[FlightSummary]:
    """Return the flights of a file, a folder or a .zip file.

    A file that is none has its refusal. `read` reads a file.

    Raises BadInputError for a .zip file that cannot be unpacked.
    """
    found = []
    with opened(path) as folder:
        for file in logs_in(folder) if folder.is_dir() else [folder]:
            name = str(file.relative_to(folder)) if file != folder else file.name
            try:
                log = read(file)
            except BadInputError as error:
                words = str(error).removeprefix(f"{file}: ")
                strange = isinstance(error, MissingColumnsError)
                found.append(FlightSummary(name, words, strange=strange))
                continue
            for flight in flights_in(log):
                speed = air.calibrated_airspeed(np.maximum(flight.impact_pressure, 0.0))
                low, high = (float(each) for each in np.quantile(speed, (0.05, 0.95)))
                seconds = float(flight.time[-1] - flight.time[0])
                start = str(log.header.get(START, ""))
                found.append(FlightSummary(name, "", start, airplane_of(log), seconds, (low, high)))
    return found
