"""How a record shows itself in a notebook: as a line, as HTML, as a picture and as a table.

The records know nothing of drawing. `show.notebook` holds the views; it is loaded when a view is first asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pandas import DataFrame

_VIEWS = "pitotbench.show.notebook"  # by name, as the table of commands names its modules


class Shown:
    """A record that a notebook shows."""

    __slots__ = ()

    def to_frame(self) -> "DataFrame":
        """Return the record as a table; each column ends in its unit."""
        frame: DataFrame = _views().to_frame(self)
        return frame

    def plot(self, axes: Any = None) -> Any:
        """Draw the record on matplotlib's axes, or in a new figure without them; return the figure."""
        return _views().plot(self, axes)

    def _repr_html_(self) -> str:
        return str(_views().to_html(self))

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {_views().in_one_line(self)}>"


def _views() -> Any:
    return import_module(_VIEWS)
