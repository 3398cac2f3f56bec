"""Logs of the kinds that the cases of the field are of: made here, with headers as recorders write
them in other years, units and orders. Each holds one flight and is found without a flag.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from scipy.io import savemat

from pitotbench import air
from pitotbench.units import DEGREE, FOOT, KNOT

RATE = 1.0  # Hz
ROWS = 480
READS = 0.96  # of the calibrated airspeed
WIND = (5.0, 6.0)  # m/s toward north and east
TAKEOFF = 95.0  # m above the sea


def flown(speed_kt: float = 100.0, height: float = 1500.0, warmer: float = 0.0) -> dict:
    """Circles at three airspeeds, climbing and descending by 400 m: the columns in SI and knots."""
    rng = np.random.default_rng(48)
    time = np.arange(ROWS) / RATE
    legs = np.array([0.85, 0.85, 1.0, 1.0, 1.2, 1.2]) * speed_kt * KNOT
    calibrated = np.interp(time, [0.0, 140.0, 170.0, 300.0, 330.0, 480.0], legs)
    calibrated = calibrated + 0.1 * KNOT * rng.standard_normal(ROWS)
    level = height + 200.0 * np.sin(2.0 * np.pi * time / ROWS)
    static = np.asarray(air.standard_pressure(level))
    temperature = np.asarray(air.standard_temperature(level)) + warmer
    impact = np.asarray(air.impact_pressure(calibrated))
    true = np.asarray(air.true_airspeed(impact, static, temperature))
    heading = np.cumsum(np.full(ROWS, 4.0 * DEGREE / RATE))
    north = true * np.cos(heading) + WIND[0]
    east = true * np.sin(heading) + WIND[1]
    middle = 45.0 * DEGREE
    meters_north = np.cumsum(np.r_[0.0, 0.5 * (north[1:] + north[:-1])]) / RATE
    meters_east = np.cumsum(np.r_[0.0, 0.5 * (east[1:] + east[:-1])]) / RATE
    return {
        "time": time,
        "ias": READS * calibrated / KNOT,
        "tas": true / KNOT,
        "pressure": static,
        "palt_ft": level / FOOT,
        "height": level,
        "celsius": temperature - 273.15,
        "north": north,
        "east": east,
        "up": np.gradient(level, time),
        "gs": np.hypot(north, east) / KNOT,
        "track": np.degrees(np.arctan2(east, north)) % 360.0,
        "heading": np.degrees(heading) % 360.0,
        "latitude": 45.0 + np.degrees(meters_north / 6371e3),
        "longitude": 7.0 + np.degrees(meters_east / 6371e3 / np.cos(middle)),
    }


def clock(seconds: np.ndarray, hour: int = 14) -> list[str]:
    whole = seconds.astype(int)
    return [f"{hour:02d}:{s // 60:02d}:{s % 60:02d}" for s in whole]


def table(path: Path, columns: Mapping, mark: str = ",", above: str = "", digits: int = 7) -> Path:
    """Write columns below some lines; numbers with `digits` decimals."""
    cells = [
        [value if isinstance(value, str) else f"{value:.{digits}f}" for value in column]
        for column in columns.values()
    ]
    lines = [mark.join(columns), *map(mark.join, zip(*cells, strict=True))]
    path.write_text(above + "\n".join(lines) + "\n", encoding="utf-8")
    return path


def g5(folder: Path) -> Path:
    f = flown()
    columns = {
        "UTC Date (yyyy-mm-dd)": ["2021-06-05"] * ROWS,
        "UTC Time (hh:mm:ss)": clock(f["time"]),
        "Latitude (WGS84 deg)": f["latitude"],
        "Longitude (WGS84 deg)": f["longitude"],
        "GPS Velocity E (m/s)": np.round(f["east"], 2),
        "GPS Velocity N (m/s)": np.round(f["north"], 2),
        "GPS Velocity U (m/s)": np.round(f["up"], 2),
        "Pressure Altitude (ft)": np.round(f["palt_ft"]),
        "Indicated Airspeed (kt)": np.round(f["ias"], 1),
        "OAT (deg C)": np.round(f["celsius"], 1),
        "Internal Temperature (deg C)": np.full(ROWS, 41.0),
    }
    return table(folder / "log.csv", columns, above='#info,log_version="1.03"\n')


def inav(folder: Path) -> Path:
    """Of a decoder that writes the units, without the velocity of the receiver."""
    f = flown(38.0, 200.0)
    columns = {
        "loopIteration": np.arange(ROWS) * 1000,
        "time (us)": 7e6 + f["time"] * 1e6,
        "navVel[0] (cm/s)": np.round(100.0 * f["north"]),
        "navVel[1] (cm/s)": np.round(100.0 * f["east"]),
        "attitude[2]": np.round(10.0 * f["heading"]),
        "BaroAlt (cm)": np.round(100.0 * (f["height"] - TAKEOFF)),
        "AirSpeed (cm/s)": np.round(100.0 * f["ias"] * KNOT),
        "GPS_numSat": np.full(ROWS, 15.0),
        "GPS_altitude": np.round(f["height"]),
    }
    return table(folder / "LOG00042.01.csv", columns, ", ", digits=0)


def edgetx(speed: str, per_kt: float, height: str, per_m: float) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        f = flown(38.0, 300.0)
        columns = {
            "Date": ["2024-03-09"] * ROWS,
            "Time": [f"{each}.000" for each in clock(f["time"])],
            "1RSS(dB)": np.full(ROWS, -60.0),
            f"ASpd({speed})": np.round(per_kt * f["ias"], 1),
            f"Alt({height})": np.round(per_m * (f["height"] - 200.0), 1),
            f"GSpd({speed})": np.round(per_kt * f["gs"], 1),
            "Hdg(°)": np.round(f["track"], 1),
            "GPS": [f"{a:.6f} {b:.6f}" for a, b in zip(f["latitude"], f["longitude"], strict=True)],
            "Tmp1(°C)": np.full(ROWS, 55.0),
        }
        return table(folder / "Model-2024-03-09.csv", columns, digits=1)

    return write


def x_plane(folder: Path) -> Path:
    """With a tab instead of the bar's neighbors, another clock, and no course."""
    f = flown()
    columns = {
        " missn,_time ": f["time"] + 100.0,
        " _Vind,_kias ": f["ias"],
        " __lat,__deg ": f["latitude"],
        " __lon,__deg ": f["longitude"],
        " __alt,ftmsl ": f["height"] / FOOT,
        " AMprs,_inHG ": f["pressure"] / 3386.389,
        " AMtmp,_degC ": f["celsius"],
    }
    return table(folder / "Data.txt", columns, "|", above="\n\n")


