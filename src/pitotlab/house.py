"""Measure the house: its size, the numbers in it, and the statements that a job enters.

A job enters the functions of the product that it calls. Their statements are what somebody reads who
changes the job: neither splitting a file nor pasting two together moves the sum.
`python -m pitotlab house` prints the figures; `tests/lab/test_house_reach.py` holds the limits.
"""

import ast
import json
import os
import subprocess
import sys
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parents[2]
PRODUCT = ROOT / "src" / "pitotbench"
LABORATORY = ROOT / "src" / "pitotlab"
WIDTH = 100  # characters
# Where a number can change an answer; elsewhere it is a unit, a format or a width.
DECIDING = (
    "calibration",
    "reconciliation",
    "estimation",
    "logbook",
    "bench",
    "models",
    "airdata.py",
    "broken.py",
)
_FAMILIES = ("cli", "simulation.maneuvers")  # pages of entries, which only the table reads

# Runs a program under a profiler and writes file and first line of each function of the product that
# is called while no module is being imported.
_PROFILE = """
import cProfile, json, os, runpy, sys, threading
from importlib.machinery import SourceFileLoader
product, out, target = sys.argv[1:4]
sys.argv = sys.argv[3:]
profile, importing, execute = cProfile.Profile(builtins=False), [], SourceFileLoader.exec_module
def unwatched(loader, module):
    profile.disable()
    importing.append(module)
    try:
        execute(loader, module)
    finally:
        importing.pop()
        if not importing:
            profile.enable()
SourceFileLoader.exec_module = unwatched
threading.setprofile(lambda *event: profile.enable())
profile.enable()
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
    profile.disable()
    codes = [each.code for each in profile.getstats() if not isinstance(each.code, str)]
    called = {
        (code.co_filename, code.co_firstlineno)
        for code in codes
        if code.co_filename.startswith(product)
        and code.co_filename.endswith(".py")
        and code.co_name != "<module>"
    }
    with open(out, "w", encoding="utf-8") as file:
        json.dump(sorted(called), file)
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
    return sum(_counts(node) for file in files_of(*places) for node in ast.walk(_tree(file)))


def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))


def _counts(node: ast.AST) -> bool:
    """Whether a node is a statement, and neither an import nor a docstring."""
    if not isinstance(node, ast.stmt) or isinstance(node, ast.Import | ast.ImportFrom):
        return False
    value = node.value if isinstance(node, ast.Expr) else None
    return not (isinstance(value, ast.Constant) and isinstance(value.value, str))


def numbers_in(*places: Path) -> Counter[str]:
    """Return how many numbers the syntax trees at or below some places hold, by where they stand.

    `constants` of a module, `fields` of a class, or in `functions`, defaults of arguments included.
    Every literal counts but 0, 1 and 2.
    """
    found: Counter[str] = Counter()
    for file in files_of(*places):
        _count_numbers(_tree(file), "constants", found)
    return found


def _count_numbers(node: ast.AST, owner: str, found: Counter[str]) -> None:
    if isinstance(node, ast.FunctionDef | ast.Lambda):
        owner = "functions"
    elif isinstance(node, ast.ClassDef):
        owner = "fields"
    elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
        found[owner] += node.value not in (0, 1, 2)
    for child in ast.iter_child_nodes(node):
        _count_numbers(child, owner, found)


def fields_in(*places: Path) -> int:
    """Return the fields that the classes at or below some places declare."""
    classes = (n for f in files_of(*places) for n in ast.walk(_tree(f)) if type(n) is ast.ClassDef)
    return sum(isinstance(line, ast.AnnAssign) for each in classes for line in each.body)


def long_lines(*places: Path) -> list[str]:
    """Return the places of the lines above 100 characters at or below some places, `file:line`."""
    return [
        f"{file}:{number}"
        for file in files_of(*places)
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1)
        if len(line) > WIDTH
    ]


@dataclass(frozen=True, slots=True)
class Reach:
    """The functions of the product that a program entered: their files, their number and their
    statements, each with its head and without docstring, imports and the functions inside it; and
    what the program printed.
    """

    files: tuple[str, ...]
    functions: int
    statements: int
    said: str


def reach(arguments: Sequence[str], folder: Path, product: Path = PRODUCT) -> Reach:
    """Run a program below a profiler in a folder; return what it enters of the product.

    `arguments`: a script of this checkout or a module, then its own arguments. Raises
    CalledProcessError where the program cannot be started or fails.
    """
    out = folder / "entered.json"
    environment = os.environ | {"PYTHONPATH": str(product.parent)}
    program = [sys.executable, "-c", _PROFILE, str(product), str(out), *arguments]
    said = subprocess.run(
        program, cwd=folder, env=environment, check=True, stdout=subprocess.PIPE, encoding="utf-8"
    ).stdout
    entered = {(Path(file), line) for file, line in json.loads(out.read_text(encoding="utf-8"))}
    files = sorted({file for file, _ in entered})
    sizes = [
        size
        for file in files
        for line, size in _sizes_of_functions(_tree(file))
        if (file, line) in entered
    ]
    names = tuple(file.relative_to(product).as_posix() for file in files)
    return Reach(names, len(sizes), sum(sizes), said)


def _sizes_of_functions(tree: ast.Module) -> Iterator[tuple[int, int]]:
    """Yield the first line of each function, which is that of its first decorator, and its
    statements.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            first = min([node.lineno, *(each.lineno for each in node.decorator_list)])
            yield first, 1 + sum(map(_own_statements, node.body))


