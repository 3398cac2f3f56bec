"""The bounds of hand-written cards cover as often as they state, over two hundred cards."""

import numpy as np
import pytest
from tests.lab.hand_card_figures import coverage


@pytest.mark.long
def test_coverage_on_two_hundred_cards():
    """Half of three legs a point and half of four; development seeds. 1,000 points, a curve each."""
    found = coverage(4001, 200)
    assert len(found.point_errors) >= 995
    assert found.slips <= 2
    assert 0.92 <= found.points_inside <= 0.98
    assert 0.92 <= found.curves_inside <= 0.98
    for errors, bounds in (
        (found.point_errors, found.point_bounds),
        (found.curve_errors, found.curve_bounds),
    ):
        assert 0.4 < np.sqrt(np.mean((errors / bounds) ** 2)) < 0.6  # 0.5 for a true 2σ
