"""The answer of a calibration in sentences: the correction, the wind, and what to doubt of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.logbook.same_flight import COUNTED_ONCE
from pitotbench.records.calibration import (
    AutopilotSettings,
    CalibratedFlight,
    Calibration,
    ErrorCurve,
    OneSided,
)
from pitotbench.records.log import CurveMove
from pitotbench.records.outputs import file_name
from pitotbench.show.columns import with_minus_signs
from pitotbench.show.words import capital
from pitotbench.timeline import minutes_text
from pitotbench.units import KNOT, MetersPerSecond

# kt: the low end, the middle and the high end of the study's maneuvers.
_USUAL_KT = (100.0, 130.0, 160.0)


_MOST_DRAWN = 30  # points of a line that is drawn small


@dataclass(frozen=True, slots=True)
class Correction:
    """The correction to add to one indicated airspeed, and its ±2σ bound [kt].

    `true_kt` is the true correction, known of a simulated flight.
    """

    indicated_kt: float
    correction_kt: float
    two_sigma_kt: float
    true_kt: float | None = None

    def __str__(self) -> str:
        return with_minus_signs(f"{self.correction_kt:+.2f} ± {self.two_sigma_kt:.2f} kt")


def correction_sentence(corrections: Sequence[Correction]) -> str:
    """Some corrections of the indicated airspeed in one sentence."""
    parts = [f"{each} at {each.indicated_kt:.0f} KIAS" for each in corrections]
    return f"Add {'; '.join(parts)} to the indicated airspeed (± is 2σ)."


@dataclass(frozen=True, slots=True)
class ShortAnswer:
    """The short answer of a calibration, in knots and degrees.

    The wind comes from `wind_from_deg`. `curve` are the points of the curve of a simulated flight,
    to be drawn.
    """

    subject: str
    model: str
    corrections: tuple[Correction, ...]
    wind_kt: float | None  # None for a wind that is unknown
    wind_from_deg: float | None
    wind_two_sigma_kt: float | None  # of the larger component
    residual_two_sigma_kt: float
    warnings: tuple[str, ...]
    curve: tuple[Correction, ...] = ()

    @property
    def correction_sentence(self) -> str:
        """The corrections of the indicated airspeed in one sentence."""
        return correction_sentence(self.corrections)

    @property
    def wind_sentence(self) -> str:
        """The wind with the larger of its components' bounds, in one sentence."""
        if self.wind_kt is None or self.wind_two_sigma_kt is None:
            return "The wind is unknown."
        return (
            f"The wind is {self.wind_kt:.1f} ± {self.wind_two_sigma_kt:.1f} kt from "
            f"{self.wind_from_deg:03.0f}°."
        )


def short_answer_of(
    result: Calibration, subject: str, truth: MetersPerSecond | None = None
) -> ShortAnswer:
    """Return the short answer of a calibration of `subject`.

    The subject is a maneuver and data system, or a file. `truth`: the true correction [m/s] at the
    airspeeds of the curve.
    """
    wind = result.wind
    return ShortAnswer(
        subject=subject,
        model=result.model,
        corrections=_corrections(result),
        wind_kt=None if wind is None else wind.speed_kt,
        wind_from_deg=None if wind is None else wind.from_deg,
        wind_two_sigma_kt=None
        if wind is None
        else max(wind.north.two_sigma, wind.east.two_sigma) / KNOT,
        residual_two_sigma_kt=result.residual_two_sigma / KNOT,
        warnings=result.warnings,
        curve=() if truth is None else _points(result.curve, truth),
    )


