"""Answer two of the bench's four questions with one call each: `plan` and `reconcile`.

`calibrate` answers the other two: the error curve, and the bound of its error.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from pitotbench.records.case import Case
from pitotbench.records.forecast import Plan
from pitotbench.records.log import FlightLog

if TYPE_CHECKING:
    from pitotbench.bench.planner import PlanRequest
    from pitotbench.bench.workflow import FullReconciliation
    from pitotbench.reconciliation.free_parameters import AnalysisSetting


def plan(request: "PlanRequest", search_flights: int = 0) -> Plan:
    """Predict the 2σ bound of every maneuver of a request, and choose the maneuver to fly.

    Parameters: request; search_flights, the number of simulated flights to spend on a better card for the best
    maneuver (the command `pitotbench plan` spends 40).
    Raises NoAnswerError where no maneuver of the request can be flown.
    """
    from pitotbench.bench.planner import make_plan

    return make_plan(request, search_flights)


def reconcile(
    logs: FlightLog | Sequence[FlightLog],
    aircraft: str = "navajo",
    holdout: FlightLog | None = None,
    card: Case | None = None,
    setting: "AnalysisSetting | None" = None,
    refly: bool = True,
    progress: Callable[[str], None] | None = None,
) -> "FullReconciliation":
    """Find where a simulation and measured logs disagree, and name the effect that the simulation lacks.

    Parameters: logs, a measured one, or several of one airplane whose causes and sizes are the same; aircraft,
    a model of the hangar, or `none` to judge the sensors alone; holdout, another log of the same airplane on which
    the gap has to shrink too; card, what was flown (default: the card in the header of each log); setting, what is
    known of the logs beyond their rows; refly, whether the card is flown again with the named effects; progress,
    called with a line of text at each step.
    Returns a record with the `verdict`, the `probabilities` of the causes, the `sizes`, the `patch` and the figures
    of each of the `flights`. It shows itself in a notebook.
    Raises BadInputError for a log that cannot be used, UnknownNameError for an aircraft that is not known.
    """
    from pitotbench.bench.rounds import NamedLog
    from pitotbench.bench.workflow import reconcile_fully

    other = None if holdout is None else NamedLog("held-out log", holdout)
    several = [logs] if isinstance(logs, FlightLog) else list(logs)
    names = ["measured log"] if len(several) == 1 else [f"flight {i}" for i in range(1, len(several) + 1)]
    measured = [NamedLog(name, log) for name, log in zip(names, several, strict=True)]
    return reconcile_fully(measured, aircraft, other, card, progress, setting, refly)
