"""Compare a checkout from before with today's: python -m pitotlab.guards BEFORE [--full] [--only
NAME ...].

Both trees run at the same time on one machine, each with its own interpreter (`.venv` of the
checkout). Prints a line for each guard and below it each difference; ends with 0 if all are equal,
else 1.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from pitotlab.guards.bodies import changed_pairs, compare, read_renames, read_tree
from pitotlab.guards.differences import differences
from pitotlab.guards.names import missing_names
from pitotlab.guards.probe import FULL, QUICK

TODAY = Path(__file__).resolve().parents[3]
STATIC = ("bodies", "strings")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a guard found: what it counted, its differences, and the processor seconds it took in
    either tree.
    """

    guard: str
    counted: str
    lines: Sequence[str]
    seconds: str
    skipped: bool = False


def compare_bodies(before: Path, renames: Path | None) -> Outcome:
    """Compare the code of both trees."""
    begun = time.process_time()
    found = compare(read_tree(before), read_tree(TODAY), read_renames(renames))
    lines = []
    for name, module, was, now in changed_pairs(found):
        if was and now:
            lines += [f"changed  {module}:{name}", *list(differences(was, now))[1:]]
        else:
            lines.append(f"{'gone    ' if was else 'new     '} {module}:{name}")
    lines += [
        f"fewer    {module}:{body.name} (a copy remains)" for body, module in found.fewer.items()
    ]
    counted = (
        f"{found.total:,} bodies before; {len(found.gone)} gone or changed, {len(found.new)} new"
    )
    return Outcome("bodies", counted, lines, f"{time.process_time() - begun:.0f}")


def check_names(before: Path) -> Outcome:
    """Look for names in today's texts that name nothing."""
    begun = time.process_time()
    lines = list(missing_names(TODAY, before))
    return Outcome(
        "strings", f"{len(lines)} name nothing", lines, f"{time.process_time() - begun:.0f}"
    )


def start_probe(
    tree: Path, place: Path, data: Path, names: Sequence[str]
) -> subprocess.Popen[bytes]:
    """Start the probe in a tree with its own interpreter, sources, caches and one thread."""
    python = tree / ".venv" / "bin" / "python"
    place.mkdir(parents=True)
    environment = {
        **os.environ,
        "PYTHONPATH": str(tree / "src"),
        "PITOTBENCH_DATA": str(data),
        "XDG_CACHE_HOME": str(place / "cache"),
        "OPENBLAS_NUM_THREADS": "1",
        "COLUMNS": "100",
        "NO_COLOR": "1",
        "TERM": "dumb",
    }
    probe = Path(__file__).with_name("probe.py")
    command = [
        str(python) if python.is_file() else sys.executable,
        "-P",
        str(probe),
        *map(str, (tree, place, data)),
    ]
    return subprocess.Popen([*command, *names], env=environment)


def compare_probes(place: Path, names: Sequence[str]) -> Iterator[Outcome]:
    """Compare what the probes wrote."""
    for name in names:
        files = [place / side / f"{name}.json" for side in ("before", "today")]
        if not all(file.is_file() for file in files):
            lost = " and ".join(file.parent.name for file in files if not file.is_file())
            yield Outcome(
                name, f"no answer {lost}", ["the probe failed; its error stands above"], ""
            )
            continue
        before, today = (json.loads(file.read_text("utf-8")) for file in files)
        seconds = f"{before['cpu_s']:.0f} + {today['cpu_s']:.0f}"
        skipped = [
            answers["skipped"]
            for each in (before, today)
            if "skipped" in (answers := each["answers"])
        ]
        lines = skipped or list(differences(before["answers"], today["answers"]))
        yield Outcome(
            name, f"{len(before['answers'])} answers", lines, seconds, skipped=bool(skipped)
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the guards and print their table; return 0 if all are equal, else 1."""
    made = argparse.ArgumentParser(prog="python -m pitotlab.guards", description=__doc__)
    made.add_argument(
        "before", type=Path, help="checkout from before, with its environment in .venv"
    )
    made.add_argument("--full", action="store_true", help="also what takes an hour")
    made.add_argument(
        "--only", nargs="+", choices=[*STATIC, *QUICK, *FULL], help="these guards alone"
    )
    made.add_argument(
        "--renames",
        type=Path,
        help='TOML: ["*"], ["old.module"], ["old.module:name"] with old = "new"',
    )
    made.add_argument(
        "--lines", type=int, default=200, help="lines of differences shown for each guard"
    )
    made.add_argument("--keep", type=Path, help="folder in which the answers are kept")
    asked = made.parse_args(arguments)
    before = asked.before.resolve()
    names = asked.only or [*STATIC, *QUICK, *(FULL if asked.full else ())]
    data = Path(os.environ.get("PITOTBENCH_DATA", TODAY.parent / "shared" / "data")).resolve()
    place = (asked.keep or Path(tempfile.mkdtemp(prefix="guards-"))).resolve()
    probed = [name for name in names if name not in STATIC]
    begun = time.monotonic()
    sides = {"before": before, "today": TODAY} if probed else {}
    running = [start_probe(tree, place / side, data, probed) for side, tree in sides.items()]
    try:
        outcomes = [compare_bodies(before, asked.renames)] if "bodies" in names else []
        outcomes += [check_names(before)] if "strings" in names else []
        for each in running:
            each.wait()
        outcomes += compare_probes(place, probed)
    finally:
        for each in running:
            each.kill()
        if asked.keep is None:
            shutil.rmtree(place)
    for outcome in outcomes:
        sys.stdout.write(told(outcome, asked.lines) + "\n")
    sys.stdout.write(f"{time.monotonic() - begun:.0f} s\n")
    return int(any(outcome.lines and not outcome.skipped for outcome in outcomes))


def told(outcome: Outcome, most: int) -> str:
    """Return the line of a guard and the lines of its differences."""
    word = "skipped" if outcome.skipped else "differs" if outcome.lines else "equal"
    head = f"{outcome.guard:9}{word:9}{outcome.counted}  [{outcome.seconds} CPU s]"
    rest = (
        [f"    … and {len(outcome.lines) - most} more lines"] if len(outcome.lines) > most else []
    )
    return "\n".join([head, *(f"    {line}" for line in islice(outcome.lines, most)), *rest])


if __name__ == "__main__":
    sys.exit(main())
