"""Guess what a column is by its name, its unit and its values."""

import re
from collections.abc import Sequence
from contextlib import suppress
from difflib import SequenceMatcher

import numpy as np

from pitotbench.channels import Channel
from pitotbench.logbook.columns import QUANTITIES, Column, almost_numbers, clock_seconds, is_clock
from pitotbench.logbook.guess import Guess
from pitotbench.logbook.synonyms import (
    ANGLES,
    AS_INTEGERS,
    RATES,
    SCALED,
    SYNONYMS,
    UNIT_WORDS,
    USUAL_UNITS,
)
from pitotbench.records import BadInputError
from pitotbench.units import Array, to_si

# A unit stands in brackets, or behind a semicolon; braces after `_` are a subscript: V_{North}.
_BRACKETS = re.compile(r"(?:(?<!_)[\[({]|;)([^\])}]*)(?:[\])}]|$)")
# Words that say which box measured, or in which axes; without them a name is the quantity's.
_SYSTEMS = frozenset((
    "gps", "gnss", "adc", "dadc", "ins", "imu", "ahrs", "ekf", "egi", "gin", "ned", "air", "data", "sensor",
    "primary", "true", "efis", "fms", "0", "1", "2",
))  # fmt: skip
_COUNTED = _SYSTEMS | {"ias", "kias", "cas", "kcas", "airspeed", "aspd"}
# Words of what is set, wanted or estimated, not measured on the airplane, or of what no log needs.
_NOT_MEASURED = frozenset((
    "sel", "selected", "target", "cmd", "command", "commanded", "desired", "bug", "setpoint", "error", "err",
    "sigma", "max", "min", "innov", "innovation", "innovations", "wind", "wnd",
    "acc", "accel", "acceleration",
))  # fmt: skip
# Words of a temperature that is that of a box, an engine or a cabin, or of a number of satellites.
_OF_A_BOX = frozenset((
    "internal", "int", "imu", "gyro", "baro", "board", "cpu", "mcu", "fc", "esc", "motor", "mag",
    "battery", "batt", "bat", "engine", "eng", "oil", "cht", "egt", "coolant", "water", "cabin",
    "num", "sats", "nsat", "satellites", "fet",
))  # fmt: skip
_OF_A_PITOT = frozenset(("differential", "diff", "dynamic", "dyn", "total", "pitot", "impact"))
# Units of what no flight log holds: of a magnetic field, a voltage, a current.
_OTHER_UNITS = re.compile(
    r"[(\[ _](µt|μt|ut|mgauss|gauss|mv|volts?|v|ma|mah|amps?|hz|db|dbm)[)\]]?$", re.I
)
_BY_PRESSURE = frozenset(("adc", "dadc", "baro", "bc", "press", "pressure"))  # no height by GPS
_IN_KNOTS = frozenset(("kias", "kcas", "ktas", "ktgs", "kgs"))
_FASTEST = 2e-3  # s between rows: 500 Hz; a clock that seems faster is in another unit
_SLOWEST = 10.0  # s between rows
_FEW_REPEATS = 0.01  # share of stamps that an even clock may repeat now and then
EXACT = 1.0  # score of a guess by a whole name
_PART = 0.8  # by a word of the name
_NEAR = 0.6  # by a misspelled word
_SIMILAR = 0.86  # share of equal letters at which a name counts as misspelled


def guesses(name: str, unit: str, column: Column) -> list[Guess]:
    """Return what a column may be, the best first; nothing for a column that fits no quantity.

    `unit` is what the file states next to the names, or empty.
    """
    if is_clock(column):
        score = 0.0
        with suppress(BadInputError):
            score = EXACT + _evenness(clock_seconds(name, column))
        return [Guess(name, "time", ("s",), score, True)] if score > 0.0 else _date(name)
    values = almost_numbers(column)
    if values is None:
        return _date(name)
    words, written = name_and_unit(name, unit)
    found = _fitting(name, words, written, values)
    known = any(_score(words, names.split())[0] > _PART + 0.1 for names in SYNONYMS.values())
    if not found and written and not unit and not known and not _BRACKETS.search(name):
        # The last word of the name may be no unit after all: TAT_DI_R is right of the nose, not in
        # °R.
        found = _fitting(name, [*words, *written.split("/")], "", values)
    return sorted(found, key=lambda guess: -guess.score)


