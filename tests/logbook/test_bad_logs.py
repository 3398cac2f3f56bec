"""What is bad is a clear error or a warning with its rows; what is plausible stays without a word."""

import re
import struct
import zlib
from collections.abc import Callable

import h5py
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy.io import savemat
from tests.logbook import sample_log as sample
from tests.logbook.bad_logs import GOOD, NEEDED, TIME, Table, put, scale, with_decimal_commas

from pitotbench import BadInputError, FlightLog, air, read_log, write_log
from pitotbench.logbook.columns import parse_header
from pitotbench.units import DEGREE, KNOT, STANDARD_GRAVITY


def hold(table: Table) -> Table:
    return put("velocity_east_mps", slice(200, 400), 20.0)(
        put("velocity_north_mps", slice(200, 400), 60.0)(table)
    )


WARNINGS: dict[str, tuple[Callable[[Table], Table], str, int]] = {
    "some NaN": (
        put("static_pressure_pa", slice(9, 12), np.nan),
        r"'static_pressure_pa'.*\(rows 10–12\)",
        597,
    ),
    "NaN in two places": (put("time_s", np.array([4, 7]), np.nan), r"'time_s'.*\(rows 5, 8\)", 598),
    "a clock of whole seconds": (
        lambda t: {**t, "time_s": np.floor(TIME)},
        r"540 of 600 time stamps repeat the one before: the rows are spread evenly over its steps "
        r"of 1 s",
        600,
    ),
    "a unit that starts up": (
        put("static_pressure_pa", slice(0, 50), np.nan),
        r"the first 50 rows are dropped: the log begins blank in 'static_pressure_pa'",
        550,
    ),
    "NaN for a while": (
        put("impact_pressure_pa", slice(100, 150), np.nan),
        r"50 of 600 values are not numbers \(rows 101–150\), 8 % of the log, 5 s: those rows are "
        r"dropped",
        550,
    ),
    "infinite for a while": (
        put("static_pressure_pa", slice(0, 50), np.inf),
        r"not numbers \(rows 1–50\)",
        550,
    ),
    "GPS lost for a while": (
        lambda t: put("velocity_east_mps", slice(200, 350), np.nan)(
            put("velocity_north_mps", slice(200, 350), np.nan)(t)
        ),
        r"150 of 600 values are not numbers \(rows 201–350\), 25 % of the log, 15 s",
        450,
    ),
    "empty cell": (put("total_temperature_k", 8, ""), r"'total_temperature_k'.*\(row 9\)", 599),
    "a spike": (
        put("static_pressure_pa", np.array([30, 31]), -81200.0),
        r"impossible values in 2 rows \(rows 31–32\)",
        598,
    ),
    "a GPS spike": (
        put("velocity_east_mps", 77, 1e6),
        r"'velocity_east_mps': impossible .*\(row 78\)",
        599,
    ),
    "a time repeats": (put("time_s", 50, 4.9), r"time stamps repeat \(row 51\)", 599),
    "some negative": (
        put("impact_pressure_pa", slice(20, 30), -1.0),
        r"negative in 10 rows \(rows 21–30\)",
        590,
    ),
    "stuck pitot": (
        put("impact_pressure_pa", slice(100, 220), 2500.0),
        r"seems stuck \(rows 101–220\)",
        480,
    ),
    "stuck GPS": (hold, r"'velocity_north_mps'.*seems stuck \(rows 201–400\)", 400),
    "stuck static": (
        put("static_pressure_pa", slice(100, 220), 81200.0),
        r"'static_pressure_pa'.*stuck",
        480,
    ),
    "static never moves": (put("static_pressure_pa", slice(None), 81200.0), r"never changes", 600),
    "vane not installed": (
        put("angle_of_attack_rad", slice(None), np.nan),
        r"'angle_of_attack_rad' is left out",
        600,
    ),
    "degrees said to be radians": (
        scale("angle_of_attack_rad", 57.3),
        r"left out.*angle_of_attack_deg",
        600,
    ),
    "g said to be m/s²": (
        scale("specific_force_z_mps2", 1 / 9.8),
        r"left out.*specific_force_z_g",
        600,
    ),
    "rpm said to be rad/s": (
        scale("propeller_speed_left_radps", 9.55),
        r"left out.*propeller_speed_left_rpm",
        600,
    ),
    "percent": (scale("throttle_left", 100.0), r"'throttle_left' is left out.*from 0 to 1", 600),
}


