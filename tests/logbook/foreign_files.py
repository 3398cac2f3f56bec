"""One flight as the files of other systems, each written after its public description or by its own
library.
"""

import re
import struct
from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from pitotbench import air
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, PSF, Array

ROWS = 420
START = datetime(2026, 5, 4, 14, 3, 6)
VARIATION = 12.5  # degrees, east
SETTING = 30.12  # inHg


def flight() -> dict[str, Array]:
    """Channels [SI] of seven minutes at 1 Hz: circles at a changing airspeed, in wind and gusts."""
    rng = np.random.default_rng(11)
    time = np.arange(float(ROWS))
    speed, heading = 62.0 + 9.0 * np.sin(time / 60.0), time / 35.0
    static = 81200.0 + 60.0 * np.sin(time / 40.0) + 4.0 * rng.standard_normal(ROWS)
    mach = (speed + 0.3 * rng.standard_normal(ROWS)) / air.sound_speed(276.0)
    north, east = speed * np.cos(heading) + 5.0, speed * np.sin(heading) - 6.0
    return {
        "time": time,
        "impact_pressure": np.asarray(air.impact_pressure_from_mach(mach, static)),
        "static_pressure": static,
        "air_temperature": 276.0 + 0.3 * rng.standard_normal(ROWS),
        "velocity_north": north,
        "velocity_east": east,
        "velocity_down": 0.1 * rng.standard_normal(ROWS),
        "altitude": np.asarray(air.pressure_altitude(static)) + rng.standard_normal(ROWS),
        "heading": heading % (2.0 * np.pi),
    }


def displayed(flown: dict[str, Array]) -> dict[str, Array]:
    """What a cockpit shows of the flight, in the units of a cockpit."""
    north, east = flown["velocity_north"], flown["velocity_east"]
    altitude = np.asarray(air.pressure_altitude(flown["static_pressure"])) / FOOT
    return {
        "ias": np.asarray(air.calibrated_airspeed(flown["impact_pressure"])) / KNOT,
        "pressure_altitude": altitude,
        "indicated_altitude": altitude
        - float(air.pressure_altitude(SETTING * INCH_OF_MERCURY)) / FOOT,
        "oat": flown["air_temperature"] - 273.15,
        "ground_speed": np.hypot(north, east) / KNOT,
        "track": np.arctan2(east, north) / DEGREE % 360.0,
        "height": flown["altitude"] / FOOT,
        "heading": flown["heading"] / DEGREE,
    }


def clock(seconds: float) -> datetime:
    return START + timedelta(seconds=float(seconds))


def every_row(flown: dict[str, Array]) -> range:
    return range(len(flown["time"]))


def write_rows(
    path: Path, above: list[str], names: list[str], rows: list[list[str]], mark: str = ","
) -> Path:
    path.write_text(
        "\n".join([*above, mark.join(names), *(mark.join(row) for row in rows)]) + "\n", "utf-8"
    )
    return path


def rows_of(*columns: tuple[Array | list[str], str]) -> list[list[str]]:
    """The cells of columns, each in its format."""
    formats = [form for _, form in columns]
    return [
        [format(cell, form) for cell, form in zip(row, formats, strict=True)]
        for row in zip(*(values for values, _ in columns), strict=True)
    ]


def kias(path: Path, flown: dict[str, Array]) -> Path:
    """Whole knots, degrees and tens of feet, read from displays."""
    d = displayed(flown)
    names = [
        "time_s",
        "indicated_airspeed_kt",
        "pressure_altitude_ft",
        "air_temperature_degc",
        "ground_speed_kt",
    ]
    shown = (
        flown["time"],
        d["ias"],
        10.0 * np.round(d["pressure_altitude"] / 10.0),
        d["oat"],
        d["ground_speed"],
    )
    rows = rows_of(*((values, ".0f") for values in (*shown, d["track"])))
    return write_rows(path, [], [*names, "track_deg"], rows)


