"""One flight in the files that people have: the same numbers in all, exact or within the steps of the display."""

import re
import struct
from pathlib import Path

import numpy as np
import pytest
from tests.logbook import foreign_files as foreign
from tests.logbook import sample_log as sample

from pitotbench import air
from pitotbench.logbook.columns import Table
from pitotbench.logbook.reading import log_of, needs_mapping, read_log
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, FOOT, KNOT

FLOWN = foreign.flight()
CLOCK_TEXTS = {f"clock {name}": foreign.clocked(write) for name, write in foreign.CLOCKS.items()}
# Largest errors that the digits of the file leave: impact pressure as airspeed [kt], height [ft], velocity [kt].
CSV = {
    "kias": (foreign.kias, 0.5, 5.0, 1.2),  # half a degree of track is 0.9 kt at 100 kt
    "garmin g1000": (foreign.g1000, 0.005, 0.1, 0.13),  # a twentieth of a degree of track is 0.12 kt at 135 kt
    "garmin g3x": (foreign.g3x, 0.05, 0.5, 0.02),
    "garmin gi 275": (foreign.gi275, 0.05, 0.5, 1.2),
    "dynon": (foreign.dynon, 0.05, 0.5, 0.2),
    "jsbsim": (foreign.jsbsim, 1e-6, 1e-6, 1e-9),
    "utf-16, decimal commas": (foreign.german, 1e-5, 1e-3, 1e-4),
} | {name: (write, 1e-12, 1e-9, 1e-12) for name, write in CLOCK_TEXTS.items()}


def assert_same_flight(log: FlightLog, airspeed: float, height: float, velocity: float) -> None:
    """The first rows may be missing."""
    first = len(FLOWN["time"]) - len(log)
    assert first <= 3
    np.testing.assert_allclose(np.diff(log.time), 1.0, atol=1e-6)
    flown = {name: values[first:] for name, values in FLOWN.items()}
    speed = air.calibrated_airspeed(flown["impact_pressure"])
    assert np.abs(air.calibrated_airspeed(log.impact_pressure) - speed).max() <= 1.0001 * airspeed * KNOT
    altitude = air.pressure_altitude(flown["static_pressure"])
    assert np.abs(air.pressure_altitude(log.static_pressure) - altitude).max() <= 1.001 * height * FOOT
    for axis in ("velocity_north", "velocity_east"):
        assert np.abs(getattr(log, axis) - flown[axis]).max() <= velocity * KNOT
    if log.air_temperature is not None:
        assert np.abs(log.air_temperature - flown["air_temperature"]).max() <= 0.501
    if log.heading is not None:
        turn = np.angle(np.exp(1j * (log.heading - flown["heading"])))
        assert np.abs(turn).max() <= (0.51 if "g3x" not in log.header.get("mapping", "") else 1.0) * DEGREE


@pytest.mark.parametrize("name", list(CSV))
def test_csv_files(tmp_path, name):
    write, *steps = CSV[name]
    assert_same_flight(read_log(write(tmp_path / "log.csv", FLOWN)), *steps)


@pytest.mark.parametrize("mapping", [None, "ardupilot"])
def test_ardupilot_dataflash(tmp_path, mapping):
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    log = read_log(foreign.dataflash(tmp_path / "log.bin", FLOWN), mapping)
    assert_same_flight(log, 1e-5, 1e-2, 1e-4)
    assert log.velocity_down is not None
    assert log.altitude is not None


@pytest.mark.parametrize("renewed", [False, True])
def test_px4_ulog(tmp_path, renewed):
    """Written here byte by byte, read and written again by the format's own library."""
    pyulog = pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    first = foreign.ulog(tmp_path / "first.ulg", FLOWN, renewed)
    pyulog.ULog(str(first)).write_ulog(str(tmp_path / "second.ulg"))
    for path in (first, tmp_path / "second.ulg"):
        log = read_log(path)
        assert_same_flight(log, 1e-4, 1e-1, 1e-4)
        np.testing.assert_allclose(log.altitude, FLOWN["altitude"], rtol=1e-6)
        assert log.header["mapping"] == "px4"


def topics() -> dict[str, tuple[str, np.ndarray]]:
    """Topics of a log of the seaway project, each with a clock of its own: pressures, and fixes a quarter later."""
    rng, clock = np.random.default_rng(2), 100.0 + np.arange(90.0)
    velocity = [10.0 * np.cos(clock / 20), 10.0 * np.sin(clock / 20), np.zeros(90), 90e3 + clock]
    pressures = 120.0 + rng.standard_normal(90), 99000.0 + rng.standard_normal(90)
    return {
        "differential_pressure": ("float differential_pressure_pa;", np.column_stack([clock, pressures[0]])),
        "vehicle_air_data": ("float baro_pressure_pa;", np.column_stack([clock - 0.5, pressures[1]])),
        "sensor_gps": (
            "float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;float alt;",
            np.column_stack([clock + 0.25, *velocity]),
        ),
    }


