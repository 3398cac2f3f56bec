"""5 maneuvers x 3 data systems x 4 models, in smooth and in light air: the 2σ results stay where
they were.

One of the maneuvers is compared here, the others in `tests/lab/test_two_sigma_of_others.py`.
Simulated light air is compared only where the C++ library draws the stored turbulence; pytest's
closing line says where it does not. Light air from a formula is compared everywhere.

The tolerance is 2 % (0.002 kt where that is larger): the same code gives the same digits, other
versions of NumPy or SciPy differ in the last ones, and a real change of a noise model, a filter or
a card moves more than that.
"""

from pathlib import Path

import pandas as pd
import pytest
from tests.regression import two_sigma

from pitotbench.simulation.maneuvers import PAPER_MANEUVERS

FORMULA_TABLE = pd.read_csv(Path(__file__).with_name("formula_two_sigma.csv"))
TABLE = pd.read_csv(Path(__file__).with_name("two_sigma.csv"))
MARKS = pd.read_csv(Path(__file__).with_name("turbulence_marks.csv"), index_col="maneuver")[
    "mean_cas_mps"
]
HERE = ("rapid_decel",)
OTHERS = tuple(name for name in PAPER_MANEUVERS if name not in HERE)
RELATIVE, ABSOLUTE_KT = 0.02, 0.002


def test_table_is_complete():
    assert len(TABLE) == 2 * 5 * 3 * 4


def require_alike(found, wanted):
    for column in ("residual_two_sigma_kt", "two_sigma_kt", "correction_kt"):
        for have, want in zip(found[column], wanted[column], strict=True):
            assert have == pytest.approx(want, rel=RELATIVE, abs=ABSOLUTE_KT), column


def test_light_air_from_a_formula():
    """Gusts drawn by NumPy, which are the same everywhere: this part is compared on every platform."""
    found = pd.DataFrame(two_sigma.formula_rows())
    assert len(FORMULA_TABLE) == 3 * 4
    assert list(found.das + found.model) == list(FORMULA_TABLE.das + FORMULA_TABLE.model)
    require_alike(found, FORMULA_TABLE)


@pytest.mark.parametrize("maneuver", HERE)
def test_the_closing_line_names_what_was_not_compared(maneuver, request):
    name = f"{request.node.nodeid.partition('::')[0]}::{test_light_turbulence.__name__}[{maneuver}]"
    skipped = pytest.TestReport(
        name, ("", 0, ""), {}, "skipped", ("", 0, "Skipped: other turbulence"), "call"
    )
    category, *_ = request.config.hook.pytest_report_teststatus(
        report=skipped, config=request.config
    )
    assert category == "not compared in simulated light air"


def compare(flight):
    wanted = TABLE[
        (TABLE.maneuver == flight.case.maneuver) & (TABLE.turbulence == flight.case.turbulence)
    ]
    found = pd.DataFrame(two_sigma.rows(flight))
    assert list(found.das + found.model) == list(wanted.das + wanted.model)
    require_alike(found, wanted)


def compare_light(flight):
    maneuver = flight.case.maneuver
    if two_sigma.turbulence_mark(flight) != pytest.approx(MARKS[maneuver], rel=1e-7):
        pytest.skip(
            "this platform's C++ library draws other turbulence: the stored figures are not its own"
        )
    compare(flight)


@pytest.mark.parametrize("maneuver", HERE)
def test_smooth_air(maneuver, smooth_flights):
    compare(smooth_flights[maneuver])


@pytest.mark.parametrize("maneuver", HERE)
def test_light_turbulence(maneuver, light_flights):
    compare_light(light_flights[maneuver])