@pytest.mark.parametrize("name", list(WARNINGS))
def test_a_warning_names_the_rows_and_goes_with_the_log(read, tmp_path, name):
    spoil, message, rows = WARNINGS[name]
    log = read(spoil(sample.columns()))
    matching = [w for w in log.header["warnings"] if re.search(message, w)]
    assert matching, log.header["warnings"]
    assert len(log) == rows
    again = read_log(write_log(log, tmp_path / "again.parquet"))
    assert set(log.header["warnings"]) <= set(again.header["warnings"])


def standing(rows, of_value, *names):
    return lambda t: {
        name: np.where(rows, of_value(v), v) if name in names else v for name, v in t.items()
    }


CHANGED: dict[str, Callable[[Table], Table]] = {
    # A computed log may repeat all values at once; a stuck sensor repeats while others move.
    "constant speed without noise": standing(
        (TIME > 9.99) & (TIME < 29.99), lambda v: v[100], "impact_pressure_pa", "static_pressure_pa",
        "velocity_north_mps", "velocity_east_mps",
    ),
    "a parked airplane": standing(TIME < 19.99, lambda _: 0.0, "velocity_north_mps", "velocity_east_mps"),
    **{f"{rate} Hz": lambda t, rate=rate: {**t, "time_s": TIME * 10.0 / rate} for rate in (0.11, 1.0, 2000.0)},
    "an hour's gap": lambda t: {**t, "time_s": TIME + np.where(TIME < 30.0, 0.0, 3600.0)},
}  # fmt: skip


@pytest.mark.parametrize("name", list(CHANGED))
def test_every_row_of_a_log_that_may_be_is_kept(read, name):
    assert len(read(CHANGED[name](sample.columns()))) == sample.ROWS


def test_a_sound_log_has_no_warning(read):
    assert "warnings" not in read().header


def test_a_coarse_display_in_calm_air_is_not_a_stuck_sensor(read):
    """Steps of 20 Pa with noise of 3 Pa: on a steady leg of 25 s the number does not change."""
    table = sample.columns()
    steady = np.interp(TIME, [0.0, 20.0, 45.0, 60.0], [2900.0, 2500.0, 2500.0, 2100.0])
    noise = 3.0 * np.random.default_rng(1).standard_normal(sample.ROWS)
    table["impact_pressure_pa"] = 20.0 * np.round((steady + noise) / 20.0)
    log = read(table)
    assert len(log) == sample.ROWS
    assert not any("stuck" in warning for warning in log.header.get("warnings", ()))


def steady_legs() -> Table:
    """Legs of 90 s on four tracks at three airspeeds, 1 Hz, with turns of 3°/s between them; the
    velocity in whole m/s, heading and ground speed beside it.
    """
    rng = np.random.default_rng(3)
    leg, turn = np.zeros(90), np.full(30, np.pi / 60.0)
    heading = 0.14 + np.cumsum(np.tile(np.r_[leg, turn], 12))
    time, speed = np.arange(len(heading)) * 1.0, np.repeat([48.0, 60.0, 72.0], 480)
    gusts = 0.15 * rng.standard_normal(len(time))
    noise = 0.05 * rng.standard_normal((2, len(time)))  # of the receiver
    north = speed * np.cos(heading) - 2.6 + noise[0]
    east = speed * np.sin(heading) - 7.3 + noise[1]
    true = air.impact_pressure_from_true_airspeed(speed + gusts, 84300.0, 283.0)
    return {
        "time_s": time,
        "impact_pressure_pa": true,
        "static_pressure_pa": 84300.0 + 3.0 * rng.standard_normal(len(time)),
        "air_temperature_k": np.full(len(time), 283.0),
        "velocity_north_mps": np.round(north),
        "velocity_east_mps": np.round(east),
        "heading_deg": np.degrees(heading) % 360.0,
        "ground_speed_kt": np.round(np.hypot(north, east) / KNOT, 1),
        "track_deg": np.round(np.degrees(np.arctan2(east, north)) % 360.0),
    }


