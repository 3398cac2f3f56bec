"""The posterior over causes: its identities, and what it makes of logs whose columns are known
exactly.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import noise_of_log, whitened_columns
from pitotbench.reconciliation.evidence import Evidence, LogEvidence, Prior, Rest, weigh
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import ScoreScale
from pitotbench.reconciliation.posterior import (
    CausePosterior,
    CauseSearch,
    answer_of,
    cause_posterior,
)
from pitotbench.reconciliation.signatures import FITTED, Signature, columns_of, searched_shapes
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.units import Array

Along = Mapping[tuple[str, str], Array]


@dataclass(frozen=True)
class PlainLog:
    """A log without form error: whitened columns of effects, at their typical sizes, and a
    residual.
    """

    base: Evidence
    signatures: tuple[Signature, ...]
    rests: tuple[Rest, ...] = ()
    least_bayes_factor: float = THRESHOLDS.gap_bayes_factor

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(columns_of(self.signatures))

    def directions(self, columns: object) -> None:
        """None are needed."""

    def form_error(self, sizes: object) -> tuple[list[int], Array]:
        return [], np.zeros(0)

    def beyond(self, sizes: object, power: float = 1.0) -> Evidence:
        return self.base.tempered(power)


def log_of(along: Along, residual: Array) -> PlainLog:
    typical = np.array([EFFECTS[effect].parameter(name).typical for effect, name in along])
    every = np.vstack([np.array(list(along.values())) / typical[:, None], residual])
    signatures = tuple(Signature(effect, name, 1.0, np.zeros((1, 1))) for effect, name in along)
    return PlainLog(Evidence(every @ every.T), signatures)


def blind_like(along: Along) -> PlainLog:
    """A flight that shows nothing."""
    return log_of({key: np.zeros(6) for key in along}, np.zeros(6))


def explained(along: Along, residual: Array) -> CausePosterior:
    return cause_posterior([log_of(along, residual)])


LAG, LATE, POD = ("pitot_lag", "lag_s"), ("gps_latency", "latency_s"), ("belly_pod", "drag_area_m2")
AXES = np.eye(6) * 20.0  # every effect stands at 20σ at its typical size


def total(posterior: CausePosterior) -> float:
    return float(sum(np.exp(w.total) for w in posterior.weights))


def test_the_evidence_of_one_size_is_the_integral_over_it() -> None:
    column, residual, deviation = np.array([1.0, -2.0, 0.5]), np.array([2.0, -3.0, 1.0]), 0.7
    every = np.stack([column, residual])
    sizes = np.linspace(-8.0, 8.0, 40_001)
    fall = (
        -0.5 * ((residual[:, None] - column[:, None] * sizes) ** 2).sum(axis=0)
        + 0.5 * residual @ residual
    )
    prior = np.exp(-0.5 * (sizes / deviation) ** 2) / (deviation * np.sqrt(2.0 * np.pi))
    integral = np.trapezoid(prior * np.exp(fall), sizes)
    found = Evidence(every @ every.T).of([0], [deviation])
    assert found.log_evidence == pytest.approx(np.log(integral), abs=1e-6)


@pytest.mark.parametrize(("low", "high"), [(-5.0, 5.0), (0.01, 3.0), (-3.0, -0.2)])
def test_an_effect_alone_weighs_as_much_as_the_integral_over_its_plausible_sizes(
    low: float, high: float
) -> None:
    column, residual = np.array([1.0, -2.0, 0.5]), np.array([1.0, -1.0, 1.0])
    every = np.stack([column, residual])
    sizes = np.linspace(low, high, 60_001)
    fall = (
        -0.5 * ((residual[:, None] - column[:, None] * sizes) ** 2).sum(axis=0)
        + 0.5 * residual @ residual
    )
    integrals = []
    for scale in THRESHOLDS.size_scales:
        prior = np.exp(-0.5 * (sizes / scale) ** 2)
        integrals.append(np.trapezoid(prior * np.exp(fall), sizes) / np.trapezoid(prior, sizes))
    found = weigh(
        Evidence(every @ every.T), [[0]], [Prior(*np.array([[1.0], [low], [high], [0.0]]))]
    )
    assert found.log_evidence == pytest.approx(np.log(np.mean(integrals)), abs=1e-4)


def test_columns_eliminated_first_give_the_same_evidence_as_all_together() -> None:
    every = np.random.default_rng(3).normal(size=(5, 9))
    evidence, deviations = Evidence(every @ every.T), np.array([0.5, 2.0, 1.0, 0.3])
    rest, first = evidence.given([1, 3], deviations[[1, 3]], [0, 2])
    together = evidence.of(range(4), deviations).log_evidence
    assert first + rest.of([0, 1], deviations[[0, 2]]).log_evidence == pytest.approx(
        together, abs=1e-9
    )


def test_the_probabilities_sum_to_one_and_none_is_likely_without_a_gap() -> None:
    along = {LAG: AXES[0], LATE: AXES[1]}
    posterior = explained(along, np.zeros(6))
    assert total(posterior) == pytest.approx(1.0)
    assert posterior.none + sum(
        p for causes, p in posterior.of_sets().items() if causes
    ) == pytest.approx(1.0)
    assert posterior.log_bayes_factor < 0.0
    assert answer_of(posterior).kind == "no_gap"
    # The chance of no gap is that of the Bayes factor, and what is left of it is shared among the
    # hypotheses.
    posterior = explained(along, AXES[0] * 0.2)
    prior = THRESHOLDS.prior_of_number[0] * (1.0 - THRESHOLDS.prior_of_rest)
    odds = np.exp(posterior.log_bayes_factor) * (1.0 - prior) / prior
    assert posterior.none == pytest.approx(1.0 / (1.0 + odds))
    assert total(posterior) == pytest.approx(1.0)
    with pytest.raises(ValueError, match="no log"):
        cause_posterior([])


def test_a_cause_is_named_and_two_that_act_together_are() -> None:
    along = {LAG: AXES[0], LATE: AXES[1], POD: AXES[2]}
    assert answer_of(explained(along, AXES[1])).groups == (("gps_latency",),)
    both = answer_of(explained(along, AXES[1] + AXES[2]))
    assert sorted(both.groups) == [("belly_pod",), ("gps_latency",)]
    assert both.kind == "named"


WATER, WATER_LAG = ("water_in_line", "column_m"), ("water_in_line", "lag_s")


@pytest.mark.parametrize(
    ("shown", "columns", "cause"),
    [(1.0, 0.0, "pitot_lag"), (1.0, 1.0, "water_in_line"), (0.15, 0.0, "pitot_lag")],
)
def test_a_line_without_water_is_late_and_one_with_water_is_not_just_late(
    shown, columns, cause
) -> None:
    """Water restricts the line as well, so that with no water it explains each lag just as a lag
    does. Where the column shows by 3σ at its typical size, it could still be there without any, and
    is not told."""
    typical = (
        EFFECTS["water_in_line"].parameter("lag_s").typical
        / EFFECTS["pitot_lag"].parameters[0].typical
    )
    along = {LAG: AXES[0], WATER_LAG: AXES[0] * typical, WATER: shown * AXES[1]}
    found = explained(along, AXES[0] + columns * AXES[1])
    assert answer_of(found).groups == ((cause,),)
    assert shown == 1.0 or "water_in_line" not in found.of_causes()
    assert total(found) == pytest.approx(1.0)


def test_the_forms_of_a_cause_share_its_prior() -> None:
    forms = [
        "pitot_lag",
        "height_dependent_lag",
        "second_order_line",
        "pitot_lag_from_a_time",
        "gps_latency",
    ]
    along = {(name, FITTED[name].parameters[0].name): AXES[i] for i, name in enumerate(forms)}
    log = PlainLog(
        Evidence(np.eye(len(forms) + 1)), tuple(Signature(*k, 1.0, np.zeros((1, 1))) for k in along)
    )
    search = CauseSearch([log])
    shares = {
        name: np.exp(
            search.log_form(name) + THRESHOLDS.search_penalty * len(searched_shapes(FITTED[name]))
        )
        for name in forms
    }
    assert sum(shares[name] for name in forms[:4]) == pytest.approx(1.0)
    assert shares["pitot_lag"] == pytest.approx(
        shares["height_dependent_lag"] + shares["second_order_line"]
    )
    assert shares["pitot_lag_from_a_time"] == pytest.approx(THRESHOLDS.prior_of_part)
    assert shares["gps_latency"] == pytest.approx(1.0)


def test_causes_that_act_alike_are_a_set() -> None:
    alike = AXES[0] + np.array([0.0, 0.5, 0.0, 0.0, 0.0, 0.0])
    answer = answer_of(explained({LAG: AXES[0], LATE: alike, POD: AXES[2]}, AXES[0]))
    assert answer.kind == "one_of"
    assert [set(group) for group in answer.groups] == [{"pitot_lag", "gps_latency"}]
    assert answer.others("pitot_lag") == ("gps_latency",)


@pytest.mark.parametrize(("missed", "kind"), [(0.003, "one_of"), (0.1, "named")])
def test_a_small_share_of_a_gap_does_not_decide_however_strong_it_is(
    missed: float, kind: str
) -> None:
    """Two causes explain 500σ, one of them all but a share of its sum of squares."""
    axes = 25.0 * AXES
    nearly = axes[0] * np.sqrt(1.0 - missed) + axes[1] * np.sqrt(missed)
    answer = answer_of(explained({LAG: axes[0], LATE: nearly, POD: axes[2]}, axes[0]))
    assert answer.kind == kind
    assert answer.groups[0][0] == "pitot_lag"


def test_a_size_that_cannot_be_excludes_its_cause() -> None:
    """A lag is never negative; a latency that fits as badly as the lag fits well is then the
    answer.
    """
    answer = answer_of(explained({LAG: -AXES[0], POD: AXES[0] + AXES[1] / 20.0}, AXES[0]))
    assert answer.groups == (("belly_pod",),)


def test_a_cause_is_named_in_the_form_that_fits() -> None:
    creep, plain = ("creep", "fraction"), ("hysteresis", "width_pa")
    for share, form in ((0.5, "creep"), (1.0, "hysteresis")):
        mixed = AXES[0] * share + AXES[1] * np.sqrt(1.0 - share**2)
        answer = answer_of(explained({creep: AXES[0], plain: mixed, POD: AXES[2]}, AXES[0]))
        assert answer.groups == (("hysteresis",),)
        assert answer.effects == (form,)


def test_two_logs_name_what_neither_can_and_one_that_contradicts_takes_it_back() -> None:
    one = log_of({LAG: AXES[0], LATE: AXES[0] + AXES[3] / 40.0}, AXES[0] / 4.0)
    other = log_of({LAG: AXES[0], LATE: AXES[1]}, AXES[0] / 4.0)
    silent = log_of({LAG: AXES[0], LATE: AXES[0]}, np.zeros(6))
    assert answer_of(cause_posterior([one])).kind == "one_of"
    assert answer_of(cause_posterior([one, other])).groups == (("pitot_lag",),)
    size = cause_posterior([one, silent]).weights[0].explained.weighed.sizes
    assert not len(size) or abs(size[0]) < 0.15 * EFFECTS["pitot_lag"].parameter("lag_s").typical


def test_the_prior_of_an_explanation_is_that_of_its_effects() -> None:
    """It held the difference between the tempered evidence and the whole one."""
    log = log_of({LAG: AXES[0], LATE: AXES[0] + AXES[3] / 4.0, POD: AXES[2]}, AXES[0])
    search = CauseSearch([log])
    explained = [w.explained for w in cause_posterior([log]).weights if w.causes]
    assert len(explained) > 1
    for each in explained:
        assert each.log_prior == pytest.approx(search.log_prior(each.effects))


def test_a_flight_that_shows_nothing_changes_no_probability_and_takes_no_name_away() -> None:
    """Three blind flights once brought a cause from 0.7 above 0.9: the strength of the evidence was
    their mean.
    """
    columns = {LAG: AXES[0], LATE: AXES[0] + AXES[3] / 10.0, POD: AXES[2]}
    seen, blind = log_of(columns, 3.0 * AXES[0]), blind_like(columns)
    alone, with_blind = cause_posterior([seen]), cause_posterior([seen, blind, blind, blind])
    assert 0.5 < alone.of_causes()["pitot_lag"] < 0.99
    assert with_blind.of_causes()["pitot_lag"] == pytest.approx(
        alone.of_causes()["pitot_lag"], abs=1e-3
    )
    assert with_blind.concentration == pytest.approx(1.0)
    columns = {LAG: AXES[0], LATE: AXES[1]}
    seen = log_of(columns, AXES[0] / 2.0)
    alone = cause_posterior([seen])
    both = cause_posterior(
        [seen, replace(blind_like(columns), least_bayes_factor=1000.0)]
    )  # without null flights
    assert both.least_bayes_factor == pytest.approx(alone.least_bayes_factor)
    assert answer_of(both).groups == answer_of(alone).groups == (("pitot_lag",),)


def test_a_flight_in_which_nothing_stands_out_has_no_answer_and_takes_none_from_another() -> None:
    columns = {LAG: AXES[0], LATE: AXES[1]}
    seen = log_of(columns, 3.0 * AXES[0])
    quiet = replace(seen, least_bayes_factor=np.inf)
    assert answer_of(cause_posterior([seen])).groups == (("pitot_lag",),)
    for logs in (
        [quiet],
        [quiet, quiet],
        [quiet, replace(blind_like(columns), least_bayes_factor=np.inf)],
    ):
        answer = answer_of(cause_posterior(logs))
        assert (answer.kind, answer.groups) == ("no_gap", ())
    both = cause_posterior([seen, quiet])
    assert both.least_bayes_factor == pytest.approx(seen.least_bayes_factor)
    assert answer_of(both).groups == (("pitot_lag",),)


def test_two_flights_that_show_the_same_tell_more_than_one_of_twice_the_evidence() -> None:
    """A signature may be wrong in an unknown direction on one flight, hardly in the same way on
    two.
    """
    columns = {LAG: AXES[0], LATE: AXES[0] + AXES[3] / 10.0}
    seen = log_of(columns, 3.0 * AXES[0])
    strong = replace(seen, base=seen.base + seen.base)
    two = cause_posterior([seen, seen])
    one = cause_posterior([strong])
    assert two.concentration == pytest.approx(0.5)
    assert two.of_causes()["pitot_lag"] > one.of_causes()["pitot_lag"] + 0.005


def test_a_rest_counts_as_evidence_of_its_flight() -> None:
    """A gap that no cause takes once had its evidence shared among flights that do not show it."""
    smooth = Rest("airspeed_along", (2,), np.array([30.0]), 0.0)
    columns = {LAG: AXES[0], LATE: AXES[1]}
    cell = np.zeros(6)
    cell[4] = 1.0
    every = np.vstack([AXES[0], AXES[1], cell, 30.0 * cell])
    seen = replace(log_of(columns, 30.0 * cell), base=Evidence(every @ every.T), rests=(smooth,))
    silent = np.vstack([np.zeros((2, 6)), cell, np.zeros(6)])
    blind = replace(seen, base=Evidence(silent @ silent.T))
    found = cause_posterior([seen, blind, blind])
    assert found.weights[0].causes == ()
    assert found.concentration > 0.99


FEW = Catalog(
    "effect", {name: EFFECTS[name] for name in ("pitot_lag", "gps_latency", "wind_drift")}
)


def test_the_order_of_the_channels_does_not_matter(sensed) -> None:
    layout = lay_out(sensed("gps_latency", das="20/20"), None, AnalysisSetting(day_known=True), FEW)
    noise = noise_of_log(layout)
    wander = dict.fromkeys(noise.names, 0.5)
    turned, noise_turned = _turned(layout, noise, np.argsort(noise.names)[::-1])
    found = [
        cause_posterior([LogEvidence(*each, wander)])
        for each in ((layout, noise), (turned, noise_turned))
    ]
    first, second = (each.of_sets() for each in found)
    likely = [causes for causes, probability in first.items() if probability > 1e-6]
    assert [second[causes] for causes in likely] == pytest.approx(
        [first[causes] for causes in likely], rel=1e-5
    )
    assert found[0].log_bayes_factor == pytest.approx(found[1].log_bayes_factor, rel=1e-7)


def test_what_gusts_imitate_is_marginalized_as_dense_algebra_does(sensed) -> None:
    """A fluctuating part that null flights show with 4σ: the evidence of all sizes against dense
    covariances.
    """

    log = sensed("gps_latency", das="20/20")
    layout = lay_out(
        log.select(log.time - log.time[0] < 120.0), None, AnalysisSetting(day_known=True), FEW
    )
    noise = noise_of_log(layout)
    scale = ScoreScale({}, {}, {}, {}, {"gps_latency|latency_s": 4.0})
    found = LogEvidence(layout, noise, {}, scale)
    white = whitened_columns(layout, noise)
    rows = white.reshape(-1, white.shape[2])
    rows = rows[np.any(rows != 0.0, axis=1)]
    k = layout.free.columns.shape[2]
    free, cells, residual = rows[:, :k], rows[:, [k + i for i, _ in layout.places]], rows[:, -1]
    labels = [s.effect for s in layout.signatures]
    late = rows[:, k + labels.index("gps_latency")]
    beside = np.concatenate([free, cells], axis=1)
    beside = beside / np.maximum(np.linalg.norm(beside, axis=0), 1e-150)
    left, values, _ = np.linalg.svd(beside, full_matrices=False)
    moving = late - left[:, values > 1e-4 * values[0]] @ (
        left[:, values > 1e-4 * values[0]].T @ late
    )
    assert 0.05 < moving @ moving / (late @ late) < 0.95
    plain = np.eye(len(rows)) + free @ np.diag(layout.free.deviations**2) @ free.T
    plain += 15.0 * np.outer(moving, moving) / (moving @ moving)
    for i, deviation in enumerate(found.typical):
        column = rows[:, k + i]
        solved = np.linalg.solve(plain, np.stack([column, residual], axis=1))
        precision = deviation**-2 + column @ solved[:, 0]
        expected = 0.5 * (column @ solved[:, 1]) ** 2 / precision - 0.5 * np.log(
            precision * deviation**2
        )
        assert found.base.of([i], [deviation]).log_evidence == pytest.approx(
            expected, rel=1e-4, abs=1e-3
        )


def _turned(layout: Layout, noise: NoiseModel, order: Array) -> tuple[Layout, NoiseModel]:
    """The same log and noise with the channels in another order."""
    names = tuple(noise.names[i] for i in order)
    residuals = layout.residuals
    count = layout.shapes.shape[1]
    cells = tuple(c for i in order for c in layout.cells[count * i : count * (i + 1)])
    turned = replace(
        layout,
        residuals=replace(
            residuals,
            names=names,
            values=residuals.values[:, order],
            slack=residuals.slack[:, order],
        ),
        free=replace(layout.free, columns=layout.free.columns[:, order]),
        signatures=tuple(replace(s, column=s.column[:, order]) for s in layout.signatures),
        cells=cells,
    )
    correlation = noise.correlation[np.ix_(order, order)]
    return turned, NoiseModel(
        names, noise.coefficients[order], noise.deviations[order], correlation
    )
