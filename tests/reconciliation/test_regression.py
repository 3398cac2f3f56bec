"""The regression of many gaps: its identities, and what it makes of logs whose columns are known
exactly.
"""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
import pytest

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS, effect_of
from pitotbench.estimation.information import Information
from pitotbench.reconciliation.cells import Cell
from pitotbench.reconciliation.closure import closure_of
from pitotbench.reconciliation.equations import (
    equations_from,
    noise_of_log,
    whitened_columns,
    whitened_equations,
)
from pitotbench.reconciliation.evidence import Prior, evidence_beyond_floor, weigh
from pitotbench.reconciliation.fitting import fitted_by
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import ScoreScale
from pitotbench.reconciliation.regression import FoundGap, Regression
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.units import Array

ROWS, FOLDS = 1600, 8
Along = Mapping[tuple[str, str], Array]
LAG, LATE, POD = ("pitot_lag", "lag_s"), ("gps_latency", "latency_s"), ("belly_pod", "drag_area_m2")
DRAW = np.random.default_rng(17)
# Directions of unit length, nearly at right angles to one another.
AXES = DRAW.normal(size=(8, ROWS)) / np.sqrt(ROWS)
NOISE = DRAW.normal(size=ROWS)


def block_of(
    along: Along, residual: Array, cells: Sequence[Array] = (), on_null: Sequence[Array] = ()
) -> SimpleNamespace:
    """A log of whitened columns, each at the typical size of its effect, with one free column, and
    null flights with these residuals.
    """
    typical = np.array([effect_of(e).parameter(name).typical for e, name in along])
    columns = np.array(list(along.values())) / typical[:, None]
    pull = np.mean([*on_null] or [np.zeros(ROWS)], axis=0)
    sizes = np.linalg.lstsq(columns.T, pull, rcond=None)[0]
    every = np.vstack([np.ones(ROWS), columns, *cells, residual])
    parts = [every[:, n::FOLDS] for n in range(FOLDS)]
    products = np.stack([part @ part.T for part in parts])
    equations = equations_from(products, 1, np.array([1.0]))
    places = [(len(along) + i, Cell("airspeed_along", "", "time")) for i in range(len(cells))]
    beyond = Information(equations.inner).less(range(len(along)), sizes)
    return SimpleNamespace(
        keys=tuple(along),
        channels={},
        layout=SimpleNamespace(
            places=places, track={}, reference=SimpleNamespace(force_model=None)
        ),
        null=SimpleNamespace(gap_bayes_factor=THRESHOLDS.gap_bayes_factor),
        equations=equations,
        beyond=beyond,
        around_sizes=lambda _columns, _deviations: beyond,
        stands_out=True,
    )


def fitted(
    along: Along, residual: Array, cells: Sequence[Array] = ()
) -> tuple[list[FoundGap], FoundGap]:
    return Regression([block_of(along, residual, cells)]).fit()


def names(gaps: Sequence[FoundGap]) -> list[str]:
    return [gap.member.name for gap in gaps]


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
    found = Information(every @ every.T).posterior([0], [deviation])
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
        Information(every @ every.T), [0], Prior(*np.array([[1.0], [low], [high], [0.0]]))
    )
    assert found.log_evidence == pytest.approx(np.log(np.mean(integrals)), abs=1e-4)


def test_columns_eliminated_first_give_the_same_evidence_as_all_together() -> None:
    every = np.random.default_rng(3).normal(size=(5, 9))
    evidence, deviations = Information(every @ every.T), np.array([0.5, 2.0, 1.0, 0.3])
    rest, first = evidence.given([1, 3], deviations[[1, 3]], [0, 2])
    together = evidence.posterior(range(4), deviations).log_evidence
    assert first + rest.posterior([0, 1], deviations[[0, 2]]).log_evidence == pytest.approx(
        together, abs=1e-9
    )


def test_noise_shows_no_gap_and_no_log_is_refused() -> None:
    gaps, left = fitted({LAG: 20.0 * AXES[0], LATE: 20.0 * AXES[1]}, NOISE, [AXES[2]])
    assert not gaps
    assert left.log_bayes_factor < THRESHOLDS.gap_bayes_factor
    assert left.probability < 0.2
    assert sum(left.causes.values()) + left.unknown == pytest.approx(1.0)
    with pytest.raises(ValueError, match="no log"):
        Regression([])


