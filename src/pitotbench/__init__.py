"""pitotbench: a simulated flight-test bench for pitot-static calibration."""
