"""The settings in which the study flies, its reductions of a flight, and the changes of a log that
a reduction asks for.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from pitotbench.calibration.options import Accuracies, CalibrationOptions
from pitotbench.campaigns.flights import wind_toward
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.pressure_error import PAPER_MODELS
from pitotbench.records.case import Case, DataSystem, EffectSpec, PressureErrorSpec, Wind
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import SYSTEMS, data_system
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.timeline import gaps
from pitotbench.units import DEGREE, FOOT, KNOT, Array
from pitotlab.experiment import in_walking_wind

NAMES = {
    "step_decrease": "Step Decrease",
    "circle": "Circle",
    "rapid_decel": "Rapid Decel",
    "race_track": "Race Track",
    "four_leg": "4-Leg",
    "step_both_ways": "Step Decrease both ways",
}
PAPER_ORDER = tuple(NAMES)[:5]  # smallest 2σ first (Martos et al. 2011, III.E)


def named(
    row: Callable[[str], dict[str, object]], maneuvers: Sequence[str] = PAPER_ORDER
) -> pd.DataFrame:
    """Return a table with one line for each maneuver, by its name."""
    return pd.DataFrame([{"maneuver": NAMES[m], **row(m)} for m in NAMES if m in maneuvers])


MINUTE, HUNDRED_FEET = 60.0, 100.0 * FOOT
# Of q_c a degree squared: 1.25 % at 5°, our estimate for a probe next to the fuselage.
SIDESLIP_ERROR = 0.0005
TURNING = 10.0 * DEGREE  # of bank: above it the airplane turns
Change = Callable[[Flight, float], Flight]


def _with(flight: Flight, **channels: Array) -> Flight:
    return replace(flight, channels={**flight.channels, **channels})


def _with_wind(flight: Flight, speed: Array, direction: float) -> Flight:
    """Return the flight with more wind toward a direction [rad], of a speed [m/s] at each sample."""
    north, east = speed * np.cos(direction), speed * np.sin(direction)
    return _with(
        flight,
        velocity_north=flight["velocity_north"] + north,
        velocity_east=flight["velocity_east"] + east,
    )


def _direction(flight: Flight) -> float:
    """Draw a direction [rad] from the seed, so that it does not depend on the maneuver's headings."""
    return float(np.random.default_rng([flight.case.truth_seed, 83]).uniform(0.0, 2.0 * np.pi))


def wind_change(flight: Flight, knots_a_minute: float) -> Flight:
    """Return the flight in a wind that grows steadily with time toward a random direction."""
    since = (flight["time"] - flight["time"].mean()) / MINUTE
    return _with_wind(flight, knots_a_minute * KNOT * since, _direction(flight))


def wind_walk(flight: Flight, rms: float) -> Flight:
    """Return the flight in a wind that walks, by `rms` [m/s] in ten minutes."""
    return in_walking_wind(flight, rms, flight.case.truth_seed)[0]


def shear(flight: Flight, knots_a_hundred_feet: float) -> Flight:
    """Return the flight in a wind that grows with altitude toward a random direction."""
    above = (flight["altitude"] - flight["altitude"].mean()) / HUNDRED_FEET
    return _with_wind(flight, knots_a_hundred_feet * KNOT * above, _direction(flight))


def vertical_speed(flight: Flight, times: float) -> Flight:
    """Return the flight at the same airspeed with the vertical speed multiplied."""
    wind = wind_toward(flight.case.wind)
    north, east = flight["velocity_north"] - wind[0], flight["velocity_east"] - wind[1]
    down = flight["velocity_down"]
    level, steeper = np.hypot(north, east), np.clip(times * down, -20.0, 20.0)
    shrink = np.sqrt(np.maximum(level**2 + down**2 - steeper**2, 0.0)) / level
    return _with(
        flight,
        velocity_north=wind[0] + shrink * north,
        velocity_east=wind[1] + shrink * east,
        velocity_down=steeper,
    )


def steady_sideslip(flight: Flight, degrees: float | Array) -> Flight:
    """Return the flight with a sideslip; the probe loses `SIDESLIP_ERROR` of q_c a degree squared."""
    total = flight["total_pressure"]
    lost = SIDESLIP_ERROR * degrees**2 * (total - flight["static_pressure"])
    return _with(flight, total_pressure=total - lost)


def sideslip_in_turns(flight: Flight, degrees: float) -> Flight:
    """Return the flight with sideslip in turns only, as without rudder."""
    return steady_sideslip(flight, np.where(np.abs(flight["roll"]) > TURNING, degrees, 0.0))


