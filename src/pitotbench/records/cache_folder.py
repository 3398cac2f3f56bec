"""Where work that need not be done twice is kept."""

import os
from pathlib import Path


def cache_folder() -> Path:
    """Return the folder of the cache: `$PITOTBENCH_CACHE`, else one in the user's cache folder."""
    chosen = os.environ.get("PITOTBENCH_CACHE")
    if chosen:
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pitotbench"
