"""Where work that need not be done twice is kept."""

import os
from pathlib import Path

from platformdirs import user_cache_path


def cache_folder() -> Path:
    """Return the folder of the cache: `$PITOTBENCH_CACHE`, else that of the system for this user."""
    return Path(os.environ.get("PITOTBENCH_CACHE") or user_cache_path("pitotbench", appauthor=False))
