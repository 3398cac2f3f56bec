"""A calibration as the page of `open` and the command ask for it: files, how they are read, and
what the record says of both.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
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
from pitotbench.records.log import Choice, FlightLog


@dataclass(frozen=True, slots=True)
class NamedFile:
    """A file, and the name by which the user knows it."""

    path: Path
    name: str


@dataclass(frozen=True, slots=True)
class CalibrationRequest:
    """What is asked in addition to the logs, in the texts of the flags of `calibrate`; empty where
    not stated.

    The path of `mapping` is a file or a shipped name.
    """

    mapping: NamedFile | None = None
    handbook: NamedFile | None = None
    begin: str = ""
    end: str = ""
    without: tuple[str, ...] = ()
    limit: str = ""
    parameters: str = ""
    airspeed_sensor: str = ""
    temperature_c: str = ""

    def reading_choices(self) -> list[Choice]:
        """Return how a log is read as choices, in the order of the record."""
        texts = {
            "mapping": (self.mapping.name if self.mapping else "", "as recognized"),
            "from": (self.begin, "the first row"),
            "to": (self.end, "the last row"),
            "without": (", ".join(self.without), "none"),
        }
        return _as_choices(texts)

    def choices(self) -> list[Choice]:
        """Return all texts as choices, in the order of the record."""
        texts = {
            "limit": (self.limit, "auto"),
            "params": (self.parameters, "none"),
            "handbook": (Path(self.handbook.name).name if self.handbook else "", "none"),
            "airspeed_sensor": (self.airspeed_sensor, "the first"),
            "temperature_c": (self.temperature_c, "as logged, else a standard day"),
        }
        return [*self.reading_choices(), *_as_choices(texts)]

    def sources(self) -> list[Source]:
        """Return the mapping as a source for the record; nothing for a shipped one or for none."""
        path = self.mapping.path if self.mapping else None
        return [("mapping", path, None)] if path is not None and path.is_file() else []

    def published(self) -> tuple[PublishedCurve, ...]:
        """Return the curves of the handbook. Raises BadInputError for another table."""
        if self.handbook is None:
            return ()
        name = Path(self.handbook.name).name
        return tuple(replace(each, source=name) for each in published_of(self.handbook.path))


def _as_choices(texts: Mapping[str, tuple[str, str]]) -> list[Choice]:
    return [flag_choice(name, text or None, usual) for name, (text, usual) in texts.items()]


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
        [*sources_of("log", [each.path for each in files], logs), *asked.sources()],
        asked.choices(),
        asked.published(),
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
