"""The table between JSBSim and the bench: one line a property.

A line has our name, its path and its factor to SI: SI value = property * factor. Names are those of
`channels.py` where both have the quantity. JSBSim creates a property that is written under a wrong
path, without an error; `plant.check_table` finds such paths when an aircraft is loaded.
"""

from dataclasses import dataclass

from pitotbench.catalog import Catalog
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, POUND, POUND_FORCE, PSF, SLUG

RANKINE = 5.0 / 9.0  # K
REVOLUTION_PER_MINUTE = 2.0 * 3.141592653589793 / 60.0  # rad/s
HORSEPOWER = 550.0 * POUND_FORCE * FOOT  # W


@dataclass(frozen=True, slots=True)
class Property:
    """One line of the table.

    `per_mass` means that the recorded value is divided by the mass of the same sample.
    """

    name: str
    path: str
    factor: float = 1.0
    writable: bool = False
    per_mass: bool = False


# Specific force comes from the force of the present state: accelerations/Nx.. are one step old.
CHANNELS = (
    Property("time", "simulation/sim-time-sec"),
    Property("latitude", "position/lat-geod-rad"),
    Property("longitude", "position/long-gc-rad"),
    Property("position_north", "position/from-start-neu-n-ft", FOOT),
    Property("position_east", "position/from-start-neu-e-ft", FOOT),
    Property("altitude", "position/h-sl-ft", FOOT),
    Property("velocity_north", "velocities/v-north-fps", FOOT),
    Property("velocity_east", "velocities/v-east-fps", FOOT),
    Property("velocity_down", "velocities/v-down-fps", FOOT),
    Property("roll", "attitude/phi-rad"),
    Property("pitch", "attitude/theta-rad"),
    Property("heading", "attitude/psi-rad"),
    Property("roll_rate", "velocities/p-rad_sec"),
    Property("pitch_rate", "velocities/q-rad_sec"),
    Property("yaw_rate", "velocities/r-rad_sec"),
    Property("specific_force_x", "forces/fbx-total-lbs", POUND_FORCE, per_mass=True),
    Property("specific_force_y", "forces/fby-total-lbs", POUND_FORCE, per_mass=True),
    Property("specific_force_z", "forces/fbz-total-lbs", POUND_FORCE, per_mass=True),
    Property("angle_of_attack", "aero/alpha-rad"),
    Property("sideslip", "aero/beta-rad"),
    Property("total_pressure", "propulsion/pt-lbs_sqft", PSF),
    Property("static_pressure", "atmosphere/P-psf", PSF),
    Property("air_temperature", "atmosphere/T-R", RANKINE),
    Property("total_temperature", "propulsion/tat-r", RANKINE),
    Property("calibrated_airspeed", "velocities/vc-kts", KNOT),
    Property("true_airspeed", "velocities/vt-fps", FOOT),
    Property("mach", "velocities/mach"),
    Property("wind_north", "atmosphere/total-wind-north-fps", FOOT),
    Property("wind_east", "atmosphere/total-wind-east-fps", FOOT),
    Property("wind_down", "atmosphere/total-wind-down-fps", FOOT),
    Property("throttle_left", "fcs/throttle-pos-norm"),
    Property("throttle_right", "fcs/throttle-pos-norm[1]"),
    Property("elevator", "fcs/elevator-pos-rad"),
    Property("aileron", "fcs/left-aileron-pos-rad"),
    Property("rudder", "fcs/rudder-pos-rad"),
    Property("manifold_pressure_left", "propulsion/engine/map-inhg", INCH_OF_MERCURY),
    Property("manifold_pressure_right", "propulsion/engine[1]/map-inhg", INCH_OF_MERCURY),
    Property("propeller_speed_left", "propulsion/engine/propeller-rpm", REVOLUTION_PER_MINUTE),
    Property("propeller_speed_right", "propulsion/engine[1]/propeller-rpm", REVOLUTION_PER_MINUTE),
    Property("fuel_flow_left", "propulsion/engine/fuel-flow-rate-pps", POUND),
    Property("fuel_flow_right", "propulsion/engine[1]/fuel-flow-rate-pps", POUND),
    Property("power_left", "propulsion/engine/power-hp", HORSEPOWER),
    Property("power_right", "propulsion/engine[1]/power-hp", HORSEPOWER),
    Property("thrust_left", "propulsion/engine/thrust-lbs", POUND_FORCE),
    Property("thrust_right", "propulsion/engine[1]/thrust-lbs", POUND_FORCE),
    Property("mass", "inertia/mass-slugs", SLUG),
    Property("flap", "fcs/flap-pos-norm"),
)

# Of every autopilot, and of the air.
COMMON_CONTROLS = (
    Property("lateral_mode", "ap/lateral-mode", writable=True),
    Property("heading_target", "ap/heading-target-deg", DEGREE, writable=True),
    Property("bank_target", "ap/bank-target-deg", DEGREE, writable=True),
    Property("bank_limit", "ap/bank-limit-deg", DEGREE, writable=True),
    Property("roll_rate_limit", "ap/roll-rate-limit-degps", DEGREE, writable=True),
    Property("sideslip_target", "ap/sideslip-target-deg", DEGREE, writable=True),
    Property("pitch_mode", "ap/pitch-mode", writable=True),
    Property("altitude_target", "ap/altitude-target-ft", FOOT, writable=True),
    Property("pitch_target", "ap/pitch-target-deg", DEGREE, writable=True),
    Property("throttle_mode", "ap/throttle-mode", writable=True),
    Property("throttle_command", "ap/throttle-command-norm", writable=True),
    Property("airspeed_target", "ap/kcas-target-kt", KNOT, writable=True),
    Property("airspeed_rate_limit", "ap/kcas-rate-limit-ktps", KNOT, writable=True),
    Property("throttle_bias_left", "ap/throttle-bias-left-norm", writable=True),
    Property("throttle_bias_right", "ap/throttle-bias-right-norm", writable=True),
    Property("mean_wind_north", "atmosphere/wind-north-fps", FOOT, writable=True),
    Property("mean_wind_east", "atmosphere/wind-east-fps", FOOT, writable=True),
    Property("mean_wind_down", "atmosphere/wind-down-fps", FOOT, writable=True),
    Property("temperature_offset", "atmosphere/delta-T", RANKINE, writable=True),
    Property("turbulence_type", "atmosphere/turb-type", writable=True),
    Property("turbulence_severity", "atmosphere/turbulence/milspec/severity", writable=True),
    Property(
        "turbulence_low_wind", "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps", FOOT, True
    ),
    Property("turbulence_seed", "atmosphere/randomseed", writable=True),
)

# Of the autopilots of the bench's own aircraft. One that is attached to any other sets the throttle
# lever instead.
OWN_CONTROLS = (
    Property("manifold_pressure_target", "ap/map-target-inhg", INCH_OF_MERCURY, writable=True),
)

PROPERTIES = Catalog(
    "property", {line.name: line for line in (*CHANNELS, *COMMON_CONTROLS, *OWN_CONTROLS)}
)
