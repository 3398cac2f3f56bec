"""Fly a case in JSBSim. No other package imports jsbsim."""

from pitotbench.simulation.aircraft_files import SimulationError as SimulationError
from pitotbench.simulation.maneuvers import MANEUVERS as MANEUVERS
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS as PAPER_MANEUVERS
from pitotbench.simulation.modified import install_variant as install_variant
from pitotbench.simulation.plant import Plant as Plant
from pitotbench.simulation.sortie import fly as fly
