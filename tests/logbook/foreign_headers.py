"""Ten headers of the field, after public descriptions of the systems, with one flight below each.

The names are those of the systems; decoys that a careless guess would take are among them.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from tests.logbook.foreign_files import ROWS, clock, displayed, write_rows

from pitotbench import air
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, PSF, PSI, Array

Column = Array | list[str]


def _common(flown: Mapping[str, Array]) -> dict[str, Array]:
    q, p = flown["impact_pressure"], flown["static_pressure"]
    mach = air.mach_from_impact_pressure(q, p)
    return {
        "mach": mach,
        "total_temperature": np.asarray(air.total_temperature(flown["air_temperature"], mach)),
        "tas": np.asarray(air.true_airspeed(q, p, flown["air_temperature"])),
        "noise": np.random.default_rng(3).standard_normal(ROWS),
    }


def onspeed(flown: Mapping[str, Array]) -> dict[str, Column]:
    """An angle-of-attack computer of homebuilders with an inertial system: milliseconds, counts, velocities."""
    d, c = displayed(dict(flown)), _common(flown)
    return {
        "timeStamp": flown["time"] * 1e3 + 51_233.0,
        "Pfwd": 8000.0 + 900.0 * c["noise"],
        "PfwdSmoothed": flown["impact_pressure"] / PSI,
        "PStatic": flown["static_pressure"] / PSI,
        "Palt": d["pressure_altitude"],
        "IAS": d["ias"],
        "AngleofAttack": 4.0 + 0.3 * c["noise"],
        "OAT": d["oat"],
        "TAS": c["tas"] / KNOT,
        "vnGnssVelNedNorth": flown["velocity_north"],
        "vnGnssVelNedEast": flown["velocity_east"],
        "vnGnssVelNedDown": flown["velocity_down"],
    }


def iwg1(flown: Mapping[str, Array]) -> dict[str, Column]:
    """The packet of research airplanes: units fixed by the description, none in the names."""
    d, c = displayed(dict(flown)), _common(flown)
    return {
        "Date_Time": [f"{clock(i):%Y-%m-%dT%H:%M:%S}" for i in range(ROWS)],
        "Lat": 47.0 + 1e-4 * flown["time"],
        "Lon": 8.5 + 1e-4 * flown["time"],
        "GPS_MSL_Alt": flown["altitude"],
        "Press_Alt": d["pressure_altitude"],
        "Grnd_Spd": d["ground_speed"] * KNOT,
        "True_Airspeed": c["tas"],
        "Indicated_Airspeed": d["ias"],
        "Mach_Number": c["mach"],
        "Vert_Velocity": -flown["velocity_down"],
        "True_Hdg": d["heading"],
        "Track": d["track"],
        "Ambient_Temp": d["oat"],
        "Dew_Point": d["oat"] - 6.0,
        "Total_Temp": c["total_temperature"] - 273.15,
        "Static_Press": flown["static_pressure"] / 100.0,
        "Dynamic_Press": flown["impact_pressure"] / 100.0,
    }


def ncar(flown: Mapping[str, Array]) -> dict[str, Column]:
    """A research airplane: names of one variable list, seconds of the day, hPa and °C."""
    d, c = displayed(dict(flown)), _common(flown)
    return {
        "Time": flown["time"] + 50_586.0,
        "ATX": d["oat"],
        "TTX": c["total_temperature"] - 273.15,
        "DPXC": d["oat"] - 8.0,
        "PSX": flown["static_pressure"] / 100.0,
        "QCX": flown["impact_pressure"] / 100.0,
        "TASX": c["tas"],
        "GGALT": flown["altitude"],
        "GGVNS": flown["velocity_north"],
        "GGVEW": flown["velocity_east"],
        "GGSPD": d["ground_speed"] * KNOT,
        "THDG": d["heading"],
        "ATTACK": 3.0 + 0.1 * c["noise"],
    }


def faam(flown: Mapping[str, Array]) -> dict[str, Column]:
    """Another research airplane: instruments as endings of the names."""
    c = _common(flown)
    return {
        "Time": flown["time"] + 36_000.0,
        "PS_RVSM": flown["static_pressure"] / 100.0,
        "Q_RVSM": flown["impact_pressure"] / 100.0,
        "TAT_DI_R": c["total_temperature"],
        "TAT_ND_R": c["total_temperature"] + 0.2,
        "ALT_GIN": flown["altitude"],
        "VELN_GIN": flown["velocity_north"],
        "VELE_GIN": flown["velocity_east"],
        "VELD_GIN": flown["velocity_down"],
        "HDG_GIN": flown["heading"] / DEGREE,
        "TAS_RVSM": c["tas"],
    }


def recorder(flown: Mapping[str, Array]) -> dict[str, Column]:
    """A quick-access recorder of an airliner: short upper-case names of its parameters."""
    d, c = displayed(dict(flown)), _common(flown)
    return {
        "TIME (sec)": flown["time"],
        "CAS (KNOTS)": d["ias"],
        "ALT (FEET)": d["pressure_altitude"],
        "PALT (FEET)": d["pressure_altitude"],
        "SAT (DEG C)": d["oat"],
        "TAT (DEG C)": c["total_temperature"] - 273.15,
        "GS (KNOTS)": d["ground_speed"],
        "TRKT (DEG)": d["track"],
        "MACH": c["mach"],
        "WS (KNOTS)": 15.0 + 0.1 * c["noise"],
        "WD (DEG)": 310.0 + c["noise"],
        "N1_1 (%)": 82.0 + 0.1 * c["noise"],
    }


def pcm(flown: Mapping[str, Array]) -> dict[str, Column]:
    """A flight-test recorder: IRIG time, units as endings in capitals."""
    c = _common(flown)
    return {
        "IRIG_TIME": [f"{clock(i):%j:%H:%M:%S}.000" for i in range(ROWS)],
        "QCI_INHG": flown["impact_pressure"] / INCH_OF_MERCURY,
        "PSI_INHG": flown["static_pressure"] / INCH_OF_MERCURY,
        "TTI_DEGK": c["total_temperature"],
        "GPS_VN_FPS": flown["velocity_north"] / FOOT,
        "GPS_VE_FPS": flown["velocity_east"] / FOOT,
        "GPS_VD_FPS": flown["velocity_down"] / FOOT,
        "HDG_TRUE_DEG": flown["heading"] / DEGREE,
        "ALPHA_DEG": 3.0 + 0.2 * c["noise"],
        "FUEL_TOTAL_LB": 900.0 - 0.2 * flown["time"],
        "EVENT": np.floor(flown["time"] / 60.0),
    }


def glass(flown: Mapping[str, Array]) -> dict[str, Column]:
    """A cockpit display: clock, date, units in brackets, blanks in the names."""
    d, c = displayed(dict(flown)), _common(flown)
    return {
        "Local Date": [f"{clock(i):%m/%d/%Y}" for i in range(ROWS)],
        "Local Time": [f"{clock(i):%H:%M:%S}" for i in range(ROWS)],
        "Latitude (deg)": 47.0 + 1e-4 * flown["time"],
        "GPS Alt (ft MSL)": d["height"],
        "Baro Alt (ft)": d["indicated_altitude"],
        "Altimeter Setting (in Hg)": np.full(ROWS, 30.12),
        "Airspeed (kts)": d["ias"],
        "True Airspeed (kts)": c["tas"] / KNOT,
        "OAT (C)": d["oat"],
        "Ground Spd (kts)": d["ground_speed"],
        "Ground Trk (deg)": d["track"],
        "Vert Spd (ft/min)": 30.0 * c["noise"],
        "CHT 1 (F)": 350.0 + c["noise"],
    }


def card(flown: Mapping[str, Array]) -> dict[str, Column]:
    """A sheet typed from a video of the panel."""
    d = displayed(dict(flown))
    return {
        "t [s]": flown["time"],
        "KIAS": d["ias"],
        "Hp [ft]": d["pressure_altitude"],
        "OAT [°C]": d["oat"],
        "GS [kt]": d["ground_speed"],
        "TRK [°]": d["track"],
        "remarks": ["" if i % 60 else "new speed" for i in range(ROWS)],
    }


def simulator(flown: Mapping[str, Array]) -> dict[str, Column]:
    """A desktop simulator's table: names with commas and lines, knots and feet."""
    d, c = displayed(dict(flown)), _common(flown)
    return {
        "_real,_time": flown["time"] + 12.0,
        "Vind,_kias": d["ias"],
        "Vtrue,_ktas": c["tas"] / KNOT,
        "Vtrue,_ktgs": d["ground_speed"],
        "press,__alt_ft": d["pressure_altitude"],
        "AMtmp,_degC": d["oat"],
        "hding,_true": d["heading"],
        "track,_true_deg": d["track"],
        "thro1,_part": 0.6 + 0.01 * c["noise"],
    }


