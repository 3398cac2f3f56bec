"""SVG elements from data: lines, areas, bars and points. Positions are rounded to a tenth of a point."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pitotbench.units import Array

KEY_WIDTH = 12.8  # pt, of a legend's key
SHAPES = {
    "o": "M-2.2 0a2.2 2.2 0 1 0 4.4 0a2.2 2.2 0 1 0-4.4 0z",
    "s": "M-2.2-2.2h4.4v4.4h-4.4z",
    "^": "M0-2.2l2.2 4.4h-4.4z",
    "v": "M0 2.2l2.2-4.4h-4.4z",
    "D": "M0-3.2l3.2 3.2l-3.2 3.2l-3.2-3.2z",
}
_CAP = 2.5  # pt: half the length of the line at the end of an error bar


@dataclass(frozen=True, slots=True)
class Scale:
    """The axes' limits and size [pt]; x grows to the right, y to the top."""

    left: float
    right: float
    bottom: float
    top: float
    width: float
    height: float

    def x(self, value: Any) -> Any:
        """Return points from the left edge."""
        return (np.asarray(value) - self.left) * (self.width / (self.right - self.left))

    def y(self, value: Any) -> Any:
        """Return points from the top edge."""
        return (self.top - np.asarray(value)) * (self.height / (self.top - self.bottom))


def stroke(color: str, width: float, dash: tuple[float, ...] = ()) -> str:
    """The attributes of a line."""
    dashes = f' stroke-dasharray="{" ".join(f"{width * part:.3g}" for part in dash)}"' if dash else ""
    return f'fill="none" stroke="{color}" stroke-width="{width:g}"{dashes}'


def path(scale: Scale, x: Any, y: Any, color: str, width: float, dash: tuple[float, ...] = ()) -> str:
    """A line through points, broken where one is not a number."""
    across, down = scale.x(np.asarray(x, dtype=np.float64)), scale.y(np.asarray(y, dtype=np.float64))
    shown = np.isfinite(across) & np.isfinite(down)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], shown, [False]]).astype(np.int8)))
    runs = [_through(across[a:b], down[a:b]) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return f'<path d="{"".join(runs)}" {stroke(color, width, dash)}/>' if runs else ""


def _through(x: Array, y: Array) -> str:
    return "M" + " ".join(f"{a:.1f} {b:.1f}" for a, b in zip(x.tolist(), y.tolist(), strict=True))


def area(scale: Scale, x: Any, low: Any, high: Any, color: str, opacity: float) -> str:
    """The area between two lines; either may be one number."""
    x = np.asarray(x, dtype=np.float64)
    ends = [np.broadcast_to(np.asarray(edge, dtype=np.float64), x.shape) for edge in (low, high)]
    across = scale.x(np.concatenate([x, x[::-1]]))
    down = scale.y(np.concatenate([ends[0], ends[1][::-1]]))
    return f'<path d="{_through(across, down)}z" fill="{color}" fill-opacity="{opacity:g}"/>'


def segments(scale: Scale, x0: Any, y0: Any, x1: Any, y1: Any, color: str, width: float) -> str:
    """Straight lines, each from one point to another."""
    ends = zip(scale.x(x0), scale.y(y0), scale.x(x1), scale.y(y1), strict=True)
    lines = "".join(f"M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}" for a, b, c, d in ends if np.isfinite(a + b + c + d))
    return f'<path d="{lines}" {stroke(color, width)}/>'


def rectangle(
    color: str, opacity: float, x: float = 0.0, y: float = -2.8, width: float = KEY_WIDTH, height: float = 5.6
) -> str:
    """A filled rectangle; by default the key of an area in a legend."""
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    return f'<rect {place} fill="{color}" fill-opacity="{opacity:g}"/>'


def beam(color: str, width: float, dash: tuple[float, ...] = ()) -> str:
    """The key of a line in a legend."""
    return f'<path d="M0 0h{KEY_WIDTH}" {stroke(color, width, dash)}/>'


def point(shape: str, color: str, x: float, y: float, low: float, high: float) -> str:
    """A measured point with its error bar from `low` to `high` [pt]."""
    ends = "".join(f"M{x - _CAP:.1f} {end:.1f}h{2.0 * _CAP:g}" for end in (low, high))
    bar = f'<path d="M{x:.1f} {low:.1f}V{high:.1f}{ends}" {stroke(color, 1.0)}/>'
    return f'{bar}<path transform="translate({x:.1f} {y:.1f})" d="{SHAPES[shape]}" fill="white" stroke="{color}"/>'
