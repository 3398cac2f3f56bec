"""The cockpit that a card flies from: smoothed instruments, autopilot targets, the label of the segment."""

from dataclasses import dataclass
from math import atan, degrees, hypot, pi

from pitotbench.simulate.maneuvers.card import Card
from pitotbench.simulate.maneuvers.pilot import Hands
from pitotbench.simulate.plant import Plant
from pitotbench.units import INCH_OF_MERCURY, KNOT, STANDARD_GRAVITY

TICK = 0.1  # s between two looks at the instruments
EYE_TIME = 3.0  # s, over which the eye averages the airspeed needle about the inertial speed
INSTRUMENTS = (
    *("calibrated_airspeed", "true_airspeed", "heading", "roll", "altitude"),
    *("velocity_north", "velocity_east", "mean_wind_north", "mean_wind_east"),
)

LOWEST_MANIFOLD_PRESSURE = 8.0 * INCH_OF_MERCURY  # below idle: more steps change nothing
POWER_SPAN = 25.0 * INCH_OF_MERCURY  # of the bench's own aircraft, from 160 KCAS with power to spare down to idle

HEADING_HOLD, BANK_HOLD = 1, 2  # ap/lateral-mode
DIRECT, AIRSPEED_HOLD, MANIFOLD_PRESSURE_HOLD = 0, 1, 2  # ap/throttle-mode
ALTITUDE_BY_PITCH, AIRSPEED_BY_PITCH = 1, 2  # ap/pitch-mode


@dataclass(slots=True)
class Targets:
    """The values to hold: calibrated airspeed [m/s], true heading [rad], geometric altitude [m], bank [rad]."""

    airspeed: float
    heading: float
    altitude: float
    bank: float = 0.0


