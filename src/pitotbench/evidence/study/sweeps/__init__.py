"""The table of open questions. A new question is one file and one line here."""

from pitotbench.catalog import Catalog
from pitotbench.evidence.study.sweeps.changing_wind import WIND
from pitotbench.evidence.study.sweeps.conditions import CONDITIONS
from pitotbench.evidence.study.sweeps.model_choice import STRUCTURE
from pitotbench.evidence.study.sweeps.sampling_density import DENSITY
from pitotbench.evidence.study.sweeps.sampling_rates import RATES_SWEEP
from pitotbench.evidence.study.sweeps.sideslip import SIDESLIP
from pitotbench.evidence.study.sweeps.sweep import Reply as Reply
from pitotbench.evidence.study.sweeps.sweep import Sweep as Sweep

_TABLE = (WIND, SIDESLIP, RATES_SWEEP, STRUCTURE, DENSITY, CONDITIONS)

SWEEPS: Catalog[Sweep] = Catalog("sweep", {sweep.name: sweep for sweep in _TABLE})
