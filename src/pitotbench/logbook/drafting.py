"""Draft a mapping for a log whose columns have unknown names."""

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from functools import partial
from itertools import islice, product

import numpy as np
import tomli_w

from pitotbench import air
from pitotbench.channels import Channel
from pitotbench.logbook.assembly import log_of
from pitotbench.logbook.behavior import judged
from pitotbench.logbook.checks import check_broken, check_broken_in_sound_velocities
from pitotbench.logbook.columns import (
    HEIGHT,
    QUANTITIES,
    Column,
    Table,
    almost_numbers,
    clock_seconds,
    is_clock,
    parse_column,
)
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.guess import Guess
from pitotbench.logbook.joining import first_of_each, rename
from pitotbench.logbook.mapping import MappedFile, Renamed
from pitotbench.logbook.sensors import AIRSPEEDS
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
from pitotbench.records.log import GUESSED, UNITS_BY
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
_EXACT = 1.0  # score of a guess by a whole name
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
            score = _EXACT + _evenness(clock_seconds(name, column))
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
        [Guess(name, "date", ("",), _EXACT, True)]
        if re.sub(r"[^a-z0-9°/^.-]", "", name.lower()) in SYNONYMS["date"].split()
        else []
    )


def _evenness(time: Array) -> float:
    """Return what a clock gains or loses in score.

    One that never repeats and never runs back is the log's.
    """
    steps = np.diff(time[np.isfinite(time)])
    if not len(steps) or np.any(steps < 0.0) or not np.any(steps > 0.0):
        return -_EXACT
    repeats = float(np.mean(steps == 0.0))
    return 0.05 if repeats == 0.0 else -0.3 if repeats > _FEW_REPEATS else 0.0


def _fitting(name: str, words: Sequence[str], written: str, values: Array) -> list[Guess]:
    """Return the guesses for words of a name with a unit.

    Each has the units in which the values are plausible.
    """
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
            found += _with_units(name, QUANTITIES[quantity], score, sign, written, values)
    return found


def _with_units(
    name: str, quantity: Channel, score: float, sign: float, written: str, values: Array
) -> list[Guess]:
    """Return the guess with the units in which the values are plausible.

    There is none where no unit is.
    """
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
    return bool(low <= np.quantile(size, 0.7) and np.quantile(size, 0.95) <= high)


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
    """Return the words that capitals separate, in lower case: `GndSpd` has two; `hPa` is one unit."""
    if _is_unit(token.lower()):
        return [token.lower()]
    return re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", " ", token).lower().split()


def _is_unit(word: str) -> bool:
    return word in SCALED or any(word in known for known in UNIT_WORDS.values())


def _score(words: Sequence[str], names: Sequence[str]) -> tuple[float, float]:
    """Return how well words fit one of the names of a quantity, and the sign with which it counts."""
    whole = "".join(words)
    core = "".join(word for word in words if word not in _SYSTEMS)
    # A box may stand before what it measures: `HSDB_diff_press`.
    ends = {*words, *("".join(words[place:]) for place in range(len(words)))}
    best, sign = 0.0, 1.0
    for rank, name in enumerate(names):
        plain = name.removeprefix("-")
        if whole == plain:
            score = _EXACT - 0.001 * rank
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


_AIRSPEED_AGREES = 0.05  # of the airspeed: a display shows the impact pressure of its own source
_HEIGHT_AGREES = 250.0  # m, more than a static source errs; a unit errs by kilometers
_PAIRS: tuple[tuple[str, tuple[str, ...], Callable[[Array], Array]], ...] = (
    (
        "impact_pressure",
        ("indicated_airspeed", "calibrated_airspeed"),
        lambda q: air.calibrated_airspeed(q),
    ),
    ("static_pressure", ("pressure_altitude",), lambda p: air.pressure_altitude(p)),
)


