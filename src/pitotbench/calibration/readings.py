"""A finding about a column of a log: by how much the answer moves where the column is read anew."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.reduction import reduce_log
from pitotbench.calibration.result import assemble
from pitotbench.logbook.plausible_air import HEIGHT, NO_AIR, NO_TOTAL
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import CalibratedFlight, Calibration, Disagreement
from pitotbench.records.log import Caution, CurveMove, FlightLog
from pitotbench.units import KNOT

# By the code of a finding, the log as it would be read otherwise.
_OTHERS: dict[str, Callable[[FlightLog], FlightLog]] = {
    NO_AIR: lambda a: replace(a, total_temperature=a.air_temperature, air_temperature=None),
    NO_TOTAL: lambda a: replace(a, air_temperature=a.total_temperature, total_temperature=None),
    HEIGHT: lambda a: replace(a, altitude=None),
}


def with_readings(flight: CalibratedFlight, options: CalibrationOptions) -> Calibration:
    """Return the calibration of a flight with what a wrong column would move in its curve.

    A finding that moves it by more than a quarter of its 2σ is a disagreement; any other remains a
    note. Both say by how much.
    """
    result, log = flight.calibration, flight.log
    for caution in result.warnings:
        if caution.code not in _OTHERS:
            continue
        others = tuple(each for each in result.warnings if each != caution)
        try:
            # Flights that share a curve are compared alone: the other logs do not change.
            before = result if flight.joined == 1 else assemble(reduce_log(log, options))
            after = assemble(reduce_log(_OTHERS[caution.code](log), options))
        except (BadInputError, NoAnswerError):
            continue  # nothing is known of what it moves: it remains a doubt
        speed, bound = before.curve.indicated_airspeed, before.curve.two_sigma
        curve = after.curve
        moved = np.interp(speed, curve.indicated_airspeed, curve.correction)
        moved -= before.curve.correction
        at = int(np.argmax(np.abs(moved) / bound))
        moves = CurveMove(float(np.max(np.abs(moved))), float(np.abs(moved[at]) / bound[at]))
        words = (
            f"{caution}; read so, the curve moves by {moved[at] / KNOT:+.2f} kt at "
            f"{speed[at] / KNOT:.0f} KIAS"
        )
        if moves.matters:
            finding = Disagreement("reading", words, moves.most, fatal=False)
            disagreements = (*result.disagreements, finding)
            result = replace(result, disagreements=disagreements, warnings=others)
        else:
            note = Caution(words, caution.code, caution.column, moves=moves)
            result = replace(result, warnings=(*others, note))
    return result