def g1000(path: Path, flown: dict[str, Array]) -> Path:
    """Garmin G1000: a line about the airframe, one of units, padded names and cells, blanks while
    it starts.
    """
    d, n = displayed(flown), len(flown["time"])
    count = np.arange(n)
    names = (
        "  Lcl Date, Lcl Time, UTCOfst, AtvWpt,    AltB, BaroA,  AltMSL,   OAT,    IAS, "
        "GndSpd,    VSpd,  Pitch,"
    )
    names += "   Roll,   HDG,   TRK, volt1, E1 RPM, MagVar"
    units = (
        "#yyy-mm-dd, hh:mm:ss,   hh:mm,  ident, ft Baro,  inch,  ft msl, deg C,     kt,     "
        "kt,     fpm,    deg,"
    )
    units += "    deg,   deg,   deg, volts,    rpm,    deg"
    local = [clock(seconds) for seconds in flown["time"]]
    magnetic = [(d[name] - VARIATION) % 360.0 for name in ("heading", "track")]
    rows = rows_of(
        ([f"{t:%Y-%m-%d}" for t in local], ""), ([f"{t:%H:%M:%S}" for t in local], ""), (["  -07:00"] * n, ""),
        (["       "] * n, ""), (d["indicated_altitude"], "8.1f"), (np.full(n, SETTING), "6.2f"),
        (d["height"], "8.1f"), (d["oat"], "6.1f"), (d["ias"], "7.2f"), (d["ground_speed"], "7.2f"),
        (["    0.10"] * n, ""), (2.0 + 0.01 * (count % 7), "7.2f"), (15.0 + 0.01 * (count % 5), "7.2f"),
        (magnetic[0], "6.1f"), (magnetic[1], "6.1f"), (["  28.1"] * n, ""), (2400.0 + count % 3, "7.1f"),
        (np.full(n, VARIATION), "7.1f"),
    )  # fmt: skip
    rows[:3] = [[*cells[:7], *["       "] * 11] for cells in rows[:3]]
    above = ['#airframe_info, log_version="1.00", airframe_name="C172"', units]
    return write_rows(path, above, names.split(","), rows)


def g3x(path: Path, flown: dict[str, Array], product: str = "GDU 460") -> Path:
    """Garmin G3X Touch: long names, then short names, then rows."""
    d, local = displayed(flown), [clock(seconds) for seconds in flown["time"]]
    columns = {
        "Date (yyyy-mm-dd)": ("Lcl Date", [f"{t:%Y-%m-%d}" for t in local], ""),
        "Time (hh:mm:ss)": ("Lcl Time", [f"{t:%H:%M:%S}" for t in local], ""),
        "GPS Altitude (ft)": ("AltGPS", d["height"], ".0f"),
        "GPS Ground Speed (kt)": ("GndSpd", d["ground_speed"], ".1f"),
        "GPS Ground Track (deg)": ("TRK", d["track"], ".0f"),
        "GPS Velocity E (m/sec)": ("VelE", flown["velocity_east"], ".2f"),
        "GPS Velocity N (m/sec)": ("VelN", flown["velocity_north"], ".2f"),
        "GPS Velocity U (m/sec)": ("VelU", -flown["velocity_down"], ".2f"),
        "Magnetic Heading (deg)": ("HDG", d["heading"], ".0f"),
        "Pressure Altitude (ft)": ("AltP", d["pressure_altitude"], ".0f"),
        "Indicated Airspeed (kt)": ("IAS", d["ias"], ".1f"),
        "Outside Air Temp (deg C)": ("OAT", d["oat"], ".1f"),
    }
    rows = [
        [short for short, *_ in columns.values()],
        *rows_of(*(rest for _, *rest in columns.values())),
    ]
    return write_rows(
        path, [f'#airframe_info,log_version="1.00",product="{product}"'], list(columns), rows
    )


