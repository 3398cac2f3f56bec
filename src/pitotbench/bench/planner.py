"""Plan a flight: predict the bound of each maneuver before it is flown, and find the card with the
smallest one.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from math import sqrt
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.calibration.expected_bound import ExpectedNoise, expected_two_sigma
from pitotbench.calibration.options import AUTO, CalibrationOptions
from pitotbench.campaigns.flights import briefing_of, sense, wind_toward
from pitotbench.effects.air import LENGTH as LENGTH_FT
from pitotbench.records import SEARCH_FLIGHTS, BadInputError, NoAnswerError
from pitotbench.records.case import TURBULENCE_SEVERITY, Case, DataSystem, rates_for
from pitotbench.records.case_file import read_case, write_case
from pitotbench.records.flight import Flight
from pitotbench.records.forecast import COMPARED_MINUTES, Forecast, Plan
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import SimulationError, read_record
from pitotbench.simulation.card import override
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.sortie import fly, speed_range, with_usual_curve
from pitotbench.timeline import gaps, interval
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, Array, MetersPerSecond, from_si

_CURVE_STEP = 5.0 * KNOT
_NARROWEST = 20.0 * KNOT
_FEWEST_DRAWS = 2


@dataclass(frozen=True, slots=True)
class PlanRequest:
    """The request for a plan.

    `base` holds the aircraft, the height, the expected wind and turbulence, and an error curve of
    the expected size and location. `system` is the data system or its name, and `options` are those
    of the calibration: the smooth curve of a measured log where none are stated. An error of the
    static source narrows the bound as far as the system's height shows it. A base that states no
    curve has the usual one at the speeds of its aircraft.
    `speeds` is the range of calibrated airspeed [m/s] over which the bound is averaged, by default
    that of the aircraft's cards. `minutes` is the time available, `want` [m/s] the wanted 2σ, and
    `box` [m] the side of the airspace; each is None where it does not matter. `draws` is the number
    of draws of gusts and sensor noise for each maneuver.

    Raises BadInputError or UnknownNameError for a request that makes no sense.
    """

    base: Case
    system: str | DataSystem = "20/1"
    speeds: tuple[float, float] | None = None
    minutes: float | None = None
    want: float | None = None
    box: float | None = None
    maneuvers: tuple[str, ...] = tuple(MANEUVERS)
    draws: int = 16
    options: CalibrationOptions = field(default_factory=lambda: CalibrationOptions(model=AUTO))

    def __post_init__(self) -> None:
        for name in self.maneuvers:
            _ = MANEUVERS[name]
        if self.base.turbulence not in TURBULENCE_SEVERITY:
            raise BadInputError(
                f"turbulence {self.base.turbulence!r}: expect one of "
                f"{', '.join(TURBULENCE_SEVERITY)}"
            )
        object.__setattr__(self, "base", with_usual_curve(self.base))
        low, high = self.range
        if not (low >= 20.0 * KNOT and high - low >= _NARROWEST):
            raise BadInputError("--speeds-kt LOW,HIGH: from 20 kt upward, and at least 20 kt apart")
        for name, value in (
            ("--minutes", self.minutes),
            ("--want-kt", self.want),
            ("--box-nm", self.box),
        ):
            if value is not None and not 0.0 < value < float("inf"):
                raise BadInputError(
                    f"{name} must be above zero; leave it out where it does not matter"
                )
        if self.draws < _FEWEST_DRAWS:
            raise BadInputError(f"--draws: at least {_FEWEST_DRAWS} flights make an average")

    @property
    def das(self) -> DataSystem:
        """The data system."""
        return data_system(self.system) if isinstance(self.system, str) else self.system

    @property
    def range(self) -> tuple[float, float]:
        """The range of calibrated airspeed [m/s] over which the bound is averaged."""
        return self.speeds or speed_range(self.base.aircraft)

    @property
    def airspeeds(self) -> Array:
        """The airspeeds [m/s], (n,), at which the bound is averaged: every 5 kt of the wanted
        range.
        """
        low, high = self.range
        steps = np.arange(int((high - low) / _CURVE_STEP + 1e-6) + 1, dtype=np.float64)
        return np.asarray(low + _CURVE_STEP * steps, dtype=np.float64)

    def case(self, maneuver: str, card: dict[str, Any] | None = None) -> Case:
        """Return the case of a maneuver in still air, with its speeds scaled to the wanted range.

        Each speed of a card keeps its relative place between the slowest and the fastest one.
        """
        speeds = np.array(MANEUVERS[maneuver].card.speeds)
        place = (speeds - speeds.min()) / np.ptp(speeds)
        low, high = self.range
        wanted = [written(v, "kt") for v in low + place * (high - low)]
        changes = {"speeds_kt": wanted, **(card or {})}
        return replace(self.base, maneuver=maneuver, card=changes, turbulence="none")


def written(value: float, suffix: str) -> float:
    """Return an SI value as a card's file has it: in the unit of a suffix ("" for a count), to a
    millionth.
    """
    return round(float(from_si(value, suffix) if suffix else value), 6)


# Add gusts to a flight in smooth air: draw Dryden turbulence at random along it. The spectra are
# those of MIL-F-8785C (1980), 3.7.2.1, above 2,000 ft: longitudinal H(s) ∝ 1/(1 + s/a) and lateral
# H(s) ∝ (1 + √3 s/a)/(1 + s/a)² with a = V/L. Both have the same variance. At low frequencies the
# lateral gust has half the power of the longitudinal one. The axes of the simulator's turbulence
# are fixed to the ground and do not turn with the airplane. The longitudinal axis is the direction
# that the wind comes from, mirrored about north; this was found from simulated flights.

LENGTH = LENGTH_FT * FOOT  # of the Dryden spectra, above 2,000 ft
MEAN_LENGTH = (
    0.75 * LENGTH
)  # of one isotropic process with the mean low-frequency power of both components
# MIL-F-8785C, Fig. 7: standard deviation [ft/s] at heights [ft], by severity.
_HEIGHTS = (500.0, 1750.0, 3750.0, 7500.0, 15000.0)
_DEVIATIONS = {0: (0.0,) * 5, 1: (3.2, 2.2, 1.5, 0.0, 0.0), 2: (4.2, 3.6, 3.3, 1.6, 0.0)}
_STEP = 0.1  # s between two samples of the gust: one draw serves flights of any rate


def gust_deviation(case: Case) -> float:
    """Return the standard deviation [m/s] of each horizontal gust component, at the height of a
    case.
    """
    severity = TURBULENCE_SEVERITY[case.turbulence]
    return float(np.interp(case.altitude / FOOT, _HEIGHTS, _DEVIATIONS[severity])) * FOOT


def with_gusts(flight: Flight, turbulence: str, seed: int) -> Flight:
    """Return the smooth flight with the airspeed and the total pressure that it would have in
    turbulence.

    The ground velocity does not change: the airplane is too heavy to follow gusts of this length.
    """
    case = replace(flight.case, turbulence=turbulence, truth_seed=seed, sensor_seed=seed)
    deviation = gust_deviation(case)
    if deviation == 0.0:
        return replace(flight, case=case)
    gust = deviation * _gust(flight, seed)
    north, east = (
        flight[f"velocity_{axis}"] - flight[f"wind_{axis}"] - part
        for axis, part in zip(("north", "east"), gust, strict=True)
    )
    down = flight["velocity_down"] - flight["wind_down"]
    airspeed = np.sqrt(north**2 + east**2 + down**2)
    impact = air.impact_pressure_from_true_airspeed(
        airspeed, flight["static_pressure"], flight["air_temperature"]
    )
    changed = {"true_airspeed": airspeed, "total_pressure": flight["static_pressure"] + impact}
    return replace(flight, case=case, channels={**flight.channels, **changed})


def _gust(flight: Flight, seed: int) -> Array:
    """Return a gust toward north and east of unit variance, (2, n), at the flight's samples."""
    rows = np.arange(0, len(flight), round(_STEP / interval(flight["time"])))
    time, rate = flight["time"][rows], flight["true_airspeed"][rows] / LENGTH
    along, across = (
        _dryden(time, rate, np.random.default_rng([seed, axis, 1750])) for axis in (0, 1)
    )
    axis = -flight.case.wind.from_direction
    north = np.cos(axis) * along[0] - np.sin(axis) * across[1]
    east = np.sin(axis) * along[0] + np.cos(axis) * across[1]
    return np.stack([np.interp(flight["time"], time, part) for part in (north, east)])


