"""Guess what a foreign column is: by its name, its unit, and whether its values could be that quantity's."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

import numpy as np

from pitotbench.channels import Channel
from pitotbench.logbook.clock import is_clock
from pitotbench.logbook.drafting.synonyms import ANGLES, RATES, SCALED, SYNONYMS, UNIT_WORDS, USUAL_UNITS
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.logbook.table import Column
from pitotbench.units import Array, to_si

_BRACKETS = re.compile(r"[\[({]([^\])}]*)[\])}]")
# Words that say which box measured, or in which axes; without them a name is the quantity's.
_SYSTEMS = frozenset(
    [
        "gps",
        "gnss",
        "adc",
        "dadc",
        "ins",
        "imu",
        "ahrs",
        "ekf",
        "egi",
        "gin",
        "ned",
        "air",
        "data",
        "sensor",
        "primary",
        "true",
        "efis",
        "fms",
        "0",
        "1",
        "2",
    ]
)
_IN_KNOTS = frozenset(("kias", "kcas", "ktgs", "kgs"))
_FASTEST = 2e-3  # s between rows: 500 Hz; a clock that seems faster is in another unit
_EXACT, _PART, _NEAR = 1.0, 0.8, 0.6
_SIMILAR = 0.86  # share of equal letters at which a name counts as misspelled


@dataclass(frozen=True, slots=True)
class Guess:
    """What a column may be: our quantity, the units that are possible (the likeliest first), and how well the name
    fits, 0 to 1. `stated` says that the unit is written in the file. `factor` turns the number into the unit's."""

    theirs: str
    quantity: str
    units: tuple[str, ...]
    score: float
    stated: bool
    factor: float = 1.0

    def target(self, unit: str | None = None) -> str:
        """Return our column name, with the likeliest unit or another one."""
        suffix = self.units[0] if unit is None else unit
        return f"{self.quantity}_{suffix}" if suffix else self.quantity


def guesses(name: str, unit: str, column: Column) -> list[Guess]:
    """Return what a column may be, the best first; nothing for a column that fits no quantity.

    `unit` is what the file states beside the names, or empty.
    """
    if is_clock(column):
        return [Guess(name, "time", ("s",), _EXACT, True)]
    values = _numbers(column)
    if values is None:
        return [Guess(name, "date", ("",), _EXACT, True)] if _plain(name) in SYNONYMS["date"].split() else []
    words, written = _words(name, unit)
    found = _fitting(name, words, written, values)
    if not found and written and not unit and not _BRACKETS.search(name):
        # The last word of the name may be no unit after all: TAT_DI_R is right of the nose, not in °R.
        found = _fitting(name, [*words, *written.split("/")], "", values)
    return sorted(found, key=lambda guess: -guess.score)


def _fitting(name: str, words: Sequence[str], written: str, values: Array) -> list[Guess]:
    """Return the guesses for words of a name with a unit, each with the units in which the values are plausible."""
    found = []
    for quantity, names in SYNONYMS.items():
        score, sign = _score(words, names.split())
        if score > 0.0 and quantity != "date":
            found += _with_units(name, QUANTITIES[quantity], score, sign, written, values)
    return found


def _with_units(
    name: str, quantity: Channel, score: float, sign: float, written: str, values: Array
) -> list[Guess]:
    """Return the guess with the units in which the values are plausible; none where there is no such unit."""
    if written in SCALED and SCALED[written][0] in quantity.suffixes:
        suffix, factor = SCALED[written]
        return [Guess(name, quantity.name, (suffix,), score, True, sign * factor)]
    stated = next((s for s in quantity.suffixes if written in UNIT_WORDS.get(s, "").split()), None)
    if stated is not None:
        return (
            [Guess(name, quantity.name, (stated,), score, True, sign)]
            if _plausible(quantity, values, stated)
            else []
        )
    if written:
        return []  # the unit of another kind of quantity
    usual = USUAL_UNITS.get(quantity.name) or (ANGLES if "rad" in quantity.suffixes else RATES)
    possible = tuple(s for s in usual if s in quantity.suffixes and _plausible(quantity, values, s))
    return [Guess(name, quantity.name, possible, score, False, sign)] if possible else []


