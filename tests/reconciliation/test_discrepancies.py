"""The evidence of smooth discrepancies, against the whole matrices."""

import numpy as np
import pytest
from scipy.special import logsumexp

from pitotbench.estimation.information import Information
from pitotbench.reconciliation.discrepancies import discrepancy_of
from pitotbench.reconciliation.thresholds import THRESHOLDS

CELLS, MEMBERS, OWN = [0, 1, 2, 3, 4], [5, 6], [7]
DEVIATIONS = np.array([0.4, 2.0, 0.7])


@pytest.mark.parametrize("members", [0, 2])
@pytest.mark.parametrize("power", [1.0, 0.03])
@pytest.mark.parametrize("own", [0, 1])
def test_the_turned_cells_give_the_evidence_of_the_whole_matrix(
    members: int, power: float, own: int
) -> None:
    """The fourth cell is the sum of two others: the powers of the turned ones include a zero."""
    every = np.random.default_rng(members).normal(size=(10, 40))
    every[3] = every[0] + every[1]
    evidence = Information(every @ every.T)
    found = discrepancy_of("all", CELLS, evidence, 0.25)
    chosen, deviations = MEMBERS[:members], DEVIATIONS[:members]
    marginal = evidence.marginal(chosen, deviations).tempered(power)
    further, wide = OWN[:own], DEVIATIONS[2 : 2 + own]

    whole = evidence.given(chosen, deviations)[0].tempered(power).given(further, wide)[0]
    unit = 1.0 / np.sqrt(np.diag(evidence.inner)[CELLS] * len(CELLS))
    direct = [whole.posterior(CELLS, size * unit).log_evidence for size in THRESHOLDS.rest_sizes]
    wanted = logsumexp(direct) + np.log(0.25 / len(THRESHOLDS.rest_sizes))
    # beside other hypotheses, which take no part in it
    others = [([8], np.array([1.3])), ([], np.zeros(0))]
    _, value, _ = found.log_evidences(marginal, [others[0], (further, wide), others[1]])
    assert value == pytest.approx(wanted, rel=1e-9)
