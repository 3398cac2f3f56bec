"""The cache of null distributions: a file for each card, named by a digest of inputs and code."""

import os
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

from pitotbench.campaigns.digests import NOT_DECIDING, aircraft_digest, package_digest
from pitotbench.logbook.columns import atomic
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.null_distribution import NullDistribution, read_distribution, text_of
from pitotbench.records import BadInputError
from pitotbench.records.aircraft import cache_folder
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case

Progress = Callable[[str], None]  # is called with a line about the step that begins


MOST_KEPT = 100  # entries of the cache, about 0.2 MB each


def cache_entry(card: Case, flights: int, setting: AnalysisSetting) -> Path:
    """Return the file of a card's null distribution, whether it exists or not.

    Its name has a digest of all that decides it: card, setting, code, aircraft files, versions.
    """
    versions = [f"{name} {version(name)}" for name in ("jsbsim", "numpy", "scipy")]
    computes = (versions, package_digest(NOT_DECIDING), aircraft_digest(card.aircraft))
    digest = sha256(repr((write_case(card), flights, setting, computes)).encode()).hexdigest()[:24]
    return cache_folder() / f"null-{digest}.json"


def read_entry(place: Path, flights: int, say: Progress) -> NullDistribution | None:
    """Return an entry of the cache and mark it as used, None where none is there or usable."""
    try:
        null = read_distribution(place.read_bytes())
        if null.flights != flights:
            raise ValueError(f"of {null.flights} flights instead of {flights}")
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        say(f"{place} cannot be used: its null flights are flown again")
        return None
    with suppress(OSError):  # a read-only cache can be used as well
        os.utime(place)
    return null


def write_entry(place: Path, null: NullDistribution, say: Progress) -> None:
    """Write an entry completely or not at all, and remove those not used for longest."""
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with atomic(place) as scratch:
            scratch.write_text(text_of(null), encoding="utf-8")
        _prune(place.parent)
    except (OSError, ValueError, BadInputError) as error:  # the log can be judged all the same
        say(f"the null flights are not kept: {error}")


def _prune(folder: Path) -> None:
    """Remove all but the `MOST_KEPT` entries used last.

    Partial files of a stopped run count as entries.
    """
    files = [file for pattern in ("null-*.json", ".null-*.part") for file in folder.glob(pattern)]
    for file in sorted(files, key=_last_used, reverse=True)[MOST_KEPT:]:
        file.unlink(missing_ok=True)


def _last_used(file: Path) -> float:
    """When a file was last used [s]; 0 where another run has just removed it."""
    try:
        return file.stat().st_mtime
    except FileNotFoundError:
        return 0.0
