"""The units of the reader: what is written in kt, ft, °C and inHg, in the units that they read.

A number is translated as it is written, with its digits, so that no two voices of an answer differ
in a digit. Files of data keep the units of their keys.
"""

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from platformdirs import user_config_path

from pitotbench.catalog import explain
from pitotbench.records import BadInputError
from pitotbench.records.intake import read_toml
from pitotbench.show.columns import Column, with_minus_signs
from pitotbench.units import SUFFIXES, Suffix

_CHOICES = {  # by the field of `Units`: the suffix of each unit by the word that asks for it
    "speed": {"kt": "kt", "km/h": "kmh", "mph": "mph", "m/s": "mps"},
    "length": {"ft": "ft", "m": "m"},
    "temperature": {"degc": "degc", "degf": "degf"},
    "pressure": {"inhg": "inhg", "hpa": "hpa"},
}
_WRITTEN = {  # by the unit that a text is written in: the field of `Units`, and what follows a unit
    "kt": ("speed", ""), "KIAS": ("speed", " IAS"), "KCAS": ("speed", " CAS"),
    "KTAS": ("speed", " TAS"),
    "ft": ("length", ""), "°C": ("temperature", ""), "inHg": ("pressure", ""),
}  # fmt: skip
QUOTED = "\u00a0"  # between number and unit of a rule, which stands in its own units
_NONE = Suffix("", 1.0, "")
_ONE = r"[+\-−]?\d[\d,]*(?:\.\d+)?"
_NUMBERS = re.compile(
    rf"(?<![\w.,])((?:±?{_ONE}(?: ± | to | and |, ))*±?{_ONE}) ({'|'.join(_WRITTEN)})(?![\w/²])"
)


@dataclass(frozen=True, slots=True)
class Units:
    """The suffixes of the reader's units of speed, length, temperature and pressure.

    `source` says who chose them: `default`, `stated` or a file.
    """

    speed: str = "kt"
    length: str = "ft"
    temperature: str = "degc"
    pressure: str = "inhg"
    source: str = field(default="default", compare=False)

    @property
    def words(self) -> str:
        """The words that ask for these units."""
        own = {getattr(self, name): choices for name, choices in _CHOICES.items()}
        return ",".join(w for suffix, all_ in own.items() for w, s in all_.items() if s == suffix)

    def text(self, text: str) -> str:
        """Return a text written in kt, ft, °C and inHg as it is read in these units.

        A quoted rule keeps its own.
        """
        return with_minus_signs(_NUMBERS.sub(self._translated, text)).replace(QUOTED, " ")

    def columns(self, columns: Sequence[Column[Any]]) -> list[Column[Any]]:
        """The columns of a table in these units."""
        return [*columns] if self == BENCH else [self._column(each) for each in columns]

    def scale(self, unit: str) -> tuple[float, str]:
        """Return how many of the reader's units one of the bench's is, and the symbol.

        For other units the number is 1.
        """
        written, read, _ = self._units(unit)
        return written.factor / read.factor, read.symbol or unit

    def _units(self, unit: str) -> tuple[Suffix, Suffix, str]:
        """The unit that is written, the one that is read, and the words that follow it."""
        field, words = _WRITTEN.get(unit, ("", ""))
        written, read = (
            SUFFIXES[getattr(each, field)] if field else _NONE for each in (BENCH, self)
        )
        return written, read, words

    def _column(self, column: Column[Any]) -> Column[Any]:
        unit = next((each for each in (column.unit, column.heading) if each in _WRITTEN), "")
        written, read, _ = self._units(unit)

        def value(row: Any) -> str:
            text = column.text(row)
            number = re.fullmatch(_ONE, text) if unit else None
            return _number(text, written, read) if number else self.text(text)

        return replace(
            column,
            heading=_WRITTEN.get(column.heading, ("", ""))[1].strip() or self.text(column.heading),
            unit=read.symbol or column.unit,
            value=value,
            style=column.style and "s",
        )

    def _translated(self, found: "re.Match[str]") -> str:
        written, read, words = self._units(found[2])
        numbers = re.sub(_ONE, lambda each: _number(each[0], written, read), found[1])
        return found[0] if written is read else f"{numbers} {read.symbol}{words}"


def _number(text: str, written: Suffix, read: Suffix) -> str:
    """A number in another unit with its own decimals, and a sign where it had one."""
    plain = text.replace(",", "").replace("−", "-")
    value = (float(plain) + written.offset) * written.factor / read.factor - read.offset
    sign, comma = "+" * text.startswith("+"), "," * ("," in text)
    digits = len(plain.partition(".")[2])
    return f"{value:{sign}{comma}.{digits}f}"


BENCH = Units()


def reader_units(stated: str = "") -> Units:
    """Return the units that are stated, such as `km/h,m`, else the user's own.

    The user's own are on the line `units` of the configuration: `pitotbench.toml` in the folder of
    the system for it, or the file that the variable PITOTBENCH_CONFIG names. Raises BadInputError
    for words that are no units, and for a file that is not TOML.
    """
    path = Path(
        os.environ.get("PITOTBENCH_CONFIG")
        or (user_config_path() / "pitotbench").with_suffix(".toml")
    )
    if stated or not path.is_file():
        return replace(units_named(stated), source="stated" if stated else "default")
    try:
        found = read_toml(path, "the configuration")
        return replace(units_named(str(found.get("units", ""))), source=path.name)
    except (BadInputError, ValueError) as error:
        why = str(error).removeprefix(f"{path}: ")
        raise BadInputError(f'{path}: {why}; write units = "km/h,m", or delete it') from error


def units_named(text: str) -> Units:
    """The units that words with commas between them ask for, such as `km/h,m`.

    Raises BadInputError for a word that is none, and for two units of one kind.
    """
    found: dict[str, str] = {}
    for word in filter(None, text.lower().split(",")):
        place = next((name for name, choices in _CHOICES.items() if word in choices), None)
        if place is None:
            known = [each for choices in _CHOICES.values() for each in choices]
            raise BadInputError(f"--units: {explain('unit', word, known)}")
        if place in found:
            raise BadInputError(f"--units {text}: two units of {place}; give one")
        found[place] = _CHOICES[place][word]
    return Units(**found)
