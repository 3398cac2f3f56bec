"""Effects of the air: humidity, temperature, turbulence, and a wind that changes."""

from math import pi

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import (
    CHANGING_HEIGHT,
    ELAPSED,
    STEADY_LEGS,
    TEMPERATURE,
    TURNING,
    AirEffect,
    Effect,
    Parameter,
    SensorEffect,
    Sizes,
    clipped,
    elapsed,
)
from pitotbench.effects.overlay import (
    Baseline,
    Expression,
    Overlay,
    WindTerm,
    difference,
    operation,
    product,
    quotient,
    size,
    total,
)
from pitotbench.effects.response import Signals
from pitotbench.units import FOOT, Array, Kelvin, Pascal

# Humid air: it is as light as drier air that is warmer, and the thermometer reads less than that warmth.

FREEZING = 273.15  # K
LIGHTER = 0.378  # 1 − molar mass of water over that of dry air, 1 − 18.015/28.964
ROUNDS = 4  # of solving for the temperature that has this virtual temperature; each gains a digit or more


def saturation_pressure(temperature: Kelvin) -> Pascal:
    """Return the saturation pressure of water vapor [Pa] at a temperature [K], to 0.3 % from -35 to 35 °C.

    Source: Bolton 1980, Monthly Weather Review 108, eq. 10.
    """
    celsius = temperature - FREEZING
    return np.asarray(611.2 * np.exp(17.67 * celsius / (celsius + 243.5)))


def _dry_bulb(virtual: Kelvin, pressure: Pascal, humidity: float) -> Array:
    """Return the temperature [K] of air of a virtual temperature, T_v = T/(1 − 0.378 e/p)."""
    temperature = virtual
    for _ in range(ROUNDS):
        vapor = humidity * saturation_pressure(temperature)
        temperature = virtual * (1.0 - LIGHTER * vapor / pressure)
    return temperature


def _humid(signals: Signals, sizes: Sizes) -> Signals:
    pressure = signals["static_pressure"]
    mach = air.mach_from_impact_pressure(signals["impact_pressure"].clip(min=0.0), pressure)
    virtual = air.air_temperature(signals["total_temperature"], mach)
    read = air.total_temperature(_dry_bulb(virtual, pressure, sizes["relative_humidity"]), mach)
    return signals.with_channels(total_temperature=read)


HUMID_AIR = SensorEffect(
    name="humid_air",
    part="air",
    parameters=(Parameter("relative_humidity", 0.7, 0.02, 1.0, "vapor pressure over that of saturation"),),
    source="Bolton 1980, Monthly Weather Review 108, eq. 10: saturation pressure; T_v = T/(1 − 0.378 e/p)",
    what="The air is humid: the temperature of the case is the virtual one, and the probe reads less.",
    shows_in=TEMPERATURE,
    changes=("total_temperature",),
    needs=("impact_pressure", "static_pressure"),
    function=_humid,
)


# Air that is warmer or colder than the case says, at all heights.


def _build_nonstandard_temperature(sizes: Sizes, baseline: Baseline) -> Overlay:
    return Overlay(temperature_offset=sizes["warmer_k"])


NONSTANDARD_TEMPERATURE = AirEffect(
    name="nonstandard_temperature",
    part="thermometer, or the day",
    parameters=(Parameter("warmer_k", 10.0, -40.0, 40.0, "temperature above that of the case"),),
    source="ISO 2533 standard atmosphere and its hot and cold days (MIL-STD-210)",
    what="The air is warmer or colder than the case says: power, true airspeed and heights change.",
    shows_in=CHANGING_HEIGHT,
    build=_build_nonstandard_temperature,
)


# A front passes, and the wind changes from one vector to another within seconds.