def _date(name: str) -> list[Guess]:
    return (
        [Guess(name, "date", ("",), EXACT, True)]
        if re.sub(r"[^a-z0-9°/^.-]", "", name.lower()) in SYNONYMS["date"].split()
        else []
    )


def _evenness(time: Array) -> float:
    """Return what a clock gains or loses in score.

    The log's clock never repeats and never runs back.
    """
    steps = np.diff(time[np.isfinite(time)])
    if not len(steps) or np.any(steps < 0.0) or not np.any(steps > 0.0):
        return -EXACT
    repeats = float(np.mean(steps == 0.0))
    return 0.05 if repeats == 0.0 else -0.3 if repeats > _FEW_REPEATS else 0.0


def _fitting(name: str, words: Sequence[str], written: str, values: Array) -> list[Guess]:
    """Return the guesses for words of a name with the units that make its values plausible."""
    found: list[Guess] = []
    if _NOT_MEASURED & set(words) or list(words) == ["rate"] or _OTHER_UNITS.search(name):
        return found
    for quantity, names in SYNONYMS.items():
        score, sign = _score(words, names.split())
        if ("rate" in words and "rate" not in quantity) or (
            quantity == "altitude" and _BY_PRESSURE & set(words)
        ):
            continue
        if quantity.endswith("_temperature") and _OF_A_BOX & set(words):
            continue
        if quantity == "static_pressure" and _OF_A_PITOT & set(words):
            continue
        if score > 0.0 and quantity == "time":
            score = max(0.0, score + _evenness(values))
        if score > 0.0 and quantity != "date":
            found += with_units(name, QUANTITIES[quantity], score, sign, written, values)
    return found


def with_units(
    name: str, quantity: Channel, score: float, sign: float, written: str, values: Array
) -> list[Guess]:
    """Return the guess with the units in which the values are plausible, [] where none is."""
    if written in SCALED and SCALED[written][0] in quantity.suffixes:
        suffix, factor = SCALED[written]
        return [Guess(name, quantity.name, (suffix,), score, True, sign * factor)]
    stated = next((s for s in quantity.suffixes if written in UNIT_WORDS.get(s, ())), None)
    if stated is None and written:
        return []  # the unit of another kind of quantity
    if stated is not None or not quantity.unit:
        unit = stated or ""
        return (
            [Guess(name, quantity.name, (unit,), score, True, sign)]
            if _plausible(quantity, values, unit)
            else []
        )
    usual = USUAL_UNITS.get(quantity.name) or (ANGLES if "rad" in quantity.suffixes else RATES)
    possible = tuple(s for s in usual if s in quantity.suffixes and _plausible(quantity, values, s))
    suffix, factor = AS_INTEGERS.get(quantity.name, ("", 0.0))
    if not possible and factor and _plausible(quantity, factor * values, suffix):
        return [Guess(name, quantity.name, (suffix,), score, False, sign * factor)]
    return [Guess(name, quantity.name, possible, score, False, sign)] if possible else []


def _plausible(quantity: Channel, values: Array, suffix: str) -> bool:
    """Return whether most values in a unit are those of an airplane in flight."""
    known = values[np.isfinite(values)]
    if quantity.name == "time":
        return (
            len(known) > 1
            and bool(np.mean(np.diff(known) > 0.0) > 0.9)
            and _FASTEST <= float(to_si(float(np.median(np.diff(known))), suffix)) <= _SLOWEST
        )
    if len(known) < 2:
        return False
    low, high = _RANGES.get(quantity.name, (quantity.low, quantity.high))
    size = np.abs(to_si(known, suffix) if suffix else known)
    # A setting is turned by hand: what changes all the time is the pressure itself.
    return bool(
        (quantity.name != "altimeter_setting" or len(np.unique(known)) < _MOST_SET * len(known))
        and low <= np.quantile(size, 0.7)
        and np.quantile(size, 0.95) <= high
    )