class Cockpit:
    """The instruments as a pilot reads them, and the controls of the autopilot.

    `airspeed` [m/s] is the needle as the eye averages it: gusts are smoothed over `EYE_TIME`, and a change of the
    inertial speed is followed at once, so that a true change of speed does not lag. `begin` names the segment,
    says whether it is recorded, and which quantities must be in tolerance for a sample to be on condition.
    """

    def __init__(self, plant: Plant, card: Card, targets: Targets, hands: Hands | None = None) -> None:
        self.plant = plant
        self._hands = hands or Hands(plant)
        self.card = card
        self.targets = targets
        self._tolerances = {q: getattr(card, f"{q}_tolerance") for q in ("airspeed", "heading", "altitude")}
        self.label = "set-up"
        self.recorded = False
        self._judged: tuple[str, ...] = ()
        self._reads = [plant.getter(name) for name in INSTRUMENTS]
        # The first look needs an airspeed and finds a jump of the inertial speed from zero; the second assignment
        # removes that jump.
        self.airspeed = plant.get("calibrated_airspeed")
        self._inertial = 0.0
        self.look()
        self.airspeed = plant.get("calibrated_airspeed")
        for name in ("bank_limit", "roll_rate_limit", "airspeed_rate_limit"):
            plant.set(name, getattr(card, name))
        self._hands.command("altitude_target", targets.altitude)

    def look(self) -> None:
        """Read the instruments, once a tick."""
        needle, self.true_airspeed, self.heading, self.bank, self.altitude, north, east, *wind = [
            read() * factor for read, factor in self._reads
        ]
        # A complementary filter: the speed through the mean wind gives fast changes, the needle the slow ones.
        before, self._inertial = self._inertial, hypot(north - wind[0], east - wind[1])
        self.airspeed += (self._inertial - before) * needle / self.true_airspeed
        self.airspeed += (needle - self.airspeed) * TICK / EYE_TIME

    def fly(self) -> None:
        """Let the pilot correct the deviations of this tick."""
        self._hands.tick(self.deviation, TICK)

    def begin(self, label: str, *judged: str, recorded: bool = True) -> None:
        """Start a segment. `judged` names quantities held to the card's tolerances: airspeed, heading, altitude."""
        self.label, self._judged, self.recorded = label, judged, recorded

    def on_condition(self) -> bool:
        """Return whether all judged quantities are within tolerance; False where none is judged."""
        return bool(self._judged) and self.within(*self._judged)

    def within(self, *quantities: str) -> bool:
        """Return whether quantities (airspeed, heading, altitude) are within the card's tolerances."""
        return all(abs(self.deviation(q)) <= self._tolerances[q] for q in quantities)

    def deviation(self, quantity: str) -> float:
        """Return the reading minus the target [SI]; for a heading, the short way around."""
        difference: float = getattr(self, quantity) - getattr(self.targets, quantity)
        return (difference + pi) % (2.0 * pi) - pi if quantity == "heading" else difference

    def hold_airspeed(self, airspeed: float) -> None:
        """Hold a calibrated airspeed [m/s] by throttle."""
        self.targets.airspeed = airspeed
        self._hands.command("airspeed_target", airspeed)
        self._hands.command("throttle_mode", AIRSPEED_HOLD)

    def hold_airspeed_by_pitch(self, airspeed: float) -> None:
        """Hold a calibrated airspeed [m/s] by pitch; nothing holds the altitude. The target does not change."""
        self._hands.command("airspeed_target", airspeed)
        self._hands.command("pitch_mode", AIRSPEED_BY_PITCH)

    def hold_altitude_by_pitch(self) -> None:
        """Hold the altitude by pitch again, as every maneuver begins."""
        self._hands.command("pitch_mode", ALTITUDE_BY_PITCH)

    def hold_heading(self, heading: float) -> None:
        """Hold a true heading [rad], turning the short way."""
        self.targets.heading = heading % (2.0 * pi)
        self._hands.command("heading_target", self.targets.heading)
        self._hands.command("lateral_mode", HEADING_HOLD)

    def hold_bank(self, bank: float) -> None:
        """Hold a bank angle [rad], right positive."""
        self.targets.bank = bank
        self._hands.command("bank_target", bank)
        self._hands.command("lateral_mode", BANK_HOLD)

    def hold_altitude(self, altitude: float) -> None:
        """Hold a geometric altitude [m], climbing or descending to it at the autopilot's rate."""
        self.targets.altitude = altitude
        self._hands.command("altitude_target", altitude)

    def hold_sideslip(self, sideslip: float) -> None:
        """Hold a sideslip [rad] by rudder, flow from the right positive; bank holds the heading."""
        self._hands.command("sideslip_target", sideslip)

    def set_power(self, power: float) -> None:
        """Hold a power setting on all engines, as `power` reads it."""
        if self.plant.attached:
            self.set_throttle(min(max(power, 0.0), 1.0))
        else:
            self._hands.command("manifold_pressure_target", power)
            self._hands.command("throttle_mode", MANIFOLD_PRESSURE_HOLD)

    def set_throttle(self, position: float) -> None:
        """Set both throttles, 0 (idle) to 1."""
        self._hands.command("throttle_command", position)
        self._hands.command("throttle_mode", DIRECT)

    def power(self) -> float:
        """Return the power setting: the manifold pressure [Pa], mean of both engines.

        It is the throttle lever, 0 to 1, where the autopilot was attached: a lever is what all engines have.
        """
        if self.plant.attached:
            return self.plant.get("ap/lever-norm")
        return 0.5 * (self.plant.get("manifold_pressure_left") + self.plant.get("manifold_pressure_right"))

    def power_step(self, step: float) -> tuple[float, float]:
        """Return the change of the power setting for a step [Pa] of manifold pressure, and the lowest setting.

        A lever goes from here to idle in as many steps as the manifold pressure of the bench's own aircraft does.
        """
        if not self.plant.attached:
            return step, LOWEST_MANIFOLD_PRESSURE
        idle = self.plant.get("ap/model/lever-idle")
        return (self.power() - idle) * step / POWER_SPAN, idle

    def power_words(self, power: float) -> str:
        """Return a power setting for a label."""
        return f"{100.0 * power:.0f} %" if self.plant.attached else f"{power / INCH_OF_MERCURY:.1f} inHg"

    def turn_bank(self) -> float:
        """Return the bank [rad] of a level, coordinated turn at the card's rate and the present true airspeed.

        The bank limit of the card is the largest value.
        """
        bank = atan(self.true_airspeed * self.card.turn_rate / STANDARD_GRAVITY)
        return min(bank, self.card.bank_limit)

    def name(self, kind: str, detail: str = "") -> str:
        """Return the label of a segment: kind, target airspeed, heading, detail. For example `leg 160 kt 090°`."""
        label = f"{kind} {self.targets.airspeed / KNOT:.0f} kt {degrees(self.targets.heading):03.0f}°"
        return f"{label} {detail}".rstrip()
