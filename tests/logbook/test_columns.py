"""Column names: every quantity in every unit of its dimension, and an answer to each wrong one."""

import numpy as np
import pytest
from tests.logbook import sample_log as sample

from pitotbench import BadInputError, read_log
from pitotbench.logbook.columns import QUANTITIES, parse_column
from pitotbench.units import SUFFIXES, from_si

EVERY_COLUMN = [(q.name, s) for q in QUANTITIES.values() for s in (q.suffixes or [""])]


@pytest.mark.parametrize(("name", "suffix"), EVERY_COLUMN)
def test_every_quantity_in_every_unit_is_recognized(name, suffix):
    column = f"{name}_{suffix}" if suffix else name
    assert parse_column(column) == (QUANTITIES[name], suffix)


@pytest.mark.parametrize(
    "quantity", [q for q in QUANTITIES.values() if q.unit], ids=lambda q: q.name
)
def test_canonical_columns_are_si(quantity):
    unit = SUFFIXES[quantity.unit]
    assert (unit.factor, unit.offset) == (1.0, 0.0)


def test_foreign_units_become_si(read):
    table = sample.columns()
    other = {
        "time_s": "time_ms",
        "impact_pressure_pa": "impact_pressure_psf",
        "static_pressure_pa": "static_pressure_inhg",
        "total_temperature_k": "total_temperature_degc",
        "velocity_north_mps": "velocity_north_kt",
        "velocity_east_mps": "velocity_east_fps",
        "altitude_m": "altitude_ft",
        "specific_force_z_mps2": "specific_force_z_g",
        "angle_of_attack_rad": "angle_of_attack_deg",
        "propeller_speed_left_radps": "propeller_speed_left_rpm",
    }
    written = {
        other.get(name, name): from_si(values, other[name].rpartition("_")[2])
        if name in other
        else values
        for name, values in table.items()
    }
    log = read(written)
    for name in other:
        quantity, _ = parse_column(name)
        np.testing.assert_allclose(
            getattr(log, quantity.name), table[name], rtol=1e-12, atol=1e-9, err_msg=name
        )
    assert "warnings" not in log.header


@pytest.mark.parametrize("name", ["impact_pressure_pa", "total_pressure_pa"])
def test_an_airspeed_does_not_replace_a_pressure(name, read):
    table = sample.columns()
    impact = table.pop("impact_pressure_pa")
    static = table["static_pressure_pa"] if name == "total_pressure_pa" else 0.0
    shown = np.linspace(50.0, 99.0, len(impact))  # m/s, of another instrument
    log = read({**table, name: impact + static, "indicated_airspeed_mps": shown})
    np.testing.assert_allclose(log.impact_pressure, impact, atol=1e-9)
    assert "display" not in log.header


def test_total_pressure_serves_for_impact_pressure_and_the_latter_goes_before(read):
    table = sample.columns()
    impact, total = table.pop("impact_pressure_pa"), table["static_pressure_pa"] + 3000.0
    both = read({**table, "impact_pressure_pa": impact, "total_pressure_pa": total})
    np.testing.assert_array_equal(both.impact_pressure, impact)
    assert any("impact pressure is used" in warning for warning in both.header["warnings"])
    table["total_pressure_hpa"] = (impact + table["static_pressure_pa"]) / 100.0
    np.testing.assert_allclose(read(table).impact_pressure, impact, atol=1e-6)


WRONG_NAMES = {
    "static_pressure_bar": r"unknown unit suffix 'bar'\..*Known: s, ms, min, pa, hpa.*Name it "
    r"static_pressure_pa",
    "static_pressure_kt": r"'kt' is a unit of speed, but static_pressure is of pressure; name it "
    r"static_",
    "static_pressure": r"does not say its unit; name it static_pressure_pa, static_pressure_hpa",
    "roll_rate_deg": r"'deg' is a unit of angle, but roll_rate is of angular rate",
    "throttle_left_pct": r"throttle_left has no unit",
}


@pytest.mark.parametrize("column", list(WRONG_NAMES))
def test_wrong_names_are_answered(column):
    with pytest.raises(BadInputError, match=WRONG_NAMES[column]):
        parse_column(column)


@pytest.mark.parametrize(
    "column", ["oil_temperature_degc", "cabin_altitude_ft", "mass_flow_kgps", "times"]
)
def test_strangers_are_not_ours_and_are_named_in_a_warning(column, read):
    assert parse_column(column) is None
    log = read({**sample.columns(), column: np.full(sample.ROWS, 90.0)})
    assert any(column in warning for warning in log.header["warnings"])


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_other_delimiters(tmp_path, delimiter):
    table = {name: values for name, values in sample.columns().items() if name != "segment"}
    path = sample.write(tmp_path / "log.csv", table)
    path.write_text(path.read_text().replace(",", delimiter))
    assert len(read_log(path)) == sample.ROWS


@pytest.mark.parametrize(
    "above", ["\ufeff", "# made by hand: no TOML = at all\n", "\n\n# note = 'x'\n"]
)
def test_what_may_stand_above_and_spaces_around_names_and_flags_as_numbers(read, above):
    table = {f" {name} ": values for name, values in sample.columns().items()}
    table[" on_condition "] = table[" on_condition "].astype(int)
    np.testing.assert_array_equal(read(table, above).on_condition, sample.log().on_condition)


def test_a_true_airspeed_with_a_total_temperature_has_the_mach_number_of_both(tmp_path):
    """T_t = T (1 + 0.2 M²) and q_c = p ((1 + 0.2 M²)^3.5 − 1): the temperature of the air is not asked."""
    time = np.arange(0.0, 120.0, 0.1)
    # In a circle: straight and evenly faster, time and airspeed are one to the checks of a log.
    mach, static, cold = 0.3 + 0.03 * np.sin(0.2 * time), 70_000.0, 265.0
    total = cold * (1.0 + 0.2 * mach**2)
    speed = mach * np.sqrt(1.4 * 287.05287 * cold)
    north, east = speed * np.cos(0.1 * time), speed * np.sin(0.1 * time)
    rows = np.column_stack([time, speed, np.full_like(time, static), total, north, east])
    names = "time_s,true_airspeed_mps,static_pressure_pa,total_temperature_k,velocity_north_mps,velocity_east_mps"
    path = tmp_path / "flight.csv"
    np.savetxt(path, rows, delimiter=",", header=names, comments="")
    impact = static * ((1.0 + 0.2 * mach**2) ** 3.5 - 1.0)
    assert read_log(path).impact_pressure == pytest.approx(impact, rel=1e-5)
