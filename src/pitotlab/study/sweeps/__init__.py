"""The table of open questions. A new question is a function on the page of its family, and one line
here.
"""

from pitotbench.catalog import Catalog
from pitotlab.study.questions import Reply as Reply
from pitotlab.study.questions import Sweep as Sweep
from pitotlab.study.sweeps.air import CONDITIONS, SIDESLIP, WIND
from pitotlab.study.sweeps.sampling import DENSITY, RATES_SWEEP, STRUCTURE

_TABLE = (WIND, SIDESLIP, RATES_SWEEP, STRUCTURE, DENSITY, CONDITIONS)

SWEEPS: Catalog[Sweep] = Catalog("sweep", {sweep.name: sweep for sweep in _TABLE})
