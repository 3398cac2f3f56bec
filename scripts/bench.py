"""Print, in one run, how fast the bench is: ratios to what the same work costs without it.

    python scripts/bench.py

CPU seconds of one thread, the least of several tries. The last line is wall time with all processes.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from pitotbench.cli import main as pitotbench
from pitotbench.evidence.speed.ratios import ratio_lines

EVERYTHING = ["campaign", "--maneuver", "all", "--das", "all", "--model", "all", "--out"]


def main() -> None:
    for line in ratio_lines():
        print(line, flush=True)
    with TemporaryDirectory() as folder:
        begun = perf_counter()
        pitotbench([*EVERYTHING, str(Path(folder, "all"))])
        print(f"--maneuver all --das all --model all, one seed     {perf_counter() - begun:10.1f} s (limit 20 s)")


if __name__ == "__main__":
    main()
