"""The pilot of a maneuver: the cockpit, the phases of a flight, and how a pilot flies them."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import atan, degrees, hypot, pi, tan

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.simulation.card import Card
from pitotbench.simulation.plant import Plant
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, STANDARD_GRAVITY, percent_text

CORRECTED = 0.7  # share of a noticed deviation that one correction takes out
# thresholds; a larger deviation is a commanded change under way, not an error to correct
PURSUED = 5.0
HEADING_HOLD, BANK_HOLD = 1, 2  # ap/lateral-mode
DIRECT, AIRSPEED_HOLD, MANIFOLD_PRESSURE_HOLD = 0, 1, 2  # ap/throttle-mode
ALTITUDE_BY_PITCH, AIRSPEED_BY_PITCH = 1, 2  # ap/pitch-mode
# The modes in which the autopilot holds a quantity: the throttle or the nose holds an airspeed.
COMMANDED_IN_MODE = {
    "airspeed": (("throttle_mode", AIRSPEED_HOLD), ("pitch_mode", AIRSPEED_BY_PITCH)),
    "altitude": (("pitch_mode", ALTITUDE_BY_PITCH),),
    "heading": (("lateral_mode", HEADING_HOLD),),
    "bank": (("lateral_mode", BANK_HOLD),),
}


# quantity: the wait after a correction [s], the deviation that is noticed [SI], and the random walk
# of the commanded value [SI a square-root second]; airspeed answers the throttle slowly
HABITS = {
    "airspeed": (12.0, 0.5 * KNOT, 0.05 * KNOT),
    "altitude": (6.0, 20.0 * FOOT, 1.5 * FOOT),
    "heading": (3.0, 0.7 * DEGREE, 0.15 * DEGREE),
    "bank": (3.0, 1.5 * DEGREE, 0.25 * DEGREE),
}
SETTING_ERROR = 0.1  # inHg, 1σ of a manifold-pressure setting


class AutopilotOnly:
    """The autopilot alone: each command of the card is set at once and kept exactly."""

    def __init__(self, plant: Plant, truth_seed: int = 1) -> None:
        self._plant = plant

    def command(self, name: str, value: float) -> None:
        """Set a control of the property table [SI]."""
        self._plant.set(name, value)

    def tick(self, deviation: Callable[[str], float], seconds: float) -> None:
        """Let time pass [s]; `deviation(quantity)` is the reading minus the target [SI].

        Nothing is corrected.
        """


class Person(AutopilotOnly):
    """A pilot with reaction time, gauge thresholds and remnant, drawn from the truth seed.

    The person is an intermittent controller (Craik 1948; Neilson and others since). Between
    corrections the command drifts at random (the remnant of McRuer and Jex 1967). A deviation is
    noticed only when it is larger than a glance at the gauge shows. It is corrected in part; then
    the pilot waits for the aircraft to respond. The autopilot keeps stick and rudder, so this
    models how well targets are kept, not handling qualities. All sizes are estimates: a good pilot
    stays within the paper's tolerances most of the time in smooth air, a busy one does not.

    `reaction` [s] is the delay of each command; all sizes but the waits are multiplied by
    `coarseness`.
    """

    reaction, coarseness = 0.5, 1.0

    def __init__(self, plant: Plant, truth_seed: int = 1) -> None:
        super().__init__(plant)
        self._random = np.random.default_rng(np.random.SeedSequence(truth_seed).spawn(1)[0])
        self._now = 0.0
        self._waiting: deque[tuple[float, str, float]] = deque()
        self._commanded: dict[str, float] = {"pitch_mode": 1}  # as the flight begins
        self._offsets: dict[str, float] = {}
        self._next_correction: dict[str, float] = {}

    def command(self, name: str, value: float) -> None:
        """Set a control [SI] after the reaction time; a manifold pressure is set with an error."""
        if name == "manifold_pressure_target":
            value += self._random.normal(0.0, self.coarseness * SETTING_ERROR * INCH_OF_MERCURY)
        self._waiting.append((self._now + self.reaction, name, value))

    def tick(self, deviation: Callable[[str], float], seconds: float) -> None:
        """Set the commands that are due, let the values drift, and correct what is noticed."""
        self._now += seconds
        while self._waiting and self._waiting[0][0] <= self._now:
            _, name, value = self._waiting.popleft()
            self._commanded[name] = value
            self._offsets.pop(name.removesuffix("_target"), None)
            self._plant.set(name, value)
        for quantity in HABITS:
            in_mode = any(
                self._commanded.get(name) == mode for name, mode in COMMANDED_IN_MODE[quantity]
            )
            if in_mode and f"{quantity}_target" in self._commanded:
                self._hold(quantity, deviation(quantity), seconds)

    def _hold(self, quantity: str, deviation: float, seconds: float) -> None:
        patience, *sizes = HABITS[quantity]
        threshold, drift = (self.coarseness * size for size in sizes)
        offset = self._offsets.get(quantity, 0.0)
        offset += self._random.normal(0.0, drift * seconds**0.5)
        # A person corrects again only after the patience: a correction needs time to show.
        noticed = threshold < abs(deviation) < PURSUED * threshold
        if noticed and self._now >= self._next_correction.get(quantity, 0.0):
            offset -= CORRECTED * deviation
            self._next_correction[quantity] = self._now + patience
        self._offsets[quantity] = min(max(offset, -PURSUED * threshold), PURSUED * threshold)
        self._plant.set(
            f"{quantity}_target", self._commanded[f"{quantity}_target"] + self._offsets[quantity]
        )


class BusyPerson(Person):
    """The same person busy: reaction time, thresholds, drifts and setting error are doubled."""

    reaction, coarseness = 1.0, 2.0


PILOTS: Catalog[type[AutopilotOnly]] = Catalog(
    "pilot", {"none": AutopilotOnly, "good": Person, "busy": BusyPerson}
)
TICK = 0.1  # s between two readings of the instruments
EYE_TIME = 3.0  # s, over which the eye averages the airspeed needle about the inertial speed
INSTRUMENTS = (
    *("calibrated_airspeed", "true_airspeed", "heading", "roll", "altitude"),
    *("velocity_north", "velocity_east", "mean_wind_north", "mean_wind_east"),
)

LOWEST_MANIFOLD_PRESSURE = 8.0 * INCH_OF_MERCURY  # below idle: more steps change nothing
# of the bench's own aircraft, from 160 KCAS with power to spare down to idle
POWER_SPAN = 25.0 * INCH_OF_MERCURY


@dataclass(slots=True)
class Targets:
    """The values to hold: calibrated airspeed [m/s], true heading, altitude [m], bank [rad].

    The altitude is geometric.
    """

    airspeed: float
    heading: float
    altitude: float
    bank: float = 0.0


class Cockpit:
    """The instruments as a pilot reads them, and the controls of the autopilot.

    `airspeed` [m/s] is the needle as the eye averages it: gusts are smoothed over `EYE_TIME`, and a
    change of the inertial speed is followed at once, so that a true change of speed does not lag.
    `begin` names the segment, says whether it is recorded, and which quantities must be in
    tolerance for a sample to be on condition.
    """

    def __init__(
        self, plant: Plant, card: Card, targets: Targets, pilot: AutopilotOnly | None = None
    ) -> None:
        self.plant = plant
        self._pilot = pilot or AutopilotOnly(plant)
        self.card = card
        self.targets = targets
        self._tolerances = {
            q: getattr(card, f"{q}_tolerance") for q in ("airspeed", "heading", "altitude")
        }
        self.label = "set-up"
        self.recorded = False
        self._judged: tuple[str, ...] = ()
        self._reads = [plant.getter(name) for name in INSTRUMENTS]
        # The first reading needs an airspeed and finds a jump of the inertial speed from zero; the
        # second assignment removes that jump.
        self.airspeed = plant.get("calibrated_airspeed")
        self._inertial = 0.0
        self.read_instruments()
        self.airspeed = plant.get("calibrated_airspeed")
        for name in ("bank_limit", "roll_rate_limit", "airspeed_rate_limit"):
            plant.set(name, getattr(card, name))
        self._pilot.command("altitude_target", targets.altitude)

    def read_instruments(self) -> None:
        """Read the instruments, once a tick."""
        needle, self.true_airspeed, self.heading, self.bank, self.altitude, north, east, *wind = [
            read() * factor for read, factor in self._reads
        ]
        # A complementary filter: the speed through the mean wind gives fast changes, the needle the
        # slow ones.
        before, self._inertial = self._inertial, hypot(north - wind[0], east - wind[1])
        self.airspeed += (self._inertial - before) * needle / self.true_airspeed
        self.airspeed += (needle - self.airspeed) * TICK / EYE_TIME

    def fly(self) -> None:
        """Let the pilot correct the deviations of this tick."""
        self._pilot.tick(self.deviation, TICK)

    def begin(self, label: str, *judged: str, recorded: bool = True) -> None:
        """Start a segment.

        `judged` names quantities held to the card's tolerances: airspeed, heading, altitude.
        """
        self.label, self._judged, self.recorded = label, judged, recorded

    def on_condition(self) -> bool:
        """Return whether all judged quantities are within tolerance; False where none is judged."""
        return bool(self._judged) and self.within(*self._judged)

    def within(self, *quantities: str) -> bool:
        """Return whether airspeed, heading, altitude are within the card's tolerances."""
        return all(abs(self.deviation(q)) <= self._tolerances[q] for q in quantities)

    def deviation(self, quantity: str) -> float:
        """Return the reading minus the target [SI]; for a heading, the short way around."""
        difference: float = getattr(self, quantity) - getattr(self.targets, quantity)
        return (difference + pi) % (2.0 * pi) - pi if quantity == "heading" else difference

    def hold_airspeed(self, airspeed: float) -> None:
        """Hold a calibrated airspeed [m/s] by throttle."""
        self.targets.airspeed = airspeed
        self._pilot.command("airspeed_target", airspeed)
        self._pilot.command("throttle_mode", AIRSPEED_HOLD)

    def hold_airspeed_by_pitch(self, airspeed: float) -> None:
        """Hold a calibrated airspeed [m/s] by pitch; nothing holds the altitude.

        The altitude's target does not change.
        """
        self._pilot.command("airspeed_target", airspeed)
        self._pilot.command("pitch_mode", AIRSPEED_BY_PITCH)

    def hold_altitude_by_pitch(self) -> None:
        """Hold the altitude by pitch again, as every maneuver begins."""
        self._pilot.command("pitch_mode", ALTITUDE_BY_PITCH)

    def hold_heading(self, heading: float) -> None:
        """Hold a true heading [rad], turning the short way."""
        self.targets.heading = heading % (2.0 * pi)
        self._pilot.command("heading_target", self.targets.heading)
        self._pilot.command("lateral_mode", HEADING_HOLD)

    def hold_bank(self, bank: float) -> None:
        """Hold a bank angle [rad], right positive."""
        self.targets.bank = bank
        self._pilot.command("bank_target", bank)
        self._pilot.command("lateral_mode", BANK_HOLD)

    def hold_altitude(self, altitude: float) -> None:
        """Hold a geometric altitude [m], climbing or descending to it at the autopilot's rate."""
        self.targets.altitude = altitude
        self._pilot.command("altitude_target", altitude)

    def hold_sideslip(self, sideslip: float) -> None:
        """Hold a sideslip [rad] by rudder, flow from the right positive; bank holds the heading."""
        self._pilot.command("sideslip_target", sideslip)

    def set_power(self, power: float) -> None:
        """Hold a power setting on all engines, as `power` reads it."""
        if self.plant.attached:
            self.set_throttle(min(max(power, 0.0), 1.0))
        else:
            self._pilot.command("manifold_pressure_target", power)
            self._pilot.command("throttle_mode", MANIFOLD_PRESSURE_HOLD)

    def set_throttle(self, position: float) -> None:
        """Set both throttles, 0 (idle) to 1."""
        self._pilot.command("throttle_command", position)
        self._pilot.command("throttle_mode", DIRECT)

    def power(self) -> float:
        """Return the power setting: mean manifold pressure [Pa], or throttle lever [0 to 1].

        The lever is that of an attached autopilot: all engines have one.
        """
        if self.plant.attached:
            return self.plant.get("ap/lever-norm")
        return 0.5 * (
            self.plant.get("manifold_pressure_left") + self.plant.get("manifold_pressure_right")
        )

    def power_step(self, step: float) -> tuple[float, float]:
        """Return the power setting's change for a step [Pa of manifold pressure], and its lowest.

        A lever goes from here to idle in as many steps as the manifold pressure of the bench's own
        aircraft does.
        """
        if not self.plant.attached:
            return step, LOWEST_MANIFOLD_PRESSURE
        idle = self.plant.get("ap/model/lever-idle")
        return (self.power() - idle) * step / POWER_SPAN, idle

    def power_words(self, power: float) -> str:
        """Return a power setting for a label."""
        return percent_text(power) if self.plant.attached else f"{power / INCH_OF_MERCURY:.1f} inHg"

    def turn_bank(self) -> float:
        """Return the bank [rad] of a level turn at the card's rate and the present true airspeed.

        The turn is coordinated. The bank limit of the card is the largest value.
        """
        bank = atan(self.true_airspeed * self.card.turn_rate / STANDARD_GRAVITY)
        return min(bank, self.card.bank_limit)

    def name(self, kind: str) -> str:
        """Return the label of a segment: kind, target airspeed, heading; `leg 160 kt 090°`."""
        return (
            f"{kind} {self.targets.airspeed / KNOT:.0f} kt {degrees(self.targets.heading):03.0f}°"
        )


