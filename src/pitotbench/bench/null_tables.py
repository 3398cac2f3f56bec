"""Null tables: null distributions of the stock cards, flown once and shipped with the package.

A table is found by the card, its airplane's files, the setting of the log, and all tables of
numbers that decide it. A change of the code that changes its numbers needs another `FORMAT`: a test
lays a kept flight out anew, and is red where it gives other numbers.
"""

import json
import lzma
from hashlib import sha256
from pathlib import Path

from pitotbench.campaigns.digests import aircraft_digest
from pitotbench.channels import CHANNELS
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.null_distribution import NullDistribution, read_distribution, text_of
from pitotbench.reconciliation.residuals import FAMILIES
from pitotbench.reconciliation.signatures import WHOLE_FLIGHT
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case

FORMAT = 1  # of the numbers in a table: one more where the code gives others
FOLDER = Path(__file__).with_name("null_flights_of_cards")
DIGITS = 7  # of a number in a shipped table: more than the flights determine


def table_of(card: Case, flights: int, setting: AnalysisSetting) -> Path:
    """Return the file of the null table of a card, whether it is shipped or not."""
    effects = [
        (name, effect.part, [(p.name, p.typical, p.low, p.high) for p in effect.parameters])
        for name, effect in WHOLE_FLIGHT.items()
    ]
    sensors = [(name, each.noise, each.resolution) for name, each in CHANNELS.items()]
    decides = (FORMAT, flights, setting, effects, sensors, FAMILIES, THRESHOLDS)
    of_card = write_case(card), aircraft_digest(card.aircraft)
    return FOLDER / f"{sha256(repr((*of_card, *decides)).encode()).hexdigest()[:24]}.json.xz"


def read_table(card: Case, flights: int, setting: AnalysisSetting) -> NullDistribution | None:
    """Return a card's null distribution as shipped, None for none or for one of other numbers.

    The numbers that decide it may have changed since it was made.
    """
    place = table_of(card, flights, setting)
    return read_packed(place.read_bytes()) if place.is_file() else None


def read_packed(table: bytes) -> NullDistribution:
    """Return the null distribution of a table that `packed` wrote."""
    return read_distribution(lzma.decompress(table))


def packed(null: NullDistribution) -> bytes:
    """Return a null distribution as a table holds it, with numbers of `DIGITS` digits."""
    cut = json.loads(text_of(null), parse_float=lambda text: float(f"{float(text):.{DIGITS}g}"))
    return lzma.compress(json.dumps(cut, separators=(",", ":")).encode(), preset=9)
