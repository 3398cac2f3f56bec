"""One flight of a log with its calibration."""

from dataclasses import dataclass

from pitotbench.records.calibration import Calibration
from pitotbench.records.log import FlightLog


@dataclass(frozen=True, slots=True)
class CalibratedFlight:
    """A flight of a log with its calibration.

    `place` is the index of the log among those given. `number` counts the flights of the log from 1, `count` is how
    many it holds; both are 1 where the log was reduced as one. `joined` is the number of flights, of all logs, that
    share the curve.
    """

    log: FlightLog
    calibration: Calibration
    place: int
    number: int = 1
    count: int = 1
    joined: int = 1
