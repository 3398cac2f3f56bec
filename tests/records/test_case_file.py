"""Case files read back equal, every problem is answered by its key; which rates fit which data
system.
"""

import tomllib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pitotbench.records import BadInputError
from pitotbench.records.case import (
    _NAMES,
    PILOTS,
    TURBULENCE_SEVERITY,
    USUAL_RATE,
    Case,
    DataSystem,
    EffectSpec,
    PressureErrorSpec,
    Wind,
    broken_rules,
    possible_rates,
    rate_problem,
    rates_for,
)
from pitotbench.records.case_file import case_table, read_case, write_case
from pitotbench.units import FOOT

positive = st.floats(1e-6, 1e6)
some = st.floats(0.0, 1e6)
names = st.from_regex(r"[a-z][a-z_]{0,12}", fullmatch=True)
systems = st.builds(
    DataSystem,
    air_rate=st.floats(50.0, 100.0),
    gps_rate=st.floats(0.1, 50.0),
    impact_pressure_noise=some,
    temperature_noise=some,
    vane_noise=some,
    gps_latency=some,
    recovery_factor=positive,
)
cases = st.builds(
    Case,
    aircraft=st.text(max_size=20),
    maneuver=st.sampled_from(_NAMES["maneuver"]),
    card=st.dictionaries(
        names, st.floats(-1e9, 1e9) | st.integers(-99, 99) | st.booleans() | st.text(max_size=5)
    ),
    altitude=st.floats(-500.0, 2e4),
    temperature_offset=st.floats(-50.0, 50.0),
    wind=st.builds(
        Wind, speed=some, from_direction=st.floats(-10.0, 10.0), up=st.floats(-10.0, 10.0)
    ),
    fuel=st.floats(0.001, 1.0),
    ballast=st.floats(-1000.0, 1000.0),
    turbulence=st.sampled_from(sorted(TURBULENCE_SEVERITY)),
    pilot=st.sampled_from(PILOTS),
    pressure_error=st.builds(
        PressureErrorSpec,
        parameters=st.lists(st.floats(-1.0, 1.0), max_size=4).map(tuple),
        reference_pressure=positive,
        airspeed=st.lists(positive, max_size=4).map(tuple),
    ),
    das=systems,
    effects=st.lists(
        st.builds(
            EffectSpec, name=names, parameters=st.dictionaries(names, st.floats(-9, 9), max_size=3)
        ),
        max_size=3,
    ).map(tuple),
    truth_seed=st.integers(0, 2**31),
    sensor_seed=st.integers(0, 2**31),
)


@settings(max_examples=60)
@given(cases)
def test_round_trip_is_exact(case):
    """Bit for bit: a case read from a log's header must fly the same flight."""
    assert read_case(write_case(case)) == case


def test_default_keys_are_in_the_fields_units():
    table = tomllib.loads(write_case(Case()))
    assert table["altitude_ft"] == 6000.0
    assert table["wind"] == {"speed_kt": 15.0, "from_direction_deg": 300.0, "up_mps": 0.0}
    assert table["das"]["air_rate_hz"] == 50.0
    assert (table["fuel"], table["ballast_kg"]) == (1.0, 0.0)


def test_any_suffix_of_the_dimension_is_read(tmp_path):
    case = read_case(
        "altitude_m = 1000\nballast_lb = 100\ntemperature_offset_degc = 10\n"
        "[wind]\nspeed_fps = 10\nfrom_direction_rad = 1.5\n[das]\ntemperature_noise_degr = 0.9\n"
        "[pressure_error]\nmodel = 'table'\nairspeed_mps = [50, 60]\nvalues = [0.1, 0.2]\n"
    )
    assert case.altitude == 1000.0
    assert case.ballast == pytest.approx(45.359, abs=1e-3)
    assert (
        case.temperature_offset == 10.0
    )  # 10 °C warmer than standard is 10 K warmer, not 283.15 K warmer
    assert case.wind == Wind(speed=10.0 * FOOT, from_direction=1.5)
    assert case.das.temperature_noise == pytest.approx(0.5)
    assert case.pressure_error.airspeed == (50.0, 60.0)
    # The empty file is the default case, and one that is not there is named.
    (tmp_path / "case.toml").write_text("")
    assert read_case(tmp_path / "case.toml") == Case()
    with pytest.raises(BadInputError, match=r"nowhere\.toml"):
        read_case(tmp_path / "nowhere.toml")