def twice_the_rate(flight: Flight, level: float) -> Flight:
    """Return the flight with one more sample between every two, for systems faster than the
    simulator.

    The frequencies of the air data are far below the simulator's Nyquist frequency of 50 Hz, so
    linear interpolation is accurate enough.
    """
    time = flight["time"]
    near = np.setdiff1d(np.arange(len(time) - 1), gaps(time) - 1)  # rows without a gap after them

    def between(values: Array) -> Array:
        return np.insert(values, near + 1, 0.5 * (values[near] + values[near + 1]))

    circular = {"heading": np.unwrap(flight["heading"])}
    channels = {name: between(values) for name, values in {**flight.channels, **circular}.items()}
    order = np.insert(np.arange(len(time)), near + 1, near)
    return Flight(flight.case, channels, flight.segment[order], flight.on_condition[order])


def _with_error(flight: Flight, level: float, *, error: PressureErrorSpec) -> Flight:
    return replace(flight, case=replace(flight.case, pressure_error=error))


def _truth(model: str, *parameters: float) -> Change:
    return partial(_with_error, error=PressureErrorSpec(model=model, parameters=parameters))


def error_size(flight: Flight, times: float) -> Flight:
    """Return the flight with its pressure error multiplied."""
    error = flight.case.pressure_error
    larger = replace(error, parameters=tuple(times * k for k in error.parameters))
    return _with_error(flight, 0.0, error=larger)


# A curve with a knee, as of a static source behind a flap.
_KNEE = PressureErrorSpec(
    model="table",
    airspeed=tuple(knots * KNOT for knots in (90.0, 110.0, 120.0, 130.0, 170.0)),
    values=(0.01, 0.01, -0.01, -0.02, -0.02),
)

CHANGES: Catalog[Change] = Catalog(
    "change",
    {
        "none": lambda flight, level: flight,
        "wind change": wind_change,
        "wind walk": wind_walk,
        "shear": shear,
        "vertical speed": vertical_speed,
        "steady sideslip": steady_sideslip,
        "sideslip in turns": sideslip_in_turns,
        "twice the rate": twice_the_rate,
        "error size": error_size,
        "constant truth": _truth("bias", -0.02),
        "linear truth": _truth("linear", 0.03, -0.025),
        "quadratic truth": _truth("quadratic", 0.08, -0.09, 0.02),
        "knee truth": partial(_with_error, error=_KNEE),
    },
)


# The paper's case is stated in full, so that no default of the calibrator changes it. The error is
# in the impact pressure alone (so no altitude equation), no sensor has a constant error, the wind
# is constant, the clocks agree.
COVERING = CalibrationOptions(
    model="inverse+",
    method="covering",
    error_location="impact",
    wind="constant",
    latency="given",
    accuracies=Accuracies(),
)
PAPER = replace(COVERING, method="paper", robust=False)  # as published: every row counts
BOTH_METHODS = (COVERING, PAPER)
EITHER_WAY = tuple(replace(PAPER, use_down=down) for down in (True, False))
_SIMULATED = 100.0  # Hz


@dataclass(frozen=True, slots=True)
class Reduction:
    """A data system, the options of the fit, and a change of the flight before it is sensed.

    `change` is a name of `CHANGES`, `level` the size of the change. `noise` multiplies the noise of
    the impact pressure, `gps_noise` that of the GPS velocity. `given_down` adds velocity down to
    the log of any system. `alone` leaves the noise of the impact pressure alone, as in the paper:
    every other sensor is exact. `form` is `scalar` (one output, airspeed) or `vector` (the
    components of ground velocity, by the paper's method).
    """

    das: str = "50/50"
    options: CalibrationOptions = PAPER
    change: str = "none"
    level: float = 0.0
    noise: float = 1.0
    gps_noise: float = 1.0
    given_down: bool = False
    alone: bool = False
    form: str = "scalar"

    @property
    def sensing(self) -> "Reduction":
        """The part that determines the log: reductions that share it share one log."""
        return replace(self, options=PAPER, form="scalar")


def reductions(
    options: Iterable[CalibrationOptions] = (PAPER,),
    das: Iterable[str] = ("50/50",),
    **how: Any,
) -> tuple[Reduction, ...]:
    """Return the reductions with each of some options at each of some data systems."""
    every = tuple(options)
    return tuple(Reduction(system, one, **how) for system in das for one in every)


def sense_for(flight: Flight, reduction: Reduction) -> tuple[Flight, FlightLog]:
    """Return the flight with the change of a reduction, and its log. Twice the simulator's rate is
    allowed.

    Raises BadInputError for impossible rates, UnknownNameError for an unknown change.
    """
    system = _system(reduction.das)
    changed = CHANGES[reduction.change](flight, reduction.level)
    if system.air_rate > _SIMULATED:
        changed = CHANGES["twice the rate"](changed, 0.0)
    if reduction.alone:  # no other noise, and no rounding
        names = [f.name for f in fields(system) if f.name.endswith(("_noise", "_resolution"))]
        exact: dict[str, Any] = dict.fromkeys(names, 0.0)
        system = replace(system, **exact | {"impact_pressure_noise": system.impact_pressure_noise})
    noisy = replace(
        system,
        impact_pressure_noise=reduction.noise * system.impact_pressure_noise,
        velocity_noise=reduction.gps_noise * system.velocity_noise,
    )
    return changed, record(changed, noisy, flight.case.sensor_seed, reduction.given_down or None)