def _build_sea_breeze_front(sizes: Sizes, baseline: Baseline) -> Overlay:
    north, east, at, width = SEA_BREEZE_FRONT.paths()
    # The step is a ramp of the given width, held at 0 before it and at 1 after it. JSBSim's winds are in ft/s.
    share = clipped(quotient(difference(ELAPSED, at), width))
    winds = tuple(
        WindTerm(toward, product(path, 1.0 / FOOT, share)) for toward, path in (("north", north), ("east", east))
    )
    return Overlay(sizes=SEA_BREEZE_FRONT.held(sizes), winds=winds)


def _wind_sea_breeze_front(signals: Signals, sizes: Sizes) -> tuple[Array, Array, Array]:
    share = np.clip((elapsed(signals) - sizes["at_s"]) / sizes["width_s"], 0.0, 1.0)
    return sizes["north_mps"] * share, sizes["east_mps"] * share, np.zeros_like(share)


SEA_BREEZE_FRONT = AirEffect(
    name="sea_breeze_front",
    part="air",
    parameters=(
        Parameter("north_mps", 2.5, -20.0, 20.0, "step of the wind toward north"),
        Parameter("east_mps", -2.0, -20.0, 20.0, "step of the wind toward east"),
        Parameter("at_s", 120.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True),
        Parameter("width_s", 10.0, 0.5, 600.0, "duration of the change", shape=True),
    ),
    source="Simpson 1994, Sea Breeze and Local Winds: changes of 2 to 8 m/s across some hundred meters",
    what="A front passes, and the wind changes within seconds.",
    shows_in=TURNING,
    build=_build_sea_breeze_front,
    wind=_wind_sea_breeze_front,
)


# Gusts that are stronger or weaker than the case says, with the same spectrum.


def _build_turbulence_level(sizes: Sizes, baseline: Baseline) -> Overlay:
    # JSBSim's gusts stay as they are; a share of them is added as a further wind.
    winds = tuple(
        WindTerm(toward, product(*TURBULENCE_LEVEL.paths(), f"atmosphere/turb-{toward}-fps"))
        for toward in ("north", "east", "down")
    )
    return Overlay(sizes=TURBULENCE_LEVEL.held(sizes), winds=winds)


TURBULENCE_LEVEL = AirEffect(
    name="turbulence_level",
    part="air",
    parameters=(Parameter("change", 0.5, -1.0, 3.0, "gusts stronger by this share; -1 removes them"),),
    source="MIL-F-8785C 1980, §3.7: root-mean-square intensities, light to severe",
    what="The gusts are stronger or weaker than the case says; rotational gusts (p, q, r) stay the same.",
    shows_in=STEADY_LEGS,  # nothing but gusts moves the airplane there
    build=_build_turbulence_level,
)


# Gusts of another length: the spectrum keeps its strength and moves in frequency.
# Dryden's gust along the path is white noise through 1/(1 + L s/V). A lead-lag filter (1 + L s/V)/(1 + L' s/V)
# with a gain of sqrt(L'/L) therefore gives exactly the gust of length L'. For the gusts across the path it is
# close.

LENGTH = 1750.0  # ft, of MIL-F-8785C above 2,000 ft
_CHANGE, _OLD, _NEW = (size("turbulence_scale", name) for name in ("change", "time_s", "new_time_s"))


def _component(name: str, value: Expression) -> str:
    return f'<fcs_function name="{name}"><function>{value}</function></fcs_function>'


def _filter(toward: str) -> str:
    return (
        f'<lead_lag_filter name="{size("turbulence_scale", toward)}"><input>atmosphere/turb-{toward}-fps</input>'
        f"<c1>{_OLD}</c1><c2>1.0</c2><c3>{_NEW}</c3><c4>1.0</c4></lead_lag_filter>"
    )


def _unless_off(value: Expression) -> Expression:
    """Return an expression that is exactly zero at zero change, where the filter would leave a rounding error."""
    return operation("ifthen", operation("eq", _CHANGE, 0.0), 0.0, value)


