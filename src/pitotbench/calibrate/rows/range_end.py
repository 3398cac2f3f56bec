"""Rows that the range of the impact-pressure sensor cuts off: a reading at its end is not a measurement.

Leaving out the rows at the end alone would keep the lulls and lose the gusts, and the curve would be wrong by a
part of the gusts. So the rows are chosen by what hardly depends on one gust: the mean of the reading over half a
minute has to be below the end of the range by three times the scatter about it.
"""

from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.estimate.robust_scale import robust_deviation
from pitotbench.logbook.ceiling import at_ceiling
from pitotbench.records.log import FlightLog
from pitotbench.timeline import interval
from pitotbench.units import KNOT, Booleans, MetersPerSecond

_MEAN_OVER = 30.0  # s: a gust lasts 4 s at 250 kt and 10 s at 100 kt
_AROUND = 5.0  # s: before and after a row at the end of the range, where the airplane comes from it or goes to it
_SCATTER = 3.0  # times the scatter about the mean: a thousandth of the readings is cut off there


@dataclass(frozen=True, slots=True)
class RangeEnd:
    """The end of the sensor's range in a log.

    `airspeed` [m/s] is the indicated airspeed there and `usable` [m/s] the mean one up to which rows are used.
    `rows` (n,) marks the rows at the end, `cut_off` (n,) those and all that are left out because of it.
    """

    airspeed: float
    usable: float
    rows: Booleans
    cut_off: Booleans

    @property
    def words(self) -> str:
        """The warning: where the range ends, and which rows are not used."""
        return (
            f"the impact pressure stands at the end of the sensor's range, {self.airspeed / KNOT:.0f} kt, on "
            f"{int(self.rows.sum())} rows: those, {_AROUND:.0f} s around them and rows whose mean is above "
            f"{self.usable / KNOT:.0f} kt are not used, {int(self.cut_off.sum())} in all; for these speeds use a "
            "sensor with more range"
        )


def range_end(log: FlightLog) -> RangeEnd | None:
    """Return the end of the impact-pressure sensor's range as the log shows it; None where it shows none."""
    rows = at_ceiling(log.impact_pressure)
    if not rows.any():
        return None
    from scipy.ndimage import maximum_filter1d, uniform_filter1d  # slow to load, and most logs need none

    speed: MetersPerSecond = air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0))
    period = interval(log.time)
    mean = uniform_filter1d(speed, 1 + 2 * round(0.5 * _MEAN_OVER / period), mode="nearest")
    near = maximum_filter1d(rows, 1 + 2 * round(_AROUND / period), mode="nearest")
    end = float(np.max(speed))
    free = ~near if not near.all() else ~rows
    usable = end - _SCATTER * float(robust_deviation((speed - mean)[free]))
    return RangeEnd(end, usable, rows, near | (mean > usable))
