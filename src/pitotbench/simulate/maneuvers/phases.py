"""The pieces that cards are made of. Each is a generator that yields once a tick, while the plant runs."""

from collections.abc import Callable, Iterator
from math import degrees, pi, tan

from pitotbench.simulate.maneuvers.cockpit import TICK, Cockpit
from pitotbench.units import DEGREE, KNOT, STANDARD_GRAVITY

Ticks = Iterator[None]

SET_UP_LIMIT = 240.0  # s, to reach a speed; idle 160 to 100 kt takes half a minute
SET_UP_HOLD = 5.0  # s, on speed before a set-up is over
SET_UP_AIRSPEED = 0.4 * KNOT  # m/s, off at most ..
SET_UP_PATIENCE = 60.0  # s, .. for so long; then the card's tolerance will do
SET_UP_WORST = 4.0 * KNOT  # m/s, off at the limit without being an error
ROLL_OUT_LIMIT = 40.0  # s
THERE = 5.0 * DEGREE  # past a heading by less is being on it
LEVEL = 3.0 * DEGREE  # bank below which a turn is over
ALL = ("airspeed", "heading", "altitude")


def wait(seconds: float) -> Ticks:
    """Let time [s] pass."""
    for _ in range(round(seconds / TICK)):
        yield


def until(cockpit: Cockpit, reached: Callable[[], bool], limit: float, what: str) -> Ticks:
    """Fly on until a condition is met. Raises SimulationError, naming it, after a limit [s]."""
    for _ in range(round(limit / TICK)):
        if reached():
            return
        yield
    raise cockpit.plant.failure(f"{what} not reached within {limit:.0f} s")


def set_up(cockpit: Cockpit, airspeed: float, heading: float) -> Ticks:
    """Reach an airspeed [m/s] and heading [rad] in level flight, unrecorded: the paper's times exclude it.

    Raises SimulationError where the aircraft does not get there.
    """
    cockpit.hold_airspeed(airspeed)
    cockpit.hold_heading(heading)
    cockpit.begin(cockpit.name("set-up"), recorded=False)
    held = 0.0
    for tick in range(round(SET_UP_LIMIT / TICK)):
        near = abs(cockpit.deviation("airspeed")) < SET_UP_AIRSPEED or tick * TICK > SET_UP_PATIENCE
        held = held + TICK if near and abs(cockpit.bank) < LEVEL and cockpit.within(*ALL) else 0.0
        if held >= SET_UP_HOLD:
            return
        yield
    off = cockpit.deviation("airspeed")
    if abs(off) > SET_UP_WORST:  # less is turbulence: the log says what was achieved
        raise cockpit.plant.failure(
            f"{airspeed / KNOT:.0f} KCAS in level flight was not reached ({off / KNOT:+.1f} kt off); "
            "choose a speed that it holds"
        )


def settle(cockpit: Cockpit, label: str = "", quantities: tuple[str, ...] = ALL) -> Ticks:
    """Let the aircraft settle for the card's time, up to twice that until quantities are within tolerances."""
    cockpit.begin(label or cockpit.name("settle"))
    yield from wait(cockpit.card.settle)
    for _ in range(round(cockpit.card.settle / TICK)):
        if cockpit.within(*quantities):
            return
        yield


def leg(cockpit: Cockpit, seconds: float, *judged: str) -> Ticks:
    """Fly straight and level for a time [s]; by default airspeed, heading and altitude are judged."""
    cockpit.begin(cockpit.name("leg"), *(judged or ALL))
    yield from wait(seconds)


def turn(cockpit: Cockpit, heading: float) -> Ticks:
    """Turn right to a heading [rad] at the card's bank, roll out on it.

    Bank is held until the lead of the roll-out, so that a turn by 180° has one direction only.
    """
    angle, bank = (heading - cockpit.heading) % (2.0 * pi), cockpit.turn_bank()
    if angle > 2.0 * pi - THERE:  # already there, a little past it
        angle = 0.0
    cockpit.targets.heading = heading % (2.0 * pi)
    cockpit.begin(cockpit.name("turn"))
    cockpit.hold_bank(bank)
    yield from sweep(cockpit, angle, bank, lead=True)
    cockpit.hold_heading(heading)
    yield from until(
        cockpit,
        lambda: cockpit.within("heading") and abs(cockpit.bank) < LEVEL,
        ROLL_OUT_LIMIT,
        f"roll-out on {degrees(heading) % 360.0:03.0f}°",
    )


def sweep(cockpit: Cockpit, angle: float, bank: float, lead: bool = False) -> Ticks:
    """Turn through an angle [rad] to either side at a held bank [rad], less the lead of a roll-out.

    Raises SimulationError where it takes far longer than the bank's turn rate says.
    """
    rate = STANDARD_GRAVITY * tan(abs(bank)) / cockpit.true_airspeed
    swept = 0.0
    for _ in range(round((2.0 * angle / rate + ROLL_OUT_LIMIT) / TICK)):
        if abs(swept) >= angle - (_roll_out_lead(cockpit) if lead else 0.0):
            return
        before = cockpit.heading
        yield
        swept += (cockpit.heading - before + pi) % (2.0 * pi) - pi
    raise cockpit.plant.failure(f"the turn by {degrees(angle):.0f}° was not flown in twice its time")


def _roll_out_lead(cockpit: Cockpit) -> float:
    """Heading [rad] that passes while the wings are rolled level at the card's roll rate."""
    roll = max(cockpit.bank, 0.0)
    rate = STANDARD_GRAVITY * tan(roll) / cockpit.true_airspeed
    return 0.5 * rate * roll / cockpit.card.roll_rate_limit