def _dryden(time: Array, rate: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return a longitudinal and a lateral gust of unit variance, (n,) each, from one white noise.

    Two states of unit and half variance, x' = −a x + √(2a) w and y' = a (x − y), integrated exactly
    over steps of any length. The lateral gust is (√3 x + (1 − √3) y)/√2.
    """
    first, second = rng.standard_normal((len(time), 2)).T
    step = np.diff(time) * rate[1:]
    decay = np.exp(-step)
    left_x = np.maximum(1.0 - decay * decay, 1e-15)
    left_xy = 0.5 - decay * decay * (step + 0.5)
    left_y = 0.5 - decay * decay * (step * step + step + 0.5)
    common, own = (
        first[1:] / np.sqrt(left_x),
        np.sqrt(np.maximum(left_y - left_xy * left_xy / left_x, 0.0)),
    )
    x, y = float(first[0]), float(0.5 * first[0] + 0.5 * second[0])
    found = [(x, y)]
    # Lists, because a number of an array takes far longer to reckon with than a number of Python's
    # own.
    pushes = (decay, step, left_x * common, left_xy * common + own * second[1:])
    for keep, share, push_x, push_y in zip(*(each.tolist() for each in pushes), strict=True):
        x, y = keep * x + push_x, keep * (y + share * x) + push_y
        found.append((x, y))
    states = np.array(found)
    lateral = (sqrt(3.0) * states[:, 0] + (1.0 - sqrt(3.0)) * states[:, 1]) / sqrt(2.0)
    return states[:, 0], lateral


# Predict the bound of a card before it is flown, from a simulated flight in smooth air with random
# gusts added.

_CHANNELS = (
    *CALIBRATION_CHANNELS, "true_airspeed", "wind_north", "wind_east", "wind_down", "roll", "position_north",
    "position_east", "heading", "calibrated_airspeed",
)  # fmt: skip
_KEPT_FLIGHTS = 16
_FIRST_DRAW = 1


def forecast(
    request: PlanRequest, maneuver: str, card: Mapping[str, Any] | None = None
) -> Forecast:
    """Predict the bound of a maneuver, with the numbers of its card that are in `card` changed.

    Raises SimulationError where the card cannot be flown, NoAnswerError where it does not determine
    the answer.
    """
    flight = smooth_flight(request, maneuver, card)
    bounds = np.stack(
        [_drawn(request, flight, seed) for seed in range(_FIRST_DRAW, _FIRST_DRAW + request.draws)]
    )
    return Forecast(
        maneuver=maneuver,
        card=dict(card or {}),
        minutes=flight.duration / 60.0,
        elapsed_minutes=float(np.ptp(flight["time"])) / 60.0,
        steepest_bank=float(np.abs(flight["roll"]).max()),
        extent=(float(np.ptp(flight["position_north"])), float(np.ptp(flight["position_east"]))),
        airspeeds=request.airspeeds,
        two_sigma=bounds.mean(axis=0),
        known_noise_two_sigma=known_noise_two_sigma(request, flight),
        spread=float(bounds.mean(axis=1).std(ddof=1)),
        track=_track(flight),
        legs=briefing_of(flight),
    )


def _track(flight: Flight) -> Array:
    """Return the ground track, north and east [m], (2, k), one point a second; NaN where nothing
    was recorded.
    """
    time = flight["time"]
    rows = np.flatnonzero(np.diff(np.floor(time - time[0]), prepend=-1.0) > 0.0)
    track = np.stack([flight["position_north"][rows], flight["position_east"][rows]])
    return np.insert(track, gaps(time[rows]), np.nan, axis=1)


def smooth_flight(
    request: PlanRequest, maneuver: str, card: Mapping[str, Any] | None = None
) -> Flight:
    """Return the flight of a maneuver in smooth air. The last few are kept in memory.

    It is integrated at the slowest rate that fits the data system, where the airplane is one of the
    bench: `python -m tests.simulation.rates` measures what that changes. A fast airplane of
    JSBSim's library may need the usual rate.
    """
    case = replace(request.case(maneuver, dict(card or {})), das=request.das)
    attached = read_record(find_aircraft(case.aircraft)) is not None
    rate = case.integration_rate if attached else rates_for(request.das.air_rate)[0]
    return _flown(write_case(replace(case, integration_rate=rate)))


@lru_cache(_KEPT_FLIGHTS)
def _flown(case: str) -> Flight:
    return fly(read_case(case), channels=_CHANNELS)


def known_noise_two_sigma(request: PlanRequest, flight: Flight) -> MetersPerSecond:
    """Return 2σ [m/s] at the request's airspeeds by the information matrix, for gusts of the
    expected level.
    """
    level = gust_deviation(request.base)
    wind = np.array(wind_toward(request.base.wind)[:2])
    das = request.das
    noise = ExpectedNoise(
        gust_deviation=level,
        gust_length=MEAN_LENGTH,
        height_deviation=das.altitude_drift,
        height_memory=das.altitude_drift_time,
        height_white=das.altitude_noise,
        height_walk=das.velocity_noise / das.gps_rate**0.5,
    )
    location = request.options.error_location
    if (
        location == AUTO
    ):  # the calibrator finds the place from the height, or assumes the published one
        location = request.base.pressure_error.location
    log = sense(flight, das)
    options = replace(request.options, error_location=location)
    return expected_two_sigma(log, options, wind, noise, request.airspeeds)


def _drawn(request: PlanRequest, flight: Flight, seed: int) -> MetersPerSecond:
    """Return the calibrator's 2σ [m/s] at the request's airspeeds, for one draw of gusts and sensor
    noise.
    """
    log = sense(with_gusts(flight, request.base.turbulence, seed), request.das)
    curve = calibrate(log, request.options).curve
    return np.interp(request.airspeeds, curve.indicated_airspeed, curve.two_sigma)


# Search the best card: change the free numbers of a maneuver until the bound of the curve is
# smallest. The search minimizes the bound for known noise (the inverse information matrix) on the
# flight of the card in smooth air, within the minutes given. Headings are not free: the simulated
# turbulence has an axis, and no known axis exists in real air, so the best headings would be those
# of the simulator.

# Entry of a card: least and largest value [SI]. A list has as many free numbers as entries.
_FREE = {
    "dwell": (2.0, 240.0),
    "dwells": (2.0, 240.0),
    "turns": (0.25, 4.0),
    "circles": (0.25, 4.0),
    "step": (0.4 * INCH_OF_MERCURY, 3.0 * INCH_OF_MERCURY),
    "step_time": (3.0, 20.0),
    "bank": (15.0 * DEGREE, 45.0 * DEGREE),  # 45° is the steep turn that pilots train
}
_OVERTIME = (
    1.0  # times ln(minutes over the limit): twice the gain of flying longer, since 2σ falls as 1/√t
)
_FIRST_STEP = (
    0.35  # of a number's logarithm; up and down in turn, so that the first cards take similar times
)
_UNFLYABLE = 50.0


@dataclass(frozen=True, slots=True)
class FreeNumber:
    """One number of a card that may change.

    `place` is its index in the list of the entry, None for a plain number. `suffix` is the unit
    suffix of the written key, "" for a count. `low` and `high` are its bounds [SI].
    """

    entry: str
    place: int | None
    suffix: str
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Search:
    """The result of a search: the card's changed numbers (keys with units), and the number of
    flights.
    """

    maneuver: str
    card: Mapping[str, Any]
    flights: int


def free_numbers(maneuver: str) -> tuple[FreeNumber, ...]:
    """Return the free numbers of a maneuver's card. The speeds between the first and the last are
    among them.
    """
    card = MANEUVERS[maneuver].card
    found = []
    for entry in (f for f in fields(card) if f.name in _FREE):
        value = getattr(card, entry.name)
        places = range(len(value)) if isinstance(value, tuple) else (None,)
        suffix = str(entry.metadata.get("suffix", ""))
        found += [FreeNumber(entry.name, place, suffix, *_FREE[entry.name]) for place in places]
    between = range(1, len(card.speeds) - 1)
    ends = min(card.speeds), max(card.speeds)
    return (*found, *(FreeNumber("speeds", place, "kt", *ends) for place in between))


def best_card(
    request: PlanRequest,
    maneuver: str,
    minutes: float,
    flights: int = 60,
    step: Callable[[], None] = lambda: None,
) -> Search:
    """Search the card of a maneuver with the smallest bound in at most so many `minutes`, with so
    many `flights`.

    Uses the simplex of Nelder and Mead (1965) on the logarithms of the free numbers. A card that
    cannot be flown, does not determine the answer or leaves the box gets the cost `_UNFLYABLE`. A
    card that takes longer than `minutes` pays for the overtime. `step` is called after each flight.
    Raises BadInputError where the maneuver has no free number.
    """
    from scipy.optimize import minimize

    free = free_numbers(maneuver)
    if not free:
        raise BadInputError(f"the card of {maneuver} has no free numbers: choose another maneuver")
    card = override(MANEUVERS[maneuver].card, request.case(maneuver).card)
    values = [(getattr(card, number.entry), number.place) for number in free]
    start = np.log([value if place is None else value[place] for value, place in values])
    simplex = np.vstack([start, start + _FIRST_STEP * np.diag((-1.0) ** np.arange(len(free)))])
    simplex = np.clip(simplex, np.log([n.low for n in free]), np.log([n.high for n in free]))

    def changes_of(x: Array) -> dict[str, Any]:
        """Return the changes of the card that set the free numbers to exp(x)."""
        changes: dict[str, Any] = {}
        for number, value in zip(free, np.exp(x), strict=True):
            key = f"{number.entry}_{number.suffix}" if number.suffix else number.entry
            if number.place is None:
                changes[key] = written(value, number.suffix)
            else:
                present = [written(v, number.suffix) for v in getattr(card, number.entry)]
                changes.setdefault(key, present)[number.place] = written(value, number.suffix)
        return changes

    def cost(x: Array) -> float:
        """Return ln 2σ plus a penalty for overtime."""
        try:
            flight = smooth_flight(request, maneuver, changes_of(x))
            bound = float(np.mean(known_noise_two_sigma(request, flight)))
        except (SimulationError, NoAnswerError, BadInputError):
            return _UNFLYABLE
        finally:
            step()
        side = max(float(np.ptp(flight[f"position_{axis}"])) for axis in ("north", "east"))
        if request.box is not None and side > request.box:
            return _UNFLYABLE
        return float(np.log(bound) + _OVERTIME * max(0.0, np.log(flight.duration / 60.0 / minutes)))

    found = minimize(
        cost,
        start,
        method="Nelder-Mead",
        bounds=[(np.log(n.low), np.log(n.high)) for n in free],
        options={"maxfev": flights, "initial_simplex": simplex, "xatol": 0.02, "fatol": 0.003},
    )
    return Search(maneuver, changes_of(found.x), int(found.nfev))


# Forecast all maneuvers of a request, rank them, and improve the card of the best one.

GENTLE_BANK = 35.0 * DEGREE  # a maneuver of 30° bank stays below it, overshoot included
_LEAST_GAIN = 0.99  # an improved card must have at most this share of the given one's bound,
_MOST_MINUTES = 1.02  # in at most this share of its minutes


def plan(
    request: PlanRequest | Case,
    search_flights: int = SEARCH_FLIGHTS,
    step: Callable[[], None] = lambda: None,
) -> Plan:
    """Predict the 2σ bound of every maneuver of a request, choose the maneuver to fly, and improve
    its card.

    A case stands for the request of what it expects, with its own data system. The search for a
    better card uses `search_flights` simulated flights, none where it is 0. `step` is called after
    each maneuver and each flight of the search. Raises NoAnswerError where no maneuver of the
    request can be flown.
    """
    if isinstance(request, Case):
        request = PlanRequest(request, request.das)
    found: list[Forecast] = []
    refused: dict[str, str] = {}
    for maneuver in request.maneuvers:
        try:
            found.append(forecast(request, maneuver))
        except (SimulationError, NoAnswerError, BadInputError) as error:
            refused[maneuver] = str(error)
        step()
    if not found:
        raise NoAnswerError(
            "no maneuver can be flown or determines the curve: " + "; ".join(refused.values())
        )
    ranked = sorted(found, key=lambda each: plan_merit(request, each))
    fitting = [each for each in ranked if each.fits(request.box)]
    allowed = [
        each for each in fitting if request.minutes is None or each.minutes <= request.minutes
    ]
    gentle = [each for each in allowed if each.steepest_bank <= GENTLE_BANK]
    best, improved, flights = allowed[0] if allowed else None, None, 0
    if best is not None and search_flights > 0 and free_numbers(best.maneuver):
        # The limit of the search is the minutes of the request, flown once, or those that the card
        # takes now.
        minutes = (
            best.minutes if request.want is not None or request.minutes is None else request.minutes
        )
        search = best_card(request, best.maneuver, minutes, search_flights, step)
        flights, tried = search.flights, forecast(request, best.maneuver, search.card)
        if (
            tried.mean < _LEAST_GAIN * best.within(minutes)
            and tried.minutes < _MOST_MINUTES * minutes
        ):
            improved = tried
    return Plan(
        conditions=conditions_of(request),
        forecasts=tuple(ranked),
        refused=refused,
        best=best,
        gentle=gentle[0] if gentle else None,
        improved=improved,
        flights_searched=flights,
        minutes=request.minutes,
        want=request.want,
        box=request.box,
    )


def conditions_of(request: PlanRequest) -> str:
    """Return the expected conditions in words."""
    base, (low, high) = request.base, request.range
    return (
        f"{base.aircraft}, {base.altitude / FOOT:,.0f} ft, {request.das.label} Hz, turbulence "
        f"{base.turbulence}, "
        f"wind {base.wind.speed / KNOT:.0f} kt from {base.wind.from_direction / DEGREE:03.0f}°, "
        f"{low / KNOT:.0f} to {high / KNOT:.0f} KIAS"
    )


def plan_merit(request: PlanRequest, each: Forecast) -> float:
    """Return the number that ranks a maneuver; the smallest is the best.

    It is the minutes to the wanted 2σ; else 2σ [m/s] after as many whole flights as fit into the
    minutes; else 2σ [m/s] for equal minutes.
    """
    if request.want is not None:
        return each.times_for(request.want) * each.minutes
    if request.minutes is not None:
        return each.within(request.minutes)
    return each.mean_in(COMPARED_MINUTES)
