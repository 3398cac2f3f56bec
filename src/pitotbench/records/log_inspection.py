"""What a log holds and what can be learned from it, before anything is calibrated."""

from dataclasses import dataclass

from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class HeldChannel:
    """A channel of a log: its name, its canonical unit, its 5 % and 95 % quantiles in that unit, and how many times
    a second it is renewed [Hz]; the numbers are None for texts and flags."""

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


@dataclass(frozen=True, slots=True)
class LogInspection:
    """The account of one log, in SI.

    `flights`: start and end [s] of each; `pauses`: start and length [s] of each pause inside them. `headings`: how
    many of the twelve sectors of 30° of track hold at least 2 % of the rows. `airspeeds`, `heights`: 5 %, 50 % and
    95 % quantiles, indicated [m/s] and pressure altitude [m]. `expected`: indicated airspeeds [m/s] and 2σ [m/s] in
    light turbulence, or None with the reason in `refusal`. `wind`: toward north and east [m/s].
    """

    rows: int
    rate: float
    channels: tuple[HeldChannel, ...]
    flights: tuple[tuple[float, float], ...]
    pauses: tuple[tuple[float, float], ...]
    headings: int
    airspeeds: tuple[float, float, float]
    heights: tuple[float, float, float]
    questions: tuple[Question, ...]
    expected: tuple[Array, Array] | None
    refusal: str
    wind: tuple[float, float]
    warnings: tuple[str, ...]