def agreed(table: Table, chosen: Sequence[Guess]) -> list[Guess]:
    """Return the guesses, with the units of pressures that agree with a display.

    A pressure that agrees in no unit is left out, because a raw or a smoothed count looks like one.

    An airspeed and an impact pressure, or a height and a static pressure, say the same in two ways.
    Where both are there, the one that needs no unit by guess tells the unit of the other.
    """
    by_quantity = {guess.quantity: guess for guess in chosen}
    result = list(chosen)
    for pressure, displays, converted in _PAIRS:
        shown = next((by_quantity[name] for name in displays if name in by_quantity), None)
        guess = by_quantity.get(pressure)
        if shown is None or guess is None:
            continue
        fits = [unit for unit in guess.units if _close(table, guess, unit, shown, converted)]
        result.remove(guess)
        result += [replace(guess, units=(unit,), stated=True) for unit in fits[:1]]
    return [guess for guess in result if guess.units]


def _close(
    table: Table, guess: Guess, unit: str, shown: Guess, converted: Callable[[Array], Array]
) -> bool:
    """Return whether a pressure in a unit agrees with a display in one of its possible units."""
    with np.errstate(all="ignore"):
        expected = converted(replace(guess, units=(unit,)).values(table))
    written = (replace(shown, units=(each,)).values(table) for each in shown.units)
    return any(_near(expected, each, guess.quantity) for each in written)


def _near(one: Array, other: Array, pressure: str) -> bool:
    known = np.isfinite(one) & np.isfinite(other)
    if pressure == "impact_pressure":
        known &= other > 0.5 * float(np.nanmax(other, initial=0.0))
    if not known.any():
        return False
    difference = float(np.median(np.abs(one[known] - other[known])))
    if pressure == "impact_pressure":
        return difference < _AIRSPEED_AGREES * float(np.median(other[known]))
    return difference < _HEIGHT_AGREES


_ROWS = 2000  # of a long log that are tried
_MOST_TRIALS = 48  # of units on the whole log: a second or two
_MOST_COLUMNS = 1000  # of a log that is drafted: more would take minutes
_SURE = 0.7  # score of a name above which it is the field's own
_HEIGHTS = ("static_pressure", "pressure_altitude", "indicated_altitude", "height_above_takeoff")
NEEDED = (
    ("time",),
    (
        "impact_pressure",
        "total_pressure",
        "indicated_airspeed",
        "calibrated_airspeed",
        "mach",
        "true_airspeed",
    ),
    _HEIGHTS,
    ("velocity_north", "ground_speed", "latitude"),
    ("velocity_east", "track", "magnetic_track", "longitude"),
)
_SUPERSEDED = {  # a quantity that is not needed where others are there
    "indicated_airspeed": ("impact_pressure", "total_pressure"),
    "calibrated_airspeed": ("impact_pressure", "total_pressure", "indicated_airspeed"),
    "mach": AIRSPEEDS,
    "true_airspeed": (*AIRSPEEDS, "mach"),
    "pressure_altitude": ("static_pressure",),
    "indicated_altitude": ("static_pressure", "pressure_altitude"),
    "height_above_takeoff": ("static_pressure", "pressure_altitude", "indicated_altitude"),
    "altimeter_setting": ("static_pressure", "pressure_altitude"),
    "ground_speed": ("velocity_north",),
    "track": ("velocity_east",),
    "magnetic_track": ("velocity_east", "track"),
    "total_pressure": ("impact_pressure",),
    "air_temperature": ("total_temperature",),
}


@dataclass(frozen=True, slots=True)
class DraftedLine:
    """A line of the mapping: the guess, and the question to ask where it is not sure."""

    guess: Guess
    question: str = ""


@dataclass(frozen=True, slots=True)
class DraftedMapping:
    """The lines of a drafted mapping, and what it lacks.

    `missing` are the needed quantities for which no column was found, and `unused` the columns that
    are left over, with what each holds, its range and its step, in `ranges`. `refusal` is what the
    reader says of the log with it: empty, or a refusal.
    """

    lines: tuple[DraftedLine, ...]
    missing: tuple[str, ...]
    unused: tuple[str, ...]
    refusal: str
    ranges: tuple[str, ...] = ()

    @property
    def sure(self) -> bool:
        """Whether the mapping can be used as it is."""
        return not self.unusable and not any(line.question for line in self.lines)

    @property
    def unusable(self) -> bool:
        """Whether the mapping cannot work as it is.

        It lacks something essential, or the log is refused with it.
        """
        return bool(self.missing or self.refusal)