BAD = {
    "aircrft = 'navajo'": r"aircrft: unknown key 'aircrft'\. Did you mean 'aircraft'",
    "altitude = 6000": r"altitude: the unit is missing: write altitude_ft",
    "altitude_kt = 6000": r"altitude_kt: unknown unit of altitude 'kt'\..*Known: m, ft",
    "altitude_parsec = 1": r"unknown unit of altitude 'parsec'",
    "altitude_ft = 6000\naltitude_m = "
    "1800": r"altitude_ft and altitude_m: one quantity, given twice",
    "altitude_ft = 'high'": r"altitude_ft: input should be a valid number, not 'high'",
    "das = '20/1'": (
        r"1 problem\n  das: give a table of fields, \{ air_rate_hz = …, gps_rate_hz = … \}, not "
        r"'20/1'"
    ),
    "effects = ['pod']": (
        r"1 problem\n  effects.0: give a table of fields, \{ name = …, parameters = … \}, not 'pod'"
    ),
    "altitude_ft = true": r"altitude_ft: input should be a valid number",
    "altitude_ft = nan": r"altitude_ft: must be a finite number",
    "[wind]\nspeed_kt = -5": r"wind\.speed_kt: must not be negative",
    "[wind]\nspeed = 5": r"wind\.speed: the unit is missing: write speed_kt",
    "wind = 15": r"wind: .*not 15",
    "turbulence = 'lite'": r"turbulence: unknown turbulence 'lite'\. Did you mean 'light'\?",
    "pilot = 'god'": r"pilot: unknown pilot 'god'\..*Known: none, good, busy",
    "truth_seed = 1.5": r"truth_seed: input should be a valid integer",
    "truth_seed = -1": r"truth_seed: must not be negative",
    "[das]\nair_rate_hz = 0": r"das\.air_rate_hz: must be above 0",
    "[das]\nair_rate_hz = 200": r"das\.air_rate_hz: must not exceed the simulator's 100 Hz",
    "[das]\nair_rate_hz = 10\ngps_rate_hz = "
    "20": r"GPS rate \(20 Hz\) must not exceed the air-data rate \(10 Hz\)",
    "integration_rate_hz = "
    "20": r"integration_rate_hz: .* at 40, 50, 60, 70, 80, 90, 100 Hz, not at 20 Hz",
    "integration_rate_hz = 60": (
        r"60 Hz is not a whole multiple of the 50 Hz of the air data: integrate the flight at 50 "
        r"or 100 Hz"
    ),
    "integration_rate = 50": r"integration_rate: the unit is missing: write integration_rate_hz",
    "[das]\nvane_noise_rad = -1": r"das\.vane_noise_rad: must not be negative",
    "[[effects]]\nparameters = {}": r"effects\.0\.name: field required",
    "[[effects]]\nname = 'lag'\nparameters = { lag_s = 'x' "
    "}": r"effects\.0\.parameters\.lag_s: .*valid number",
    "effects = 'lag'": r"effects: .*valid (tuple|array)",
    "card = { start = 2020-01-01 }": r"neither number, text",
    "altitude_ft = = 3": r"not valid TOML",
    "pilot = 'god'\naltitude = 3\ntruth_seed = 'x'\n[das]\nair_rate_hz = -1\n": (
        r"(?s)4 problems(?=.*pilot)(?=.*altitude)(?=.*truth_seed)(?=.*das\.air_rate_hz)"
    ),
    **{
        line: line.split(" ")[0]
        for line in ("fuel = 0.0", "fuel = 1.1", "fuel = -0.5", "ballast_kg = 1200", "ballast = 10")
    },
}


@pytest.mark.parametrize("text", list(BAD))
def test_each_problem_is_named(text):
    with pytest.raises(BadInputError, match=BAD[text]):
        read_case(text)


def test_truth_can_be_left_out():
    table = case_table(Case(), omit=("pressure_error", "wind", "effects"))
    assert not {"pressure_error", "wind", "effects"} & set(table)
    assert table["das"]["gps_rate_hz"] == 50.0


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
    assert not rate_problem(USUAL_RATE, air_rate)


def test_a_tick_of_the_card_is_a_whole_number_of_steps_and_the_message_says_what_would_do():
    assert all((0.1 * rate) == pytest.approx(round(0.1 * rate)) for rate in possible_rates())
    assert rate_problem(50.0, 20.0) == (
        "50 Hz is not a whole multiple of the 20 Hz of the air data: "
        "integrate the flight at 40 or 60 or 80 or 100 Hz"
    )
    assert "not at 30 Hz" in str(rate_problem(30.0))


def test_a_number_in_a_list_of_tables_obeys_the_rules_as_any_other():
    tree = {"effects": [{"name": "pitot_lag", "parameters": {"lag_s": float("inf")}}]}
    (told,) = broken_rules(tree, ".".join)
    assert told == "effects.0.parameters.lag_s: must be a finite number, not inf"
