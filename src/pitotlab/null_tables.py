"""Fly the null tables that are shipped with the package, and the kept flight that holds them."""

import json
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path

from pitotbench.bench.null_flights import NULL_FLIGHTS, NULL_SEED, null_distribution_of
from pitotbench.bench.null_tables import FOLDER, packed, read_table, table_of
from pitotbench.logbook.columns import atomic
from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.null_learning import FlightScores, scores_of
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.sortie import fly

KEPT = Path(__file__).parents[2] / "tests" / "kept_null_flight"
KEPT_SECONDS = 60.0  # of a flight, so that a test lays it out in some seconds
# That of a log which states its card and the temperature of the day.
SETTING = AnalysisSetting(day_known=True, instruments_known=True)


def stock_cards() -> Iterator[Case]:
    """Yield the cards of which a table is shipped: those of the README and of the examples of
    `docs/reconcile.md`, then every maneuver as it stands for two data systems; all in light
    turbulence.
    """
    for maneuver in ("step_decrease", "race_track", "circle"):
        yield Case(maneuver=maneuver, das=DataSystem(air_rate=20.0, gps_rate=1.0))
    for das, maneuver in product(("50/50", "20/1"), MANEUVERS):
        yield Case(maneuver=maneuver, das=data_system(das))


def is_shipped(card: Case) -> bool:
    """Return whether there is a table of a card that can be used."""
    return table_of(card, NULL_FLIGHTS, SETTING).is_file()


def null_log(card: Case) -> FlightLog:
    """Return the first null flight of a card."""
    flight = fly(replace(card, truth_seed=NULL_SEED, sensor_seed=NULL_SEED))
    return record(flight, card.das, NULL_SEED)


def kept_scores(null: NullDistribution) -> FlightScores:
    """Return the scores of the kept flight by the noise of a null distribution."""
    log = read_log(KEPT.with_suffix(".parquet"))
    return scores_of((lay_out(log, aircraft_model("navajo"), SETTING), null.noise))


def _keep(card: Case) -> None:
    """Keep the begin of a null flight of a card, and its scores by the noise of its table."""
    log = null_log(card)
    begin = log.select(log.time - log.time[0] < KEPT_SECONDS)
    write_log(replace(begin, header={}), KEPT.with_suffix(".parquet"))
    null = read_table(card, NULL_FLIGHTS, SETTING)
    assert null is not None
    KEPT.with_suffix(".json").write_text(json.dumps(asdict(kept_scores(null)), indent=1))


def _write(card: Case) -> None:
    null = null_distribution_of(card, progress=print, setting=SETTING, keep=False)
    FOLDER.mkdir(exist_ok=True)
    with atomic(table_of(card, NULL_FLIGHTS, SETTING)) as scratch:
        scratch.write_bytes(packed(null))


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly the null tables of the stock cards that are missing, and remove those that are stale."""
    parser.add_argument("--most", type=int, default=1_000, help="fly at most so many tables")
    options = parser.parse_args(words)
    cards = [*stock_cards()]
    usable = {table_of(card, NULL_FLIGHTS, SETTING) for card in cards}
    for file in {*FOLDER.glob("*.json.xz")} - usable:
        file.unlink()
    missing = [card for card in cards if not is_shipped(card)]
    for number, card in enumerate(missing[: options.most], start=1):
        print(f"table {number} of {len(missing)}: {card.maneuver}, {card.das.label}", flush=True)
        _write(card)
        if card == cards[0]:
            _keep(card)
