"""The information of rows against dense algebra: flat and normal priors, parts, what is left."""

import numpy as np
import pytest

from pitotbench.estimation.information import Information, inverse

DEVIATIONS = np.array([0.5, np.inf, 2.0, np.inf])


def rows(seed: int, count: int = 60) -> np.ndarray:
    """Four columns and a residual, (n, 5)."""
    return np.random.default_rng(seed).standard_normal((count, 5))


def test_an_infinite_deviation_is_flat_and_a_finite_one_a_row_of_data() -> None:
    data = rows(1)
    prior = np.diag([2.0, 0.0, 0.5, 0.0])
    design, response = np.vstack([data[:, :4], prior]), np.append(data[:, 4], np.zeros(4))
    found = Information(data.T @ data).posterior(range(4), DEVIATIONS)
    assert found.mean == pytest.approx(np.linalg.lstsq(design, response)[0], rel=1e-9)
    assert found.covariance == pytest.approx(np.linalg.inv(design.T @ design), rel=1e-9)
    wide = Information(data.T @ data).posterior(range(4), np.minimum(DEVIATIONS, 1e6))
    assert wide.mean == pytest.approx(found.mean, rel=1e-6)


def test_parts_add_and_what_is_left_of_columns_gives_the_same_posterior() -> None:
    one, other = rows(2), rows(3)
    both = np.vstack([one, other])
    whole = Information(one.T @ one) + Information(other.T @ other)
    assert whole.inner == pytest.approx(both.T @ both)
    joint = whole.posterior(range(4), DEVIATIONS)
    left, _ = whole.given([1, 2], DEVIATIONS[[1, 2]], [0, 3])
    found = left.posterior([0, 1], DEVIATIONS[[0, 3]])
    assert found.mean == pytest.approx(joint.mean[[0, 3]], rel=1e-9)
    assert found.covariance == pytest.approx(joint.covariance[np.ix_([0, 3], [0, 3])], rel=1e-9)
    assert whole.placed([3, 1, 0, 5], 6).posterior([3, 1, 0, 5], DEVIATIONS).mean == pytest.approx(
        joint.mean
    )


def test_the_evidence_of_other_residuals_is_that_of_each() -> None:
    data, deviations = rows(4), np.array([0.3, 1.5])
    plain = Information(data.T @ data)
    products = plain.drawn(3, seed=1)
    found = plain.log_evidences(products, np.array([0, 2]), deviations)
    for each, product in zip(found, products, strict=True):
        own = plain.inner.copy()
        own[-1, :-1] = own[:-1, -1] = product
        assert each == pytest.approx(Information(own).posterior([0, 2], deviations).log_evidence)


def test_columns_of_any_units_a_copy_and_an_empty_one_have_an_inverse() -> None:
    data = rows(5)[:, :4] * np.array([1e-9, 1.0, 1e7, 0.0])
    data = np.column_stack([data, data[:, 1]])
    found = inverse(data.T @ data)
    fitted = data @ found @ data.T @ rows(6)[:, 0]
    wanted = data[:, :3] @ np.linalg.lstsq(data[:, :3], rows(6)[:, 0], rcond=1e-30)[0]
    assert fitted == pytest.approx(wanted, rel=1e-6)
    assert not found[3].any()
