"""The altitude equation: static pressure against GPS height gives the static source's error.

The pressure is the indicated one.

p_i(t) = p_ref + ∫ −ρ g dh + Δp(q_ci) with Δp = q_c − q_ci, which is p_i − p where the total
pressure is right. It needs neither the wind nor, to first order, the temperature. Its noise does
not grow with the gusts: it is the error of the receiver's height, which has a white and a slow
part. Where the log has the vertical velocity, its integral is the height between fixes, and the
receiver's height only removes the drift of the integral. All these signals are slow, so means over
two to four seconds are enough. They are a few hundred rows, in meters. Background: Gracey, NASA
RP-1046 (1980), ch. 9; Jurado and McGehee, Journal of Aircraft 56 (2019).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.nuisances import ZERO, HeightState, Nuisance, load_factor
from pitotbench.calibration.observations import DENSE, FEWEST_FIXES, LONG, Observations
from pitotbench.calibration.options import (
    PRIORS,
    WITHOUT_TEMPERATURE,
    CalibrationOptions,
    Priors,
    accuracies_of,
    priors_of,
)
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.estimation.noise import UNIFORM
from pitotbench.estimation.point_noise import (
    PointNoise,
    UnknownColumns,
    ornstein_uhlenbeck,
    random_walk,
)
from pitotbench.estimation.restricted_likelihood import Regression
from pitotbench.records.log import FlightLog
from pitotbench.scatter import NORMAL, deviation_of_sizes, spikes_among, white_differences
from pitotbench.timeline import interval, pauses, stretch_numbers
from pitotbench.units import (
    KNOT,
    Array,
    Booleans,
    Kelvin,
    Meters,
    MetersPerSecond,
    Pascal,
    Seconds,
)

_BLOCK = 2.0  # s: short against the correlation time of a height error
_LONG_BLOCK = 4.0  # s: such blocks
_FEWEST_BLOCKS = 15
_EARTH = 6.357e6  # m, radius of the earth
_CORIOLIS = 1e-4  # 1/s, middle latitudes
_LEAST_WIND = 3.0  # m/s: least wind from which a pressure gradient is computed
_TENDENCY = 5.0  # Pa in ten minutes (1σ): change of the weather and drift of the transducer
# K (1σ): departure of the air between two heights from a straight line, as a temperature
_LAYER = 1.0
# Moist air is lighter, as warmer air is. Its humidity is unknown, from dry to saturated. Half of it
# is taken for the middle, and the deviation is that of a uniform distribution.
_HALF = 0.5  # of saturation: the middle of what the humidity can be
_LIGHTER = 0.378  # 1 less the ratio of the molar masses of water and dry air
_LAYER_DEPTH = 1000.0  # m, of a layer of the air
_MOST_LAYERS = 20
_FINE = 50  # steps in each layer
_SMOOTH = 0.1  # weight of a bend of the temperature's profile, relative to one reading
_LEAST_CLIMB = 60.0  # m: with a greater climb the lapse rate is taken from the log
_AT_REST = 1.0  # m/s over the ground
_NO_AIRSPEED = 10.0 * KNOT  # m/s: below it a reading is that of an airplane at rest
_FARTHEST = 6.8  # standard deviations: a row farther off is a fault; the limit of the screening in `reduction`
# Share of the level that the total source's slope has over half the flown range of ln q_ci: the
# error of a pitot tube hardly changes with the airspeed (Gracey, NASA RP-1046, 1980, ch. 3).
_TOTAL_SLOPE = 0.3
_LEAST_HALF = 0.005  # of the range of ln q_ci: over less there is no slope
_FLOOR = 1e-8  # m²: keeps the covariance regular for logs without noise


# The height of a log between the fixes of its receiver.


@dataclass(frozen=True, slots=True)
class CarriedHeight:
    """Height at every row of the log, from the fixes.

    `height` [m] is interpolated or the integral of the vertical velocity, and NaN where unknown.
    `part` is the stretch of every row. `fresh` marks new fixes, `fixes` are their rows, and
    `seconds` the usual interval between them. `offsets` [m] is the receiver's height minus the
    integral at `fixes`, None without vertical velocity.
    """

    height: Meters
    part: NDArray[np.intp]
    fresh: Booleans
    fixes: NDArray[np.intp]
    seconds: float
    offsets: Meters | None


def carried_height(log: FlightLog, latency: float, by_velocity: bool) -> CarriedHeight:
    """Compute the height of each stretch by itself, its fixes earlier by the `latency` [s]."""
    from scipy.interpolate import CubicSpline  # slow to load

    assert log.altitude is not None
    fresh = log.fresh_fixes()
    part = stretch_numbers(log.time, pauses(log.time))
    dense = bool(fresh.mean() > DENSE)
    height, at_fixes, offsets = np.full(len(log), np.nan), [], []
    for number in range(int(part[-1]) + 1):
        fixes = np.flatnonzero((part == number) & fresh)
        if len(fixes) < FEWEST_FIXES:
            continue
        knots, measured = log.time[fixes] - latency, log.altitude[fixes]
        inside = np.flatnonzero((part == number) & (log.time >= knots[0]) & (log.time <= knots[-1]))
        if by_velocity:
            assert log.velocity_down is not None
            integral, height[inside] = _integrated(
                knots, -log.velocity_down[fixes], log.time[inside], dense
            )
            start = float(np.median(measured - integral))
            height[inside] += start
            at_fixes.append(fixes)
            offsets.append(measured - integral - start)
        else:
            curve = np.interp(log.time[inside], knots, measured) if dense else None
            height[inside] = (
                CubicSpline(knots, measured)(log.time[inside]) if curve is None else curve
            )
    seconds = interval(log.time[fresh])
    fixes = np.concatenate(at_fixes) if at_fixes else np.flatnonzero(fresh)
    return CarriedHeight(
        height, part, fresh, fixes, seconds, np.concatenate(offsets) if offsets else None
    )


def _integrated(
    knots: Seconds, climb: MetersPerSecond, time: Seconds, dense: bool
) -> tuple[Meters, Meters]:
    """The integral [m] of a climb rate given at knots, at the knots and at other times."""
    from scipy.interpolate import CubicSpline  # slow to load

    if dense:
        rises = np.concatenate([[0.0], np.cumsum(0.5 * (climb[1:] + climb[:-1]) * np.diff(knots))])
        return rises, np.interp(time, knots, rises)
    integral = CubicSpline(knots, climb).antiderivative()
    return integral(knots), integral(time)


@dataclass(frozen=True, slots=True)
class AltitudeRows:
    """Block means, (n,), and their noise.

    `rise`: indicated static pressure minus that of the air column at the height, in meters of air.
    `state`: what the columns are made of. `tie`: the receiver's height minus the integral of its
    vertical velocity [m], None without vertical velocity. `sensor`, `fix`: white variances [m²];
    the latter is infinite where a block has no fix (without vertical velocity: one over the number
    of fixes). `first`: whether the block begins a stretch. `priors`: those of the noise. `unknown`:
    columns of the unknowns of this equation alone. `spread`: standard deviation of what the slow
    height error shows in [m].
    """

    time: Seconds
    rise: Meters
    state: HeightState
    tie: Meters | None
    sensor: Array
    fix: Array
    first: Booleans
    unknown: UnknownColumns
    spread: float
    priors: Priors = PRIORS

    def __len__(self) -> int:
        return len(self.time)

    def with_probe(self, deviation: float) -> "AltitudeRows":
        """The same rows with the error of the probe [K] among the unknowns of this equation."""
        precision = self.unknown.precision.copy()
        precision[-1] = 1.0 / (1.0 / precision[-1] + deviation**2)
        return replace(self, unknown=replace(self.unknown, precision=precision))

    @property
    def count(self) -> int:
        """Rows of the regression: one per block, and one more per block with a fix.

        A fix ties the integral of the vertical velocity.
        """
        return len(self) + (0 if self.tie is None else int(np.isfinite(self.fix).sum()))


def altitude_rows(
    log: FlightLog, obs: Observations, options: CalibrationOptions, wind: Array
) -> AltitudeRows | None:
    """Return the altitude rows of a log's used rows and rows at rest, None for a useless height.

    Parameters: log; obs; options, with the accuracy of the total source and the priors; wind (2,),
    roughly, toward north and east [m/s], which gives the size of the horizontal pressure gradient.
    """
    if log.altitude is None:
        return None
    carried = carried_height(log, options.gps_latency, obs.has_down)
    # Before take-off or after landing the static source has no error: height and pressure agree.
    still = np.hypot(log.velocity_north, log.velocity_east) < _AT_REST
    still &= log.impact_pressure < float(air.impact_pressure(_NO_AIRSPEED))
    rows = np.flatnonzero((obs.used | still) & np.isfinite(carried.height))
    if len(rows) < _FEWEST_BLOCKS:
        return None
    noise, spikes = _white_noise(log.static_pressure[rows])
    blocks = _divided(log, carried, rows[~spikes])
    if len(blocks.count) < _FEWEST_BLOCKS or float(np.ptp(log.altitude)) == 0.0:
        return None
    return _assembled(
        log,
        obs,
        carried,
        blocks,
        np.where(still, 0.0, log.impact_pressure),
        noise,
        wind,
        options,
    )


def altitude_regression(
    rows: AltitudeRows, model: PredictionModel | None, theta: Array, nuisances: Sequence[Nuisance]
) -> Regression:
    """Linearize the rows at θ (p,), in the unknowns of the wind triangle [m].

    An error that is not the static source's leaves the height to tell of the temperature. There are
    no unknowns where `model` is None.
    """
    response, regressors = (
        rows.rise,
        np.zeros((len(rows), 0 if model is None else model.count + len(nuisances))),
    )
    if model is not None:
        for place, nuisance in enumerate(nuisances, start=model.count):
            if nuisance.height is not None and (model.static_error or not nuisance.of_source):
                regressors[:, place] = nuisance.height(rows.state)
    if model is not None and model.static_error:
        free = model.error_count
        q = rows.state.impact_pressure
        basis = model.error.basis(np.maximum(q, 1.0) / model.reference_pressure)
        impact_share = 1.0 - basis @ theta[:free]
        response = rows.rise - rows.state.gain * q * (1.0 / impact_share - 1.0)
        regressors[:, :free] = basis * (rows.state.gain * q / impact_share**2)[:, None]
        for place, nuisance in enumerate(nuisances, start=model.count):
            if nuisance.name == ZERO:
                regressors[:, place] = _by_zero(rows, model, theta[:free], impact_share)
    if rows.tie is not None:
        ties = rows.tie[np.isfinite(rows.fix)]
        response = np.concatenate([response, ties])
        regressors = np.concatenate([regressors, np.zeros((len(ties), regressors.shape[1]))])
    return Regression(response, regressors, regressors, np.zeros(regressors.shape[1]))


def _by_zero(rows: AltitudeRows, model: PredictionModel, k: Array, impact_share: Array) -> Array:
    """Change of the rows per pascal of zero offset, (n,) [m/Pa].

    The ports see the reading minus the offset.

    At rest they see nothing, whatever the reading is.
    """
    q, reference = rows.state.impact_pressure, model.reference_pressure
    bend = model.error.curve(np.maximum(q, 1.0) / reference, k)[1] / reference
    return np.where(
        q > 0.0, -rows.state.gain * ((1.0 / impact_share - 1.0) + q * bend / impact_share**2), 0.0
    )


def virtual_temperature_rise(temperature: float, pressure: float) -> float:
    """Return by how much saturated air is lighter, as a temperature [K].

    Parameters: temperature [K]; pressure [Pa].

    Source: Alduchov and Eskridge, Journal of Applied Meteorology 35 (1996), eq. 21, for the vapor
    pressure.
    """
    celsius = temperature - 273.15
    vapor = 610.94 * float(np.exp(17.625 * celsius / (celsius + 243.04)))
    return _LIGHTER * vapor / pressure * temperature


def _white_noise(values: Array) -> tuple[float, Booleans]:
    """Return the deviation of the white noise of values (n,), and which are spikes, (n,).

    A spike differs from both neighbors. The deviation comes from second differences, in which slow
    signals cancel.
    """
    second = np.abs(white_differences(values))
    noise = deviation_of_sizes(second)
    # Values without noise have no scale by which a difference could be too large.
    return noise, spikes_among(second, _FARTHEST * noise if noise > 0.0 else np.inf)


@dataclass(frozen=True, slots=True)
class _Blocks:
    """The chosen rows, the block of each, (rows,), non-decreasing, and rows per block, (n,)."""

    rows: NDArray[np.intp]
    index: NDArray[np.intp]
    count: Array

    def mean(self, values: Array) -> Array:
        """Block means of values at all rows of the log."""
        return np.asarray(np.bincount(self.index, values[self.rows], len(self.count)) / self.count)


def _divided(log: FlightLog, carried: CarriedHeight, rows: NDArray[np.intp]) -> _Blocks:
    """Divide rows into blocks of 2 s, in long logs 4 s, none across a gap.

    A longer fix interval makes longer blocks.
    """
    length = max(_LONG_BLOCK if len(log) * interval(log.time) > LONG else _BLOCK, carried.seconds)
    cell = np.floor((log.time - log.time[0]) / length).astype(np.intp)
    cell += carried.part * (int(cell[-1]) + 2)
    _, index, count = np.unique(cell[rows], return_inverse=True, return_counts=True)
    return _Blocks(rows, index, count.astype(np.float64))


def _assembled(
    log: FlightLog,
    obs: Observations,
    carried: CarriedHeight,
    blocks: _Blocks,
    impact_pressure: Pascal,
    noise: float,
    wind: Array,
    options: CalibrationOptions,
) -> AltitudeRows:
    static, impact = blocks.mean(log.static_pressure), blocks.mean(impact_pressure)
    height = blocks.mean(carried.height)
    height = height / (1.0 + height / _EARTH)  # geopotential: gravity falls with height
    profile = _air_temperature(log, obs, blocks, impact, static, height)
    moist = virtual_temperature_rise(
        float(np.median(profile.temperature)), float(np.median(static))
    )
    profile = replace(profile, temperature=profile.temperature + _HALF * moist)
    column = np.exp(-air.GRAVITY / air.GAS_CONSTANT * profile.thinness(height))
    column *= float(np.mean(static / column))
    # By the column's pressure: a gain by the reading would put the rows into their own columns.
    gain = air.GAS_CONSTANT * profile.at(height) / (column * air.GRAVITY)
    tie, fix = _ties(carried, blocks)
    velocity = np.stack([blocks.mean(log.velocity_north), blocks.mean(log.velocity_east)])
    time = blocks.mean(log.time)
    load, climb = _load(velocity - wind[:, None], time), np.gradient(height, time)
    rows = AltitudeRows(
        time=time,
        rise=gain * column * np.log(static / column),
        state=HeightState(gain, impact, load, climb, profile.temperature_slope(height)),
        tie=tie,
        sensor=(gain * noise) ** 2 / blocks.count + _FLOOR,
        fix=fix,
        first=np.diff(blocks.mean(carried.part.astype(np.float64)), prepend=-1.0) != 0.0,
        unknown=UnknownColumns(np.zeros((0, 0)), np.zeros(0)),
        spread=1.0,
        priors=priors_of(options.priors),
    )
    layer = float(np.hypot(_LAYER, UNIFORM * moist))
    layers = profile.layers(height)
    unknown = _unknowns(rows, column, velocity, wind, layers, layer, obs.standard_day)
    total_source = 0.5 * accuracies_of(options.accuracies, {}).total_source
    if total_source > 0.0:
        unknown = _with_total_source(unknown, rows, total_source)
    measured = rows.rise if tie is None else tie[np.isfinite(fix)]
    return replace(rows, unknown=unknown, spread=float(np.std(measured)))


def _load(through_air: Array, time: Seconds) -> Array:
    """The load factor of velocities through the air (2, n) [m/s]."""
    north, east = through_air
    by_north, by_east = np.gradient(through_air, time, axis=1)
    speed = np.maximum(np.hypot(north, east), _AT_REST)
    return load_factor((north * by_east - east * by_north) / speed)


def _air_temperature(
    log: FlightLog,
    obs: Observations,
    blocks: _Blocks,
    impact: Pascal,
    static: Pascal,
    height: Meters,
) -> "_Profile":
    """Return the temperature of the air over height, from the blocks' (n,) readings.

    Its slope is fitted to a log that climbs, layer by layer where it climbs far, and standard for
    another.
    """
    probe = log.total_temperature if log.total_temperature is not None else log.air_temperature
    if probe is None:
        probe = air.standard_temperature(air.pressure_altitude(log.static_pressure))
    mach = air.mach_from_impact_pressure(np.maximum(impact, 0.0), static)
    temperature = blocks.mean(probe) / (1.0 + obs.probe_heating * mach**2)
    low, high = float(np.min(height)), float(np.max(height))
    if high - low <= _LEAST_CLIMB:
        middle = float(np.mean(temperature))
        edges = np.array([low - 1.0, high + 1.0])
        return _Profile(edges, middle - air.LAPSE_RATE * (edges - float(np.mean(height))))
    edges = np.linspace(
        low, high, 1 + min(max(1, round((high - low) / _LAYER_DEPTH)), _MOST_LAYERS)
    )
    hats = np.stack([np.interp(height, edges, unit) for unit in np.eye(len(edges))], axis=1)
    # A layer without data goes on as its neighbors do: the second differences are held small.
    smooth = _SMOOTH * np.diff(np.eye(len(edges)), 2, axis=0)
    known = np.concatenate([temperature, np.zeros(len(smooth))])
    return _Profile(edges, np.linalg.lstsq(np.concatenate([hats, smooth]), known)[0])


@dataclass(frozen=True, slots=True)
class _Profile:
    """The air's temperature over height: lines through `temperature` (k,) [K] at `edges` [m]."""

    edges: Meters
    temperature: Kelvin

    def at(self, height: Meters) -> Kelvin:
        """The temperature at heights (n,) [K]."""
        return np.interp(height, self.edges, self.temperature)

    def thinness(self, height: Meters) -> Array:
        """The integral of dh/T from the mean height to heights (n,) [m/K].

        g/R times it is ln of the pressures.
        """
        return self._integral(height, 1.0 / self._fine()[1])

    def temperature_slope(self, height: Meters) -> Array:
        """Change of the height of the column per kelvin, at heights (n,) [m/K]."""
        return self.at(height) * self._integral(height, self._fine()[1] ** -2.0)

    def layers(self, height: Meters) -> Array:
        """The same for each layer that is warmer by itself, (n, layers) [m/K].

        Of a single layer there are no columns: (n, 0).
        """
        if len(self.edges) == 2:
            return np.zeros((len(height), 0))
        fine, temperature = self._fine()
        inside = [(fine >= low) & (fine < high) for low, high in pairwise(self.edges)]
        return np.stack(
            [self.at(height) * self._integral(height, rows * temperature**-2.0) for rows in inside],
            1,
        )

    def _fine(self) -> tuple[Meters, Kelvin]:
        fine = np.linspace(self.edges[0], self.edges[-1], _FINE * (len(self.edges) - 1) + 1)
        return fine, self.at(fine)

    def _integral(self, height: Meters, values: Array) -> Array:
        """The integral of values on the fine heights from the mean height to each height."""
        fine = self._fine()[0]
        steps = 0.5 * (values[1:] + values[:-1]) * np.diff(fine)
        sums = np.concatenate([[0.0], np.cumsum(steps)])
        return np.asarray(
            np.interp(height, fine, sums) - np.interp(float(np.mean(height)), fine, sums)
        )


