"""Ask one checkout all questions and write its answers as JSON: run by the guards in either tree,
by path.

It touches outside interfaces alone: the command line, the public names, and tables that are found
by name in whatever module holds them. It imports nothing else of the laboratory, because the other
checkout may have none.
"""

import csv
import importlib
import json
import math
import os
import pkgutil
import re
import shlex
import shutil
import struct
import subprocess
import sys
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from typing import Any

TABLES = ("EFFECTS", "MANEUVERS", "MODELS", "FORMS", "COMMANDS")
HELPED_SCRIPTS = ("run_campaign", "reproduce_study", "reconcile")
NOT_COMPARED = (
    "flight",
    "cpu_s",
    "wall_s",
    "code",
    "when",
)  # columns of time and of digests of code
# Where the blind generator may be, and how its signatures and its development set are made.
BLIND = {
    "src/pitotlab/blind/drawn.py": ("pitotlab blind signatures", "pitotlab blind develop"),
    "tests/blind/development.py": ("tests.blind.signatures", "tests.blind.development"),
}
DEVELOPMENT_LOGS = 40

Answers = dict[str, object]


@dataclass(frozen=True)
class Said:
    """What a command said: its output, its errors and its exit code."""

    out: str
    err: str
    code: int


@dataclass(frozen=True)
class Bench:
    """A checkout, the folder of its own in which its commands run, and where the real logs lie."""

    tree: Path
    place: Path
    data: Path
    questions: Mapping[str, Any]
    made: set[str] = field(default_factory=set)

    def run(self, *arguments: str, timeout: float = 7200.0) -> Said:
        """Run a command of the bench, a script, or Python with a flag, and return what it said."""
        first = [] if arguments[:1] == ("-m",) else ["-m", "pitotbench"]
        if arguments and arguments[0].startswith("scripts/"):
            first, arguments = [str(self.tree / arguments[0])], arguments[1:]
        done = subprocess.run(
            [sys.executable, *first, *(a.replace("DATA/", f"{self.data}/") for a in arguments)],
            cwd=self.place, capture_output=True, text=True, timeout=timeout, check=False,
        )  # fmt: skip
        return Said(self.neutral(done.stdout), self.neutral(done.stderr), done.returncode)

    def ask(self, line: str) -> object:
        """Return what a command line answers: its document where it prints JSON, else its words."""
        said = self.run(*shlex.split(line))
        if "--json" in line and said.code == 0:
            return {"answer": json.loads(said.out), "stderr": said.err}
        return words(said)

    def neutral(self, text: str) -> str:
        """Return a text without what differs between two places: folders, lines of code, versions,
        times.
        """
        for path, name in ((self.place, "<place>"), (self.data, "<data>"), (self.tree, "<tree>")):
            text = text.replace(str(path), name)
        text = re.sub(r"<tree>[^\s:]*\.py:\d+", "<code>", text)
        text = text.replace(f"pitotbench {version('pitotbench')}", "pitotbench <version>")
        return re.sub(r"(?m)^pitotbench: \w+: \d+ of \d+\n", "", text)  # progress, by the clock

    def once(self, what: str, make: Callable[["Bench"], None]) -> None:
        """Make something that several guards need, the first time only."""
        if what not in self.made:
            self.made.add(what)
            make(self)


def words(said: Said) -> str:
    """Return what a command said as one text."""
    return f"exit code {said.code}\n--- stdout\n{said.out}--- stderr\n{said.err}"


def write_files(bench: Bench) -> None:
    """Write the small files of the questions, the logs with unknown columns, and a ULog."""
    for name, text in bench.questions["files"].items():
        (bench.place / name).parent.mkdir(exist_ok=True)
        (bench.place / name).write_text(text.lstrip("\n"), encoding="utf-8")
    for name, header in bench.questions["headers"].items():
        columns = [re.fullmatch(r"(.+)=(\w)(?:\*(.+))?", each) for each in header.split()]
        with (bench.place / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file, lineterminator="\n")
            table.writerow(
                [
                    c[1].replace("_", " ") if "_(" in c[1] or "_[" in c[1] else c[1]
                    for c in columns
                    if c
                ]
            )
            for second in range(240):
                row = orbit(second)
                table.writerow([f"{row[c[2]] * float(c[3] or 1.0):.7g}" for c in columns if c])
    write_ulog(bench.place / "log.ulg")


