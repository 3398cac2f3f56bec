"""pitotbench: a simulated flight-test bench for pitot-static calibration.

The public names, on one page.

A name is imported when it is first used, so that `import pitotbench` itself loads no other package.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pitotbench.bench.forecasts import PlanRequest as PlanRequest
    from pitotbench.bench.planner import plan as plan
    from pitotbench.bench.questions import calibrate as calibrate
    from pitotbench.bench.questions import fixed_speed as fixed_speed
    from pitotbench.bench.questions import inspect as inspect
    from pitotbench.bench.questions import reconcile as reconcile
    from pitotbench.bench.workflow import FullReconciliation as FullReconciliation
    from pitotbench.calibration.options import CalibrationOptions as CalibrationOptions
    from pitotbench.campaigns.campaign import CampaignRequest as CampaignRequest
    from pitotbench.campaigns.campaign import CampaignResult as CampaignResult
    from pitotbench.campaigns.campaign import run_campaign as run_campaign
    from pitotbench.campaigns.flights import score as score
    from pitotbench.campaigns.flights import sense as sense
    from pitotbench.catalog import UnknownNameError as UnknownNameError
    from pitotbench.logbook.formats import write_log as write_log
    from pitotbench.logbook.reading import read_log as read_log
    from pitotbench.records import BadInputError as BadInputError
    from pitotbench.records import NoAnswerError as NoAnswerError
    from pitotbench.records.calibration import Calibration as Calibration
    from pitotbench.records.case import Case as Case
    from pitotbench.records.case_file import read_case as read_case
    from pitotbench.records.case_file import write_case as write_case
    from pitotbench.records.flight import Flight as Flight
    from pitotbench.records.flight import Score as Score
    from pitotbench.records.forecast import Plan as Plan
    from pitotbench.records.log import FlightLog as FlightLog
    from pitotbench.records.verdict import Verdict as Verdict
    from pitotbench.simulation.sortie import fly as fly
    from pitotbench.version import __version__ as __version__

# The same names for Python as the block above for type checkers; a test compares the two.
_MODULES = {
    "BadInputError": "records",
    "Calibration": "records.calibration",
    "CalibrationOptions": "calibration.options",
    "CampaignRequest": "campaigns.campaign",
    "CampaignResult": "campaigns.campaign",
    "Case": "records.case",
    "Flight": "records.flight",
    "FlightLog": "records.log",
    "FullReconciliation": "bench.workflow",
    "NoAnswerError": "records",
    "Plan": "records.forecast",
    "PlanRequest": "bench.forecasts",
    "Score": "records.flight",
    "UnknownNameError": "catalog",
    "Verdict": "records.verdict",
    "calibrate": "bench.questions",
    "fixed_speed": "bench.questions",
    "fly": "simulation.sortie",
    "inspect": "bench.questions",
    "plan": "bench.planner",
    "read_case": "records.case_file",
    "read_log": "logbook.reading",
    "reconcile": "bench.questions",
    "run_campaign": "campaigns.campaign",
    "score": "campaigns.flights",
    "sense": "campaigns.flights",
    "write_case": "records.case_file",
    "write_log": "logbook.formats",
    "__version__": "version",
}

__all__ = [*_MODULES]  # noqa: PLE0604 - strings, though ruff cannot see it


def __getattr__(name: str) -> Any:
    """Import a public name on its first use."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