def msfs(folder: Path) -> Path:
    """Angles in radians, pressure in millibars, as a program asks for that leaves the defaults."""
    f = flown()
    columns = {
        "SIMULATION TIME": f["time"] + 33.0,
        "Plane Latitude": np.radians(f["latitude"]),
        "Plane Longitude": np.radians(f["longitude"]),
        "Plane Heading Degrees True": np.radians(f["heading"]),
        "Airspeed Indicated": f["ias"],
        "Velocity World Z": f["north"] / FOOT,
        "Velocity World X": f["east"] / FOOT,
        "Ambient Temperature": f["celsius"],
        "Ambient Pressure": f["pressure"] / 100.0,
    }
    return table(folder / "flight.csv", columns, ";", digits=9)


def mode_s(folder: Path) -> Path:
    f = flown(230.0, 4000.0)
    columns = {
        "timestamp": [f"2023-08-01 {each}+00:00" for each in clock(f["time"])],
        "icao24": ["4b1800"] * ROWS,
        "latitude": f["latitude"],
        "longitude": f["longitude"],
        "altitude": 25.0 * np.round(f["palt_ft"] / 25.0),
        "track": f["track"],
        "groundspeed": f["gs"],
        "IAS": np.round(f["ias"]),
        "Mach": np.round(f["tas"] / 600.0, 3),
        "heading": f["heading"] - 2.0,
        "roll": np.full(ROWS, 25.0),
        "vertical_rate": np.full(ROWS, 0.0),
    }
    return table(folder / "4b1800.csv", columns)