def test_a_small_gap_is_found_beside_one_of_seventeen_hundred_sigma() -> None:
    """With one temper for all gaps the small one vanished."""
    along = {LAG: 1700.0 * AXES[0], LATE: 30.0 * AXES[1], POD: 100.0 * AXES[2]}
    gaps, left = fitted(along, along[LAG] + along[LATE] + NOISE, [AXES[3]])
    assert names(gaps) == ["pitot_lag", "gps_latency"]
    assert all(max(gap.forms.values()) > 0.999 for gap in gaps)
    assert all(gap.held_out > 0.9 for gap in gaps)
    assert left.log_bayes_factor < THRESHOLDS.gap_bayes_factor


def test_the_first_choice_is_taken_back_where_two_others_explain_it() -> None:
    """A column that stands for the sum of two is best alone, and needless beside them."""
    both = AXES[0] + AXES[1]
    along = {LAG: 60.0 * AXES[0], LATE: 60.0 * AXES[1], POD: 60.0 * (both + 0.6 * AXES[2])}
    gaps, _ = fitted(along, 60.0 * both + NOISE, [AXES[3]])
    assert sorted(names(gaps)) == ["gps_latency", "pitot_lag"]


def test_the_sizes_of_all_gaps_are_fitted_at_once_and_hold_the_truth() -> None:
    along = {LAG: 100.0 * AXES[0], LATE: 100.0 * (AXES[1] + 0.5 * AXES[0])}
    regression = Regression([block_of(along, 1.2 * along[LAG] + 0.7 * along[LATE] + NOISE)])
    gaps, _ = regression.fit()
    sizes = regression.sizes([gap.member for gap in gaps])
    for key, value, deviation in zip(
        sizes.keys, sizes.values, np.sqrt(np.diag(sizes.covariance)), strict=True
    ):
        true = {LAG: 1.2, LATE: 0.7}[key] * effect_of(key[0]).parameter(key[1]).typical
        assert abs(value - true) < 4.0 * deviation < 0.1 * true


def test_causes_that_act_alike_share_a_gap_and_what_no_cause_explains_is_unknown() -> None:
    alike = 20.0 * (AXES[0] + 0.01 * AXES[1])
    gaps, _ = fitted({LAG: 20.0 * AXES[0], LATE: alike}, 20.0 * AXES[0] + NOISE, [AXES[3]])
    (gap,) = gaps
    assert 0.3 < gap.causes["pitot_lag"] < 0.7
    assert sum(gap.causes.values()) + gap.unknown == pytest.approx(1.0)
    gaps, left = fitted({LAG: 20.0 * AXES[0], LATE: alike}, 60.0 * AXES[3] + NOISE, [AXES[3]])
    assert not gaps
    assert left.unknown > THRESHOLDS.likely
    assert left.place == "airspeed_along"


@pytest.mark.parametrize(("missed", "least", "most"), [(0.003, 0.5, 0.99), (0.1, 0.999, 1.0)])
def test_a_small_share_of_a_gap_does_not_decide_however_strong_it_is(
    missed: float, least: float, most: float
) -> None:
    """Two causes explain 500σ, one of them all but a share of its sum of squares."""
    nearly = 500.0 * (AXES[0] * np.sqrt(1.0 - missed) + AXES[1] * np.sqrt(missed))
    found = Regression([block_of({LAG: 500.0 * AXES[0], LATE: nearly}, 500.0 * AXES[0])])
    assert least < found.beside([]).causes["pitot_lag"] <= most


def test_a_size_that_cannot_be_excludes_its_cause() -> None:
    """A lag is never negative; a latency that fits as badly as the lag fits well is then the
    answer.
    """
    along = {LAG: -20.0 * AXES[0], POD: 20.0 * AXES[0] + AXES[1]}
    gaps, _ = fitted(along, 20.0 * AXES[0] + NOISE)
    assert names(gaps) == ["belly_pod"]


