"""The correction of one airplane over the dates of its flights, and since when it is another."""

from dataclasses import dataclass
from datetime import datetime

from pitotbench.units import KNOT, MetersPerSecond


@dataclass(frozen=True, slots=True)
class DatedChange:
    """A correction that is another from a flight on.

    `first` is the index of that flight, `airspeed` [m/s] where the change is clearest, `size` [m/s]
    the correction after less that before, `chance` how often flights without a change look so.
    """

    first: int
    airspeed: float
    size: float
    two_sigma: float
    chance: float


@dataclass(frozen=True, slots=True)
class OverDates:
    """The corrections of the flights of an airplane, n in the order of their dates.

    `airspeed` [m/s] has c of the airspeeds that all flights share; `correction` and `two_sigma`
    [m/s] are (n, c).
    """

    names: tuple[str, ...]
    dates: tuple[datetime, ...]
    airspeed: MetersPerSecond
    correction: MetersPerSecond
    two_sigma: MetersPerSecond
    change: DatedChange | None

    @property
    def words(self) -> str:
        """Since when the correction is another, and what to do; empty where it is not."""
        change = self.change
        if change is None:
            return ""
        before, after = (self.dates[change.first + step].date() for step in (-1, 0))
        return (
            f"the correction at {change.airspeed / KNOT:.0f} KIAS changed by "
            f"{change.size / KNOT:+.2f} ± {change.two_sigma / KNOT:.2f} kt between {before} and "
            f"{after} (from {self.names[change.first]} on), so that no one curve is right before "
            "and after: calibrate the flights of each time alone"
        )
