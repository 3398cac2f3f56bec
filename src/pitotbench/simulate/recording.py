"""Record every channel at the simulator's rate: one packed row a step, converted to SI block by block."""

import struct
from collections.abc import Collection, Iterator, Sequence
from operator import call

import numpy as np

from pitotbench.simulate.plant import Plant
from pitotbench.simulate.properties import CHANNELS, PROPERTIES, Property
from pitotbench.units import Array

BLOCK = 1000  # rows packed before they are transposed: 0.4 MB, which a processor's cache still holds
_ALWAYS = ("time", "mass")  # the mass divides the forces


def lines_of(names: Collection[str] | None) -> tuple[Property, ...]:
    """Return the lines of the table for some channels, with time and mass; all for None.

    Raises UnknownNameError for a name that is not in the table.
    """
    if names is None:
        return CHANNELS
    wanted = {PROPERTIES[name].name for name in (*_ALWAYS, *names)}
    return tuple(line for line in CHANNELS if line.name in wanted)


class Recorder:
    """Run a plant and keep channels of the table, by default all that its aircraft serves, at every step.

    Rows are packed into one buffer that is used again and again. This costs a quarter of the time of a bare step
    of JSBSim; assigning each row to an array costs a third.
    """

    def __init__(self, plant: Plant, channels: Sequence[Property] = ()) -> None:
        self._plant = plant
        channels = channels or plant.channels
        self._channels = channels
        self._factors = np.array([[line.factor] for line in channels])
        self._rows = np.empty((BLOCK, len(channels)))
        self._row_size = self._rows.strides[0]
        self._reads = [plant.getter(line.name)[0] for line in channels]
        self._pack = struct.Struct(f"{len(channels)}d").pack_into
        self._end = 0
        self._blocks: list[Array] = []

    def advance(self, steps: int) -> None:
        """Run the plant a number of steps and record after each. Raises SimulationError where JSBSim stops."""
        run, pack, rows, reads = self._plant.fdm.run, self._pack, self._rows.data, self._reads
        for count in _batches(steps, BLOCK):
            if self._end + count > BLOCK:
                self._flush()
            first = self._end
            for row in range(first, first + count):
                if not run():
                    raise self._plant.failure("JSBSim stopped")
                pack(rows, row * self._row_size, *map(call, reads))
            self._end = first + count

    def _flush(self) -> None:
        # The product with the factors transposes the rows: one pass gives contiguous channels in SI.
        block = np.empty((len(self._channels), self._end))
        np.multiply(self._rows[: self._end].T, self._factors, out=block)
        finite = np.isfinite(block).all(axis=1)
        if not finite.all():
            bad = self._channels[int(np.argmin(finite))].name
            raise self._plant.failure(f"channel {bad!r} is not finite")
        self._blocks.append(block)
        self._end = 0

    def channels(self) -> dict[str, Array]:
        """Return the recorded channels by name [SI], one contiguous array (n,) a channel.

        Raises SimulationError where a value is not finite.
        """
        self._flush()
        found = {
            line.name: np.concatenate([block[i] for block in self._blocks]) for i, line in enumerate(self._channels)
        }
        for line in self._channels:
            if line.per_mass:
                found[line.name] /= found["mass"]
        return found


def record_channels(plant: Plant, seconds: float) -> dict[str, Array]:
    """Run a plant for a time [s] and return its channels by name [SI], each (n,) with one value a step."""
    recorder = Recorder(plant)
    for count in _batches(round(seconds / plant.time_step), max(1, round(0.1 / plant.time_step))):
        recorder.advance(count)
        plant.check()
    return recorder.channels()


def _batches(steps: int, batch: int) -> Iterator[int]:
    """Split `steps` into batches of at most `batch`."""
    return (min(batch, steps - done) for done in range(0, steps, batch))
