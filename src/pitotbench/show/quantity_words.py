"""Names of the code as words: `drag_area_m2` is a drag area in m²."""

from collections.abc import Sequence
from math import floor, log10

UNITS = {
    "_m2": "m²",
    "_mps2": "m/s²",
    "_mps": "m/s",
    "_pa": "Pa",
    "_inhg": "inHg",
    "_kt": "kt",
    "_kg": "kg",
    "_m": "m",
    "_min": "min",
    "_s": "s",
    "_k": "K",
    "_deg": "°",
    "_rad": "rad",
    "_hz": "Hz",
    "_radps": "rad/s",
    "_degps": "°/s",
    "_rpm": "rpm",
    "_pph": "lb/h",
    "_ft": "ft",
    "_km": "km",
    "_rad2": "rad²",
    "_kgps": "kg/s",
}
_DIGITS = 3  # of a size, significant
_PLAIN_BELOW = 1e7
_TURNS = "turns"  # in full circles


_INITIALS = {"gps": "GPS"}  # words that are written in capitals


def words(name: str) -> str:
    """A name of the code, or a sentence with such names, as words."""
    return " ".join(_INITIALS.get(word, word) for word in name.replace("_", " ").split(" "))


def heading(name: str) -> str:
    """A name of the code as words, with a capital at its start: `GPS latency`, `Drag area`."""
    text = words(name)
    return text[:1].upper() + text[1:]


def unit_words(suffix: str) -> str:
    """The unit of a suffix without its line: `m/s²` for `mps2`; a suffix that is not known stays as it is."""
    return UNITS.get(f"_{suffix}", suffix)


def name_and_unit(name: str) -> tuple[str, str]:
    """The name without its suffix as words, and the unit of the suffix, empty for a bare number.

    Of a rate such as `shift_pa_per_k` the unit is `Pa per K`.
    """
    first, _, last = name.rpartition("_per_")
    if first and f"_{last}" in UNITS:
        noun, unit = name_and_unit(first)
        return noun, f"{unit} per {unit_words(last)}".lstrip()
    suffix = max((s for s in UNITS if name.endswith(s)), key=len, default="")
    return words(name.removesuffix(suffix)), UNITS.get(suffix, "")


def size_words(name: str, value: float, bound: float | None = None) -> str:
    """A size with its ±2σ bound and its unit: `drag area 0.12 ± 0.01 m²`."""
    noun, unit = name_and_unit(name)
    if bound is None:
        return f"{noun} {with_unit(_number(value, _DIGITS), unit)}"
    digits = _DIGITS
    if 0.0 < bound < abs(value):  # all digits that the bound leaves
        digits = max(digits, floor(log10(abs(value))) - floor(log10(bound)) + 1)
    return f"{noun} {with_unit(f'{_number(value, digits)} ± {_number(bound, 2)}', unit)}"


def _number(value: float, digits: int) -> str:
    """A number with significant digits, and no power of ten below `_PLAIN_BELOW`."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < _PLAIN_BELOW else text


def entry_words(name: str, value: float | Sequence[float]) -> str:
    """An entry of a card as a pilot reads it: `speeds 160, 128, 100 kt`, `turns 223°, 529°`."""
    noun, unit = name_and_unit(name)
    values = value if isinstance(value, Sequence) else [value]
    if name == _TURNS:
        return f"{noun} {', '.join(f'{360.0 * circles:.0f}°' for circles in values)}"
    return f"{noun} {with_unit(', '.join(f'{number:.3g}' for number in values), unit)}"


def listed(items: Sequence[str], word: str = "and") -> str:
    """One item, or several with commas between them and a word before the last."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {word} {items[-1]}"


def with_unit(number: str, unit: str) -> str:
    """A number with its unit; the degree sign of an angle follows without a space."""
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()
