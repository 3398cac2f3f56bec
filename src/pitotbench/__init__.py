"""pitotbench: a simulated flight-test bench for pitot-static calibration. The public names, on one page."""

from pitotbench.bench import calibrate as calibrate
from pitotbench.bench import fly as fly
from pitotbench.bench import score as score
from pitotbench.bench import sense as sense
from pitotbench.calibrate import CalibrationOptions as CalibrationOptions
from pitotbench.calibrate import fixed_speed as fixed_speed
from pitotbench.logbook import read_log as read_log
from pitotbench.logbook import write_log as write_log
from pitotbench.records.calibration import Calibration as Calibration
from pitotbench.records.case import Case as Case
from pitotbench.records.case_file import read_case as read_case
from pitotbench.records.errors import BadInputError as BadInputError
from pitotbench.records.errors import NoAnswerError as NoAnswerError
from pitotbench.records.log import FlightLog as FlightLog

__version__ = "0.1.0"
