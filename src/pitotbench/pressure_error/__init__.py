"""The table of pressure-error models Δp/q_c = f(q_ci/q_ref), each linear in its parameters.

Arguments, terms, slopes and values are ratios without units.
"""

from pitotbench.catalog import Catalog
from pitotbench.pressure_error.models import (
    BIAS,
    INVERSE,
    INVERSE_PLUS,
    LINEAR,
    QUADRATIC,
    SMOOTH,
)
from pitotbench.pressure_error.models import PressureErrorCurve as PressureErrorCurve
from pitotbench.pressure_error.models import PressureErrorModel as PressureErrorModel
from pitotbench.pressure_error.models import PressureErrorRangeError as PressureErrorRangeError
from pitotbench.pressure_error.models import TableCurve as TableCurve

# Pa, impact pressure at 100 KCAS, so that x = q_ci/q_ref is of order one
REFERENCE_PRESSURE = 1630.28

MODELS: Catalog[PressureErrorModel] = Catalog(
    "pressure-error model",
    {m.name: m for m in (BIAS, LINEAR, QUADRATIC, INVERSE, INVERSE_PLUS, SMOOTH)},
)
PAPER_MODELS = ("inverse+", "quadratic", "linear", "bias")  # Martos et al. 2011, Fig 9
