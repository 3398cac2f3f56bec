"""The table of open questions: a newcomer is one file and one line here."""

from pitotbench.catalog import Catalog
from pitotbench.study.sweeps.conditions import CONDITIONS
from pitotbench.study.sweeps.density import DENSITY
from pitotbench.study.sweeps.rates import RATES_SWEEP
from pitotbench.study.sweeps.sideslip import SIDESLIP
from pitotbench.study.sweeps.structure import STRUCTURE
from pitotbench.study.sweeps.sweep import Reply as Reply
from pitotbench.study.sweeps.sweep import Sweep as Sweep
from pitotbench.study.sweeps.wind import WIND

_TABLE = (WIND, SIDESLIP, RATES_SWEEP, STRUCTURE, DENSITY, CONDITIONS)

SWEEPS: Catalog[Sweep] = Catalog("sweep", {sweep.name: sweep for sweep in _TABLE})