def gi275(path: Path, flown: dict[str, Array]) -> Path:
    """Garmin GI 275: the names of the G3X, without components of the GPS velocity."""
    above, *lines = g3x(path, flown, "GI 275").read_text("utf-8").splitlines()
    columns = zip(*(line.split(",") for line in lines), strict=True)
    kept = [column for column in columns if "Velocity" not in column[0]]
    names, *rest = map(list, zip(*kept, strict=True))
    return write_rows(path, [above], names, rest)


def dynon(path: Path, flown: dict[str, Array]) -> Path:
    """Dynon SkyView: seconds of the session, units in the names."""
    d, n = displayed(flown), len(flown["time"])
    columns = {
        "Session Time": (3600.0 + flown["time"], ".2f"),
        "GPS Fix Quality": (["2"] * n, ""),
        "GPS Altitude (feet)": (d["height"], ".0f"),
        "Ground Speed (knots)": (d["ground_speed"], ".1f"),
        "Ground Track (deg)": (d["track"], ".1f"),
        "Mag Var (deg)": (np.full(n, VARIATION), ""),
        "Indicated Airspeed (knots)": (d["ias"], ".1f"),
        "Pressure Altitude (ft)": (d["pressure_altitude"], ".0f"),
        "OAT (deg C)": (d["oat"], ".0f"),
    }
    return write_rows(path, [], list(columns), rows_of(*columns.values()))


def german(path: Path, flown: dict[str, Array]) -> Path:
    """Semicolons and decimal commas, in UTF-16, as a spreadsheet exports Unicode text."""
    columns = {
        "time_s": flown["time"],
        "impact_pressure_pa": flown["impact_pressure"],
        "static_pressure_hpa": flown["static_pressure"] / 100.0,
        "air_temperature_degc": flown["air_temperature"] - 273.15,
        "velocity_north_kmh": flown["velocity_north"] * 3.6,
        "velocity_east_kmh": flown["velocity_east"] * 3.6,
    }
    rows = rows_of(*((values, ".5f") for values in columns.values()))
    write_rows(
        path, [], list(columns), [[cell.replace(".", ",") for cell in row] for row in rows], ";"
    )
    path.write_text(path.read_text("utf-8"), "utf-16")
    return path


def clocked(write_clock: Callable[[datetime], str]) -> Callable[[Path, dict[str, Array]], Path]:
    """A canonical CSV whose time is a clock."""

    def write(path: Path, flown: dict[str, Array]) -> Path:
        names = [
            "impact_pressure_pa",
            "static_pressure_pa",
            "air_temperature_k",
            "velocity_north_mps",
        ]
        columns = [flown[name.rpartition("_")[0]] for name in (*names, "velocity_east_mps")]
        rows = [
            [write_clock(clock(flown["time"][i])), *(repr(float(c[i])) for c in columns)]
            for i in every_row(flown)
        ]
        return write_rows(path, [], ["time_s", *names, "velocity_east_mps"], rows)

    return write


CLOCKS: dict[str, Callable[[datetime], str]] = {
    "hms": lambda t: f"{t:%H:%M:%S}",
    "milliseconds": lambda t: t.isoformat(timespec="milliseconds").partition("T")[2],
    "iso": lambda t: f"{t:%Y-%m-%dT%H:%M:%S}",
    "iso-utc": lambda t: (t + timedelta(seconds=0.5)).isoformat(timespec="milliseconds") + "Z",
    "iso-zone": lambda t: f"{t:%Y-%m-%d %H:%M:%S}+02:00",
    "us": lambda t: f"{t.month}/{t.day}/{t.year} {t:%I:%M:%S %p}",
    "german": lambda t: f"{t:%d.%m.%Y %H:%M:%S}",
    "irig": lambda t: f"{t:%j:%H:%M:%S.%f}",
    "epoch": lambda t: f"{t.replace(tzinfo=UTC).timestamp():.3f}",
}


