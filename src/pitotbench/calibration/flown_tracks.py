"""Which airspeeds of a log were flown on one side of the compass only: what to fly again."""

import numpy as np

from pitotbench import air
from pitotbench.records.calibration import Calibration, OneSided
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, Array

_PARTS = 3  # of the airspeeds of a curve: a slow, a middle and a fast one
_SECTORS = 12  # of track, 30° each
_LEAST_SHARE = 0.03  # of the rows: a sector with fewer is passed in a turn, not flown
_TURN = 360.0  # °: tracks of half of it, and less, lie on one side


def one_sided(log: FlightLog, result: Calibration) -> tuple[OneSided, ...]:
    """Return the airspeeds, slow or fast, that were flown on one side of the compass only.

    The slow and the fast third of a calibration's airspeeds are judged by the rows of its log that
    were used.
    """
    used = result.residuals.used
    if len(used) != len(log):  # of several logs joined, each flight has its own
        return ()
    speed = np.asarray(air.calibrated_airspeed(np.maximum(log.impact_pressure[used], 0.0)))
    track = np.arctan2(log.velocity_east[used], log.velocity_north[used]) / DEGREE % _TURN
    known = result.curve.indicated_airspeed
    edges = [float(v) for v in np.linspace(float(known[0]), float(known[-1]), _PARTS + 1)]
    # Gusts carry rows of the outermost airspeeds beyond the ends of the curve.
    thirds = (edges[0], edges[1], speed <= edges[1]), (edges[-2], edges[-1], speed >= edges[-2])
    arcs = [(low, high, _arc(track[rows])) for low, high, rows in thirds]
    return tuple(OneSided(low, high, *arc) for low, high, arc in arcs if arc is not None)


def _arc(track: Array) -> tuple[float, float] | None:
    """Return the arc that holds all tracks flown (n,) [°], None where they lie on several sides.

    The arc goes clockwise from its begin to its end.
    """
    count, edges = np.histogram(track, np.linspace(0.0, _TURN, _SECTORS + 1))
    flown = np.flatnonzero(count > _LEAST_SHARE * len(track))
    if not len(flown):
        return None
    empty = np.diff(flown, append=flown[0] + _SECTORS) - 1  # sectors clockwise of each
    widest = int(np.argmax(empty))
    if 2 * empty[widest] < _SECTORS:
        return None
    begin, end = flown[(widest + 1) % len(flown)], flown[widest] + 1
    return float(edges[begin]), float(edges[end]) % _TURN