def orbit(second: float) -> dict[str, float]:
    """Return a second of a plausible turn in wind: pressures, velocities and what other logs hold
    of it.
    """
    turn, speed = math.radians(3.0 * second), 55.0 + 8.0 * math.sin(second / 40.0)
    north, east = speed * math.cos(turn) - 4.0, speed * math.sin(turn) + 6.0
    wave = math.sin(12.9898 * second) + math.sin(
        78.233 * second + 1.0
    )  # looks like noise on any machine
    return {
        "t": 100.0 + second, "q": 0.5 * 1.05 * speed**2 + 4.0 * wave, "p": 81200.0 + 6.0 * wave,
        "n": north + 0.05 * wave, "e": east, "a": 1830.0 + wave, "h": 6000.0 + 3.0 * wave, "k": 276.3 + 0.1 * wave,
        "c": 3.1 + 0.1 * wave, "v": 1.8 * speed + 0.4 * wave, "g": 1.94384 * math.hypot(north, east),
        "r": math.degrees(math.atan2(east, north)) % 360.0,
    }  # fmt: skip


def write_ulog(path: Path) -> None:
    """Write a ULog (PX4 file format, version 1) of a turn: header, flags, formats, subscriptions,
    data.
    """

    def message(kind: str, body: bytes) -> bytes:
        return struct.pack("<HB", len(body), ord(kind)) + body

    topics = {
        "differential_pressure": ("differential_pressure_pa", "q"),
        "vehicle_air_data": ("baro_pressure_pa", "p"),
        "sensor_gps": ("vel_n_m_s vel_e_m_s vel_d_m_s alt", "neza"),
    }
    parts = [b"ULog\x01\x12\x35\x01", struct.pack("<Q", 0), message("B", bytes(40))]
    for name, (columns, _) in topics.items():
        listing = "".join(f"float {each};" for each in columns.split())
        parts.append(message("F", f"{name}:uint64_t timestamp;{listing}".encode()))
    parts += [
        message("A", struct.pack("<BH", 0, n) + name.encode()) for n, name in enumerate(topics)
    ]
    for number, (_, letters) in enumerate(topics.values()):
        for second in range(300):
            row = {**orbit(second), "z": 0.0}
            values = [row[letter] * (1e3 if letter == "a" else 1.0) for letter in letters]
            body = struct.pack(
                f"<HQ{len(values)}f", number, int(row["t"] * 1e6) + 1000 * number, *values
            )
            parts.append(message("D", body))
    path.write_bytes(b"".join(parts))


def fly_short(bench: Bench) -> None:
    """Fly the short cases of the questions."""
    for name, text in bench.questions["flights"].items():
        (bench.place / f"{name}.toml").write_text(text, encoding="utf-8")
        said = bench.run("fly", f"{name}.toml", "-o", f"{name}.csv")
        if said.code:
            (bench.place / f"{name}.csv").write_text(words(said), encoding="utf-8")


def fly_campaign(bench: Bench) -> None:
    """Fly the paper's five maneuvers and record each with two data systems."""
    fixed = "--log-format csv --no-report --jobs 1 --progress none --keep-logs all --out campaign"
    said = bench.run("scripts/run_campaign.py", *f"--maneuver all --das 20/1,50/50 {fixed}".split())
    (bench.place / "campaign.txt").write_text(words(said), encoding="utf-8")
    if (bench.place / "campaign/logs").is_dir():
        shutil.copytree(bench.place / "campaign/logs", bench.place / "logs", dirs_exist_ok=True)


def collected_tests(bench: Bench) -> Answers:
    """Return the tests that pytest collects, by function and parameter without their path, and the
    skips.
    """
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "--collect-only", "-q", "-o", "addopts=", "-rs", "-p", "no:cacheprovider"],
        cwd=bench.tree, capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": f"{bench.tree / 'src'}"},
    )  # fmt: skip
    lines = done.stdout.splitlines()
    names = sorted(
        line.split(".py::", 1)[1]
        for line in lines
        if ".py::" in line and not line.startswith("SKIPPED")
    )
    other = [
        line
        for line in lines
        if re.match(r"SKIPPED|ERROR|.*(deselected|error)", line) and ".py::" not in line
    ]
    skips = "\n".join(sorted(re.sub(r"tests/\S*?([^/]+\.py)[:\d]*", r"\1", line) for line in other))
    return {"tests": "\n".join(names), "skipped or in error while collecting": bench.neutral(skips)}


