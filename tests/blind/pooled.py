"""Several sets of the blind test scored together, each held against its own seal.

python -m tests.blind.pooled docs/blind/fifth docs/blind/sixth docs/blind
A folder holds the truth, its seal, `results.jsonl`, and where they were made `observed.jsonl` and `advised.jsonl`.
"""

import argparse
from pathlib import Path

from tests.blind.case import JudgedCase
from tests.blind.rows import table, tenths
from tests.blind.score import joined, opened


def judged_in(folder: Path) -> list[JudgedCase]:
    """The judged cases of one set. Raises ValueError where the truth is not the one that was sealed."""
    return joined(opened(folder), folder / "results.jsonl", folder / "observed.jsonl", folder / "advised.jsonl")


if __name__ == "__main__":
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("folders", type=Path, nargs="+")
    cases = [case for folder in made.parse_args().folders for case in judged_in(folder)]
    print(f"{len(cases)} cases")
    for row in table(cases):
        print(f"{row.what:76s} {row.hits:5d} of {row.cases:5d}  {row.remark}")
    for low, count, mean, share in tenths([c for c in cases if c.is_single or c.kind == "two"]):
        print(f"{low:.1f} to {low + 0.1:.1f}: {count:4d} causes, mean {mean:.3f}, share right {share:.3f}")
