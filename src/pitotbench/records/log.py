"""A flight log: what a measured log can hold, without anything that only a simulator knows."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import nan
from types import MappingProxyType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import CHANNELS, Recorded, numbers_from
from pitotbench.records import RecordError, Shown, freeze_arrays
from pitotbench.timeline import fresh_fixes
from pitotbench.units import KNOT, Array, Booleans

_MATTERS = 0.25  # of the curve's 2σ: what moves it by less is within the bound


@dataclass(frozen=True, slots=True)
class CurveMove:
    """The most by which a cause moves the error curve: in m/s, and as a share of the curve's 2σ."""

    most: float
    share: float

    @property
    def matters(self) -> bool:
        """Whether the answer must not go without a word of the cause."""
        return self.share > _MATTERS


class Caution(str):
    """A warning: its text, and what a later step needs to find it again.

    The step may reword or withdraw it.

    `code` names the check. `column` is the column that it is about, empty where there is none.
    `size` is the size that was found, in the unit of the text, NaN where there is none. `moves` is
    what it moves in the curve, None where that is not known. It is a text, so a header holds it as
    one.
    """

    __slots__ = ("code", "column", "moves", "size")
    code: str
    column: str
    size: float
    moves: CurveMove | None

    def __new__(
        cls,
        text: str,
        code: str = "log",
        column: str = "",
        size: float = nan,
        moves: CurveMove | None = None,
    ) -> Self:
        """Make the warning of a text.

        One that a log brings along as a mere text has the code `log`.
        """
        caution = super().__new__(cls, text)
        caution.code, caution.column, caution.size, caution.moves = code, column, size, moves
        return caution


