"""Level legs: their air, and the true airspeed and wind that fixed-speed methods find from them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.options import WITHOUT_TEMPERATURE, Accuracies
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.legs import FixedSpeedResult
from pitotbench.units import (
    DEGREE,
    Array,
    Booleans,
    Kelvin,
    MetersPerSecond,
    Pascal,
    Radians,
    Seconds,
)

_PART = 1e-3  # of a stated accuracy, the step of the difference: a zero offset may exceed q_c
_LEAST_STATIC = 0.1  # of the indicated pressure: a wild correction leaves the air some
_STEP = 0.05  # m/s, of the difference by which airspeeds are differentiated


@dataclass(frozen=True, slots=True)
class LegAir:
    """The indicated air of legs, (n,), or the means of a group, (1,).

    `impact_pressure` and `static_pressure` [Pa] are indicated. `probe_heating` [-] is 0.2 r for a
    probe of total temperature [K] and 0 for air temperature. `static_error` states whether the
    pressure error is the static source's, and `standard_day` whether the temperature is that of a
    standard day.
    """

    impact_pressure: Pascal
    static_pressure: Pascal
    probe_temperature: Kelvin
    probe_heating: float = 0.0
    static_error: bool = True
    standard_day: bool = False

    def at(self, rows: Booleans | NDArray[np.intp]) -> "LegAir":
        """The chosen rows."""
        return replace(
            self,
            impact_pressure=self.impact_pressure[rows],
            static_pressure=self.static_pressure[rows],
            probe_temperature=self.probe_temperature[rows],
        )

    @property
    def indicated_airspeed(self) -> MetersPerSecond:
        """Indicated airspeed [m/s]."""
        return air.calibrated_airspeed(self.impact_pressure)

    def true_airspeed(self, correction: MetersPerSecond | float = 0.0) -> MetersPerSecond:
        """True airspeed [m/s] with corrections of the indicated airspeed [m/s].

        Where the static source errs the total pressure is right: p = p_i + q_ci − q_c.
        """
        impact = air.impact_pressure(self.indicated_airspeed + correction)
        moved = self.impact_pressure - impact if self.static_error else 0.0
        static = np.maximum(self.static_pressure + moved, _LEAST_STATIC * self.static_pressure)
        mach = air.mach_from_impact_pressure(impact, static)
        heating = 1.0 + self.probe_heating * mach**2
        return np.asarray(mach * air.sound_speed(self.probe_temperature / heating))

    def calibrated_airspeed(self, true_airspeed: MetersPerSecond | float) -> MetersPerSecond:
        """Calibrated airspeed [m/s] for a true airspeed [m/s].

        Where the error is the static source's, the total pressure has none: p (1 + q/p) = p_i +
        q_i.
        """
        ratio = impact_ratio(true_airspeed, self.probe_temperature, self.probe_heating)
        pressure = self.static_pressure
        if self.static_error:
            pressure = (self.static_pressure + self.impact_pressure) / (1.0 + ratio)
        return air.calibrated_airspeed(pressure * ratio)

    def slope(self, correction: MetersPerSecond | float) -> Array:
        """dV_t/dΔV [-], (n,)."""
        up, down = self.true_airspeed(correction + _STEP), self.true_airspeed(correction - _STEP)
        return (up - down) / (2.0 * _STEP)

    def temperature_slope(self, correction: MetersPerSecond | float) -> Array:
        """dV_t/dT [m/s per K], (n,): a true airspeed is proportional to √T."""
        return self.true_airspeed(correction) / (2.0 * self.probe_temperature)

    def corrected(
        self, true_airspeed: float, two_sigma: float, stated: Accuracies
    ) -> tuple[float, float]:
        """Return the correction [m/s] for a true airspeed, and its 2σ.

        The 2σ is that of the true airspeed [m/s] and of the stated accuracies.
        """
        here, there = self.calibrated_airspeed(np.array([true_airspeed, true_airspeed + _STEP]))
        of_air = self.stated_two_sigma(true_airspeed, stated)
        bound = float(np.hypot((there - here) / _STEP * two_sigma, of_air))
        return float(here - self.indicated_airspeed), bound

    def stated_two_sigma(self, true_airspeed: float, stated: Accuracies) -> float:
        """Return 2σ of calibrated airspeed [m/s] by stated accuracies, at a true airspeed [m/s].

        The errors are independent. Those of GPS velocity change the wind alone, and a latency
        changes nothing at constant airspeed. A zero offset belongs to the correction, which is
        added to the raw reading: it only moves the total pressure, from which the true static
        pressure is found.
        """
        here = self.calibrated_airspeed(true_airspeed)
        parts = [
            (moved.calibrated_airspeed(true_airspeed) - here) / _PART
            for moved in self._each_moved(stated)
        ]
        return float(np.linalg.norm(parts))

    def _each_moved(self, stated: Accuracies) -> Iterator["LegAir"]:
        """Yield this air with one quantity at a time changed by a small part of its accuracy."""
        temperature = max(stated.temperature_k, WITHOUT_TEMPERATURE if self.standard_day else 0.0)
        recovery = 0.2 * stated.recovery_factor if self.probe_heating > 0.0 else 0.0
        for field, accuracy in (
            ("probe_temperature", temperature),
            ("probe_heating", recovery),
            ("static_pressure", stated.static_pressure_pa),
            ("impact_pressure", stated.impact_pressure_zero_pa),
        ):
            yield replace(self, **{field: getattr(self, field) + _PART * accuracy})


def impact_ratio(
    true_airspeed: MetersPerSecond | float,
    probe_temperature: Kelvin | float,
    probe_heating: float,
) -> Array:
    """Return q_c/p for a true airspeed [m/s] and a probe temperature [K].

    The air has T = T_t − 0.2 r V²/(γR).
    """
    heating = probe_heating * np.square(true_airspeed) / (air.HEAT_RATIO * air.GAS_CONSTANT)
    return air.impact_pressure_from_true_airspeed(true_airspeed, 1.0, probe_temperature - heating)


# Three legs: exact (Gray, National Test Pilot School, 1998). Four legs: the mean of the four
# three-leg answers. Their spread (standard deviation) is a measure of how steady wind and airspeed
# were. A turn and more legs: a circle.

_ILL_CONDITIONED = 1e6  # condition number: beyond it the tracks are practically the same
_LEAST_SPEED = 1e-3  # m/s, below which a velocity has no direction
_STEPS = 6  # of Gauss-Newton, which converges in three or four
_METHODS = {3: "three_leg", 4: "four_leg"}
_ROUNDS = 40  # at most
_LAST_STEP = 1e-9  # m/s, of the last step
_SAME_TRACK = 30.0 * DEGREE  # pieces whose tracks differ by less are one leg


def fixed_speed(ground_speed: MetersPerSecond, track: Radians) -> FixedSpeedResult:
    """Solve three or four legs flown at one true airspeed.

    Parameters: ground speed [m/s] and true track [rad] of each leg, shape (3,) or (4,). Raises
    BadInputError for another number of legs or non-positive speeds, NoAnswerError for tracks that
    are too similar.
    """
    speed, angle = np.asarray(ground_speed, dtype=np.float64), np.asarray(track, dtype=np.float64)
    if speed.shape != angle.shape or speed.shape not in ((3,), (4,)):
        raise BadInputError(
            f"give three or four legs, a speed and a track each; got {speed.size} and {angle.size}"
        )
    if not np.all(np.isfinite(speed) & np.isfinite(angle)) or not np.all(speed > 0.0):
        raise BadInputError("ground speeds must be positive numbers and tracks numbers")
    velocity = np.stack([speed * np.cos(angle), speed * np.sin(angle)], axis=1)
    (airspeed, *wind), spread = answer_of_legs(velocity)
    return FixedSpeedResult(float(airspeed), spread, float(np.hypot(*wind)), wind_from(wind))


def wind_from(wind: Array | list[float]) -> float:
    """Return the direction from which a wind (north, east) comes [rad, 0 to 2π]."""
    return float(np.arctan2(-wind[1], -wind[0]) % (2.0 * np.pi))


def answer_of_legs(velocity: Array) -> tuple[Array, float | None]:
    """Return [V, W_N, W_E] [m/s] from the ground velocities of legs, (n, 2), by their number.

    With it comes the spread of the answers of three among four legs, None for other numbers. Raises
    NoAnswerError for tracks that are too similar.
    """
    answers = np.array([circle_fit(velocity[legs]) for legs in _circles(len(velocity))])
    spread = float(answers[:, 0].std(ddof=1)) if len(answers) > 1 else None
    return answers.mean(axis=0), spread


def _circles(count: int) -> list[list[int]]:
    """The legs of each circle of the method: three of three or four, else all."""
    size = count if count > max(_METHODS) else min(_METHODS)
    return [list(legs) for legs in combinations(range(count), size)]


def leg_gain(velocity: Array) -> Array:
    """Return the change of `answer_of_legs` per 1 m/s of each leg along its path, (n, 3) [-]."""
    circles, gain = _circles(len(velocity)), np.zeros((len(velocity), 3))
    for legs in circles:
        gain[legs] += circle_gain(velocity[legs], circle_fit(velocity[legs])) / len(circles)
    return gain


def unit(vectors: Array) -> Array:
    """Return vectors (..., 2) with a length of one."""
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(size, _LEAST_SPEED))


def turn_between(one: Array | float, other: Array | float) -> Array:
    """Return the angle from one track to another [rad], within half a turn."""
    return np.asarray((np.asarray(one) - np.asarray(other) + np.pi) % (2.0 * np.pi) - np.pi)


def circle_fit(velocity: Array) -> Array:
    """Fit a circle to ground velocities (n, 2) at one airspeed: return [V, W_N, W_E] [m/s].

    These are true airspeed and wind. Least squares of the distances from the circle, by
    Gauss-Newton from the algebraic fit (Kåsa 1976). Raises NoAnswerError where the velocities are
    too similar.
    """
    columns = np.column_stack([2.0 * velocity, np.ones(len(velocity))])
    if len(velocity) < 3 or np.linalg.cond(columns) > _ILL_CONDITIONED:
        raise NoAnswerError(
            "the tracks do not determine the wind: fly three at least 60° apart, or a full turn"
        )
    north, east, rest = np.linalg.lstsq(columns, np.sum(velocity**2, axis=1))[0]
    answer = np.array([np.sqrt(rest + north**2 + east**2), north, east])
    for _ in range(_STEPS):
        left = np.linalg.norm(velocity - answer[1:], axis=1) - answer[0]
        jacobian = np.column_stack([np.ones(len(velocity)), unit(velocity - answer[1:])])
        step = np.linalg.lstsq(jacobian, left)[0]
        answer = answer + step
        if np.max(np.abs(step)) < _LAST_STEP:
            break
    return answer


def circle_gain(velocity: Array, answer: Array) -> Array:
    """Return the change of `circle_fit` per 1 m/s of each velocity along its path, (n, 3) [-].

    Parameters: velocity (n, 2) [m/s]; answer [V, W_N, W_E] [m/s]. By the implicit function theorem:
    the gradient of the fit, the sum of r (1, u) with residuals r and unit vectors u of the flight
    path, remains zero. A step along u changes r alone.
    """
    along = unit(velocity - answer[1:])
    distance = np.linalg.norm(velocity - answer[1:], axis=1)
    jacobian = np.column_stack([np.ones(len(velocity)), along])
    curvature = jacobian.T @ jacobian
    bend = (distance - answer[0]) / distance  # the residuals turn the unit vectors a little
    curvature[1:, 1:] += bend.sum() * np.eye(2) - (along * bend[:, None]).T @ along
    return np.linalg.solve(curvature, jacobian.T).T


# Legs of a log, a second a row, and legs of a card, a leg a row, are one problem. The airspeed
# varies a little within a group. The difference of the indicated true airspeed from the group's
# mean is subtracted from each ground velocity, along the flight path. Then the methods' formulas
# apply as published.


def by_track(toward: Array) -> NDArray[np.intp]:
    """Return the leg number, (n,), of each piece along unit vectors (n, 2), one for a track."""
    from scipy.sparse.csgraph import connected_components  # slow to load

    near = toward @ toward.T >= np.cos(_SAME_TRACK)
    return np.asarray(connected_components(near, directed=False)[1], dtype=np.intp)


@dataclass(frozen=True, slots=True)
class Legs:
    """Rows (n,) in the order of `time`: seconds of a log, or legs of a card.

    `air` is that of each row. `toward` (n, 2) is the unit vector of the track, or of the heading
    where `by_heading`. `leg` is the number of each row's leg or piece of flight; in a turn each row
    is a leg.
    """

    air: LegAir
    time: Seconds
    ground_speed: MetersPerSecond
    toward: Array
    by_heading: Booleans
    leg: NDArray[np.intp]
    turning: bool = False

    @property
    def track(self) -> Radians:
        """The track or heading without jumps [rad], (n,)."""
        return np.unwrap(np.arctan2(self.toward[:, 1], self.toward[:, 0]))

    def at(self, rows: Booleans | NDArray[np.intp]) -> "Legs":
        """The chosen rows."""
        return replace(
            self,
            air=self.air.at(rows),
            time=self.time[rows],
            ground_speed=self.ground_speed[rows],
            toward=self.toward[rows],
            by_heading=self.by_heading[rows],
            leg=self.leg[rows],
        )

    def pieces(self) -> list["Legs"]:
        """The rows of each number of `leg`, in the order of the numbers."""
        order = np.argsort(self.leg, kind="stable")
        first = np.flatnonzero(np.diff(self.leg[order], prepend=-1))
        return [self.at(rows) for rows in np.split(order, first[1:])] if len(order) else []

    def leg_means(self, data: Array) -> Array:
        """Means of (n, k) data over each leg, (legs, k)."""
        sums = [np.bincount(self.leg, column) for column in data.T]
        return np.stack(sums, axis=1) / np.bincount(self.leg)[:, None]

    def mean_air(self) -> LegAir:
        """The mean air. Every leg has the same weight, as in the methods' airspeed."""
        channels = self.air.true_airspeed(), self.air.static_pressure, self.air.probe_temperature
        airspeed, pressure, probe = self.leg_means(np.column_stack(channels)).mean(axis=0)
        impact = pressure * impact_ratio(airspeed, probe, self.air.probe_heating)
        return replace(
            self.air,
            impact_pressure=impact,
            static_pressure=pressure,
            probe_temperature=probe,
        )


