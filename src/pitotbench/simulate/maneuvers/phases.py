"""The phases of flight that cards are made of: generators that yield once a tick, while the plant runs."""

from collections.abc import Callable, Iterator
from math import degrees, pi, tan

from pitotbench.records.errors import BadInputError
from pitotbench.simulate.maneuvers.cockpit import TICK, Cockpit
from pitotbench.units import DEGREE, KNOT, STANDARD_GRAVITY

Ticks = Iterator[None]

SET_UP_LIMIT = 240.0  # s, to reach a speed; idle 160 to 100 kt takes half a minute
SET_UP_HOLD = 5.0  # s, on speed before a set-up is over
SET_UP_AIRSPEED = 0.4 * KNOT  # m/s: largest deviation during the patience; tighter than any card's tolerance
SET_UP_PATIENCE = 60.0  # s; after it the card's tolerance is enough
SET_UP_WORST = 4.0 * KNOT  # m/s: largest deviation at the limit that turbulence may explain; more is an error
ROLL_OUT_LIMIT = 40.0  # s
THERE = 5.0 * DEGREE  # an airplane past its new heading by less does not turn a full circle to reach it
LEVEL = 3.0 * DEGREE  # bank below which a turn is over
ALL = ("airspeed", "heading", "altitude")
ACCELERATION_LIMIT = 180.0  # s, for either change of speed


def wait(seconds: float) -> Ticks:
    """Let time [s] pass."""
    for _ in range(round(seconds / TICK)):
        yield


def until(cockpit: Cockpit, reached: Callable[[], bool], limit: float, what: str) -> Ticks:
    """Fly on until a condition is met. Raises SimulationError, which names it as `what`, after a limit [s]."""
    for _ in range(round(limit / TICK)):
        if reached():
            return
        yield
    raise cockpit.plant.failure(f"{what} not reached within {limit:.0f} s")


def set_up(cockpit: Cockpit, airspeed: float, heading: float) -> Ticks:
    """Reach an airspeed [m/s] and heading [rad] in level flight. Not recorded: the paper's times exclude set-ups.

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
    """Let the aircraft settle for the card's time; for up to twice that while quantities are out of tolerance."""
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
    """Turn right to a heading [rad] at the card's bank and roll out on it.

    The bank is held until the roll-out begins, so that a turn by 180° cannot go to the left.
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
    """Turn through an angle [rad] at a constant bank [rad]; the sign of the bank is the side of the turn.

    With `lead`, stop early by the angle that the roll-out needs.
    Raises SimulationError where it takes far longer than the turn rate of the bank says.
    """
    # The turn is measured by adding small changes of heading: it may be more than a full circle.
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
    """Return the change of heading [rad] while the wings are rolled level at the card's roll rate."""
    # During the roll-out the turn rate falls to zero nearly linearly, so its mean is half the present one.
    roll = max(cockpit.bank, 0.0)
    rate = STANDARD_GRAVITY * tan(roll) / cockpit.true_airspeed
    return 0.5 * rate * roll / cockpit.card.roll_rate_limit


def accelerate(cockpit: Cockpit, airspeed: float) -> Ticks:
    """Hold a higher airspeed [m/s] by throttle until it is nearly reached.

    Raises SimulationError where it is not reached.
    """
    cockpit.hold_airspeed(airspeed)
    cockpit.begin(cockpit.name("accelerate"))
    what = f"acceleration to {airspeed / KNOT:.0f} KCAS"
    yield from until(cockpit, lambda: cockpit.airspeed >= airspeed - 1.0 * KNOT, ACCELERATION_LIMIT, what)


def decelerate(cockpit: Cockpit, airspeed: float, label: str) -> Ticks:
    """Slow down by throttle to near an airspeed [m/s], at most at the card's rate, straight or in a turn.

    Raises SimulationError where the speed is not reached.
    """
    cockpit.hold_airspeed(airspeed)
    cockpit.begin(label)
    what = f"deceleration to {airspeed / KNOT:.0f} KCAS"
    yield from until(cockpit, lambda: cockpit.airspeed <= airspeed + 1.0 * KNOT, ACCELERATION_LIMIT, what)


def require_steep_turns(bank: float) -> None:
    """Raise BadInputError for a bank [rad] below 5° or above 60°, to either side."""
    if not 5.0 * DEGREE <= abs(bank) <= 60.0 * DEGREE:
        raise BadInputError("the bank of a circle lies between 5° and 60°, to either side")


def step_down(cockpit: Cockpit, step: float, step_time: float, floor: float, *judged: str) -> Ticks:
    """Reduce the power in steps [Pa of manifold pressure], one each `step_time` [s], down to `floor` [m/s].

    Raises SimulationError where the power is at idle before that.
    """
    power, number = cockpit.power(), 0
    step, lowest = cockpit.power_step(step)
    while cockpit.airspeed > floor:
        power, number = power - step, number + 1
        if power < lowest:
            raise cockpit.plant.failure(f"{floor / KNOT:.0f} KCAS not reached with the power at idle")
        cockpit.set_power(power)
        cockpit.begin(f"step {number} {cockpit.power_words(power)}", *judged)
        for _ in range(round(step_time / TICK)):
            yield
            if cockpit.airspeed <= floor:
                return