START = "first_row_s"  # header entry of a part of a log: the time of the first row of the whole
AT_REST = "at_rest"  # header entry: what the impact pressure reads before and after the flight
OF_FIXES = "velocity_of_fixes_s"  # header entry: the time between the fixes that give the velocity
UNITS_BY = "units_by"  # header entry: what fixes the units of a log, see `FlightLog.units_by`
PRESSURE, FORMAT, NAMED, GUESSED = "pressure", "speed", "named", "guessed"  # of that entry
UNITS_OF_A_LOG = {"air_data": PRESSURE, "velocity": NAMED}  # without that entry


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class FlightLog(Shown, Recorded):
    """A flight log: one row a sample at the air-data rate, read-only arrays (n,), SI and radians.

    The channels are those of `channels.Recorded`; an optional channel is None where the log lacks
    it. `header` is the table of entries above the columns of the file. Raises RecordError where
    lengths differ or time does not increase strictly.
    """

    header: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        freeze_arrays(self, len(self.time))
        if len(self.time) < 2 or not bool(np.all(np.diff(self.time) > 0.0)):
            raise RecordError("FlightLog.time must hold at least two samples and increase strictly")

    def channels(self) -> dict[str, NDArray[Any]]:
        """Return the channels that are present, by field name."""
        return {name: value for name in CHANNELS if (value := getattr(self, name)) is not None}

    def fresh_fixes(self) -> Booleans:
        """Return whether GPS velocity is new in each row, as logged or by repeated values, (n,)."""
        return fresh_fixes(self.gps_fresh, self.velocity_north, self.velocity_east)

    def renewed_fixes(self) -> Booleans:
        """Return whether anything of the GPS is new in each row, as logged or by repeats, (n,).

        On a steady leg a coarse velocity repeats itself while the height goes on; in an outage all
        stand still.
        """
        present = [
            values for name in numbers_from("gps") if (values := getattr(self, name)) is not None
        ]
        return fresh_fixes(self.gps_fresh, *present)

    def select(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "FlightLog":
        """Return the log of some rows (a mask or sorted indices), with the same header."""
        picked = {name: array[rows] for name, array in self.channels().items()}
        return FlightLog(**picked, header=self.header)

    def part(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> "FlightLog":
        """Return a part of the log, whose clock remains that of the whole."""
        return replace(self.select(rows), header={**self.header, START: self.start})

    @property
    def start(self) -> float:
        """The time [s] of the first row of the whole, from which the minutes of the log count."""
        first, start = float(self.time[0]), self.header.get(START)
        return float(start) if isinstance(start, int | float) and start <= first else first

    @property
    def cautions(self) -> tuple[Caution, ...]:
        """The remarks of the header as warnings.

        One that the log brought along as a mere text has no finding.
        """
        remarks = self.header.get("warnings", ())
        return tuple(each if isinstance(each, Caution) else Caution(each) for each in remarks)

    @property
    def units_by(self) -> Mapping[str, str]:
        """What fixes how `air_data` and `velocity` are read.

        `pressure` (a pressure, which no unit of speed can be in), `speed` (the unit that the
        recorder's format prescribes), `named` (a suffix, a heading or a mapping) or `guessed` (by
        the values). A log without the entry holds a pressure and a named velocity.
        """
        found = self.header.get(UNITS_BY)
        stated = found if isinstance(found, Mapping) else {}
        return {**UNITS_OF_A_LOG, **stated}

    @property
    def simulated(self) -> bool:
        """Whether a simulator made the log: nothing else writes a case into the header."""
        return "case" in self.header

    def __len__(self) -> int:
        return len(self.time)


@dataclass(frozen=True, slots=True)
class ChannelSummary:
    """A channel of a log on a sheet: name, unit, 5 % and 95 % quantiles, and rate of renewal [Hz].

    The numbers, the quantiles in the canonical unit, are None for texts and flags.
    """

    name: str
    unit: str
    low: float | None
    high: float | None
    rate: float | None


@dataclass(frozen=True, slots=True)
class Question:
    """A question to the log: whether it can be answered, and what is missing or assumed for it."""

    name: str
    answered: bool
    words: str


@dataclass(frozen=True, slots=True, repr=False)
class LogInspection(Shown):
    """The account of one log, in SI.

    `flights`: start and end [s] of each; `pauses`: start and length [s] of each pause inside them.
    `headings`: how many of the twelve sectors of 30° of track hold at least 2 % of the rows.
    `airspeeds`, `heights`: 5 %, 50 % and 95 % quantiles, indicated [m/s] and pressure altitude [m].
    `expected`: indicated airspeeds [m/s] and 2σ [m/s] in light turbulence with the pressure-error
    `model`, or None with the reason in `refusal`. `wind`: toward north and east [m/s];
    `wind_drifts` where a calibration gives each part of the flight a wind of its own.
    """

    rows: int
    rate: float
    channels: tuple[ChannelSummary, ...]
    flights: tuple[tuple[float, float], ...]
    pauses: tuple[tuple[float, float], ...]
    headings: int
    airspeeds: tuple[float, float, float]
    heights: tuple[float, float, float]
    questions: tuple[Question, ...]
    expected: tuple[Array, Array] | None
    refusal: str
    wind: tuple[float, float]
    wind_drifts: bool
    model: str
    warnings: tuple[Caution, ...]


@dataclass(frozen=True, slots=True)
class InputFile:
    """A file that an answer was made from: its `role`, name and SHA-256, and facts of a log.

    The role is log, mapping, card or aircraft. A folder has the digest of its files one after
    another, by path; a log in memory that of its channels. Of a log also the number of rows, the
    minutes, the origin (measured or simulated), the names of its channels, the 5 % and 95 %
    quantiles of its indicated airspeed [m/s] and pressure altitude [m]. As far as the log tells
    them, the airplane, the day when it was `flown`, and the `kind` of aircraft, such as `drone`.
    """

    role: str
    name: str
    sha256: str
    rows: int = 0
    minutes: float = 0.0
    origin: str = ""
    channels: tuple[str, ...] = ()
    airspeeds: tuple[float, float] = (nan, nan)
    heights: tuple[float, float] = (nan, nan)
    airplane: str = ""
    flown: str = ""
    kind: str = ""

    @property
    def flight(self) -> str:
        """The airplane and the day of the flight, as far as they are known."""
        return ", ".join(filter(None, (self.airplane, self.flown)))


@dataclass(frozen=True, slots=True)
class Choice:
    """A choice that acted on an answer, in words, with who made it.

    `source` is `stated`, `mapping` or `default`.
    """

    name: str
    value: str
    source: str


@dataclass(frozen=True, slots=True)
class Provenance:
    """Provenance of an answer: files, choices, versions by name, and the date of the run in UTC."""

    inputs: tuple[InputFile, ...] = ()
    choices: tuple[Choice, ...] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    date: str = ""

    @property
    def airplane(self) -> str:
        """The airplane of the logs, or several with commas; empty where no log names it."""
        return ", ".join(dict.fromkeys(each.airplane for each in self.inputs if each.airplane))

    @property
    def flown(self) -> str:
        """The days of the flights with commas; empty where no log knows its day."""
        return ", ".join(dict.fromkeys(each.flown for each in self.inputs if each.flown))


@dataclass(frozen=True, slots=True)
class FlightSummary:
    """A flight of a folder: its file, and the file's refusal, empty for one that was read.

    It also has its moment as the log states it, its airplane, its length [s] and the 5 % and 95 %
    quantiles of its indicated airspeed [m/s]. `strange`: it was not read for its names, which a
    mapping can tell.
    """

    file: str
    refusal: str = ""
    start: str = ""
    airplane: str = ""
    seconds: float = 0.0
    airspeeds: tuple[float, float] = (0.0, 0.0)
    strange: bool = False

    def __str__(self) -> str:
        if self.refusal:
            return f"{self.file}: not read: {self.refusal}"
        low, high = (speed / KNOT for speed in self.airspeeds)
        facts = [
            self.start,
            self.airplane,
            f"{self.seconds / 60.0:.0f} min",
            f"{low:.0f} to {high:.0f} KIAS",
        ]
        return f"{self.file}: {', '.join(filter(None, facts))}"
