"""Terms of one moment are weighed as sets: a pair that greedy steps miss is found, and bounds hold
the sets that the log cannot tell apart.
"""

from collections.abc import Mapping

import numpy as np
import pytest
from tests.reconciliation.test_regression import AXES, NOISE, block_of

from pitotbench.effects import EFFECTS, effect_of
from pitotbench.estimation.information import Information
from pitotbench.reconciliation.evidence import prior_of
from pitotbench.reconciliation.fitting import Fitted, fitted_by
from pitotbench.reconciliation.regression import Regression
from pitotbench.reconciliation.sets import Hypothesis, weighed_sets
from pitotbench.units import Array

STIFFNESS, DAMPING = ("pitch_stiffness", "change"), ("pitch_damping", "change")
ELEVATOR = ("control_effectiveness", "elevator_change")
GRAVITY = ("center_of_gravity", "aft_m")
A, B, C, D = 60.0 * AXES[:4]  # a typical size stands at 60 sigma


def judged(along: Mapping[tuple[str, str], Array], residual: Array) -> Fitted:
    block = block_of(along, residual)
    block.channels = dict.fromkeys(along, "pitch_acceleration")
    return fitted_by(Regression([block]))


def names(fitted: Fitted) -> set[str]:
    return {member.name for member in fitted.members}


def test_two_terms_of_a_moment_are_exchanged_together() -> None:
    """The center of gravity imitates stiffness and elevator nearly, and damping what is left."""
    along = {
        STIFFNESS: A,
        ELEVATOR: B,
        GRAVITY: (A + B) / np.sqrt(2.0) + 0.3 * C,
        DAMPING: C + 0.3 * D,
    }
    found = judged(along, A + B + NOISE)
    assert names(found) == {"pitch_stiffness", "control_effectiveness"}


def test_a_term_that_few_parts_of_the_flight_excite_is_told_with_its_partner() -> None:
    """Damping acts in the parts of one fold alone, so that the others cannot foretell its size."""
    rows = np.arange(len(A)) % 8
    damping = np.where(rows == 3, A + 0.5 * B, 0.0)
    found = judged({ELEVATOR: A, DAMPING: damping}, A - 0.8 * damping + NOISE)
    assert names(found) == {"pitch_damping", "control_effectiveness"}


def test_a_bound_holds_the_sets_that_are_nearly_as_probable() -> None:
    """Any two of three terms explain the moment, and no log shows which two."""
    along = {STIFFNESS: A, ELEVATOR: 0.8 * A + 0.6 * B, DAMPING: -0.8 * A + 0.6 * B}
    pairs = {STIFFNESS: (-0.8, 0.8), ELEVATOR: (1.0, 0.5), DAMPING: (1.0, 0.5)}
    sizes = judged(along, 0.6 * B + NOISE).sizes
    assert len(sizes.keys) == 2
    typical = [EFFECTS[e].parameter(name).typical for e, name in sizes.keys]
    for key, size, unit, variance in zip(
        sizes.keys, sizes.values, typical, sizes.covariance.diagonal(), strict=True
    ):
        assert all(
            abs(size / unit - rival) < 2.5 * variance**0.5 / abs(unit) for rival in pairs[key]
        )


def test_the_bound_of_one_cause_holds_a_pair_that_is_nearly_as_probable() -> None:
    """The elevator is needed by too little to be told, and moves the stiffness far."""
    along = {STIFFNESS: A, ELEVATOR: 0.9 * A + 0.44 * B}
    found = judged(along, A + 0.1 * along[ELEVATOR] + NOISE)
    (size,), ((variance,),) = found.sizes.values, found.sizes.covariance
    alone = found.regression.sizes(found.members)
    assert names(found) == {"pitch_stiffness"}
    assert size == pytest.approx(alone.values[0])
    assert variance > 4.0 * alone.covariance[0, 0]


def test_sets_have_the_evidence_of_the_integral_over_their_sizes() -> None:
    """By brute force: the residual as a normal vector, its covariance with that of the sizes."""
    draw = np.random.default_rng(5)
    columns, residual = draw.normal(size=(2, 40)), draw.normal(size=40) * 2.0
    every = np.vstack([columns, residual])
    none = (), np.zeros(0)
    hypotheses = [
        Hypothesis(
            key[0], key[0], (i,), prior_of([effect_of(key[0]).parameter(key[1])]), -1.0, none
        )
        for i, key in enumerate((STIFFNESS, DAMPING))
    ]
    sets = weighed_sets(Information(every @ every.T), hypotheses, 2)
    both = next(each for each in sets if len(each.names) == 2)
    deviations = np.concatenate([member.deviations for member in both.members])
    cover = np.eye(40) + (columns.T * deviations**2) @ columns
    log_evidence = 0.5 * (
        residual @ residual
        - residual @ np.linalg.solve(cover, residual)
        - np.linalg.slogdet(cover)[1]
    )
    ladder = 2.0 * np.log(4.0)
    # The ranges cut little of what is as small as these sizes.
    assert both.log_weight == pytest.approx(log_evidence - 2.0 - ladder, abs=0.2)
