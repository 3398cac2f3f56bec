"""From a measured log to the effect that the model lacks: check, locate, name, close, patch, advise."""

from pitotbench.reconcile.decide.judgment import judge as judge
from pitotbench.reconcile.decide.naming import name_effects as name_effects
from pitotbench.reconcile.decide.patches import patch_of_effects as patch_of_effects
from pitotbench.reconcile.log_checks import check_log as check_log
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting as AnalysisSetting
from pitotbench.reconcile.residuals.layout import lay_out as lay_out