def _own_statements(node: ast.AST) -> int:
    """Return the statements at and below a node. Those inside a function are its own."""
    inside = [] if isinstance(node, ast.FunctionDef) else ast.iter_child_nodes(node)
    return _counts(node) + sum(map(_own_statements, inside))


def reach_of_jobs(folder: Path) -> dict[str, Reach]:
    """Return what each job enters, of a circle at 20/1 in light turbulence flown in a folder.

    `reconcile` has the README's case without its effect, whose null flights come with the package.
    It finds no gap in such a log, so it does not fly the card again.
    """
    (folder / "case.toml").write_text(_CASE.format("circle"), encoding="utf-8")
    (folder / "step.toml").write_text(_CASE.format("step_decrease"), encoding="utf-8")
    fly = [sys.executable, "-m", "pitotbench", "fly", "step.toml", "-o", "step.csv"]
    subprocess.run(fly, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return {
        "fly": reach(["pitotbench", "fly", "case.toml", "-o", "flight.csv"], folder),
        "calibrate": reach(["pitotbench", "calibrate", "flight.csv"], folder),
        "reconcile": reach(["pitotbench", "reconcile", "step.csv", "--aircraft", "navajo"], folder),
        "run_campaign.py": reach([str(ROOT / "scripts" / "run_campaign.py"), *_CAMPAIGN], folder),
    }


_CASE = """
maneuver = "{}"
turbulence = "light"

[das]
air_rate_hz = 20
gps_rate_hz = 1
"""
_CAMPAIGN = ("--maneuver", "circle", "--das", "20/1", "--jobs", "1", "--out", "out")


def packages() -> list[Path]:
    """Return the packages of the product, sorted."""
    return sorted(file.parent for file in PRODUCT.glob("*/__init__.py"))


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


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print the figures of the house: sizes, numbers, documents, statements entered by each job."""
    parser.parse_args(words)
    print(f"product: {statements_in(PRODUCT)} statements")
    for package in packages():
        print(f"  {package.name}: {statements_in(package)}")
    deciding = numbers_in(*(PRODUCT / name for name in DECIDING))
    print(f"numbers: {_told(numbers_in(PRODUCT))}")
    print(f"  that decide an answer ({', '.join(DECIDING)}): {_told(deciding)}")
    print(f"fields of records: {fields_in(PRODUCT)}")
    tests, lab_tests = lines_of(ROOT / "tests"), lines_of(ROOT / "tests" / "lab")
    print(f"laboratory: {lines_of(LABORATORY)} lines; its tests: {lab_tests} lines")
    print(f"tests of the product: {tests - lab_tests} lines")
    print(f"lines above {WIDTH} characters: {len(long_lines(PRODUCT))}")
    alone = with_one_reader()
    print(f"modules with one reader in the same folder: {len(alone)}: {', '.join(alone)}")
    pages, counted, size, readme = documents()
    print(f"docs: {pages} pages, {counted} words, {size / 1e6:.2f} MB; README {readme} bytes")
    with TemporaryDirectory() as folder:
        for job, found in reach_of_jobs(Path(folder)).items():
            print(
                f"{job} enters {found.statements} statements of {found.functions} functions in "
                f"{len(found.files)} files"
            )


def _told(numbers: Counter[str]) -> str:
    places = ", ".join(f"{numbers[place]} {place}" for place in ("constants", "fields"))
    return f"{numbers.total()}: {places}, {numbers['functions']} in functions"
