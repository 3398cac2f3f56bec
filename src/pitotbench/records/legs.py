"""Fixed-speed points of a log, and a card written by hand: its legs, its points and its curves."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi

from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.calibration import FixedSpeedPoint as FixedSpeedPoint
from pitotbench.units import DEGREE, FOOT, KNOT


@dataclass(frozen=True, slots=True)
class FixedSpeedResult:
    """True airspeed [m/s] and wind of legs without air data.

    `spread` [m/s] is the standard deviation of the three-leg answers, None for three legs.
    `wind_speed` is in m/s, and `wind_from` the direction from which the wind comes [rad, 0 to 2π].
    """

    true_airspeed: float
    spread: float | None
    wind_speed: float
    wind_from: float


# A card written by hand: its legs, and what they give: a point each airspeed and a curve each
# configuration.


@dataclass(frozen=True, slots=True, kw_only=True)
class CardRow:
    """One row of a card as it was read from the displays [SI]; `row` counts from 1."""

    row: int
    point: str
    configuration: str
    indicated_airspeed: float
    pressure_altitude: float


@dataclass(frozen=True, slots=True, kw_only=True)
class CardLeg(CardRow):
    """A leg of a card [SI, rad].

    `air_temperature` is that of the air [K]; `track` is true, and the heading where `by_heading`.
    """

    air_temperature: float
    ground_speed: float
    track: float
    by_heading: bool = False


@dataclass(frozen=True, slots=True)
class ReadingSteps:
    """The steps of a card's displays: airspeeds [m/s], height [m], temperature [K], track [rad]."""

    indicated_airspeed: float
    pressure_altitude: float
    air_temperature: float
    ground_speed: float
    track: float


# Of usual displays, where the numbers of a short card show none.
USUAL_STEPS = ReadingSteps(KNOT, 10.0 * FOOT, 1.0, KNOT, DEGREE)


@dataclass(frozen=True, slots=True)
class Slip:
    """A leg that cannot be: row, point, what is wrong, and what was probably meant, if known."""

    row: int
    point: str
    words: str
    probably: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CardPoint:
    """What the legs at one airspeed give.

    `correction` is calibrated minus indicated airspeed [m/s]; `altitude_correction` is true minus
    indicated pressure altitude [m] where the static source errs. A point with too few legs has None
    and the reason in `remark`. `wind_from` [rad]; `spread` [m/s] of the three-leg answers.
    """

    point: str
    configuration: str
    legs: int
    indicated_airspeed: float
    calibrated_airspeed: float | None = None
    correction: float | None = None
    two_sigma: float | None = None
    altitude_correction: float | None = None
    altitude_two_sigma: float | None = None
    true_airspeed: float | None = None
    spread: float | None = None
    wind_speed: float | None = None
    wind_from: float | None = None
    remark: str | None = None


@dataclass(frozen=True, slots=True)
class HandCard:
    """The answer of a card: points, curves by configuration, slips, warnings, and stated priors.

    Points are in their order; the warnings tell the slips too; priors go by name.
    """

    points: tuple[CardPoint, ...]
    curves: dict[str, ErrorCurve]
    slips: tuple[Slip, ...]
    warnings: tuple[str, ...]
    priors: Mapping[str, float]


# A card of tower fly-bys: the passes as they were read, and the position error of each.


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyBy(CardRow):
    """One pass of a tower as it was read [SI].

    `pressure_altitude` is the airplane's altimeter on 1013.25 hPa. `grid_height` is the airplane's
    height above the tower's barometer, which reads `tower_pressure` (not reduced to sea level) in
    air of `tower_temperature` [K].
    """

    grid_height: float
    tower_pressure: float
    tower_temperature: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FlyByPoint:
    """What a pass gives, each with 2σ.

    True minus indicated pressure altitude [m], Δp/q_c [-], and calibrated minus indicated airspeed
    [m/s] where the total source is right.
    """

    point: str
    configuration: str
    indicated_airspeed: float
    altitude_correction: float
    altitude_two_sigma: float
    correction: float
    two_sigma: float
    normalized_pressure_error: float
    normalized_two_sigma: float


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownSpeed:
    """A point with a known speed: that speed, and the airspeed that was shown [m/s]."""

    row: int
    point: str
    configuration: str
    known_airspeed: float
    indicated_airspeed: float


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedFactor:
    """What points with a known speed give at one of them, each with 2σ.

    The factor of the indicated airspeed that was measured there, and calibrated minus indicated
    airspeed [m/s] by all of them.
    """

    point: str
    configuration: str
    indicated_airspeed: float
    known_airspeed: float
    factor: float
    factor_two_sigma: float
    correction: float
    two_sigma: float


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownSpeedResult:
    """What points with a known speed give.

    The factor by speed, and the scale [-] and the zero [Pa] of true impact pressure = scale ·
    indicated + zero, with 2σ; `scatter` [m/s] of the points.
    """

    points: tuple[SpeedFactor, ...]
    scale: float
    scale_two_sigma: float
    zero: float
    zero_two_sigma: float
    scatter: float


@dataclass(frozen=True, slots=True)
class HandPlan:
    """A card to fly: legs a point, airspeeds [m/s] in order, how often, minutes, and 2σ [m/s].

    The 2σ of the curve is the mean over its airspeeds.
    """

    legs: int
    airspeeds: tuple[float, ...]
    times: int
    minutes: float
    two_sigma: float

    @property
    def tracks(self) -> tuple[float, ...]:
        """The true tracks of a point [rad], from north; any turn of all together does as well."""
        return tuple(2.0 * pi * leg / self.legs for leg in range(self.legs))
