"""Measure the house: its size, the files that a job enters, and the files behind a job.

`python -m pitotlab house` prints the table. The tests of the house hold the figures to their
budgets.
"""

import ast
import json
import os
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = ROOT / "src" / "pitotbench"
LABORATORY = ROOT / "src" / "pitotlab"
WIDTH = 100  # characters
# Modules below which each job lies. What they import, lazily or not, has to be read by who changes
# the job.
BEHIND = {
    "one flight": ("pitotbench.simulation.sortie", "pitotbench.sensing.recorder"),
    "calibrate": ("pitotbench.calibration",),
    "the judge": ("pitotbench.reconciliation.verdict",),
    "campaign": ("pitotbench.campaigns.campaign",),
}
_FAMILIES = ("cli", "simulation.maneuvers")  # pages of entries, which only the table reads

# Runs a program under a profiler and writes the files of the product with a function called while
# no module is being imported. A module is being imported while a frame named <module> is on the
# stack.
_PROFILE = """
import json, os, runpy, sys, threading
product, out, target = sys.argv[1:4]
sys.argv = sys.argv[3:]
files, depth = set(), {}
def watch(frame, event, _):
    code, me = frame.f_code, threading.get_ident()
    if code.co_name == "<module>" and event in ("call", "return"):
        depth[me] = depth.get(me, 0) + (1 if event == "call" else -1)
    elif event == "call" and depth.get(me, 0) <= START.get(me, 0):
        if code.co_filename.startswith(product) and code.co_filename.endswith(".py"):
            files.add(code.co_filename)
START = {threading.get_ident(): 1}  # the program itself is a module as well
threading.setprofile(watch)
sys.setprofile(watch)
try:
    if target.endswith(".py"):
        sys.path.insert(0, os.path.dirname(target))
        runpy.run_path(target, run_name="__main__")
    else:
        runpy.run_module(target, run_name="__main__")
except SystemExit as end:
    if end.code:
        sys.exit(f"the program ended with {end.code}")
finally:
    sys.setprofile(None)
    with open(out, "w", encoding="utf-8") as file:
        json.dump(sorted(files), file)
"""


def files_of(*places: Path) -> list[Path]:
    """Return all Python files at or below some places, sorted."""
    return [
        f for place in places for f in ([place] if place.is_file() else sorted(place.rglob("*.py")))
    ]


def lines_of(*places: Path) -> int:
    """Return the lines of all Python files at or below some places."""
    return sum(len(f.read_text(encoding="utf-8").splitlines()) for f in files_of(*places))


def statements_in(*places: Path) -> int:
    """Return the statements of the syntax trees at or below some places.

    Docstrings and imports do not count: neither wider lines nor files pasted together change the sum.
    """
    return sum(isinstance(n, ast.stmt) and not _is_free(n) for n in _nodes(*places))


def _nodes(*places: Path) -> Iterator[ast.AST]:
    for file in files_of(*places):
        yield from ast.walk(ast.parse(file.read_text(encoding="utf-8")))


def _is_free(statement: ast.stmt) -> bool:
    if isinstance(statement, ast.Import | ast.ImportFrom):
        return True
    value = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


def numbers_in(*places: Path) -> int:
    """Return how many numbers the syntax trees at or below some places hold.

    Every literal counts but 0, 1 and 2, those of fields and defaults included.
    """
    values = [node.value for node in _nodes(*places) if isinstance(node, ast.Constant)]
    numbers = [v for v in values if isinstance(v, (int, float)) and not isinstance(v, bool)]
    return sum(number not in (0, 1, 2) for number in numbers)


def long_lines(*places: Path) -> int:
    """Return the lines above 100 characters at or below some places."""
    texts = [f.read_text(encoding="utf-8").splitlines() for f in files_of(*places)]
    return sum(len(line) > WIDTH for lines in texts for line in lines)


def judge_files() -> list[Path]:
    """Return the files of `reconcile`: the reconciliation, its part of the bench, the own terms."""
    judge = files_of(PRODUCT / "reconciliation")
    return [*judge, *(PRODUCT / name for name in _BENCH_OF_THE_JUDGE)]


def calibration_files() -> list[Path]:
    """Return the files of a calibration: the package and the estimation, without legs and cards."""
    every = files_of(PRODUCT / "calibration", PRODUCT / "estimation")
    return [f for f in every if f.name not in _LEGS_AND_CARDS]


_BENCH_OF_THE_JUDGE = (
    "bench/flown_card.py",
    "bench/fly_again.py",
    "bench/null_cache.py",
    "bench/null_flights.py",
    "bench/workflow.py",
    "bench/verdict_folder.py",
    "bench/closing.py",
    "models/aircraft_model.py",
    "models/coefficients.py",
    "models/identification.py",
    "models/maneuver_model.py",
    "models/sidpac.py",
)
_LEGS_AND_CARDS = (
    "card_model.py",
    "card_plan.py",
    "card_slips.py",
    "fly_by.py",
    "hand_card.py",
    "leg_methods.py",
    "leg_points.py",
)


