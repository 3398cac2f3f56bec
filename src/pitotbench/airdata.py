"""What an air-data reading follows: one linear regression for all who ask.

An impact pressure follows the square of the speed through the air and nothing else. With q = k·V²
and the ground velocity v = V + w, the reading of a sound system is

    q = a·k·v² − 2a·k·v·w + constant,   a = 1,

which is linear in a, the wind and the zero. The wind changes along the flight as a random walk
does, in straight lines between knots. A further column asks for what else a reading may follow.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.normal_equations import inverse
from pitotbench.scatter import white_differences
from pitotbench.units import KNOT, Array, Booleans

# Channels that the regression is of.
NEEDED = ("time", "impact_pressure", "static_pressure", "velocity_north", "velocity_east")
TAXI = 20.0 * KNOT  # m/s over the ground: no airplane taxies faster, and none flies so slowly


@dataclass(frozen=True, slots=True)
class RegressionLimits:
    """What the regression knows before a log is looked at; SI, ratios without unit."""

    block: float = 2.0  # s, over which rows are averaged: usual 1 to 5
    lasting: float = 20.0  # s, in which gusts and pilots err alike: usual 10 to 60
    window: float = 1800.0  # s of a log that are judged together: usual 900 to 3600
    knot: float = 300.0  # s between the knots of the wind: a turn on all headings or two
    wind: float = 12.0  # m/s, 1σ of a component of the wind low down
    # of the speed, added to it: who flies fast flies high, where winds are strong
    wind_share: float = 0.1
    wind_walk: float = 1.0  # m/s, 1σ of the change of a component in a minute: a wave has more
    zero: float = 100.0  # Pa, 1σ of the zero of a gauge
    fewest: int = 30  # blocks of a part that is judged
    flying: float = 0.4  # of the largest ground speeds: slower is taxi, take-off or landing
    rounds: int = 20  # of finding the scatter of a fit, at most
    squares: int = 3  # fits until the square of the wind is known
    settled: float = 1.01  # times the scatter before, at which it is found
    nothing: float = 1e-6  # a, that rounding leaves of a reading that stands still
    rows: int = 2000  # that a mean wind is found from: more add nothing
    far: float = 5.0  # times the median of the speed, or of what is left: such a row is faulty
    rest: float = 1.5  # m/s over the ground, below which the airplane stands
    settle: float = 8.0  # s at rest that show a zero, at least: usual 5 to 30
    steady: float = 1.5  # times what the reading scatters at rest: a wind on the ground is gusty
    passes: int = 3  # of leaving these out


LIMITS = RegressionLimits()


@dataclass(frozen=True, slots=True)
class Part:
    """Rows or block means of a part of a log in flight, (n,) each.

    The clock [s], reading, static pressure and ambient pressure [Pa], k [Pa s²/m²], ground
    velocity, its size and the speed of sound [m/s]. `ambient` is that of the receiver's height, in
    the standard atmosphere, where the log has one (`by_height`), else the static pressure.
    """

    time: Array
    impact: Array
    static: Array
    ambient: Array
    density: Array
    north: Array
    east: Array
    speed: Array
    sound: Array
    by_height: bool

    def rows(self, which: slice | Booleans) -> "Part":
        """Return some of the rows."""
        names = (n for n in self.__slots__ if n != "by_height")
        return replace(self, **{n: getattr(self, n)[which] for n in names})

    @property
    def clock(self) -> Array:
        """The time, −1 to 1."""
        return np.asarray(2.0 * (self.time - self.time[0]) / np.ptp(self.time) - 1.0)

    @property
    def square(self) -> Array:
        """k·v² [Pa]."""
        return np.asarray(self.density * self.speed**2)

    @property
    def slope(self) -> Array:
        """Impact pressure by airspeed [Pa s/m]: 2·k·v."""
        return 2.0 * self.density * self.speed

    @property
    def shared(self) -> float:
        """Rows for each that counts: gusts last, and rows within one say the same."""
        return max(LIMITS.lasting / float(np.median(np.diff(self.time))), 1.0)

    def shapes(self) -> Array:
        """The shapes of the wind in time, (n, m).

        The first is steady, and the others change from a knot to the next and last.
        """
        since = self.time - self.time[0]
        knots = self._knots()
        changes = [np.clip((since - at) / knots[1], 0.0, 1.0) for at in knots[:-1]]
        return np.stack([np.ones_like(since), *changes], axis=1)

    def wind(self) -> tuple[Array, Array]:
        """The columns of the winds, (n, 2m), and 1σ of their coefficients, (2m,).

        The columns are to be multiplied by a. The 1σ, of a wind and of the steps of a random walk,
        is known before the log is looked at.
        """
        shapes, knots = self.shapes(), self._knots()
        usual = LIMITS.wind + LIMITS.wind_share * float(np.median(self.speed))
        steps = [LIMITS.wind_walk * np.sqrt(knots[1] / 60.0)] * (len(knots) - 1)
        axes = [-2.0 * (self.density * v)[:, None] * shapes for v in (self.north, self.east)]
        return np.hstack(axes), np.array([usual, *steps, usual, *steps])

    def _knots(self) -> Array:
        length = float(self.time[-1] - self.time[0])
        return np.linspace(0.0, length, 1 + max(round(length / LIMITS.knot), 1))


def part_of(
    rows: Mapping[str, Array], temperature: Array | None = None, altitude: Array | None = None
) -> Part:
    """Return rows of a log by the names of its channels, (n,) each [SI].

    `temperature` [K] is that of the air, the standard one where it is not given.
    """
    static, north, east = (rows[n] for n in ("static_pressure", "velocity_north", "velocity_east"))
    ambient = static if altitude is None else air.standard_pressure(altitude)
    # The static pressure of a broken line may be any; that of the height is the receiver's.
    around = np.clip(ambient, 1e3, None)
    if temperature is None:
        temperature = air.standard_temperature(air.pressure_altitude(around))
    speed, sound = np.hypot(north, east), air.sound_speed(temperature)
    density = _per_square(speed, sound, around)
    time, impact, by_height = rows["time"], rows["impact_pressure"], altitude is not None
    return Part(time, impact, static, ambient, density, north, east, speed, sound, by_height)


def _per_square(speed: Array, sound: Array, ambient: Array) -> Array:
    """Impact pressure by the square of the speed [Pa s²/m²]."""
    speed = np.maximum(speed, 0.1)
    return np.asarray(air.impact_pressure_from_mach(speed / sound, ambient) / speed**2)


@dataclass(frozen=True, slots=True)
class Fit:
    """The regression of a reading: coefficients (p,), their covariance, and what it leaves (n,).

    `covariance` is (p, p); `columns` (m, p) are those on all rows, fitted or not.
    """

    values: Array
    covariance: Array
    left: Array
    columns: Array

    @property
    def errors(self) -> Array:
        """Standard errors, (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def rms(self) -> float:
        """Root mean square of what is left."""
        return float(np.sqrt(np.mean(self.left**2)))

    @property
    def asked(self) -> Array:
        """The reading that the fit asks for on all rows, (m,)."""
        return np.asarray(self.columns @ self.values)

    @property
    def unsure(self) -> Array:
        """Its standard error, (m,)."""
        variance = np.einsum("np,pq,nq->n", self.columns, self.covariance, self.columns)
        return np.asarray(np.sqrt(variance))


def regress(
    reading: Array,
    columns: Array,
    shared: float,
    sizes: Array | None = None,
    until: int | None = None,
) -> Fit:
    """Fit columns, (m, p), to a reading, (m,), by least squares; with `until`, on the first rows.

    `sizes` are 1σ of the coefficients about 0 before the log is looked at, (p,), and what is left
    says how much they weigh: both are found together, from nothing known on. Of `shared` rows one
    counts in the covariance.
    """
    matrix, shown = columns[:until], reading[:until]
    weight = np.zeros(matrix.shape[1]) if sizes is None else sizes**-2.0
    normal, target = matrix.T @ matrix, matrix.T @ shown
    scatter, before = 0.0, -1.0
    for _ in range(LIMITS.rounds):
        found = inverse(normal + np.diag(scatter * weight))
        values: Array = found @ target
        left: Array = shown - matrix @ values
        before, scatter = scatter, float(np.sum(left**2)) / max(len(left) - len(values), 1)
        scatter *= shared
        if sizes is None or scatter <= LIMITS.settled * before:
            break
    return Fit(values, found * scatter, left, columns)


@dataclass(frozen=True, slots=True)
class Followed(Fit):
    """What a reading follows: its share a of the speed first, then other columns and the zero.

    `wind` is that on all rows, (2, m) [m/s] toward north and east.
    """

    wind: Array


def follow(
    part: Part,
    reading: Array,
    *others: Array,
    until: int | None = None,
    zero: float = np.inf,
) -> Followed:
    """Fit a reading, (n,), by its share of the speed, other columns, a zero and a wind.

    The other columns are (n,) each. Of the `zero` 1σ is given [Pa]. With `until` the first rows are
    fitted.

    The wind moves the density k and, by its square, the zero: both are those of the fit before.
    """
    axes, sizes = part.wind()
    sizes = np.array([np.inf, *[np.inf] * len(others), zero, *sizes])
    shapes, around, ones = part.shapes(), np.clip(part.ambient, 1e3, None), np.ones_like(reading)
    square, times = part.square, ones
    for _ in range(LIMITS.squares):
        columns = np.column_stack([square, *others, ones, times[:, None] * axes])
        fit = regress(reading, columns, part.shared, sizes, until)
        share, error = fit.values[0], fit.errors[0]
        along = fit.values[-axes.shape[1] :].reshape(2, -1) @ shapes.T
        # A reading that follows nothing tells no wind.
        wind = along * share / max(share**2 + error**2, LIMITS.nothing**2)
        through = np.hypot(part.north - wind[0], part.east - wind[1])
        density = _per_square(through, part.sound, around)
        times = density / part.density
        square = density * (part.speed**2 + np.sum(wind**2, axis=0))
    return Followed(fit.values, fit.covariance, fit.left, fit.columns, wind)


def mean_wind(channels: Mapping[str, Any]) -> Array:
    """Return the wind, north and east, (2,) [m/s], that best fits ground velocity and airspeed.

    The airspeed may have any factor. The wind is 0 where the log does not tell. `channels` [SI] by
    name, (n,) each: those of `NEEDED`. Rows that are not finite or do not fit count for nothing.

    Source: the velocities lie on a circle around the wind (Kåsa, IEEE Transactions on
    Instrumentation and Measurement 25, 1976).
    """
    known = np.isfinite(np.sum([channels[name] for name in NEEDED], axis=0))
    here = np.flatnonzero(known & (channels["impact_pressure"] > 0.0))
    if len(here) < LIMITS.fewest:
        return np.zeros(2)
    here = here[:: max(len(here) // LIMITS.rows, 1)]
    part = part_of({name: channels[name][here] for name in NEEDED})
    part = part.rows(part.speed <= LIMITS.far * np.median(part.speed))
    for _ in range(LIMITS.passes):
        fit = follow(part, part.impact, zero=LIMITS.zero)
        left = np.abs(fit.left)
        part = part.rows(left <= LIMITS.far * np.median(left))
    return np.asarray(np.mean(fit.wind, axis=1))


def parts_of(channels: Mapping[str, Any]) -> Iterator[Part]:
    """Return the parts of a log in flight in means of blocks, each as long as one wind may last."""
    time, speed = channels["time"], np.hypot(channels["velocity_north"], channels["velocity_east"])
    fast = float(np.quantile(speed, 0.95))
    if fast < TAXI:
        return
    flying = speed > max(LIMITS.flying * fast, 0.5 * TAXI)
    del speed  # of a long log; what follows is of one part at a time
    count = int((time[-1] - time[0]) // LIMITS.window) + 1
    ends = np.searchsorted(time, time[0] + LIMITS.window * np.arange(1, count + 1))
    for first, last in pairwise([0, *ends.tolist()]):
        here = first + np.flatnonzero(flying[first:last])
        _, place, rows = np.unique(
            (time[here] - time[0]) // LIMITS.block, return_inverse=True, return_counts=True
        )
        if len(rows) < LIMITS.fewest:
            continue
        names = [*NEEDED, *(["altitude"] if "altitude" in channels else [])]
        means = {n: np.bincount(place, channels[n][here]) / rows for n in names}
        means["time"] = means["time"] - time[0]
        yield part_of(means, altitude=means.get("altitude"))


@dataclass(frozen=True, slots=True)
class Rest:
    """What the impact pressure reads while the airplane stands before or after its flight [Pa].

    The median of the means of blocks, the range that holds nine tenths of them, and the standard
    deviations of what changes from block to block and of the noise that the mean of all rows keeps.
    """

    reading_pa: float
    scatter_pa: float
    gusts_pa: float
    noise_pa: float


def rests_of(channels: Mapping[str, Any]) -> list[Rest]:
    """Return the rests before and after a flight that show the zero of a gauge.

    A rest lasts some seconds (`LIMITS.settle`). A display shows none: it stands at 0 whatever its
    zero is. `channels` [SI] by name, (n,) each: those of `NEEDED` without the static pressure.
    """
    time, impact = channels["time"], channels["impact_pressure"]
    moving = np.flatnonzero(
        np.hypot(channels["velocity_north"], channels["velocity_east"]) > LIMITS.rest
    )
    ends = [slice(0, moving[0]), slice(moving[-1] + 1, None)] if len(moving) else []
    rests = (_rest(time[end], impact[end]) for end in ends)
    return [each for each in rests if each is not None and each.scatter_pa > 0.0]


def _rest(time: Array, impact: Array) -> Rest | None:
    block = np.unique(time // LIMITS.block, return_inverse=True)[1]
    if LIMITS.block * (np.max(block, initial=-1) + 1) < LIMITS.settle:
        return None
    rows = np.bincount(block)
    means = np.bincount(block, impact) / rows
    low, reading, high = np.quantile(means, [0.05, 0.5, 0.95])
    white = float(np.mean(white_differences(impact) ** 2))
    gusts = max(float(np.var(means)) - white * float(np.mean(1.0 / rows)), 0.0)
    return Rest(float(reading), float(high - low), gusts**0.5, (white / len(impact)) ** 0.5)
