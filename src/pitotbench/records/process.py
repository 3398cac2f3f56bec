"""Limits of a process."""

from collections.abc import Callable
from contextlib import suppress
from functools import partial


def limit_process(name: str, most: int) -> Callable[[], object]:
    """Give this process a limit of the system, such as `RLIMIT_AS`; return what takes it back.

    A later limit may exceed it. Windows has none, macOS refuses one below what is in use, and the
    system's own may be lower: there nothing happens.
    """
    with suppress(ImportError, ValueError, OSError):
        import resource

        kind = getattr(resource, name)
        before = _, hard = resource.getrlimit(kind)
        allowed = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (allowed, hard))
        return partial(resource.setrlimit, kind, before)
    return lambda: None
