"""Every way in which a log can be bad: one clear error, or a warning that names the rows and a log of the rest."""

import re
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import savemat
from tests.logbook import sample_log as sample

from pitotbench.logbook.formats import FORMATS
from pitotbench.logbook.reading import read_log
from pitotbench.logbook.writing import write_log
from pitotbench.records import BadInputError

Table = dict[str, NDArray]
TIME = np.arange(sample.ROWS) / sample.RATE


def put(name: str, rows: slice | int, value: float) -> Callable[[Table], Table]:
    """Spoil some rows of a column."""

    def spoil(table: Table) -> Table:
        values = table[name].astype(object if isinstance(value, str) else float)
        values[rows] = value
        return {**table, name: values}

    return spoil


def scale(name: str, factor: float) -> Callable[[Table], Table]:
    return lambda table: {**table, name: table[name] * factor}


def drop(*names: str) -> Callable[[Table], Table]:
    return lambda table: {k: v for k, v in table.items() if k not in names}


def rename(old: str, new: str) -> Callable[[Table], Table]:
    return lambda table: {new if k == old else k: v for k, v in table.items()}


def add(name: str, like: str) -> Callable[[Table], Table]:
    return lambda table: {**table, name: table[like]}


ERRORS: dict[str, tuple[Callable[[Table], Table], str]] = {
    "no time": (drop("time_s"), r"missing column time_s"),
    "time runs back": (
        put("time_s", 300, 2.0),
        r"'time_s', row 301: time runs back from 29.9 to 2 s.*sort the rows",
    ),
    "time repeats often": (lambda t: {**t, "time_s": np.floor(TIME)}, r"time stamps repeat.*more digits"),
    "NaN in most rows": (
        put("impact_pressure_pa", slice(100, 450), np.nan),
        r"350 of 600 values are not numbers \(rows 101–450\): too few rows remain",
    ),
    "time NaN often": (put("time_s", slice(0, 50), np.nan), r"'time_s': 50 of 600"),
    "text in a number": (
        put("static_pressure_pa", 41, "err"),
        r"'static_pressure_pa', row 42: 'err' is not a number",
    ),
    "no flag": (put("on_condition", 6, "perhaps"), r"'on_condition', row 7: 'perhaps' is not true or false"),
    "no static pressure": (drop("static_pressure_pa"), r"missing column static_pressure_pa"),
    "much missing": (
        drop("velocity_north_mps", "velocity_east_mps", "impact_pressure_pa"),
        r"missing columns velocity_north_mps or ground_speed_kt with track_deg, velocity_east_mps, impact_.*"
        r"--mapping",
    ),
    "misspelled": (
        rename("impact_pressure_pa", "impact_presure_pa"),
        r"Is 'impact_presure_pa' meant for impact_pressure_pa",
    ),
    "unknown suffix": (rename("altitude_m", "altitude_furlong"), r"unknown unit suffix 'furlong'.*altitude_m"),
    "wrong dimension": (rename("altitude_m", "altitude_kt"), r"'kt' is a unit of speed, but altitude is of length"),
    "two units of one": (
        add("altitude_ft", "altitude_m"),
        r"'altitude_m' and 'altitude_ft' give one quantity in two",
    ),
    "column twice": (add("altitude_m ", "altitude_m"), r"'altitude_m' is given twice"),
    "inches said to be pascal": (
        scale("static_pressure_pa", 1 / 3386.389),
        r"typical values of 23\.98 pa are not those of an airplane; they would fit .*static_pressure_inhg",
    ),
    "Celsius said to be kelvin": (
        lambda t: {**t, "total_temperature_k": t["total_temperature_k"] - 273.15},
        r"typical values of 5\.\d+ k.*total_temperature_degc",
    ),
    "knots of feet": (scale("velocity_north_mps", 100.0), r"velocity_north_mps.*not those of an airplane"),
    "millibar said to be pascal": (
        scale("impact_pressure_pa", 0.01),
        r"air data say about 7 m/s.*name the column impact_pressure_hpa",
    ),
    "feet per second said to be meters": (
        lambda t: {**t, **{f"velocity_{k}_mps": t[f"velocity_{k}_mps"] * 3.28084 for k in ("north", "east")}},
        r"the air data say about.*name the columns velocity_north_fps and velocity_east_fps",
    ),
    "knots said to be m/s": (
        lambda t: {**t, **{f"velocity_{k}_mps": t[f"velocity_{k}_mps"] * 1.944 for k in ("north", "east")}},
        r"look like knots: name the columns velocity_north_kt and velocity_east_kt",
    ),
    "Fahrenheit said to be kelvin": (
        lambda t: {**t, "total_temperature_k": t["total_temperature_k"] * 1.8 - 459.67},
        r"they would fit total_temperature_degf",
    ),
    "negative impact pressure": (scale("impact_pressure_pa", -1.0), r"negative in 600 of 600 rows.*swap them"),
    "stuck pitot": (scale("impact_pressure_pa", 0.0), r"stuck at 0 Pa in every row"),
    "mostly stuck pitot": (put("impact_pressure_pa", slice(100, 580), 2500.0), r"rows 101–580.*80% of the log"),
    "stuck GPS": (
        lambda t: put("velocity_east_mps", slice(None), 1.0)(put("velocity_north_mps", slice(None), 60.0)(t)),
        r"GPS velocity is the same in every row",
    ),
    "nothing remains": (
        lambda t: put("impact_pressure_pa", 1, np.nan)(
            put("static_pressure_pa", 0, np.nan)({k: v[:3] for k, v in t.items()})
        ),
        r"1 of 2 values are not numbers .*no log remains",
    ),
    "one row": (lambda t: {k: v[:1] for k, v in t.items()}, r"at least 2 are needed"),
    "no rows": (lambda t: {k: v[:0] for k, v in t.items()}, r"no rows"),
}


