"""Attach the bench's autopilot to any fixed-wing aircraft of JSBSim. Arrays are SI and radians."""
