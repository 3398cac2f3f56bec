"""What is plausible stays without a word, on whatever headings and in whatever wind it was flown."""

import numpy as np
import pytest
from tests.logbook.bad_logs import GOOD, NEEDED, TIME

from pitotbench import FlightLog, air, read_log, write_log
from pitotbench.units import DEGREE, STANDARD_GRAVITY


def moved(table, name, change):
    return {**table, name: change(table[name])}


CIRCLE = GOOD["a circle"]
NO_WORD = GOOD | {
    "a circle without height, heading or temperature": {name: CIRCLE[name] for name in NEEDED},
    # A low of 980 hPa: 280 m of pressure altitude.
    "weather moves the static pressure of a height": moved(CIRCLE, "altitude_m", lambda height: height - 280.0),
}
DOUBTED = {
    "a zero that a small gauge may have": (
        moved(GOOD["a small airplane in a wind of half its speed"], "impact_pressure_pa", lambda q: q + 100.0),
        "zero offset",
    ),
    "a height above the field": (moved(CIRCLE, "altitude_m", lambda h: h - 1000.0), "no weather explains that"),
    "a change of the pitot gain in flight": (
        moved(CIRCLE, "impact_pressure_pa", lambda q: q * np.where(TIME < 30.0, 1.0, 1.3)),
        "from the first to the second half",
    ),
}


@pytest.mark.parametrize("name", list(NO_WORD))
def test_a_good_log_has_no_warning(read, name):
    assert "warnings" not in read(NO_WORD[name]).header


@pytest.mark.parametrize("name", list(DOUBTED))
def test_what_may_be_is_doubted_and_not_refused(read, name):
    table, says = DOUBTED[name]
    assert any(says in words for words in read(table).header["warnings"])


def turning(bank_deg: float) -> FlightLog:
    """Legs and level turns of 20 s by turns at 80 m/s; the angle of attack is −3° without lift, and 3° on a leg."""
    time = np.arange(4000) / 20.0
    bank = bank_deg * DEGREE * (time % 40.0 > 20.0)
    rate = STANDARD_GRAVITY * np.tan(bank) / 80.0
    track = np.cumsum(rate) / 20.0
    load_factor = 1.0 / np.cos(bank)
    attack = (6.0 * load_factor - 3.0) * DEGREE
    noise = np.random.default_rng(5).normal(0.0, 1e-3, (5, len(time)))
    pitch = np.arcsin(np.sin(attack) * np.cos(bank))
    return FlightLog(
        time=time,
        impact_pressure=air.impact_pressure(np.full(len(time), 72.0)) + noise[0],
        static_pressure=np.full(len(time), 81_200.0) + noise[1],
        velocity_north=80.0 * np.cos(track) + noise[3],
        velocity_east=80.0 * np.sin(track) + noise[4],
        roll=bank,
        pitch=pitch + noise[2],
        heading=np.mod(track, 2.0 * np.pi),
        specific_force_x=STANDARD_GRAVITY * load_factor * np.sin(attack),
    )


@pytest.mark.parametrize("bank_deg", [30.0, 45.0])
def test_the_pitch_of_a_flight_with_steep_turns_is_kept(tmp_path, bank_deg):
    """In a cloverleaf the motion seemed to ask for several times the pitch, and the column was left out."""
    write_log(turning(bank_deg), tmp_path / "log.parquet")
    assert read_log(tmp_path / "log.parquet").pitch is not None