Ticks = Iterator[None]  # of a phase of flight, which yields once a tick while the plant runs
SET_UP_LIMIT = 240.0  # s, to reach a speed; idle 160 to 100 kt takes half a minute
SET_UP_HOLD = 5.0  # s, on speed before a set-up is over
# m/s: largest deviation during the patience; tighter than any card's tolerance
SET_UP_AIRSPEED = 0.4 * KNOT
SET_UP_PATIENCE = 60.0  # s; after it the card's tolerance is enough
# m/s: largest deviation at the limit that turbulence may explain; more is an error
SET_UP_WORST = 4.0 * KNOT
ROLL_OUT_LIMIT = 40.0  # s
# an airplane past its new heading by less does not turn a full circle to reach it
THERE = 5.0 * DEGREE
LEVEL = 3.0 * DEGREE  # bank below which a turn is over
ALL = ("airspeed", "heading", "altitude")
ACCELERATION_LIMIT = 180.0  # s, for either change of speed
CLIMB_LIMIT = 240.0  # s, for either change of height
LEVEL_OFF = 10.0  # m below or above the target height: a climb or descent ends there


def wait(seconds: float) -> Ticks:
    """Let time [s] pass."""
    for _ in range(round(seconds / TICK)):
        yield


def until(cockpit: Cockpit, reached: Callable[[], bool], limit: float, what: str) -> Ticks:
    """Fly on until a condition is met.

    Raises SimulationError, which names it as `what`, after a limit [s].
    """
    for _ in range(round(limit / TICK)):
        if reached():
            return
        yield
    raise cockpit.plant.failure(f"{what} not reached within {limit:.0f} s")


