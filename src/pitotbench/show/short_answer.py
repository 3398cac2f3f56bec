"""A calibration in a few numbers and two sentences. Loads no drawing library."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.records.calibration import Calibration
from pitotbench.units import KNOT

_USUAL_KT = (100.0, 130.0, 160.0)  # the low end, the middle and the high end of the study's maneuvers


@dataclass(frozen=True, slots=True)
class Correction:
    """The correction to add to one indicated airspeed, and its ±2σ bound [kt]."""

    indicated_kt: float
    correction_kt: float
    two_sigma_kt: float

    def __str__(self) -> str:
        return f"{self.correction_kt:+.2f} ± {self.two_sigma_kt:.2f} kt".replace("-", "−")


@dataclass(frozen=True, slots=True)
class ShortAnswer:
    """The short answer of a calibration, in knots and degrees. The wind comes from `wind_from_deg`."""

    subject: str
    model: str
    corrections: tuple[Correction, ...]
    wind_kt: float
    wind_from_deg: float
    wind_two_sigma_kt: float  # of the larger component
    residual_two_sigma_kt: float
    warnings: tuple[str, ...]

    @property
    def correction_sentence(self) -> str:
        """The corrections of the indicated airspeed in one sentence."""
        parts = [f"{each} at {each.indicated_kt:.0f} KIAS" for each in self.corrections]
        return f"Add {'; '.join(parts)} to the indicated airspeed (± is 2σ)."

    @property
    def wind_sentence(self) -> str:
        """The wind with the larger of its components' bounds, in one sentence."""
        return (
            f"The wind is {self.wind_kt:.1f} kt from {self.wind_from_deg:03.0f}°; each of its components is known "
            f"to ±{self.wind_two_sigma_kt:.2f} kt (2σ) or better."
        )


def short_answer_of(result: Calibration, subject: str) -> ShortAnswer:
    """The short answer of a calibration of `subject` (a maneuver and data system, or a file)."""
    north, east = result.wind.north, result.wind.east
    return ShortAnswer(
        subject=subject,
        model=result.model,
        corrections=corrections_at(result),
        wind_kt=result.wind.speed_kt,
        wind_from_deg=result.wind.from_deg,
        wind_two_sigma_kt=max(north.two_sigma, east.two_sigma) / KNOT,
        residual_two_sigma_kt=result.residual_two_sigma / KNOT,
        warnings=result.warnings,
    )


def corrections_at(result: Calibration) -> tuple[Correction, ...]:
    """The curve at 100, 130 and 160 KIAS, or at its ends and middle where it does not reach so far."""
    curve = result.curve
    speed = curve.indicated_airspeed / KNOT
    covered = speed[0] <= _USUAL_KT[0] + 0.5 and speed[-1] >= _USUAL_KT[-1] - 0.5
    wanted: Sequence[float] = (
        _USUAL_KT if covered else speed[np.linspace(0, len(speed) - 1, 3).astype(int)].tolist()
    )
    values = np.interp(wanted, speed, curve.correction / KNOT)
    bounds = np.interp(wanted, speed, curve.two_sigma / KNOT)
    return tuple(Correction(*map(float, row)) for row in zip(wanted, values, bounds, strict=True))
