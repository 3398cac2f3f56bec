"""Foreign logs by a mapping: one file or several on one time base, shipped or the user's own."""

import re
from pathlib import Path

import numpy as np
import pytest
from tests.logbook import sample_log as sample
from tests.shared_data import real_log

from pitotbench import BadInputError, UnknownNameError, air, read_log
from pitotbench.logbook.columns import QUANTITIES, Table, parse_column
from pitotbench.logbook.joining import join_tables
from pitotbench.logbook.mapping import find_mapping, shipped
from pitotbench.units import FOOT, KNOT, PSI

OWN = """
[columns]
clock = "time_s"
qc_mbar = "impact_pressure_hpa"
ps = { name = "static_pressure_pa", factor = 1000.0, offset = 200.0 }
vn = "velocity_north_kt"
ve = "velocity_east_kt"
"""
SEVERAL = """
[[files]]
file = "*air.csv"
[files.columns]
us = { name = "time_s", factor = 1e-6 }
q = "impact_pressure_pa"
p = "static_pressure_pa"
[[files]]
file = "*gps.csv"
join = "JOIN"
[files.columns]
us = { name = "time_s", factor = 1e-6 }
n = "velocity_north_mps"
e = "velocity_east_mps"
"""


@pytest.mark.parametrize("name", list(shipped()))
def test_shipped_mappings_name_real_columns(name):
    mapping = find_mapping(name)
    if mapping.refuse:  # what such a log lacks, and what to do
        assert re.search("holds no (ground speed|airspeed)", mapping.refuse)
        return
    targets = [target.name for file in mapping.files for target in file.columns]
    found = {name if name in QUANTITIES else parse_column(name)[0].name for name in targets}
    assert found & {"time", "clock_time"}
    assert found & {
        "static_pressure",
        "pressure_altitude",
        "indicated_altitude",
        "height_above_takeoff",
    }
    assert {"velocity_north", "velocity_east"} <= found or found & {"ground_speed", "latitude"}
    assert found & {
        "impact_pressure",
        "total_pressure",
        "indicated_airspeed",
        "calibrated_airspeed",
        "true_airspeed",
    }


def test_an_own_mapping(tmp_path):
    (tmp_path / "m.toml").write_text(OWN)
    t = sample.columns()
    table = {
        "clock": t["time_s"],
        "qc_mbar": t["impact_pressure_pa"] / 100.0,
        "ps": (t["static_pressure_pa"] - 200.0) / 1000.0,
        "vn": t["velocity_north_mps"] / KNOT,
        "ve": t["velocity_east_mps"] / KNOT,
        "altitude_furlong": t["altitude_m"],  # not mapped, so its name does not matter
    }
    log = read_log(sample.write(tmp_path / "log.csv", table), mapping=tmp_path / "m.toml")
    for name in ("impact_pressure_pa", "static_pressure_pa", "velocity_east_mps"):
        np.testing.assert_allclose(getattr(log, name.rpartition("_")[0]), t[name])
    assert "warnings" not in log.header


def several(folder: Path, join: str) -> Path:
    """Air data at 10 Hz, GPS at 2 Hz, 50 ms later and for a shorter time."""
    (folder / "m.toml").write_text(SEVERAL.replace("JOIN", join))
    t = sample.columns()
    air_data = {"us": t["time_s"] * 1e6, "q": t["impact_pressure_pa"], "p": t["static_pressure_pa"]}
    fixes = np.arange(2, 500, 5)
    gps = {
        "us": (t["time_s"][fixes] + 0.05) * 1e6,
        "n": t["velocity_north_mps"][fixes],
        "e": t["velocity_east_mps"][fixes],
    }
    sample.write(folder / "07_gps.csv", gps)
    return sample.write(folder / "07_air.csv", air_data)


@pytest.mark.parametrize("join", ["last", "nearest", "linear"])
def test_several_files(tmp_path, join):
    path = several(tmp_path, join)
    log = read_log(path, mapping=tmp_path / "m.toml")
    assert (log.time[0], log.time[-1]) == pytest.approx(
        (0.3, 49.7)
    )  # where both files have something to say
    clock = 0.25 + 0.5 * np.arange(100)
    north = sample.columns()["velocity_north_mps"][2:500:5]
    distance = log.time[:, None] - clock[None, :]
    pick = {
        "last": np.argmin(np.where(distance < -1e-9, np.inf, distance), axis=1),
        "nearest": np.argmin(np.abs(distance), axis=1),
    }
    if join in pick:
        expected = north[pick[join]]
    else:  # each fix once, at the row next to it, and held to the next one
        fresh = np.flatnonzero(log.gps_fresh)
        assert len(fresh) == len(clock)
        assert np.all(np.abs(distance[fresh]).min(axis=1) < 0.05 + 1e-6)
        held = fresh[np.searchsorted(fresh, np.arange(len(log.time)), side="right") - 1]
        expected = np.interp(log.time[held], clock, north)
    ties = np.abs(np.abs(distance).min(axis=1) - 0.25) < 1e-6
    np.testing.assert_allclose(log.velocity_north[~ties], expected[~ties], rtol=1e-9)