def test_a_cause_is_told_in_the_form_that_fits_and_its_forms_are_rivals() -> None:
    creep, plain = ("creep", "fraction"), ("hysteresis", "width_pa")
    for share, form in ((0.5, "creep"), (1.0, "hysteresis")):
        mixed = 40.0 * (AXES[0] * share + AXES[1] * np.sqrt(1.0 - share**2))
        gaps, _ = fitted({creep: 40.0 * AXES[0], plain: mixed}, 40.0 * AXES[0] + NOISE)
        assert names(gaps) == [form]
        assert list(gaps[0].causes) == ["hysteresis"]


SURFACES = [
    ("control_effectiveness", f"{surface}_change") for surface in ("elevator", "aileron", "rudder")
]


def test_surfaces_that_are_off_are_one_gap_with_their_sizes_alone() -> None:
    along = {key: 100.0 * axis for key, axis in zip(SURFACES, AXES, strict=False)}
    block = block_of(along, 0.9 * along[SURFACES[0]] - 0.4 * along[SURFACES[2]] + NOISE)
    found = fitted_by(Regression([block]))
    assert names(found.gaps) == ["control_effectiveness"]
    assert found.gaps[0].causes == pytest.approx({"control_effectiveness": 1.0}, abs=0.01)
    assert found.sizes.keys == (SURFACES[0], SURFACES[2])
    typical = effect_of(SURFACES[0][0]).parameter(SURFACES[0][1]).typical
    assert found.sizes.values / typical == pytest.approx([0.9, -0.4], abs=0.03)


def test_what_a_form_leaves_open_is_no_second_cause() -> None:
    """A pod pitches the airplane too, by an arm that nobody knows."""
    moment = ("pitch_stiffness", "zero_coefficient")
    along = {POD: 200.0 * AXES[0], moment: 100.0 * AXES[1], LATE: 100.0 * AXES[2]}
    pod = along[POD] + 0.2 * along[moment] + NOISE
    assert names(fitted(along, pod)[0]) == ["belly_pod"]
    moved = along[LATE] + 0.2 * along[moment] + NOISE
    assert sorted(names(fitted(along, moved)[0])) == ["gps_latency", "pitch_stiffness"]


def test_what_a_form_leaves_open_is_in_the_sizes_and_closes_the_gap() -> None:
    """Else the fit and the closure tell two stories of one log."""
    moment = ("pitch_stiffness", "zero_coefficient")
    along = {POD: 200.0 * AXES[0], moment: 100.0 * AXES[1]}
    block = block_of(along, along[POD] + 0.2 * along[moment] + NOISE)
    one = fitted_by(Regression([block]))
    assert names(one.gaps) == ["belly_pod"]
    typical = effect_of("pitch_stiffness").parameter("zero_coefficient").typical
    assert one.sizes.by_key()[moment] == pytest.approx(0.2 * typical, rel=0.1)
    fit = one.fit_of(block)
    closed = closure_of(Information(block.equations.inner), fit.columns, fit.sizes.tolist(), [])
    assert closed.share > 0.999


@pytest.mark.parametrize(("score", "counts"), [(3.0, False), (5.0, True)])
def test_a_cell_is_a_part_of_the_gap_from_four_sigma_on(score: float, counts: bool) -> None:
    """Many small cells are noise: with them in the gap, a name that closes it would not."""
    cells = [*AXES[1:6]]
    flat = NOISE - sum((NOISE @ axis) * axis for axis in AXES)
    block = block_of({POD: 30.0 * AXES[0]}, 30.0 * AXES[0] + score * sum(cells) + flat, cells)
    size = effect_of("belly_pod").parameter("drag_area_m2").typical
    evidence = Information(block.equations.inner)
    closed = closure_of(evidence, [0], [size], range(1, 6))
    extra = 5.0 * (score**2 - 1.0) if counts else 0.0
    assert closed.after + 1.0 - closed.noise == pytest.approx(extra, rel=0.1, abs=1.0)


