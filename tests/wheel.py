"""Build wheel and sdist, install the wheel in a fresh environment outside the checkout, and use it
there as a user does. Prints the times.

    python -m tests.wheel               # build, install, fly, calibrate, plan, reconcile, open
    python -m tests.wheel --python python3.13
    python -m tests.wheel --clone       # instead: a fresh clone of this checkout, and `make demo`
    in it

It needs the network or pip's cache. With --all also the plan that flies and `reconcile` with null
flights: minutes.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path
from shutil import unpack_archive
from tempfile import TemporaryDirectory
from time import perf_counter
from urllib.request import HTTPCookieProcessor, build_opener
from zipfile import ZipFile

ROOT = Path(__file__).resolve().parents[1]
CASE = 'maneuver = "decel_circle"\nturbulence = "light"\n'
LATE = '[[effects]]\nname = "gps_latency"\nparameters = { latency_s = 0.6 }\n'
COMMANDS = (
    "--version",
    "aircraft check aerosonde --maneuver rapid_decel",
    "fly case.toml -o flight.csv",
    "inspect flight.csv",
    "calibrate flight.csv --report flight.html",
    "plan --by-hand",
    "fly late.toml -o late.csv",
    "reconcile late.csv --aircraft none --out gap",
)
LONG = ("plan --out plan", "reconcile flight.csv --aircraft navajo --out null-flights")
WRITTEN = ("flight.csv", "flight.html", "gap/report.html", "gap/verdict.json")
LIMIT = 1800.0  # s, for one step


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--clone", action="store_true", help="from a clone to the first report, by README"
    )
    parser.add_argument("--python", default=sys.executable, help="the Python that it is tried with")
    parser.add_argument("--all", action="store_true", help="also what takes minutes")
    options = parser.parse_args()
    with TemporaryDirectory(prefix="pitotbench-wheel-") as place:
        (_clone if options.clone else _wheel)(Path(place), options)


def _clone(place: Path, options: argparse.Namespace) -> None:
    begun = perf_counter()
    _step(["git", "clone", "--quiet", str(ROOT), "copy"], place)
    _step(["make", "demo", f"PYTHON={options.python}"], place / "copy")
    pages = list((place / "copy" / "out").rglob("report.html"))
    if not pages:
        raise SystemExit("no report was written")
    print(f"from the clone to the first report: {perf_counter() - begun:.0f} s")


def _wheel(place: Path, options: argparse.Namespace) -> None:
    wheel = _built(place / "dist")
    programs = place / "fresh" / ("Scripts" if os.name == "nt" else "bin")
    python = str(programs / "python")
    _step([options.python, "-m", "venv", "fresh"], place)
    # As a user does: the newest of all that the wheel asks for, and nothing that a test brings along.
    pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    _step([*pip, str(wheel)], place)
    work = place / "work"
    work.mkdir()
    (work / "case.toml").write_text(CASE, encoding="utf-8")
    (work / "late.toml").write_text(CASE + LATE, encoding="utf-8")
    where = [python, "-c", "import pitotbench; print(pitotbench.__file__)"]
    if str(place) not in _step(where, work):
        raise SystemExit("not the package of the fresh environment was imported")
    for command in (*COMMANDS, *(LONG if options.all else ())):
        _step([str(programs / "pitotbench"), *command.split()], work)
    missing = [name for name in WRITTEN if not (work / name).is_file()]
    if missing:
        raise SystemExit(f"not written: {', '.join(missing)}")
    _step([*pip, f"{wheel}[open]"], place)
    _open_page([python, "-m", "pitotbench", "open", "--no-browser", "--port", "0"], work)
    print("the wheel works outside the checkout")


def _built(dist: Path) -> Path:
    """Build wheel and sdist and return the wheel. The sdist makes the same wheel."""
    dist.mkdir()
    build = [sys.executable, "-m", "hatchling", "build", "-d"]
    _step([*build, str(dist)], ROOT)
    (wheel,), (sdist,) = dist.glob("*.whl"), dist.glob("*.tar.gz")
    members = ZipFile(wheel).namelist()
    foreign = [name for name in members if not name.startswith("pitotbench")]
    if foreign:
        raise SystemExit(f"not of the product: {', '.join(foreign)}")
    unpack_archive(sdist, dist)
    _step([*build, "again", "-t", "wheel"], dist / sdist.name.removesuffix(".tar.gz"))
    (again,) = dist.glob("*/again/*.whl")
    if different := set(members).symmetric_difference(ZipFile(again).namelist()):
        raise SystemExit(f"of one of checkout and sdist alone: {', '.join(sorted(different))}")
    return wheel


def _open_page(command: list[str], folder: Path) -> None:
    """Ask `pitotbench open` for its page."""
    begun = perf_counter()
    with subprocess.Popen(
        command, cwd=folder, env=_plain(), stdout=subprocess.PIPE, text=True, encoding="utf-8"
    ) as server:
        try:
            assert server.stdout is not None
            address = server.stdout.readline().split()[-1]
            page = build_opener(HTTPCookieProcessor()).open(address, timeout=LIMIT).read()
        finally:
            server.terminate()
    if b"<title>pitotbench" not in page:
        raise SystemExit(f"open shows another page: {page[:200]!r}")
    print(f"{perf_counter() - begun:7.1f} s: the page of open")


def _plain() -> dict[str, str]:
    """Environment without the checkout on the path."""
    ours = ("PYTHONPATH", "PITOTBENCH_CACHE")
    return {key: value for key, value in os.environ.items() if key not in ours}


def _step(command: list[str], folder: Path) -> str:
    """Run a command in a folder, without the checkout on its path; print its times, return what it
    printed.
    """
    own = Path(command[0]).stem == "pitotbench"
    before, cpu = perf_counter(), os.times()
    done = subprocess.run(
        command,
        cwd=folder,
        env=_plain() | ({"PITOTBENCH_CACHE": str(folder / "cache")} if own else {}),
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=LIMIT,
        check=False,
    )
    after = os.times()
    used = after.children_user + after.children_system - cpu.children_user - cpu.children_system
    shown = " ".join(Path(part).name if os.sep in part else part for part in command)
    print(f"{perf_counter() - before:7.1f} s, processor {used:6.1f} s: {shown[:90]}", flush=True)
    if done.returncode != 0:
        raise SystemExit(
            f"exit code {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
        )
    return done.stdout


if __name__ == "__main__":
    main()
