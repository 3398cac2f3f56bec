"""The digest of the code and of the aircraft files that decide a result."""

from collections.abc import Iterable
from functools import cache
from hashlib import sha256
from pathlib import Path

from pitotbench.simulate.hangar import PACKAGE, find_aircraft

# Packages whose code cannot change the result of a flight. All other code counts: a list of the code that counts
# would miss a module that a later change adds.
NOT_DECIDING = ("cli", "evidence", "show", "reconcile", "bench")
_DECIDING_BENCH = ("bench/flights.py", "bench/truth_comparison.py", "bench/campaign/perform.py")


@cache
def code_digest() -> str:
    """Return the digest of the code that decides the result of a flight, 16 hexadecimal digits."""
    files = (file for file in sorted(PACKAGE.rglob("*.py")) if _decides(file.relative_to(PACKAGE)))
    return digest_of(PACKAGE, files)[:16]


@cache
def aircraft_digest(name: str) -> str:
    """Return the digest of the files of an aircraft. Raises UnknownNameError for one that does not exist."""
    folder = find_aircraft(name)
    return digest_of(folder, (file for file in sorted(folder.rglob("*")) if file.is_file()))[:16]


def digest_of(root: Path, files: Iterable[Path]) -> str:
    """Return the digest of files with their paths below a folder."""
    digest = sha256()
    for file in files:
        digest.update(repr((file.relative_to(root).as_posix(), file.read_bytes())).encode())
    return digest.hexdigest()


def _decides(path: Path) -> bool:
    return path.parts[0] not in NOT_DECIDING or path.as_posix() in _DECIDING_BENCH