def set_up(cockpit: Cockpit, airspeed: float, heading: float) -> Ticks:
    """Reach an airspeed [m/s] and heading [rad] in level flight, unrecorded.

    The paper's times exclude set-ups.

    Raises SimulationError where the aircraft does not get there.
    """
    cockpit.hold_airspeed(airspeed)
    cockpit.hold_heading(heading)
    cockpit.begin(cockpit.name("set-up"), recorded=False)
    steady = 0.0
    for tick in range(round(SET_UP_LIMIT / TICK)):
        near = abs(cockpit.deviation("airspeed")) < SET_UP_AIRSPEED or tick * TICK > SET_UP_PATIENCE
        steady = (
            steady + TICK if near and abs(cockpit.bank) < LEVEL and cockpit.within(*ALL) else 0.0
        )
        if steady >= SET_UP_HOLD:
            return
        yield
    off = cockpit.deviation("airspeed")
    if abs(off) > SET_UP_WORST:  # less is turbulence: the log says what was achieved
        raise cockpit.plant.failure(
            f"{airspeed / KNOT:.0f} KCAS in level flight was not reached ({off / KNOT:+.1f} kt "
            "off); choose a speed that it holds"
        )


def settle(cockpit: Cockpit, label: str = "", quantities: tuple[str, ...] = ALL) -> Ticks:
    """Let the aircraft settle for the card's time, or up to twice that while out of tolerance.

    The `quantities` are those whose tolerances count.
    """
    cockpit.begin(label or cockpit.name("settle"))
    yield from wait(cockpit.card.settle)
    for _ in range(round(cockpit.card.settle / TICK)):
        if cockpit.within(*quantities):
            return
        yield


