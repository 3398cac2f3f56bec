"""FlightLog to Calibration. Nothing in this package can reach the truth of a simulated flight.

The estimators load with the first calibration, so that options and the arithmetic of legs do not wait for SciPy.
"""

from collections.abc import Sequence

from pitotbench.calibrate.accuracy import Accuracies as Accuracies
from pitotbench.calibrate.accuracy import accuracies_from as accuracies_from
from pitotbench.calibrate.gps_legs.methods import FixedSpeedResult as FixedSpeedResult
from pitotbench.calibrate.gps_legs.methods import fixed_speed as fixed_speed
from pitotbench.calibrate.one_thread import one_thread
from pitotbench.calibrate.options import AUTO
from pitotbench.calibrate.options import CalibrationOptions as CalibrationOptions
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog


def calibrate(log: FlightLog, options: CalibrationOptions | None = None) -> Calibration:
    """Recover the pressure-error curve and the wind from a log.

    Parameters: log; options (defaults: Inverse+, covering method).
    Raises BadInputError for a log that cannot be used, NoAnswerError for one that does not determine the answer.
    Source: Martos, Kiszely and Foster (2011) for the problem; see `covering` and `output_error` for the methods.
    """
    from pitotbench.calibrate.averaging.model_average import calibrate_auto
    from pitotbench.calibrate.observability import require_useful
    from pitotbench.calibrate.reduction import reduce_log
    from pitotbench.calibrate.result import assemble

    chosen = options or CalibrationOptions()
    with one_thread():
        calibration = calibrate_auto(log, chosen) if chosen.model == AUTO else assemble(reduce_log(log, chosen))
    require_useful(calibration)
    return calibration


def calibrate_together(
    logs: Sequence[FlightLog], options: CalibrationOptions | None = None
) -> tuple[Calibration, ...]:
    """One curve for several logs of one airplane, each with its own wind: a Calibration a log, one curve in all.

    Raises as `calibrate` does; a warning says where the logs disagree about the curve.
    """
    from pitotbench.calibrate.joint_fit import reduce_together
    from pitotbench.calibrate.observability import require_useful
    from pitotbench.calibrate.result import assemble

    chosen = options or CalibrationOptions()
    if chosen.model == AUTO:
        raise BadInputError("several logs have a curve in common only of one model: name it, or use --separately")
    with one_thread():
        calibrations = tuple(
            assemble(reduction, airspeeds) for reduction, airspeeds in reduce_together(logs, chosen)
        )
    for calibration in calibrations:
        require_useful(calibration)
    return calibrations
