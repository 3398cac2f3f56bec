"""The version of the project, of which the metadata of the wheel come, and those of packages."""

from functools import cache

__version__ = "1.1.0"


@cache  # to read the metadata of three packages takes a fifth of a short log's time
def version_of(package: str) -> str:
    """Return the version of an installed package, or of this one; "unknown" without metadata."""
    from importlib.metadata import PackageNotFoundError, version  # as slow to load as `--help`

    if package == "pitotbench":  # a checkout that runs without being installed has no metadata
        return __version__
    try:
        return version(package)
    except PackageNotFoundError:
        return "unknown"
