"""The names that the field gives to the quantities of a flight log, and the words for its units.

Sources: parameter lists of instrumented airplanes (JMOSS, SIDPAC), of research airplanes (IWG1,
NCAR, FAAM), of flight recorders (ARINC 717), of displays (Garmin, Dynon, Avidyne), and of
autopilots (PX4, ArduPilot, INAV).
"""

from pitotbench.units import SUFFIXES

# Quantity: names without unit, in lower case, words without separators. The first is the plainest.
# A name with a minus sign counts the other way.
SYNONYMS: dict[str, str] = {
    "time": (
        "time t timestamp elapsedtime sessiontime missiontime irigtime irig deltairig utc "
        "milliseconds totltime missntime utctime gpstime clock localtime datetime epoch unixtime "
        "seconds sec timesincestart realtime reltime tow utcsec missntime zeit uhrzeit temps heure "
        "tiempo hora millis lcltime logtime systemtime elapsed boottime simtime simt totltime"
    ),
    "date": "date localdate lcldate utcdate day datum fecha",
    "impact_pressure": (
        "impactpressure pd qc qci qcic qcx qrvsm dynamicpressure dynpress differentialpressure "
        "diffpress diffpres diffpressure deltapressure deltap pitotdp dp pdiff pdyn q "
        "pitotpressure qcr qciadc airspeedpressure pfwdsmoothed"
    ),
    "total_pressure": (
        "totalpressure pt ptot ptotal pti ptadc totalpress totalpres pitottotal p0 pto "
        "pitottotalpressure"
    ),
    "static_pressure": (
        "staticpressure ps psx psxc pstatic pstat psi psm psa psadc staticpress staticpres "
        "baropres pambient baropressure ambientpressure barometricpressure abspressure "
        "absolutepressure p press pressure psrvsm psfrd pamb"
    ),
    "indicated_airspeed": (
        "indicatedairspeed ias kias vi vias iasadc airspeedindicated asi iaskts aspd airspd "
        "indairspeed airspeedic airspeed vindkias vind viadc indspeed indicatedspeed"
    ),
    "calibrated_airspeed": (
        "calibratedairspeed cas kcas vc vcas computedairspeed casadc vcal airspeedcas vcadc"
    ),
    "pressure_altitude": (
        "pressurealtitude pressalt pressurealt palt hp hpc hpi altp pa pressalitude pressheight "
        "pressureheight pressurehgt dadcalt adcalt dadcaltitude adcaltitude altitudepressure "
        "pressaltitude altpressure altitudeic bcalt zp alt29 altstd altitudeqne hic altitudestd "
        "baroaltstd"
    ),
    "true_airspeed": (
        "trueairspeed tas ktas vtas vtrue tasadc truespeed vtruekt airspeedtrue vtotal"
    ),
    "mach": "mach machnumber machno machnum",
    "indicated_altitude": (
        "indicatedaltitude dadcbcalt altind altb baroalt baroaltitude baroaltcorrected altbaro "
        "altitudeqnh"
    ),
    "height_above_takeoff": (
        "heightabovetakeoff relativealtitude altituderelative relalt altrel relativealt "
        "heightrelative relheight heightabovehome altabovehome"
    ),
    "altimeter_setting": (
        "altimetersetting barosetting baroa qnh kollsman baroset altimeter barometersetting"
    ),
    "total_temperature": (
        "totaltemperature totaltemp tat tt ttx ttot totalairtemperature tti t0 tatdir totalairtemp "
        "rat"
    ),
    "air_temperature": (
        "airtemperature oat sat outsideairtemperature outsideairtemp ambienttemperature "
        "ambienttemp statictemperature statictemp staticairtemperature staticairtemp ta atx tamb "
        "temperature airtemp temp ambtemp amtmp outsidetemp outtemp exttemp externaltemp airt tair "
        "lufttemperatur"
    ),
    "velocity_north": (
        "velocitynorth velnorth vnvelnorth vn vnorth northvelocity northvel veln speednorth "
        "velworldz velocityworldz gpsvelned0 velned0 navvel0 velnorth nvel vns nsvel nsvelocity "
        "northspeed ggvns velngin vinsnorth uground gpsveln vgn northveln velocityn vngps"
    ),
    "velocity_east": (
        "vnveleast velocityeast ve veast eastvelocity eastvel vele veleast evel vew speedeast "
        "velworldx velocityworldx gpsvelned1 velned1 navvel1 ewvel ewvelocity eastspeed ggvew "
        "velegin vinseast vground gpsvele vge velocitye"
    ),
    "velocity_down": (
        "vnveldown velocitydown vd vdown downvelocity downvel veld veldown veldgin -velocityu "
        "-velocityworldy -velworldy downspeed gpsveld vgd velocityd -velocityup -vu -vup "
        "-upvelocity -upvel -velu -velup -ggvspd -gpsvelu"
    ),
    "ground_speed": (
        "groundspeed gs vg gndspd gspd grndspd grdspd gpsspeed speedoverground sog groundvelocity "
        "groundspd gpsgroundspeed gndspeed gpsspd spd ggspd ktgs gpsgs gsc grspd"
    ),
    "track": (
        "track trk groundtrack tracktrue truetrack trackangle trackangletrue trkt trktrue cog "
        "hpathtrue hpath courseoverground course truecourse coursetrue gcrs gpstrack gpscourse "
        "groundcourse tk tka gpsgroundcourse gpsgroundtrack ttrk trackangletr"
    ),
    "magnetic_track": (
        "magnetictrack magneticcourse coursemag coursemagnetic magcourse trackmag trkm trkmag "
        "magtrack trackmagnetic trackanglemag"
    ),
    "heading": (
        "heading hdg trueheading thdg truehdg psi yaw headingtrue hdgt hdgtrue thead hdgin "
        "hdingtrue hding hdggin"
    ),
    "magnetic_heading": (
        "magneticheading magheading maghdg mhdg hdgm hdgmag headingmag hdingmag headingmagnetic"
    ),
    "magnetic_variation": "magneticvariation magvar variation magdec declination",
    "latitude": "latitude gpscoord0 lat phlat gpslat gpslatitude latdeg gnsslat gpsla",
    "longitude": (
        "longitude lon long lalon lng gpslon gpslong gpslongitude londeg gnsslon gpslo gpscoord1"
    ),
    "altitude": (
        "altitude alt gpsalt altgps gpsaltitude height hmsl altmsl altitudemsl geometricaltitude "
        "gpsheight gpsmslalt ggalt altgin mslalt elevation heightmsl egialt h hgps altftmsl "
        "gpsaltmsl"
    ),
    "roll": "roll phi bank rollangle bankangle rollatt rollattitude rollgin rolldeg",
    "pitch": "pitch theta pitchangle pitchatt pitchattitude ptchgin pitchgin pitchdeg",
    "roll_rate": "rollrate p pb rollr bodyrollrate xrate gyrox angularrateroll",
    "pitch_rate": "pitchrate qb pitchr bodypitchrate yrate gyroy angularratepitch",
    "yaw_rate": "yawrate r rb yawr bodyyawrate zrate gyroz angularrateyaw",
    "angle_of_attack": "angleofattack aoa alpha alfa aoavane alphavane angleattack",
    "sideslip": "sideslip beta aos ssa sideslipangle betavane angleofsideslip",
    "mass": "mass weight grossweight gw grosswt aircraftmass",
}

