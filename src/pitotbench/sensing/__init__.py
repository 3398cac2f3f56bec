"""Turn a Flight (the truth) into a FlightLog (a data system's recording), (n,) in SI."""

from pitotbench.sensing.recorder import CALIBRATION_CHANNELS as CALIBRATION_CHANNELS
from pitotbench.sensing.recorder import LOG_CHANNELS as LOG_CHANNELS
from pitotbench.sensing.recorder import record as record
from pitotbench.sensing.recorder import truth_path as truth_path
from pitotbench.sensing.recorder import write_truth as write_truth
from pitotbench.sensing.sampling import SYSTEMS as SYSTEMS
from pitotbench.sensing.sampling import data_system as data_system
from pitotbench.sensing.sampling import has_velocity_down as has_velocity_down
