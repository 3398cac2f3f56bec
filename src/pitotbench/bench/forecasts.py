"""Predict the bound of a card before it is flown, from a flight in smooth air with random gusts."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from pitotbench.bench.gusts import MEAN_LENGTH, gust_deviation, with_gusts
from pitotbench.calibration.expected_bound import (
    ExpectedNoise,
    expected_two_sigma,
    two_sigma_in_gusts,
)
from pitotbench.calibration.options import AUTO, CalibrationOptions
from pitotbench.campaigns.flights import briefing_of, sense, wind_toward
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, DataSystem, rates_for
from pitotbench.records.case_file import read_case, write_case
from pitotbench.records.flight import Flight
from pitotbench.records.forecast import Forecast
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import read_record
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.sortie import fly, speed_range, with_usual_curve
from pitotbench.timeline import gaps
from pitotbench.units import KNOT, Array, MetersPerSecond, from_si

# Numbers of a card, or lists of them, by their keys with a unit's suffix.
CardChanges = Mapping[str, float | list[float]]
_CURVE_STEP = 5.0 * KNOT  # between the airspeeds at which a bound is predicted
_NARROWEST = 20.0 * KNOT  # range of airspeed that a plan may ask for
_FEWEST_DRAWS = 2  # flights in gusts, of which the bound is averaged


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
        """The airspeeds [m/s], (n,), at which the bound is averaged: every 5 kt of the range."""
        low, high = self.range
        steps = np.arange(int((high - low) / _CURVE_STEP + 1e-6) + 1, dtype=np.float64)
        return np.asarray(low + _CURVE_STEP * steps, dtype=np.float64)

    def case(self, maneuver: str, card: CardChanges | None = None) -> Case:
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
    """Return an SI value as a card's file has it, in the unit of a suffix, to a millionth.

    The suffix of a count is "".
    """
    return round(float(from_si(value, suffix) if suffix else value), 6)


_CHANNELS = (
    *CALIBRATION_CHANNELS, "true_airspeed", "wind_north", "wind_east", "wind_down", "roll", "position_north",
    "position_east", "heading", "calibrated_airspeed",
)  # fmt: skip
_KEPT_FLIGHTS = 16  # in memory, of the maneuvers that a plan compares


def forecast(request: PlanRequest, maneuver: str, card: CardChanges | None = None) -> Forecast:
    """Predict the bound of a maneuver, with the numbers of its card that are in `card` changed.

    Raises SimulationError where the card cannot be flown, NoAnswerError where it does not determine
    the answer.
    """
    flight = smooth_flight(request, maneuver, card)
    drawn = (with_gusts(flight, request.base.turbulence, n + 1) for n in range(request.draws))
    logs = [sense(each, request.das) for each in drawn]
    bounds = two_sigma_in_gusts(logs, *_expected(request), request.airspeeds)
    return Forecast(
        maneuver=maneuver,
        card=dict(card or {}),
        minutes=flight.duration / 60.0,
        elapsed_minutes=flight.elapsed / 60.0,
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
    """Return the ground track, north and east [m], (2, k), one point a second.

    A point is NaN where nothing was recorded.
    """
    time = flight["time"]
    rows = np.flatnonzero(np.diff(np.floor(time - time[0]), prepend=-1.0) > 0.0)
    track = np.stack([flight["position_north"][rows], flight["position_east"][rows]])
    return np.insert(track, gaps(time[rows]), np.nan, axis=1)


def smooth_flight(request: PlanRequest, maneuver: str, card: CardChanges | None = None) -> Flight:
    """Return the flight of a maneuver in smooth air. The last few are kept in memory.

    Where the airplane is one of the bench, the rate is the slowest that fits the data system:
    `python -m tests.simulation.rates` measures what that changes. A fast airplane of JSBSim's
    library may need the usual rate.
    """
    case = replace(request.case(maneuver, card), das=request.das)
    attached = read_record(find_aircraft(case.aircraft)) is not None
    rate = case.integration_rate if attached else rates_for(request.das.air_rate)[0]
    return _flown(write_case(replace(case, integration_rate=rate)))


@lru_cache(_KEPT_FLIGHTS)
def _flown(case: str) -> Flight:
    return fly(read_case(case), channels=_CHANNELS)


def known_noise_two_sigma(request: PlanRequest, flight: Flight) -> MetersPerSecond:
    """Return 2σ [m/s] at the request's airspeeds, by the information in gusts of expected level.

    The noise is known: the bound is that of the information matrix.
    """
    return expected_two_sigma(sense(flight, request.das), *_expected(request), request.airspeeds)


def _expected(request: PlanRequest) -> tuple[CalibrationOptions, Array, ExpectedNoise]:
    """Return options with the error's expected place, the wind north and east, and the noise.

    The calibrator finds the place from the height, or assumes the published one: to leave it open
    moves the bound by at most 0.3 %, and takes half as long again.
    """
    das, location = request.das, request.options.error_location
    noise = ExpectedNoise(
        gust_deviation=gust_deviation(request.base),
        gust_length=MEAN_LENGTH,
        height_deviation=das.altitude_drift,
        height_memory=das.altitude_drift_time,
        height_white=das.altitude_noise,
        height_walk=das.velocity_noise / das.gps_rate**0.5,
    )
    if location == AUTO:
        location = request.base.pressure_error.location
    wind = np.array(wind_toward(request.base.wind)[:2])
    return replace(request.options, error_location=location), wind, noise
