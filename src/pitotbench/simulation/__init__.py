"""Fly a case in JSBSim. No other package imports jsbsim."""
