"""Turns at constant bank, through whole circles.

Circle: a full turn at constant bank and airspeed, one for each airspeed.
Decelerating circle: one long steep turn from fast to slow, with a dwell at each speed.
Figure eight: at each speed, steep full turns to one side and then to the other.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees, pi

from pitotbench.records import BadInputError
from pitotbench.simulation.card import Card, count, quantity
from pitotbench.simulation.pilot import (
    TICK,
    Cockpit,
    Ticks,
    decelerate,
    set_up,
    settle,
    sweep,
    wait,
)
from pitotbench.units import FOOT, KNOT

JUDGED = ("airspeed", "altitude")
POWER_TIME = 5.0  # s, over which the power of the turn is averaged before it is fixed
# With fixed power, a height too low or too high is flown back by less or more speed, in steps.
FEET_A_KNOT, SPEED_STEP, MOST_TRADED = 25.0 * FOOT / KNOT, 0.5 * KNOT, 1.5 * KNOT


@dataclass(frozen=True, slots=True, kw_only=True)
class CircleCard(Card):
    """Circle of Martos et al. (2011), III.A: full turns at 30° of bank.

    160, 140, 120 and 100 KCAS, ±2 KCAS and ±50 ft; flown in the simulator only (Table 2: 6
    minutes).

    Ours: `settle` in the turn, then `circles` full turns on condition; the roll-out belongs to the
    set-up. With `fixed_power` = 1 the power found while settling is kept and pitch holds airspeed
    and altitude, as the paper's pilot flew; with 0 the throttle holds the airspeed.
    """

    bank: float = quantity(30.0, "deg", steep=True)
    heading: float = quantity(0.0, "deg")
    circles: float = count(1.0, positive=True)
    fixed_power: int = 0
    bank_limit: float = quantity(35.0, "deg", positive=True)
    settle: float = quantity(10.0, "s")
    airspeed_tolerance: float = quantity(2.0, "kt")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        if self.fixed_power not in (0, 1):
            raise BadInputError("fixed_power of a circle is 0 or 1")


def fly_circle(cockpit: Cockpit, card: CircleCard) -> Ticks:
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

    The power is fixed, so the sum of speed and height is given, and pitch exchanges one for the
    other: too low, fly slower. The speed held changes in steps, as a person reads a gauge.
    """
    commanded = airspeed
    cockpit.hold_airspeed_by_pitch(commanded)
    for _ in ticks:
        traded = round(cockpit.deviation("altitude") / FEET_A_KNOT / SPEED_STEP) * SPEED_STEP
        wanted = airspeed + min(max(traded, -MOST_TRADED), MOST_TRADED)
        if wanted != commanded:
            commanded = wanted
            cockpit.hold_airspeed_by_pitch(commanded)
        yield


@dataclass(frozen=True, slots=True, kw_only=True)
class DecelCircleCard(Card):
    """Ours: the Circle of Martos et al. (2011), III.A, steeper, and slowed down in the turn.

    Only the first speed has to be set up. ±2 KCAS and ±50 ft in the dwells.

    Every speed is flown on every heading, so the wind and the curve are two unknowns, not one. The
    airplane turns faster than gusts decay, so gusts average out sooner than on straight legs. Half
    the time is at the middle speed and a quarter at each end: for a quadratic curve this gives the
    smallest mean variance.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt", decreasing=True)
    dwells: tuple[float, ...] = quantity((72.0, 145.0, 72.0), "s", as_many_as="speeds")
    bank: float = quantity(45.0, "deg", steep=True)
    heading: float = quantity(0.0, "deg")
    bank_limit: float = quantity(50.0, "deg", positive=True)
    airspeed_rate_limit: float = quantity(1.5, "kt")
    airspeed_tolerance: float = quantity(2.0, "kt")
    settle: float = quantity(5.0, "s")


def fly_decel_circle(cockpit: Cockpit, card: DecelCircleCard) -> Ticks:
    """Fly the card: set up unrecorded, roll in, dwell at each speed and slow down to the next."""
    yield from set_up(cockpit, card.speeds[0], card.heading)
    cockpit.hold_bank(card.bank)
    for index, (speed, dwell) in enumerate(zip(card.speeds, card.dwells, strict=True)):
        what = f"{speed / KNOT:.0f} kt bank {degrees(card.bank):.0f}°"
        if index:
            yield from decelerate(cockpit, speed, f"slow to {what}")
        yield from settle(cockpit, f"settle {what}", JUDGED)
        cockpit.begin(f"circle {what}", *JUDGED)
        yield from wait(dwell)


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureEightCard(Card):
    """Ours: the Circle of Martos et al. (2011), III.A, steeper, to both sides, slowing in the turn.

    Only the first speed has to be set up. ±2 KCAS and ±50 ft in the turns.

    An error that depends on the side of the turn (a probe at an angle to the flow, a sideslip)
    shows as a difference of the two halves and cancels in their mean. Without wind, each eight ends
    where it began.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt", decreasing=True)
    turns: tuple[float, ...] = count((0.8, 1.2, 1.0), positive=True, as_many_as="speeds")
    bank: float = quantity(45.0, "deg", steep=True)
    heading: float = quantity(0.0, "deg")
    bank_limit: float = quantity(50.0, "deg", positive=True)
    roll_rate_limit: float = quantity(15.0, "degps")
    airspeed_rate_limit: float = quantity(1.5, "kt")
    airspeed_tolerance: float = quantity(2.0, "kt")
    settle: float = quantity(3.0, "s")


def fly_figure_eight(cockpit: Cockpit, card: FigureEightCard) -> Ticks:
    """Fly the card: at each speed turn to one side, then to the other; slow down in turns.

    The set-up is not recorded.
    """
    yield from set_up(cockpit, card.speeds[0], card.heading)
    bank = -card.bank
    for index, (speed, turns) in enumerate(zip(card.speeds, card.turns, strict=True)):
        for half in range(2):
            # A new speed begins on the side where the last one ended, which saves a roll.
            bank = bank if index and not half else -bank
            cockpit.hold_bank(bank)
            what = f"{speed / KNOT:.0f} kt bank {degrees(bank):.0f}°"
            if index and not half:
                yield from decelerate(cockpit, speed, f"slow to {what}")
            yield from settle(cockpit, f"settle {what}", JUDGED)
            cockpit.begin(f"circle {what}", *JUDGED)
            yield from sweep(cockpit, 2.0 * pi * turns, bank)