def leg(cockpit: Cockpit, seconds: float, *judged: str) -> Ticks:
    """Fly straight and level for a time [s], by default judged by airspeed, heading, altitude."""
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
    """Turn through an angle [rad] at a constant bank [rad], whose sign is the turn's side.

    With `lead`, stop early by the angle that the roll-out needs. Raises SimulationError where it
    takes far longer than the turn rate of the bank says.
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
    raise cockpit.plant.failure(
        f"the turn by {degrees(angle):.0f}° was not flown in twice its time"
    )


def _roll_out_lead(cockpit: Cockpit) -> float:
    """Return the change of heading [rad] while the wings roll level at the card's rate."""
    # During the roll-out the turn rate falls to zero nearly linearly, so its mean is half the
    # present one.
    roll = abs(cockpit.bank)
    rate = STANDARD_GRAVITY * tan(roll) / cockpit.true_airspeed
    return 0.5 * rate * roll / cockpit.card.roll_rate_limit


def accelerate(cockpit: Cockpit, airspeed: float) -> Ticks:
    """Hold a higher airspeed [m/s] by throttle until it is nearly reached.

    Raises SimulationError where it is not reached.
    """
    cockpit.hold_airspeed(airspeed)
    cockpit.begin(cockpit.name("accelerate"))
    what = f"acceleration to {airspeed / KNOT:.0f} KCAS"
    yield from until(
        cockpit, lambda: cockpit.airspeed >= airspeed - 1.0 * KNOT, ACCELERATION_LIMIT, what
    )