def without(table: Table, *names: str) -> Table:
    return {name: values for name, values in table.items() if name not in names}


def test_whole_meters_a_second_on_steady_legs_are_not_stuck(read):
    table = without(steady_legs(), "ground_speed_kt", "track_deg")
    for given in (table, without(table, "heading_deg")):
        log = read(given)
        assert len(log) == len(table["time_s"])
        assert not [text for text in log.header.get("warnings", ()) if "stuck" in text]
    # What the steps leave is in the bound, and a number that repeats is a fix all the same.
    assert log.header["accuracy"]["velocity_mps"] == pytest.approx(np.hypot(0.05, 1.0 / 3**0.5))
    assert log.gps_fresh.all()


def test_of_two_ground_velocities_the_finer_one_is_used_and_said(read):
    table = steady_legs()
    log = read(table)
    np.testing.assert_allclose(
        np.hypot(log.velocity_north, log.velocity_east), table["ground_speed_kt"] * KNOT
    )
    assert [text for text in log.header["warnings"] if "'ground_speed_kt' is used" in text]
    tens = {"ground_speed_kt": 10.0 * np.round(table["ground_speed_kt"] / 10.0)}
    finer = {"velocity_north_mps": table["velocity_north_mps"] + 0.01 * np.sin(table["time_s"])}
    for other in (tens, finer):
        log = read({**table, **other})
        np.testing.assert_array_equal(log.velocity_north, {**table, **other}["velocity_north_mps"])


@pytest.mark.parametrize("rows", [slice(70, 150), slice(400, 520), slice(1000, 1440)])
@pytest.mark.parametrize("kept", ["components", "speed and track"])
def test_a_receiver_that_is_stuck_is_found_among_coarse_steps(read, rows, kept):
    """Over a turn, over a change of airspeed, and to the end of the log."""
    table = steady_legs()
    names = ("velocity_north_mps", "velocity_east_mps"), ("ground_speed_kt", "track_deg")
    held, other = names if kept == "components" else names[::-1]
    table = without(table, *other)
    for name in held:
        table[name] = table[name].copy()
        table[name][rows] = table[name][rows.start]
    log = read(table)
    assert [text for text in log.header["warnings"] if "seems stuck" in text]
    assert not np.isin(log.time, np.arange(rows.start + 1, rows.stop)).any()
    assert len(log) > len(table["time_s"]) - (rows.stop - rows.start) - 100


def test_gps_blank_between_fixes_is_held(read):
    table = sample.columns()
    stale = np.arange(sample.ROWS) % 10 != 3
    for name in ("velocity_north_mps", "velocity_east_mps", "velocity_down_mps", "altitude_m"):
        table[name] = np.where(stale, np.nan, table[name])
    log = read(table)
    assert len(log) == sample.ROWS - 3
    np.testing.assert_array_equal(log.gps_fresh, ~stale[3:])
    assert log.velocity_north[9] == log.velocity_north[0] != log.velocity_north[10]
    assert len(log.header["warnings"]) == 1
    assert "blank between fixes (one in 10 rows)" in log.header["warnings"][0]


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_csv_file_that_is_cut_gives_its_whole_rows_and_a_warning(tmp_path, share):
    whole = write_log(sample.log(), tmp_path / "whole.csv").read_bytes()
    cut = tmp_path / "cut.csv"
    cut.write_bytes(whole[: int(share * len(whole))])
    log = read_log(cut)
    assert 0 < len(log) < sample.ROWS
    assert any("its end is missing" in w for w in log.header["warnings"])
    # A foreign one, which does not say how many rows it has.
    foreign = sample.write(tmp_path / "log.csv", sample.columns())
    foreign.write_bytes(foreign.read_bytes()[:-40])
    log = read_log(foreign)
    assert len(log) == sample.ROWS - 1
    assert any(f"row {sample.ROWS} breaks off after" in w for w in log.header["warnings"])