def qgroundcontrol(folder: Path) -> Path:
    """Another order, further columns, no height above the sea."""
    f = flown(38.0, 300.0)
    columns = {
        "Timestamp": [f"2025-02-03 {each}.250" for each in clock(f["time"])],
        "heading": np.round(f["heading"]),
        "roll": np.full(ROWS, 8.0),
        "rollRate": np.full(ROWS, 0.1),
        "airSpeed": np.round(f["ias"] * KNOT, 2),
        "groundSpeed": np.round(f["gs"] * KNOT, 2),
        "altitudeRelative": np.round(f["height"] - 200.0, 1),
        "gps.lat": f["latitude"],
        "gps.lon": f["longitude"],
        "gps.hdop": np.full(ROWS, 0.7),
        "temperature.temperature1": np.full(ROWS, 38.0),
    }
    return table(folder / "Vehicle 1.csv", columns)


def airliner(folder: Path) -> Path:
    """Fields in lower case, four rates, the airspeed at the fastest."""
    f = flown(230.0, 4000.0)
    every = {"CAS": ("ias", 4), "GS": ("gs", 2), "TRK": ("track", 2), "ALT": ("palt_ft", 4)}
    held = {"SAT": ("celsius", 1), "VRTG": ("up", 8)}
    variables = {}
    for name, (key, rate) in {**every, **held}.items():
        moments = np.arange(ROWS * rate) / rate
        values = np.unwrap(f[key], period=360.0) if key == "track" else f[key]
        values = np.interp(moments, f["time"], values)
        values = values % 360.0 if key == "track" else values
        variables[name] = {"data": values, "rate": float(rate), "units": "", "alpha": name}
    savemat(folder / "tail.mat", variables)
    return folder / "tail.mat"


def dynon(folder: Path) -> Path:
    """Two recordings in one download; the clock begins anew."""
    f = flown()
    again = np.r_[f["time"][:240], f["time"][:240] + 2.0]
    columns = {
        "Session Time": again,
        "GPS Altitude (feet)": np.round(f["height"] / FOOT),
        "Ground Track (deg)": np.round(f["track"], 1),
        "Ground Speed (knots)": np.round(f["gs"], 1),
        "Indicated Airspeed (knots)": np.round(f["ias"], 1),
        "Pressure Altitude (ft)": np.round(f["palt_ft"]),
        "OAT (deg C)": np.round(f["celsius"], 1),
    }
    return table(folder / "USER_LOG.csv", columns, digits=2)


def piccolo(folder: Path) -> Path:
    """Columns as <Name>[unit], directions in radians; beside them those of the ground station."""
    f = flown(100.0, 400.0)
    columns = {
        "<Clock>[ms]": 1e3 * f["time"] + 8.1e5,
        "<Lat>[rad]": np.radians(f["latitude"]),
        "<Height>[m]": np.round(f["height"], 1),
        "<VNorth>[m/s]": np.round(f["north"], 2),
        "<VEast>[m/s]": np.round(f["east"], 2),
        "<BoxTemp>[C]": np.full(ROWS, 41.0),
        "<Alt>[m]": np.round(f["height"], 1),
        "<TAS>[m/s]": np.round(f["tas"] * KNOT, 2),
        "<OAT>[C]": np.round(f["celsius"], 1),
        "<Static>[Pa]": np.round(f["pressure"]),
        "<Dynamic>[Pa]": np.round(air.impact_pressure(f["ias"] * KNOT), 1),
        "<Yaw>[rad]": np.radians(f["heading"]),
        "<GSVNorth>[m/s]": np.zeros(ROWS),
    }
    return table(folder / "20140310.log", columns)


