"""Spoiled logs and mappings given to the commands: each must end in an answer or in one line that
explains itself.

    python -m tests.lab.spoil --out FOLDER [--first 1] [--count 1000]

spoils a good file of each format by a seed, as it is, in a folder or in a .zip file of several,
runs a command on it in a process of its own, and counts what no input may bring about: exit code 1, a traceback, a hang, too much memory, output that
nobody asked for, JSON that is none. One row an input goes into FOLDER/results.csv, which is read
first, so that a run goes on where it stopped; inputs that fail are kept beside it.
"""

import argparse
import gzip
import json
import os
import re
import resource
import shutil
import signal
import sys
import time
import zipfile
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np
from tests.lab.formats import FORMATS
from tests.logbook import foreign_files as foreign
from tests.logbook.field_recorders import KINDS

from pitotbench.cli.app import main as run_command
from pitotbench.logbook.formats import write_log
from pitotbench.records.log import FlightLog
from pitotlab.sets import append_to, read_rows

Random = np.random.Generator
FAULTS = ("traceback", "exit 1", "hang", "memory", "stray output", "invalid JSON", "crash")
SECONDS, BYTES = 60, 2 << 30  # s of the processor, and of the clock ten times as many
TEXT = (".csv", ".toml", ".txt", ".igc")
BUNDLED = 0.15  # share of the inputs that lie in a folder or in a .zip file
COMMANDS = {  # the words and the share of each: a calibration takes longest
    "inspect": ("inspect {log}", 0.3),
    "map": ("map {log}", 0.3),
    "inspect json": ("inspect {log} --json", 0.1),
    "calibrate": ("calibrate {log}", 0.07),
    "calibrate json": ("calibrate {log} --json --model bias", 0.05),
    "fixed-speed": ("fixed-speed {log}", 0.08),
    "a mapping": ("inspect {log} --mapping {mapping}", 0.1),
}
USUAL = [share for _, share in COMMANDS.values()]
MAPPING = """\
[log]
delimiter = ","
rate_hz = 1.0

[columns]
"t" = "time_s"
"q" = "impact_pressure_pa"
"vn" = { name = "velocity_north_mps", scale = 1.0, offset = 0.0 }

[calibrate]
mach_max = 0.9
model = "bias"
"""
VALUES = (
    '""', '"x"', "-1", "0", "1e400", "nan", "inf", "true", "[]", "{}", "[[1]]", "1979-05-27", '"\\u0000"', '"*"',
    "[" * 60 + "]" * 60, "9" * 400, '{ a = { b = { c = 1 } } '
                                    '}', '"time_s"', '"impact_pressure_pa"', "'''a\nb'''",
)  # fmt: skip
CELLS = (
    "", "nan", "NaN", "inf", "-inf", "1e400", "-1e308", "1e-320", "0", "-0", "x", '"', '""', "'", ",", ";", "1,5",
    "1_000", "0x1F", "١٢", "²", "\x00", "\x1a", "\r", "\ufeff", "é", "\U0001f681", "=1+1", "12:34:56", "24:60:61",
    "2026-02-30", "1e5 m", " 5 ", "5\t", "true", "None", "-", "--", "9" * 400, "A" * 200_000, "%s", "{}", "\\",
)  # fmt: skip
LINES = (
    "# a = [", "# mapping = 5", '# mapping = "jmoss"', "# accuracy = 3", "# accuracy = { temperature_k = -1 }",
    "# " + "a." * 3000 + "b = 1", "# display = { airspeed_mps = -1 "
                                  "}", "# synthetic = 7", "# case = []", "#",
    "# time = 1e999", "# source = nan", "# [[[", "sep=;", "", ",,,,", "#" * 5000, "# aircraft = 1", "# \x00",
    "# warnings = 5",
    "# flights = { a = 1 }", '# accuracy = { nothing = 1 '
                             '}', "# parameters = 3", "# gps_latency_s = 1e30",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Result:
    """What became of one input: a fault of `FAULTS` or nothing, with the first words that it said."""

    seed: int
    file: str
    damage: str
    command: str
    code: int
    seconds: float
    megabytes: int
    fault: str
    says: str


def good_files(folder: Path) -> list[Path]:
    """Write one good file of each format; a file that needs a mapping has it beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    flown = foreign.flight()
    found = []
    for number, form in enumerate(FORMATS.values()):
        path = folder / f"{number:02d}" / f"log{form.suffix}"
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            path = form.write(path, flown)
        found.append(path)
    for number, (write, _) in enumerate(KINDS.values()):
        place = folder / f"field{number:02d}"
        place.mkdir(exist_ok=True)
        written = next(place.iterdir(), None) or write(place)
        found += [written] if written.is_file() else sorted(written.iterdir())[:1]
    for name in ("own.csv", "own.parquet", "own.mat"):
        path = folder / name
        if not path.exists():
            write_log(FlightLog(**flown), path)
        found.append(path)
    return found


def bundled(path: Path, other: Path, rng: Random) -> tuple[Path, str]:
    """Put a file into a folder or a .zip beside a good one; return it, and what it is in words."""
    folder = path.parent / "card"
    (folder / "older").mkdir(parents=True)
    path = path.rename(folder / path.name)
    shutil.copy(other, folder / "older" / other.name)
    if rng.random() < 0.4:
        return folder, "in a folder"
    packed = folder.with_suffix(".zip")
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as file:
        for each in sorted(folder.rglob("*.*")):
            file.write(each, each.relative_to(folder))
    if rng.random() < 0.5:
        packed.write_bytes(BYTES_DAMAGE[int(rng.integers(6))](packed.read_bytes(), rng))
    return (packed if rng.random() < 0.5 else packed / path.name), "in a .zip"


# Damage to bytes of any file.


def cut(data: bytes, rng: Random) -> bytes:
    return data[: int(rng.integers(0, len(data)))]


def flipped(data: bytes, rng: Random) -> bytes:
    spoiled = bytearray(data)
    for _ in range(int(rng.integers(1, 30))):
        spoiled[int(rng.integers(len(spoiled)))] ^= 1 << int(rng.integers(8))
    return bytes(spoiled)


def head_flipped(data: bytes, rng: Random) -> bytes:
    """Formats of tables say what they hold at their head or at their end."""
    size = min(len(data), 600)
    if rng.random() < 0.5:
        return flipped(data[:size], rng) + data[size:]
    return data[:-size] + flipped(data[-size:], rng)


def with_hole(data: bytes, rng: Random) -> bytes:
    first, size = int(rng.integers(len(data))), int(rng.integers(1, 3000))
    return data[:first] + data[first + size :]


def with_noise(data: bytes, rng: Random) -> bytes:
    first = int(rng.integers(len(data)))
    return data[:first] + rng.bytes(int(rng.integers(1, 400))) + data[first:]


def doubled(data: bytes, rng: Random) -> bytes:
    return data + data[int(rng.integers(len(data))) :]


def zeroed(data: bytes, rng: Random) -> bytes:
    first, size = int(rng.integers(len(data))), int(rng.integers(1, 5000))
    return data[:first] + bytes(len(data[first : first + size])) + data[first + size :]


def zipped(data: bytes, rng: Random) -> bytes:
    whole = gzip.compress(data)
    return whole if rng.random() < 0.5 else cut(whole, rng)


BYTES_DAMAGE = (cut, flipped, head_flipped, with_hole, with_noise, doubled, zeroed, zipped)


# Damage to text.


def of_lines(change: Callable[[list[str], Random], list[str]]) -> Callable[[bytes, Random], bytes]:
    """Damage to the lines of a file, whatever its encoding."""

    def run(data: bytes, rng: Random) -> bytes:
        text = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8"
        lines = change(data.decode(text, "replace").split("\n"), rng)
        return "\n".join(lines).encode(text, "replace")

    run.__name__ = getattr(change, "__name__", "lines").lstrip("_")
    return run


def _somewhere(lines: list[str], rng: Random) -> int:
    """A line; the first ten, which say what the file is, as often as all others."""
    return int(rng.integers(min(10, len(lines)) if rng.random() < 0.5 else len(lines)))


def _mark(line: str) -> str:
    return max(",;\t", key=line.count)


def _cells(lines: list[str], rng: Random) -> list[str]:
    for _ in range(int(rng.integers(1, 6))):
        row = _somewhere(lines, rng)
        mark = _mark(lines[row])
        parts = lines[row].split(mark)
        parts[int(rng.integers(len(parts)))] = str(rng.choice(CELLS))
        lines[row] = mark.join(parts)
    return lines


def _column(lines: list[str], rng: Random) -> list[str]:
    """One column in every row: scaled, constant, blank, or of junk."""
    place, kind, junk = int(rng.integers(12)), int(rng.integers(4)), str(rng.choice(CELLS[:30]))
    for row in range(2, len(lines)):
        mark = _mark(lines[row])
        parts = lines[row].split(mark)
        if place >= len(parts):
            continue
        if kind == 0:
            try:
                parts[place] = repr(float(parts[place]) * 10.0 ** int(place - 6))
            except ValueError:
                parts[place] = junk
        else:
            parts[place] = ("1", "", junk)[kind - 1]
        lines[row] = mark.join(parts)
    return lines


def _rows_moved(lines: list[str], rng: Random) -> list[str]:
    kind = int(rng.integers(4))
    if kind == 0:
        return [*lines[:3], *rng.permutation(lines[3:]).tolist()]
    if kind == 1:
        return [*lines[:3], *lines[:2:-1]]
    if kind == 2:
        row = _somewhere(lines, rng)
        return lines[:row] + lines[row : row + 1] * int(rng.integers(1, 400)) + lines[row:]
    return lines[: int(rng.integers(1, 30))]


def _line_added(lines: list[str], rng: Random) -> list[str]:
    row = 0 if rng.random() < 0.5 else _somewhere(lines, rng)
    return [*lines[:row], str(rng.choice(LINES)), *lines[row:]]


def _names(lines: list[str], rng: Random) -> list[str]:
    """Names of columns: exchanged, repeated, in other units, or of junk."""
    row = int(rng.integers(min(3, len(lines))))
    mark = _mark(lines[row])
    names = lines[row].split(mark)
    a, b = (int(rng.integers(len(names))) for _ in range(2))
    kind = int(rng.integers(4))
    if kind == 0:
        names[a], names[b] = names[b], names[a]
    elif kind == 1:
        names[a] = names[b]
    elif kind == 2:
        suffix = rng.choice(["_kt", "_mps", "_hpa", "_degf", "_ft", "_ms", ""])
        names[a] = names[a].rsplit("_", 1)[0] + str(suffix)
    else:
        names[a] = str(rng.choice(CELLS))
    lines[row] = mark.join(names)
    return lines


def _endings(lines: list[str], rng: Random) -> list[str]:
    ending = str(rng.choice(["\r", "\r\n", "\r\r\n", "\x0b", "\u2028", "\x00"]))
    if rng.random() < 0.5:
        return [ending.join(lines)]
    return [line + ending.strip("\n") for line in lines]


def _marks(lines: list[str], rng: Random) -> list[str]:
    mark = str(rng.choice([";", "\t", "|", " ", ",,", '","']))
    return [line.replace(",", mark) for line in lines]


def recoded(data: bytes, rng: Random) -> bytes:
    code = rng.choice(["utf-16", "utf-16-le", "utf-32", "latin-1", "utf-7", "cp037"])
    return data.decode("utf-8", "replace").encode(str(code), "replace")


_OF_LINES = (_cells, _cells, _column, _rows_moved, _line_added, _names, _endings, _marks)
TEXT_DAMAGE = (*map(of_lines, _OF_LINES), recoded)


def _mapping(rng: Random) -> tuple[str, bytes]:
    """A mapping of which values or bytes are spoiled."""
    lines = MAPPING.split("\n")
    for _ in range(int(rng.integers(1, 4))):
        row = int(rng.integers(len(lines)))
        key, equals, _ = lines[row].partition("=")
        value = rng.choice(VALUES if equals else ["[log", "[[columns]]", "[x]", "="])
        lines[row] = f"{key}= {value}" if equals else str(value)
    data = "\n".join(lines).encode("utf-8", "replace")
    return ("values", data) if rng.random() < 0.7 else ("bytes", flipped(data, rng))


# One input.


def spoil(seed: int, files: Sequence[Path], folder: Path) -> tuple[Path, str, str, tuple[str, ...]]:
    """Write the input of a seed; return its file, its damage, and the command's name and words."""
    rng = np.random.default_rng([seed, 1031])
    good = files[int(rng.integers(len(files)))]
    name = [*COMMANDS][int(rng.choice(len(COMMANDS), p=USUAL))]
    words = COMMANDS[name][0].split()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    path, mapping = folder / good.name, folder / "mapping.toml"
    data, damages = good.read_bytes(), []
    if name == "a mapping":
        kind, spoiled = _mapping(rng)
        mapping.write_bytes(spoiled)
        damages.append(f"mapping {kind}")
        if rng.random() < 0.5:
            words[0] = "calibrate"
    else:
        of_text = (*BYTES_DAMAGE[:5], *TEXT_DAMAGE, *TEXT_DAMAGE)
        kinds = of_text if good.suffix in TEXT else BYTES_DAMAGE
        for _ in range(1 if rng.random() < 0.7 else 2):
            change = kinds[int(rng.integers(len(kinds)))]
            data = change(data, rng) if data else data
            damages.append(change.__name__)
    path.write_bytes(data)
    if rng.random() < BUNDLED:
        path, words_of_it = bundled(path, files[int(rng.integers(len(files)))], rng)
        damages.append(words_of_it)
    filled = tuple(word.format(log=path, mapping=mapping) for word in words)
    return good, " + ".join(damages), name, filled


def judge(seed: int, files: Sequence[Path], folder: Path) -> Result:
    """Run the command of a seed in a process of its own and judge how it ended."""
    good, damage, name, words = spoil(seed, files, folder / "input")
    out, err = folder / "stdout", folder / "stderr"
    began = time.monotonic()
    child = os.fork()
    if child == 0:
        _become(words, out, err)
    _, status, used = os.wait4(child, 0)
    lasted = time.monotonic() - began
    said, told = (path.read_bytes().decode("utf-8", "replace") for path in (out, err))
    code = os.waitstatus_to_exitcode(status)
    fault = _fault(name, code, said, told, used.ru_maxrss * 1024)
    if fault:
        shutil.copytree(folder / "input", folder / f"kept-{seed}", dirs_exist_ok=True)
        told = f"{said[:200]} | {told[:400]}"
    says, file = " ".join(told[: 603 if fault else 120].split()), f"{good.parent.name}/{good.name}"
    megabytes = used.ru_maxrss // 1024
    return Result(seed, file, damage, name, code, round(lasted, 2), megabytes, fault, says)


def _become(words: Sequence[str], out: Path, err: Path) -> None:
    """Run the command in this process, which a fork has made, and end it."""
    code = 1
    try:
        for number, path in ((1, out), (2, err)):
            os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
        # A test may have put others there.
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
        resource.setrlimit(resource.RLIMIT_AS, (2 * BYTES, 2 * BYTES))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(10 * SECONDS)
        signal.setitimer(signal.ITIMER_PROF, SECONDS)
        sys.argv = ["pitotbench", *words]
        code = run_command()
        sys.stdout.flush()
        sys.stderr.flush()
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 1
    except BaseException:
        import traceback

        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(code)


def _load(files: Sequence[Path]) -> None:
    """Run commands once on good files, so that a fork has the modules loaded."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        for path in files:
            run_command(["inspect", str(path)])
        run_command(["calibrate", str(files[-3])])
        run_command(["map", str(files[1])])


# A line for each log of a folder, their sum, and how far a long command is.
_OF_FOLDER = re.compile(
    r".+: (left out: .+|[+-][\d.]+ ± [\d.]+ kt at \d+ KIAS)|\d+ logs, \d+ with an answer|"
    r"pitotbench: calibrating: \d+ of \d+"
)


def _fault(name: str, code: int, said: str, told: str, used: int) -> str:
    if code in (-signal.SIGALRM, -signal.SIGPROF):
        return "hang"
    if "Traceback" in told or "Exception ignored" in told:
        return "traceback"
    if code not in (0, 2, 3):
        return "exit 1" if code == 1 else "crash"
    if used > BYTES:
        return "memory"
    lines = [line for line in told.splitlines() if not _OF_FOLDER.fullmatch(line)]
    if "Warning" in told:
        return "stray output"
    if code:
        refused = lines and lines[0].startswith("pitotbench: ") and not said
        return "" if refused else "stray output"
    if not all(line.startswith(("written", "#")) for line in lines):
        return "stray output"
    if "json" not in name:
        return "" if said else "stray output"
    try:
        json.loads(said, parse_constant=_no_json)
    except ValueError:
        return "invalid JSON"
    return ""


def _no_json(text: str) -> None:
    raise ValueError(f"{text} is no JSON")


def judge_all(seeds: Sequence[int], out: Path) -> list[Result]:
    """Judge the seeds that the results of a folder do not hold yet; return all that were asked."""
    out.mkdir(parents=True, exist_ok=True)
    files, table = good_files(out / "good"), out / "results.csv"
    _load(files)
    found = {result.seed: result for result in read_rows(table, Result)}
    with append_to(table, Result) as append:
        for seed in seeds:
            if seed not in found:
                found[seed] = judge(seed, files, out)
                append(found[seed])
    return [found[seed] for seed in seeds]


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; returns exit code 1 where an input brought a fault about."""
    parser = argparse.ArgumentParser(prog="python -m tests.lab.spoil", description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--first", type=int, default=1, help="the first seed")
    parser.add_argument("--count", type=int, default=1000)
    choice = parser.parse_args(arguments)
    found = judge_all(range(choice.first, choice.first + choice.count), choice.out)
    for each in found:
        if each.fault:
            what = f"seed {each.seed}, {each.file}, {each.damage}, {each.command}"
            print(f"{each.fault}: {what}: {each.says[:300]}")
    faults, codes = Counter(each.fault for each in found), Counter(each.code for each in found)
    print(f"{len(found):,} inputs: " + ", ".join(f"{name} {faults[name]}" for name in FAULTS))
    print("exit codes: " + ", ".join(f"{code} {codes[code]:,}" for code in sorted(codes)))
    print(f"largest: {max(e.seconds for e in found):.1f} s, {max(e.megabytes for e in found):,} MB")
    return 1 if any(each.fault for each in found) else 0


if __name__ == "__main__":
    sys.exit(main())