def _build_turbulence_scale(sizes: Sizes, baseline: Baseline) -> Overlay:
    directions, grown = ("north", "east", "down"), total(1.0, _CHANGE)
    time = quotient(LENGTH, operation("max", 100.0, "velocities/vt-fps"))
    root = operation("sqrt", grown)
    return Overlay(
        sizes=TURBULENCE_SCALE.held(sizes),
        filters=(
            _component(_OLD, time),
            _component(_NEW, product(_OLD, grown)),
            *(_filter(toward) for toward in directions),
        ),
        winds=tuple(
            WindTerm(
                t,
                _unless_off(difference(product(root, size("turbulence_scale", t)), f"atmosphere/turb-{t}-fps")),
            )
            for t in directions
        ),
    )


TURBULENCE_SCALE = AirEffect(
    name="turbulence_scale",
    part="air",
    parameters=(Parameter("change", -0.6, -0.9, 3.0, "gusts longer by this share"),),
    source="MIL-F-8785C 1980, §3.7.2: Dryden spectra, 1,750 ft above 2,000 ft",
    what="The gusts are longer or shorter than the case says.",
    shows_in=STEADY_LEGS,  # long gusts need long legs
    build=_build_turbulence_scale,
)


# Rising or sinking air for some time, with edges of a few seconds.

EDGE = 5.0  # s: a thermal's edge of some 300 m at 120 kt; an instant step would be no flow of air


def _build_updraft(sizes: Sizes, baseline: Baseline) -> Overlay:
    up, begin, last = UPDRAFT.paths()
    rise = quotient(difference(ELAPSED, begin), EDGE)
    fall = quotient(difference(total(begin, last), ELAPSED), EDGE)
    share = clipped(operation("min", rise, fall))
    wind = WindTerm("down", product(up, -1.0 / FOOT, share))
    return Overlay(sizes=UPDRAFT.held(sizes), winds=(wind,))


def _wind_updraft(signals: Signals, sizes: Sizes) -> tuple[Array, Array, Array]:
    since = elapsed(signals) - sizes["from_s"]
    share = np.clip(np.minimum(since, sizes["for_s"] - since) / EDGE, 0.0, 1.0)
    return np.zeros_like(since), np.zeros_like(since), -sizes["up_mps"] * share


UPDRAFT = AirEffect(
    name="updraft",
    part="air",
    parameters=(
        Parameter("up_mps", 1.0, -10.0, 10.0, "speed of the rising air"),
        Parameter("from_s", 60.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True),
        Parameter("for_s", 60.0, 5.0, 1e5, "duration", shape=True),
    ),
    source="mountain waves and thermals: 1 to 5 m/s over kilometers (FAA Glider Flying Handbook, ch. 9)",
    what="The airplane flies through rising or sinking air.",
    shows_in=STEADY_LEGS,  # power and height are held, so that only the air rises
    build=_build_updraft,
    wind=_wind_updraft,
)


# A wind that changes steadily during the flight.

MINUTE = 60.0  # s


def _build_wind_drift(sizes: Sizes, baseline: Baseline) -> Overlay:
    winds = tuple(
        WindTerm(toward, product(path, 1.0 / (MINUTE * FOOT), ELAPSED))
        for toward, path in zip(("north", "east"), WIND_DRIFT.paths(), strict=True)
    )
    return Overlay(sizes=WIND_DRIFT.held(sizes), winds=winds)


def _wind_wind_drift(signals: Signals, sizes: Sizes) -> tuple[Array, Array, Array]:
    minutes = elapsed(signals) / MINUTE
    return sizes["north_mps_per_min"] * minutes, sizes["east_mps_per_min"] * minutes, np.zeros_like(minutes)


WIND_DRIFT = AirEffect(
    name="wind_drift",
    part="air",
    parameters=(
        Parameter("north_mps_per_min", 0.15, -2.0, 2.0, "change of the wind toward north, per minute"),
        Parameter("east_mps_per_min", -0.10, -2.0, 2.0, "change of the wind toward east, per minute"),
    ),
    source="Martos, Kiszely and Foster 2011: the methods take the wind as constant; hourly changes of 2 to 5 m/s "
    "are usual in soundings (estimate)",
    what="The wind changes during the flight.",
    shows_in=TURNING,
    for_whole_flight=True,
    build=_build_wind_drift,
    wind=_wind_wind_drift,
)