def sdlog2(folder: Path) -> Path:
    """The messages of PX4 before the ULog, side by side; the clock stands last, in microseconds."""
    f = flown(60.0, 500.0)
    columns = {
        "SENS_BaroPres": np.round(f["pressure"] / 100.0, 2),
        "SENS_BaroTemp": np.full(ROWS, 38.0),
        "SENS_DiffPres": np.round(air.impact_pressure(f["ias"] * KNOT), 1),
        "GPS_GPSTime": 1.4e15 + 1e6 * f["time"],
        "GPS_VelN": np.round(f["north"], 2),
        "GPS_VelE": np.round(f["east"], 2),
        "GPS_nSat": np.full(ROWS, 9.0),
        "AIRS_IndSpeed": np.round(f["ias"] * KNOT, 2),
        "TIME_StartTime": 5.5e7 + 1e6 * f["time"],
    }
    return table(folder / "log001.csv", columns)


def aura(folder: Path) -> Path:
    """One table a sensor in the folder of the flight, each with its clock."""
    f = flown(60.0, 400.0)
    parts = {
        "air": {
            "pressure_mbar": np.round(f["pressure"] / 100.0, 2),
            "temp_C": np.full(ROWS, 31.0),
            "airspeed_smoothed_kt": np.round(f["ias"], 2),
        },
        "gps": {"vn_ms": np.round(f["north"], 2), "ve_ms": np.round(f["east"], 2)},
        "imu": {"p_rad_sec": np.full(ROWS, 0.01), "temp_C": np.full(ROWS, 35.0)},
    }
    for name, columns in parts.items():
        table(folder / f"{name}-0.csv", {"timestamp": f["time"] + 33.0, **columns})
    return folder


def nasa(folder: Path) -> Path:
    """A file of research airplanes: some 30 lines with a unit each above the names, -9999 for blanks."""
    f = flown(220.0, 4000.0)
    columns = {
        "Start_UTC": f["time"] + 50_400.0,
        "Latitude": f["latitude"],
        "Pressure_Altitude": np.round(f["palt_ft"]),
        "Radar_Altitude": np.full(ROWS, -9999.0),
        "Ground_Speed": np.round(f["gs"] * KNOT, 2),
        "Indicated_Air_Speed": np.where(f["time"] == 77.0, -9999.0, np.round(f["ias"], 1)),
        "Track_Angle": np.round(f["track"], 2),
        "Static_Air_Temp": np.round(f["celsius"], 2),
        "Cabin_Pressure": np.full(ROWS, 850.0),
    }
    units = ("deg", "feet", "feet", "m/s", "kts", "deg (0-360)", "Celsius", "mb")
    stated = [f"{name}, {unit}" for name, unit in zip([*columns][1:], units, strict=True)]
    above = ["32, 1001", "DOE, J.", "NASA", "Navigation", "MISSION", "1, 1", "2013, 08, 15", "1"]
    remarks = ["Start_UTC, seconds", "8", ", ".join(["1"] * 8), ", ".join(["-9999"] * 8), *stated]
    remarks += ["0", "10", *(f"REMARK {number}: none" for number in range(10))]
    return table(folder / "nav.ict", columns, ", ", "\n".join([*above, *remarks]) + "\n", 2)


def jsbsim_groups(folder: Path) -> Path:
    """The groups of JSBSim's own output; `q bar` and the pressure at the sea mislead a guess."""
    f = flown()
    columns = {
        "Time": f["time"],
        "q bar (psf)": np.full(ROWS, 30.0),
        "V_{Total} (ft/s)": READS * f["tas"] * KNOT / FOOT,
        "V_{North} (ft/s)": f["north"] / FOOT,
        "V_{East} (ft/s)": f["east"] / FOOT,
        "Temperature (R)": 1.8 * (f["celsius"] + 273.15),
        "P_{SL} (psf)": np.full(ROWS, 2116.2),
        "P_{Ambient} (psf)": f["pressure"] / 47.880259,
        "Altitude ASL (ft)": f["height"] / FOOT,
        "Psi (deg)": f["heading"],
    }
    return table(folder / "c172_out.csv", columns)