def _plausible(quantity: Channel, values: Array, suffix: str) -> bool:
    """Return whether most values in a unit are those of an airplane in flight."""
    known = values[np.isfinite(values)]
    if quantity.name == "time":
        return len(known) > 1 and bool(np.mean(np.diff(known) > 0.0) > 0.9) and _rate_fits(known, suffix)
    if len(known) < 2:
        return False
    low, high = _RANGES.get(quantity.name, (quantity.low, quantity.high))
    size = np.abs(to_si(known, suffix))
    return bool(low <= np.quantile(size, 0.7) and np.quantile(size, 0.95) <= high)


def _rate_fits(time: Array, suffix: str) -> bool:
    return _FASTEST <= float(to_si(float(np.median(np.diff(time))), suffix)) <= 10.0


# Narrower than what a log may hold: the ranges of usual flights tell the units apart.
_RANGES = {
    "static_pressure": (15e3, 108e3),
    "total_pressure": (15e3, 140e3),
    "impact_pressure": (30.0, 60e3),
    "indicated_airspeed": (7.0, 330.0),
    "calibrated_airspeed": (7.0, 330.0),
    "ground_speed": (7.0, 400.0),
    "altimeter_setting": (90e3, 108e3),
    "air_temperature": (205.0, 325.0),
    "total_temperature": (215.0, 380.0),
    "pressure_altitude": (0.0, 18e3),
    "altitude": (0.0, 20e3),
}


def _numbers(column: Column) -> Array | None:
    if column.dtype.kind in "fiu":
        return np.asarray(column, dtype=np.float64)
    if column.dtype.kind not in "OU":
        return None
    cells = [str(cell).strip() if cell is not None else "" for cell in column[:400]]
    try:
        values = np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return None
    return values if np.isfinite(values).any() else None


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9°/^.-]", "", name.lower())


def _words(name: str, unit: str) -> tuple[list[str], str]:
    """Return the words of a name without its unit, and the unit in lower case without blanks."""
    bracket = _BRACKETS.search(name)
    written = re.sub(r"\s", "", (unit or (bracket[1] if bracket else "")).lower()).strip("()[]")
    bare = _BRACKETS.sub(" ", name)
    tokens = [token for token in re.split(r"[^A-Za-z0-9°]+", bare) if token]
    words = [word for token in tokens for word in _parts(token)]
    if not written and len(words) > 1:
        for count in (2, 1):  # ft_min before min
            tail = ("/" if count == 2 else "").join(words[-count:])
            if len(words) > count and _is_unit(tail):
                return words[:-count], tail
    if written and len(words) > 1 and _is_unit(words[-1]):
        words = words[:-1]
    if not written and _IN_KNOTS & set(words):
        return words, "kt"
    return words, written if _is_unit(written) else ""


def _parts(token: str) -> list[str]:
    """Return the words that capitals separate, in lower case: `GndSpd` has two; `hPa` is one unit."""
    if _is_unit(token.lower()):
        return [token.lower()]
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", token).lower().split()


def _is_unit(word: str) -> bool:
    return word in SCALED or any(word in known.split() for known in UNIT_WORDS.values())


def _score(words: Sequence[str], names: Sequence[str]) -> tuple[float, float]:
    """Return how well words fit one of the names of a quantity, and the sign with which it counts."""
    whole = "".join(words)
    core = "".join(word for word in words if word not in _SYSTEMS)
    best, sign = 0.0, 1.0
    for rank, name in enumerate(names):
        plain = name.removeprefix("-")
        if whole == plain:
            score = _EXACT - 0.001 * rank
        elif core == plain or (len(plain) > 2 and plain in words):
            score = _PART - 0.001 * rank + 0.01 * len(plain) / len(whole)
        elif len(plain) > 4 and SequenceMatcher(None, core, plain).ratio() >= _SIMILAR:
            score = _NEAR - 0.001 * rank
        else:
            continue
        if score > best:
            best, sign = score, -1.0 if name.startswith("-") else 1.0
    return best, sign