@dataclass(frozen=True, slots=True)
class SolvedGroup:
    """A group at about one airspeed, its mean air, and its answer [V, W_N, W_E] [m/s].

    `velocity` (n, 2) [m/s] is brought to one airspeed, `along` (n, 2) the flight path, `residual`
    (n,) [m/s] that of ground velocity against airspeed and wind. `gain` (n, 3) is the change of the
    answer per residual of each row [-]. `spread` [m/s] is the standard deviation of the three-leg
    answers of four legs, or of the residual for a turn and for more legs.
    """

    group: Legs
    air: LegAir
    method: str
    velocity: Array
    answer: Array
    spread: float | None
    along: Array
    residual: Array
    gain: Array


def solve_group(group: Legs) -> SolvedGroup:
    """Solve a group by the method of its number of legs.

    Raises NoAnswerError for tracks that do not determine the wind.
    """
    air, airspeed = group.mean_air(), group.air.true_airspeed()
    off = (airspeed - air.true_airspeed())[:, None]
    velocity = group.ground_speed[:, None] * group.toward
    answer, spread = np.array([float(airspeed.mean()), 0.0, 0.0]), None
    for _ in range(_ROUNDS):
        drifted = (answer[0] + off) * group.toward + answer[1:]
        path = np.where(group.by_heading[:, None], unit(drifted), group.toward)
        moved = group.ground_speed[:, None] * path
        velocity = moved - off * unit(moved - answer[1:])
        before = answer
        answer, spread = answer_of_legs(group.leg_means(velocity))
        if np.max(np.abs(answer - before)) < _LAST_STEP:
            break
    along = unit(velocity - answer[1:])
    residual = np.linalg.norm(velocity - answer[1:], axis=1) - answer[0]
    legs = group.leg_means(velocity)
    share = np.sum(along * unit(legs - answer[1:])[group.leg], axis=1)
    share = share / np.bincount(group.leg)[group.leg]
    gain = share[:, None] * leg_gain(legs)[group.leg]
    if len(legs) > max(_METHODS):
        spread = float(residual.std(ddof=3))
    method = "turn" if group.turning else _METHODS.get(len(legs), "many_leg")
    return SolvedGroup(group, air, method, velocity, answer, spread, along, residual, gain)
