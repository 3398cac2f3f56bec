"""Turn a Flight (the truth) into a FlightLog (the recording of a data system). Channels, (n,), are SI."""

from pitotbench.sense.das import SYSTEMS as SYSTEMS
from pitotbench.sense.das import data_system as data_system
from pitotbench.sense.das import has_velocity_down as has_velocity_down
from pitotbench.sense.recorder import CALIBRATION_CHANNELS as CALIBRATION_CHANNELS
from pitotbench.sense.recorder import LOG_CHANNELS as LOG_CHANNELS
from pitotbench.sense.recorder import record as record
from pitotbench.sense.truth import read_truth as read_truth
from pitotbench.sense.truth import truth_path as truth_path
from pitotbench.sense.truth import write_truth as write_truth