def readsb(folder: Path) -> Path:
    f = flown(230.0, 4000.0)
    columns = {
        "hex": ["4b1800"] * ROWS,
        "point_timestamp": [f"2025-02-03 {each}" for each in clock(f["time"])],
        "altitude_baro": 25.0 * np.round(f["palt_ft"] / 25.0),
        "ground_speed": np.round(f["gs"], 1),
        "track": np.round(f["track"], 1),
        "ias": np.round(f["ias"]),
        "squawk": ["1000"] * ROWS,
    }
    return table(folder / "trace.csv", columns)


def transponder(folder: Path) -> Path:
    """A decoder whose names end in units as ours: its altitude is the transponder's, by pressure."""
    f = flown(230.0, 4000.0)
    columns = {
        "timestamp": 1.7e9 + f["time"],
        "icao24": ["4b1800"] * ROWS,
        "altitude_ft": 25.0 * np.round(f["palt_ft"] / 25.0),
        "track_deg": np.round(f["track"], 1),
        "ground_speed_kt": 2.0 * np.round(f["gs"] / 2.0),
        "heading_deg": f["heading"] - 2.0,
        "indicated_airspeed_kt": np.round(f["ias"]),
    }
    return table(folder / "bds.csv", columns)


def g3x_short(folder: Path) -> Path:
    """What a program keeps that reads the second line of names and leaves out the first."""
    f = flown()
    columns = {
        "Lcl Date": ["2022-03-04"] * ROWS,
        "Lcl Time": clock(f["time"], 7),
        "GPSVelE": np.round(f["east"], 2),
        "GPSVelN": np.round(f["north"], 2),
        "AltP": np.round(f["palt_ft"]),
        "AltInd": np.round(f["palt_ft"] + 120.0),
        "IAS": np.round(f["ias"], 1),
        "HDG": f["heading"] - 9.0,
        "MagVar": np.full(ROWS, 9.0),
        "OAT": np.round(f["celsius"], 1),
    }
    return table(folder / "log_short.csv", columns)


def analyzer(folder: Path) -> Path:
    f = flown(230.0, 4000.0)
    columns = {
        "Time": f["time"],
        "Airspeed": np.round(f["ias"], 1),
        "Altitude STD": np.round(f["palt_ft"]),
        "Groundspeed": np.round(f["gs"], 1),
        "Track": np.round(f["track"] - 3.0, 2),
        "Track True": np.round(f["track"], 2),
        "SAT": np.round(f["celsius"], 1),
    }
    return table(folder / "flight.csv", columns)


KINDS: dict[str, tuple[Callable[[Path], Path], str]] = {
    "Garmin G5 with a probe": (g5, "garmin_g3x"),
    "INAV with units": (inav, "inav"),
    "EdgeTX in knots and feet": (edgetx("kts", 1.0, "ft", 1.0 / FOOT), "edgetx"),
    "OpenTX in miles per hour": (edgetx("mph", 1.150779, "m", 1.0), "edgetx"),
    "X-Plane without a course": (x_plane, "x_plane"),
    "MSFS in radians": (msfs, "msfs"),
    "Mode S": (mode_s, "mode_s"),
    "QGroundControl without height above the sea": (qgroundcontrol, "qgroundcontrol"),
    "airliner": (airliner, "airline"),
    "Dynon with two recordings": (dynon, "dynon"),
    "Piccolo": (piccolo, "piccolo"),
    "PX4 before the ULog": (sdlog2, "px4_sdlog2"),
    "AuraUAS": (aura, "aura"),
    "NASA navigation": (nasa, "nasa_navigation"),
    "JSBSim by groups": (jsbsim_groups, "jsbsim_subsystems"),
    "readsb": (readsb, "mode_s"),
    "a decoder of transponders": (transponder, "mode_s"),
    "Garmin G3X by its short names": (g3x_short, "garmin_g3x"),
    "FlightDataAnalyzer": (analyzer, "flight_data_analyzer"),
}
