"""The next flight, chosen: the forecast against dense densities and draws, and the variants of the cards."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from pitotbench import Case
from pitotbench.bench.next_flight import variants_of
from pitotbench.reconciliation.discrimination import Contender, Doubt, discrimination
from pitotbench.reconciliation.evidence import Evidence
from pitotbench.reconciliation.signatures import Signature
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.simulation.sortie import card_of
from pitotbench.units import Array

LAG, LATE = ("pitot_lag", "lag_s"), ("gps_latency", "latency_s")


@dataclass(frozen=True)
class Unflown:
    """Inner products of a log without residuals and without form error."""

    base: Evidence
    signatures: tuple[Signature, ...]

    def form_error(self, sizes: Mapping[tuple[str, str], float]) -> tuple[list[int], Array]:
        return [], np.zeros(0)


def unflown(*columns: Array) -> Unflown:
    every = np.vstack([*columns, np.zeros(len(columns[0]))])
    signatures = tuple(Signature(*key, 1.0, np.zeros((1, 1))) for key in (LAG, LATE)[: len(columns)])
    return Unflown(Evidence(every @ every.T), signatures)


def doubt(size: float, deviation: float, probability: float = 0.5) -> Doubt:
    """Two causes that explain the flights so far, each by a size of its own."""

    def contender(key: tuple[str, str], p: float) -> Contender:
        return Contender((key[0],), (key,), np.array([size]), np.array([[deviation**2]]), p, 0.0)

    return Doubt((contender(LAG, probability), contender(LATE, 1.0 - probability)), 30.0)


def by_dense_draws(columns: tuple[Array, Array], asked: Doubt, draws: int) -> float:
    """The share of right names over dense logs, weighed by dense normal densities."""
    random = np.random.default_rng(77)
    known = [
        multivariate_normal(
            column * c.sizes[0], np.eye(len(column)) + np.outer(column, column) * c.covariance[0, 0]
        )
        for column, c in zip(columns, asked.contenders, strict=True)
    ]
    nothing = multivariate_normal(np.zeros(len(columns[0])), np.eye(len(columns[0])))
    prior = np.array([c.probability for c in asked.contenders])
    right = 0.0
    for truth, density in enumerate(known):
        logs = np.atleast_2d(density.rvs(draws, random_state=random))
        added = np.stack([each.logpdf(logs) - nothing.logpdf(logs) for each in known], axis=1)
        gap = np.log(np.exp(np.log(prior) + added).sum(axis=1))
        before, after = asked.log_bayes_factor, np.maximum(0.0, gap)
        old = 1.0 / (1.0 + THRESHOLDS.table_error**2 * 2.0 * before)
        square = 2.0 * (before * before / (before + after) + after * after / (before + after))
        new = 1.0 / (1.0 + THRESHOLDS.table_error**2 * square)
        values = new[:, None] * (np.log(prior) / old + added)
        weights = np.exp(values - values.max(axis=1, keepdims=True))
        others = np.maximum(weights.sum(axis=1) - weights[:, truth], 1e-300)
        told = (1.0 - THRESHOLDS.doubt_least) / (1.0 + (others / weights[:, truth]) ** THRESHOLDS.odds_above_even)
        right += prior[truth] * np.mean(told > THRESHOLDS.named_from)
    return float((1.0 - THRESHOLDS.doubt_least) * right)


@pytest.mark.parametrize("angle", [0.05, 0.3, 0.6, 1.5])
def test_the_probability_of_a_name_is_that_over_dense_logs(angle: float) -> None:
    first, second = np.array([6.0, 0.0, 0.0]), 6.0 * np.array([np.cos(angle), np.sin(angle), 0.0])
    asked = doubt(1.0, 0.1, 0.6)
    forecast = discrimination(asked, unflown(first, second), draws=4000)  # type: ignore[arg-type]
    assert forecast.name == pytest.approx(by_dense_draws((first, second), asked, 4000), abs=0.04)


def test_a_card_on_which_two_causes_act_alike_gives_no_name() -> None:
    column = np.array([8.0, 3.0])
    asked = doubt(1.0, 0.1)
    forecast = discrimination(asked, unflown(column, column))  # type: ignore[arg-type]
    assert forecast.name == 0.0
    assert forecast.entropy == pytest.approx(1.0, abs=0.01)
    assert asked.entropy == pytest.approx(1.0)


def test_the_wider_the_angle_the_surer_a_name() -> None:
    first = np.array([8.0, 0.0])
    found = [
        discrimination(doubt(1.0, 0.1), unflown(first, 8.0 * np.array([np.cos(a), np.sin(a)])))  # type: ignore[arg-type]
        for a in (0.1, 0.4, 0.8, 1.5)
    ]
    assert [f.name for f in found] == sorted(f.name for f in found)
    assert [f.entropy for f in found] == sorted((f.entropy for f in found), reverse=True)
    assert 0.9 < found[-1].name <= 1.0 - THRESHOLDS.doubt_least  # other causes keep their share


def test_evidence_that_flights_share_is_tempered_less() -> None:
    shared = replace(doubt(1.0, 0.1), concentration=0.5)
    square = 2.0 * (30.0**2 * 0.5 + 10.0**2) / 40.0
    assert shared.power(10.0) == pytest.approx(1.0 / (1.0 + THRESHOLDS.table_error**2 * square))


def test_a_name_needs_the_evidence_that_the_flights_need() -> None:
    first, second = np.array([6.0, 0.0, 0.0]), np.array([0.0, 6.0, 0.0])
    asked = doubt(1.0, 0.1)
    assert discrimination(asked, unflown(first, second)).name > 0.5  # type: ignore[arg-type]
    careful = replace(asked, least_bayes_factor=200.0)
    assert discrimination(careful, unflown(first, second)).name == 0.0  # type: ignore[arg-type]


def test_the_variants_of_a_card_can_be_flown() -> None:
    for name in ("diagnostic", "circle", "decel_circle", "step_decrease", "rapid_decel"):
        variants = variants_of(Case(maneuver=name))
        assert len(variants) >= 3
        for case in variants:
            assert card_of(case) is not None
