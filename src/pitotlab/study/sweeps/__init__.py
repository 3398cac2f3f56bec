"""The table of open questions. A new question is a function on the page of its family, and one line
here.
"""

from pitotbench.catalog import Catalog
from pitotlab.study.questions import Sweep
from pitotlab.study.sweeps import air, sampling

_TABLE = (
    air.variable_wind,
    air.sideslip,
    sampling.rates,
    sampling.structure,
)

SWEEPS: Catalog[Sweep] = Catalog("sweep", {sweep.name: sweep for sweep in _TABLE})
