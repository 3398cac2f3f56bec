"""From a measured log to the effect that a model lacks: check, locate, name, close, patch, advise."""

from pitotbench.reconcile.checks import check as check
from pitotbench.reconcile.judge import judge as judge
from pitotbench.reconcile.name import name as name
from pitotbench.reconcile.nuisance import Setting as Setting
from pitotbench.reconcile.patch import patch as patch
from pitotbench.reconcile.study import study as study