def sidpac(flown: Mapping[str, Array]) -> dict[str, Column]:
    """A system-identification data set: symbols of the textbooks, feet, degrees and pounds."""
    c = _common(flown)
    return {
        "t": flown["time"],
        "alpha": 3.0 + 0.2 * c["noise"],
        "beta": 0.2 * c["noise"],
        "phi": 20.0 + 0.2 * c["noise"],
        "theta": 3.0 + 0.2 * c["noise"],
        "psi": flown["heading"] / DEGREE,
        "qc_psf": flown["impact_pressure"] / PSF,
        "ps_psf": flown["static_pressure"] / PSF,
        "tt_degR": c["total_temperature"] * 1.8,
        "vn_fps": flown["velocity_north"] / FOOT,
        "ve_fps": flown["velocity_east"] / FOOT,
        "h_ft": flown["altitude"] / FOOT,
    }


HEADERS: dict[str, Callable[[Mapping[str, Array]], dict[str, Column]]] = {
    "onspeed": onspeed,
    "iwg1": iwg1,
    "ncar": ncar,
    "faam": faam,
    "recorder": recorder,
    "pcm": pcm,
    "glass": glass,
    "card": card,
    "simulator": simulator,
    "sidpac": sidpac,
}


def write_header(path: Path, name: str, flown: dict[str, Array]) -> Path:
    """Write the flight under one of the headers."""
    table = HEADERS[name](flown)
    texts = [c if isinstance(c, list) else [repr(float(value)) for value in c] for c in table.values()]
    quoted = [f'"{column}"' if "," in column else column for column in table]
    return write_rows(path, [], quoted, [list(row) for row in zip(*texts, strict=True)])