# Unit suffix: how else than by its suffix, symbol or name the field writes it, in lower case
# without blanks.
_SPELLINGS: dict[str, str] = {
    "s": "sec secs second",
    "ms": "msec millis",
    "pa": "pascal n/m2 n/m^2",
    "hpa": "mb mbar millibar millibars",
    "kpa": "kilopascal",
    "psi": "psia psid lb/in2 lbf/in2",
    "inhg": "in.hg inchhg hg inch inches",
    "psf": "lb/ft2 lbf/ft2 lbs_sqft",
    "mmhg": "torr",
    "inh2o": "inchh2o in.h2o",
    "k": "kelvin degk",
    "degc": "c degsc celsius deg_c degreesc",
    "degf": "f *f fahrenheit deg_f",
    "degr": "r rankine",
    "mps": "ms m/sec ms-1 m.s-1 metres/second meters/second m_s",
    "kt": "kts knot kn",
    "fps": "ft/sec feet/second",
    "mph": "mi/h",
    "kmh": "kph",
    "fpm": "feet/min",
    "m": "meter metre metres",
    "ft": "foot ftmsl ftbaro ftwgs",
    "rad": "radian rads",
    "deg": "degree degt degm degtrue degmag degrees_true",
    "radps": "rad/sec",
    "degps": "deg/s deg/sec",
    "kg": "kilogram",
    "lb": "lbs pound",
}
UNIT_WORDS: dict[str, list[str]] = {
    suffix: [suffix, unit.symbol.lower(), unit.words.lower().replace(" ", ""), *more.split()]
    for suffix, more in _SPELLINGS.items()
    for unit in (SUFFIXES[suffix],)
}
SCALED: dict[
    str, tuple[str, float]
] = {  # units of no suffix: the suffix, and its size in that unit's
    "us": ("s", 1e-6),
    "usec": ("s", 1e-6),
    "microseconds": ("s", 1e-6),
    "cm/s": ("mps", 0.01),
    "mm/s": ("mps", 1e-3),
    "cm": ("m", 0.01),
    "mm": ("m", 1e-3),
    "1e-2deg": ("deg", 0.01),
    "cdeg": ("deg", 0.01),
}

# Where a name does not say its unit: what the field writes, the most usual first.
USUAL_UNITS: dict[str, tuple[str, ...]] = {
    "time": ("s", "ms"),
    "impact_pressure": ("pa", "hpa", "kpa", "psi", "psf", "inhg"),
    "total_pressure": ("pa", "hpa", "kpa", "psi", "psf", "inhg"),
    "static_pressure": ("pa", "hpa", "kpa", "psi", "psf", "inhg"),
    "altimeter_setting": ("inhg", "hpa"),
    "indicated_airspeed": ("kt", "mps", "mph", "kmh"),
    "calibrated_airspeed": ("kt", "mps", "mph", "kmh"),
    "ground_speed": ("kt", "mps", "mph", "kmh"),
    "velocity_north": ("mps", "kt", "fps"),
    "velocity_east": ("mps", "kt", "fps"),
    "velocity_down": ("mps", "fps", "fpm"),
    "true_airspeed": ("kt", "mps", "mph", "kmh"),
    "pressure_altitude": ("ft", "m"),
    "indicated_altitude": ("ft", "m"),
    "height_above_takeoff": ("m", "ft"),
    "altitude": ("ft", "m"),
    "total_temperature": ("degc", "k", "degf"),
    "air_temperature": ("degc", "k", "degf"),
    "mass": ("kg", "lb"),
}
# What a drone writes as whole numbers where no usual unit fits: the unit, and their size in it.
AS_INTEGERS: dict[str, tuple[str, float]] = {
    "time": ("s", 1e-6),
    "indicated_airspeed": ("mps", 0.01),
    "ground_speed": ("mps", 0.01),
    "latitude": ("deg", 1e-7),
    "longitude": ("deg", 1e-7),
}
ANGLES = ("deg", "rad")
RATES = ("degps", "radps")
