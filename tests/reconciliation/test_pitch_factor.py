"""The factor that all terms of the pitching moment may have in common: learned on null flights,
integrated out of a log.
"""

import numpy as np
import pytest

from pitotbench.estimation.information import Information, SizePosterior
from pitotbench.reconciliation.pitch_factor import (
    CONSTANT,
    TERMS,
    around_sizes,
    factor_deviation,
    without_factor,
)

LABELS = (*TERMS, CONSTANT)


def flight(draw: np.random.Generator, factor: float, sizes: tuple[float, ...] = ()) -> Information:
    """Columns that the trim keeps near a constant, with a residual of a factor and of sizes."""
    constant = np.ones(400)
    stiffness, damping = 20.0 * draw.normal(size=400), 3.0 * draw.normal(size=400)
    elevator = 5.0 * constant - stiffness + 2.0 * draw.normal(size=400)
    columns = np.stack([stiffness, damping, elevator, constant], axis=1)
    whole = np.array([1.0, 1.0, 1.0, -5.0])
    residual = columns @ (factor * whole + np.array([*sizes, *[0.0] * (4 - len(sizes))]))
    every = np.column_stack([columns, residual + draw.normal(size=400)])
    return Information(every.T @ every)


def test_null_flights_tell_how_much_of_the_factor_is_unknown():
    draw = np.random.default_rng(3)
    steady = [flight(draw, 0.0) for _ in range(100)]
    pulled = [flight(draw, 0.15 * draw.normal()) for _ in range(100)]
    assert factor_deviation(LABELS, steady) < 0.01
    assert factor_deviation(LABELS, pulled) == pytest.approx(0.15, rel=0.25)
    assert factor_deviation(LABELS[1:], [flight(draw, 1.0).given((), (), [1, 2, 3])[0]]) == 0.0


def test_the_factor_is_integrated_out_as_a_further_column():
    one = flight(np.random.default_rng(4), 0.1)
    whole = np.array([1.0, 1.0, 1.0, -one.inner[3, :3].sum() / one.inner[3, 3], 0.0])
    turn = np.column_stack([np.eye(5)[:, :4], whole, np.eye(5)[:, 4]])
    with_column = Information(turn.T @ one.inner @ turn)
    expected = with_column.given([4], [0.15], [0, 1, 2, 3])[0]
    assert without_factor(one, LABELS, 0.15).inner == pytest.approx(expected.inner, rel=1e-9)


def test_a_bound_holds_a_pull_of_all_terms_and_what_parts_them_stays_as_sharp():
    """A stiffness and an elevator a quarter too large, pulled by the usual half of that."""
    one = flight(np.random.default_rng(5), -0.12, (0.25, 0.0, 0.25))
    columns, wide = [0, 1, 2, 3], [1.0] * 4
    sharp, honest = (
        each.posterior(columns, wide) for each in (one, without_factor(one, LABELS, 0.15))
    )
    off = [abs(each.mean[0] - 0.25) / each.covariance[0, 0] ** 0.5 for each in (sharp, honest)]
    assert off[0] > 4.0
    assert off[1] < 2.0
    apart = np.array([1.0, 0.0, -1.0, 0.0])
    assert apart @ honest.covariance @ apart == pytest.approx(
        apart @ sharp.covariance @ apart, rel=0.1
    )


def pulled_change(seed: int, factor: float, change: float) -> Information:
    """A log of a stiffness that is changed, where the factor multiplies the change too."""
    return flight(np.random.default_rng(seed), factor, ((1.0 + factor) * change,))


def freed(one: Information, deviation: float) -> SizePosterior:
    """The size of the stiffness alone, freed of the factor."""
    shown = np.zeros(4)
    shown[0] = without_factor(one, LABELS, deviation).posterior([0], [0.5]).mean[0]
    return around_sizes(one, LABELS, deviation, range(4), shown).posterior([0], [0.5])


@pytest.mark.parametrize("factor", [-0.35, 0.3])
def test_a_change_is_told_as_large_as_it_is_not_as_the_factor_shows_it(factor: float) -> None:
    """A stiffness a quarter too small seemed to be a sixth, with a bound that did not hold it."""
    raw, off = list[float](), list[float]()
    for seed in range(40):
        one = pulled_change(seed, factor, -0.25)
        shown = without_factor(one, LABELS, 0.2).posterior([0], [0.5])
        found = freed(one, 0.2)
        raw.append(float(shown.mean[0] + 0.25) / shown.covariance[0, 0] ** 0.5)
        off.append(float(found.mean[0] + 0.25) / found.covariance[0, 0] ** 0.5)
    assert abs(np.mean(raw)) > 3.0
    assert abs(np.mean(off)) < 0.6
    assert np.std(off) == pytest.approx(1.0, abs=0.35)


def test_without_a_factor_a_change_is_what_the_log_shows() -> None:
    one = pulled_change(2, 0.0, -0.25)
    plain = one.posterior([0], [0.5])
    assert freed(one, 0.0).mean == pytest.approx(plain.mean, rel=1e-12)
    assert freed(one, 0.0).covariance == pytest.approx(plain.covariance, rel=1e-12)
