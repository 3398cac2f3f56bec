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
}
