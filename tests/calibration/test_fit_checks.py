"""The size of a curve of the pressure error is judged apart from its bound."""

import numpy as np
import pytest

from pitotbench.calibration.fit_checks import judge_curve
from pitotbench.units import KNOT

SPEED = np.linspace(100.0, 160.0, 7) * KNOT
SURE = np.full(7, 0.005)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("size", "kind"), [(0.09, "plausible"), (0.15, "doubtful"), (0.25, "impossible")])
def test_one_point_decides_and_either_sign_counts(sign, size, kind):
    error = np.zeros(7)
    error[4] = sign * size
    verdict = judge_curve(SPEED, error, SURE)
    assert verdict.kind == kind
    if kind != "plausible":
        assert verdict.worst == sign * size
        assert verdict.indicated_airspeed == SPEED[4]
        assert f"{100.0 * sign * size:+.0f}% of the impact pressure at 140 kt" in verdict.words


def test_a_large_error_that_is_hardly_known_is_not_impossible():
    assert judge_curve(SPEED, np.full(7, 0.3), np.full(7, 0.35)).kind == "plausible"
    assert judge_curve(SPEED, np.full(7, 0.3), np.full(7, 0.15)).kind == "doubtful"
    # The worst is named among the points that are known.
    error, bound = np.array([0.9, 0.25, 0.0]), np.array([2.0, 0.01, 0.01])
    assert judge_curve(SPEED[:3], error, bound).worst == 0.25


def test_a_curve_that_is_none_is_refused():
    with pytest.raises(ValueError, match="one length"):
        judge_curve(SPEED, np.zeros(6), SURE)
    with pytest.raises(ValueError, match="not finite"):
        judge_curve(SPEED, np.full(7, np.nan), SURE)