def draft_mapping(table: Table) -> DraftedMapping:
    """Return a mapping for a table, as far as its columns can be recognized.

    Each column goes to the quantity that its name fits best. Where the file does not state a unit,
    the units in which the values are possible are tried on the whole log: airspeed and ground
    speed, height and pressure have to agree.

    Raises BadInputError for a table of more than 1,000 columns, which would take minutes.
    """
    if len(table.names) > _MOST_COLUMNS:
        raise BadInputError(
            f"the log has {len(table.names):,} columns; a mapping is drafted for at most "
            f"{_MOST_COLUMNS:,}: keep those of air data and GPS"
        )
    table = first_of_each(table)
    columns = (
        column if column.dtype.kind != "O" or (found := almost_numbers(column)) is None else found
        for column in table.columns
    )
    table = replace(table, columns=tuple(columns))
    stated = table.units or ("",) * len(table.names)
    turns = _quaternions(table)
    offered = [
        [Guess(name, turns[name], ("",), _EXACT, True)]
        if name in turns
        else guesses(name, unit, column)
        for name, unit, column in zip(table.names, stated, table.columns, strict=True)
    ]
    chosen = _without_superseded(table, agreed(table, judged(table, _one_each(offered))))
    lacking = _missing(table, chosen)
    chosen = _like_the_airspeed(table, chosen)
    fitted, refusal = (chosen, "") if lacking else _fit_units(table, chosen)
    fitted = judged(table, fitted)  # now that more units are known
    by_quantity = {guess.quantity: guess.theirs for guess in fitted}
    lines = (
        *(
            DraftedLine(guess, _question(guess, _rivals(guess, offered, fitted), by_quantity))
            for guess in fitted
        ),
        *_more_sensors(fitted, offered),
    )
    if not refusal and not lacking:
        refusal, _ = _trial(table, fitted)
    used = {line.guess.theirs for line in lines}
    unused = tuple(name for name in table.names if name not in used)
    ranges = tuple(_range_of(table.column(name)) for name in unused)
    return DraftedMapping(lines, lacking, unused, refusal, ranges)


def read_by_draft(table: Table, drafted: DraftedMapping) -> Table | None:
    """Return a table under our names by the draft of its columns.

    A remark says how each was read; what raises a question is left out. None where something that a
    log needs is not sure.
    """
    sure = [line.guess for line in drafted.lines if not line.question]
    if drafted.unusable or _missing(table, sure):
        return None
    asked = [line.guess.theirs for line in drafted.lines if line.question]
    lines = ", ".join(f"{guess.theirs} → {guess.target()}" for guess in sure)
    left = f"; left out, since `pitotbench map` has a question: {', '.join(asked)}" if asked else ""
    note = f"columns as their names, units and values tell: {lines}{left}"
    found = rename(table, _mapped_file(sure))
    return replace(found, warnings=(*found.warnings, note))


def _mapped_file(chosen: Sequence[Guess]) -> MappedFile:
    return MappedFile(
        ("*",), "last", tuple(Renamed(g.theirs, g.target(), g.factor) for g in chosen)
    )


def _range_of(column: Column) -> str:
    """Return in words what a column holds: its range and the smallest step of its numbers."""
    values = almost_numbers(column)
    if values is None:
        return "no numbers"
    different = np.unique(values[np.isfinite(values)])
    if len(different) < 2:
        return f"always {different[0]:g}" if len(different) else "blank"
    step = float(np.min(np.diff(different)))
    return f"{different[0]:g} to {different[-1]:g} in steps of {step:.2g}"


_PART_OF_FOUR = re.compile(r"(.*?)[\[(_.]?([0-3]|[wxyz])[\])]?")
_UNIT_LENGTH = 0.01  # by which the sum of the squares of a quaternion differs from one


def _quaternions(table: Table) -> dict[str, str]:
    """Return the columns that are the four parts of a quaternion, with our names.

    They have one name with four numbers or letters, and their squares add up to one.
    """
    stems: dict[str, dict[int, str]] = {}
    for name in table.names:
        if found := _PART_OF_FOUR.fullmatch(name.lower()):
            place = "0123".find(found[2]) if found[2].isdigit() else "wxyz".find(found[2])
            stems.setdefault(found[1], {})[place] = name
    turns: dict[str, str] = {}
    for parts in (each for each in stems.values() if len(each) == 4):
        columns = [table.column(parts[place]) for place in range(4)]
        if all(column.dtype.kind == "f" for column in columns):
            length = np.nanmedian(np.abs(np.sum(np.square(columns), axis=0) - 1.0))
            close = bool(length < _UNIT_LENGTH)
            turns |= {parts[p]: f"attitude_q{p}" for p in range(4)} if close else {}
    return turns


