"""What a card sees and moves: smoothed instruments, autopilot targets, the label of the segment."""

from dataclasses import dataclass
from math import atan, degrees, hypot, pi

from pitotbench.simulate.maneuvers.card import Card
from pitotbench.simulate.maneuvers.pilot import Hands
from pitotbench.simulate.plant import Plant
from pitotbench.units import KNOT, STANDARD_GRAVITY

TICK = 0.1  # s between two looks at the instruments
EYE_TIME = 3.0  # s, over which the eye averages the airspeed needle about the inertial speed
SEEN = (
    *("calibrated_airspeed", "true_airspeed", "heading", "roll", "altitude"),
    *("velocity_north", "velocity_east", "mean_wind_north", "mean_wind_east"),
)

HEADING_HOLD, BANK_HOLD = 1, 2  # ap/lateral-mode
DIRECT, AIRSPEED_HOLD, MANIFOLD_PRESSURE_HOLD = 0, 1, 2  # ap/throttle-mode


@dataclass(slots=True)
class Targets:
    """What is flown: calibrated airspeed [m/s], true heading [rad], geometric altitude [m], bank [rad]."""

    airspeed: float
    heading: float
    altitude: float
    bank: float = 0.0


class Cockpit:
    """The instruments as a pilot's eye reads them, and the controls of the autopilot.

    `airspeed` is the needle smoothed over `EYE_TIME` about the inertial speed, so that gusts average out and a
    true change of speed does not lag. `begin` names the segment, says whether it is recorded and which quantities
    must be in tolerance for a sample to be on condition.
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
        self._reads = [plant.getter(name) for name in SEEN]
        self.airspeed = plant.get("calibrated_airspeed")
        self._inertial = 0.0
        self.look()
        self.airspeed = plant.get("calibrated_airspeed")
        for name in ("bank_limit", "roll_rate_limit", "airspeed_rate_limit"):
            plant.set(name, getattr(card, name))
        self._hands.command("altitude_target", targets.altitude)

    def look(self) -> None:
        """Read the instruments; called once a tick. The inertial speed is that through the mean wind."""
        needle, self.true_airspeed, self.heading, self.bank, self.altitude, north, east, *wind = [
            read() * factor for read, factor in self._reads
        ]
        before, self._inertial = self._inertial, hypot(north - wind[0], east - wind[1])
        self.airspeed += (self._inertial - before) * needle / self.true_airspeed
        self.airspeed += (needle - self.airspeed) * TICK / EYE_TIME

    def fly(self) -> None:
        """Let the hands do what the deviations of this tick ask for."""
        self._hands.tick(self.deviation, TICK)

    def begin(self, label: str, *judged: str, recorded: bool = True) -> None:
        """Start a segment; `judged` are among airspeed, heading, altitude, with the card's tolerances."""
        self.label, self._judged, self.recorded = label, judged, recorded

    def on_condition(self) -> bool:
        """Whether all judged quantities are within tolerance; False where none is judged."""
        return bool(self._judged) and self.within(*self._judged)

    def within(self, *quantities: str) -> bool:
        """Whether quantities (airspeed, heading, altitude) are within the card's tolerances."""
        return all(abs(self.deviation(q)) <= self._tolerances[q] for q in quantities)

    def deviation(self, quantity: str) -> float:
        """Read minus target [SI]; headings the short way around."""
        difference: float = getattr(self, quantity) - getattr(self.targets, quantity)
        return (difference + pi) % (2.0 * pi) - pi if quantity == "heading" else difference

    def hold_airspeed(self, airspeed: float) -> None:
        """Hold a calibrated airspeed [m/s] by throttle."""
        self.targets.airspeed = airspeed
        self._hands.command("airspeed_target", airspeed)
        self._hands.command("throttle_mode", AIRSPEED_HOLD)

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
        """Hold a sideslip [rad] by rudder, wind from the right positive; the heading stays held by bank."""
        self._hands.command("sideslip_target", sideslip)

    def set_manifold_pressure(self, pressure: float) -> None:
        """Hold a manifold pressure [Pa] on both engines."""
        self._hands.command("manifold_pressure_target", pressure)
        self._hands.command("throttle_mode", MANIFOLD_PRESSURE_HOLD)

    def set_throttle(self, position: float) -> None:
        """Set both throttles, 0 (idle) to 1."""
        self._hands.command("throttle_command", position)
        self._hands.command("throttle_mode", DIRECT)

    def manifold_pressure(self) -> float:
        """Manifold pressure [Pa], mean of both engines."""
        return 0.5 * (self.plant.get("manifold_pressure_left") + self.plant.get("manifold_pressure_right"))

    def turn_bank(self) -> float:
        """The bank [rad] of a level, coordinated turn at the card's rate and the present true airspeed."""
        bank = atan(self.true_airspeed * self.card.turn_rate / STANDARD_GRAVITY)
        return min(bank, self.card.bank_limit)

    def name(self, kind: str, detail: str = "") -> str:
        """A segment's label: kind, target airspeed, heading, detail."""
        label = f"{kind} {self.targets.airspeed / KNOT:.0f} kt {degrees(self.targets.heading):03.0f}°"
        return f"{label} {detail}".rstrip()
