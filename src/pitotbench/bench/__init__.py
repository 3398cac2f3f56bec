"""Fly, sense, calibrate, and compare with the truth. No other package of the product joins these
stages.
"""

from pitotbench.bench.flights import SCORED_RANGE as SCORED_RANGE
from pitotbench.bench.flights import fly_to_log as fly_to_log
from pitotbench.bench.flights import score as score
from pitotbench.bench.flights import sense as sense
from pitotbench.bench.flights import tolerances as tolerances
from pitotbench.bench.flights import true_correction as true_correction
from pitotbench.bench.flights import wind_toward as wind_toward
from pitotbench.calibration import calibrate as calibrate
from pitotbench.calibration import calibrate_flights as calibrate_flights
from pitotbench.calibration.leg_points import cross_check as cross_check
from pitotbench.calibration.leg_points import fixed_speed_points as fixed_speed_points
from pitotbench.calibration.options import CalibrationOptions as CalibrationOptions
from pitotbench.simulation.sortie import fly as fly
