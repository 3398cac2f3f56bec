"""Unit factors against their legal definitions and published equivalents; every suffix there and
back.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitotbench.units import SUFFIXES, from_si, to_si

# NIST Special Publication 811 (2008), Appendix B, and the standard day of the U.S. Standard
# Atmosphere 1976.
PUBLISHED = [
    (1.0, "kt", 0.5144444),
    (1.0, "fps", 0.3048),
    (1.0, "ft", 0.3048),
    (1.0, "mph", 0.44704),
    (1.0, "kmh", 0.2777778),
    (1.0, "fpm", 5.08e-3),
    (760.0, "mmhg", 101325.0),
    (1.0, "inh2o", 249.0889),
    (59.0, "degf", 288.15),
    (1.5, "min", 90.0),
    (29.92126, "inhg", 101325.0),
    (14.69595, "psi", 101325.0),
    (2116.217, "psf", 101325.0),
    (1013.25, "hpa", 101325.0),
    (101.325, "kpa", 101325.0),
    (15.0, "degc", 288.15),
    (518.67, "degr", 288.15),
    (180.0, "deg", np.pi),
    (60.0, "rpm", 2.0 * np.pi),
    (180.0, "degps", np.pi),
    (1.0, "g", 9.80665),
    (1.0, "fps2", 0.3048),
    (1.0, "lb", 0.45359237),
    (100.0, "pph", 0.01259979),
    (250.0, "ms", 0.25),
]


@pytest.mark.parametrize(("value", "suffix", "si"), PUBLISHED)
def test_published_equivalents(value, suffix, si):
    assert to_si(value, suffix) == pytest.approx(si, rel=5e-7)


def test_every_unit_that_is_not_si_has_evidence():
    plain = {name for name, unit in SUFFIXES.items() if unit.factor == 1.0 and unit.offset == 0.0}
    assert set(SUFFIXES) - plain == {suffix for _, suffix, _ in PUBLISHED}
    assert sorted(SUFFIXES[name].dimension for name in plain) == sorted(
        {u.dimension for u in SUFFIXES.values()}
    )
    with pytest.raises(KeyError):
        to_si(1.0, "furlong")


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(SUFFIXES)))
def test_there_and_back(value, suffix):
    assert from_si(to_si(value, suffix), suffix) == pytest.approx(value, rel=1e-12, abs=1e-9)