_MOST_SET = 0.2  # of the rows, with a setting of the altimeter of their own
# Narrower than what a log may hold: the ranges of usual flights distinguish the units.
_RANGES = {
    "static_pressure": (15e3, 108e3),
    "total_pressure": (15e3, 140e3),
    "impact_pressure": (30.0, 60e3),
    "indicated_airspeed": (10.3, 330.0),  # from 20 kt: slower rows serve no calibration
    "calibrated_airspeed": (7.0, 330.0),
    "ground_speed": (7.0, 400.0),
    "true_airspeed": (7.0, 400.0),
    "mach": (0.03, 1.0),
    "altimeter_setting": (90e3, 108e3),
    "air_temperature": (205.0, 325.0),
    "total_temperature": (215.0, 380.0),
    "pressure_altitude": (0.0, 18e3),
    "altitude": (0.0, 20e3),
}
_LONGEST_NAME = 200  # letters: an open quotation mark makes a name of the rest of the file


def name_and_unit(name: str, unit: str = "") -> tuple[list[str], str]:
    """Return the words of a name without its unit, and the unit in lower case without blanks."""
    name = name[:_LONGEST_NAME]
    name = name.rpartition("/")[2] if name.startswith("/") else name  # a property in its tree
    bracket = _BRACKETS.search(name)
    below = re.sub(r"\s", "", unit.lower()).strip("()[]")
    within = re.sub(r"\s", "", bracket[1].lower()) if bracket else ""
    # Below the names may stand units, or the names in another form.
    written = below if below and (_is_unit(below) or below in _REFERENCES or not within) else within
    bare = written if written in _IN_KNOTS else _BRACKETS.sub(" ", name)  # "Airspeed (KCAS)"
    for mark, (reference, stated) in _REFERENCES.items():
        # "Course (T)": true; the letters stand for no tesla and, beside an angle, for no meter.
        if written == mark and (mark != "m" or _ANGLE_WORDS & set(_plain_words(bare))):
            bare, written = f"{bare} {reference}", stated
    words = _plain_words(bare)
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


_REFERENCES = {
    "t": ("true", ""), "true": ("true", ""), "m": ("mag", ""), "mag": ("mag", ""), "magnetic": ("mag", ""),
    "°t": ("true", "deg"), "°m": ("mag", "deg"), "degt": ("true", "deg"), "degm": ("mag", "deg"),
    "degtrue": ("true", "deg"), "degmag": ("mag", "deg"), "degrees_true": ("true", "deg"),
}  # fmt: skip
_ANGLE_WORDS = frozenset(("course", "track", "trk", "heading", "hdg", "cog"))


def _plain_words(text: str) -> list[str]:
    words = [part for token in re.split(r"[^A-Za-z0-9°]+", text) if token for part in _parts(token)]
    # The second box of a kind is of that kind, and so is what it shows: dadc2, IAS2.
    return [bare if (bare := word.rstrip("0123456789")) in _COUNTED else word for word in words]


def _parts(token: str) -> list[str]:
    """Return the words that capitals separate, in lower case: two of `GndSpd`, one of `hPa`."""
    if _is_unit(token.lower()):
        return [token.lower()]
    return re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", token).lower().split()


def _is_unit(word: str) -> bool:
    return word in SCALED or any(word in known for known in UNIT_WORDS.values())


def _score(words: Sequence[str], names: Sequence[str]) -> tuple[float, float]:
    """Return how well words fit one of a quantity's names, and the sign with which it counts."""
    whole = "".join(words)
    core = "".join(word for word in words if word not in _SYSTEMS)
    # A box may stand before what it measures: `HSDB_diff_press`.
    ends = {*words, *("".join(words[place:]) for place in range(len(words)))}
    best, sign = 0.0, 1.0
    for rank, name in enumerate(names):
        plain = name.removeprefix("-")
        if whole == plain:
            score = EXACT - 0.001 * rank
        elif core == plain or (len(plain) > 2 and plain in ends):
            score = _PART - 0.001 * rank + 0.01 * len(plain) / len(whole)
        elif (
            core != "attitude"  # no misspelled altitude
            and len(plain) > 4
            # The shorter word bounds what they share; to match letters takes far longer.
            and 2 * min(len(core), len(plain)) >= _SIMILAR * (len(core) + len(plain))
            and SequenceMatcher(None, core, plain).ratio() >= _SIMILAR
        ):
            score = _NEAR - 0.001 * rank
        else:
            continue
        if score > best:
            best, sign = score, -1.0 if name.startswith("-") else 1.0
    return best, sign