def _one_each(offered: Sequence[list[Guess]]) -> list[Guess]:
    """Give each quantity to one column and each column one quantity, the best fit first."""
    ranked = sorted(
        (guess for options in offered for guess in options), key=lambda g: (-g.score, not g.stated)
    )
    chosen: dict[str, Guess] = {}
    for guess in ranked:
        if guess.quantity not in chosen and all(guess.theirs != g.theirs for g in chosen.values()):
            chosen[guess.quantity] = guess
    order = [guess.theirs for options in offered for guess in options[:1]]
    places = {name: place for place, name in enumerate(order)}
    return sorted(chosen.values(), key=lambda guess: places.get(guess.theirs, len(order)))


_COMPONENTS = ("velocity_north", "velocity_east", "velocity_down")
_DIRECTED = ("ground_speed", "track", "magnetic_track")
_POSITIONS = ("latitude", "longitude")


def _without_superseded(table: Table, chosen: list[Guess]) -> list[Guess]:
    here = {guess.quantity for guess in chosen if guess.score >= _SURE}
    dropped: tuple[str, ...] = _POSITIONS  # where the velocity has both components
    if not here.issuperset(_COMPONENTS[:2]):
        here -= set(_COMPONENTS)
        directed = "ground_speed" in here and not here.isdisjoint(_DIRECTED[1:])
        others = _DIRECTED if here.issuperset(_POSITIONS) else ()
        dropped = (*_COMPONENTS, *(_POSITIONS if directed else others))
        dropped = dropped if directed or others else ()
    unneeded = {name for name, better in _SUPERSEDED.items() if not here.isdisjoint(better)}
    return _with_a_height(table, [g for g in chosen if g.quantity not in unneeded.union(dropped)])


def _with_a_height(table: Table, chosen: list[Guess]) -> list[Guess]:
    """Return the guesses with a height for the static pressure where there is none.

    It is the altitude, whose reference is then as good as unknown.
    """
    lifted = [
        replace(g, quantity="indicated_altitude") if g.quantity == "altitude" else g for g in chosen
    ]
    return lifted if _missing(table, chosen) and not _missing(table, lifted) else chosen


def _missing(table: Table, chosen: Sequence[Guess]) -> tuple[str, ...]:
    """The needed quantities that neither a guess nor what is stated of the flight gives."""
    here = {guess.quantity for guess in chosen} | (
        {_HEIGHTS[0]} if HEIGHT in table.header else set()
    )
    return tuple(" or ".join(names) for names in NEEDED if not here & set(names))


