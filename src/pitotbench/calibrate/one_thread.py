"""Linear algebra on one thread: faster for arrays of this size, and the same digits on any number of cores."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the linear-algebra libraries to one thread within the context."""
    with _controller().limit(limits=1):
        yield


@cache
def _controller() -> "ThreadpoolController":
    """Find the loaded libraries, once, because this takes longer than a fit.

    The BLAS of NumPy and that of SciPy must be loaded before. The estimators load both on import.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
