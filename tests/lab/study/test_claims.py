"""Every claim is answered, and its verdict follows the numbers in both directions."""

import numpy as np
import pytest
from tests.lab.study import made_up

from pitotlab.study.claims import CLAIMS
from pitotlab.study.claims.models import orders
from pitotlab.study.claims.ranking import best_agreement, power
from pitotlab.study.claims.ranking import by_chance as by_luck
from pitotlab.study.reductions import NAMES
from pitotlab.study.rules import RULES
from pitotlab.study.tables import Spread

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
    assert CLAIMS[number].answer(contradicted).verdict not in ("reproduced", "set by the cards")


@pytest.mark.parametrize("number", CLAIMS)
def test_numbers_as_published_reproduce_the_claim_with_a_number_and_a_reason(number, published):
    finding = CLAIMS[number].answer(published)
    assert finding.verdict == ("set by the cards" if number in ("C1", "C13") else "reproduced")
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


def test_a_pooled_fall_is_told_and_does_not_count():
    """An output without residual lowers the pooled 2σ; the claim is about that of the airspeed."""
    pooled = _small(_pooled_only)
    for number, verdict in (("C7", "not reproduced"), ("C8", "in part")):
        finding = CLAIMS[number].answer(pooled)
        assert "18.4" in finding.ours
        assert finding.verdict == verdict

    def turning(sortie, reduction):
        straight = reduction.options.on_condition and not reduction.alone
        return _pooled_only(sortie, reduction) * (1.1 if straight else 1.0)

    assert CLAIMS["C8"].answer(_small(turning)).verdict == "not reproduced"


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


@pytest.mark.parametrize(("seeds", "verdict"), [(4, "in part"), (5, "reproduced")])
def test_an_order_needs_more_than_half_of_the_seeds(seeds, verdict):
    """Odd seeds are in the published order, even ones in the reverse."""

    def in_turn(sortie, reduction):
        value = PUBLISHED.get(sortie.case.maneuver, 1.0)
        return value if sortie.case.truth_seed % 2 else 1.0 / value

    evidence = made_up.evidence(in_turn, seeds=5 * seeds)  # a fifth fly the airplane
    assert CLAIMS["C12"].answer(evidence).verdict == verdict
    share, tau = orders(evidence)
    odd = (seeds + 1) // 2
    assert share == odd / seeds
    assert tau.mean == pytest.approx((2 * odd - seeds) / seeds)


JUST = {
    "C1": ([1.0, -1.0], [1.1, 0.0]),
    "C2": ([1.0, 3.0, 2.0, 4.0, 5.0], [2.0, 1.0, 3.0, 4.0, 5.0]),
    "C3": ([4.9, 0.0, 0.0, 0.0, 9.0], [4.9, 0.0, 0.0, 9.0, 9.0]),
    "C4": ([30.0, 30.0, 20.0, 10.0, 10.0], [30.0, 30.0, 21.0, 10.0, 10.0]),
    "C5": ([1.03, 3.0], [1.01, 2.0]),
    "C6": ([9.0, 9.0, 0.0, 0.0, -4.9], [9.0, 9.0, -9.0, 0.0, 0.0]),
    "C11": ([0.6, -1.0, -1.0], [0.5, 0.5, 0.5]),
    "C13": (0.33, 0.34),
}


@pytest.mark.parametrize("number", JUST)
def test_a_band_ends_where_its_words_say(number):
    """The first numbers are just in part (or set by the cards), the second just not."""
    inside, outside = map(RULES[number].judge, JUST[number])
    assert inside in ("in part", "set by the cards")
    assert outside == "not reproduced"


def test_one_seed_decides_no_sign():
    """With one seed there is no interval, and two hardly give one."""
    for values in ([-1.0], [-1.0, -1.2]):
        assert RULES["C10"].judge(Spread.of(values)) == "in part"
    assert RULES["C10"].judge(Spread.of([-1.0, -1.2, -1.1])) == "reproduced"
    assert RULES["C9"].judge(Spread.of([-1.0]), Spread.of([1.0])) == "not reproduced"