@pytest.mark.parametrize("name", list(ERRORS))
def test_error(tmp_path, name):
    spoil, message = ERRORS[name]
    path = sample.write(tmp_path / "flight7.csv", spoil(sample.columns()))
    with pytest.raises(BadInputError, match=message) as caught:
        read_log(path)
    assert "flight7.csv: " in str(caught.value)


def hold(table: Table) -> Table:
    return put("velocity_east_mps", slice(200, 400), 20.0)(put("velocity_north_mps", slice(200, 400), 60.0)(table))


WARNINGS: dict[str, tuple[Callable[[Table], Table], str, int]] = {
    "some NaN": (put("static_pressure_pa", slice(9, 12), np.nan), r"'static_pressure_pa'.*\(rows 10–12\)", 597),
    "NaN in two places": (put("time_s", np.array([4, 7]), np.nan), r"'time_s'.*\(rows 5, 8\)", 598),
    "NaN for a while": (
        put("impact_pressure_pa", slice(100, 150), np.nan),
        r"50 of 600 values are not numbers \(rows 101–150\), 8% of the log, 5 s: those rows are dropped",
        550,
    ),
    "infinite for a while": (put("static_pressure_pa", slice(0, 50), np.inf), r"not numbers \(rows 1–50\)", 550),
    "GPS lost for a while": (
        lambda t: put("velocity_east_mps", slice(200, 350), np.nan)(
            put("velocity_north_mps", slice(200, 350), np.nan)(t)
        ),
        r"150 of 600 values are not numbers \(rows 201–350\), 25% of the log, 15 s",
        450,
    ),
    "empty cell": (put("total_temperature_k", 8, ""), r"'total_temperature_k'.*\(row 9\)", 599),
    "a spike": (
        put("static_pressure_pa", np.array([30, 31]), -81200.0),
        r"impossible values in 2 rows \(rows 31–32\)",
        598,
    ),
    "a GPS spike": (put("velocity_east_mps", 77, 1e6), r"'velocity_east_mps': impossible .*\(row 78\)", 599),
    "a time repeats": (put("time_s", 50, 4.9), r"time stamps repeat \(row 51\)", 599),
    "some negative": (put("impact_pressure_pa", slice(20, 30), -1.0), r"negative in 10 rows \(rows 21–30\)", 590),
    "stuck pitot": (put("impact_pressure_pa", slice(100, 220), 2500.0), r"seems stuck \(rows 101–220\)", 480),
    "stuck GPS": (hold, r"'velocity_north_mps'.*seems stuck \(rows 201–400\)", 400),
    "stuck static": (put("static_pressure_pa", slice(100, 220), 81200.0), r"'static_pressure_pa'.*stuck", 480),
    "static never moves": (put("static_pressure_pa", slice(None), 81200.0), r"never changes", 600),
    "vane not installed": (
        put("angle_of_attack_rad", slice(None), np.nan),
        r"'angle_of_attack_rad' is left out",
        600,
    ),
    "degrees said to be radians": (scale("angle_of_attack_rad", 57.3), r"left out.*angle_of_attack_deg", 600),
    "g said to be m/s²": (scale("specific_force_z_mps2", 1 / 9.8), r"left out.*specific_force_z_g", 600),
    "rpm said to be rad/s": (scale("propeller_speed_left_radps", 9.55), r"left out.*propeller_speed_left_rpm", 600),
    "percent": (scale("throttle_left", 100.0), r"'throttle_left' is left out.*from 0 to 1", 600),
}


