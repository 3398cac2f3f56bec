"""From a measured log to the missing effect: check, locate, name, close, patch, advise."""

from pitotbench.reconciliation.fitting import fit_gaps as fit_gaps
from pitotbench.reconciliation.free_parameters import AnalysisSetting as AnalysisSetting
from pitotbench.reconciliation.layout import lay_out as lay_out
from pitotbench.reconciliation.patches import patch_of_effects as patch_of_effects
from pitotbench.reconciliation.recording_checks import check_log as check_log
from pitotbench.reconciliation.verdict import judge as judge
