"""Fly a case in JSBSim. No other package imports jsbsim."""

from pitotbench.simulate.fdm import SimulationError as SimulationError
from pitotbench.simulate.maneuvers import MANEUVERS as MANEUVERS
from pitotbench.simulate.maneuvers import PAPER_MANEUVERS as PAPER_MANEUVERS
from pitotbench.simulate.modified import install_variant as install_variant
from pitotbench.simulate.plant import Plant as Plant
from pitotbench.simulate.sortie import fly as fly
