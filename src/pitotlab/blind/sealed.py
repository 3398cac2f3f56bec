"""The sets of the blind test: truth and answers, in a folder while they are made, then in one archive.

An archive `results/blind/NAME.tar.xz` holds the truth, its seal and `results.jsonl`. `SHA256SUMS`
beside it holds the digest of every archive.
"""

import json
import tarfile
from argparse import ArgumentParser
from collections.abc import Sequence
from hashlib import sha256
from io import BytesIO
from pathlib import Path

from pitotlab.blind.case import JudgedCase
from pitotlab.experiment import OUT
from pitotlab.sealing import SEAL, TRUTH, unsealed

PLACE = OUT / "blind"  # of a set that is being made
KEPT = Path(__file__).parents[1] / "results" / "blind"
SUMS = "SHA256SUMS"
ANSWERS = "results.jsonl"


def kept_sets() -> list[Path]:
    """The archives in the order in which they were made."""
    return [KEPT / line.split()[1] for line in (KEPT / SUMS).read_text("utf-8").splitlines()]


def files_of(seal: Path) -> dict[str, bytes]:
    """The files of an archive or a folder by name. Raises ValueError for a changed archive."""
    if seal.is_dir():
        places = {TRUTH: seal / "seal", SEAL: seal / "seal", ANSWERS: seal}
        paths = {name: folder / name for name, folder in places.items()}
        return {name: path.read_bytes() for name, path in paths.items() if path.is_file()}
    lines = (seal.parent / SUMS).read_text("utf-8").splitlines()
    digests = {name: digest for digest, name in map(str.split, lines)}
    packed = seal.read_bytes()
    if sha256(packed).hexdigest() != digests.get(seal.name):
        raise ValueError(f"{seal.name} does not match its SHA-256")
    with tarfile.open(fileobj=BytesIO(packed)) as archive:
        return {each.name: file.read() for each in archive if (file := archive.extractfile(each))}


def judged_in(seal: Path) -> list[JudgedCase]:
    """Return truth and answer of every case of an archive or a folder that has an answer.

    Raises ValueError where the truth is not the one sealed.
    """
    files = files_of(seal)
    told = [json.loads(line) for line in files.get(ANSWERS, b"").decode().splitlines()]
    answers = {each["name"]: each for each in told}
    cases = unsealed(files[TRUTH], files[SEAL])["cases"]
    return [JudgedCase(c, answers[c["name"]]) for c in cases if c["name"] in answers]


def pack(name: str, folder: Path, into: Path = KEPT) -> Path:
    """Pack a set into one archive, add its SHA-256 to those of the others, and return its path.

    The answers are in `folder`, the truth and its seal in its folder `seal`.
    """
    judged_in(folder)
    files = files_of(folder)
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
    add("name", help="of the set: fifteenth")
    add("--folder", type=Path, default=PLACE, help="folder of the set (default: %(default)s)")
    options = parser.parse_args(words)
    print(pack(options.name, options.folder))
