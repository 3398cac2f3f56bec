"""The data systems of the source (Martos, Kiszely and Foster 2011, §II.C), and systems of any other rates.

Where the noise levels come from: the source adds white noise to the dynamic pressure, "an order of magnitude
higher than the specification sheet". Rosemount-class transducers are specified at 0.026 % of full scale (3σ).

- Impact pressure: full scale 2 psi = 13,789.5 Pa (a 280 KCAS instrument). 0.026 % of it is 3.59 Pa at 3σ, so
  1.195 Pa at 1σ; ten times that is 11.95 Pa: 12 Pa, which is 0.36 kt at 100 KCAS and 0.22 kt at 160 KCAS.
- Static pressure: full scale 38 inHg = 128,683 Pa. 0.026 % is 33.5 Pa at 3σ, 11.2 Pa at 1σ: 10 Pa is the
  specification itself, not raised, since the source corrupts the dynamic pressure only.
- Resolutions are those of 16-bit words over full scale: 0.2 Pa of 13,789.5 Pa, 1.5 Pa of about 103 kPa.
- Velocity: 0.05 m/s (1σ) for an integrated IMU/GPS solution; 0.1 m/s for a receiver alone, which prints
  hundredths of a meter per second. Both are common in data sheets; the choice is ours, the source gives none.
"""

import re
from dataclasses import replace

from pitotbench.catalog import Catalog, explain
from pitotbench.records.case import DataSystem
from pitotbench.records.errors import BadInputError
from pitotbench.records.integration import USUAL_RATE

INERTIAL_RATE = 10.0  # Hz, from which velocity counts as an integrated IMU/GPS solution

_HIGH_END = DataSystem()
_LOW_END = replace(_HIGH_END, velocity_noise=0.1, velocity_resolution=0.01)

SYSTEMS: Catalog[DataSystem] = Catalog(
    "data system",
    {
        "20/1": replace(_LOW_END, air_rate=20.0, gps_rate=1.0),
        "50/50": replace(_HIGH_END, air_rate=50.0, gps_rate=50.0),
        "100/100": replace(_HIGH_END, air_rate=100.0, gps_rate=100.0),
    },
)

_RATES = re.compile(r"\s*(\d+(?:\.\d+)?)\s*/\s*(\d+(?:\.\d+)?)\s*")


def data_system(text: str) -> DataSystem:
    """Return the data system of a name, such as `20/1`, or of any rates `A/G`: air data over GPS [Hz].

    The ratio need not be a whole number. A GPS below 10 Hz gets the noise of a receiver without inertial unit.
    Raises BadInputError for text that is not a pair of rates, and for rates that `require_rates` refuses.
    """
    if text in SYSTEMS:
        return SYSTEMS[text]
    rates = _RATES.fullmatch(text)
    if rates is None:
        raise BadInputError(
            f"{explain('data system', text, list(SYSTEMS))} Any rates in Hz will do, air data / GPS, such as 25/5."
        )
    air, gps = (float(rate) for rate in rates.groups())
    system = replace(_HIGH_END if gps >= INERTIAL_RATE else _LOW_END, air_rate=air, gps_rate=gps)
    require_rates(system, USUAL_RATE)
    return system


def require_rates(das: DataSystem, flight_rate: float) -> None:
    """Raise BadInputError unless 0 < GPS rate ≤ air-data rate ≤ rate of the flight [Hz]."""
    if not 0.0 < das.gps_rate <= das.air_rate:
        raise BadInputError(
            f"data system {das.label}: the GPS rate must be above 0 and not exceed the air-data rate; "
            "write air data first, for example 20/1"
        )
    # The rate of a flight is computed from its times, so it may be off by a rounding error.
    if das.air_rate > flight_rate * (1.0 + 1e-6):
        raise BadInputError(
            f"data system {das.label}: the air-data rate must not exceed the {flight_rate:g} Hz at which the "
            "flight is simulated; choose a lower one"
        )


def has_velocity_down(das: DataSystem) -> bool:
    """Return whether the system records velocity down.

    Where the system does not state it, only an integrated IMU/GPS does (the source, §II.C).
    """
    if das.vertical_velocity == "usual":
        return das.gps_rate >= INERTIAL_RATE
    return das.vertical_velocity == "recorded"
