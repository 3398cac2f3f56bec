"""The peers' bounds reduce to what they should in limits, and fall short where ours does not."""

import numpy as np
import pytest

from pitotlab.peers import PeerCase, bartlett, colored, peer_rows, white


def make_case(memory, n=4000, seed=4):
    rng = np.random.default_rng(seed)
    residual = rng.standard_normal(n + 400)
    for i in range(1, len(residual)):
        residual[i] += memory * residual[i - 1]
    jacobian = np.column_stack([np.ones(n), np.linspace(-1.0, 1.0, n)])
    return PeerCase(jacobian, residual[400:], 0.1)


def test_all_agree_on_white_residuals():
    case = make_case(0.0)
    plain = np.sqrt(np.diag(white(case)))
    np.testing.assert_allclose(np.sqrt(np.diag(bartlett(case))), plain, rtol=0.35)


def test_memory_widens_the_consistent_bound_as_theory_says():
    """An AR(1) residual of memory a widens the bound of a mean by sqrt((1 + a)/(1 − a))."""
    case = make_case(0.8, n=40000)
    ratio = np.sqrt(bartlett(case)[0, 0] / white(case)[0, 0])
    assert ratio == pytest.approx(np.sqrt(1.8 / 0.2), rel=0.25)


def test_the_unbiased_correction_can_return_negative_variances():
    """An unbiased autocorrelation over all lags is no covariance."""
    signs = [np.any(np.diag(colored(make_case(0.95, n=600, seed=s))) < 0.0) for s in range(40)]
    assert any(signs)


def test_rows_of_a_flight(light_flights):
    rows = {row["bound"]: row for row in peer_rows(light_flights["circle"], "20/1")}
    assert len(rows) == 6
    assert rows["per-point spread, fixed speed"]["rms_error"] < 1.0  # m/s, of the turns' points
    ours = rows["pitotbench"]["two_sigma"]
    assert rows["white residuals (Cramér-Rao)"]["two_sigma"] < 0.5 * ours