# A wind that oscillates: waves in the lee of hills.


def _build_wind_oscillation(sizes: Sizes, baseline: Baseline) -> Overlay:
    north, east, period = WIND_OSCILLATION.paths()
    swing = operation("sin", quotient(product(2.0 * pi, ELAPSED), period))
    winds = tuple(
        WindTerm(toward, product(path, 1.0 / FOOT, swing)) for toward, path in (("north", north), ("east", east))
    )
    return Overlay(sizes=WIND_OSCILLATION.held(sizes), winds=winds)


def _wind_wind_oscillation(signals: Signals, sizes: Sizes) -> tuple[Array, Array, Array]:
    swing = np.sin(2.0 * pi * elapsed(signals) / sizes["period_s"])
    return sizes["north_mps"] * swing, sizes["east_mps"] * swing, np.zeros_like(swing)


WIND_OSCILLATION = AirEffect(
    name="wind_oscillation",
    part="air",
    parameters=(
        Parameter("north_mps", 0.8, -10.0, 10.0, "amplitude of the wind toward north"),
        Parameter("east_mps", -0.6, -10.0, 10.0, "amplitude of the wind toward east"),
        Parameter("period_s", 400.0, 20.0, 7200.0, "period of the oscillation, which begins at zero", shape=True),
    ),
    source="Holton 2004, Dynamic Meteorology: trapped lee waves of 5 to 25 km, met in minutes of flight",
    what="The wind oscillates during the flight.",
    shows_in=TURNING,  # each circle measures the wind anew
    variant_of="wind_drift",
    build=_build_wind_oscillation,
    wind=_wind_wind_oscillation,
)


# A wind that changes with height.

KILOMETER = 1000.0  # m


def _build_wind_shear(sizes: Sizes, baseline: Baseline) -> Overlay:
    north, east, reference = WIND_SHEAR.paths()
    above = difference(product("position/h-sl-ft", FOOT), reference)
    winds = tuple(
        WindTerm(toward, product(path, above, 1.0 / (KILOMETER * FOOT)))
        for toward, path in (("north", north), ("east", east))
    )
    return Overlay(sizes=WIND_SHEAR.held(sizes), winds=winds)


def _wind_wind_shear(signals: Signals, sizes: Sizes) -> tuple[Array, Array, Array]:
    signals.require(WIND_SHEAR.name, ("altitude",))
    above = (signals["altitude"] - sizes["reference_m"]) / KILOMETER
    return sizes["north_mps_per_km"] * above, sizes["east_mps_per_km"] * above, np.zeros_like(above)


WIND_SHEAR = AirEffect(
    name="wind_shear",
    part="air",
    parameters=(
        Parameter("north_mps_per_km", 4.0, -50.0, 50.0, "growth of the wind toward north with height"),
        Parameter("east_mps_per_km", 6.0, -50.0, 50.0, "growth of the wind toward east with height"),
        Parameter("reference_m", 1828.8, 0.0, 15000.0, "height of the steady wind", shape=True),
    ),
    source="thermal wind, a few m/s a kilometer (Holton 2004, Dynamic Meteorology); more below inversions",
    what="The wind changes with height.",
    shows_in=CHANGING_HEIGHT,
    build=_build_wind_shear,
    wind=_wind_wind_shear,
)


# The order of this page's effects in every table.
AIR: tuple[Effect, ...] = (
    HUMID_AIR,
    NONSTANDARD_TEMPERATURE,
    SEA_BREEZE_FRONT,
    TURBULENCE_LEVEL,
    TURBULENCE_SCALE,
    UPDRAFT,
    WIND_DRIFT,
    WIND_OSCILLATION,
    WIND_SHEAR,
)
