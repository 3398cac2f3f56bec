"""The generator of the blind test: logs under neutral names, and the truth in a sealed file elsewhere.

python -m tests.blind.signatures --jobs 2        (first: the strength of every effect in every setting)
python -m tests.blind.generate --seed 900000 --jobs 2 --logs out/blind/logs --seal out/blind/seal
The truth is drawn and its salted SHA-256 written before the first log. A run that was stopped goes on where it was.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.random import Generator
from tests.blind.drawn import HiddenCase, hidden_case
from tests.blind.settings import SETTINGS
from tests.blind.signatures import PLACE, SettingSignatures, read
from tests.blind.written import seal, write_cases

KINDS = {"above 7": 150, "4 to 7": 75, "2 to 4": 40, "two": 50, "none": 65, "outside": 70, "counted": 20}
DEVELOPMENT, SCORED = (30_000, 40_000), 900_000  # seeds; sets drawn by `development` lie above the first
SEVERAL = {2: 0.12, 3: 0.08}  # share of the cases of so many flights
HELD_OUT = 60  # cases with a flight held out


def draw_set(
    draw: Generator, kinds: Mapping[str, int], letters: Sequence[str], measured: Mapping[str, SettingSignatures]
) -> tuple[list[HiddenCase], list[bool]]:
    """Return the cases of a set in random order, and whether each has a flight held out."""
    wanted = [kind for kind, number in kinds.items() for _ in range(number)]
    wanted = [wanted[i] for i in draw.permutation(len(wanted))]
    firsts = [letters[i % len(letters)] for i in draw.permutation(len(wanted))]
    cases = []
    for kind, first in zip(wanted, firsts, strict=True):
        cases.append(hidden_case(draw, kind, (first, *_further(draw, kind, first, letters)), measured))
    strong = [i for i, case in enumerate(cases) if case.kind == "above 7" and len(case.settings) == 1]
    chosen = set(draw.permutation(strong)[:HELD_OUT].tolist())
    return cases, [i in chosen for i in range(len(cases))]


def _further(draw: Generator, kind: str, first: str, letters: Sequence[str]) -> list[str]:
    """The settings of the further flights: other maneuvers of the same airplane."""
    number = int(draw.choice([1, *SEVERAL], p=[1.0 - sum(SEVERAL.values()), *SEVERAL.values()]))
    if kind == "counted":
        return []
    maneuver = SETTINGS[first].flown.maneuver
    others = [letter for letter in letters if SETTINGS[letter].flown.maneuver != maneuver]
    return [str(letter) for letter in draw.permutation(others)[: number - 1]]


def generate(seed: int, jobs: int, logs: Path, folder: Path, place: Path, share: float = 1.0) -> str:
    """Seal the truth, then write the logs; returns the salted SHA-256.

    A truth that is there already is drawn again from its seed and must be the same; its logs are completed.
    Raises ValueError for a seed of neither range, and for another truth.
    """
    if not (DEVELOPMENT[0] <= seed < DEVELOPMENT[1] or seed >= SCORED):
        raise ValueError(f"seeds of development lie in {DEVELOPMENT}, scored ones begin at {SCORED}")
    letters = [letter for letter in SETTINGS if (place / f"{letter}.npz").is_file()]
    kinds = {kind: max(1, round(share * number)) for kind, number in KINDS.items()}
    measured = {letter: read(letter, place) for letter in letters}
    cases, held = draw_set(np.random.default_rng(seed), kinds, letters, measured)
    if (folder / "truth.json").is_file():
        there = json.loads((folder / "truth.json").read_text("utf-8"))["cases"]
        drawn = [[e.name for e in case.effects] for case in cases]
        if [[e["name"] for e in case["effects"]] for case in there] != drawn:
            raise ValueError(f"{folder}: another truth is sealed there")
        digest = (folder / "truth.sha256").read_text("utf-8").strip()
    else:
        digest = seal(folder, seed, cases, held)
    print(f"sealed, SHA-256 {digest}", flush=True)
    write_cases(logs, seed, cases, held, jobs)
    return digest


if __name__ == "__main__":
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--seed", type=int, default=SCORED)
    made.add_argument("--jobs", type=int, default=2)
    made.add_argument("--logs", type=Path, default=Path("out/blind/logs"))
    made.add_argument("--seal", type=Path, default=Path("out/blind/seal"), dest="folder")
    made.add_argument("--place", type=Path, default=PLACE, help="folder of the signatures")
    made.add_argument("--share", type=float, default=1.0, help="of the cases of the full set")
    generate(**vars(made.parse_args()))