def _points(curve: ErrorCurve, truth: MetersPerSecond) -> tuple[Correction, ...]:
    """The points of a curve, few enough to be drawn as a line."""
    columns = (curve.indicated_airspeed, curve.correction, curve.two_sigma, truth)
    step = max(1, len(truth) // _MOST_DRAWN)
    kept = sorted({*range(0, len(truth), step), len(truth) - 1})
    return tuple(Correction(*(float(each[row] / KNOT) for each in columns)) for row in kept)


def _corrections(result: Calibration) -> tuple[Correction, ...]:
    """The curve at 100, 130 and 160 KIAS, or at its ends and middle if it is shorter."""
    curve = result.curve
    speed = curve.indicated_airspeed / KNOT
    covered = speed[0] <= _USUAL_KT[0] + 0.5 and speed[-1] >= _USUAL_KT[-1] - 0.5
    wanted: Sequence[float] = (
        _USUAL_KT if covered else speed[np.linspace(0, len(speed) - 1, 3).astype(int)]
    )
    values = np.interp(wanted, speed, curve.correction / KNOT)
    bounds = np.interp(wanted, speed, curve.two_sigma / KNOT)
    return tuple(Correction(*map(float, row)) for row in zip(wanted, values, bounds, strict=True))


@dataclass(frozen=True, slots=True)
class NamedFlight:
    """A calibrated flight with the file of its log as the user knows it.

    `settings` are the parameters of an autopilot where they were asked for.
    """

    file: str
    flight: CalibratedFlight
    settings: AutopilotSettings | None = None

    @property
    def name(self) -> str:
        """The name of the file, with the number of the flight where the file holds several."""
        number, count = self.flight.number, self.flight.count
        return file_name(self.file) + (f", flight {number} of {count}" if count > 1 else "")

    @property
    def own_curve(self) -> bool:
        """Whether the flight is the first of those that share its curve, or has one of its own."""
        each = self.flight
        return each.joined == 1 or (each.place == each.leader and each.number == 1)


def flight_lines(flight: CalibratedFlight) -> list[str]:
    """Return in lines which flight of its log a calibration is of, and with which it is shared.

    The number of flights that share the curve is told, and the logs that are of this flight.
    """
    sentences = []
    if flight.count > 1:
        times = flight.log.time[[0, -1]] - flight.log.start
        begin, end = map(minutes_text, times)
        sentences.append(f"flight {flight.number} of {flight.count} in the log, {begin} to {end}")
    if flight.joined > 1:
        sentences.append(f"one curve from {flight.joined} flights, the wind of this one")
    same = [str(each) for each in flight.calibration.warnings if _code(each) == COUNTED_ONCE]
    return [*(["; ".join(sentences)] if sentences else []), *same]


_ASSUMED = (
    "The altimeter's correction holds only if the static port is at fault; this log cannot show "
    "which port it is."
)


_READ = (
    "log",
    "faulty rows",
    "flight left out",
    "own curves",
    "display steps",
    "turns to one side",
    COUNTED_ONCE,
)


# Kinds whose size is that of a difference of curves.
_OF_CURVE = ("height", "reading", "samples", "fixed_speed")


def _code(warning: str) -> str:
    return getattr(warning, "code", "")


def _moves(warning: str) -> CurveMove | None:
    return getattr(warning, "moves", None)


def is_doubt(warning: str) -> bool:
    """Return whether a warning tells of what may move the answer.

    Others tell how the log was read. One without a code is a doubt, and one that moves the answer
    by little is none.
    """
    moves = _moves(warning)
    return _code(warning) not in _READ and (moves is None or moves.matters)


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found beside an answer: its kind, its words, and how far it moves the curve [m/s].

    `moves` is the most, None where that is not known. One that is `fatal` makes the answer
    unusable; one of the `first` must go with it, the others tell how the log was read.
    """

    kind: str
    words: str
    moves: float | None
    first: bool = True
    fatal: bool = False


def findings_of(result: Calibration) -> list[Finding]:
    """Return the findings beside an answer in the order of every voice.

    What makes it unusable comes first, then what else contradicts it, what may move it, and how the
    log was read.
    """
    found = [
        Finding(
            each.kind, each.words, each.size if each.kind in _OF_CURVE else None, fatal=each.fatal
        )
        for each in result.disagreements
    ]
    for warning in result.warnings:
        moves = _moves(warning)
        most = None if moves is None else moves.most
        found.append(Finding(_code(warning), str(warning), most, is_doubt(warning)))
    return sorted(found, key=lambda each: (not each.fatal, not each.first))


def headline(result: Calibration) -> list[str]:
    """Return a line with what forbids an answer's use, and one with what else contradicts it.

    Both are from the answer's own log.
    """
    fatal = [each.words for each in result.disagreements if each.fatal]
    others = [each.words.partition(". ")[0] for each in result.disagreements if not each.fatal]
    lines = [("Do not use this answer", fatal), ("Two findings of this log disagree", others)]
    return [f"{lead}: {'; '.join(sentences)}." for lead, sentences in lines if sentences]


def doubts_of(result: Calibration) -> list[str]:
    """Return what contradicts, may move or is assumed of an answer, which must go wherever it goes.

    The first doubt says which speeds and tracks the log lacks.
    """
    words = [each.words for each in findings_of(result)[len(result.disagreements) :] if each.first]
    warnings = [f"{capital(w)}{'' if w.endswith('?') else '.'}" for w in words]
    sentences = [*headline(result), *warnings, *doubts_of_curve(result.curve)]
    if sentences:
        sentences[0] += _one_sided_words(result.one_sided)
    return [with_minus_signs(each) for each in sentences]


def _one_sided_words(found: Sequence[OneSided]) -> str:
    flown = [
        f"{each.begin:03.0f}° to {each.end:03.0f}° from {each.low / KNOT:.0f} to "
        f"{each.high / KNOT:.0f} KIAS"
        for each in found
    ]
    if not found:
        return ""
    return (
        f" You flew only tracks {'; '.join(flown)}: there wind and error look alike. Fly the "
        "opposite tracks as well."
    )


def doubts_of_curve(curve: ErrorCurve) -> list[str]:
    """What is assumed of a curve, in at most one line."""
    return [_ASSUMED] if curve.altitude_assumed else []
