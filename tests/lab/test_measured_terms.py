"""Terms of an airplane's file corrected on measured maneuvers, against the published derivatives."""

import numpy as np
import pytest
from tests.shared_data import real_log

from pitotbench import read_log
from pitotbench.bench.workflow import NamedLog, reconcile_fully
from pitotbench.models.maneuver_model import in_place_of_log
from pitotbench.models.maneuver_parts import maneuvers_of
from pitotbench.models.sidpac import read_identification


def reconciled(aircraft, fitted, held=()):
    logs = [NamedLog("a log", in_place_of_log(each, aircraft)) for each in (fitted, held) if each]
    outcome = reconcile_fully(logs[0], aircraft, *logs[1:], refly=False)
    return outcome, {each.effect: each.measured for each in outcome.account.coefficients}


# Until which minute, of those from 46 on, flaps and gear are up.
@pytest.mark.long
@pytest.mark.parametrize(
    "minute",
    [
        71.0,
        pytest.param(
            55.0,
            marks=pytest.mark.xfail(
                strict=True,
                reason="two maneuvers of four: 4.03 ± 0.26, below all estimates from flights",
            ),
        ),
    ],
)
def test_the_citation_of_delft_is_corrected_on_maneuvers_held_out(minute):
    """Published: 5.74 per radian, the vane's scale unknown; from other flights 4.25 to 5.1."""
    log = read_log(real_log("citation", "2019-03-12.parquet"))
    since = log.time - log.time[0]
    cruise = log.select((since > 46 * 60.0) & (since < minute * 60.0))
    found = maneuvers_of(cruise, "citation")
    outcome, told = reconciled("citation", found[::2], found[1::2])
    assert abs(told["lift_slope"].value - 4.7) < 0.6
    assert outcome.verdict.closure_holdout.share > 0.7
    assert "angle-of-attack vane lags" in outcome.account.warnings[0]


def test_the_twin_otter_of_nasa_has_a_steeper_lift_slope_than_its_file():
    """Estimates beside the data (Morelli): 6.35 and 6.76 per radian by C_Z. Of the pitching moment
    his model has no term of the rate of the angle of attack: its damping holds the −8 of the file's.
    """
    fitted, held = (
        read_identification(real_log("sidpac", f"totter_lon_020213f1_{number}.mat"))
        for number in ("018", "017")
    )
    outcome, told = reconciled("DHC6", [fitted], [held])
    assert outcome.verdict.gaps[0].causes[0].name == "lift_slope"
    assert abs(told["lift_slope"].value - 6.35) < told["lift_slope"].two_sigma < 0.5
    assert outcome.verdict.closure_holdout.share > 0.9
    by_rate = -8.0
    published = {
        "pitch_stiffness": (-1.476, 0.045),
        "control_moments": (-1.869, 0.041),
        "pitch_damping": (-36.35 - by_rate, 1.38),
    }
    for name, (value, two_sigma) in published.items():
        assert abs(told[name].value - value) < np.hypot(told[name].two_sigma, two_sigma)
