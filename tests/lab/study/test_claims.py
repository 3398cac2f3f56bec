"""Every claim is answered, and its verdict follows the numbers in both directions."""

import itertools

import numpy as np
import pytest
from tests.lab.study import made_up

from pitotlab.study.claims import CLAIMS
from pitotlab.study.claims.models import by_chance
from pitotlab.study.claims.ranking import best_agreement, power
from pitotlab.study.claims.ranking import by_chance as by_luck
from pitotlab.study.reductions import NAMES

PUBLISHED = {"step_decrease": 0.75, "race_track": 1.2, "four_leg": 1.5, "rapid_decel": 2.1}


def as_published(sortie, reduction):
    """Residuals as the paper's words have them, made up to be so."""
    if sortie.setting == "airplane":
        return PUBLISHED[sortie.case.maneuver]
    value = 0.5 + 0.05 * list(NAMES).index(sortie.case.maneuver)
    value *= 1.1 if reduction.das == "20/1" else 1.0
    value *= 2.0 if reduction.options.model == "bias" else 1.0
    without = 1.05 if reduction.das == "20/1" else {"four_leg": 1.4}.get(sortie.case.maneuver, 1.25)
    value *= 1.0 if reduction.options.use_down else without
    return value * {"six speeds": 0.97, "long steps": 1.03}.get(sortie.variant, 1.0)


def otherwise(sortie, reduction):
    """Residuals that contradict every claim about them."""
    if sortie.setting == "airplane":
        return 1.0 / PUBLISHED[sortie.case.maneuver]
    value = 0.9 - 0.05 * list(NAMES).index(sortie.case.maneuver)
    value *= {"20/1": 1.5, "100/100": 1.2}.get(reduction.das, 1.0)
    value *= 1.5 if reduction.options.model == "quadratic" else 1.0
    value *= 1.3 if reduction.options.on_condition else 1.0
    return value * {"six speeds": 1.03, "long steps": 0.97}.get(sortie.variant, 1.0)


@pytest.fixture(scope="module")
def published():
    return made_up.evidence(as_published)


@pytest.fixture(scope="module")
def contradicted():
    minutes = dict.fromkeys(made_up.MINUTES, 12.0)
    return made_up.evidence(otherwise, minutes)


def test_the_table_holds_all_claims():
    assert list(CLAIMS) == [f"C{n}" for n in range(1, 14)]


@pytest.mark.parametrize("number", [n for n in CLAIMS if n not in ("C11", "C12")])
def test_numbers_otherwise_do_not_reproduce_the_claim(number, contradicted):
    assert CLAIMS[number].answer(contradicted).verdict != "reproduced"


@pytest.mark.parametrize("number", CLAIMS)
def test_numbers_as_published_reproduce_the_claim_with_a_number_and_a_reason(number, published):
    finding = CLAIMS[number].answer(published)
    assert finding.verdict == "reproduced"
    assert any(character.isdigit() for character in finding.ours)
    assert len(finding.why) > 40
    assert len(finding.experiment) > 40
    assert "nan" not in finding.ours


def test_airplane_order_decides(contradicted):
    """The fixed-speed point still agrees."""
    assert CLAIMS["C12"].answer(contradicted).verdict == "in part"


def test_ratings_are_never_ours(published):
    finding = CLAIMS["C11"].answer(published)
    assert "not rated" in finding.ours
    assert "not ratings" in finding.why


def test_chance_counts_every_choice():
    rng = np.random.default_rng(5)
    sizes = {"a": 4, "b": 3, "c": 5}
    flights = {name: rng.integers(0, 6, size).astype(float) for name, size in sizes.items()}
    choices = list(itertools.product(*flights.values()))
    rising = sum(a < b < c for a, b, c in choices)
    assert by_chance(flights) == pytest.approx(100.0 * rising / len(choices))


def _how_steep(sortie, reduction):
    """No fall as flown; at every multiple of the vertical speed V_down takes out a fixed share."""
    down = reduction.options.use_down
    return 0.6 * (0.5 if down and reduction.change == "vertical speed" else 1.0)


