"""The loading of a log: it is judged, and its card is flown, at the mass that its own column
states.
"""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import BadInputError, Case, FlightLog, fly, sense
from pitotbench.bench.flown_card import as_flown, card_of
from pitotbench.effects.overlay import Overlay
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.replay import motion_of
from pitotbench.reconciliation.track import track_of
from pitotbench.records.case import EffectSpec, PressureErrorSpec
from pitotbench.simulation.modified import Loading, loaded_mass, mass_of
from pitotbench.units import FOOT

CARD = Case(maneuver="rapid_decel", turbulence="none")
TRUE = PressureErrorSpec("bias", (0.0,))  # an error curve would be a residual of its own


@pytest.fixture(scope="module", params=[{"fuel": 0.4}, {"ballast": 200.0}], ids=["light", "heavy"])
def log(request) -> FlightLog:
    """Half a minute of a flight without an effect, lighter or heavier than the aircraft's file
    loads it.
    """
    whole = sense(fly(replace(CARD, pressure_error=TRUE, **request.param)), "50/50")
    return whole.select(whole.time < whole.time[0] + 25.0)


def force_residual(log: FlightLog) -> float:
    """Mean specific force along z that the model lacks [m/s²]."""
    track, model = track_of(log), aircraft_model("navajo")
    rows = np.arange(0, len(track.time), 5)
    felt = model.react(motion_of(track, rows), Overlay(), True)
    return float(np.mean(log.specific_force_z) - np.mean(felt.specific_force_z))


def test_the_force_residual_of_another_loading_is_that_of_the_weight_it_lacks(
    log: FlightLog,
) -> None:
    right = force_residual(log)
    wrong = force_residual(replace(log, mass=np.full(len(log), loaded_mass("navajo"))))
    assert abs(right) < 0.05 * abs(wrong)
    assert abs(wrong) > 0.5


def test_a_card_is_flown_at_the_first_mass_of_its_log(log: FlightLog) -> None:
    card = card_of(
        {"case": {"maneuver": "rapid_decel"}}, "navajo"
    )  # a header that does not tell the loading
    loaded = as_flown(card, log)
    assert mass_of("navajo", Loading(loaded.fuel, loaded.ballast)) == pytest.approx(
        log.mass[0], abs=5.0
    )
    # Logs within some kilograms share a card.
    first, second = (as_flown(CARD, replace(log, mass=log.mass + more)) for more in (0.0, 0.3))
    assert first == second != CARD
    with pytest.raises(BadInputError, match="check the unit"):
        as_flown(CARD, replace(log, mass=log.mass / 0.45359237))


def test_a_card_that_states_its_loading_or_a_log_without_a_mass_changes_no_card(
    log: FlightLog,
) -> None:
    stated = card_of(log.header, "navajo")
    assert as_flown(stated, log) is stated
    assert as_flown(CARD, replace(log, mass=None)) is CARD


def test_a_load_that_is_not_on_the_weight_sheet_is_a_gap() -> None:
    """150 kg are 5 % of the weight, and so is what the model lacks along z, flown at the mass of
    the sheet.
    """
    hidden = (EffectSpec("mass", {"mass_kg": 150.0}),)
    whole = sense(fly(replace(CARD, pressure_error=TRUE, effects=hidden)), "50/50")
    log = whole.select(whole.time < whole.time[0] + 25.0)
    assert as_flown(CARD, log) is CARD
    assert force_residual(log) == pytest.approx(
        9.8 * 150.0 / (loaded_mass("navajo") + 150.0), rel=0.15
    )


@pytest.mark.parametrize(("feet", "flown"), [(-1100.0, -1000.0), (90.0, 0.0), (700.0, 750.0)])
def test_a_card_is_flown_at_the_height_of_its_log(
    log: FlightLog, feet: float, flown: float
) -> None:
    card = card_of(log.header, "navajo")
    level = np.full(len(log), card.altitude + feet * FOOT)
    assert as_flown(card, replace(log, altitude=level)).altitude == pytest.approx(
        card.altitude + flown * FOOT
    )
    assert as_flown(card, replace(log, altitude=None)).altitude == card.altitude
