"""Mappings drafted for headers that the reader has never seen: the log reads right without help, or
it is asked.
"""

import numpy as np
import pytest
from tests.logbook import foreign_files as foreign
from tests.logbook import foreign_headers as headers
from tests.logbook import quoted_headers as quoted
from tests.logbook.test_foreign_files import assert_same_flight

from pitotbench import air, read_log
from pitotbench.cli.app import main
from pitotbench.logbook.column_guesses import guesses
from pitotbench.logbook.columns import QUANTITIES, Table, numbered
from pitotbench.logbook.drafting import draft_mapping, mapping_text
from pitotbench.logbook.reading import read_table

FLOWN = foreign.flight()


@pytest.mark.parametrize("name", list(headers.headers(FLOWN)))
def test_a_foreign_header_is_drafted_right(tmp_path, name):
    """As it stands, also where a question is asked: airspeed, height, temperature and velocity are
    the flight's.
    """
    path, mapping = headers.write_header(tmp_path / "log.csv", name, FLOWN), tmp_path / "m.toml"
    mapping.write_text(mapping_text(draft_mapping(read_table(path)), path.name), encoding="utf-8")
    log = read_log(path, mapping)
    assert_same_flight(log, 0.01, 0.1, 0.02)  # a wrong column or unit is off by far more
    if log.total_temperature is not None:
        mach = air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)
        found = air.air_temperature(log.total_temperature, mach)
        np.testing.assert_allclose(found, FLOWN["air_temperature"], atol=0.01)


def test_a_last_word_that_looks_like_a_unit_may_be_none():
    """The unit of TAT_DI_R would be °R, in which no air has 280."""
    flown = {
        "TAT_DI_R": FLOWN["air_temperature"] + 2.0,
        "TAT_DEGR": 1.8 * (FLOWN["air_temperature"] + 2.0),
    }
    found = {
        name: [(g.quantity, g.units) for g in guesses(name, "", values)][:1]
        for name, values in flown.items()
    }
    assert found == {
        "TAT_DI_R": [("total_temperature", ("k",))],
        "TAT_DEGR": [("total_temperature", ("degr",))],
    }


def as_table(**columns):
    return Table(tuple(columns), tuple(np.asarray(values) for values in columns.values()))


def test_what_is_missing_is_said():
    drafted = draft_mapping(as_table(time=FLOWN["time"], ias=np.full(foreign.ROWS, 120.0)))
    assert drafted.missing[0].startswith("static_pressure or pressure_altitude")
    assert not drafted.sure
    assert "# No column was found for velocity_north or ground_speed" in mapping_text(
        drafted, "log.csv"
    )


KNOWN = {
    "time": FLOWN["time"],
    "qc_pa": FLOWN["impact_pressure"],
    "ps_pa": FLOWN["static_pressure"],
    "vn_mps": FLOWN["velocity_north"],
    "ve_mps": FLOWN["velocity_east"],
}


def questions_about(**columns):
    return {
        line.guess.theirs: line.question
        for line in draft_mapping(as_table(**KNOWN, **columns)).lines
    }


def test_an_ambiguous_unit_and_two_columns_for_one_quantity_are_asked_for():
    """A temperature of 8 to 10 may be in °C or in °F, and nothing else in the log tells."""
    questions = questions_about(oat=FLOWN["air_temperature"] - 273.15 + 6.0)
    assert questions["oat"] == "the file states no unit: is it degc, or degf?"
    assert not questions["qc_pa"]
    heights = {"alt_m": FLOWN["altitude"], "gps_alt_m": FLOWN["altitude"] + 40.0}
    questions = questions_about(hdg=FLOWN["heading"] * 57.3, **heights)
    assert any("or is it" in question for question in questions.values())


def test_a_name_cannot_leave_its_line(tmp_path):
    odd = 'velo"city\nnorth = 3'
    table = as_table(
        **{"time": FLOWN["time"], odd: FLOWN["velocity_north"], "x\n[calibrate]\ny": FLOWN["time"]}
    )
    from pitotbench.logbook.mapping import parse_mapping

    assert parse_mapping("m", mapping_text(draft_mapping(table), "a\nb.csv")).calibrate == {}


