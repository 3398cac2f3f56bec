"""The units of the reader: what is written in kt, ft, °C and inHg, in the units that he thinks in.

A number is translated as it is written, with its digits, so that no two voices of an answer differ
in a digit. Files of data keep the units of their keys.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from pitotbench.catalog import explain
from pitotbench.records import BadInputError
from pitotbench.show.columns import Column
from pitotbench.units import SUFFIXES, from_si, to_si

_CHOICES = {  # by the field of `Units`: the suffix of each unit by the word that asks for it
    "speed": {"kt": "kt", "km/h": "kmh", "mph": "mph"},
    "length": {"ft": "ft", "m": "m"},
    "temperature": {"degc": "degc", "degf": "degf"},
    "pressure": {"inhg": "inhg", "hpa": "hpa"},
}
WORDS = ",".join("|".join(each) for each in _CHOICES.values())
_WRITTEN = {  # by the unit that a text is written in: the field of `Units`, and what follows a unit
    "kt": ("speed", ""), "KIAS": ("speed", " IAS"), "KCAS": ("speed", " CAS"),
    "KTAS": ("speed", " TAS"),
    "ft": ("length", ""), "°C": ("temperature", ""), "inHg": ("pressure", ""),
}  # fmt: skip
_ONE = r"[+\-−]?\d[\d,]*(?:\.\d+)?"
_NUMBERS = re.compile(
    rf"(?<![\w.,])((?:±?{_ONE}(?: ± | to | and |, ))*±?{_ONE}) ({'|'.join(_WRITTEN)})(?![\w/²])"
)


@dataclass(frozen=True, slots=True)
class Units:
    """The suffixes of the reader's units of speed, length, temperature and pressure."""

    speed: str = "kt"
    length: str = "ft"
    temperature: str = "degc"
    pressure: str = "inhg"

    def text(self, text: str) -> str:
        """A text written in kt, ft, °C and inHg, in these units."""
        return text if self == BENCH else _NUMBERS.sub(self._translated, text)

    def column(self, column: Column[Any]) -> Column[Any]:
        """A column whose unit is one of the bench's, in these units."""
        known = next((u for u in (column.unit, column.heading) if u in _WRITTEN), None)
        if self == BENCH or known is None:
            return column
        field, _ = _WRITTEN[known]
        return replace(
            column,
            heading=_WRITTEN.get(column.heading, ("", ""))[1].strip() or self.text(column.heading),
            unit=SUFFIXES[getattr(self, field)].symbol,
            value=lambda row: self._number(column.text(row), known),
            style="s",
        )

    def columns(self, columns: Sequence[Column[Any]]) -> list[Column[Any]]:
        """The columns of a table in these units."""
        return [self.column(each) for each in columns]

    def scale(self, unit: str) -> tuple[float, str]:
        """How many of the reader's units one of the bench's is, and the symbol; of another unit 1."""
        if unit not in _WRITTEN or unit == "°C":  # a scale has no zero to move
            return 1.0, unit
        field, _ = _WRITTEN[unit]
        mine, theirs = (SUFFIXES[getattr(each, field)] for each in (BENCH, self))
        return mine.factor / theirs.factor, theirs.symbol

    def _translated(self, found: "re.Match[str]") -> str:
        field, more = _WRITTEN[found[2]]
        if getattr(self, field) == getattr(BENCH, field):
            return found[0]
        numbers = re.sub(_ONE, lambda each: self._number(each[0], found[2]), found[1])
        return f"{numbers} {SUFFIXES[getattr(self, field)].symbol}{more}"

    def _number(self, text: str, unit: str) -> str:
        """A written number in the reader's unit, with as many decimals, a sign where it had one."""
        field, _ = _WRITTEN[unit]
        if not re.fullmatch(_ONE, text):
            return text
        plain = text.replace(",", "").replace("−", "-")
        value = float(from_si(to_si(float(plain), getattr(BENCH, field)), getattr(self, field)))
        sign = "+" if plain[0] == "+" else ""
        group = "," if "," in text else ""
        written = f"{value:{sign}{group}.{len(plain.partition('.')[2])}f}"
        return written.replace("-", "−") if "−" in text else written


BENCH = Units()


def units_named(text: str) -> Units:
    """The units that words with commas between them ask for, such as `km/h,m`.

    Raises BadInputError for a word that is none, and for two units of one kind.
    """
    found: dict[str, str] = {}
    for word in filter(None, text.lower().split(",")):
        place = next((f.name for f in fields(Units) if word in _CHOICES[f.name]), None)
        if place is None:
            known = [each for choices in _CHOICES.values() for each in choices]
            raise BadInputError(f"--units: {explain('unit', word, known)}")
        if place in found:
            raise BadInputError(f"--units {text}: two units of {place}; give one")
        found[place] = _CHOICES[place][word]
    return Units(**found)