@pytest.mark.parametrize("name", list(WARNINGS))
def test_warning(tmp_path, name):
    spoil, message, rows = WARNINGS[name]
    log = read_log(sample.write(tmp_path / "log.csv", spoil(sample.columns())))
    matching = [w for w in log.header["warnings"] if re.search(message, w)]
    assert matching, log.header["warnings"]
    assert len(log) == rows


def test_a_sound_log_has_no_warning(tmp_path):
    assert "warnings" not in read_log(sample.write(tmp_path / "log.csv", sample.columns())).header


def test_constant_speed_without_noise_is_not_a_stuck_sensor(tmp_path):
    """A computed log may repeat all values at once; a stuck sensor repeats while others move."""
    table = sample.columns()
    for name in ("impact_pressure_pa", "static_pressure_pa", "velocity_north_mps", "velocity_east_mps"):
        table[name][100:300] = table[name][100]
    assert len(read_log(sample.write(tmp_path / "log.csv", table))) == sample.ROWS


def test_a_coarse_display_in_calm_air_is_not_a_stuck_sensor(tmp_path):
    """Steps of 20 Pa with noise of 3 Pa: on a steady leg of 25 s the number does not change."""
    table = sample.columns()
    steady = np.interp(TIME, [0.0, 20.0, 45.0, 60.0], [2900.0, 2500.0, 2500.0, 2100.0])
    noise = 3.0 * np.random.default_rng(1).standard_normal(sample.ROWS)
    table["impact_pressure_pa"] = 20.0 * np.round((steady + noise) / 20.0)
    log = read_log(sample.write(tmp_path / "log.csv", table))
    assert len(log) == sample.ROWS
    assert not any("stuck" in warning for warning in log.header.get("warnings", ()))


def test_a_parked_airplane_is_not_a_stuck_gps(tmp_path):
    table = sample.columns()
    for name in ("velocity_north_mps", "velocity_east_mps"):
        table[name][:200] = 0.0
    assert len(read_log(sample.write(tmp_path / "log.csv", table))) == sample.ROWS


