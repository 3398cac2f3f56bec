"""The card of a log: the case from which its null flights are flown."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import tomli_w

from pitotbench.records.case import Case
from pitotbench.records.case_file import read_case
from pitotbench.records.log import FlightLog
from pitotbench.simulation.modified import (
    Loading,
    loading_of,
    mass_of,
)
from pitotbench.units import FOOT

# kg: cards this near in mass share null flights. It is 0.4 % of the mass, and more than is burnt
# before a card
MASS_STEP = 10.0
# m: cards this near in height share null flights. "Light" turbulence of JSBSim is 23 % stronger 500
# ft lower
HEIGHT_STEP = 250.0 * FOOT


def card_of(header: Mapping[str, Any], aircraft: str) -> Case | None:
    """Return the case of a log's header as a null flight of an aircraft: without effects.

    Parts that are not in the header have their default values. None where the header has no case (a
    foreign log).
    """
    table = header.get("case")
    if not isinstance(table, Mapping):
        return None
    entries = {key: value for key, value in table.items() if key != "das"}
    das = {key: value for key, value in table.get("das", {}).items() if key != "name"}
    return replace(read_case(tomli_w.dumps({**entries, "das": das}) + "\n"), aircraft=aircraft)


def has_weather_report(header: Mapping[str, Any]) -> bool:
    """Return whether the case of a log's header states the temperature of the day."""
    table = header.get("case")
    return isinstance(table, Mapping) and "temperature_offset_k" in table


def as_flown(card: Case, log: FlightLog) -> Case:
    """Return a card at the height and with the mass of a log.

    What a header planned is not always what was flown. The height is the median of the log's GPS
    height, to `HEIGHT_STEP`; fuel and ballast give the first mass of the log, to `MASS_STEP`. What
    the log does not have, or has within half a step, stays as the card says. Raises BadInputError
    where the mass is not that of the card's aircraft.
    """
    if log.altitude is not None:
        steps = round((float(np.nanmedian(log.altitude)) - card.altitude) / HEIGHT_STEP)
        card = replace(card, altitude=card.altitude + steps * HEIGHT_STEP) if steps else card
    if log.mass is None:
        return card
    stated = mass_of(card.aircraft, Loading(card.fuel, card.ballast))
    steps = round((float(log.mass[0]) - stated) / MASS_STEP)
    if not steps:
        return card
    loading = loading_of(card.aircraft, stated + steps * MASS_STEP)
    return replace(card, fuel=loading.fuel, ballast=loading.ballast)