def jsbsim_named(flown: dict[str, Array]) -> dict[str, Array]:
    """The flight under the property names of JSBSim's CSV output."""
    return {
        "Time": flown["time"],
        "/fdm/jsbsim/propulsion/pt-lbs_sqft": (flown["impact_pressure"] + flown["static_pressure"])
        / PSF,
        "/fdm/jsbsim/atmosphere/P-psf": flown["static_pressure"] / PSF,
        "/fdm/jsbsim/atmosphere/T-R": flown["air_temperature"] * 1.8,
        "/fdm/jsbsim/velocities/v-north-fps": flown["velocity_north"] / FOOT,
        "/fdm/jsbsim/velocities/v-east-fps": flown["velocity_east"] / FOOT,
        "/fdm/jsbsim/position/h-sl-ft": flown["altitude"] / FOOT,
    }


def exact(path: Path, table: dict[str, Array]) -> Path:
    """Every digit written."""
    rows = [[repr(float(cell)) for cell in row] for row in zip(*table.values(), strict=True)]
    return write_rows(path, [], list(table), rows)


def jsbsim(path: Path, flown: dict[str, Array]) -> Path:
    return exact(path, jsbsim_named(flown))


_Formats = dict[str, tuple[int, str, str]]
_FORMATS: _Formats = {  # kind of message: number, letters of its fields, names
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "ARSP": (150, "QBffcffBBB", "TimeUS,I,Airspeed,DiffPress,Temp,RawPress,Offset,U,H,Pri"),
    "BARO": (151, "QBffcf", "TimeUS,I,Alt,Press,Temp,CRt"),
    "GPS": (
        152,
        "QBBIHBcLLeffffB",
        "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U",
    ),
    "CTUN": (155, "Qf", "TimeUS,ThO"),
    "PARM": (154, "QNf", "TimeUS,Name,Value"),
    "ATT": (153, "QccccCC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw"),
}


_AIRSPEEDS = "TimeUS,Airspeed,DiffPress,Temp,RawPress,Offset,U,H,Pri"
UP_TO_4_0 = _FORMATS | {  # a kind of message for each airspeed sensor, without its number
    "ARSP": (150, "QffcffBBB", _AIRSPEEDS),
    "ASP2": (156, "QffcffBBB", _AIRSPEEDS),
}


def _message(kind: str, values: list[object], formats: _Formats = _FORMATS) -> bytes:
    from pymavlink.DFReader import FORMAT_TO_STRUCT  # the table by which the library reads

    number, letters, _ = formats[kind]
    body = b""
    for letter, value in zip(letters, values, strict=True):
        code, scale, _ = FORMAT_TO_STRUCT[letter]
        if isinstance(value, str):
            body += struct.pack("<" + code, value.encode())
        else:
            body += struct.pack("<" + code, round(value / scale) if scale else value)
    return struct.pack("<BBB", 0xA3, 0x95, number) + body


def dataflash(
    path: Path,
    flown: dict[str, Array],
    parameters: Mapping[str, float] | None = None,
    formats: _Formats = _FORMATS,
) -> Path:
    """ArduPilot: two airspeed sensors, the second one wrong; a GPS message between two of the air
    data.

    With `parameters`, the impact pressure is what the first sensor gave without its offset. The
    formats of the versions up to 4.0 are `UP_TO_4_0`.
    """
    from pymavlink.DFReader import FORMAT_TO_STRUCT

    parts = []
    for name, (number, letters, columns) in formats.items():
        length = 3 + sum(struct.calcsize("<" + FORMAT_TO_STRUCT[letter][0]) for letter in letters)
        parts.append(_message("FMT", [number, length, name, letters, columns]))
    held = parameters or {}
    parts += [_message("PARM", [0, name, value]) for name, value in held.items()]
    offset = held.get("ARSPD_OFFSET", 0.0)
    speed = np.hypot(flown["velocity_north"], flown["velocity_east"])
    course = np.arctan2(flown["velocity_east"], flown["velocity_north"]) / DEGREE % 360.0
    for i in every_row(flown):
        us = int(flown["time"][i] * 1e6) + 5_000_000
        q, p = float(flown["impact_pressure"][i]), float(flown["static_pressure"][i])
        for sensor in (0, 1):
            told = [60.0, q / (1 + sensor), 31.0, q, offset, 1, 1, 0]
            kind = ("ARSP", "ASP2")[sensor] if "ASP2" in formats else "ARSP"
            numbered = [] if "ASP2" in formats else [sensor]
            parts.append(_message(kind, [us, *numbered, *told], formats))
        parts.append(_message("BARO", [us, 0, 0.0, p, 31.0, 0.0]))
        at = [float(values[i]) for values in (flown["altitude"], speed, course)]
        fix = [3, 1000 * i, 2300, 14, 0.7, 47.1, 8.5, *at]
        parts.append(_message("GPS", [us, 0, *fix, float(flown["velocity_down"][i]), 0.0, 1]))
        if "throttle" in flown:
            parts.append(_message("CTUN", [us, 100.0 * float(flown["throttle"][i])]))
        parts.append(
            _message("ATT", [us, 0.0, 15.0, 0.0, 2.0, 0.0, float(flown["heading"][i] / DEGREE)])
        )
    path.write_bytes(b"".join(parts))
    return path


