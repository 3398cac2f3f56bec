"""Header lines as they stand in public repositories, and ten made here, with one flight below each.

Of a repository only the line of names (and that of units) is quoted, with its source. A line of
`holds` names what a column holds, by our column; a `~` marks one that a mapping needs not, but that
must not be taken for another. All other columns hold numbers without a meaning.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from tests.logbook import foreign_files as foreign

from pitotbench import air
from pitotbench.units import DEGREE, INCH_OF_MERCURY, Array, from_si

ONSPEED = (
    "timeStamp,Pfwd,PfwdSmoothed,P45,P45Smoothed,PStatic,Palt,IAS,AngleofAttack,flapsPos,DataMark,OAT,TAS,imuTemp,"
    "VerticalG,LateralG,ForwardG,RollRate,PitchRate,YawRate,Pitch,Roll,"
)
VN300 = (
    "vnAngularRateRoll,vnAngularRatePitch,vnAngularRateYaw,vnVelNedNorth,vnVelNedEast,vnVelNedDown,vnAccelFwd,"
    "vnAccelLat,vnAccelVert,vnYaw,vnPitch,vnRoll,vnLinAccFwd,vnLinAccLat,vnLinAccVert,vnYawSigma,vnRollSigma,"
    "vnPitchSigma,vnGnssVelNedNorth,vnGnssVelNedEast,vnGnssVelNedDown,vnGnssLat,vnGnssLon,vnGPSFix,vnDataAge,"
    "vnTimeUTC,"
)
EFIS = (
    "efisIAS,efisPitch,efisRoll,efisLateralG,efisVerticalG,efisPercentLift,efisPalt,efisVSI,efisTAS,efisOAT,"
    "efisFuelRemaining,efisFuelFlow,efisMAP,efisRPM,efisPercentPower,efisMagHeading,efisAge,efisTime,"
)
DERIVED = "EarthVerticalG,FlightPath,VSI,Altitude,DerivedAOA,CoeffP"
ATTAS = (
    "T AXCG AYCG AZCG AYCKP AZCKP PRGX QRGY RRGZ PHI THE PSI ALCG BECG VTASCG HQNH PDOT QDOT RDOT "
    "HRADIO VCAS "
    "DELV IHTRM N1T1L N1T2R DLC_L DLC_R DAIL_L DAIL_R DRUD MACH SAT PSTAT RHO PHLAT LALON FN_L "
    "FN_R FUELUS BETDOT "
    "FW ALDOT FLAP DSPL_L DSPL_R"
)
ATTAS_UNITS = (
    "s M/S**2 M/S**2 M/S**2 M/S**2 M/S**2 DEG/S DEG/S DEG/S DEG DEG DEG DEG DEG M/S M DEG/S2 "
    "DEG/S2 DEG/S2 M M/S "
    "DEG DEG PROZENT PROZENT DEG DEG DEG DEG DEG -- M-0K PA Kg/m3 DEG DEG N N KG DEG/S -- DEG/S "
    "DEG DEG DEG"
)
HFB = "T DELV PDYN THRUST TASCG ALFCG THE Q QDOT AXCG AZCG AYCG P R PDOT RDOT BETCG PHI DAIL DRUD"
HFB_UNITS = (
    "S RAD PA N M/S RAD RAD RAD/S RAD/S2 M/S2 M/S2 M/S2 RAD/S RAD/S RAD/S2 RAD/S2 RAD RAD RAD RAD"
)
G1000 = (
    "  Lcl Date, Lcl Time, UTCOfst, AtvWpt,     Latitude,    Longitude,    AltB, BaroA,  AltMSL,   "
    "OAT,    IAS, "
    "GndSpd,    VSpd,  Pitch,   Roll,  LatAc, NormAc,   HDG,   TRK, volt1, volt2,  amp1,  amp2,  "
    "FQtyL,  FQtyR, "
    "E1 FFlow, E1 OilT, E1 OilP, E1 RPM,  AltGPS, TAS, HSIS,    CRS,   NAV1,   NAV2,    COM1,    "
    "COM2,   HCDI,   "
    "VCDI, WndSpd, WndDr, WptDst, WptBrg, MagVar"
)
D180 = (
    "zulu is gps;zulu hour;zulu min;zulu sec;date valid;zulu day;zulu mo;zulu year;nav port;sel "
    "course;cdi;gsi;"
    "type;oil pres;man pres;oil temp;fuel pres;volts;amps;rpm;fuel "
    "flow;hobbs;tach;pitch;roll;heading;turn rate;"
    "airspeed;altitude;vert spd;gz;aoa %;oat"
)
ATC_CONSOLE = (
    "Time, s;Sound velocity (ISA), m/s;Air density (ISA), kg/m^3;Static air pressure (ISA), "
    "Pa;Static temperature "
    "(ISA), K;Climb mode;Flight phase;Target altitude, ft;Target speed TAS, kt;Cross track error, "
    "nm;Heading "
    "error, deg;Longitude, deg;Latitude, deg;Altitude, ft;True airspeed, kt;True heading, deg;Mach "
    "number;Bank "
    "angle, deg;Path angle, deg;Lift coefficient;Drag coefficient;Lift force, N;Drag force, "
    "N;Thrust force, N"
)
FTIS = (
    "Ahrs1_Pitch,Ahrs1_Roll,Ahrs1_VertAcc,Ahrs1_bLatAcc,Ahrs1_bPitchRate,Ahrs1_bRollRate,Ahrs1_bYawRate,Dadc1_alt,"
    "Dadc1_altRate,Dadc1_bcAlt,Dadc1_cas,Dadc1_mach,Dadc1_sat,Dadc1_tas,Dadc1_tat,Gps_lat,Gps_long,Gps_utcSec,"
    "delta_a,delta_e,delta_r,vane_AOA"
)
ALFA = (
    "time,roll_commanded,roll_measured,pitch_commanded,pitch_measured,yaw_commanded,yaw_measured,label,"
    "wind_estimation_linear_x,wind_estimation_linear_y,orientation_x,angular_velocity_x,linear_acceleration_x,"
    "airspeed,groundspeed,throttle,altitude,climb"
)
XPLANE = (
    "Epoch time|ID|Timestamp|pitch_deg|roll_deg|hding_true|hding_mag|lat_deg|lon_deg|alt_ftmsl|alt_ftagl|on_runwy|"
    "alt_ind|lat_south|lon_west"
)
NO_DIRECTION = ("velocity_north or ground_speed or latitude", "velocity_east or track")


@dataclass(frozen=True)
class Quoted:
    """A header: its source (repository and path, or `ours`), the line, its separator, the line of
    units, what its columns hold, and the needed quantities that it has no column for (the begin of
    what is said)."""

    source: str
    line: str
    holds: dict[str, str]
    asks: tuple[str, ...] = ()
    mark: str = ","
    units: str = ""
    questions: tuple[str, ...] = field(default=())

    @property
    def names(self) -> list[str]:
        return [name.strip() for name in self.line.split(None if self.mark == " " else self.mark)]


_ONSPEED = {
    "timeStamp": "time_ms", "Palt": "~pressure_altitude_ft", "IAS": "indicated_airspeed_kt",
    "OAT": "air_temperature_degc", "TAS": "~true_airspeed_kt", "PStatic": "static_pressure_hpa",
    "Altitude": "~altitude_ft",
}  # fmt: skip
_GARMIN = {
    "Lcl Date": "date", "Lcl Time": "clock", "BaroA": "altimeter_setting_inhg", "OAT": "air_temperature_degc",
    "IAS": "indicated_airspeed_kt", "GndSpd": "ground_speed_kt", "TRK": "track_deg", "HDG": "heading_deg",
    "MagVar": "magnetic_variation_deg", "AltMSL": "~altitude_ft", "AltGPS": "~altitude_ft",
    "TAS": "~true_airspeed_kt", "Latitude": "~latitude_deg", "Longitude": "~longitude_deg",
}  # fmt: skip


def _ours(holds: dict[str, str], asks: tuple[str, ...] = (), mark: str = ",") -> Quoted:
    """A header made here, all of whose columns hold something."""
    return Quoted("ours", mark.join(holds), holds, asks, mark)


_MAGNETIC = ("TRK: is it true, or magnetic", "HDG: is it true, or magnetic")

QUOTED: dict[str, Quoted] = {
    "OnSpeed with an inertial system": Quoted(
        "flyonspeed/OnSpeed-Gen3 docs/site/docs/reference/log-columns.md",
        ONSPEED + VN300 + DERIVED,
        {**_ONSPEED, "vnVelNedNorth": "velocity_north_mps", "vnVelNedEast": "velocity_east_mps",
         "vnGnssVelNedNorth": "~velocity_north_mps", "vnGnssVelNedEast": "~velocity_east_mps",
         "vnTimeUTC": "minutes"},
        questions=("vnVelNedNorth: or is it 'vnGnssVelNedNorth'",),
    ),
    "OnSpeed with a display": Quoted(
        "flyonspeed/OnSpeed-Gen3 docs/site/docs/reference/log-columns.md",
        ONSPEED + EFIS + DERIVED,
        {**_ONSPEED, "efisIAS": "~indicated_airspeed_kt", "efisOAT": "~air_temperature_degc"},
        NO_DIRECTION,
    ),
    "DLR ATTAS": Quoted(
        "josemiguelbento/UAV-OAT-controlo "
        "RVJategaonkar_codes_2ed/flt_data/fAttas_qst01_withHeader.asc",
        ATTAS,
        {"T": "time_s", "VCAS": "calibrated_airspeed_mps", "PSTAT": "static_pressure_pa", "PHLAT": "latitude_deg",
         "LALON": "longitude_deg", "SAT": "air_temperature_k", "VTASCG": "~true_airspeed_mps", "MACH": "~mach"},
        (), " ", ATTAS_UNITS,
    ),
    "DLR HFB 320": Quoted(
        "josemiguelbento/UAV-OAT-controlo "
        "RVJategaonkar_codes_2ed/flt_data/hfb320_1_10_withHeader.asc",
        HFB,
        {"T": "time_s", "PDYN": "impact_pressure_pa", "TASCG": "~true_airspeed_mps"},
        ("static_pressure or pressure_altitude", *NO_DIRECTION), " ", HFB_UNITS,
    ),
    "T-38, a level acceleration": Quoted(
        "jorgec00/tps_py_tools Performance/5-2-25-1/LA_90_15K_5-2-1.csv",
        "Time (s),Airspeed (KCAS),Altitude (ft),Temperature (C),Fuel (thousand lbs)",
        {"Time (s)": "time_s", "Airspeed (KCAS)": "calibrated_airspeed_kt",
         "Temperature (C)": "air_temperature_degc", "Altitude (ft)": "~pressure_altitude_ft"},
        ("static_pressure or pressure_altitude", *NO_DIRECTION),
        questions=("Altitude (ft): is it the height by GPS, or a pressure altitude "
                   "(pressure_altitude_ft)",),
    ),
    "T-38, JMOSS": Quoted(
        "SaguaroAerospaceResearch/JMOSS CLASS55.csv",
        "time_s,north_vel_fps,east_vel_fps,down_vel_fps,height_ft,total_pres_psi,static_pres_psi,total_temp_K,"
        "aoa_rad,"
        "aos_rad,roll_angle_rad,pitch_angle_rad,true_heading_rad",
        {"time_s": "time_s", "north_vel_fps": "velocity_north_fps", "east_vel_fps": "velocity_east_fps",
         "down_vel_fps": "velocity_down_fps", "height_ft": "altitude_ft", "total_pres_psi": "total_pressure_psi",
         "static_pres_psi": "static_pressure_psi", "total_temp_K": "total_temperature_k",
         "true_heading_rad": "heading_rad"},
    ),
    "C172S, G1000": Quoted(
        "travisdesell/ngafid2.0 resources/example_data/C172/log_110812_095915_KCKN.csv",
        G1000, {**_GARMIN, "AltB": "indicated_altitude_ft"}, questions=_MAGNETIC,
    ),
    "PA-28, GIFD": Quoted(
        "travisdesell/ngafid2.0 ProximityTestFlights.zip",
        G1000.replace("AltB", "AltInd"), {**_GARMIN, "AltInd": "indicated_altitude_ft"}, questions=_MAGNETIC,
    ),
    "Dynon FlightDEK-D180": Quoted(
        "VictorPetitAviation/Dynon_DataVisualisation "
        "data/raw/FlightDEK-D180_sn1878_20250731_datalog.csv",
        D180,
        {"airspeed": "indicated_airspeed_kt", "altitude": "~altitude_ft", "oat": "air_temperature_degc",
         "heading": "heading_deg"},
        ("time", "static_pressure or pressure_altitude", *NO_DIRECTION), ";",
    ),
    "a controller's simulation": Quoted(
        "ignmiz/ATC_Console log/readme.txt",
        ATC_CONSOLE,
        {"Time, s": "time_s", "Static air pressure (ISA), "
                              "Pa": "static_pressure_pa", "Mach number": "mach",
         "Static temperature (ISA), K": "air_temperature_k", "Longitude, deg": "longitude_deg",
         "Latitude, deg": "latitude_deg", "True airspeed, kt": "~true_airspeed_kt",
         "Target speed TAS, kt": "~true_airspeed_kt", "Target altitude, ft": "~altitude_ft"},
        (), ";",
    ),
    "Citation, FTIS": Quoted(
        "Patpat98/SVV_FD_B23 Mat/",
        FTIS,
        {"Gps_utcSec": "time_s", "Dadc1_cas": "calibrated_airspeed_kt", "Dadc1_alt": "pressure_altitude_ft",
         "Dadc1_sat": "~air_temperature_degc", "Gps_lat": "latitude_deg", "Gps_long": "longitude_deg",
         "Dadc1_bcAlt": "~indicated_altitude_ft", "Dadc1_tas": "~true_airspeed_kt", "Dadc1_mach": "~mach",
         "Dadc1_tat": "total_temperature_degc"},
    ),
    "ALFA, a drone": Quoted(

               "zampierida98/anomaly-detection "
        "datasets/ALFA_INTERPOLATED/carbonZ_2018-07-18-15-53-31_1_engine_failure.csv",
        ALFA,
        {"time": "stamp", "airspeed": "indicated_airspeed_mps", "groundspeed": "ground_speed_mps",
         "altitude": "altitude_m"},
        ("static_pressure or pressure_altitude", "velocity_east or track"),
    ),
    "FlySight": Quoted(
        "sco1/pyflysight doc/data_format.md",
        "time,lat,lon,hMSL,velN,velE,velD,hAcc,vAcc,sAcc,heading,cAcc,gpsFix,numSV",
        {"time": "stamp", "velN": "velocity_north_mps", "velE": "velocity_east_mps", "hMSL": "altitude_m",
         "lat": "~latitude_deg", "lon": "~longitude_deg"},
        ("impact_pressure or total_pressure", "static_pressure or pressure_altitude"),
        units=",(deg),(deg),(m),(m/s),(m/s),(m/s),(m),(m),(m/s),(deg),(deg),,",
    ),
    "X-Plane over the net": Quoted(
        "DigiLog-N/Data README.md",
        XPLANE.replace("|", ";"),
        {"Epoch time": "~time_ms", "lat_deg": "latitude_deg", "lon_deg": "longitude_deg", "Timestamp": "stamp",
         "alt_ftmsl": "~altitude_ft", "alt_ftagl": "~altitude_ft", "alt_ind": "~indicated_altitude_ft"},
        ("impact_pressure or total_pressure",), ";",
    ),
    "German": _ours(
        {"Zeit": "time_s", "ASI (mph)": "indicated_airspeed_mph", "Palt": "pressure_altitude_ft",
         "OAT °F": "air_temperature_degf", "GS kts": "ground_speed_kt", "Course (T)": "track_deg"}
    ),
    "a pilot's own": _ours(
        {"clock": "time_s", "airspeed": "indicated_airspeed_kt", "press. height": "pressure_altitude_ft",
         "outside temp": "air_temperature_degc", "ground speed": "ground_speed_kt",
         "trk mag": "magnetic_track_deg"},
    ),
    "units run into the names": _ours(
        {"t_ms": "time_ms", "VelN_ms": "velocity_north_mps", "VelE_ms": "velocity_east_mps",
         "VelD_ms": "velocity_down_mps", "qc_Pa": "impact_pressure_pa", "Ps_hPa": "static_pressure_hpa",
         "OAT_C": "air_temperature_degc", "h_m": "altitude_m"},
    ),
    "by position": _ours(
        {"seconds": "time_s", "KIAS": "indicated_airspeed_kt", "PressAlt ft": "pressure_altitude_ft",
         "OAT degC": "air_temperature_degc", "lat": "latitude_deg", "lon": "longitude_deg",
         "GPS alt ft": "altitude_ft"},
    ),
    "a glider's": _ours(
        {"Time [s]": "time_s", "TAS [km/h]": "true_airspeed_kmh", "Press. Altitude [m]": "pressure_altitude_m",
         "OAT [°C]": "air_temperature_degc", "Ground speed [km/h]": "ground_speed_kmh",
         "True course [°]": "track_deg", "Alt GPS [m]": "altitude_m"},
        mark=";",
    ),
    "magnetic course in brackets": _ours(
        {"UTC": "clock", "IAS (kt)": "indicated_airspeed_kt", "Pressure Altitude (ft)": "pressure_altitude_ft",
         "SAT (C)": "air_temperature_degc", "Gnd Spd (kt)": "ground_speed_kt", "Course (M)": "magnetic_track_deg",
         "MagVar (deg)": "magnetic_variation_deg"},
    ),
    "French": _ours(
        {"temps": "time_s", "Vi (kt)": "indicated_airspeed_kt", "Zp (ft)": "pressure_altitude_ft",
         "temperature (C)": "air_temperature_degc", "GS (kt)": "ground_speed_kt", "COG (deg)": "track_deg"},
    ),
    "a card of Mach": _ours(
        {"elapsed_s": "time_s", "Mach": "mach", "static_press_psi": "static_pressure_psi",
         "TAT_degC": "total_temperature_degc", "north_vel_fps": "velocity_north_fps",
         "east_vel_fps": "velocity_east_fps"},
    ),
    "no direction": _ours(
        {"time_stamp_s": "time_s", "IAS_kt": "indicated_airspeed_kt", "Press_Alt_ft": "pressure_altitude_ft",
         "GS_kt": "ground_speed_kt", "HDG_true_deg": "heading_deg"},
        ("velocity_east or track",),
    ),
    "two clocks": _ours(
        {"utc": "minutes", "boot_time_ms": "time_ms", "qc_inhg": "impact_pressure_inhg",
         "ps_inhg": "static_pressure_inhg", "oat_c": "air_temperature_degc", "vn_mps": "velocity_north_mps",
         "ve_mps": "velocity_east_mps"},
    ),
}  # fmt: skip


def write_quoted(path: Path, quoted: Quoted) -> Path:
    """Write the flight under a header."""
    mark = "," if quoted.mark == " " else quoted.mark
    columns = [_cells(quoted.holds.get(name, ""), k) for k, name in enumerate(quoted.names)]
    lines = [mark.join(f'"{name}"' if mark in name else name for name in quoted.names)]
    if quoted.units:
        lines.append(mark.join(quoted.units.split(None if quoted.mark == " " else quoted.mark)))
    lines += [mark.join(row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def _cells(holds: str, number: int) -> list[str]:
    if holds in ("clock", "date", "stamp", "minutes"):
        form = {
            "clock": "%H:%M:%S",
            "date": "%Y-%m-%d",
            "stamp": "%Y-%m-%dT%H:%M:%S.%fZ",
            "minutes": "%M:%S",
        }[holds]
        step = 50.0 if holds == "minutes" else 1.0  # whole minutes that run back after the hour
        return [f"{foreign.clock(step * second):{form}}" for second in range(foreign.ROWS)]
    if not holds:  # a number without a meaning, different in each column
        return [f"{x:.4f}" for x in np.random.default_rng(number).uniform(-1.0, 1.0, foreign.ROWS)]
    name, _, unit = (
        holds.removeprefix("~").rpartition("_") if holds.lstrip("~") != "mach" else ("mach", "", "")
    )
    return [repr(float(x)) for x in (from_si(_flown(name), unit) if unit else _flown(name))]


def _flown(name: str) -> Array:
    """A quantity of the flight [SI]."""
    flown = foreign.flight()
    q, p, cold = flown["impact_pressure"], flown["static_pressure"], flown["air_temperature"]
    north, east = flown["velocity_north"], flown["velocity_east"]
    setting = foreign.SETTING * INCH_OF_MERCURY
    mach = air.mach_from_impact_pressure(q, p)
    formed = {
        "mach": mach,
        "total_pressure": p + q,
        "indicated_airspeed": air.calibrated_airspeed(q),
        "calibrated_airspeed": air.calibrated_airspeed(q),
        "true_airspeed": air.true_airspeed(q, p, cold),
        "total_temperature": air.total_temperature(cold, mach),
        "pressure_altitude": air.pressure_altitude(p),
        "indicated_altitude": air.pressure_altitude(p) - air.pressure_altitude(setting),
        "altimeter_setting": np.full(foreign.ROWS, setting),
        "ground_speed": np.hypot(north, east),
        "track": np.arctan2(east, north) % (2.0 * np.pi),
        "magnetic_track": (np.arctan2(east, north) - 3.0 * DEGREE) % (2.0 * np.pi),
        "magnetic_variation": np.full(foreign.ROWS, 3.0 * DEGREE),
        # Near 47° a radian of latitude is 6,370 km and one of longitude 4,358 km (WGS 84).
        "latitude": 47.0 * DEGREE + np.cumsum(north) / 6.370e6,
        "longitude": 8.0 * DEGREE + np.cumsum(east) / 4.358e6,
    }
    return np.asarray(formed[name] if name in formed else flown[name])