def test_the_command_writes_a_mapping_that_calibrate_offers(tmp_path, capsys):
    log, mapping = headers.write_header(tmp_path / "log.csv", "card", FLOWN), tmp_path / "m.toml"
    lacking = quoted.write_quoted(tmp_path / "other.csv", quoted.QUOTED["no direction"])
    assert main(["calibrate", str(lacking)]) == 2
    assert f"pitotbench map {lacking} -o mapping.toml" in capsys.readouterr().err
    assert main(["map", str(log), "-o", str(mapping)]) == 0
    assert "6 columns recognized" in capsys.readouterr().out
    assert len(read_log(log, mapping)) == foreign.ROWS
    for refused in (tmp_path / "m.txt", log):
        assert main(["map", str(log), "-o", str(refused)]) == 2
    # What cannot work is not offered for use.
    log = quoted.write_quoted(tmp_path / "log.csv", quoted.QUOTED["no direction"])
    capsys.readouterr()
    assert main(["map", str(log), "-o", str(mapping)]) == 0
    said = capsys.readouterr().out
    assert "use it" not in said
    assert f"complete it first, then: pitotbench calibrate {log}" in said
    # A known log needs no mapping.
    assert main(["map", str(foreign.dynon(tmp_path / "log.csv", FLOWN))]) == 0
    assert "dynon" in capsys.readouterr().out


def test_our_own_names_in_capitals_are_drafted_without_a_question():
    columns = foreign.canonical(FLOWN)
    drafted = draft_mapping(as_table(**{name.upper(): values for name, values in columns.items()}))
    assert drafted.sure
    assert not drafted.missing
    ours = {
        line.guess.theirs: f"{line.guess.quantity}_{line.guess.units[0]}" for line in drafted.lines
    }
    assert ours == {name.upper(): name for name in columns}


@pytest.mark.parametrize("name", list(quoted.QUOTED))
def test_a_quoted_header_is_mapped_right_or_asked_about(name, tmp_path):
    """What a header holds is found in its unit, what it lacks is named, and nothing else is taken
    for it.
    """
    header = quoted.QUOTED[name]
    drafted = draft_mapping(read_table(quoted.write_quoted(tmp_path / "log.csv", header)))
    targets = {line.guess.theirs: line.guess.target() for line in drafted.lines}
    found = {theirs: target for theirs, target in targets.items() if numbered(target)[1] == 1}
    # What may be another sensor's is asked about.
    assert all(line.question for line in drafted.lines if line.guess.theirs not in found)
    # Units by guess need the whole log: where it lacks a channel, they are asked for.
    unsure = {
        line.guess.theirs
        for line in drafted.lines
        if "no unit: is it" in line.question and header.asks
    }
    found |= {
        name: header.holds[name]
        for name in unsure
        if same_quantity(found[name], header.holds.get(name))
    }
    meant = {
        k: {"clock": "time_s", "stamp": "time_s"}.get(v, v)
        for k, v in header.holds.items()
        if v[0] != "~"
    }
    meant = {k: v for k, v in meant.items() if v != "minutes"}
    assert {k: found.get(k) for k in meant} == meant
    essential = {
        column for column in found if QUANTITIES[drafted_quantity(drafted, column)].essential
    }
    allowed = {k for k, v in header.holds.items() if v != "minutes"}
    assert essential <= allowed, essential - allowed
    asked = {line.guess.theirs for line in drafted.lines if line.question}
    beside = {
        k: v[1:] for k, v in header.holds.items() if v[0] == "~" and k in found and k not in asked
    }
    assert all(found[k] == v or same_quantity(found[k], v) for k, v in beside.items()), beside
    assert len(drafted.missing) == len(header.asks)
    for said, asked in zip(drafted.missing, header.asks, strict=True):
        assert said.startswith(asked)
    assert drafted.unusable == bool(header.asks), drafted.refusal
    asked = [f"{line.guess.theirs}: {line.question}" for line in drafted.lines if line.question]
    for question in header.questions:
        assert any(said.startswith(question) for said in asked), asked


def same_quantity(one, other):
    return other is not None and one.rpartition("_")[0] == other.rpartition("_")[0]


def drafted_quantity(drafted, column):
    return next(line.guess.quantity for line in drafted.lines if line.guess.theirs == column)


def test_the_barometer_of_a_phone_is_no_setting_of_an_altimeter():
    """A setting is turned by hand; a pressure changes from row to row."""
    pressure = np.linspace(99.0, 89.0, 300)
    drafted = {each.quantity for each in guesses("altimeterPressure(kPa)", "", pressure)}
    assert drafted == {"static_pressure"}
    by_hand = np.repeat([101.3, 101.5], 150)
    turned = {each.quantity for each in guesses("altimeter(kPa)", "", by_hand)}
    assert turned == {"altimeter_setting"}