def entered(arguments: Sequence[str], folder: Path) -> list[str]:
    """Run a program below a profiler in a folder; return the product's files that it enters.

    `arguments`: a script of this checkout or a module, then its own arguments. Raises
    CalledProcessError where the program cannot be started or fails.
    """
    out = folder / "entered.json"
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    program = [sys.executable, "-c", _PROFILE, str(PRODUCT), str(out), *arguments]
    subprocess.run(program, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    files = map(Path, json.loads(out.read_text(encoding="utf-8")))
    return [file.relative_to(PRODUCT).as_posix() for file in files]


def reach_of_jobs(folder: Path, reconcile: bool = True) -> dict[str, list[str]]:
    """Return the files that each job enters, of a circle at 20/1 flown in a folder."""
    (folder / "case.toml").write_text('maneuver = "circle"\n', encoding="utf-8")
    jobs = {
        "fly": ["pitotbench", "fly", "case.toml", "-o", "flight.csv"],
        "calibrate": ["pitotbench", "calibrate", "flight.csv"],
        "run_campaign.py": [str(ROOT / "scripts" / "run_campaign.py"), *_CAMPAIGN],
    }
    if reconcile:
        jobs["reconcile"] = ["pitotbench", "reconcile", "flight.csv", "--aircraft", "navajo"]
    return {name: entered(arguments, folder) for name, arguments in jobs.items()}


_CAMPAIGN = ("--maneuver", "circle", "--das", "20/1", "--jobs", "1", "--out", "out")


def behind(modules: Iterable[str]) -> int:
    """Return how many modules of the product some modules import, directly or not, with these."""
    import grimp

    graph = grimp.build_graph("pitotbench")
    return len({m for module in modules for m in (module, *graph.find_upstream_modules(module))})


def with_one_reader() -> list[str]:
    """Return modules that only one module of the same folder imports. `__init__` is no reader."""
    import grimp

    graph = grimp.build_graph("pitotbench")
    packages = {m for m in graph.modules if graph.find_children(m)}
    found = []
    for module in sorted(graph.modules - packages):
        folder = module.rpartition(".")[0]
        if any(folder == f"pitotbench.{family}" for family in _FAMILIES):
            continue
        readers = graph.find_modules_that_directly_import(module) - packages
        if len(readers) == 1 and next(iter(readers)).rpartition(".")[0] == folder:
            found.append(module)
    return found


def documents() -> tuple[int, int, int, int]:
    """Return pages, words and bytes of the documentation, and the bytes of the README."""
    command = ["git", "ls-files", "docs", "README.md"]
    listed = subprocess.check_output(command, cwd=ROOT, text=True)
    files = [ROOT / name for name in listed.split()]
    pages = [f for f in files if f.suffix == ".md"]
    words = sum(len(f.read_text(encoding="utf-8").split()) for f in pages)
    size, readme = sum(f.stat().st_size for f in files), (ROOT / "README.md").stat().st_size
    return len(pages), words, size, readme


PARTS: dict[str, Callable[[], list[Path]]] = {
    "product": lambda: [PRODUCT],
    "calibration without legs and cards": calibration_files,
    "reconciliation with its bench": judge_files,
    "logbook": lambda: [PRODUCT / "logbook"],
    "show": lambda: [PRODUCT / "show"],
    "cli": lambda: [PRODUCT / "cli"],
}  # whose sizes are printed


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print the figures of the house: sizes, files entered by each job, files behind it, documents."""
    parser.parse_args(words)
    print("statements and numbers:")
    for name, places in PARTS.items():
        print(f"  {name}: {statements_in(*places())}, {numbers_in(*places())}")
    tests, lab_tests = lines_of(ROOT / "tests"), lines_of(ROOT / "tests" / "lab")
    print(f"laboratory: {lines_of(LABORATORY)} lines; its tests: {lab_tests} lines")
    print(f"tests of the product: {tests - lab_tests} lines")
    print(f"lines above {WIDTH} characters: {long_lines(PRODUCT)}")
    alone = with_one_reader()
    print(f"modules with one reader in the same folder: {len(alone)}: {', '.join(alone)}")
    pages, counted, size, readme = documents()
    print(f"docs: {pages} pages, {counted} words, {size / 1e6:.2f} MB; README {readme} bytes")
    for job, modules in BEHIND.items():
        print(f"files behind {job}: {behind(modules)}")
    with TemporaryDirectory() as folder:
        for job, files in reach_of_jobs(Path(folder)).items():
            print(f"files entered by {job}: {len(files)}")
