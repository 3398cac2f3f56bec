"""Null tables of stock cards are what the code gives, and one that no longer is so is not used."""

import json
from collections.abc import Mapping
from dataclasses import asdict, replace

import numpy as np
import pytest

from pitotbench.bench import null_tables
from pitotbench.bench.null_flights import NULL_FLIGHTS, null_distribution_of
from pitotbench.bench.null_tables import FOLDER, packed, read_packed, read_table
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotlab.null_tables import KEPT, SETTING, kept_scores, stock_cards

CARD = next(stock_cards())
MOST = 5e6  # bytes of all tables together


def are_close(one: object, other: object, share: float = 1e-6) -> bool:
    """Whether two trees have the same keys, and numbers within a share of the largest beside them."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        if one.keys() != other.keys():
            return False
        if not all(isinstance(value, float) for value in one.values()):
            return all(are_close(one[key], other[key], share) for key in one)
        one, other = ([each[key] for key in one] for each in (one, other))
    if one is None or isinstance(one, str):
        return one == other
    if isinstance(one, tuple) and isinstance(one[0], str):
        return one == other
    a, b = np.asarray(one, dtype=float), np.asarray(other, dtype=float)
    return a.shape == b.shape and bool(
        np.abs(a - b).max(initial=0.0) <= share * np.abs(b).max(initial=0.0)
    )


@pytest.fixture(scope="module")
def null() -> NullDistribution:
    found = read_table(CARD, NULL_FLIGHTS, SETTING)
    assert found is not None, "the table is stale: python -m pitotlab nulls"
    return found


def test_a_kept_null_flight_scores_as_it_did(null: NullDistribution) -> None:
    """Where this fails, the code gives other numbers: `FORMAT` is to be raised, and the tables are to
    be flown anew.
    """
    kept = json.loads(KEPT.with_suffix(".json").read_text(encoding="utf-8"))
    assert are_close(asdict(kept_scores(null)), kept, 1e-3)  # another processor rounds by 1e-4


def test_a_stock_card_needs_no_flight(null: NullDistribution, monkeypatch) -> None:
    monkeypatch.setattr("pitotbench.bench.null_flights.open_fleet", None)
    assert null_distribution_of(CARD, setting=SETTING).threshold == null.threshold


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("FORMAT", 0),
        ("THRESHOLDS", replace(null_tables.THRESHOLDS, false_alarms=0.02)),
        ("WHOLE_FLIGHT", {}),
        ("aircraft_digest", lambda name: "another"),
    ],
)
def test_a_stale_table_is_not_used(name: str, value: object, monkeypatch) -> None:
    monkeypatch.setattr(null_tables, name, value)
    assert read_table(CARD, NULL_FLIGHTS, SETTING) is None


def test_another_card_or_setting_has_a_table_of_its_own() -> None:
    assert read_table(replace(CARD, fuel=0.4), NULL_FLIGHTS, SETTING) is None
    assert read_table(CARD, 4, SETTING) is None
    assert read_table(CARD, NULL_FLIGHTS, replace(SETTING, static_error=True)) is None


def test_a_table_keeps_what_it_is_given_to_its_digits(null: NullDistribution) -> None:
    odd = replace(
        null, threshold=np.pi, noise=replace(null.noise, deviations=null.noise.deviations / 3.0)
    )
    assert are_close(asdict(read_packed(packed(odd))), asdict(odd))


def test_the_tables_are_small_and_each_is_of_a_stock_card() -> None:
    files = {*FOLDER.glob("*")}
    assert files <= {null_tables.table_of(card, NULL_FLIGHTS, SETTING) for card in stock_cards()}
    assert sum(file.stat().st_size for file in files) < MOST