def decelerate(cockpit: Cockpit, airspeed: float, label: str) -> Ticks:
    """Slow down by throttle, at most at the card's rate, to near an airspeed [m/s].

    The flight is straight or in a turn. Raises SimulationError where the speed is not reached.
    """
    cockpit.hold_airspeed(airspeed)
    cockpit.begin(label)
    yield from slowed(cockpit, airspeed, 1.0 * KNOT)


def slowed(cockpit: Cockpit, airspeed: float, near: float = 0.0) -> Ticks:
    """Fly on until the airplane has slowed down to an airspeed [m/s], or so near [m/s] above it.

    Raises SimulationError where it does not.
    """
    what = f"deceleration to {airspeed / KNOT:.0f} KCAS"
    yield from until(cockpit, lambda: cockpit.airspeed <= airspeed + near, ACCELERATION_LIMIT, what)


def change_height(cockpit: Cockpit, label: str, altitude: float) -> Ticks:
    """Climb or descend to an altitude [m] at constant airspeed and settle there."""
    cockpit.hold_altitude(altitude)
    cockpit.begin(cockpit.name(label))
    what = f"{label} to {altitude / FOOT:.0f} ft"
    yield from until(
        cockpit, lambda: abs(cockpit.deviation("altitude")) < LEVEL_OFF, CLIMB_LIMIT, what
    )
    yield from settle(cockpit)


def step_down(cockpit: Cockpit, step: float, step_time: float, floor: float, *judged: str) -> Ticks:
    """Reduce power by steps [Pa of manifold pressure], `step_time` [s] each, to `floor` [m/s].

    Raises SimulationError where the power is at idle before that.
    """
    power, number = cockpit.power(), 0
    step, lowest = cockpit.power_step(step)
    while cockpit.airspeed > floor:
        power, number = power - step, number + 1
        if power < lowest:
            raise cockpit.plant.failure(
                f"{floor / KNOT:.0f} KCAS not reached with the power at idle"
            )
        cockpit.set_power(power)
        cockpit.begin(f"step {number} {cockpit.power_words(power)}", *judged)
        for _ in range(round(step_time / TICK)):
            yield
            if cockpit.airspeed <= floor:
                return
