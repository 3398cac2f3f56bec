"""One thread for linear algebra: faster on arrays of this size, and the same digits on any number of cores."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the linear-algebra libraries to one thread while the context lasts."""
    with _controller().limit(limits=1):
        yield


@cache
def _controller() -> "ThreadpoolController":
    """Looked up once: finding the loaded libraries takes longer than a fit.

    The BLAS of NumPy and that of SciPy must be loaded by then. The estimators load both on import.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
