"""A development set: one effect at typical sizes and small ones, pairs, none, and faults outside the table.

python -m tests.blind.development --out /tmp/blind-development --seed 41000 --jobs 1
"""

import argparse
from pathlib import Path

import numpy as np
from tests.blind.drawn import hidden_case
from tests.blind.settings import DEVELOPMENT
from tests.blind.signatures import PLACE, read
from tests.blind.written import seal, write_cases

KINDS = {"above 7": 45, "4 to 7": 15, "two": 10, "none": 15, "outside": 10}
SEEDS = (40_000, 45_000)

if __name__ == "__main__":
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--out", type=Path, required=True)
    made.add_argument("--seed", type=int, default=41_000)
    made.add_argument("--settings", default=",".join(DEVELOPMENT))
    made.add_argument("--signatures", type=Path, default=PLACE)
    made.add_argument("--like", default="", help="settings whose strengths are taken from another: A=B,D=C")
    made.add_argument("--jobs", type=int, default=1)
    options = made.parse_args()
    if not SEEDS[0] <= options.seed < SEEDS[1]:
        raise SystemExit(f"seeds of development sets lie between {SEEDS[0]} and {SEEDS[1]}")
    letters = options.settings.split(",")
    like = dict(pair.split("=") for pair in options.like.split(",") if pair)
    measured = {letter: read(like.get(letter, letter), options.signatures) for letter in letters}
    draw = np.random.default_rng(options.seed)
    kinds = [kind for kind, number in KINDS.items() for _ in range(number)]
    kinds = [kinds[i] for i in draw.permutation(len(kinds))]
    cases = [hidden_case(draw, kind, (letters[i % len(letters)],), measured) for i, kind in enumerate(kinds)]
    print(seal(options.out, options.seed, cases, [False] * len(cases)))
    write_cases(options.out / "logs", options.seed, cases, [False] * len(cases), options.jobs)
