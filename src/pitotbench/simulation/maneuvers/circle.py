"""Circle: a full turn at constant bank and airspeed, one for each airspeed."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, pi

from pitotbench.records import BadInputError
from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import TICK, Cockpit, Ticks, require_steep_turns, set_up, settle, sweep
from pitotbench.units import FOOT, KNOT

JUDGED = ("airspeed", "altitude")
POWER_TIME = 5.0  # s, over which the power of the turn is averaged before it is fixed
# With fixed power, a height too low or too high is flown back by less or more speed, in steps.
FEET_A_KNOT, SPEED_STEP, MOST_TRADED = 25.0 * FOOT / KNOT, 0.5 * KNOT, 1.5 * KNOT


@dataclass(frozen=True, slots=True, kw_only=True)
class CircleCard(Card):
    """Martos et al. (2011), III.A: 30° of bank, 160, 140, 120 and 100 KCAS, ±2 KCAS and ±50 ft; flown in the
    simulator only (Table 2: 6 minutes).

    Ours: `settle` in the turn, then `circles` full turns on condition; the roll-out belongs to the set-up. With
    `fixed_power` = 1 the power found while settling is kept and pitch holds airspeed and altitude, as the paper's
    pilot flew; with 0 the throttle holds the airspeed.
    """

    bank: float = quantity(30.0, "deg")
    heading: float = quantity(0.0, "deg")
    circles: float = 1.0
    fixed_power: int = 0
    bank_limit: float = quantity(35.0, "deg")
    settle: float = quantity(10.0, "s")
    airspeed_tolerance: float = quantity(2.0, "kt")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_positive("circles")
        require_steep_turns(self.bank)
        if self.fixed_power not in (0, 1):
            raise BadInputError("fixed_power of a circle is 0 or 1")


def fly(cockpit: Cockpit, card: CircleCard) -> Ticks:
    """Fly the card. At each speed: set up unrecorded, roll in, settle, circle."""
    for speed in card.speeds:
        yield from set_up(cockpit, speed, card.heading)
        cockpit.hold_bank(card.bank)
        what = f"{speed / KNOT:.0f} kt bank {degrees(card.bank):.0f}°"
        power = MeanPower(cockpit)
        yield from power.over(settle(cockpit, f"settle {what}", JUDGED))
        cockpit.begin(f"circle {what}", *JUDGED)
        circle = sweep(cockpit, 2.0 * pi * card.circles, card.bank)
        if card.fixed_power:
            cockpit.set_power(power.mean)
            yield from by_pitch(cockpit, speed, circle)
            cockpit.hold_altitude_by_pitch()
        else:
            yield from circle


class MeanPower:
    """The power setting, averaged over the last `POWER_TIME` while ticks pass."""

    def __init__(self, cockpit: Cockpit) -> None:
        self._cockpit = cockpit
        self.mean = cockpit.power()

    def over(self, ticks: Ticks) -> Iterator[None]:
        """Let the ticks pass, and average."""
        for _ in ticks:
            yield
            self.mean += (self._cockpit.power() - self.mean) * TICK / POWER_TIME


def by_pitch(cockpit: Cockpit, airspeed: float, ticks: Ticks) -> Iterator[None]:
    """Let the ticks pass while pitch holds an airspeed [m/s], and small changes of it the altitude.

    The power is fixed, so the sum of speed and height is given, and pitch exchanges one for the other: too low, fly
    slower. The speed held changes in steps, as a person reads a gauge.
    """
    held = airspeed
    cockpit.hold_airspeed_by_pitch(held)
    for _ in ticks:
        traded = round(cockpit.deviation("altitude") / FEET_A_KNOT / SPEED_STEP) * SPEED_STEP
        wanted = airspeed + min(max(traded, -MOST_TRADED), MOST_TRADED)
        if wanted != held:
            held = wanted
            cockpit.hold_airspeed_by_pitch(held)
        yield