def _system(das: str) -> DataSystem:
    """Return a data system for rates up to 200 Hz, with the noise of its kind at 100 Hz."""
    air, gps = (float(part) for part in das.split("/"))
    if air <= _SIMULATED:
        return data_system(das)
    known = data_system(f"{_SIMULATED:g}/{min(gps, _SIMULATED):g}")
    return replace(known, air_rate=air, gps_rate=gps)


SPECIFICATION = 0.1  # times the injected noise gives that of the instrument's specification
BOTH_WAYS = "step_both_ways"  # Step Decrease with every speed on both headings
STEEPER = (4.0, 8.0, 12.0, 16.0, 24.0)
STEEP = 12.0  # times the vertical speed: the one at which data rates are compared
ALIKE = 0.5  # times the noise of a receiver alone gives that of an integrated solution
FIXED_POWER = "fixed power"  # the variant of Circle that the paper's pilot flew
ERROR_SIZES = (0.25, 0.5, 2.0)  # times the default pressure error, which was chosen with C5 in view
ERROR_SHAPES = ("linear truth", "quadratic truth", "knee truth")


@dataclass(frozen=True, slots=True)
class StudySetting:
    """The air and the pilot. `rare` settings are flown for a fifth of the seeds."""

    turbulence: str
    pilot: str
    what: str
    rare: bool = True
    effects: tuple[EffectSpec, ...] = ()
    flown: tuple[str, ...] = PAPER_MANEUVERS
    wind: float | None = None  # kt, the wind of the case unless given


# The airplane differed from the simulator (Martos et al. 2011, II.B, III.A): it had a pod under the
# belly, and its turns needed more power. The sizes are the typical ones of the effects table. An
# effect not in it is omitted.
_AIRPLANE = (
    EffectSpec("belly_pod", {"drag_area_m2": 0.1}),
    EffectSpec("turn_drag", {"coefficient_at_30deg": 0.005}),
)
AIRPLANE_EFFECTS = tuple(effect for effect in _AIRPLANE if effect.name in EFFECTS)
AIRPLANE_FLOWN = ("step_decrease", "race_track", "four_leg", "rapid_decel")
_SMOOTH = "smooth air, constant wind, a good pilot: as the paper's simulator"
_CALM = "smooth air, no wind, the autopilot alone"
_AS_FLOWN = "light turbulence, a good pilot, the airplane's effects"

SETTINGS: Catalog[StudySetting] = Catalog(
    "setting",
    {
        "smooth": StudySetting("none", "good", _SMOOTH, rare=False),
        "light": StudySetting("light", "good", "light turbulence, a good pilot", rare=False),
        "autopilot": StudySetting("none", "none", _CALM, wind=0.0),
        "busy": StudySetting("none", "busy", "smooth air, a busy pilot"),
        "airplane": StudySetting(
            "light", "good", _AS_FLOWN, effects=AIRPLANE_EFFECTS, flown=AIRPLANE_FLOWN
        ),
        "moderate": StudySetting("moderate", "good", "moderate turbulence, a good pilot"),
    },
)


@dataclass(frozen=True, slots=True)
class Sortie:
    """One flight of the study and the reductions of it; `variant` is the name of an unusual card.

    `density` and `curves` ask for the tables of that name.
    """

    setting: str
    case: Case
    reductions: tuple[Reduction, ...]
    variant: str = "standard"
    density: bool = False
    curves: bool = False


def case_of(setting: str, maneuver: str, seed: int, **changes: Any) -> Case:
    """Return the case of a setting, maneuver and seed, with other changes."""
    air = SETTINGS[setting]
    case = Case(
        maneuver=maneuver,
        turbulence=air.turbulence,
        pilot=air.pilot,
        effects=air.effects,
        truth_seed=seed,
        sensor_seed=seed,
    )
    if air.wind is not None:
        case = replace(case, wind=Wind(speed=air.wind * KNOT))
    return replace(case, **changes)