def modules(root: str) -> list[Any]:
    """Import all modules of a package but those that run when imported; return those that could be
    imported.
    """
    found = []
    package = importlib.import_module(root)
    for each in pkgutil.walk_packages(package.__path__, f"{root}.", onerror=lambda _: None):
        if not each.name.endswith("__main__"):
            try:
                found.append(importlib.import_module(each.name))
            except ImportError:  # of an extra that is not installed
                continue
    return found


def tables(name: str) -> list[Any]:
    """Return the tables of a name, each once, wherever the product holds them."""
    found = {
        id(t): t for module in modules("pitotbench") if (t := vars(module).get(name)) is not None
    }
    return [
        t for t in found.values() if isinstance(t, Mapping) or hasattr(next(iter(t)), "_fields")
    ]


def table_rows(_: Bench) -> Answers:
    """Return the names of each table in order, and what each entry of it says of itself."""
    said: Answers = {}
    for name in TABLES:
        for number, table in enumerate(sorted(tables(name), key=len, reverse=True)):
            label = f"{name} {number + 1}" if number else name
            rows = (
                table.items()
                if isinstance(table, Mapping)
                else ((str(row[0]), row) for row in table)
            )
            texts = {str(key): plain(repr(value)) for key, value in rows}
            said[f"{label}: names"] = "\n".join(texts)
            said[f"{label}: entries"] = {key: texts[key] for key in sorted(texts)}
    return said


def plain(text: str) -> str:
    """Return the text of a record without functions, addresses and modules, which may move."""
    text = re.sub(
        r"<(function|bound method|built-in function) .*?( at 0x[0-9a-f]+)?>(?=[,)\]}])", "…", text
    )
    return re.sub(r"<class '.*?'>|\bpitot(bench|lab)(\.\w+)+", "…", text)


def said_words(bench: Bench) -> Answers:
    """Return what the short commands and every --help say, with their exit codes."""
    bench.once("short flights", fly_short)
    root = bench.run("--help")
    commands = re.findall(r"^    ([a-z][a-z-]+)(?=\s)", root.out, flags=re.MULTILINE)
    helps = [["--help"], *([name, "--help"] for name in commands)]
    helps += [[f"scripts/{name}.py", "--help"] for name in HELPED_SCRIPTS]
    asked = [*helps, *map(shlex.split, bench.questions["words"])]
    return {" ".join(line) or "(nothing)": words(bench.run(*line)) for line in asked}


def given_answers(bench: Bench) -> Answers:
    """Return the logs that were flown, as digests, and all answers about them."""
    bench.once("short flights", fly_short)
    bench.once("campaign", fly_campaign)
    said: Answers = {"campaign": (bench.place / "campaign.txt").read_text("utf-8")}
    flown = [f"{name}.csv" for name in bench.questions["flights"]]
    logs = sorted(
        each.relative_to(bench.place).as_posix() for each in (bench.place / "logs").glob("*.csv")
    )
    for name in [*flown, *logs]:
        text = (bench.place / name).read_text("utf-8")
        head = [line for line in text.splitlines() if line.startswith("#")]
        said[f"bytes of {name}"] = {
            "header": bench.neutral("\n".join(head)),
            "sha256 below the header": sha256(
                "\n".join(text.splitlines()[len(head) :]).encode()
            ).hexdigest(),
        }
    for line in bench.questions["answers"]:
        said[line] = bench.ask(line)
    return said


def full_answers(bench: Bench) -> Answers:
    """Return plans, verdicts, and the results of the paper's flights with all data systems and
    models.
    """
    import pandas as pd

    bench.once("short flights", fly_short)
    bench.once("campaign", fly_campaign)
    said: Answers = {line: bench.ask(line) for line in bench.questions["full"]}
    line = (
        "--maneuver all --das all --model all --no-report --jobs 1 --progress none --keep-logs "
        "none --out every"
    )
    said["all/all/all"] = bench.ask(f"scripts/run_campaign.py {line}")
    if (bench.place / "every/results.parquet").is_file():
        table = pd.read_parquet(bench.place / "every/results.parquet")
        rows = table.drop(columns=[c for c in NOT_COMPARED if c in table]).to_dict("records")
        said["results.parquet"] = {
            f"{r['maneuver']} {r['das']} {r['model']}": strings(r) for r in rows
        }
    said["claims"] = bench.ask("scripts/reproduce_study.py --claims-only --jobs 1 --out study")
    for path in sorted((bench.place / "study").rglob("*.parquet")):
        rows = (
            pd.read_parquet(path)
            .drop(columns=list(NOT_COMPARED), errors="ignore")
            .to_dict("records")
        )
        said[f"claims: {path.stem}"] = {str(i): strings(row) for i, row in enumerate(rows)}
    return said


