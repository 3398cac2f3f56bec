"""What a plant does over a time, in the channels of a flight, and what tells one flight from
another.
"""

import hashlib

from pitotbench import Flight
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.sortie import Recorder
from pitotbench.units import Array


def record_channels(plant: Plant, seconds: float) -> dict[str, Array]:
    """Run a plant for a time [s] and return its channels by name [SI], each (n,) with one value a
    step.
    """
    recorder = Recorder(plant)
    steps, batch = round(seconds / plant.time_step), max(1, round(0.1 / plant.time_step))
    for done in range(0, steps, batch):
        recorder.advance(min(batch, steps - done))
        plant.check()
    return recorder.channels()


def digest(flight: Flight) -> str:
    return hashlib.sha256(
        b"".join(flight[name].tobytes() for name in sorted(flight.channels))
    ).hexdigest()
