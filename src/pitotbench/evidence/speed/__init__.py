"""Ratios of CPU time that do not depend on the machine."""