def strings(row: Mapping[Any, Any]) -> dict[str, object]:
    """Return a row with numbers and words alone, for JSON."""
    plain_row = {
        str(key): value.item() if hasattr(value, "item") else value for key, value in row.items()
    }
    return {
        key: v if isinstance(v, int | float | str) or v is None else str(v)
        for key, v in plain_row.items()
    }


def effect_changes(_: Bench) -> Answers:
    """Return digests of the channels of one short flight with each effect at its typical size, and
    without any.
    """
    import pitotbench

    case = 'maneuver = "rapid_decel"\ncard = { dwell_s = 15.0, settle_s = 8.0, repeats = 1 }\n'
    said: Answers = {}
    effects = {name: effect for table in tables("EFFECTS") for name, effect in table.items()}
    for name in ("", *effects):
        sizes = (
            "".join(f"{p.name} = {float(p.typical)!r}\n" for p in effects[name].parameters)
            if name
            else ""
        )
        text = case + (
            f'[[effects]]\nname = "{name}"\n[effects.parameters]\n{sizes}' if name else ""
        )
        try:
            said[name or "(none)"] = channels(
                pitotbench.sense(pitotbench.fly(pitotbench.read_case(text)), "20/5")
            )
        except (pitotbench.BadInputError, pitotbench.NoAnswerError, ValueError) as error:
            said[name] = f"{type(error).__name__}: {error}"
    return said


def channels(log: Any) -> dict[str, object]:
    """Return the digest of each channel of a log."""
    import numpy as np

    every = {each.name: getattr(log, each.name) for each in fields(log)}
    arrays = {name: value for name, value in every.items() if isinstance(value, np.ndarray)}
    return {
        name: sha256(
            str(value.tolist()).encode() if value.dtype.kind in "OUST" else value.tobytes()
        ).hexdigest()
        for name, value in arrays.items()
    }


def blind_logs(bench: Bench) -> Answers:
    """Return digests of development logs of the blind generator, and a verdict on the first log of
    each kind.
    """
    import pitotbench

    entry = next((path for path in BLIND if (bench.tree / path).is_file()), None)
    if entry is None:
        return {"skipped": f"no blind generator at {' or '.join(BLIND)}"}
    os.environ["PYTHONPATH"] = f"{bench.tree / 'src'}{os.pathsep}{bench.tree}"
    for command, flags in zip(
        BLIND[entry], ("--place signatures", "--signatures signatures --out blind"), strict=True
    ):
        said_so = bench.run("-m", *f"{command} {flags} --settings A,B --jobs 1".split())
        if said_so.code:
            return {"skipped": f"the blind generator of {entry} failed: {said_so.err[-300:]}"}
    said: Answers = {}
    logs = sorted((bench.place / "blind/logs").glob("*.parquet"))
    for path in logs[:DEVELOPMENT_LOGS]:
        said[path.name] = channels(pitotbench.read_log(path))
    truth = json.loads((bench.place / "blind/truth.json").read_text("utf-8"))["cases"]
    first = {case["kind"]: case["name"] for case in reversed(truth)}
    for kind, name in sorted(first.items()):
        said[f"verdict: {kind}"] = bench.ask(
            f"reconcile blind/logs/{name}.parquet --no-next-flight --json"
        )
    return said


QUICK: dict[str, Callable[[Bench], Answers]] = {
    "tests": collected_tests,
    "tables": table_rows,
    "words": said_words,
    "answers": given_answers,
}
FULL: dict[str, Callable[[Bench], Answers]] = {
    "full": full_answers,
    "effects": effect_changes,
    "blind": blind_logs,
}


def main(tree: Path, place: Path, data: Path, names: list[str]) -> None:
    """Answer the questions of some guards; write `<guard>.json` into the place, each as soon as it
    is known.
    """
    questions = tomllib.loads(Path(__file__).with_name("questions.toml").read_text("utf-8"))
    bench = Bench(tree, place / "work", data, questions)
    bench.place.mkdir(parents=True, exist_ok=True)
    os.chdir(bench.place)
    write_files(bench)
    for name in names:
        begun = sum(os.times()[:4])
        answers = {**QUICK, **FULL}[name](bench)
        text = json.dumps({"cpu_s": sum(os.times()[:4]) - begun, "answers": answers})
        (place / f"{name}.json").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3]), sys.argv[4:])