def test_what_v_down_would_take_is_measured_not_said():
    """C7 names a fall that steeper flights have, and that those as flown have not."""
    finding = CLAIMS["C7"].answer(_small(_how_steep))
    assert finding.verdict == "not reproduced"
    assert "needs 4.0 times that" in finding.why
    level = CLAIMS["C7"].answer(_small(lambda sortie, reduction: 0.6))
    assert "does not reach a fall of 25 % at 24 times that" in level.why


def _small(residual):
    return made_up.evidence(residual, seeds=1, sweeps=False)


def _pooled_only(sortie, reduction):
    """The fall of a mean over three outputs of which one has no residual."""
    return (2.0 / 3.0) ** 0.5 if reduction.alone and reduction.options.use_down else 1.0


def test_a_pooled_fall_alike_for_all_reproduces_in_part():
    """The pooled 2σ falls, but not most for 4-Leg; without the outputs' fits nothing does."""
    pooled, none = _small(_pooled_only), _small(lambda sortie, reduction: 1.0)
    for number in ("C7", "C8"):
        assert "18.4" in CLAIMS[number].answer(pooled).ours
    assert CLAIMS["C7"].answer(pooled).verdict == "in part"
    assert CLAIMS["C7"].answer(none).verdict == "not reproduced"

    def turning(sortie, reduction):
        straight = reduction.options.on_condition and not reduction.alone
        return _pooled_only(sortie, reduction) * (1.1 if straight else 1.0)

    assert CLAIMS["C8"].answer(_small(turning)).verdict == "in part"  # by the pooled 2σ alone


def test_an_error_chosen_for_a_claim_does_not_count():
    """Bias doubles the others with the default error alone: the claim is not reproduced by it."""

    def chosen(sortie, reduction):
        other = reduction.change in ("error size", "linear truth", "quadratic truth", "knee truth")
        return 2.0 if reduction.options.model == "bias" and not other else 1.0

    assert CLAIMS["C5"].answer(_small(chosen)).verdict == "not reproduced"

    def larger(sortie, reduction):
        ratio = 1.0 + reduction.level if reduction.change == "error size" else 2.0
        return ratio if reduction.options.model == "bias" else 1.0

    finding = CLAIMS["C5"].answer(_small(larger))
    assert finding.verdict == "in part"
    assert finding.ours.startswith("1.25 (0.25 times the default error) to 3.00 times (2 times")


def test_the_wind_that_hides_the_slope_is_an_experiment():
    """Bias looks as good as the others until every speed is flown on both headings."""

    def hidden(sortie, reduction):
        bias = reduction.options.model == "bias"
        return 2.0 if bias and sortie.case.maneuver != "step_decrease" else 1.0

    finding = CLAIMS["C5"].answer(_small(hidden))
    assert "default error, 1.00." in finding.why
    assert "both headings the ratio is 2.00," in finding.why


def test_chance_and_power_of_a_rank_test():
    """Of 120 orders of five, 12 have at most one wrong pair out of eight."""
    ratings = np.array([3.0, 4.0, 2.0, 2.0, 3.0])
    assert by_luck(ratings, 0.5) == pytest.approx(100.0 * 12 / 120)
    assert best_agreement(ratings) == pytest.approx(0.8)
    assert power(ratings, 0.5, 1e-6) == 100.0
    assert power(ratings, 0.5, 100.0) == pytest.approx(by_luck(ratings, 0.5), abs=1.5)
    distinct = np.arange(8.0)
    assert by_luck(distinct[:5], 0.9) == pytest.approx(100.0 / 120)
    assert power(distinct, 0.5, 1.0) > power(distinct[:5], 0.5, 1.0)


def test_an_order_within_its_own_spread_is_no_order():
    """Means that rise by less than chance makes of them reproduce no order."""

    def barely(sortie, reduction):
        rank = [*PUBLISHED].index(sortie.case.maneuver)
        return 1.0 + 0.001 * rank + 0.1 * (sortie.case.truth_seed % 2)

    def anywhere(sortie, reduction):
        return barely(sortie, reduction) if sortie.setting == "airplane" else 1.0

    finding = CLAIMS["C12"].answer(made_up.evidence(anywhere, seeds=10))
    assert finding.verdict == "in part"