# Unusual cards in smooth air: the name, the maneuver, and the changed numbers.
VARIANTS = (
    ("six speeds", "four_leg", {"speeds_kt": (160.0, 148.0, 136.0, 124.0, 112.0, 100.0)}),
    ("long steps", "step_decrease", {"step_time_s": 20.0}),
)
FLOWN_BY_PITCH = ("smooth", "light", "autopilot", "busy")  # Circle at fixed power
_MODELS = tuple(replace(PAPER, model=model) for model in PAPER_MODELS)
_ON_CONDITION = tuple(replace(one, on_condition=True) for one in EITHER_WAY)
_COVERED = Reduction("50/50", COVERING)
_LIKE_THE_AIRPLANE = replace(PAPER, model="quadratic", on_condition=True)
_QUIET = reductions(EITHER_WAY, noise=SPECIFICATION, gps_noise=SPECIFICATION)
# What every claim needs: data systems, models, V_down, turns, and the covering bound.
_MAIN = (
    *reductions((*EITHER_WAY, *_ON_CONDITION, *_MODELS[1:], COVERING), SYSTEMS),
    *reductions((PAPER, COVERING), ("20/1",), gps_noise=ALIKE),
)
# Ground velocity as two and as three outputs, with noise on the impact pressure alone.
_POOLED = (
    *reductions(EITHER_WAY, SYSTEMS, given_down=True, alone=True, form="vector"),
    *reductions(_ON_CONDITION, given_down=True, alone=True, form="vector"),
)
_STEEP = tuple(
    one for times in STEEPER for one in reductions(EITHER_WAY, change="vertical speed", level=times)
)
# Errors that were not chosen for a claim.
_ERRORS = (
    *(
        one
        for times in ERROR_SIZES
        for one in reductions(_MODELS, change="error size", level=times)
    ),
    *(one for shape in ERROR_SHAPES for one in reductions(_MODELS, change=shape)),
)
_STRAIGHT = reductions((_LIKE_THE_AIRPLANE,), ("20/1",))
# What explains C2, C5, C7 and C8 in smooth air.
_EXPLAINING = (
    *reductions(das=SYSTEMS, noise=SPECIFICATION),
    *_STEEP,
    *reductions(EITHER_WAY, ("20/1",), change="vertical speed", level=STEEP, given_down=True),
    *reductions(EITHER_WAY, form="vector"),
    *_QUIET,
    *_POOLED,
    *_ERRORS,
    *_STRAIGHT,
)
_RARE = (*reductions(EITHER_WAY, SYSTEMS), *_STRAIGHT, _COVERED)
# The wind's walks in the airplane's air [m/s in ten minutes]; the second is judged.
WALKS = (0.5, 1.0, 2.0)
WALK: Mapping[str, object] = {"change": "wind walk", "level": WALKS[1]}
TURN_SIDESLIP = 4.0  # degrees
# The airplane's data system and model, with and without turns, by both methods.
_AIRPLANE_OPTIONS = tuple(
    replace(method, model="quadratic", on_condition=straight)
    for method in BOTH_METHODS
    for straight in (True, False)
)
_PUBLISHED_OPTIONS = tuple(each for each in _AIRPLANE_OPTIONS if each.method == "paper")
OF_SETTING: Mapping[str, tuple[Reduction, ...]] = {
    "smooth": _MAIN,
    "light": (*_MAIN, *_STRAIGHT),
    "autopilot": _RARE,
    "busy": (*_RARE, *_QUIET),
    "airplane": (
        *reductions(_AIRPLANE_OPTIONS, ("20/1",), change="wind walk", level=WALKS[1]),
        *(
            one
            for rms in (WALKS[0], WALKS[2])
            for one in reductions((_LIKE_THE_AIRPLANE,), ("20/1",), change="wind walk", level=rms)
        ),
        *reductions(_PUBLISHED_OPTIONS, ("20/1",)),
        *reductions(_PUBLISHED_OPTIONS, ("20/1",), change="sideslip in turns", level=TURN_SIDESLIP),
    ),
    "moderate": _RARE,
}


def claim_sorties(seed: int, rare: bool, first: bool = False) -> Iterator[Sortie]:
    """Return the flights of a seed that the claims need, with `rare` also those of rare settings.

    The densities and the curves are those of the `first` seed.
    """
    for name, setting in SETTINGS.items():
        if setting.rare and not rare:
            continue
        asked = (*OF_SETTING[name], *(_EXPLAINING if name == "smooth" and rare else ()))
        curves = first and name == "airplane"
        for maneuver in setting.flown:
            case = case_of(name, maneuver, seed)
            yield Sortie(name, case, asked, density=first, curves=curves)
    plain = (*reductions(das=SYSTEMS), _COVERED)
    if rare:
        both = case_of("smooth", BOTH_WAYS, seed)
        yield Sortie("smooth", both, (*reductions(_MODELS), _COVERED))
    for name in FLOWN_BY_PITCH:
        if rare or not SETTINGS[name].rare:
            case = case_of(name, "circle", seed, card={"fixed_power": 1})
            yield Sortie(name, case, plain, FIXED_POWER)
    for variant, maneuver, card in VARIANTS:
        case = case_of("smooth", maneuver, seed, card=card)
        yield Sortie("smooth", case, plain, variant, density=first)