def _ties(carried: CarriedHeight, blocks: _Blocks) -> tuple[Meters | None, Array]:
    """Return the receiver's height less the integral of its velocity, and the white variance.

    A block has one of each, in [m] and [m²]. Without vertical velocity the first is None and the
    second is one over the number of fixes in the block.
    """
    count = len(blocks.count)
    if carried.offsets is None:
        fixes = np.bincount(blocks.index, carried.fresh[blocks.rows], count)
        return None, 1.0 / np.maximum(fixes, 1.0)
    place = np.searchsorted(blocks.rows, carried.fixes)
    place = np.minimum(place, len(blocks.rows) - 1)
    good = (blocks.rows[place] == carried.fixes) & ~_white_noise(carried.offsets)[1]
    index, offsets = blocks.index[place[good]], carried.offsets[good]
    fixes = np.bincount(index, minlength=count).astype(np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        tie = np.bincount(index, offsets, count) / fixes
        variance = np.where(fixes > 0.0, _white_variance(carried.offsets) / fixes + _FLOOR, np.inf)
    return tie, variance


def _white_variance(values: Array) -> float:
    """Variance of the white part of a series that also has slow parts.

    The white part adds the same variance to differences over one and over two steps; a slow part
    adds twice as much over two. So the first minus half the second is the white variance.
    """
    once, twice = (
        (NORMAL * float(np.median(np.abs(values[lag:] - values[:-lag])))) ** 2 for lag in (1, 2)
    )
    return max(once - 0.5 * twice, 0.0)


def _unknowns(
    rows: AltitudeRows,
    column: Array,
    velocity: Array,
    wind: Array,
    layers: Array,
    layer: float,
    standard_day: bool,
) -> UnknownColumns:
    """Return the unknowns of the altitude equation alone, as columns with their priors.

    The reference pressure (flat prior), a horizontal pressure gradient (two), a slow change of
    pressure, the temperature of the air in each layer between the heights, with the deviation
    `layer` [K], and in all of it.
    """
    step = np.diff(rows.time)
    place = np.concatenate(
        [np.zeros((2, 1)), np.cumsum(0.5 * (velocity[:, 1:] + velocity[:, :-1]) * step, axis=1)], 1
    )
    # ρ f V in slope of a pressure level
    gradient = _CORIOLIS * max(float(np.hypot(*wind)), _LEAST_WIND) / air.GRAVITY
    elapsed = (rows.time - float(np.mean(rows.time))) / 600.0
    common = 0.5 * WITHOUT_TEMPERATURE if standard_day else layer
    columns = np.stack(
        [
            rows.state.gain * column,
            *(place - place.mean(axis=1)[:, None]),
            rows.state.gain * elapsed,
            *layers.T,
            rows.state.temperature_slope,
        ],
        1,
    )
    each = [layer] * layers.shape[1]
    deviation = np.array([np.inf, gradient, gradient, _TENDENCY, *each, common])
    ties = rows.count - len(rows)
    return UnknownColumns(
        np.concatenate([columns, np.zeros((ties, columns.shape[1]))]), 1.0 / deviation**2
    )


def _with_total_source(
    unknown: UnknownColumns, rows: AltitudeRows, deviation: float
) -> UnknownColumns:
    """Return the unknowns with the total source's error: a level and a slope in ln q_ci.

    `deviation` [-] is that of the level. The wind triangle tells of both sources together, the
    static pressure of one: what the total source does to the airspeed is no change of the height.
    """
    flying = rows.state.impact_pressure > 0.0
    if not flying.any():
        return unknown
    place = np.log(np.where(flying, rows.state.impact_pressure, 1.0))
    low, high = np.quantile(place[flying], [0.001, 0.999])
    place = (place - 0.5 * (low + high)) / max(0.5 * float(high - low), _LEAST_HALF)
    meters = rows.state.gain * rows.state.impact_pressure
    both = np.pad(np.stack([meters, meters * place], axis=1), ((0, rows.count - len(rows)), (0, 0)))
    known = np.array([deviation, _TOTAL_SLOPE * deviation]) ** -2.0
    return UnknownColumns(
        np.column_stack([both, unknown.columns]), np.concatenate([known, unknown.precision])
    )


NOISE_COUNT = 3
# m and s: the part of the receiver's error that follows ionosphere and orbits, which no hour of a
# log can show.
WANDER = 1.0  # m (1σ)
WANDER_TIME = 1800.0  # s


@dataclass(frozen=True, slots=True)
class AltitudeNoise:
    """The map from φ, (3,), to the covariance of the rows.

    φ = ln(slow height error [m], its correlation time [s], third). The third is the random walk of
    the integrated velocity [m/√s] or, without vertical velocity, the white height error [m].
    """

    rows: AltitudeRows

    def __call__(self, phi: Array, /) -> PointNoise:
        """Return the covariance for φ (3,)."""
        return self.stack(phi)

    def stack(self, phis: Array) -> PointNoise:
        """Return the covariances for many φ, (b, 3)."""
        rows, (deviation, memory, third) = self.rows, np.moveaxis(np.exp(phis), -1, 0)
        if rows.tie is None:
            white = (rows.sensor + third[..., None] ** 2 * rows.fix)[..., None, :]
            wander = ornstein_uhlenbeck(rows.time, WANDER, WANDER_TIME, (1.0,))
            return PointNoise(
                white,
                [ornstein_uhlenbeck(rows.time, deviation, memory, (1.0,)), wander],
                rows.unknown,
            )
        walk = random_walk(rows.time, third, rows.first, (1.0, -1.0))
        slow = ornstein_uhlenbeck(rows.time, deviation, memory, (0.0, 1.0))
        wander = ornstein_uhlenbeck(rows.time, WANDER, WANDER_TIME, (0.0, 1.0))
        white = np.broadcast_to(np.stack([rows.sensor, rows.fix]), (*phis.shape[:-1], 2, len(rows)))
        return PointNoise(white, [walk, slow, wander], rows.unknown)


def altitude_log_prior(rows: AltitudeRows, phi: Array) -> float:
    """The prior of φ (3,): half-normal levels and a log-normal correlation time.

    The φ terms convert the density of a level to that of its logarithm.
    """
    priors = rows.priors
    third = priors.height_white_m if rows.tie is None else priors.height_walk
    memory = (phi[1] - np.log(priors.height_memory_s)) / np.log(priors.height_memory_factor)
    levels = (np.exp(phi[0]) / priors.height_slow_m) ** 2 + (np.exp(phi[2]) / third) ** 2
    return float(phi[0] + phi[2] - 0.5 * (levels + memory**2))


def altitude_guess(rows: AltitudeRows) -> Array:
    """A start for φ, (3,)."""
    third = 0.3 if rows.tie is None else 0.03
    slow = np.clip(rows.spread, 0.1, rows.priors.height_slow_m)
    return np.log([slow, rows.priors.height_memory_s, third])