def message_tables(
    folder: Path,
    flown: dict[str, Array],
    ratio: float,
    parameters: Mapping[str, float] | None = None,
) -> Path:
    """ArduPilot, one CSV file a kind of message: two airspeed sensors, the second one wrong.

    The airspeed is shown with `ratio`; `parameters` are a table of their own.
    """
    q, time = flown["impact_pressure"], flown["time"] * 1e6
    shown = np.sqrt(ratio * np.maximum(q, 0.0))
    twice, sensor = np.repeat(np.arange(len(time)), 2), np.tile([0.0, 1.0], len(time))
    north, east = flown["velocity_north"], flown["velocity_east"]
    messages = {
        "ARSP": {
            "TimeUS": time[twice],
            "I": sensor,
            "Airspeed": shown[twice],
            "DiffPress": (q[twice] / (1.0 + sensor)),
        },
        "BARO": {"TimeUS": time, "I": 0.0 * time, "Press": flown["static_pressure"]},
        "GPS": {
            "TimeUS": time,
            "I": 0.0 * time,
            "Spd": np.hypot(north, east),
            "GCrs": np.arctan2(east, north) / DEGREE % 360.0,
        },
    }
    for name, columns in messages.items():
        rows = rows_of(*((values, ".10g") for values in columns.values()))
        write_rows(folder / f"x_{name}.csv", [], list(columns), rows)
    if parameters is not None:
        rows = [["0", name, f"{value:g}", "0"] for name, value in parameters.items()]
        write_rows(folder / "x_PARM.csv", [], ["TimeUS", "Name", "Value", "Default"], rows)
    return folder


def ulog_bytes(
    topics: dict[str, tuple[str, Array]], parameters: Mapping[str, float] | None = None
) -> bytes:
    """A ULog (PX4 file format, version 1): header, flags, formats, subscriptions, data.

    A topic is the types of its fields, such as `float alt;` or `float[3] xyz;`, and rows of a clock
    [s] and values.
    """

    def message(kind: str, body: bytes) -> bytes:
        return struct.pack("<HB", len(body), ord(kind)) + body

    parts = [b"ULog\x01\x12\x35\x01", struct.pack("<Q", 0), message("B", bytes(40))]
    for key, value in (parameters or {}).items():
        typed = f"float {key}".encode()
        parts.append(message("P", bytes([len(typed)]) + typed + struct.pack("<f", value)))
    for name, (fields, _) in topics.items():
        parts.append(message("F", f"{name}:uint64_t timestamp;{fields}".encode()))
    for number, name in enumerate(topics):
        parts.append(message("A", struct.pack("<BH", 0, number) + name.encode()))
    for number, (fields, rows) in enumerate(topics.values()):
        types = re.findall(r"(double|float)(?:\[(\d+)\])? ", fields)
        codes = "".join(kind[0] * int(count or 1) for kind, count in types).replace("double", "d")
        for seconds, *values in rows:
            parts.append(
                message("D", struct.pack(f"<HQ{codes}", number, round(seconds * 1e6), *values))
            )
    return b"".join(parts)


