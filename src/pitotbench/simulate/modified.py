"""The aircraft and the air of a case with its effects in them."""

from functools import reduce
from operator import add

from pitotbench.effects import AircraftEffect, Overlay, chosen
from pitotbench.effects.air.recorded_time import RECORDING_START
from pitotbench.records.case import Case
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.plant import Plant


def overlay_of(case: Case) -> Overlay:
    """What the effects of a case put on its aircraft and its air; those on the sensors are left to `sense`.

    Raises UnknownNameError for an unknown effect, BadInputError for parameters that cannot be or an aircraft that
    lacks what an effect changes.
    """
    choices = [c for c in chosen(case.effects) if isinstance(c.effect, AircraftEffect)]
    if not choices:
        return Overlay()
    baseline = read_baseline(find_aircraft(case.aircraft))
    parts = [c.effect.overlay(c.sizes, baseline) for c in choices if isinstance(c.effect, AircraftEffect)]
    return reduce(add, parts, Overlay())


def mark_recording(plant: Plant) -> None:
    """Tell effects that count time from the first recorded sample that it comes with the next step."""
    if plant.serves(RECORDING_START):
        plant.set(RECORDING_START, plant.get("time") + plant.time_step)
