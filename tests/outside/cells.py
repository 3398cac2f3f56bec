"""The cells: one kind of air, airplane and instruments each, that the bound has to cover."""

from dataclasses import dataclass, replace

from tests.outside.compressible import FOOT, KNOT
from tests.outside.moving_air import SlowWind, front, mountain_wave, steady_change, still

SHORT = ("step_decrease", "rapid_decel", "circle")
# Mostly the short ones, as the long ones cost time; an odd number, so that each meets both rates of GPS.
ALL = (*SHORT, *SHORT, "race_track", *SHORT, *SHORT, *SHORT, "four_leg")


@dataclass(frozen=True, slots=True)
class Cell:
    """One row of the judge's table; the defaults are those of the cell `base`."""

    name: str
    says: str
    maneuvers: tuple[str, ...] = SHORT  # flown in turn
    low: float = 100.0 * KNOT  # m/s, indicated airspeeds of the maneuver
    high: float = 160.0 * KNOT
    height: float = 6000.0 * FOOT  # m
    gusts: str = "ou"  # or von_karman
    gust_sigma: float = 0.5  # m/s, a component
    gust_length: float = 300.0  # m
    bursts: bool = False
    thermals: bool = False
    carried: bool = False
    slow_wind: SlowWind = still
    probe_offset: float = 0.0  # K, of either sign
    airspeed_step: float = 0.0  # m/s
    gps_late: float = 0.0  # s
    two_slopes: bool = False


BASE = Cell("base", "gusts 0.5 m/s of 300 m, every assumption holds", maneuvers=ALL)
_AIR = replace(BASE, maneuvers=SHORT)

CELLS: dict[str, Cell] = {
    cell.name: cell
    for cell in (
        BASE,
        replace(_AIR, name="calm", says="no gusts at all", gust_sigma=0.0),
        replace(
            _AIR, name="jet", says="200-350 kt at 20,000 ft", low=200 * KNOT, high=350 * KNOT, height=20000 * FOOT
        ),
        replace(_AIR, name="probe_2k", says="temperature 2 K off", probe_offset=2.0),
        replace(_AIR, name="probe_5k", says="temperature 5 K off", probe_offset=5.0),
        replace(_AIR, name="length_100", says="gusts of 100 m", gust_length=100.0),
        replace(_AIR, name="length_2000", says="gusts of 2,000 m", gust_length=2000.0),
        replace(_AIR, name="von_karman", says="von Karman gusts of 533 m", gusts="von_karman", gust_length=533.0),
        replace(_AIR, name="wave", says="mountain wave 1 m/s, 300 s", slow_wind=mountain_wave),
        replace(_AIR, name="front", says="front 3 m/s in 20 s", slow_wind=front),
        replace(_AIR, name="linear", says="wind changes by 3 m/s in 10 min", slow_wind=steady_change),
        replace(_AIR, name="steps", says="airspeed in steps of 1 kt", airspeed_step=KNOT),
        replace(
            _AIR, name="calm_steps", says="airspeed in steps of 1 kt, calm", airspeed_step=KNOT, gust_sigma=0.0
        ),
        replace(_AIR, name="two_slope", says="error curve with a kink", two_slopes=True),
        replace(_AIR, name="bursts", says="gusts in bursts x 4", bursts=True),
        replace(_AIR, name="thermals", says="thermals 2 m/s over gusts 0.3 m/s", thermals=True, gust_sigma=0.3),
        replace(_AIR, name="carried", says="the airplane answers the gusts", carried=True),
        replace(_AIR, name="late", says="GPS 0.5 s late", gps_late=0.5),
        replace(
            _AIR,
            name="uav",
            says="29-58 kt at 500 ft, gusts of 150 m",
            low=29 * KNOT,
            high=58 * KNOT,
            height=500 * FOOT,
            gust_length=150.0,
        ),
    )
}
