"""A chart in the making: marks in data units, with their legend. `frame.drawing_of` turns it into SVG."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from pitotbench.show.drawing.shapes import Scale, area, beam, path, point, rectangle, segments, stroke
from pitotbench.units import Array

DASHED, DOTTED = (3.7, 1.6), (1.0, 1.65)  # lengths of dash and gap, in line widths
_MARGIN = 0.05  # share of the data's range that is left free on either side
_BACK, _MIDDLE, _FRONT = 1, 2, 4  # areas lie behind lines, measured points before them

Values = Array | Sequence[float]


class Mark(NamedTuple):
    """Something drawn: its layer, its SVG at a scale, and its legend entry with the SVG of the key."""

    layer: int
    svg: Callable[[Scale], str]
    label: str
    key: str


@dataclass(slots=True)
class Extent:
    """The range of the data along an axis, and what the limits make of it.

    `floor` is a value that the axis does not go beyond while no data do. `fixed` limits replace those of the data.
    """

    low: float = np.inf
    high: float = -np.inf
    margin: float = _MARGIN
    floor: float | None = None
    fixed: tuple[float | None, float | None] = (None, None)

    def include(self, *values: Values) -> None:
        """Extend the range to the finite ones of some values."""
        for each in values:
            finite = np.asarray(each, dtype=np.float64)
            finite = finite[np.isfinite(finite)]
            if finite.size:
                self.low, self.high = min(self.low, float(finite.min())), max(self.high, float(finite.max()))

    def limits(self) -> tuple[float, float]:
        """Return the limits of the axis."""
        low, high = (self.low, self.high) if self.low <= self.high else (0.0, 1.0)
        if high - low <= 1e-12 * max(abs(low), abs(high)):  # one value: some room around it
            room = 0.05 * abs(low) or 0.05
            low, high = low - room, high + room
        edge = self.margin * (high - low)
        low = low if self.floor is not None and low == self.floor else low - edge
        high = high if self.floor is not None and high == self.floor else high + edge
        fixed_low, fixed_high = self.fixed
        return (low if fixed_low is None else fixed_low), (high if fixed_high is None else fixed_high)


@dataclass(slots=True)
class Chart:
    """Marks on two linear axes. Methods add a mark in data units; sizes are in points.

    `equal`: one unit is as long on both axes. `names` are written along the x axis at 0, 1, ... instead of numbers.
    `aside` is drawn in the margin on the right, in shares of the axes.
    """

    xlabel: str = ""
    ylabel: str = ""
    equal: bool = False
    vertical_grid: bool = True
    names: Sequence[str] = ()
    aside: "Aside | None" = None
    x: Extent = field(default_factory=Extent)
    y: Extent = field(default_factory=Extent)
    marks: list[Mark] = field(default_factory=list)

    def line(
        self, x: Values, y: Values, color: str, width: float = 1.4, dash: tuple[float, ...] = (), label: str = ""
    ) -> None:
        """Draw a line through points, broken where one is not a number."""
        self._include(x, y)
        self._add(_MIDDLE, lambda scale: path(scale, x, y, color, width, dash), label, beam(color, width, dash))

    def level(
        self, y: float, color: str, width: float = 1.4, dash: tuple[float, ...] = (), label: str = ""
    ) -> None:
        """Draw a line across the whole axes at a height."""
        self.y.include([y])
        look = stroke(color, width, dash)
        self._add(_MIDDLE, lambda scale: f'<path d="M0 {scale.y(y):.1f}h{scale.width:.1f}" {look}/>', label,
                  beam(color, width, dash))  # fmt: skip

    def band(self, x: Values, low: Values, high: Values, color: str, opacity: float, label: str = "") -> None:
        """Fill the area between two lines over x."""
        self._include(x, low, high)
        key = rectangle(color, opacity)
        self._add(_BACK, lambda scale: area(scale, x, low, high, color, opacity), label, key)

    def zone(self, low: float, high: float, color: str, label: str = "") -> None:
        """Fill the area between two heights across the whole axes."""
        self.y.include([low, high])
        self._add(
            _BACK,
            lambda scale: rectangle(color, 1.0, 0.0, scale.y(high), scale.width, scale.y(low) - scale.y(high)),
            label,
            rectangle(color, 1.0),
        )

    def bars(
        self, left: Array, width: float, height: Array, color: str, opacity: float = 1.0, label: str = ""
    ) -> None:
        """Draw bars that stand on zero."""
        self._include(np.concatenate([left, left + width]), np.concatenate([height, [0.0]]))
        self.y.floor = 0.0

        def svg(scale: Scale) -> str:
            tops, bottom = scale.y(np.nan_to_num(height)), scale.y(0.0)
            lefts, wide = scale.x(left), scale.x(width) - scale.x(0.0)
            return "".join(
                rectangle(color, opacity, a, min(b, bottom), wide, abs(bottom - b))
                for a, b in zip(lefts, tops, strict=True)
            )

        self._add(_BACK, svg, label, rectangle(color, opacity))

    def sticks(self, x: Array, high: Array, color: str, width: float) -> None:
        """Draw a vertical line from zero at each x."""
        self._include(x, np.concatenate([high, [0.0]]))
        self._add(_MIDDLE, lambda scale: segments(scale, x, np.zeros(len(x)), x, high, color, width), "", "")

    def dashes(self, left: Array, right: Array, y: Array, color: str, width: float, label: str = "") -> None:
        """Draw short horizontal lines."""
        self._include(np.concatenate([left, right]), y)
        svg = lambda scale: segments(scale, left, y, right, y, color, width)  # noqa: E731
        self._add(_MIDDLE, svg, label, beam(color, width))

    def points(self, x: Array, y: Array, bar: Array, shape: str, color: str, label: str = "") -> None:
        """Draw measured points with bars of ± `bar`; `shape` is a letter of `shapes.SHAPES`."""
        self._include(x, y - bar, y + bar)

        def svg(scale: Scale) -> str:
            ends = zip(scale.x(x), scale.y(y), scale.y(y - bar), scale.y(y + bar), strict=True)
            return "".join(point(shape, color, *each) for each in ends)

        self._add(_FRONT, svg, label, point(shape, color, 6.4, 0.0, 4.0, -4.0))

    def _include(self, x: Values, *y: Values) -> None:
        self.x.include(x)
        self.y.include(*y)

    def _add(self, layer: int, svg: Callable[[Scale], str], label: str, key: str) -> None:
        self.marks.append(Mark(layer, svg, label, key))


class Aside(NamedTuple):
    """A short text in the margin below an arrow, centered at (x, y) in shares of the axes; `toward` is a step."""

    lines: tuple[str, ...]
    color: str
    x: float
    y: float
    toward: tuple[float, float]