def test_gps_blank_between_fixes_is_held(tmp_path):
    table = sample.columns()
    stale = np.arange(sample.ROWS) % 10 != 3
    for name in ("velocity_north_mps", "velocity_east_mps", "velocity_down_mps", "altitude_m"):
        table[name] = np.where(stale, np.nan, table[name])
    log = read_log(sample.write(tmp_path / "log.csv", table))
    assert len(log) == sample.ROWS - 3
    np.testing.assert_array_equal(log.gps_fresh, ~stale[3:])
    assert log.velocity_north[9] == log.velocity_north[0] != log.velocity_north[10]
    assert len(log.header["warnings"]) == 1
    assert "blank between fixes (one in 10 rows)" in log.header["warnings"][0]


def test_warnings_go_with_the_log(tmp_path):
    spoil, _, _ = WARNINGS["some NaN"]
    log = read_log(sample.write(tmp_path / "log.csv", spoil(sample.columns())))
    again = read_log(write_log(log, tmp_path / "again.parquet"))
    assert again.header["warnings"] == log.header["warnings"]


@pytest.mark.parametrize("suffix", list(FORMATS))
@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_truncated_files(tmp_path, suffix, share):
    """Cut anywhere: an error, or in CSV a log of the whole rows with a warning; never silence or a traceback."""
    whole = write_log(sample.log(), tmp_path / f"whole{suffix}").read_bytes()
    cut = tmp_path / f"cut{suffix}"
    cut.write_bytes(whole[: int(share * len(whole))])
    if suffix == ".csv" and share > 0.0:
        log = read_log(cut)
        assert 0 < len(log) < sample.ROWS
        assert any("its end is missing" in w for w in log.header["warnings"])
    else:
        with pytest.raises(BadInputError, match=rf"cut{suffix}: .*(empty|not a complete)"):
            read_log(cut)


def test_a_foreign_csv_that_breaks_off(tmp_path):
    path = sample.write(tmp_path / "log.csv", sample.columns())
    path.write_bytes(path.read_bytes()[:-40])
    log = read_log(path)
    assert len(log) == sample.ROWS - 1
    assert any(f"row {sample.ROWS} breaks off after" in w for w in log.header["warnings"])


def test_a_ragged_row(tmp_path):
    path = sample.write(tmp_path / "log.csv", sample.columns())
    lines = path.read_text().splitlines()
    lines[51] = "1,2,3"
    path.write_text("\n".join(lines))
    with pytest.raises(BadInputError, match="row 51 has 3 columns, the first line names 14"):
        read_log(path)


@pytest.mark.parametrize("content", [b"", b"\n\n", b"# only = 'a header'\n", b"\x00\x01\x02\xff" * 50])
@pytest.mark.parametrize("suffix", list(FORMATS))
def test_no_log_at_all(tmp_path, suffix, content):
    path = tmp_path / f"log{suffix}"
    path.write_bytes(content)
    with pytest.raises(BadInputError, match=r"log\.(csv|parquet|mat): "):
        read_log(path)


def test_paths_that_are_no_log(tmp_path):
    for path, words in (
        (tmp_path / "none.csv", "cannot be read"),
        (tmp_path, "a folder"),
        (tmp_path / "x.doc", "ends in"),
    ):
        with pytest.raises(BadInputError, match=words):
            read_log(path)


@pytest.mark.parametrize(("name", "kind"), [("flight.ulg", "ULog"), ("flight.BIN", "DataFlash log")])
def test_broken_flight_controller_logs(tmp_path, name, kind):
    (tmp_path / name).write_bytes(b"ULog")
    with pytest.raises(BadInputError, match=rf"{kind}|needs py"):
        read_log(tmp_path / name)


def test_mat_struct_and_unequal_lengths(tmp_path):
    table = {k: v for k, v in sample.columns().items() if k != "segment"}
    savemat(tmp_path / "log.mat", {"flight": table})
    np.testing.assert_array_equal(read_log(tmp_path / "log.mat").time, TIME)
    savemat(tmp_path / "log.mat", {**table, "time_s": TIME[:5]})
    with pytest.raises(BadInputError, match=r"differ in length .*time_s 5"):
        read_log(tmp_path / "log.mat")
