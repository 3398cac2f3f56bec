"""Which rates of integration fit which data system."""

import pytest

from pitotbench.records.case import USUAL_RATE, possible_rates, rate_problem, rates_for


@pytest.mark.parametrize(
    ("air_rate", "rates"),
    [
        (20.0, (40.0, 60.0, 80.0, 100.0)),
        (50.0, (50.0, 100.0)),
        (100.0, (100.0,)),
        (33.0, (100.0,)),
        (12.5, (50.0, 100.0)),
    ],
)
def test_a_rate_is_a_whole_multiple_of_the_air_datas(air_rate, rates):
    assert rates_for(air_rate) == rates


def test_the_usual_rate_serves_every_data_system():
    assert not any(rate_problem(USUAL_RATE, air_rate) for air_rate in (1.0, 33.0, 50.0, 99.0, 100.0))


def test_a_tick_of_the_card_is_a_whole_number_of_steps():
    assert all((0.1 * rate) == pytest.approx(round(0.1 * rate)) for rate in possible_rates())


def test_the_message_says_what_would_do():
    assert rate_problem(50.0, 20.0) == (
        "50 Hz is not a whole multiple of the 20 Hz of the air data: "
        "integrate the flight at 40 or 60 or 80 or 100 Hz"
    )
    assert "not at 30 Hz" in str(rate_problem(30.0))
