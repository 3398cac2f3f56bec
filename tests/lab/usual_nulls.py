"""Flights without a cause on every usual card: five maneuvers, three data systems, smooth air and
light turbulence.

python -m tests.lab.usual_nulls --flights 4 --first 601 --jobs 2 [--only circle,20/1] Each is judged
by the whole command. A line a card: the flights with an answer, and what was answered.
"""

import argparse
from collections.abc import Sequence
from functools import partial
from itertools import product

from pitotbench.bench.workflow import NamedLog, reconcile_fully
from pitotbench.campaigns.fleet import require_all, run_tasks
from pitotbench.records.case import Case
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.sortie import fly

MANEUVERS = ("four_leg", "race_track", "step_decrease", "rapid_decel", "circle")
SYSTEMS = ("20/1", "50/50", "100/100")
AIR = ("none", "light")


def answered(card: tuple[str, str, str], seed: int) -> str:
    """The answer on one null flight of a card, in one word; empty where there is no gap."""
    maneuver, system, air = card
    case = Case(
        maneuver=maneuver,
        das=data_system(system),
        turbulence=air,
        truth_seed=seed,
        sensor_seed=seed,
    )
    log = record(fly(case), case.das, seed)
    verdict = reconcile_fully(NamedLog(str(seed), log), refly=False).verdict
    names = " + ".join(effect.name for effect in verdict.effects)
    return "" if verdict.kind == "no_gap" else f"{seed} {verdict.kind} {names}".strip()


def judged(
    cards: Sequence[tuple[str, str, str]], seeds: Sequence[int], jobs: int
) -> list[tuple[str, ...]]:
    """The alarms of each card. The flights of a card share its null flights, so they follow each
    other.
    """
    return require_all(run_tasks(partial(_of_card, seeds), cards, jobs))


def _of_card(seeds: Sequence[int], card: tuple[str, str, str]) -> tuple[str, ...]:
    return tuple(filter(None, (answered(card, seed) for seed in seeds)))


def main() -> None:
    """Print a line a card and the sum."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--flights", type=int, default=4)
    parser.add_argument(
        "--first", type=int, default=601, help="seed of the first flight of every card"
    )
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument(
        "--only", default="", help="cards that hold all of these words, with commas between them"
    )
    options = parser.parse_args()
    wanted = set(filter(None, options.only.split(",")))
    cards = [card for card in product(MANEUVERS, SYSTEMS, AIR) if wanted <= set(card)]
    seeds = range(options.first, options.first + options.flights)
    alarms = judged(cards, seeds, options.jobs)
    for card, found in zip(cards, alarms, strict=True):
        print(
            f"{card[0]:14s} {card[1]:8s} {card[2]:6s} {len(found)} of {len(seeds)}  "
            f"{'; '.join(found)}",
            flush=True,
        )
    print(f"{sum(map(len, alarms))} of {len(cards) * len(seeds)} null flights have an answer")


if __name__ == "__main__":
    main()
