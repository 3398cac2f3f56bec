"""What cannot be true together in a log: a mistake that fits is named with the column to write.

The checks run in this order, because each trusts what those before it have looked at: static pressure and
temperature give the density with which airspeeds are formed. All arrays are SI, one value for each row.
"""

from pitotbench.logbook.draft import Draft
from pitotbench.logbook.plausibility.attitude import check_attitude
from pitotbench.logbook.plausibility.heading import check_heading
from pitotbench.logbook.plausibility.height import check_height
from pitotbench.logbook.plausibility.limits import LIMITS as LIMITS
from pitotbench.logbook.plausibility.speed import check_speed, find_factor, flown_rows
from pitotbench.logbook.plausibility.weather import check_rise, check_temperature

__all__ = ["LIMITS", "check_plausibility"]


def check_plausibility(draft: Draft) -> None:
    """Warn of what is hardly possible; raise BadInputError for what is not."""
    check_height(draft)
    check_temperature(draft)
    check_rise(draft)
    flown = flown_rows(draft)
    if flown is None:
        return
    factor = find_factor(flown)
    check_speed(draft, flown, factor)
    check_heading(draft, flown, factor)
    check_attitude(draft, flown, factor)
