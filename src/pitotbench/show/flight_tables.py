"""The tables of several flights reconciled together, and of the cards for the next flight."""

from typing import Any

from pitotbench.records.advised_flight import AdvisedFlight, CardForecast
from pitotbench.records.joined_flight import JoinedFlight
from pitotbench.show.columns import Column
from pitotbench.show.quantity_words import listed, size_words, words
from pitotbench.show.verdict_tables import KIND_WORDS
from pitotbench.units import FOOT

LISTED_CARDS = 8  # on a page: more do not help to choose


def _alone(flight: JoinedFlight) -> str:
    causes = [listed([words(c) for c in group], "or") for group in flight.causes if group]
    return KIND_WORDS[flight.alone] + (f": {'; '.join(causes)}" if causes else "")


def _own(flight: JoinedFlight) -> str:
    return "; ".join(
        f"{words(own.effect)}, {size_words(own.size.name, own.size.value, own.size.two_sigma)}"
        for own in flight.own_sizes
    )


def _apart(flight: JoinedFlight) -> float | None:
    apart = [own.apart for own in flight.own_sizes if own.apart is not None]
    return max(apart) if apart else None


def _left_out(flight: JoinedFlight) -> float | None:
    return flight.left_out.share if flight.left_out is not None else None


FLIGHT_COLUMNS: tuple[Column[JoinedFlight], ...] = (
    Column("flight", lambda flight: flight.log, key="log"),
    Column("card", lambda flight: words(flight.maneuver) if flight.maneuver else "not known"),
    Column("", lambda flight: flight.maneuver or None, key="maneuver"),
    Column("recorded", lambda flight: flight.minutes, "min", ".1f", "minutes"),
    Column("alone", _alone),
    Column("", lambda flight: flight.alone, key="verdict_alone"),
    Column("", lambda flight: flight.log_bayes_factor, key="log_bayes_factor_alone"),
    Column("own size (± is 2σ)", _own),
    Column("apart from the others", _apart, "σ", ".1f", "apart"),
    Column("G", lambda flight: flight.closure.share, style=".2f", key="closure"),
    Column("G left out", _left_out, style=".2f", key="closure_left_out"),
    Column("", lambda flight: flight.null_flights, key="null_flights"),
)


def _changes(card: CardForecast) -> str:
    return ", ".join(f"{key} = {value}" for key, value in card.card.items())


CARD_COLUMNS: tuple[Column[CardForecast], ...] = (
    Column("card", lambda card: words(card.maneuver)),
    Column("", lambda card: card.maneuver, key="maneuver"),
    Column("changed numbers", _changes),
    Column("altitude", lambda card: card.altitude / FOOT, "ft", ".0f", "altitude_ft"),
    Column("recorded", lambda card: card.minutes, "min", ".1f", "minutes"),
    Column("probability of a name", lambda card: card.name, style=".2f", key="probability"),
    Column("doubt left", lambda card: card.entropy, "bit", ".2f", "entropy_bit"),
)


def flight_json(flight: JoinedFlight) -> dict[str, Any]:
    """What a flight of several says, as plain data."""
    plain = {column.key: column.value(flight) for column in FLIGHT_COLUMNS if column.key}
    sizes = [
        {
            "effect": own.effect,
            "name": own.size.name,
            "value": own.size.value,
            "two_sigma": own.size.two_sigma,
            "apart": own.apart,
        }
        for own in flight.own_sizes
    ]
    return plain | {"causes_alone": [list(group) for group in flight.causes], "own_sizes": sizes}


def advised_json(advised: AdvisedFlight | None) -> dict[str, Any] | None:
    """The next flight as plain data; None where there is none."""
    if advised is None:
        return None

    def plain(card: CardForecast) -> dict[str, Any]:
        return {c.key: c.value(card) for c in CARD_COLUMNS if c.key} | {"card": dict(card.card)}

    return plain(advised.best) | {
        "parts": advised.parts,
        "causes": [{"causes": list(causes), "probability": p} for causes, p in advised.causes],
        "ranked": [plain(card) for card in advised.ranked],
    }