def test_topics_of_a_ulog_are_joined_and_a_missing_one_is_named(tmp_path):
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    held, path = topics(), tmp_path / "log.ulg"
    path.write_bytes(foreign.ulog_bytes(held))
    log, gps = read_log(path, mapping="seaway"), held["sensor_gps"][1]
    assert (log.time[0], log.time[-1]) == pytest.approx((101.0, 188.0))
    np.testing.assert_allclose(log.impact_pressure, held["differential_pressure"][1][1:89, 1], rtol=1e-6)
    np.testing.assert_allclose(log.velocity_north, np.interp(log.time, gps[:, 0], gps[:, 1]), atol=1e-5)
    np.testing.assert_allclose(log.altitude, np.interp(log.time, gps[:, 0], gps[:, 4]) * 1e-3, rtol=1e-6)
    del held["sensor_gps"]
    path.write_bytes(foreign.ulog_bytes(held))
    says = r"no topic sensor_gps_0; it holds differential_pressure_0, vehicle_air"
    with pytest.raises(BadInputError, match=says):
        read_log(path, mapping="seaway")


def test_mat_files_of_version_7_3(tmp_path):
    pytest.importorskip("h5py", reason="needs the extra pitotbench[hdf5]")
    for place, name in (("", "flat"), ("fdata/", "struct")):
        path = foreign.mat73(tmp_path / f"{name}.mat", FLOWN, place)
        log = read_log(path)
        assert_same_flight(log, 1e-12, 1e-9, 1e-12)
        assert log.header["title"] == "a flight"
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(BadInputError, match=r"not a complete \.mat file of version 7"):
        read_log(path)


@pytest.mark.parametrize("hdf5", [False, True])
def test_a_matrix_with_a_row_a_sample(tmp_path, hdf5):
    if hdf5:
        pytest.importorskip("h5py", reason="needs the extra pitotbench[hdf5]")
    path = foreign.sidpac(tmp_path / "log.mat", FLOWN, hdf5)
    assert_same_flight(read_log(path, path.with_suffix(".toml")), 1e-12, 1e-9, 1e-12)


def test_a_struct_of_channels_with_units(tmp_path):
    from pitotbench.logbook.formats import read_mat

    path = foreign.mat_channels(tmp_path / "log.mat", FLOWN)
    assert_same_flight(read_log(path), 1e-12, 1e-9, 1e-12)
    assert set(read_mat(path).units) == {"SI"}


def test_jsbsims_own_output(tmp_path, monkeypatch):
    """A file that JSBSim itself writes."""
    import jsbsim

    monkeypatch.chdir(tmp_path)  # the c172x of JSBSim's library writes a file of its own where it flies
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.load_model("c172x")
    names = [name.removeprefix("/fdm/jsbsim/") for name in foreign.jsbsim_named(FLOWN) if name != "Time"]
    directive = tmp_path / "output.xml"
    listing = "".join(f"<property>{name}</property>" for name in names)
    directive.write_text(f'<output name="{tmp_path}/log.csv" type="CSV" rate="10">{listing}</output>')
    fdm.set_output_directive(str(directive))
    for name, value in (("ic/vc-kts", 90.0), ("ic/h-sl-ft", 5000.0), ("ic/psi-true-deg", 30.0)):
        fdm[name] = value
    fdm.run_ic()
    expected = []
    while fdm.get_sim_time() < 4.0:
        fdm.run()
        pressures = fdm["propulsion/pt-lbs_sqft"] - fdm["atmosphere/P-psf"], fdm["velocities/v-north-fps"]
        expected.append((fdm.get_sim_time(), *pressures))
    log = read_log(tmp_path / "log.csv")
    time, impact, north = np.array(expected).T
    rows = np.searchsorted(time, log.time - 1e-6)
    inside = rows < len(time)
    assert inside.sum() > 30
    assert log.header["mapping"] == "jsbsim"
    np.testing.assert_allclose(log.impact_pressure[inside], impact[rows[inside]] * 47.880259, rtol=2e-3)
    np.testing.assert_allclose(log.velocity_north[inside], north[rows[inside]] * FOOT, rtol=2e-3)


@pytest.mark.parametrize(
    ("module", "name", "write", "extra"),
    [
        ("pyulog", "log.ulg", foreign.ulog, "logs"),
        ("pymavlink.DFReader", "log.bin", None, "logs"),
        ("h5py", "log.mat", None, "hdf5"),
    ],
)
def test_an_absent_library_is_named_with_its_extra(tmp_path, monkeypatch, module, name, write, extra):
    path: Path = tmp_path / name
    if write is None:
        path.write_bytes(b"\xa3\x95\x80" if name.endswith("bin") else b"\x89HDF\r\n\x1a\n" + bytes(600))
    else:
        write(path, FLOWN)
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(BadInputError, match=rf"pip install 'pitotbench\[{extra}\]'"):
        read_log(path)