def test_an_open_form_costs_an_effect_nothing_against_one_that_acts_alike() -> None:
    """Where the pod's moment is not there, turn drag is no better an answer than the pod."""
    moment, turn = ("pitch_stiffness", "zero_coefficient"), ("turn_drag", "coefficient_at_30deg")
    along = {POD: 60.0 * AXES[0], turn: 60.0 * AXES[0], moment: 2000.0 * AXES[1]}
    (gap,) = fitted(along, along[POD] + NOISE, [AXES[3]])[0]
    assert 0.25 < gap.causes["belly_pod"] < 0.6


def test_what_null_flights_show_of_the_same_fit_is_no_gap() -> None:
    """Errors of a rate and an angle pull both coefficients of a moment toward zero on every flight:
    their sum is small, so that neither shows it alone.
    """
    stiff, damped = ("pitch_stiffness", "change"), ("pitch_damping", "change")
    along = {stiff: 100.0 * AXES[0], damped: 40.0 * AXES[1] - 100.0 * AXES[0], LAG: 90.0 * AXES[2]}
    pulled = -1.0 * (along[stiff] + along[damped])
    flights = [pulled + each for each in DRAW.normal(size=(8, ROWS))]
    log = along[LAG] + pulled + NOISE
    assert names(fitted(along, log)[0]) == ["pitot_lag", "pitch_damping", "pitch_stiffness"]
    one = Regression([block_of(along, log, (), flights)]).fit()
    assert names(one[0]) == ["pitot_lag"]
    assert one[1].log_bayes_factor < THRESHOLDS.gap_bayes_factor


def test_what_gusts_pull_on_every_flight_does_not_turn_one_coefficient_into_two() -> None:
    """Of a moment in balance the three terms nearly cancel: one that is larger is two others that
    are smaller, but for their small sum, which noise pulls toward zero.
    """
    raised, stiff, damped = (
        ("trim_offset", "pitch_coefficient"),
        *((name, "change") for name in ("pitch_stiffness", "pitch_damping")),
    )
    along = {raised: 100.0 * AXES[0], stiff: 100.0 * AXES[1]}
    along[damped] = 50.0 * AXES[2] - along[raised] - along[stiff]
    pulled = -0.6 * sum(along.values())
    flights = [pulled + each for each in DRAW.normal(size=(8, ROWS))]
    log = 0.5 * along[raised] + pulled + NOISE
    assert names(fitted(along, log)[0]) != ["trim_offset"]
    (gap,), _ = Regression([block_of(along, log, (), flights)]).fit()
    assert gap.member.name == "trim_offset"


def test_a_gap_of_one_moment_is_not_taken() -> None:
    """A column that explains one part of a log has no gain where that part is left out."""
    burst = np.where(np.arange(ROWS) % FOLDS == 0, 40.0 * AXES[0], 0.0)
    gaps, left = fitted(
        {LAG: burst + 40.0 * (AXES[1] - np.where(burst, AXES[1], 0.0))}, burst + NOISE
    )
    assert not gaps
    assert left.log_bayes_factor < THRESHOLDS.gap_bayes_factor


def test_a_term_of_a_formula_competes_like_any_other() -> None:
    term = ("drag_formula", "sideslip_squared")
    along = {LAG: 60.0 * AXES[0], term: 60.0 * AXES[1]}
    gaps, _ = fitted(along, along[LAG] + along[term] + NOISE, [AXES[1], AXES[3]])
    assert sorted(names(gaps)) == ["drag_formula|sideslip_squared", "pitot_lag"]
    assert {name for gap in gaps for name in gap.causes} == {"pitot_lag"}


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_several_logs_are_blocks_of_one_stacked_log(seed: int) -> None:
    """Dense covariances of the stacked residuals, with the free column of each log its own."""
    random, logs = np.random.default_rng(seed), []
    for _ in range(3):
        one, two = random.normal(size=(2, ROWS)) / np.sqrt(ROWS)
        logs.append((3.0 * one, 5.0 * two, random.normal(size=ROWS) + 2.0 * one))
    blocks = [block_of({LAG: one, LATE: two}, residual) for one, two, residual in logs]
    regression, deviations = Regression(blocks), np.array([0.3, 0.2])
    found = regression.evidence.posterior([0, 1], deviations)
    typical = np.array([effect_of(e).parameter(p).typical for e, p in (LAG, LATE)])
    # Each log's own constant, of deviation 1, adds a dense block to the covariance of its noise.
    own = np.linalg.inv(np.eye(ROWS) + np.ones((ROWS, ROWS)))
    inner, right = np.diag(deviations**-2.0), np.zeros(2)
    for one, two, residual in logs:
        columns = np.stack([one, two], axis=1) / typical
        inner, right = inner + columns.T @ own @ columns, right + columns.T @ own @ residual
    assert found.mean == pytest.approx(np.linalg.solve(inner, right), rel=1e-7)
    assert found.covariance == pytest.approx(np.linalg.inv(inner), rel=1e-7)


