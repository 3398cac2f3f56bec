"""Reduce tower fly-bys: the altimeter against the tower's barometer."""

from collections.abc import Mapping, Sequence

import numpy as np

from pitotbench import air
from pitotbench.calibration.options import USUAL, Accuracies
from pitotbench.estimation.mixture import half_width
from pitotbench.logbook.plausible_air import LIMITS
from pitotbench.records import BadInputError
from pitotbench.records.legs import FlyBy, FlyByPoint
from pitotbench.units import Array, percent_text

_NODES = 101  # of the reading with the coarsest step
_HIGHEST_GRID = 1000.0  # m: a grid height is that above the tower, not above the sea


def reduce_fly_bys(
    passes: Sequence[FlyBy], steps: Mapping[str, float], stated: Accuracies = USUAL
) -> tuple[FlyByPoint, ...]:
    """Return the position error of each pass of a tower, with 2σ.

    The static pressure at the airplane is the tower's, reduced by the column of air between
    (hydrostatics with the standard lapse rate from the tower's temperature; Gracey, NASA RP-1046,
    1980, ch. IX). The bound holds the steps of the readings, which are uniform, and the stated
    accuracies: `static_pressure_pa` of altimeter against barometer, `temperature_k` of the tower.
    Raises BadInputError for a pass that cannot be.
    """
    if not passes:
        raise BadInputError("the card holds no pass: write a row a pass")
    return tuple(_fly_by(each, steps, stated) for each in passes)


def _fly_by(each: FlyBy, steps: Mapping[str, float], stated: Accuracies) -> FlyByPoint:
    if not abs(each.grid_height) < _HIGHEST_GRID or not each.indicated_airspeed > 0.0:
        raise BadInputError(
            f"row {each.row}: a pass needs an airspeed above zero and a grid height above the "
            "tower's barometer, "
            f"at most {_HIGHEST_GRID:.0f} m"
        )
    if not (each.tower_pressure > 0.0 and each.tower_temperature > 0.0):
        raise BadInputError(
            f"row {each.row}: tower pressure and temperature must be above zero: check their units"
        )
    column = 1.0 - air.LAPSE_RATE * each.grid_height / each.tower_temperature
    true = each.tower_pressure * column ** (air.GRAVITY / (air.GAS_CONSTANT * air.LAPSE_RATE))
    by_height = true * air.GRAVITY / (air.GAS_CONSTANT * each.tower_temperature)  # Pa per m
    indicated = float(air.standard_pressure(each.pressure_altitude))
    low, high = air.standard_pressure(each.pressure_altitude + np.array([0.5, -0.5]))
    by_altimeter = float(high - low)  # Pa per m
    by_temperature = by_height * each.grid_height / each.tower_temperature  # Pa per K
    half = 0.5 * np.array(
        [
            steps["pressure_altitude"] * by_altimeter,
            steps["grid_height"] * by_height,
            steps["tower_pressure"] * true / each.tower_pressure,
            steps["tower_temperature"] * by_temperature,
        ]
    )
    normal = 0.5 * np.hypot(stated.static_pressure_pa, stated.temperature_k * by_temperature)
    bound = _of_readings(np.abs(half), float(normal))
    error = indicated - true  # the static source reads so much too high
    impact = float(air.impact_pressure(each.indicated_airspeed))
    if abs(error) - bound > LIMITS.curve_refused * impact:
        raise BadInputError(
            f"row {each.row}: the static pressure is off by {percent_text(error / impact, '+')} of "
            "the impact pressure, and no airplane's is so far. The altimeter must stand on "
            "1013.25 hPa (29.92 inHg), and tower_pressure is what the barometer reads at its "
            "height, not the altimeter setting"
        )
    # readings too coarse for the airspeed have a bound beyond that
    right = max(impact + error, 0.5 * impact)
    slope = float(air.calibrated_airspeed_slope(right))
    by_airspeed = 1.0 / float(air.calibrated_airspeed_slope(impact))  # Pa per m/s
    read = steps["indicated_airspeed"] / np.sqrt(3.0)  # 2σ of a reading
    return FlyByPoint(
        point=each.point,
        configuration=each.configuration,
        indicated_airspeed=each.indicated_airspeed,
        altitude_correction=float(air.pressure_altitude(true) - each.pressure_altitude),
        altitude_two_sigma=bound / by_altimeter,
        correction=float(air.calibrated_airspeed(right) - each.indicated_airspeed),
        two_sigma=float(np.hypot(slope * bound, (slope * by_airspeed - 1.0) * read)),
        normalized_pressure_error=error / right,
        normalized_two_sigma=float(np.hypot(impact * bound, error * by_airspeed * read) / right**2),
    )


def _of_readings(half: Array, normal: float) -> float:
    """Return the 2σ of a sum of uniform errors within ±`half` (n,) and a normal deviation.

    The widest one is taken as it is, the others as normal: a single reading errs by no more than
    half its step.
    """
    widest = float(np.max(half))
    others = float(np.sqrt(max(np.sum(half**2) - widest**2, 0.0) / 3.0 + normal**2))
    means = widest * np.linspace(-1.0, 1.0, 2 * _NODES + 1)[1::2]
    deviations = np.full((_NODES, 1), max(others, widest / _NODES, 1e-9))
    return float(half_width(np.full(_NODES, 1.0 / _NODES), means[:, None], deviations)[0])