def test_a_clock_passes_midnight():
    times = np.array([f"{23 + i // 60 if i < 60 else 0}:{i % 60:02d}:00" for i in range(58, 64)], dtype=object)
    from pitotbench.logbook.columns import clock_seconds

    np.testing.assert_allclose(np.diff(clock_seconds("t", times)), 60.0)


@pytest.mark.parametrize(
    "text", ["25:00:00", "14:61:00", "yesterday", "2026-13-40 10:00:00", "99/99/2026 10:00:00"]
)
def test_no_clock_time(text):
    from pitotbench.logbook.columns import clock_seconds

    with pytest.raises(BadInputError, match=r"row 2: .* is not a clock time"):
        clock_seconds("t", np.array(["14:03:06", text], dtype=object))


def test_steps_of_a_display_are_found(tmp_path):
    log = read_log(foreign.kias(tmp_path / "log.csv", FLOWN))
    assert log.header["display"] == pytest.approx({"airspeed_mps": KNOT, "ground_speed_mps": KNOT})
    assert log.header["accuracy"]["velocity_mps"] == pytest.approx(np.hypot(0.05, 2.0 / np.sqrt(12.0) * KNOT))
    exact = read_log(foreign.jsbsim(tmp_path / "exact.csv", FLOWN))
    assert not {"accuracy", "display"} & set(exact.header)


def test_true_and_magnetic_tracks():
    count = np.arange(40.0)
    base = {
        "time_s": count,
        "impact_pressure_pa": 1500.0 + count % 7,
        "static_pressure_pa": 81200.0 + count % 3,
        "ground_speed_kt": np.full(40, 100.0),
    }
    true = base | {"track_deg": (10.0 * count + 10.0) % 360.0}
    magnetic = base | {"magnetic_track_deg": 10.0 * count % 360.0, "magnetic_variation_deg": np.full(40, 10.0)}
    one, other = (log_of(Table(tuple(t), tuple(t.values()))) for t in (true, magnetic))
    np.testing.assert_allclose(one.velocity_north, other.velocity_north, atol=1e-9)
    np.testing.assert_allclose(one.velocity_north[0], 100.0 * KNOT * np.cos(10.0 * DEGREE))


def test_a_calibrated_airspeed_is_taken_as_indicated(tmp_path):
    path = foreign.kias(tmp_path / "log.csv", FLOWN)
    path.write_text(path.read_text().replace("indicated_airspeed", "calibrated_airspeed"))
    log = read_log(path)
    assert any("what the air data computer has left" in warning for warning in log.header["warnings"])


def _cut(content: bytes) -> bytes:
    return content[:-5]


def _holed(content: bytes) -> bytes:
    """A ULog with a message of no topic, a DataFlash log with forty wrong bytes."""
    if content.startswith(b"ULog"):
        return content + struct.pack("<HB", 12, ord("D")) + b"\xff" * 12
    middle = len(content) // 2
    return content[:middle] + b"\x55" * 40 + content[middle + 40 :]


@pytest.mark.parametrize("library", ["pymavlink", "pyulog"])
@pytest.mark.parametrize(("damage", "says"), [(_cut, "its end is missing"), (_holed, "the file is damaged")])
def test_a_binary_log_that_is_cut_or_damaged_is_told_in_one_warning(tmp_path, library, damage, says, capfd):
    pytest.importorskip(library, reason="needs the extra pitotbench[logs]")
    suffix, write = {"pymavlink": (".bin", foreign.dataflash), "pyulog": (".ulg", foreign.ulog)}[library]
    path = write(tmp_path / f"log{suffix}", FLOWN)
    assert not _remarks(path, "the end|damaged|missing")
    path.write_bytes(damage(path.read_bytes()))
    assert len(_remarks(path, says)) == 1
    assert capfd.readouterr() == ("", "")


def _remarks(path: Path, pattern: str) -> list[str]:
    return [text for text in read_log(path).header.get("warnings", ()) if re.search(pattern, text)]


def test_a_mapping_that_the_header_names_was_not_applied(tmp_path):
    """Such a log has our columns: nothing of the mapping's advice is meant for it."""
    path = tmp_path / "log.csv"
    for named in ("5", '"jmoss"'):
        path.write_text(f"# mapping = {named}\n" + sample.write(path, sample.columns()).read_text())
        assert "mapping" not in read_log(path).header
        assert "no mapping is needed" in needs_mapping(path)


def test_another_file_is_not_read_through_a_mat_file(tmp_path):
    h5py = pytest.importorskip("h5py", reason="needs the extra pitotbench[hdf5]")
    other = foreign.mat73(tmp_path / "other.mat", FLOWN)
    with h5py.File(tmp_path / "log.mat", "w") as file:
        for name in h5py.File(other):
            file[name] = h5py.ExternalLink(str(other), name)
    with pytest.raises(BadInputError):
        read_log(tmp_path / "log.mat")
