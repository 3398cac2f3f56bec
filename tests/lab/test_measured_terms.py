"""Terms of an airplane's file corrected on measured maneuvers, against the published derivatives."""

import numpy as np
from tests.shared_data import real_log

from pitotbench import read_log
from pitotbench.bench.identification import maneuvers_of, read_identification
from pitotbench.bench.model_terms import correct_terms, parted


def test_the_citation_of_delft_is_corrected_on_maneuvers_held_out():
    """Its published lift slope is 5.74 per radian; the scale of the vane is not known."""
    log = read_log(real_log("citation", "2019-03-12.parquet"))
    since = log.time - log.time[0]
    cruise = log.select((since > 46 * 60.0) & (since < 55 * 60.0))  # flaps and gear are up
    account = correct_terms("citation", *parted(maneuvers_of(cruise, "citation"))).account
    changes = {term.name: term for term in account.terms}
    assert abs(changes["lift slope"].measured.value - 4.7) < 0.6
    assert account.closed > 0.7
    assert "angle-of-attack vane lags" in account.remarks[0]


def test_the_twin_otter_of_nasa_has_a_steeper_lift_slope_than_its_file():
    """Estimates beside the data (Morelli): 6.35 and 6.76 per radian by C_Z, -1.87 and -1.83 by the
    elevator.
    """
    fitted, held = (
        read_identification(real_log("sidpac", f"totter_lon_020213f1_{number}.mat"))
        for number in ("018", "017")
    )
    account = correct_terms("DHC6", [fitted], [held]).account
    assert account.terms[0].name == "lift slope"
    assert 5.9 < account.terms[0].measured.value < 6.9
    elevator = next(term for term in account.terms if term.name == "elevator effectiveness")
    assert abs(elevator.measured.value + 1.87) < 0.15
    assert account.gap_of("lift").closed > 0.9
    assert account.closed > 0.8
    flown = account.flown[1]
    before, after = (
        np.linalg.norm((each - flown.measured)[:, 2]) for each in (flown.before, flown.after)
    )
    assert after < 0.6 * before
