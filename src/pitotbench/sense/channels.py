"""The plain channels: truth, noise and resolution, one line each. Air data are built in `recorder`.

Noise is a field of DataSystem or, where it has none, a number for the usual instrument of that kind. Resolutions
are about a twentieth of the noise or finer: a word length that does not show, and keeps logs short.
"""

from dataclasses import dataclass

from pitotbench.records.case import DataSystem
from pitotbench.units import INCH_OF_MERCURY, POUND

_PER_HOUR = POUND / 3600.0  # kg/s


@dataclass(frozen=True, slots=True)
class Channel:
    """One line: name of the truth and of the log's column, noise (1σ) and resolution [SI]."""

    name: str
    noise: str | float
    resolution: float
    by_gps: bool = False
    angle_of_circle: bool = False  # wraps at a full turn

    def deviation(self, das: DataSystem) -> float:
        """Standard deviation of the white noise [SI]."""
        return float(getattr(das, self.noise)) if isinstance(self.noise, str) else self.noise


CHANNELS = (
    Channel("altitude", "altitude_noise", 0.01, by_gps=True),
    Channel("roll", "attitude_noise", 1e-4),
    Channel("pitch", "attitude_noise", 1e-4),
    Channel("heading", "attitude_noise", 1e-4, angle_of_circle=True),
    Channel("roll_rate", "rate_noise", 1e-4),
    Channel("pitch_rate", "rate_noise", 1e-4),
    Channel("yaw_rate", "rate_noise", 1e-4),
    Channel("specific_force_x", "acceleration_noise", 1e-3),
    Channel("specific_force_y", "acceleration_noise", 1e-3),
    Channel("specific_force_z", "acceleration_noise", 1e-3),
    Channel("angle_of_attack", "vane_noise", 1e-4),
    Channel("sideslip", "vane_noise", 1e-4),
    Channel("throttle_left", 0.002, 1e-4),  # position potentiometers: 0.2 % of travel
    Channel("throttle_right", 0.002, 1e-4),
    Channel("elevator", 0.001, 1e-4),  # 0.06°
    Channel("aileron", 0.001, 1e-4),
    Channel("rudder", 0.001, 1e-4),
    Channel("manifold_pressure_left", 0.05 * INCH_OF_MERCURY, 5.0),
    Channel("manifold_pressure_right", 0.05 * INCH_OF_MERCURY, 5.0),
    Channel("propeller_speed_left", 0.2, 0.01),  # 2 rpm
    Channel("propeller_speed_right", 0.2, 0.01),
    Channel("fuel_flow_left", 0.5 * _PER_HOUR, 1e-6),
    Channel("fuel_flow_right", 0.5 * _PER_HOUR, 1e-6),
    Channel("mass", 0.0, 0.1),  # of the weight sheet less fuel used: no noise, but a word length
)
