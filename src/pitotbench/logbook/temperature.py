"""The day's temperature by a weather report or a thermometer, for logs without an air probe."""

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.logbook.columns import PLACE
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.same_flight import moment_of
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.units import Meters, to_si

REPORT = 2.0  # K, 2σ: a weather report of a field nearby, in whole degrees
LAPSE_SPREAD = 2e-3  # K/m, 2σ: lapse of the lower air about the standard one (6.5 K/km)
LOWEST = 0.01  # quantile of the heights that stands for the ground: a glitch lies below it
_STATED = re.compile(
    r"(?P<celsius>[+-]?\d+(\.\d+)?)\s*((±|\+-|\+/-|/)\s*(?P<spread>\d+(\.\d+)?))?\s*"
    r"(@\s*(ground|(?P<height>-?\d+(\.\d+)?)\s*(?P<unit>ft|m)))?"
)
_COLDEST = 180.0  # K, as the table of channels has it
_WARMEST = 335.0  # K, likewise


@dataclass(frozen=True, slots=True)
class DayTemperature:
    """The air's temperature [K] with its 2σ [K] at a pressure altitude [m]; None: at the ground."""

    temperature: float
    two_sigma: float
    height: float | None


def stated_day(text: str) -> DayTemperature:
    """Return the temperature of a text such as `18`, `18±2@ground`, `-5+-2@1500ft` or `18/2` [°C].

    A text without `±` is a weather report, one without `@` is of the ground. Raises BadInputError
    for any other text, and for a temperature that no day has.
    """
    found = _STATED.fullmatch(text.strip().lower().replace("−", "-"))
    if found is None:
        raise BadInputError(
            f"temperature {text!r}: write degrees Celsius with their 2σ and the place, such as "
            "18±2@ground or -5+-2@1500ft"
        )
    temperature = float(to_si(float(found["celsius"]), "degc"))
    if not _COLDEST < temperature < _WARMEST:
        raise BadInputError(f"temperature {text!r}: no day has it; write it in degrees Celsius")
    height = None if (at := found["height"]) is None else float(to_si(float(at), found["unit"]))
    return DayTemperature(temperature, float(found["spread"] or REPORT), height)


def weather_report(log: FlightLog) -> str:
    """Return in words which weather report tells the temperature of a log's middle at its place.

    "" for a log without a date, a time of day or positions.
    """
    begin, place = moment_of(log), log.header.get(PLACE)
    if begin is None or place is None:
        return ""
    middle = datetime.fromtimestamp(begin + 0.5 * float(log.time[0] + log.time[-1]), UTC)
    return f"the METAR of {middle:%Y-%m-%d %H:%M} by the log's clock, nearest to {place}"


def take_day(draft: Draft, text: str, header: dict[str, Any]) -> None:
    """Give a log the temperature of the day, with the standard lapse from where it was measured.

    The ground is the lowest pressure altitude of the log. A temperature that the log holds itself
    is replaced. `header` gets its accuracy: what is stated, and what the lapse leaves over the
    heights of the log. A log without a static pressure stays as it is. Raises BadInputError as
    `stated_day` does.
    """
    day = stated_day(text)
    static = draft.channels.get("static_pressure")
    if static is None:
        return
    height: Meters = np.asarray(air.pressure_altitude(static))
    reference = float(np.nanquantile(height, LOWEST)) if day.height is None else day.height
    warmer = day.temperature - float(air.standard_temperature(reference))
    for name in {"total_temperature", "air_temperature"} & draft.channels.keys():
        draft.leave_out(name, "the temperature of the day is stated")
    draft.warnings.append(
        f"the temperature of the day, {text} (in °C), is lapsed from {reference:.0f} m on"
    )
    lapsed = np.asarray(air.standard_temperature(height) + warmer)
    draft.put("air_temperature", lapsed, "temperature_c", "k")
    climbed = float(np.nanmedian(np.abs(height - reference)))
    bound = float(np.hypot(day.two_sigma, LAPSE_SPREAD * climbed))
    stated = header.get("accuracy")
    header["accuracy"] = {**(stated if isinstance(stated, dict) else {}), "temperature_k": bound}
