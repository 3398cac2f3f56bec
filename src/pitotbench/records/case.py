"""The configuration of one synthetic flight and of its sensing, with the rules it satisfies."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from math import isfinite
from typing import Any, Self

from pitotbench.catalog import UnknownNameError, explain
from pitotbench.records import Shown
from pitotbench.records.entries import Place, record_of_table
from pitotbench.units import DEGREE, FOOT, KNOT

USUAL_RATE = 100.0  # Hz
SLOWEST_RATE = 40.0  # Hz: at 20 Hz an autopilot loses a light airplane
LOOKS = 10.0  # Hz: a card looks at its instruments once in a whole number of steps


def possible_rates() -> tuple[float, ...]:
    """Return the rates [Hz] at which a flight may be integrated, the slowest first.

    A flight at 40 Hz takes 0.4 of the time of one at 100 Hz. `python -m tests.simulation.rates`
    measures the change of the results.
    """
    steps = range(round(SLOWEST_RATE / LOOKS), round(USUAL_RATE / LOOKS) + 1)
    return tuple(LOOKS * step for step in steps)


def rates_for(air_rate: float) -> tuple[float, ...]:
    """Return the rates [Hz] of integration that fit an air-data rate [Hz], the slowest first.

    Whole multiples, so that each row is a step of the flight, and the usual rate, which fits every
    data system: rows that fall between two of its steps are interpolated.
    """
    return tuple(
        rate for rate in possible_rates() if rate == USUAL_RATE or (rate / air_rate).is_integer()
    )


def rate_problem(rate: float, air_rate: float | None = None) -> str | None:
    """Return why a flight is not integrated at a rate [Hz], beside that of air data; None if it is.

    The latter [Hz] is considered where it is given.
    """
    if rate not in possible_rates():
        known = ", ".join(f"{each:g}" for each in possible_rates())
        return f"a flight is integrated at {known} Hz, not at {rate:g} Hz"
    if air_rate is None or rate in rates_for(air_rate):
        return None
    fitting = " or ".join(f"{each:g}" for each in rates_for(air_rate))
    return (
        f"{rate:g} Hz is not a whole multiple of the {air_rate:g} Hz of the air data: "
        f"integrate the flight at {fitting} Hz"
    )


TURBULENCE_SEVERITY = {"none": 0, "light": 1, "moderate": 2}  # Milspec severity index (MIL-F-8785C)
ERROR_LOCATIONS = ("impact", "static", "total")
PILOTS = ("none", "good", "busy")
VERTICAL_VELOCITIES = ("usual", "recorded", "missing")


@dataclass(frozen=True, slots=True)
class Wind:
    """The mean wind, uniform over the maneuver.

    `speed` [m/s]; `from_direction` [rad, true], where the wind comes from, as in a weather report:
    a wind from 270° moves the air toward east; `up` [m/s], its upward part.
    """

    speed: float = field(default=15.0 * KNOT, metadata={"suffix": "kt"})
    from_direction: float = field(default=300.0 * DEGREE, metadata={"suffix": "deg"})
    up: float = field(default=0.0, metadata={"suffix": "mps"})


@dataclass(frozen=True, slots=True)
class PressureErrorSpec:
    """The true pressure error Δp/q_c = f(q_ci/q_ref): a model of the table and its parameters.

    The default is plausible for a light twin: +0.3 kt at 100, −0.8 kt at 126 and −1.7 kt at 160
    KIAS. Its size is such that a Bias fit has about twice the residual of the other models, as in
    Martos et al. 2011, Fig 9. With `model = "table"`, `airspeed` [m/s, indicated] and `values` [-]
    are the points of the curve. `location` says which pressure has the error: `impact` (the impact
    pressure alone, as in the source), `static` (the static pressure reads Δp too high) or `total`
    (the total pressure reads Δp too low).
    """

    model: str = "inverse+"
    parameters: tuple[float, ...] = (-0.060, 0.006, 0.060)
    reference_pressure: float = field(default=1630.28, metadata={"suffix": "pa"})
    airspeed: tuple[float, ...] = field(default=(), metadata={"suffix": "kt"})
    values: tuple[float, ...] = ()
    location: str = "impact"


@dataclass(frozen=True, slots=True)
class DataSystem:
    """A data system (DAS): its rates [Hz] and the properties of its sensors.

    Each `…_noise` is the standard deviation of the white noise of a sample. A resolution of 0 means
    no rounding. A latency [s] is the time from an event to its stamp. `altitude_drift` is the
    standard deviation of the slow part of a receiver's height error, a first-order Gauss-Markov
    process of correlation time `altitude_drift_time`. `vertical_velocity` says whether the GPS
    velocity down is `recorded` or `missing`; `usual` is as in the source, where only an integrated
    IMU/GPS records it.
    """

    air_rate: float = field(default=50.0, metadata={"suffix": "hz"})
    gps_rate: float = field(default=50.0, metadata={"suffix": "hz"})
    impact_pressure_noise: float = field(default=12.0, metadata={"suffix": "pa"})
    impact_pressure_range: float = field(default=13789.5, metadata={"suffix": "pa"})
    impact_pressure_resolution: float = field(default=0.2, metadata={"suffix": "pa"})
    static_pressure_noise: float = field(default=10.0, metadata={"suffix": "pa"})
    static_pressure_resolution: float = field(default=1.5, metadata={"suffix": "pa"})
    temperature_noise: float = field(default=0.1, metadata={"suffix": "k"})
    temperature_resolution: float = field(default=0.01, metadata={"suffix": "k"})
    velocity_noise: float = field(default=0.05, metadata={"suffix": "mps"})
    velocity_resolution: float = field(default=0.001, metadata={"suffix": "mps"})
    altitude_noise: float = field(default=1.5, metadata={"suffix": "m"})
    altitude_drift: float = field(default=0.0, metadata={"suffix": "m"})
    altitude_drift_time: float = field(default=90.0, metadata={"suffix": "s"})
    attitude_noise: float = field(default=0.002, metadata={"suffix": "rad"})
    rate_noise: float = field(default=0.002, metadata={"suffix": "radps"})
    acceleration_noise: float = field(default=0.03, metadata={"suffix": "mps2"})
    vane_noise: float = field(default=0.003, metadata={"suffix": "rad"})
    air_latency: float = field(default=0.0, metadata={"suffix": "s"})
    gps_latency: float = field(default=0.0, metadata={"suffix": "s"})
    recovery_factor: float = 1.0
    vertical_velocity: str = "usual"

    @property
    def label(self) -> str:
        """The short name: air-data rate over GPS rate, for example `20/1`."""
        return f"{self.air_rate:g}/{self.gps_rate:g}"


@dataclass(frozen=True, slots=True)
class EffectSpec:
    """One effect of the effects table with its parameters, whose names end in their units."""

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, repr=False)
class Case(Shown):
    """One flight and its sensing. The same Case gives the same log, bit for bit.

    The calibrator must not import it, because it holds the truth (wind, pressure error, effects).
    Values are SI and radians; `metadata["suffix"]` names the unit in which a value is written to
    TOML.

    `card` overrides numbers of the maneuver's card; names end in a unit, for example `{"dwell_s":
    20.0}`.

    `fuel` is the share of the fuel in the aircraft's file (1 is that load). `ballast` [kg] lies at
    the center of gravity and is negative where the airplane is lighter than its file. Both are on
    the weight sheet, so the mass column of the log includes them.

    `integration_rate` [Hz] is that of the simulator, which is also the rate of the flight's truth.
    Another than the usual one is a whole multiple of the data system's air-data rate.

    `accuracy` states 2σ of constant sensor errors that the residual cannot show, for example
    `{"temperature_k": 1.0}`. It goes to the calibrator with the log and changes nothing in the
    flight.

    `truth_seed` drives turbulence and the pilot, `sensor_seed` the sensors.
    """

    aircraft: str = "navajo"
    maneuver: str = "step_decrease"
    card: Mapping[str, Any] = field(default_factory=dict)
    altitude: float = field(default=6000.0 * FOOT, metadata={"suffix": "ft"})
    temperature_offset: float = field(default=0.0, metadata={"suffix": "k"})
    wind: Wind = field(default_factory=Wind)
    fuel: float = 1.0
    ballast: float = field(default=0.0, metadata={"suffix": "kg"})
    turbulence: str = "light"
    pilot: str = "none"
    pressure_error: PressureErrorSpec = field(default_factory=PressureErrorSpec)
    das: DataSystem = field(default_factory=DataSystem)
    effects: tuple[EffectSpec, ...] = ()
    accuracy: Mapping[str, float] = field(default_factory=dict)
    integration_rate: float = field(default=USUAL_RATE, metadata={"suffix": "hz"})
    truth_seed: int = 1
    sensor_seed: int = 1

    def __new__(cls, *_: Any, **stated: Any) -> Self:
        """Refuse a name that is no field, with what to write instead."""
        known = [each.name for each in fields(cls)]
        for name in stated:
            if name not in known:
                written = ", ".join(f"{each}=…" for each in stated)
                raise TypeError(
                    f"{explain('field of a case', name, known)} Its fields are in SI units: "
                    f"Case.of({written}) takes the names of a case file, in their units"
                )
        return object.__new__(cls)

    def __post_init__(self) -> None:
        """Raise UnknownNameError for a maneuver, turbulence or pilot that does not exist."""
        for name in ("maneuver", "turbulence", "pilot"):
            value, known = getattr(self, name), _NAMES[name]
            if value not in known and value:
                raise UnknownNameError(explain(name, value, known))

    @classmethod
    def of(cls, **entries: Any) -> "Case":
        """Return the case of entries with units as in a case file: `altitude_ft=8000, wind_kt=20`.

        A table is a dictionary, such as `wind={"speed_kt": 20}`. `wind_kt` and `wind_from_deg` are
        the wind as the flags of that name state it. Raises BadInputError that lists every problem.
        """
        wind = {key: entries.pop(flag) for flag, key in _WIND.items() if flag in entries}
        if wind and isinstance(stated := entries.get("wind", {}), Mapping):
            entries["wind"] = {**stated, **wind}
        return record_of_table(cls, entries, "case", broken_rules)


_WIND = {"wind_kt": "speed_kt", "wind_from_deg": "from_direction_deg"}

# Path of the field (a regular expression), the test of its value [SI], and the rule in words.
_RULES: tuple[tuple[str, Callable[[Any], bool], str], ...] = (
    (
        r"das\.(air|gps)_rate|das\.\w+_(range|time)|das\.recovery_factor",
        lambda v: v > 0,
        "must be above 0",
    ),
    (r"pressure_error\.reference_pressure", lambda v: v > 0, "must be above 0"),
    (
        r"das\.\w+_(noise|resolution|latency|drift)|wind\.speed",
        lambda v: v >= 0,
        "must not be negative",
    ),
    (r"(truth|sensor)_seed", lambda v: v >= 0, "must not be negative"),
    (
        r"fuel",
        lambda v: 0 < v <= 1,
        "must be above 0 and at most 1, the whole of the fuel that the aircraft loads",
    ),
    (r"ballast", lambda v: abs(v) <= 1000.0, "must be within -1000 and 1000 kg"),
    (r"das\.air_rate", lambda v: v <= 100.0, "must not exceed the simulator's 100 Hz"),
)
_NAMES = {
    # Those of the table in `simulation.maneuvers`; a flight that somebody else flew has none.
    "maneuver": [
        "four_leg",
        "race_track",
        "step_decrease",
        "rapid_decel",
        "circle",
        "step_both_ways",
        "decel_circle",
        "figure_eight",
        "cloverleaf",
        "diagnostic",
    ],
    "turbulence": list(TURBULENCE_SEVERITY),
    "pilot": list(PILOTS),
    "pressure_error.location": list(ERROR_LOCATIONS),
    "das.vertical_velocity": list(VERTICAL_VELOCITIES),
}


def broken_rules(tree: Any, written: Callable[[Place], str]) -> Iterator[str]:
    """Yield each rule that a tree of fields [SI] breaks, beginning with the key as in the file."""
    leaves = dict(_leaves(tree, ()))
    for place, value in leaves.items():
        if isinstance(value, float) and not isfinite(value):
            yield f"{written(place)}: must be a finite number, not {value}"
            continue
        yield from _broken(place, value, written)
    air, gps = leaves.get(("das", "air_rate"), 50.0), leaves.get(("das", "gps_rate"), 50.0)
    if _is_number(air) and _is_number(gps) and gps > air > 0:
        yield f"das: the GPS rate ({gps:g} Hz) must not exceed the air-data rate ({air:g} Hz); lower gps_rate_hz"
    rate = leaves.get(("integration_rate",), USUAL_RATE)
    if _is_number(rate) and _is_number(air) and air > 0 and (problem := rate_problem(rate, air)):
        yield f"{written(('integration_rate',))}: {problem}"


def _broken(place: Place, value: Any, written: Callable[[Place], str]) -> Iterator[str]:
    path = ".".join(place)
    if path in _NAMES and isinstance(value, str) and value not in _NAMES[path]:
        yield f"{written(place)}: {explain(path, value, _NAMES[path])}"
    if _is_number(value):
        for pattern, holds, rule in _RULES:
            if re.fullmatch(pattern, path) and not holds(value):
                yield f"{written(place)}: {rule}, not {value:g} (SI)"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _leaves(value: Any, place: Place) -> Iterator[tuple[Place, Any]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves(inner, (*place, str(key)))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _leaves(inner, (*place, str(i)))
    else:
        yield place, value
