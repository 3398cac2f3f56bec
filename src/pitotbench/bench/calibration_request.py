"""A calibration as the page of `open` and the command ask for it, and its lines in the record."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pitotbench.bench.calibrations import (
    Source,
    calibrate_each,
    flag_choice,
    published_of,
    sources_of,
)
from pitotbench.logbook.columns import PARAMETERS
from pitotbench.records import BadInputError
from pitotbench.records.calibration import CalibratedFlight, PublishedCurve
from pitotbench.records.calibration_request import FILES, CalibrationRequest, NamedFile, Reading
from pitotbench.records.log import Choice, FlightLog


def choices_made(asked: Reading) -> list[Choice]:
    """Return what is asked of a log as choices, by the names of the flags, for the record."""
    return [
        flag_choice(
            each.metadata["flag"].strip("-").replace("-", "_"),
            # Of a file the name alone: its folder is nobody's business.
            ", ".join(Path(text).name if each.name in FILES else text for text in texts) or None,
            each.metadata["usual"],
        )
        for each, texts in asked.texts()
    ]


def mapping_sources(asked: Reading) -> list[Source]:
    """Return the mapping as a source for the record; nothing for a shipped one or for none."""
    path = asked.mapping.path if asked.mapping else None
    return [("mapping", path, None)] if path is not None and path.is_file() else []


def published_by(asked: CalibrationRequest) -> tuple[PublishedCurve, ...]:
    """Return the curves of the handbook. Raises BadInputError for another table."""
    if asked.handbook is None:
        return ()
    name = Path(asked.handbook.name).name
    return tuple(replace(each, source=name) for each in published_of(asked.handbook.path))


def calibrate_request(
    files: Sequence[NamedFile],
    logs: Sequence[FlightLog],
    asked: CalibrationRequest,
    first: Callable[[tuple[CalibratedFlight, ...]], object] | None = None,
    **choices: Any,
) -> tuple[CalibratedFlight, ...]:
    """Find one curve for the flights of some logs, read of `files`.

    The record names the files as the user knows them. `first` and `choices` are as for
    `calibrate_each`. Raises as it does, and BadInputError where parameters are asked for and the
    logs were flown with different ones.
    """
    if asked.parameters and len({str(log.header.get(PARAMETERS)) for log in logs}) > 1:
        raise BadInputError(
            "the logs were flown with different parameters, so their airspeeds have no curve in "
            "common: calibrate each by itself (--separately), or ask for no parameters"
        )
    found = calibrate_each(
        logs,
        None,
        str(asked.mapping.path) if asked.mapping else None,
        [*sources_of("log", [each.path for each in files], logs), *mapping_sources(asked)],
        choices_made(asked),
        published_by(asked),
        first=first,
        names=[each.name for each in files],
        **choices,
    )
    made = found[0].calibration.provenance
    named = tuple(
        replace(each, name=file.name) for each, file in zip(made.inputs, files, strict=False)
    )
    inputs = (*named, *made.inputs[len(files) :])  # the logs are the first of the sources
    provenance = replace(made, inputs=inputs)
    return tuple(
        replace(each, calibration=replace(each.calibration, provenance=provenance))
        for each in found
    )