def _fit_units(table: Table, chosen: list[Guess]) -> tuple[list[Guess], str]:
    """Return the guesses with the units that bring the log together best, and its refusal.

    The refusal is empty where the log is read with them.
    """
    step = max(1, len(table) // _ROWS)
    sample = replace(table, columns=tuple(column[::step] for column in table.columns), warnings=())
    # No unit breaks a pitot, and to look for a broken one takes most of the time of a reading.
    trials = [
        (
            units,
            *_trial(
                sample, _trusted(sample, units), (check_broken, check_broken_in_sound_velocities)
            ),
        )
        for units in islice(_unit_choices(chosen), _MOST_TRIALS)
    ]
    best = min(trials, key=lambda trial: (bool(trial[1]), trial[2]))
    if best[1]:
        return best[0], best[1]
    as_good = [each for each, refusal, doubts in trials if not refusal and doubts == best[2]]
    possible = [
        dict.fromkeys(column)
        for column in zip(*([g.units[0] for g in each] for each in as_good), strict=True)
    ]
    return [replace(g, units=tuple(units)) for g, units in zip(best[0], possible, strict=True)], ""


def _like_the_airspeed(table: Table, chosen: Sequence[Guess]) -> list[Guess]:
    """Return the guesses with the units of a ground speed ordered by the airspeed.

    The first brings it nearest to the airspeed, whose unit is known.
    """
    known = [g for g in chosen if g.quantity.endswith("_airspeed") and len(g.units) == 1]
    if not known:
        return list(chosen)
    airspeed = float(np.nanmedian(known[0].values(table)))

    def apart(guess: Guess, unit: str) -> float:
        speed = float(np.nanmedian(np.abs(replace(guess, units=(unit,)).values(table))))
        return abs(float(np.log(max(speed, 1e-6) / max(airspeed, 1e-6))))

    return [
        replace(g, units=tuple(sorted(g.units, key=partial(apart, g))))
        if g.quantity == "ground_speed" and len(g.units) > 1
        else g
        for g in chosen
    ]


_TIED = {"velocity_east": "velocity_north", "longitude": "latitude"}


def _unit_choices(chosen: list[Guess]) -> Iterator[list[Guess]]:
    """Yield the guesses with each choice of units, the usual ones first.

    Both horizontal velocities have one unit, and so have latitude and longitude.
    """
    open_units = {
        g.quantity: g.units for g in chosen if len(g.units) > 1 and g.quantity not in _TIED
    }
    ranks = product(*(range(len(units)) for units in open_units.values()))
    for rank in sorted(ranks, key=sum):
        picked = dict(zip(open_units, rank, strict=True))
        picked |= {name: picked.get(other, 0) for name, other in _TIED.items()}
        places = [min(picked.get(guess.quantity, 0), len(guess.units) - 1) for guess in chosen]
        yield [
            replace(g, units=(g.units[k], *g.units[:k], *g.units[k + 1 :]))
            for g, k in zip(chosen, places, strict=True)
        ]


def _trusted(table: Table, chosen: list[Guess]) -> list[Guess]:
    """Return the guesses by which the units of the others are judged.

    What raises a question itself is none, where the log can be read without it.
    """
    trusted = [guess for guess in chosen if not guess.doubt]
    return chosen if _missing(table, trusted) else trusted


def _trial(
    sample: Table, chosen: list[Guess], unasked: Sequence[Callable[[Draft], None]] = ()
) -> tuple[str, int]:
    """Return why the log is refused with some guesses, and how many doubts it raises."""
    try:
        with np.errstate(all="ignore"):
            log = log_of(rename(sample, _mapped_file(chosen)), unasked=unasked)
    except BadInputError as error:
        return str(error), 0
    return "", sum(
        not w.startswith(("the header", "the recording")) for w in log.header.get("warnings", [])
    )


def _rivals(guess: Guess, offered: Sequence[list[Guess]], fitted: Sequence[Guess]) -> list[str]:
    """Return other columns that fit the same quantity as well, and none better."""
    taken = {each.theirs for each in fitted if each.score >= _SURE}
    return [
        other.theirs
        for options in offered
        for other in options
        if other.quantity == guess.quantity
        and other.theirs not in taken
        and other.score > guess.score - 0.15
    ]


def _more_sensors(fitted: Sequence[Guess], offered: Sequence[list[Guess]]) -> Iterator[DraftedLine]:
    """Yield a line for each column that seems to be another sensor's airspeed or pressure."""
    used, count = {guess.theirs for guess in fitted}, 1
    for first in fitted:
        for other in (guess for options in offered for guess in options):
            wanted = first.quantity in AIRSPEEDS and other.quantity == first.quantity
            if wanted and other.theirs not in used and other.score >= _SURE:
                used.add(other.theirs)
                count += 1
                unit = first.units[0] if first.units[0] in other.units else other.units[0]
                numbered = replace(other, quantity=f"{first.quantity}_{count}", units=(unit,))
                yield DraftedLine(numbered, f"is this a sensor beside {first.theirs!r}?")


def _question(guess: Guess, rivals: Sequence[str], by_quantity: Mapping[str, str]) -> str:
    """Return what to ask about a line; empty for one that is sure.

    `by_quantity` holds the columns by quantity.
    """
    variation = by_quantity.get("magnetic_variation", by_quantity.get("magnetic_track"))
    if (
        variation
        and guess.quantity in ("track", "heading")
        and "true" not in name_and_unit(guess.theirs, "")[0]
    ):
        return (
            f"is it true, or magnetic as {variation!r} beside it suggests "
            f"(magnetic_{guess.quantity}_deg)?"
        )
    if (guess.quantity == "indicated_altitude" and "altimeter_setting" not in by_quantity) or (
        guess.quantity == "altitude" and not set(_HEIGHTS) & set(by_quantity)
    ):
        return (
            "is it the height by GPS, or a pressure altitude "
            f"(pressure_altitude_{guess.units[0]}), or one above the place of take-off "
            f"(height_above_takeoff_{guess.units[0]})? {_unit_question(guess)}"
        ).rstrip()
    if guess.doubt:
        return guess.doubt
    if guess.score < _SURE or (
        len(guess.theirs) == 1 and guess.quantity != "time" and not guess.stated
    ):
        return f"is this the {guess.quantity.replace('_', ' ')}?"
    if rivals:
        return f"or is it {' or '.join(map(repr, rivals[:3]))}?"
    return _unit_question(guess)


def _unit_question(guess: Guess) -> str:
    if guess.stated or len(guess.units) < 2:
        return ""
    return f"the file states no unit: is it {guess.units[0]}, or {' or '.join(guess.units[1:])}?"


def fill_units(table: Table) -> Table:
    """Return a table whose columns of our names without a unit have that which their values tell.

    Each is tried on the whole log, as by `draft_mapping`. A column whose values fit several units
    is left as it is, except one that the log needs: it gets the likeliest, and a remark says so.
    """
    chosen: list[Guess] = []
    for name, column in zip(table.names, table.columns, strict=True):
        quantity = QUANTITIES.get(name)
        if quantity is None:
            with suppress(BadInputError):
                if parsed := parse_column(name):
                    chosen.append(Guess(name, parsed[0].name, (parsed[1],), _EXACT, True))
        elif name == "time" and is_clock(column):
            chosen.append(Guess(name, name, ("s",), _EXACT, True))
        elif quantity.unit and (values := almost_numbers(column)) is not None:
            chosen += _with_units(name, quantity, _EXACT, 1.0, "", values)
    if any(len(guess.units) > 1 for guess in chosen) and not _missing(table, chosen):
        chosen = _fit_units(table, chosen)[0]
    named: dict[str, str] = {}
    notes = list(table.warnings)
    for guess in chosen:
        unit, *others = guess.units
        if (
            guess.theirs in QUANTITIES
            and unit
            and not (others and not QUANTITIES[guess.theirs].essential)
        ):
            named[guess.theirs] = guess.target()
            units = ", or else ".join(guess.units)
            notes.append(f"column {guess.theirs!r} states no unit: by its values {units}")
    names = tuple(named.get(name, name) for name in table.names)
    by = {UNITS_BY: GUESSED} if named else {}
    return replace(table, names=names, header={**table.header, **by}, warnings=tuple(notes))


_SHOWN = 40  # columns left over that are listed


def mapping_text(drafted: DraftedMapping, log: str) -> str:
    """Return the TOML text of a mapping for the log of a name."""
    open_lines = sum(bool(line.question) for line in drafted.lines)
    log = " ".join(log.split())
    above = [
        f"# Drafted from {log}: {len(drafted.lines)} columns recognized, {open_lines} to be "
        "checked."
    ]
    above += [f"# No column was found for {name}: add a line." for name in drafted.missing]
    if drafted.refusal:
        above.append(f"# With these lines the log is refused: {' '.join(drafted.refusal.split())}")
    body = [_line(line) for line in drafted.lines]
    # A line break would end the comment.
    unused = [
        f"# Not used: {' '.join(name.split())}: {values}"
        for name, values in zip(drafted.unused, drafted.ranges, strict=True)
        if name
    ]
    more = len(unused) - _SHOWN
    below = unused[:_SHOWN] + ([f"# Not used: {more} more columns"] if more > 0 else [])
    title = tomli_w.dumps({"title": f"drafted from {log}"}).strip()
    return "\n".join([*above, title, "", "[columns]", *body, "", *below]).rstrip() + "\n"


def _line(line: DraftedLine) -> str:
    guess = line.guess
    target = guess.target()
    value = (
        json.dumps(target)
        if guess.factor == 1.0
        else f'{{ name = "{target}", factor = {guess.factor!r} }}'
    )
    return f"{json.dumps(guess.theirs, ensure_ascii=False)} = {value}  # {line.question or 'sure'}"
