"""Ten headers of the field, after public descriptions of the systems, with one flight below each.

The names are those of the systems; decoys that a careless guess would take are among them.
"""

from pathlib import Path

import numpy as np
from tests.logbook.foreign_files import ROWS, clock, displayed, write_rows

from pitotbench import air
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, PSF, PSI, Array

Column = Array | list[str]


def headers(flown: dict[str, Array]) -> dict[str, dict[str, Column]]:
    """The columns of each header."""
    d, time, q, p = (
        displayed(flown),
        flown["time"],
        flown["impact_pressure"],
        flown["static_pressure"],
    )
    names = ("velocity_north", "velocity_east", "velocity_down", "altitude")
    north, east, down, height = (flown[name] for name in names)
    mach, noise = (
        air.mach_from_impact_pressure(q, p),
        np.random.default_rng(3).standard_normal(ROWS),
    )
    total = np.asarray(air.total_temperature(flown["air_temperature"], mach))
    tas = np.asarray(air.true_airspeed(q, p, flown["air_temperature"]))
    heading = flown["heading"] / DEGREE
    return {
        # An angle-of-attack computer of homebuilders with an inertial system: milliseconds, counts,
        # velocities.
        "onspeed": {
            "timeStamp": time * 1e3 + 51_233.0, "Pfwd": 8000.0 + 900.0 * noise, "PfwdSmoothed": q / PSI,
            "PStatic": p / PSI, "Palt": d["pressure_altitude"], "IAS": d["ias"], "AngleofAttack": 4.0 + 0.3 * noise,
            "OAT": d["oat"], "TAS": tas / KNOT, "vnGnssVelNedNorth": north, "vnGnssVelNedEast": east,
            "vnGnssVelNedDown": down,
        },
        # The packet of research airplanes: units fixed by the description, none in the names.
        "iwg1": {
            "Date_Time": [f"{clock(i):%Y-%m-%dT%H:%M:%S}" for i in range(ROWS)], "Lat": 47.0 + 1e-4 * time,
            "Lon": 8.5 + 1e-4 * time, "GPS_MSL_Alt": height, "Press_Alt": d["pressure_altitude"],
            "Grnd_Spd": d["ground_speed"] * KNOT, "True_Airspeed": tas, "Indicated_Airspeed": d["ias"],
            "Mach_Number": mach, "Vert_Velocity": -down, "True_Hdg": heading, "Track": d["track"],
            "Ambient_Temp": d["oat"], "Dew_Point": d["oat"] - 6.0, "Total_Temp": total - 273.15,
            "Static_Press": p / 100.0, "Dynamic_Press": q / 100.0,
        },
        # A research airplane: names of one variable list, seconds of the day, hPa and °C.
        "ncar": {
            "Time": time + 50_586.0, "ATX": d["oat"], "TTX": total - 273.15, "DPXC": d["oat"] - 8.0,
            "PSX": p / 100.0, "QCX": q / 100.0, "TASX": tas, "GGALT": height, "GGVNS": north, "GGVEW": east,
            "GGSPD": d["ground_speed"] * KNOT, "THDG": heading, "ATTACK": 3.0 + 0.1 * noise,
        },
        # Another research airplane: instruments as endings of the names.
        "faam": {
            "Time": time + 36_000.0, "PS_RVSM": p / 100.0, "Q_RVSM": q / 100.0, "TAT_DI_R": total,
            "TAT_ND_R": total + 0.2, "ALT_GIN": height, "VELN_GIN": north, "VELE_GIN": east, "VELD_GIN": down,
            "HDG_GIN": heading, "TAS_RVSM": tas,
        },
        # A quick-access recorder of an airliner: short upper-case names of its parameters.
        "recorder": {
            "TIME (sec)": time, "CAS (KNOTS)": d["ias"], "ALT (FEET)": d["pressure_altitude"],
            "PALT (FEET)": d["pressure_altitude"], "SAT (DEG C)": d["oat"], "TAT (DEG C)": total - 273.15,
            "GS (KNOTS)": d["ground_speed"], "TRKT (DEG)": d["track"], "MACH": mach,
            "WS (KNOTS)": 15.0 + 0.1 * noise, "WD (DEG)": 310.0 + noise, "N1_1 (%)": 82.0 + 0.1 * noise,
        },
        # A flight-test recorder: IRIG time, units as endings in capitals.
        "pcm": {
            "IRIG_TIME": [f"{clock(i):%j:%H:%M:%S}.000" for i in range(ROWS)], "QCI_INHG": q / INCH_OF_MERCURY,
            "PSI_INHG": p / INCH_OF_MERCURY, "TTI_DEGK": total, "GPS_VN_FPS": north / FOOT,
            "GPS_VE_FPS": east / FOOT, "GPS_VD_FPS": down / FOOT, "HDG_TRUE_DEG": heading,
            "ALPHA_DEG": 3.0 + 0.2 * noise, "FUEL_TOTAL_LB": 900.0 - 0.2 * time, "EVENT": np.floor(time / 60.0),
        },
        # A cockpit display: clock, date, units in brackets, blanks in the names.
        "glass": {
            "Local Date": [f"{clock(i):%m/%d/%Y}" for i in range(ROWS)],
            "Local Time": [f"{clock(i):%H:%M:%S}" for i in range(ROWS)], "Latitude (deg)": 47.0 + 1e-4 * time,
            "GPS Alt (ft MSL)": d["height"], "Baro Alt (ft)": d["indicated_altitude"],
            "Altimeter Setting (in Hg)": np.full(ROWS, 30.12), "Airspeed (kts)": d["ias"],
            "True Airspeed (kts)": tas / KNOT, "OAT (C)": d["oat"], "Ground Spd (kts)": d["ground_speed"],
            "Ground Trk (deg)": d["track"], "Vert Spd (ft/min)": 30.0 * noise, "CHT 1 (F)": 350.0 + noise,
        },
        # A sheet typed from a video of the panel.
        "card": {
            "t [s]": time, "KIAS": d["ias"], "Hp [ft]": d["pressure_altitude"], "OAT [°C]": d["oat"],
            "GS [kt]": d["ground_speed"], "TRK [°]": d["track"],
            "remarks": ["" if i % 60 else "new speed" for i in range(ROWS)],
        },
        # A desktop simulator's table: names with commas and lines, knots and feet.
        "simulator": {
            "_real,_time": time + 12.0, "Vind,_kias": d["ias"], "Vtrue,_ktas": tas / KNOT,
            "Vtrue,_ktgs": d["ground_speed"], "press,__alt_ft": d["pressure_altitude"], "AMtmp,_degC": d["oat"],
            "hding,_true": heading, "track,_true_deg": d["track"], "thro1,_part": 0.6 + 0.01 * noise,
        },
        # A system-identification data set: symbols of the textbooks, feet, degrees and pounds.
        "sidpac": {
            "t": time, "alpha": 3.0 + 0.2 * noise, "beta": 0.2 * noise, "phi": 20.0 + 0.2 * noise,
            "theta": 3.0 + 0.2 * noise, "psi": heading, "qc_psf": q / PSF, "ps_psf": p / PSF,
            "tt_degR": total * 1.8, "vn_fps": north / FOOT, "ve_fps": east / FOOT, "h_ft": height / FOOT,
        },
    }  # fmt: skip


def write_header(path: Path, name: str, flown: dict[str, Array]) -> Path:
    """Write the flight under one of the headers."""
    table = headers(flown)[name]
    texts = [
        c if isinstance(c, list) else [repr(float(value)) for value in c] for c in table.values()
    ]
    quoted = [f'"{column}"' if "," in column else column for column in table]
    return write_rows(path, [], quoted, [list(row) for row in zip(*texts, strict=True)])