def ulog(
    path: Path,
    flown: dict[str, Array],
    renewed: bool = False,
    parameters: Mapping[str, float] | None = None,
) -> Path:
    """PX4, of a version that calls its GPS topic `vehicle_gps_position`; with `renewed`, of the
    next ones.
    """
    time = flown["time"] + 100.0
    height = "double altitude_msl_m;" if renewed else "float alt;"
    velocity = [flown[f"velocity_{axis}"] for axis in ("north", "east", "down")]
    gps = np.column_stack([time, *velocity, flown["altitude"] * (1.0 if renewed else 1e3)])
    topics = {
        "differential_pressure": (
            "float differential_pressure_pa;",
            np.column_stack([time, flown["impact_pressure"]]),
        ),
        "vehicle_air_data": (
            "float baro_pressure_pa;",
            np.column_stack([time, flown["static_pressure"]]),
        ),
        "sensor_gps" if renewed else "vehicle_gps_position": (
            "float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;" + height,
            gps,
        ),
    }
    if (
        "throttle" in flown
    ):  # since 1.13 along the axes of the airplane, before as the fourth control
        before, after = (3, 0) if not renewed else (0, 2)
        many = [np.zeros(len(time))] * before + [flown["throttle"]] + [np.zeros(len(time))] * after
        name, field = (
            ("vehicle_thrust_setpoint", "xyz") if renewed else ("actuator_controls_0", "control")
        )
        topics[name] = (f"float[{len(many)}] {field};", np.column_stack([time, *many]))
    path.write_bytes(ulog_bytes(topics, parameters))
    return path


def canonical(flown: dict[str, Array]) -> dict[str, Array]:
    """The flight under our own column names."""
    units = {"time": "s", "air_temperature": "k", "altitude": "m", "heading": "rad"}
    return {
        f"{name}_{units.get(name, 'pa' if 'pressure' in name else 'mps')}": values
        for name, values in flown.items()
    }


def plain(path: Path, flown: dict[str, Array]) -> Path:
    """Our own CSV."""
    return exact(path, canonical(flown))


def mat73(path: Path, flown: dict[str, Array], place: str = "") -> Path:
    """As MATLAB writes version 7.3: 512 bytes of text, a column vector transposed, a struct as a
    group `place`.
    """
    import h5py

    def put(name: str, values: Array, kind: str) -> None:
        file.create_dataset(name, data=values).attrs["MATLAB_class"] = np.bytes_(kind)

    with h5py.File(path, "w", userblock_size=512) as file:
        for column, values in canonical(flown).items():
            put(place + column, values[None, :], "double")
        put(
            "header",
            np.array([[ord(letter)] for letter in "title = 'a flight'"], dtype=np.uint16),
            "char",
        )
    return path


def sidpac(path: Path, flown: dict[str, Array], hdf5: bool = False) -> Path:
    """SIDPAC keeps a flight in one matrix `fdata`, a row a sample; the mapping beside it names its
    columns.
    """
    table = canonical(flown)
    matrix = np.column_stack(list(table.values()))
    if hdf5:
        import h5py

        with h5py.File(path, "w") as file:
            file.create_dataset("fdata", data=matrix.T)
    else:
        from scipy.io import savemat

        savemat(path, {"fdata": matrix, "dt": 1.0, "title": "run 4"})
    lines = [f'"fdata(:,{k + 1})" = "{name}"' for k, name in enumerate(table)]
    path.with_suffix(".toml").write_text("[columns]\n" + "\n".join(lines))
    return path


def mat_channels(path: Path, flown: dict[str, Array]) -> Path:
    """A .mat file up to version 7: a struct of channels, each with its data, unit and description."""
    from scipy.io import savemat

    table = canonical(flown).items()
    channels = {
        name: {"data": values, "units": "SI", "description": name} for name, values in table
    }
    savemat(path, {"flightdata": channels})
    return path
