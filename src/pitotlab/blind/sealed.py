"""The sets of the blind test: truth, answers, observations; in a folder while they are made, then
in one archive.

An archive `results/blind/NAME.tar.xz` holds `truth.json`, its seal `truth.sha256`, `results.jsonl`,
and where they were made `observed.jsonl`. `results/blind/SHA256SUMS` holds the digest of every
archive.
"""

import json
import tarfile
from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

from pitotlab.blind.case import JudgedCase
from pitotlab.experiment import OUT

PLACE = OUT / "blind"  # of a set that is being made
KEPT = Path(__file__).parents[1] / "results" / "blind"
SUMS = "SHA256SUMS"
ANSWERS = ("results.jsonl", "observed.jsonl")


def kept_sets() -> list[Path]:
    """The archives in the order in which they were made."""
    return [KEPT / line.split()[1] for line in (KEPT / SUMS).read_text("utf-8").splitlines()]


def current_sets() -> list[Path]:
    """The archives that the regression of all gaps judged; earlier ones hold answers of an old chain."""
    every = kept_sets()
    return every[every.index(KEPT / "fourteenth.tar.xz") :]


def files_of(seal: Path) -> dict[str, bytes]:
    """The files of an archive or a folder by name. Raises ValueError for a changed archive."""
    if seal.is_dir():
        names = ("truth.json", "truth.sha256", *ANSWERS)
        return {name: (seal / name).read_bytes() for name in names if (seal / name).is_file()}
    lines = (seal.parent / SUMS).read_text("utf-8").splitlines()
    digests = {name: digest for digest, name in map(str.split, lines)}
    packed = seal.read_bytes()
    if sha256(packed).hexdigest() != digests.get(seal.name):
        raise ValueError(f"{seal.name} does not match its SHA-256")
    with tarfile.open(fileobj=BytesIO(packed)) as archive:
        return {each.name: file.read() for each in archive if (file := archive.extractfile(each))}


def opened(seal: Path) -> dict[str, Any]:
    """The truth of an archive or a folder. Raises ValueError where it is not the one sealed."""
    files = files_of(seal)
    if sha256(files["truth.json"]).hexdigest() != files["truth.sha256"].decode().strip():
        raise ValueError("the truth does not match its seal")
    truth: dict[str, Any] = json.loads(files["truth.json"])
    return truth


def judged_in(seal: Path, *answers: Path | None) -> list[JudgedCase]:
    """Truth, answer and observation of every case that has an answer.

    `answers` are the files of results and observations; of an archive, or of a folder that holds
    them all, none need be given.
    """
    given = files_of(seal) if not answers else {}
    for name, path in zip(ANSWERS, answers, strict=False):
        if path and path.is_file():
            given[name] = path.read_bytes()
    results, observed = (_by_name(given.get(name, b"")) for name in ANSWERS)
    return [
        JudgedCase(case, results[name], observed.get(name, {}))
        for case in opened(seal)["cases"]
        if (name := case["name"]) in results
    ]


def _by_name(lines: bytes) -> dict[str, Mapping[str, Any]]:
    return {each["name"]: each for each in map(json.loads, lines.decode().splitlines())}


def pack(name: str, folder: Path, into: Path = KEPT) -> Path:
    """Pack a set into one archive, add its SHA-256 to those of the others, and return its path.

    The answers are in `folder`, the truth and its seal in its folder `seal` or beside them.
    """
    opened(seal := folder / "seal" if (folder / "seal").is_dir() else folder)
    files = files_of(folder) | files_of(seal)
    into.mkdir(parents=True, exist_ok=True)
    path = into / f"{name}.tar.xz"
    with tarfile.open(path, "w:xz", preset=9) as archive:
        for each, content in sorted(files.items()):
            entry = tarfile.TarInfo(each)  # no times, no owners: the same set gives the same bytes
            entry.size = len(content)
            archive.addfile(entry, BytesIO(content))
    sums = into / SUMS
    lines = sums.read_text("utf-8").splitlines() if sums.is_file() else []
    lines = [line for line in lines if line.split()[1] != path.name]
    lines.append(f"{sha256(path.read_bytes()).hexdigest()}  {path.name}")
    sums.write_text("\n".join([*lines, ""]), encoding="utf-8")
    return path


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Pack a judged set into one archive of the results, with its SHA-256."""
    add = parser.add_argument
    add("name", help="of the set: twelfth")
    add("--folder", type=Path, default=PLACE, help="folder of the set (default: %(default)s)")
    options = parser.parse_args(words)
    print(pack(options.name, options.folder))