FEW = Catalog(
    "effect", {name: EFFECTS[name] for name in ("pitot_lag", "gps_latency", "wind_drift")}
)


def test_the_floor_is_marginalized_as_dense_algebra_does(sensed) -> None:
    """A fluctuating part that null flights show with 4σ, and the wander of a channel: the evidence
    of each size against dense covariances.
    """
    log = sensed("gps_latency", das="20/20")
    layout = lay_out(
        log.select(log.time - log.time[0] < 120.0), None, AnalysisSetting(day_known=True), FEW
    )
    noise = noise_of_log(layout)
    scale = ScoreScale({}, {}, {}, {}, {"gps_latency|latency_s": 4.0})
    found = evidence_beyond_floor(layout, whitened_equations(layout, noise), scale, {})
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
    for i, signature in enumerate(layout.signatures):
        deviation = abs(EFFECTS[signature.effect].parameter(signature.parameter).typical)
        column = rows[:, k + i]
        solved = np.linalg.solve(plain, np.stack([column, residual], axis=1))
        precision = deviation**-2 + column @ solved[:, 0]
        expected = 0.5 * (column @ solved[:, 1]) ** 2 / precision - 0.5 * np.log(
            precision * deviation**2
        )
        assert found.posterior([i], [deviation]).log_evidence == pytest.approx(
            expected, rel=1e-4, abs=1e-3
        )


def test_what_a_size_has_on_every_flight_is_taken_off_the_log(sensed) -> None:
    """All that sees the size sees it go; of a size that the log hardly shows, hardly anything."""
    log = sensed("gps_latency", das="20/20")
    layout = lay_out(
        log.select(log.time - log.time[0] < 120.0), None, AnalysisSetting(day_known=True), FEW
    )
    equations, instants = whitened_equations(layout, noise_of_log(layout)), len(layout.grid)
    late = [s.effect for s in layout.signatures].index("gps_latency")
    plain = evidence_beyond_floor(layout, equations, ScoreScale({}, {}, {}, {}), {}).inner

    def less(power: float) -> Array:
        lasting = {"gps_latency|latency_s": 7.0 / instants}
        scale = ScoreScale({}, {}, {}, {}, lasting=lasting, products=[[power / instants]])
        return evidence_beyond_floor(layout, equations, scale, {}).inner

    size = 7.0 / (plain[late, late] * (1.0 + THRESHOLDS.lasting_share))
    expected = size * plain[:, late]
    assert (plain - less(plain[late, late]))[:-1, -1] == pytest.approx(expected[:-1])
    fall = 2.0 * size * plain[late, -1] - size**2 * plain[late, late]
    assert (plain - less(plain[late, late]))[-1, -1] == pytest.approx(fall)
    assert (plain - less(1e6 * plain[late, late]))[late, -1] == pytest.approx(7e-4, rel=1e-3)


def test_a_power_that_rounding_made_negative_counts_as_none():
    """Wide priors of sizes that others reproduce ended an answer in an error."""
    axes = np.linalg.qr(DRAW.standard_normal((4, 4)))[0]
    inner = np.zeros((2, 5, 5))
    for each, least in zip(inner, (0.0, -1.2), strict=True):
        each[:4, :4] = (axes * np.array([1e7, 3.0, least, 5.0])) @ axes.T
    plain, rounded = map(Information, inner)
    sizes = range(4), np.ones(4)
    assert rounded.posterior(*sizes).log_evidence == pytest.approx(
        plain.posterior(*sizes).log_evidence
    )
    assert np.all(np.isfinite(rounded.given(*sizes)[0].inner))