def test_mat_struct(tmp_path):
    table = {k: v for k, v in sample.columns().items() if k != "segment"}
    savemat(tmp_path / "log.mat", {"flight": table})
    np.testing.assert_array_equal(read_log(tmp_path / "log.mat").time, TIME)


@pytest.mark.parametrize("value", ['"a"', "[]", "{}", "2026-05-04", "true", "1.5"])
def test_a_number_of_rows_that_is_none_is_a_warning(value, read):
    log = read(above=f"# rows = {value}\n")
    assert len(log) == sample.ROWS
    assert any("`rows` is not a number of rows" in text for text in log.header["warnings"])


ODD = ["the header's `warnings` holds entries that are not text; they are ignored"]


@pytest.mark.parametrize(
    ("value", "kept"),
    [
        *((value, ODD) for value in ("[[1],[2]]", "5", "{a = 1}", "[1, 2]", "2026-05-04")),
        ('"one"', ["one"]),
        ('["one", "two"]', ["one", "two"]),
    ],
)
def test_warnings_that_are_texts_are_kept_and_others_left_out_with_a_warning(value, kept, read):
    assert read(above=f"# warnings = {value}\n").header["warnings"] == kept


@pytest.mark.parametrize(
    "text", ["x = " + "[" * 3000, "x = " + "1" * 5000, "[accuracy]\ntemperature_k = 1 K"]
)
def test_a_header_that_is_not_toml_is_kept_as_text(text, read):
    assert parse_header(text)[0] == {"comments": text.splitlines()}
    above = "".join(f"# {line}\n" for line in text.splitlines())
    assert "not TOML" in read(above=above).header["warnings"][0]


@pytest.mark.parametrize(
    "text", ['airframe_info, log_version="1.00", mode=NORMAL, ', "Flown by the club, runway 05"]
)
def test_a_remark_above_the_columns_is_kept_without_a_word(text, read):
    header = read(above=f"# {text}\n").header
    assert header["comments"] == [text.strip()]
    assert "warnings" not in header


@pytest.mark.parametrize("mark", [";", "\t"])
def test_decimal_commas_are_read(mark, tmp_path):
    table, lines = with_decimal_commas(mark)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(read_log(path).impact_pressure, table["impact_pressure_pa"])


def moved(table, name, change):
    return {**table, name: change(table[name])}


