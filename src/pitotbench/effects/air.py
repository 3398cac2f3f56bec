"""Effects of the air: humidity, temperature, turbulence, and a wind that changes."""

from collections.abc import Callable
from math import pi

import numpy as np

from pitotbench import air
from pitotbench.effects.effect import (
    CHANGING_HEIGHT,
    ELAPSED,
    STEADY_LEGS,
    TEMPERATURE,
    TURNING,
    AircraftEffect,
    AirEffect,
    Build,
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
    Term,
    WindTerm,
    difference,
    operation,
    product,
    quotient,
    size,
    total,
)
from pitotbench.effects.response import Signals
from pitotbench.units import FOOT, MINUTE, Array, Kelvin, Pascal

FREEZING = 273.15  # K
LIGHTER = 0.378  # 1 − molar mass of water over that of dry air, 1 − 18.015/28.964
ROUNDS = 4  # of solving for the temperature that has this virtual temperature; each gains a digit or more


def saturation_pressure(temperature: Kelvin) -> Pascal:
    """Return the saturation pressure of water vapor [Pa] at a temperature [K], -35 to 35 °C.

    The error is at most 0.3 %.

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
    parameters=(
        Parameter("relative_humidity", 0.7, 0.02, 1.0, "vapor pressure over that of saturation"),
    ),
    source="Bolton 1980, Monthly Weather Review 108, eq. 10: saturation pressure; T_v = T/(1 − "
    "0.378 e/p)",
    what="The air is humid: the temperature of the case is the virtual one, and the probe reads "
    "less.",
    shows_in=TEMPERATURE,
    changes=("total_temperature",),
    needs=("impact_pressure", "static_pressure"),
    function=_humid,
)


NONSTANDARD_TEMPERATURE = AirEffect(
    name="nonstandard_temperature",
    part="thermometer, or the day",
    parameters=(Parameter("warmer_k", 10.0, -40.0, 40.0, "temperature above that of the case"),),
    source="ISO 2533 standard atmosphere and its hot and cold days (MIL-STD-210)",
    what="The air is warmer or colder than the case says: power, true airspeed and heights change.",
    shows_in=CHANGING_HEIGHT,
    build=lambda effect, sizes, baseline: Overlay(temperature_offset=sizes["warmer_k"]),
)


Vector = tuple[Array, Array, Array]


def _blows(factors: Callable[..., tuple[Term, ...]]) -> Build:
    """The build of a level wind, its components multiplied by `factors`.

    The `factors` are a function of the paths of the other sizes.
    """

    def build(effect: AircraftEffect, sizes: Sizes, _: Baseline) -> Overlay:
        north, east, *others = effect.paths()
        return Overlay(
            sizes=effect.properties(sizes),
            winds=tuple(
                WindTerm(toward, product(path, *factors(*others)))
                for toward, path in (("north", north), ("east", east))
            ),
        )

    return build


def _level(course: Callable[[Signals, Sizes], Array]) -> Callable[[Signals, Sizes], Vector]:
    """The same wind over a log: its first two sizes times a course, (n,)."""

    def wind(signals: Signals, sizes: Sizes) -> Vector:
        share = course(signals, sizes)
        north, east = list(sizes.values())[:2]
        return north * share, east * share, np.zeros_like(share)

    return wind


SEA_BREEZE_FRONT = AirEffect(
    name="sea_breeze_front",
    part="air",
    parameters=(
        Parameter("north_mps", 2.5, -20.0, 20.0, "step of the wind toward north"),
        Parameter("east_mps", -2.0, -20.0, 20.0, "step of the wind toward east"),
        Parameter(
            "at_s", 120.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True
        ),
        Parameter("width_s", 10.0, 0.5, 600.0, "duration of the change", shape=True),
    ),
    source="Simpson 1994, Sea Breeze and Local Winds: changes of 2 to 8 m/s across some hundred "
    "meters",
    what="A front passes, and the wind changes within seconds.",
    shows_in=TURNING,
    build=_blows(lambda at, width: (1.0 / FOOT, clipped(quotient(difference(ELAPSED, at), width)))),
    wind=_level(
        lambda log, sizes: np.clip((elapsed(log) - sizes["at_s"]) / sizes["width_s"], 0.0, 1.0)
    ),
)


TURBULENCE_LEVEL = AirEffect(
    name="turbulence_level",
    part="air",
    parameters=(
        Parameter("change", 0.5, -1.0, 3.0, "gusts stronger by this share; -1 removes them"),
    ),
    source="MIL-F-8785C 1980, §3.7: root-mean-square intensities, light to severe",
    what="The gusts are stronger or weaker than the case says; rotational gusts (p, q, r) stay "
    "the same.",
    shows_in=STEADY_LEGS,  # nothing but gusts moves the airplane there
    # JSBSim's gusts stay as they are; a share of them is added as a further wind.
    build=lambda effect, sizes, baseline: Overlay(
        sizes=effect.properties(sizes),
        winds=tuple(
            WindTerm(toward, product(*effect.paths(), f"atmosphere/turb-{toward}-fps"))
            for toward in ("north", "east", "down")
        ),
    ),
)


LENGTH = 1750.0  # ft, of MIL-F-8785C above 2,000 ft
_CHANGE, _OLD, _NEW = (
    size("turbulence_scale", name) for name in ("change", "time_s", "new_time_s")
)


def _component(name: str, value: Expression) -> str:
    return f'<fcs_function name="{name}"><function>{value}</function></fcs_function>'


def _filter(toward: str) -> str:
    return (
        f'<lead_lag_filter name="{size("turbulence_scale", toward)}"><input>atmosphere/turb-{toward}-fps</input>'
        f"<c1>{_OLD}</c1><c2>1.0</c2><c3>{_NEW}</c3><c4>1.0</c4></lead_lag_filter>"
    )


def _longer(effect: AircraftEffect, sizes: Sizes, _: Baseline) -> Overlay:
    """The gusts of another length: Dryden's along the path is white noise through 1/(1 + L s/V).

    A lead-lag filter (1 + L s/V)/(1 + L' s/V) with a gain of sqrt(L'/L) therefore gives exactly the
    gust of length L'. For the gusts across the path it is close.
    """
    directions, grown = ("north", "east", "down"), total(1.0, _CHANGE)
    time = quotient(LENGTH, operation("max", 100.0, "velocities/vt-fps"))
    root = operation("sqrt", grown)

    def added(toward: str) -> Expression:
        longer = product(root, size("turbulence_scale", toward))
        change = difference(longer, f"atmosphere/turb-{toward}-fps")
        # Exactly zero at zero change, where the filter would leave a rounding error.
        return operation("ifthen", operation("eq", _CHANGE, 0.0), 0.0, change)

    return Overlay(
        sizes=effect.properties(sizes),
        filters=(
            _component(_OLD, time),
            _component(_NEW, product(_OLD, grown)),
            *map(_filter, directions),
        ),
        winds=tuple(WindTerm(toward, added(toward)) for toward in directions),
    )


TURBULENCE_SCALE = AirEffect(
    name="turbulence_scale",
    part="air",
    parameters=(Parameter("change", -0.6, -0.9, 3.0, "gusts longer by this share"),),
    source="MIL-F-8785C 1980, §3.7.2: Dryden spectra, 1,750 ft above 2,000 ft",
    what="The gusts are longer or shorter than the case says.",
    shows_in=STEADY_LEGS,  # long gusts need long legs
    build=_longer,
)


EDGE = 5.0  # s: a thermal's edge of some 300 m at 120 kt; an instant step would be no flow of air


def _rises(effect: AircraftEffect, sizes: Sizes, _: Baseline) -> Overlay:
    up, begin, last = effect.paths()
    rise = quotient(difference(ELAPSED, begin), EDGE)
    fall = quotient(difference(total(begin, last), ELAPSED), EDGE)
    wind = WindTerm("down", product(up, -1.0 / FOOT, clipped(operation("min", rise, fall))))
    return Overlay(sizes=effect.properties(sizes), winds=(wind,))


def _updraft(signals: Signals, sizes: Sizes) -> Vector:
    since = elapsed(signals) - sizes["from_s"]
    share = np.clip(np.minimum(since, sizes["for_s"] - since) / EDGE, 0.0, 1.0)
    return np.zeros_like(since), np.zeros_like(since), -sizes["up_mps"] * share


UPDRAFT = AirEffect(
    name="updraft",
    part="air",
    parameters=(
        Parameter("up_mps", 1.0, -10.0, 10.0, "speed of the rising air"),
        Parameter(
            "from_s", 60.0, 0.0, 1e5, "time since the first sample at which it begins", shape=True
        ),
        Parameter("for_s", 60.0, 5.0, 1e5, "duration", shape=True),
    ),
    source="mountain waves and thermals: 1 to 5 m/s over kilometers (FAA Glider Flying Handbook, "
    "ch. 9)",
    what="The airplane flies through rising or sinking air.",
    shows_in=STEADY_LEGS,  # power and height are held, so that only the air rises
    by_vanes=True,
    build=_rises,
    wind=_updraft,
)


WIND_DRIFT = AirEffect(
    name="wind_drift",
    part="air",
    parameters=(
        Parameter(
            "north_mps_per_min", 0.15, -2.0, 2.0, "change of the wind toward north, per minute"
        ),
        Parameter(
            "east_mps_per_min", -0.10, -2.0, 2.0, "change of the wind toward east, per minute"
        ),
    ),
    source="Martos, Kiszely and Foster 2011: the methods take the wind as constant; hourly changes "
    "of 2 to 5 m/s are usual in soundings (estimate)",
    what="The wind changes during the flight.",
    shows_in=TURNING,
    for_whole_flight=True,
    build=_blows(lambda: (1.0 / (MINUTE * FOOT), ELAPSED)),
    wind=_level(lambda log, sizes: elapsed(log) / MINUTE),
)


WIND_OSCILLATION = AirEffect(
    name="wind_oscillation",
    part="air",
    parameters=(
        Parameter("north_mps", 0.8, -10.0, 10.0, "amplitude of the wind toward north"),
        Parameter("east_mps", -0.6, -10.0, 10.0, "amplitude of the wind toward east"),
        Parameter(
            "period_s",
            400.0,
            20.0,
            7200.0,
            "period of the oscillation, which begins at zero",
            shape=True,
        ),
    ),
    source="Holton 2004, Dynamic Meteorology: trapped lee waves of 5 to 25 km, met in minutes of "
    "flight",
    what="The wind oscillates during the flight.",
    shows_in=TURNING,  # each circle measures the wind anew
    variant_of="wind_drift",
    build=_blows(
        lambda period: (1.0 / FOOT, operation("sin", quotient(product(2.0 * pi, ELAPSED), period)))
    ),
    wind=_level(lambda log, sizes: np.sin(2.0 * pi * elapsed(log) / sizes["period_s"])),
)


KILOMETER = 1000.0  # m


def _above(signals: Signals, sizes: Sizes) -> Array:
    # A log without a height by GPS has that of its pressure.
    known = "altitude" in signals
    height = signals["altitude"] if known else air.pressure_altitude(signals["static_pressure"])
    return (height - sizes["reference_m"]) / KILOMETER


WIND_SHEAR = AirEffect(
    name="wind_shear",
    part="air",
    parameters=(
        Parameter(
            "north_mps_per_km", 4.0, -50.0, 50.0, "growth of the wind toward north with height"
        ),
        Parameter(
            "east_mps_per_km", 6.0, -50.0, 50.0, "growth of the wind toward east with height"
        ),
        Parameter("reference_m", 1828.8, 0.0, 15000.0, "height of the steady wind", shape=True),
    ),
    source="thermal wind, a few m/s a kilometer (Holton 2004, Dynamic Meteorology); more below "
    "inversions",
    what="The wind changes with height.",
    shows_in=CHANGING_HEIGHT,
    build=_blows(
        lambda reference: (
            difference(product("position/h-sl-ft", FOOT), reference),
            1.0 / (KILOMETER * FOOT),
        )
    ),
    wind=_level(_above),
)
