"""One flight has one factor, whatever the file that holds it."""

from itertools import combinations

import pytest

from pitotlab.broken.measure import SCALED, scale_rows

SAME = 0.2  # of 1σ: the curves of the containers, whose zeros are of another size, differ so far


@pytest.mark.parametrize(
    ("number", "seed"),
    [
        pytest.param(5, 620105, id="fixes slower than the air data"),
        pytest.param(12, 620112, id="a factor near 1"),
    ],
)
def test_a_flight_has_one_factor_in_each_container(number, seed, tmp_path):
    rows = list(scale_rows(number, seed, tmp_path))
    assert [row.container for row in rows] == list(SCALED)
    for one, other in combinations(rows, 2):
        sigma = 0.5 * min(one.two_sigma, other.two_sigma)
        assert abs(one.found - other.found) < SAME * sigma
        assert abs(one.two_sigma - other.two_sigma) < SAME * sigma
