"""The card of a log: the case from which its null flights are flown."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pitotbench.records.case import Case
from pitotbench.records.case_file import read_case
from pitotbench.records.log import FlightLog
from pitotbench.records.toml_text import write_toml
from pitotbench.simulate.fuel_and_ballast import Loading, loading_of, mass_of

# kg: cards this near in mass share null flights. It is 0.4 % of the mass, and more than is burnt before a card
MASS_STEP = 10.0


def card_of(header: Mapping[str, Any], aircraft: str) -> Case | None:
    """Return the case of a log's header as a null flight of an aircraft: without effects.

    Parts that are not in the header have their default values. None where the header has no case (a foreign log).
    """
    table = header.get("case")
    if not isinstance(table, Mapping):
        return None
    entries = {key: value for key, value in table.items() if key != "das"}
    das = {key: value for key, value in table.get("das", {}).items() if key != "name"}
    return replace(read_case(write_toml({**entries, "das": das}) + "\n"), aircraft=aircraft)


def tells_the_day(header: Mapping[str, Any]) -> bool:
    """Return whether the case of a log's header tells the temperature of the day."""
    table = header.get("case")
    return isinstance(table, Mapping) and "temperature_offset_k" in table


def loaded_as(card: Case, log: FlightLog) -> Case:
    """Return a card with the fuel and ballast that give its aircraft the first mass of a log, to `MASS_STEP`.

    It is the card itself where the log has no mass, or one within half a step of the card's.
    Raises BadInputError where the mass is not that of the card's aircraft.
    """
    if log.mass is None:
        return card
    stated = mass_of(card.aircraft, Loading(card.fuel, card.ballast))
    steps = round((float(log.mass[0]) - stated) / MASS_STEP)
    if not steps:
        return card
    loading = loading_of(card.aircraft, stated + steps * MASS_STEP)
    return replace(card, fuel=loading.fuel, ballast=loading.ballast)
