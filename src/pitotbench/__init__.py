"""pitotbench: a simulated flight-test bench for pitot-static calibration. The public names, on one page.

A name is imported when it is first used, so that `import pitotbench` itself loads no other package.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pitotbench.bench import score as score
    from pitotbench.bench import sense as sense
    from pitotbench.bench.campaign.runner import CampaignRequest as CampaignRequest
    from pitotbench.bench.campaign.runner import CampaignResult as CampaignResult
    from pitotbench.bench.campaign.runner import run_campaign as run_campaign
    from pitotbench.bench.plan.plan_request import PlanRequest as PlanRequest
    from pitotbench.bench.questions import plan as plan
    from pitotbench.bench.questions import reconcile as reconcile
    from pitotbench.bench.reconcile.workflow import FullReconciliation as FullReconciliation
    from pitotbench.calibrate import calibrate as calibrate
    from pitotbench.calibrate.gps_legs.methods import fixed_speed as fixed_speed
    from pitotbench.calibrate.options import CalibrationOptions as CalibrationOptions
    from pitotbench.logbook import read_log as read_log
    from pitotbench.logbook import write_log as write_log
    from pitotbench.records.calibration import Calibration as Calibration
    from pitotbench.records.case import Case as Case
    from pitotbench.records.case_file import read_case as read_case
    from pitotbench.records.case_file import write_case as write_case
    from pitotbench.records.errors import BadInputError as BadInputError
    from pitotbench.records.errors import NoAnswerError as NoAnswerError
    from pitotbench.records.flight import Flight as Flight
    from pitotbench.records.forecast import Plan as Plan
    from pitotbench.records.log import FlightLog as FlightLog
    from pitotbench.records.score import Score as Score
    from pitotbench.records.verdict import Verdict as Verdict
    from pitotbench.simulate import fly as fly

__version__ = "0.1.0"

# The same names for Python as the block above for type checkers; a test compares the two.
_MODULES = {
    "BadInputError": "records.errors",
    "Calibration": "records.calibration",
    "CalibrationOptions": "calibrate.options",
    "CampaignRequest": "bench.campaign.runner",
    "CampaignResult": "bench.campaign.runner",
    "Case": "records.case",
    "Flight": "records.flight",
    "FlightLog": "records.log",
    "FullReconciliation": "bench.reconcile.workflow",
    "NoAnswerError": "records.errors",
    "Plan": "records.forecast",
    "PlanRequest": "bench.plan.plan_request",
    "Score": "records.score",
    "Verdict": "records.verdict",
    "calibrate": "calibrate",
    "fixed_speed": "calibrate.gps_legs.methods",
    "fly": "simulate",
    "plan": "bench.questions",
    "read_case": "records.case_file",
    "read_log": "logbook",
    "reconcile": "bench.questions",
    "run_campaign": "bench.campaign.runner",
    "score": "bench",
    "sense": "bench",
    "write_case": "records.case_file",
    "write_log": "logbook",
}

__all__ = [*_MODULES, "__version__"]  # noqa: PLE0604 - strings, though ruff cannot see it


def __getattr__(name: str) -> Any:
    """Import a public name on its first use."""
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _PublicPage(ModuleType):
    """The package, in which a public name stays what the table says.

    `calibrate`, `reconcile` and `sense` are functions here and packages below. When Python imports such a package,
    it sets the attribute of this name to the package, and the function would be lost.
    """

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _MODULES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _PublicPage