CIRCLE = GOOD["a circle"]
NO_WORD = GOOD | {
    "a circle without height, heading or temperature": {name: CIRCLE[name] for name in NEEDED},
    # A low of 980 hPa: 280 m of pressure altitude.
    "weather moves the static pressure of a height": moved(
        CIRCLE, "altitude_m", lambda height: height - 280.0
    ),
}
DOUBTED = {
    "a zero that a small gauge may have": (
        moved(
            GOOD["a small airplane in a wind of half its speed"],
            "impact_pressure_pa",
            lambda q: q + 100.0,
        ),
        "zero offset",
    ),
    "a height above the field": (
        moved(CIRCLE, "altitude_m", lambda h: h - 1000.0),
        "no weather explains that",
    ),
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
    """Legs and level turns of 20 s by turns at 80 m/s; the angle of attack is −3° without lift, and
    3° on a leg.
    """
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
    """In a cloverleaf the motion seemed to ask for several times the pitch, and the column was left
    out.
    """
    write_log(turning(bank_deg), tmp_path / "log.parquet")
    assert read_log(tmp_path / "log.parquet").pitch is not None


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize(
    ("element", "place", "value"),
    [
        pytest.param(b"\x05\0\0\0\x08\0\0\0", 4, 10, id="dimensions of 10 bytes"),
        pytest.param(
            b"\x06\0\0\0\x08\0\0\0\x06", 9, 8, id="complex numbers without an imaginary part"
        ),
    ],
)
def test_a_mat_file_that_ends_the_reader_of_scipy_without_an_error_is_refused(
    tmp_path, packed, element, place, value
):
    path = tmp_path / "log.mat"
    savemat(path, {"north": {"data": TIME, "unit": "m/s"}})
    file = bytearray(path.read_bytes())
    file[file.rindex(element) + place] = value
    if packed:
        body = zlib.compress(bytes(file[128:]))
        file[128:] = struct.pack("<II", 15, len(body)) + body
    path.write_bytes(file)
    with pytest.raises(BadInputError, match=r"not a complete \.mat file: it is damaged"):
        read_log(path)


def _variable(kind: int, flags: int, size: int, *parts: tuple[int, bytes]) -> bytes:
    """A variable of a .mat file of one row of `size`, without a name."""
    head = [
        (6, struct.pack("<II", flags << 8 | kind, 0)),
        (5, struct.pack("<ii", 1, size)),
        (1, b""),
    ]
    elements = (
        struct.pack("<II", made, len(data)) + data.ljust(-(-len(data) // 8) * 8, b"\0")
        for made, data in (*head, *parts)
    )
    return b"".join(elements)


NUMBER = (9, bytes(8))
NESTED = _variable(6, 0, 1, NUMBER)
for _ in range(2000):  # of Python's own depth is 1,000
    NESTED = _variable(1, 0, 1, (14, NESTED))
KILLERS = {  # what SciPy's reader dies of, reads beyond its end, or fills the memory with
    "no imaginary part": _variable(6, 8, 1, NUMBER),
    "no numbers": _variable(6, 0, 1),
    "a cell too few": _variable(1, 0, 2, (14, _variable(6, 0, 1, NUMBER))),
    "a list without an end": _variable(1, 0, 2_000_000_000, (14, _variable(6, 0, 1, NUMBER))),
    "fields without names": _variable(2, 0, 1),
    "a letter too few": _variable(4, 0, 2, (16, b"a")),
    "letters of no kind": _variable(4, 0, 2, (14, b"kt")),
    "sparse": _variable(5, 0, 1, (5, bytes(4)), (5, bytes(8)), NUMBER),
    "nested": NESTED,
}


@pytest.mark.parametrize("name", list(KILLERS))
def test_a_mat_file_that_kills_the_reader_of_scipy_is_refused(tmp_path, name):
    variable = KILLERS[name]
    head = b"MATLAB 5.0".ljust(124) + b"\0\1IM"
    path = tmp_path / "log.mat"
    path.write_bytes(head + struct.pack("<II", 14, len(variable)) + variable)
    with pytest.raises(BadInputError):
        read_log(path)


def _wide(file):
    file.create_dataset("time_s", shape=(1,), dtype="S2000000000", chunks=(1,))


def _shared_text(file):
    """A text of a million letters in the file once, and in each of a thousand rows."""
    texts = file.create_dataset("label", shape=(1000,), dtype=h5py.string_dtype())
    texts[0] = "q" * 1_000_000
    file.flush()
    place = texts.id.get_offset()
    with open(file.filename, "rb+") as raw:
        raw.seek(place)
        reference = raw.read(16)
        raw.seek(place)
        raw.write(reference * 1000)


def _fan(file):
    """Forty groups, each by two names in the next: 2 to the 40th ways to one dataset."""
    last = file.create_dataset("x", data=np.arange(5.0))
    for number in range(40):
        group = file.create_group(f"g{number}")
        group["a"], group["b"] = last, last
        last = group


def test_a_parquet_file_whose_table_of_contents_tells_too_little_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("pitotbench.logbook.damage._MANY", 1000)
    path = tmp_path / "log.parquet"
    parquet.write_table(pa.table({"label": ["q" * 2_000_000]}), path, compression="zstd")
    size = parquet.read_metadata(path).row_group(0).total_byte_size
    path.write_bytes(path.read_bytes().replace(_varint(size, 4), _varint(100, 4)))
    assert parquet.read_metadata(path).row_group(0).total_byte_size == 100
    with pytest.raises(BadInputError, match="would unpack to"):
        read_log(path)


def _varint(number: int, width: int) -> bytes:
    """A number as Parquet's table of contents writes it, with `width` bytes."""
    bits = [(2 * number >> 7 * place) & 127 for place in range(width)]
    return bytes([*(each | 128 for each in bits[:-1]), bits[-1]])


def test_a_parquet_file_that_contradicts_its_statistics_is_refused(tmp_path):
    """Of a column that may be empty, the statistics tell how often it is. PyArrow ended the program
    where the table of contents denied that it may.
    """
    path = write_log(sample.log(), tmp_path / "log.parquet")
    whole = path.read_bytes()
    optional, required = b"\x25\x02\x18\x06time_s", b"\x25\x00\x18\x06time_s"
    assert whole.count(optional) == 1
    path.write_bytes(whole.replace(optional, required))
    with pytest.raises(BadInputError, match="not a complete Parquet file"):
        read_log(path)


def test_a_column_of_lists_is_left_out_with_a_word(tmp_path):
    path = write_log(sample.log(), tmp_path / "log.parquet")
    table = parquet.read_table(path)
    lists = pa.array([[1.0, 2.0]] * len(table))
    parquet.write_table(table.append_column("spectrum", lists), path)
    assert "column 'spectrum' holds lists: it is left out" in read_log(path).header["warnings"]


@pytest.mark.parametrize(
    ("write", "words"),
    [
        (_wide, "would unpack to"),
        (_shared_text, "texts or lists of any length"),
        (_fan, "by two names"),
    ],
)
def test_a_small_file_of_version_7_3_that_fills_the_memory_is_refused(tmp_path, write, words):
    with h5py.File(tmp_path / "log.mat", "w") as file:
        write(file)
    with pytest.raises(BadInputError, match=words):
        read_log(tmp_path / "log.mat")


def _ulog(formats: list[str], announcements: int) -> bytes:
    messages = [(b"B", bytes(40)), *((b"F", text.encode()) for text in formats)]
    messages += [
        (b"A", struct.pack("<BH", 0, number) + b"sensor_gps") for number in range(announcements)
    ]
    parts = [struct.pack("<H", len(body)) + kind + body for kind, body in messages]
    return b"ULog\x01\x12\x35\x01" + bytes(8) + b"".join(parts)


@pytest.mark.parametrize(
    ("formats", "announcements"),
    [
        (["a:uint8_t[65535] x", "sensor_gps:uint64_t timestamp;a[65535] b"], 1),
        (["float:", "a:float[65535] x", "sensor_gps:uint64_t timestamp;a[65535] b"], 1),
        (["sensor_gps:uint64_t timestamp;float[6000] x"], 200),
    ],
    ids=["formats within one another", "a format with the name of a type", "many instances"],
)
def test_a_small_ulog_that_fills_the_memory_is_refused(tmp_path, formats, announcements):
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    (tmp_path / "log.ulg").write_bytes(_ulog(formats, announcements))
    with pytest.raises(BadInputError, match="more than 1,000,000 fields of its topic"):
        read_log(tmp_path / "log.ulg")


def test_a_ulog_that_ends_in_a_long_message_of_no_kind_is_read_to_its_end(tmp_path):
    """The search for the next message steps back by what the message states, not by what is there."""
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    long = struct.pack("<HB", 64, 0) + b"end"
    (tmp_path / "log.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + bytes(20_008) + long)
    with pytest.raises(BadInputError, match="the ULog holds no topic"):
        read_log(tmp_path / "log.ulg")


def test_a_ulog_without_any_message_is_refused_before_it_takes_minutes(tmp_path, monkeypatch):
    """Each byte is taken for the begin of a message: of a large file that that takes minutes."""
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    monkeypatch.setattr("pitotbench.logbook.ulog._MOST_STEPS", 1000)
    (tmp_path / "log.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + bytes(2000))
    with pytest.raises(BadInputError, match="not a complete ULog: it is damaged"):
        read_log(tmp_path / "log.ulg")
