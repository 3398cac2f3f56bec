"""Which airspeeds of a log were flown on one side of the compass only: what to fly again."""

import numpy as np

from pitotbench import air
from pitotbench.records.calibration import Calibration, OneSided
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, Booleans

_BANDS = 8  # of airspeed, between the ends of a curve
_SECTORS = 12  # of track, 30° each
_LEAST_SHARE = 0.03  # of a band's rows: a sector with fewer is passed in a turn, not flown
_SIDE = 180.0  # °: tracks of no more than this lie on one side


def one_sided(log: FlightLog, result: Calibration) -> tuple[OneSided, ...]:
    """Return the slowest and the fastest airspeeds of a calibration that were flown on one side of
    the compass only, at most one each, by the rows of its log that were used.
    """
    used = result.residuals.used
    if len(used) != len(log) or not used.any():
        return ()
    speed = np.asarray(air.calibrated_airspeed(np.maximum(log.impact_pressure[used], 0.0)))
    track = np.arctan2(log.velocity_east[used], log.velocity_north[used]) / DEGREE % 360.0
    slowest, fastest = map(float, result.curve.indicated_airspeed[[0, -1]])
    edges = [float(each) for each in np.linspace(slowest, fastest, _BANDS + 1)]
    sectors = np.linspace(0.0, 360.0, _SECTORS + 1)
    count, _, _ = np.histogram2d(speed, track, bins=[edges, sectors])
    flown = count > _LEAST_SHARE * count.sum(axis=1, keepdims=True)
    slow = [(edges[0], edges[k], _arc(flown[:k])) for k in range(1, _BANDS + 1)]
    fast = [(edges[-k - 1], edges[-1], _arc(flown[-k:])) for k in range(1, _BANDS + 1)]
    found = [
        [OneSided(low, high, *arc) for low, high, arc in ends if arc is not None][-1:]
        for ends in (slow, fast)
    ]
    return tuple(dict.fromkeys(found[0] + found[1]))


def _arc(flown: Booleans) -> tuple[float, float] | None:
    """The tracks flown in some bands, clockwise from the first to the last [°]; None for none and
    for those of more than one side.
    """
    places, sector = np.flatnonzero(flown.any(axis=0)), 360.0 / _SECTORS
    if not len(places):
        return None
    gaps = np.diff(places, append=places[0] + _SECTORS)
    widest = int(np.argmax(gaps))
    begin, end = places[(widest + 1) % len(places)], places[widest] + 1
    return (begin * sector, end * sector % 360.0) if (gaps[widest] - 1) * sector >= _SIDE else None