@pytest.mark.parametrize(
    ("join", "expected"), [("last", [1, 2, 2]), ("nearest", [1, 2, 3]), ("linear", [1, 2, 2.75])]
)
def test_joins(join, expected):
    """A sample of the same instant counts as the last one."""
    base = Table(("time_s",), (np.array([0.0, 1.0, 1.75]),))
    other = Table(("time_s", "altitude_m"), (np.array([0.0, 1.0, 2.0]), np.array([1.0, 2.0, 3.0])))
    np.testing.assert_allclose(join_tables(base, [(other, join)]).column("altitude_m"), expected)
    with pytest.raises(BadInputError, match="do not overlap in time"):
        join_tables(base, [(Table(("time_s",), (np.array([10.0, 11.0]),)), join)])


def test_fixes_at_the_rate_of_the_air_data_or_faster_are_all_fresh():
    """A receiver that is not slower gives each row a fix of its own, interpolated to it."""
    base = Table(("time_s",), (np.array([0.0, 1.0, 2.0]),))
    clock = np.arange(0.0, 2.4, 0.4)
    fixes = Table(("time_s", "velocity_north_mps"), (clock, 10.0 * clock))
    joined = join_tables(base, [(fixes, "linear")])
    np.testing.assert_allclose(joined.column("velocity_north_mps"), [0.0, 10.0, 20.0])
    assert joined.column("gps_fresh").all()


def test_the_folder_serves_for_the_file_where_it_holds_each_once(tmp_path):
    path = several(tmp_path, "last")
    mapping = tmp_path / "m.toml"
    by_file, by_folder = (read_log(p, mapping=mapping) for p in (path, tmp_path))
    np.testing.assert_array_equal(by_file.velocity_north, by_folder.velocity_north)
    with pytest.raises(
        BadInputError, match=r"expects the folder of the log or its file '\*air.csv'"
    ):
        read_log(tmp_path / "07_gps.csv", mapping=mapping)
    (tmp_path / "08_air.csv").write_bytes(path.read_bytes())
    with pytest.raises(BadInputError, match=r"several files .*07_air.csv, 08_air.csv"):
        read_log(tmp_path, mapping=mapping)
    with pytest.raises(BadInputError, match=r"needs '08_gps.csv' in the folder"):
        read_log(tmp_path / "08_air.csv", mapping=mapping)


def test_a_mapping_that_is_not_there(tmp_path):
    with pytest.raises(UnknownNameError, match=r"unknown mapping 'jmos'\. Did you mean 'jmoss'"):
        read_log(tmp_path / "log.csv", mapping="jmos")
    with pytest.raises(BadInputError, match=r"none\.toml: cannot be read"):
        read_log(tmp_path / "log.csv", mapping=tmp_path / "none.toml")


BAD_MAPPINGS = {
    "[columns": r"not valid TOML",
    "": r"either \[columns\] or \[\[files\]\]",
    "[columns]\nx = 3": r"columns\.x",
    "[columns]\nx = 'time_s'\n[[files]]\ncolumns = { y = 'time_s' }": r"either",
    "[[files]]\njoin = 'mean'\ncolumns = { y = 'time_s' "
    "}": r"unknown join 'mean'. Known: last, nearest, linear",
    "titel = 'x'\n[columns]\nx = 'time_s'": r"titel",
    "[columns]\ntime_s = 'clock_s'": r"names 'clock_s', which is no column",
    "[columns]\ntime_s = 'time_kt'": r"'kt' is a unit of speed, but time is of time",
    "[columns]\nt = 'time_s'": r"column 't' is missing",
}


@pytest.mark.parametrize("text", list(BAD_MAPPINGS))
def test_bad_mappings(tmp_path, text):
    (tmp_path / "m.toml").write_text(text)
    path = sample.write(tmp_path / "log.csv", sample.columns())
    with pytest.raises(BadInputError, match=BAD_MAPPINGS[text]):
        read_log(path, mapping=tmp_path / "m.toml")


@pytest.mark.parametrize(("name", "rows"), [("CLASS55.csv", 8885), ("CLASS65.csv", 8178)])
def test_jmoss_logs(name, rows):
    """A jet at Mach 0.52 to 1.05, 20 Hz, velocity renewed at 5 Hz; against the raw file by another
    reader.
    """
    path = real_log("jmoss", name)
    log = read_log(path, mapping="jmoss")
    raw = np.genfromtxt(path, delimiter=",", names=True)
    assert len(log) == rows == len(raw)
    np.testing.assert_allclose(
        log.impact_pressure, (raw["total_pres_psi"] - raw["static_pres_psi"]) * PSI
    )
    np.testing.assert_allclose(log.velocity_north, raw["north_vel_fps"] * FOOT)
    np.testing.assert_allclose(log.altitude, raw["height_ft"] * FOOT)
    mach = air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)
    assert 0.4 < mach.min() < 0.6
    assert 0.9 < mach.max() < 1.1
    assert "warnings" not in log.header


@pytest.mark.parametrize("parts", [("seaway",), ("seaway", "differential_pressure_0.csv")])
def test_seaway_log(parts):
    """A solar airplane: 1 Hz, differential pressure with its zero near 100 Pa, which the reader
    reports.
    """
    log = read_log(real_log(*parts), mapping="seaway")
    assert 950 < len(log) <= 974
    assert 90.0 < np.median(log.impact_pressure[:100]) < 125.0
    assert 95e3 < np.median(log.static_pressure) < 103e3
    assert np.hypot(log.velocity_north, log.velocity_east).max() > 8.0
    assert np.median(np.diff(log.time)) == pytest.approx(1.0, abs=0.1)
    assert any("zero offset" in warning for warning in log.header["warnings"])
