"""The digests of the code and of the aircraft's files that decide a result.

The keys of what is kept hold them.
"""

from collections.abc import Iterable
from functools import cache, lru_cache
from hashlib import file_digest, sha256
from pathlib import Path

from pitotbench.simulation.aircraft import PACKAGE, find_aircraft

# Packages whose code shows results and cannot change them. All other code counts: a list of the
# code that counts would miss a module that a later change adds.
NOT_DECIDING = ("cli", "browser", "show")
# What flies and calibrates needs neither the reconciler nor most of the campaigns.
_NOT_FLYING = (*NOT_DECIDING, "reconciliation", "models", "bench", "campaigns")
_FLYING_CAMPAIGNS = ("campaigns/flights.py", "campaigns/task.py")


@cache
def code_digest() -> str:
    """Return the digest of the code that decides the result of a flight, 16 hexadecimal digits."""
    return package_digest(_NOT_FLYING, _FLYING_CAMPAIGNS)


def package_digest(without: Iterable[str] = (), but: Iterable[str] = ()) -> str:
    """Return the digest of this package's code, `without` packages `but` some of their modules."""
    left_out, kept = {*without}, {*but}
    paths = (file.relative_to(PACKAGE) for file in sorted(PACKAGE.rglob("*.py")))
    return _digest_of(
        PACKAGE, (p for p in paths if p.parts[0] not in left_out or p.as_posix() in kept)
    )


def file_sha256(path: Path) -> str:
    """Return the SHA-256, in hexadecimal, of a file or of a folder's files one after another.

    The files of a folder go by path.
    """
    found = sha256()
    for each in sorted(path.rglob("*")) if path.is_dir() else [path]:
        if each.is_file():
            with each.open("rb") as file:
                file_digest(file, lambda: found)
    return found.hexdigest()


def aircraft_digest(name: str) -> str:
    """Return the digest of the files of an aircraft.

    Raises UnknownNameError for one that does not exist.
    """
    folder = find_aircraft(name)
    files = (file for file in sorted(folder.rglob("*")) if file.is_file())
    # The files may change while this process runs: their sizes and times say whether they are to be
    # read again.
    stats = ((file.relative_to(folder), file.stat()) for file in files)
    return _aircraft_digest(
        folder, tuple((path, stat.st_size, stat.st_mtime_ns) for path, stat in stats)
    )


@lru_cache(maxsize=64)
def _aircraft_digest(folder: Path, stamps: tuple[tuple[Path, int, int], ...]) -> str:
    return _digest_of(folder, (path for path, _, _ in stamps))


def _digest_of(root: Path, paths: Iterable[Path]) -> str:
    """Return the digest of files by their paths below a folder, 16 hexadecimal digits."""
    digest = sha256()
    for path in paths:
        digest.update(repr((path.as_posix(), (root / path).read_bytes())).encode())
    return digest.hexdigest()[:16]
