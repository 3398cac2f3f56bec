"""The lock holds all that is installed, with hashes, and no address of where to get it."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")
PINS = LOCK.replace("\\\n", "").splitlines()  # one each, with its hashes
WORDS = re.compile(r"(\S+)==(\S+)(?: ; (.+?))?(?: +--hash=sha256:[0-9a-f]{64})+")
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
SYSTEMS = ("linux", "darwin", "win32")


def wanted() -> list[Requirement]:
    """What is needed to build the project, to run it, to test it and to write its site."""
    file = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = file["project"]["optional-dependencies"].values()
    parts = (file["build-system"]["requires"], file["project"]["dependencies"], *extras)
    return [Requirement(text) for part in parts for text in part]


def pinned(python: str, system: str) -> dict[str, str]:
    """Package to release on one Python and system."""
    place = {"python_full_version": f"{python}.9", "python_version": python, "sys_platform": system}
    pins = [WORDS.fullmatch(pin).groups() for pin in PINS]
    here = [
        (name, release)
        for name, release, marker in pins
        if marker is None or Requirement(f"{name} ; {marker}").marker.evaluate(place)
    ]
    assert len(here) == len(dict(here)), "a package is pinned twice"
    return {canonicalize_name(name): release for name, release in here}


def test_every_pin_has_a_hash_and_nothing_else_is_in_the_lock() -> None:
    without = [pin for pin in PINS if not WORDS.fullmatch(pin)]
    assert not without
    assert "://" not in LOCK


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("python", PYTHONS)
def test_the_lock_holds_all_that_the_project_asks_for(python: str, system: str) -> None:
    releases = pinned(python, system)
    missing = [
        str(need)
        for need in wanted()
        if not need.specifier.contains(releases.get(canonicalize_name(need.name), "0"))
    ]
    assert not missing
