"""The columns of an error curve in numbers, for the terminal, pages and JSON."""

from dataclasses import dataclass

from pitotbench.records.calibration import ErrorCurve
from pitotbench.show.columns import Column
from pitotbench.units import FOOT, KNOT, Array, Meters


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """One point of an error curve."""

    curve: ErrorCurve
    number: int

    def at(self, values: Array) -> float:
        """The value at this point of an array over the curve."""
        return float(values[self.number])

    def knots(self, speeds: Array) -> float:
        """The speed [kt] at this point of an array of speeds [m/s]."""
        return float(speeds[self.number] / KNOT)

    def feet(self, heights: Meters | None) -> float | None:
        """The height [ft] at this point of an array of heights [m]; None where the curve has none."""
        return None if heights is None else float(heights[self.number] / FOOT)


CURVE_COLUMNS: tuple[Column[CurvePoint], ...] = (
    Column("IAS", lambda p: p.knots(p.curve.indicated_airspeed), "kt", ".0f", "indicated_airspeed_kt"),
    Column(
        "CAS",
        lambda p: p.knots(p.curve.indicated_airspeed + p.curve.correction),
        "kt", ".2f", "calibrated_airspeed_kt",
    ),
    Column("correction", lambda p: p.knots(p.curve.correction), "kt", "+.2f", "correction_kt"),
    Column("±2σ bound", lambda p: p.knots(p.curve.two_sigma), "kt", ".2f", "two_sigma_kt"),
    Column(
        "±2σ of whole curve",
        lambda p: p.knots(p.curve.simultaneous_two_sigma),
        "kt", ".2f", "simultaneous_two_sigma_kt",
    ),
    Column(
        "2σ for white residuals", lambda p: p.knots(p.curve.white_two_sigma), "kt", ".2f", "white_two_sigma_kt"
    ),
    Column(
        "Δp/q_c", lambda p: p.at(p.curve.normalized_pressure_error), style="+.4f", key="normalized_pressure_error"
    ),
    Column(
        "±2σ of Δp/q_c", lambda p: p.at(p.curve.normalized_two_sigma), style=".4f", key="normalized_two_sigma"
    ),
    Column(
        "altitude correction", lambda p: p.feet(p.curve.altitude_correction),
        "ft", "+.0f", "altitude_correction_ft", optional=True,
    ),
    Column(
        "±2σ of altitude", lambda p: p.feet(p.curve.altitude_two_sigma),
        "ft", ".0f", "two_sigma_ft", optional=True,
    ),
)  # fmt: skip


def curve_points(curve: ErrorCurve) -> list[CurvePoint]:
    """The points of a curve, the rows of its table."""
    return [CurvePoint(curve, number) for number in range(len(curve.indicated_airspeed))]
