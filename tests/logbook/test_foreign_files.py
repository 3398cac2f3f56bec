"""One flight in the files that people have: the same numbers in all, exact or within the steps of
the display.
"""

import gzip
import re
import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.logbook import foreign_files as foreign
from tests.logbook import sample_log as sample

from pitotbench import BadInputError, FlightLog, air, read_log, write_log
from pitotbench.logbook.columns import Table, clock_seconds
from pitotbench.logbook.identity import kind_of
from pitotbench.logbook.matlab import read_mat
from pitotbench.logbook.reading import log_of, needs_mapping
from pitotbench.records import USUAL_ACCURACIES
from pitotbench.units import DEGREE, FOOT, KNOT

FLOWN = foreign.flight()
CLOCK_TEXTS = {f"clock {name}": foreign.clocked(write) for name, write in foreign.CLOCKS.items()}
# Largest errors that the digits of the file leave: impact pressure as airspeed [kt], height [ft],
# velocity [kt].
CSV = {
    "kias": (foreign.kias, 0.5, 5.0, 1.2),  # half a degree of track is 0.9 kt at 100 kt
    "garmin g1000": (
        foreign.g1000,
        0.005,
        0.1,
        0.13,
    ),  # a twentieth of a degree of track is 0.12 kt at 135 kt
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
    assert (
        np.abs(air.calibrated_airspeed(log.impact_pressure) - speed).max()
        <= 1.0001 * airspeed * KNOT
    )
    altitude = air.pressure_altitude(flown["static_pressure"])
    assert (
        np.abs(air.pressure_altitude(log.static_pressure) - altitude).max() <= 1.001 * height * FOOT
    )
    for axis in ("velocity_north", "velocity_east"):
        assert np.abs(getattr(log, axis) - flown[axis]).max() <= velocity * KNOT
    if log.air_temperature is not None:
        assert np.abs(log.air_temperature - flown["air_temperature"]).max() <= 0.501
    if log.heading is not None:
        turn = np.angle(np.exp(1j * (log.heading - flown["heading"])))
        assert np.abs(turn).max() <= 0.51 * DEGREE


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
    assert kind_of(log) == "drone"


def test_what_a_log_shows_of_the_kind_of_its_aircraft(tmp_path):
    log = FlightLog(**{name: values[:9] for name, values in FLOWN.items()})
    mass = np.full(9, 20.0)
    known = {
        "": log,
        "drone": replace(log, mass=mass),
        "glider": replace(log, header={"aircraft_kind": "glider"}),
    }
    for kind, each in known.items():
        assert kind_of(read_log(write_log(each, tmp_path / "log.csv"))) == kind
    assert kind_of(replace(log, mass=100.0 * mass)) == ""
    assert kind_of(replace(log, header={"parameters": {"ARSPD_RATIO": 2.0}})) == "drone"


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
    """Topics of a log of the seaway project, each with a clock of its own: pressures, and fixes a
    quarter later.
    """
    rng, clock = np.random.default_rng(2), 100.0 + np.arange(90.0)
    velocity = [10.0 * np.cos(clock / 20), 10.0 * np.sin(clock / 20), np.zeros(90), 90e3 + clock]
    pressures = 120.0 + rng.standard_normal(90), 99000.0 + rng.standard_normal(90)
    return {
        "differential_pressure": (
            "float differential_pressure_pa;",
            np.column_stack([clock, pressures[0]]),
        ),
        "vehicle_air_data": (
            "float baro_pressure_pa;",
            np.column_stack([clock - 0.5, pressures[1]]),
        ),
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
    np.testing.assert_allclose(
        log.impact_pressure, held["differential_pressure"][1][1:89, 1], rtol=1e-6
    )
    np.testing.assert_allclose(
        log.velocity_north, np.interp(log.time, gps[:, 0], gps[:, 1]), atol=1e-5
    )
    np.testing.assert_allclose(
        log.altitude, np.interp(log.time, gps[:, 0], gps[:, 4]) * 1e-3, rtol=1e-6
    )
    del held["sensor_gps"]
    path.write_bytes(foreign.ulog_bytes(held))
    says = r"no topic sensor_gps_0; it holds differential_pressure_0, vehicle_air"
    with pytest.raises(BadInputError, match=says):
        read_log(path, mapping="seaway")


def test_the_heading_of_px4_is_interpolated_through_south(tmp_path):
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    held, path = topics(), tmp_path / "log.ulg"
    clock = held["differential_pressure"][1][:, 0]
    track = clock / 20.0  # as of the fixes; the heading has a clock half a second early
    held["vehicle_local_position"] = (
        "float heading;",
        np.column_stack([clock - 0.5, (track - 0.025 + np.pi) % (2.0 * np.pi) - np.pi]),
    )
    path.write_bytes(foreign.ulog_bytes(held))
    log = read_log(path)
    for of in (np.sin, np.cos):
        np.testing.assert_allclose(of(log.heading), of(log.time / 20.0), atol=1e-5)


def test_a_mat_file_reads_no_other_file(tmp_path):
    """A dataset may name bytes of any file; they would become a column."""
    h5py = pytest.importorskip("h5py", reason="needs the extra pitotbench[hdf5]")
    (tmp_path / "secret.txt").write_bytes(b"12345678" * 8)
    path = foreign.mat73(tmp_path / "log.mat", FLOWN)
    with h5py.File(path, "a") as file:
        file.create_dataset("x", (8,), "f8", external=[(str(tmp_path / "secret.txt"), 0, 64)])
    with pytest.raises(BadInputError, match="another file"):
        read_log(path)


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
def test_a_matrix_with_a_row_a_sample_and_a_struct_of_channels_with_units(tmp_path, hdf5):
    if hdf5:
        pytest.importorskip("h5py", reason="needs the extra pitotbench[hdf5]")
    path = foreign.sidpac(tmp_path / "log.mat", FLOWN, hdf5)
    assert_same_flight(read_log(path, path.with_suffix(".toml")), 1e-12, 1e-9, 1e-12)
    path = foreign.mat_channels(path, FLOWN)
    assert_same_flight(read_log(path), 1e-12, 1e-9, 1e-12)
    assert set(read_mat(path).units) == {"SI"}


def test_jsbsims_own_output(tmp_path, monkeypatch):
    """A file that JSBSim itself writes."""
    import jsbsim

    monkeypatch.chdir(
        tmp_path
    )  # the c172x of JSBSim's library writes a file of its own where it flies
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.load_model("c172x")
    names = [
        name.removeprefix("/fdm/jsbsim/") for name in foreign.jsbsim_named(FLOWN) if name != "Time"
    ]
    directive = tmp_path / "output.xml"
    listing = "".join(f"<property>{name}</property>" for name in names)
    directive.write_text(
        f'<output name="{tmp_path}/log.csv" type="CSV" rate="10">{listing}</output>'
    )
    fdm.set_output_directive(str(directive))
    for name, value in (("ic/vc-kts", 90.0), ("ic/h-sl-ft", 5000.0), ("ic/psi-true-deg", 30.0)):
        fdm[name] = value
    fdm.run_ic()
    expected = []
    while fdm.get_sim_time() < 4.0:
        fdm.run()
        pressures = (
            fdm["propulsion/pt-lbs_sqft"] - fdm["atmosphere/P-psf"],
            fdm["velocities/v-north-fps"],
        )
        expected.append((fdm.get_sim_time(), *pressures))
    log = read_log(tmp_path / "log.csv")
    time, impact, north = np.array(expected).T
    rows = np.searchsorted(time, log.time - 1e-6)
    inside = rows < len(time)
    assert inside.sum() > 30
    assert log.header["mapping"] == "jsbsim"
    np.testing.assert_allclose(
        log.impact_pressure[inside], impact[rows[inside]] * 47.880259, rtol=2e-3
    )
    np.testing.assert_allclose(log.velocity_north[inside], north[rows[inside]] * FOOT, rtol=2e-3)


@pytest.mark.parametrize(
    ("module", "name", "write", "extra"),
    [
        ("pyulog", "log.ulg", foreign.ulog, "logs"),
        ("pymavlink.DFReader", "log.bin", None, "logs"),
        ("h5py", "log.mat", None, "hdf5"),
    ],
)
def test_an_absent_library_is_named_with_its_extra(
    tmp_path, monkeypatch, module, name, write, extra
):
    path: Path = tmp_path / name
    if write is None:
        path.write_bytes(
            b"\xa3\x95\x80" if name.endswith("bin") else b"\x89HDF\r\n\x1a\n" + bytes(600)
        )
    else:
        write(path, FLOWN)
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(BadInputError, match=rf"pip install 'pitotbench\[{extra}\]'"):
        read_log(path)


@pytest.mark.parametrize(
    "text", ["25:00:00", "14:61:00", "yesterday", "2026-13-40 10:00:00", "99/99/2026 10:00:00"]
)
def test_a_clock_passes_midnight_and_what_is_none_is_refused(text):
    times = ["23:58:00", "23:59:00", "00:00:00", "00:01:00"]
    np.testing.assert_allclose(np.diff(clock_seconds("t", np.array(times, dtype=object))), 60.0)
    with pytest.raises(BadInputError, match=r"row 2: .* is not a clock time"):
        clock_seconds("t", np.array(["14:03:06", text], dtype=object))


def test_steps_of_a_display_are_found(tmp_path):
    log = read_log(foreign.kias(tmp_path / "log.csv", FLOWN))
    assert log.header["display"] == pytest.approx({"airspeed_mps": KNOT, "ground_speed_mps": KNOT})
    usual = USUAL_ACCURACIES["velocity_mps"]
    assert log.header["accuracy"]["velocity_mps"] == pytest.approx(
        np.hypot(usual, 2.0 / np.sqrt(12.0) * KNOT)
    )
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
    magnetic = base | {
        "magnetic_track_deg": 10.0 * count % 360.0,
        "magnetic_variation_deg": np.full(40, 10.0),
    }
    one, other = (log_of(Table(tuple(t), tuple(t.values()))) for t in (true, magnetic))
    np.testing.assert_allclose(one.velocity_north, other.velocity_north, atol=1e-9)
    np.testing.assert_allclose(one.velocity_north[0], 100.0 * KNOT * np.cos(10.0 * DEGREE))


def computed(folder, name, values, *, without=()):
    """The flight with an air data computer's output in place of both pressures."""
    table = {
        "time_s": FLOWN["time"],
        name: values,
        "pressure_altitude_m": air.pressure_altitude(FLOWN["static_pressure"]),
        "air_temperature_k": FLOWN["air_temperature"],
        "velocity_north_mps": FLOWN["velocity_north"],
        "velocity_east_mps": FLOWN["velocity_east"],
    }
    return sample.write(
        folder / "log.csv", {key: column for key, column in table.items() if key not in without}
    )


OUTPUTS = {
    "calibrated_airspeed_mps": lambda q, p, t: air.calibrated_airspeed(q),
    "true_airspeed_kmh": lambda q, p, t: 3.6 * air.true_airspeed(q, p, t),
    "mach": lambda q, p, t: air.mach_from_impact_pressure(q, p),
}


@pytest.mark.parametrize("name", list(OUTPUTS))
def test_an_air_data_computers_output_stands_for_the_pressures(name, tmp_path):
    q, p, t = (FLOWN[n] for n in ("impact_pressure", "static_pressure", "air_temperature"))
    log = read_log(computed(tmp_path, name, OUTPUTS[name](q, p, t)))
    np.testing.assert_allclose(log.impact_pressure, q, rtol=1e-7)
    np.testing.assert_allclose(log.static_pressure, p, rtol=1e-7)
    assert (
        sum(
            "what the air data computer" in w or "what it has left" in w
            for w in log.header["warnings"]
        )
        == 1
    )
    assert (
        log.header["air_data"] == f"computer: {name.rpartition('_')[0].replace('_', ' ') or name}"
    )
    if name.startswith("true"):  # without a temperature it is that of a standard day
        path = computed(tmp_path, name, OUTPUTS[name](q, p, t), without=("air_temperature_k",))
        log = read_log(path)
        standard = air.standard_temperature(air.pressure_altitude(p))
        speed = air.true_airspeed(log.impact_pressure, p, standard)
        np.testing.assert_allclose(speed, air.true_airspeed(q, p, t), rtol=1e-7)


def test_a_column_beside_the_log_with_a_unit_of_its_own_is_left_alone(tmp_path):
    table = {
        **sample.columns(),
        "true_airspeed": 1.0,
        "latitude_1e7": 2.0,
        "longitude_deg": "E7°30",
    }
    table = {name: np.broadcast_to(values, sample.ROWS) for name, values in table.items()}
    log = read_log(sample.write(tmp_path / "log.csv", table))
    assert any(
        "not used" in w and "latitude_1e7, longitude_deg" in w for w in log.header["warnings"]
    )


def by_position(folder, table, digits):
    """A log whose velocity is replaced by the latitude and longitude of its path, to some digits."""
    step = np.diff(table["time_s"])
    path = {
        axis: np.r_[0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * step)]
        for axis, values in ((axis, table[f"velocity_{axis}_mps"]) for axis in ("north", "east"))
    }
    here = {
        name: values
        for name, values in table.items()
        if not name.startswith(("velocity", "altitude"))
    }
    # Near 47° a degree of latitude is 111,177 m, one of longitude 76,057 m (WGS 84).
    here["latitude_deg"] = np.round(47.0 + path["north"] / 111_177.0, digits)
    here["longitude_deg"] = np.round(8.0 + path["east"] / 76_057.0, digits)
    return sample.write(folder / "log.csv", here)


@pytest.mark.parametrize(
    ("rate", "digits", "within"), [(10.0, 9, 0.15), (1.0, 7, 0.15), (1.0, 5, 1.0)]
)
def test_the_ground_velocity_comes_from_the_position(rate, digits, within, tmp_path):
    names = {"time": "time_s", "air_temperature": "air_temperature_k"}
    names |= {
        name: f"{name}_{'pa' if 'pressure' in name else 'mps'}"
        for name in FLOWN
        if name[0] in "isv"
    }
    table = (
        sample.columns()
        if rate == 10.0
        else {column: FLOWN[name] for name, column in names.items()}
    )
    log = read_log(by_position(tmp_path, table, digits))
    for axis in ("north", "east"):
        off = getattr(log, f"velocity_{axis}") - table[f"velocity_{axis}_mps"]
        assert np.abs(off[8:-8]).max() < within
    assert any(
        "formed from 'latitude_deg' and 'longitude_deg'" in w for w in log.header["warnings"]
    )
    # What is told of the accuracy is what the digits leave: rounding of two fixes over the base of
    # the difference.
    rounding = 10.0**-digits * 111e3 / np.sqrt(12.0) * np.sqrt(2.0) / max(1.0, 2.0 / rate)
    told, usual = log.header["accuracy"]["velocity_mps"], USUAL_ACCURACIES["velocity_mps"]
    assert np.hypot(usual, 1.4 * rounding) < told < np.hypot(4.0 * usual, 4.0 * rounding)


def test_a_clock_that_was_set_gives_no_speed(tmp_path):
    """One second too much on the clock, and later the same second again: the path went on evenly."""
    table = sample.columns()
    path = by_position(tmp_path, table, 9)
    head, *rows = path.read_text().splitlines()
    time = table["time_s"] + np.where(np.abs(np.arange(sample.ROWS) - 300) < 100, 1.0, 0.0)
    set_rows = [
        f"{t:.1f},{row.split(',', 1)[1]}"
        for t, row in zip(np.maximum.accumulate(time), rows, strict=True)
    ]
    path.write_text("\n".join([head, *set_rows]))
    log = read_log(path)
    assert np.hypot(log.velocity_north, log.velocity_east).max() < 90.0
    assert len(log) > sample.ROWS - 50


def _cut(content: bytes) -> bytes:
    return content[:-5]


def _holed(content: bytes) -> bytes:
    """A ULog with a message of no topic, a DataFlash log with forty wrong bytes."""
    if content.startswith(b"ULog"):
        return content + struct.pack("<HB", 12, ord("D")) + b"\xff" * 12
    middle = len(content) // 2
    return content[:middle] + b"\x55" * 40 + content[middle + 40 :]


@pytest.mark.parametrize("library", ["pymavlink", "pyulog"])
@pytest.mark.parametrize(
    ("damage", "says"), [(_cut, "its end is missing"), (_holed, "the file is damaged")]
)
def test_a_binary_log_that_is_cut_or_damaged_is_told_in_one_warning(
    tmp_path, library, damage, says, capfd
):
    pytest.importorskip(library, reason="needs the extra pitotbench[logs]")
    suffix, write = {"pymavlink": (".bin", foreign.dataflash), "pyulog": (".ulg", foreign.ulog)}[
        library
    ]
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


@pytest.mark.parametrize("kind", [8, 10, 19, 0x0801])
def test_an_element_of_no_kind_in_a_mat_file_is_refused(tmp_path, kind):
    """One flipped bit in the tag of an element ended the whole program within SciPy's reader."""
    path = foreign.mat_channels(tmp_path / "log.mat", FLOWN)
    data = bytearray(path.read_bytes())
    shape = data.index(b"\x05\x00\x00\x00\x08\x00\x00\x00")
    data[shape : shape + 2] = kind.to_bytes(2, "little")
    path.write_bytes(data)
    with pytest.raises(BadInputError, match=r"not a complete \.mat file: it is damaged"):
        read_log(path)


ABOVE = [
    "AXXX001",
    "HFDTEDATE:020918,01",
    "HFPLTPILOTINCHARGE:A Name",
    "HFCM2CREW2:Another",
    "HFGTYGLIDERTYPE:Trainer 13",
    "HFFTYFRTYPE:Maker,Type 9",
]
EXTENSIONS = [("TAS", 5), ("GSP", 5), ("TRT", 3), ("OAT", 4)]


def igc(path, *, fix="A", start=86_380, extensions=EXTENSIONS):
    """The flight as a recorder writes it, one fix a second, over midnight."""
    tas = air.true_airspeed(
        FLOWN["impact_pressure"], FLOWN["static_pressure"], FLOWN["air_temperature"]
    )
    speed = np.hypot(FLOWN["velocity_north"], FLOWN["velocity_east"])
    track = np.degrees(np.arctan2(FLOWN["velocity_east"], FLOWN["velocity_north"])) % 360.0
    values = {
        "TAS": 360.0 * tas,
        "GSP": 360.0 * speed,
        "TRT": np.round(track) % 360.0,
        "OAT": 10.0 * (FLOWN["air_temperature"] - 273.15),
    }
    height = air.pressure_altitude(FLOWN["static_pressure"])
    ends = 35 + np.cumsum([width for _, width in extensions])
    parts = [
        f"{end - width + 1:02d}{end:02d}{code}"
        for end, (code, width) in zip(ends, extensions, strict=True)
    ]
    lines = [*ABOVE, f"I{len(parts):02d}{''.join(parts)}", "LXXXWORDS"]
    for row, second in enumerate(FLOWN["time"] + start):
        clock = round(second) % 86_400
        stamp = f"{clock // 3600:02d}{clock // 60 % 60:02d}{clock % 60:02d}"
        place = f"50{16_000 + 20 * row:05d}S07202189W"
        line = f"B{stamp}{place}{fix}{round(height[row]):05d}{round(FLOWN['altitude'][row]):05d}"
        lines.append(
            line + "".join(f"{round(values[code][row]):0{width}d}" for code, width in extensions)
        )
    data = ("\r\n".join([*lines, "GSIGNATURE"]) + "\r\n").encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


@pytest.mark.parametrize("name", ["log.igc", "LOG.IGC", "log.igc.gz"])
def test_a_recorder_file_is_read(name, tmp_path):
    log = read_log(igc(tmp_path / name))
    np.testing.assert_allclose(log.time, FLOWN["time"] - FLOWN["time"][0], atol=0.51)
    assert np.abs(log.static_pressure - FLOWN["static_pressure"]).max() < 10.0
    np.testing.assert_allclose(log.impact_pressure, FLOWN["impact_pressure"], rtol=2e-3)
    np.testing.assert_allclose(log.air_temperature, FLOWN["air_temperature"], atol=0.051)
    np.testing.assert_allclose(log.altitude, FLOWN["altitude"], atol=0.51)
    north, east = (getattr(log, name) - FLOWN[name] for name in ("velocity_north", "velocity_east"))
    assert np.hypot(north, east).max() < 1.0


def test_no_name_of_a_person_leaves_the_file_and_one_without_an_airspeed_says_so(tmp_path):
    header = read_log(igc(tmp_path / "log.igc")).header
    assert (header["glider"], header["recorder"]) == ("Trainer 13", "Maker,Type 9")
    assert header["start"] == "2018-09-02 23:59:40"
    assert "Name" not in str(header)
    assert "Another" not in str(header)
    with pytest.raises(BadInputError, match="logged no airspeed: its I record names no extension"):
        read_log(igc(tmp_path / "log.igc", extensions=[]))


def test_fixes_without_height_are_left_out(tmp_path):
    path = igc(tmp_path / "log.igc")
    lines = path.read_text().splitlines()
    lines[20:30] = [line.replace("WA", "WV") for line in lines[20:30]]
    lines[-2] = lines[-2][:30]
    path.write_text("\n".join(lines))
    log = read_log(path)
    assert len(log) == foreign.ROWS - 11
    assert any(
        f"11 of {foreign.ROWS} fixes are left out" in warning for warning in log.header["warnings"]
    )


@pytest.mark.parametrize(
    ("old", "new", "rows", "says"),
    [
        ("HFDTEDATE:020918", "HFDTEDATE:310218", foreign.ROWS, "the date 31.02.18 is none"),
        ("HFDTEDATE:020918", "HFDTEDATE:021399", foreign.ROWS, "the date 02.13.99 is none"),
        ("OATL", "OATL", foreign.ROWS, ""),
        ("I04", "I053635VAT", foreign.ROWS, "extensions VAT are left out"),
        ("I04", "I053036VAR", foreign.ROWS, "extensions VAR are left out"),
        ("I04", "I058088ENL", foreign.ROWS, "extensions ENL are left out"),
        ("B2359505016200S", "B23595A5016200S", foreign.ROWS - 1, "1 of 420 fixes are left out"),
        ("B2359505016200S07202189WA", "B2359505016200S07202189WA--", foreign.ROWS - 1, "1 of 420"),
    ],
)
def test_what_an_igc_file_does_not_need_costs_no_more_than_itself(old, new, rows, says, tmp_path):
    """A date that is none, an extension outside its line, a letter in a fix."""
    path = igc(tmp_path / "log.igc")
    text = path.read_text()
    path.write_text(text.replace(old, new, 1))
    log = read_log(path)
    assert len(log) == rows
    assert says in " ".join(log.header["warnings"])
    assert "np." not in " ".join(log.header["warnings"])


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "is empty"),
        (b"AXXX\r\nHFDTE020918\r\n", "holds no fix"),
        (b"\x00\x01" * 90, "holds no fix"),
        (b"B1441245016753S07202189WV0026500198\n" * 3, "no fix of three dimensions"),
        (b"B1441245016753S0720x189WA0026500198\n" * 3, "no number at bytes 19 to 23"),
    ],
)
def test_what_is_no_recorder_file_is_refused(content, says, tmp_path):
    path = tmp_path / "log.igc"
    path.write_bytes(content)
    with pytest.raises(BadInputError, match=says):
        read_log(path)
