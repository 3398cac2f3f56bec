"""The rows and channels of a log that the estimators use, in blocks; unusable logs are refused."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.airdata import TAXI, Rest
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.estimation.noise import Intervals
from pitotbench.logbook.plausible_air import at_ceiling
from pitotbench.records import BadInputError
from pitotbench.records.log import AT_REST, OF_FIXES, FlightLog
from pitotbench.scatter import robust_deviation
from pitotbench.timeline import interval, pauses, stretch_numbers
from pitotbench.units import (
    DEGREE,
    KNOT,
    Array,
    Booleans,
    Kelvin,
    Meters,
    MetersPerSecond,
    Pascal,
    Seconds,
    percent_text,
)

_MEAN_OVER = 30.0  # s: a gust lasts 4 s at 250 kt and 10 s at 100 kt
_AROUND = 5.0  # s: before and after a row at the end of the range, where the airplane comes from it or goes to it
_SCATTER = 3.0  # times the scatter about the mean: a thousandth of the readings is cut off there


@dataclass(frozen=True, slots=True)
class RangeEnd:
    """The end of the sensor's range in a log.

    `airspeed` [m/s] is the indicated airspeed there and `usable` [m/s] the mean one up to which
    rows are used. `rows` (n,) marks the rows at the end, `cut_off` (n,) those and all that are left
    out because of it.
    """

    airspeed: float
    usable: float
    rows: Booleans
    cut_off: Booleans

    @property
    def words(self) -> str:
        """The warning: where the range ends, and which rows are not used."""
        return (
            "the impact pressure stands at the end of the sensor's range, "
            f"{self.airspeed / KNOT:.0f} kt, on "
            f"{int(self.rows.sum())} rows: those, {_AROUND:.0f} s around them and rows whose mean "
            "is above "
            f"{self.usable / KNOT:.0f} kt are not used, {int(self.cut_off.sum())} in all; for "
            "these speeds use a "
            "sensor with more range"
        )


def range_end(log: FlightLog) -> RangeEnd | None:
    """Return the end of the impact-pressure sensor's range, None where the log shows none.

    A reading at the end of the range is not a measurement. Leaving out the rows at the end alone
    would keep the lulls and lose the gusts, and the curve would be wrong by a part of the gusts. So
    the rows are chosen by what hardly depends on one gust: the mean of the reading over half a
    minute has to be below the end of the range by three times the scatter about it.
    """
    rows = at_ceiling(log.impact_pressure)
    if not rows.any():
        return None
    from scipy.ndimage import (
        maximum_filter1d,
        uniform_filter1d,
    )  # slow to load, and most logs need none

    speed: MetersPerSecond = air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0))
    period = interval(log.time)
    mean = uniform_filter1d(speed, 1 + 2 * round(0.5 * _MEAN_OVER / period), mode="nearest")
    near = maximum_filter1d(rows, 1 + 2 * round(_AROUND / period), mode="nearest")
    end = float(np.max(speed))
    free = ~near if not near.all() else ~rows
    usable = end - _SCATTER * float(robust_deviation((speed - mean)[free]))
    return RangeEnd(end, usable, rows, near | (mean > usable))


_MINIMUM_AIRSPEED = 20.0 * KNOT  # below it the impact pressure is too small to be of use
_MINIMUM_PRESSURE = float(air.impact_pressure(_MINIMUM_AIRSPEED))

_FLYING = 0.45  # of the fast airspeed of the log: below it an airplane rolls, or stalls
_FAST = 0.9  # quantile of the airspeeds above 20 kt
_AFTER_TAKE_OFF = 60.0  # s
_BEFORE_LANDING = 120.0  # s
_MOST_CUT = 0.25  # of a time in the air, at either end
_STEEP = 6.0 * DEGREE  # of the path, twice that of a usual approach
_OVER = 20.0  # s, over which the angle of the path is taken
_FEWEST_TOGETHER = 5.0  # samples whose median a spike does not move
_BRIEF = 30.0  # s: a shorter part between two others is of no use
GROUND, ENDS, STEEP = "taxi and roll", "take-off and landing", "steep climb or descent"
SLOW = "below 20 kt indicated"


@dataclass(frozen=True, slots=True)
class UsableParts:
    """The usable rows of a log, (n,), and why others are left out."""

    rows: Booleans
    reasons: tuple[str, ...]

    def less(self, left_out: Iterable[tuple[str, Booleans]]) -> "UsableParts":
        """Leave out rows (n,) for further reasons; a reason that takes none is not reported."""
        rows, reasons = self.rows, self.reasons
        for why, out in left_out:
            if (rows & out).any():
                rows, reasons = rows & ~out, (*reasons, why)
        return UsableParts(rows, reasons)


def _every_row(log: FlightLog) -> UsableParts:
    return UsableParts(np.ones(len(log), dtype=np.bool_), ())


def usable_parts(log: FlightLog) -> UsableParts:
    """Return the parts of a log that serve a calibration.

    On the ground and in ground effect the air data have errors of their own. After take-off and
    before landing the airplane flies with flaps or gear, through the shear of the lowest air. In
    steep flight the wind changes with height faster than turns can show it.
    """
    speed = air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0))
    fast = speed[speed > _MINIMUM_AIRSPEED]
    flying = speed > (_FLYING * float(np.quantile(fast, _FAST)) if len(fast) else 0.0)
    # A log with rows of taxi holds a take-off or a landing. Recorders may leave out those at rest.
    slow = np.hypot(log.velocity_north, log.velocity_east) < TAXI
    grounded = bool(np.any(~flying & slow))
    ends = np.zeros(len(log), dtype=np.bool_)
    if grounded:
        for first, end in _runs(flying):
            time = log.time[first:end]
            most = _MOST_CUT * (time[-1] - time[0])
            ends[first:end] |= (time < time[0] + min(_AFTER_TAKE_OFF, most)) & (first > 0)
            ends[first:end] |= (time > time[-1] - min(_BEFORE_LANDING, most)) & (end < len(log))
    ground = ~flying if grounded else np.zeros(len(log), dtype=np.bool_)
    steep = ~ground & ~ends & (np.abs(path_angle(log)) > _STEEP)
    found = _every_row(log).less(((GROUND, ground), (ENDS, ends), (STEEP, steep)))
    rows = found.rows
    for first, end in _runs(rows):
        if (first > 0 or end < len(log)) and log.time[end - 1] - log.time[first] < _BRIEF:
            rows[first:end] = False
    return UsableParts(rows, found.reasons)


def path_angle(log: FlightLog) -> Array:
    """Return the angle of the path through the air above the horizon, over 20 s, (n,) [rad]."""
    pressure = np.maximum(log.static_pressure, 1.0)
    group = np.floor((log.time - log.time[0]) / max(1.0, _FEWEST_TOGETHER * interval(log.time)))
    edges = np.flatnonzero(np.diff(group, prepend=-1.0))
    ordered, size = pressure[np.lexsort((pressure, group))], np.diff(edges, append=len(group))
    middles = 0.5 * (
        ordered[edges + (size - 1) // 2] + ordered[edges + size // 2]
    )  # medians: no spike is a climb
    height = air.pressure_altitude(np.interp(log.time, log.time[edges], middles))
    before, after = (
        np.clip(log.time + half, log.time[0], log.time[-1]) for half in (-0.5 * _OVER, 0.5 * _OVER)
    )
    climb = (np.interp(after, log.time, height) - np.interp(before, log.time, height)) / (
        after - before
    )
    impact = np.maximum(log.impact_pressure, 0.0)
    airspeed = air.true_airspeed(impact, pressure, air.standard_temperature(height))
    return np.arctan2(climb, np.maximum(airspeed, _MINIMUM_AIRSPEED))


def spans(time: Seconds, rows: Booleans) -> tuple[tuple[float, float], ...]:
    """Return the first and the last time of each part of marked rows [s]."""
    return tuple((float(time[first]), float(time[end - 1])) for first, end in _runs(rows))


def _runs(rows: Booleans) -> list[tuple[int, int]]:
    """The first row of each run of marked rows, and the one after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]])))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]


_MINIMUM_SAMPLES = 30
_MOST = 0.5  # share of the rows: limits that leave out more are named where there is no answer
FEWEST_FIXES = 4  # in a stretch between pauses: four points determine a cubic
DENSE = 0.5  # share of fresh GPS rows: above it the velocity counts as sampled with the air data


@dataclass(frozen=True, slots=True)
class Observations:
    """The rows used, arrays (n,). Pressures are indicated [Pa], velocities over the ground [m/s].

    `probe_temperature` [K] is total (`probe_heating` = 0.2 r) or of the air (`probe_heating` = 0).
    `stretch` numbers the stretches between pauses, and `fresh` marks new GPS samples. `held_*` are
    the velocities as logged and `velocity_*` those at the time of the air data. `used` (rows of the
    log,) marks the used rows. `standard_day` states that the log has no temperature, and `of_fixes`
    that its velocity comes from positions.
    """

    time: Seconds
    impact_pressure: Pascal
    static_pressure: Pascal
    probe_temperature: Kelvin
    velocity_north: MetersPerSecond
    velocity_east: MetersPerSecond
    velocity_down: MetersPerSecond
    held_north: MetersPerSecond
    held_east: MetersPerSecond
    held_down: MetersPerSecond
    altitude: Meters | None
    stretch: NDArray[np.intp]
    fresh: Booleans
    used: Booleans
    probe_heating: float
    has_down: bool
    standard_day: bool
    parts: UsableParts  # of the log, over its rows, and those that all limits leave
    usable: UsableParts
    acceleration: Array  # m/s² over the ground toward north and east, (n, 2)
    of_fixes: bool = False
    heading: Array | None = None  # rad, as logged
    rests: tuple[Rest, ...] = ()  # what the gauge reads before and after the flight

    def __len__(self) -> int:
        return len(self.time)

    def height(self) -> Meters:
        """The height of each row [m]: by GPS where the log has it, else the pressure altitude."""
        return (
            air.pressure_altitude(self.static_pressure) if self.altitude is None else self.altitude
        )

    def every(self, step: int) -> "Observations":
        """Every `step`-th row."""
        return self.at(slice(None, None, step))

    def at(self, rows: slice | NDArray[np.intp] | Booleans) -> "Observations":
        """The chosen rows; `used` remains that of all."""
        every = {f.name: getattr(self, f.name) for f in fields(self) if f.name != "used"}
        once: dict[int, Any] = {}  # a velocity that needs no interpolation is the held one
        chosen: dict[str, Any] = {
            name: once.setdefault(id(values), values[rows])
            for name, values in every.items()
            if isinstance(values, np.ndarray)
        }
        return replace(self, **chosen)

    def select(self, good: Booleans) -> "Observations":
        """The good rows; `used` marks these alone."""
        used = self.used.copy()
        used[np.flatnonzero(used)[~good]] = False
        return replace(self.at(good), used=used)

    def as_held(self) -> "Observations":
        """Return the same rows with each velocity fix held until the next, as in the paper."""
        return replace(
            self,
            velocity_north=self.held_north,
            velocity_east=self.held_east,
            velocity_down=self.held_down,
        )


def observe(
    log: FlightLog, options: CalibrationOptions, before: Observations | None = None
) -> Observations:
    """Choose rows and interpolate the ground velocity to the times of the air data.

    Rows that were left out of those `before`, read of the same log with other options, remain out.
    Raises BadInputError where too few usable rows remain or a needed channel is missing.
    """
    fresh = log.fresh_fixes()
    stretch = stretch_numbers(log.time, pauses(log.time))
    down = (
        log.velocity_down
        if log.velocity_down is not None and options.use_down
        else np.zeros(len(log))
    )
    held = np.stack([log.velocity_north, log.velocity_east, down])
    velocity, between = _between_fixes(log.time, held, fresh, stretch, options.gps_latency)
    parts = parts_of(log, options) if before is None else before.parts
    usable = usable_rows(log, options, parts)
    used = usable.rows & between & (True if before is None else before.used)
    _require_rows(used, log, options)
    temperature, heating, standard = _temperature(log, options)
    between_fixes = [axis[used] for axis in velocity]
    as_held = between_fixes if velocity is held else [axis[used] for axis in held]
    flown = slice(None) if velocity is held else between
    return Observations(
        time=log.time[used],
        impact_pressure=log.impact_pressure[used],
        static_pressure=log.static_pressure[used],
        probe_temperature=temperature[used],
        velocity_north=between_fixes[0],
        velocity_east=between_fixes[1],
        velocity_down=between_fixes[2],
        held_north=as_held[0],
        held_east=as_held[1],
        held_down=as_held[2],
        altitude=None if log.altitude is None else log.altitude[used],
        stretch=stretch[used],
        fresh=fresh[used],
        used=used,
        probe_heating=heating,
        has_down=log.velocity_down is not None and options.use_down,
        standard_day=standard,
        parts=parts,
        usable=usable,
        acceleration=_acceleration(
            log.time[flown], velocity[:2, flown], stretch[flown], used[flown]
        ),
        heading=None if log.heading is None else log.heading[used],
        of_fixes=OF_FIXES in log.header,
        rests=_rests(log, used),
    )


def _rests(log: FlightLog, used: Booleans) -> tuple[Rest, ...]:
    """What the gauge reads at rest; nothing of one that reads as in flight."""
    low = float(np.min(log.impact_pressure[used]))
    return tuple(Rest(**each) for each in log.header.get(AT_REST, ()) if each["reading_pa"] < low)


_LONG_FLIGHT = 1800.0  # s: beyond it one wind does not hold for all rows
_HIGH_CLIMB = 500.0  # m: nor beyond this


def wind_drifts(options: CalibrationOptions, obs: Observations) -> bool:
    """Return whether the wind drifts: where asked for, or where it is checked on a long flight.

    A climb through much height counts as a long flight.
    """
    long = obs.time[-1] - obs.time[0] > _LONG_FLIGHT or float(np.ptp(obs.height())) > _HIGH_CLIMB
    return options.wind == "drifting" or (options.wind == "checked" and bool(long))


def parts_of(log: FlightLog, options: CalibrationOptions) -> UsableParts:
    """Return the usable parts of a log: all of it where the user has chosen the rows.

    Rows are chosen as those on condition, or by the slowest airspeed.
    """
    chosen = options.on_condition or options.slowest is not None
    return _every_row(log) if chosen else usable_parts(log)


def _slow_words(options: CalibrationOptions) -> str:
    return SLOW if options.slowest is None else f"below {options.slowest / KNOT:.0f} kt indicated"


def _slowest(options: CalibrationOptions) -> float:
    """The impact pressure of the slowest airspeed that is used [Pa]."""
    if options.slowest is None:
        return _MINIMUM_PRESSURE
    return float(air.impact_pressure(options.slowest))


def usable_rows(
    log: FlightLog, options: CalibrationOptions, parts: UsableParts | None = None
) -> UsableParts:
    """Return the rows that their part of the log, the sensor's range and the options allow.

    `parts` are those of the log where they are known. Raises BadInputError without flags.
    """
    end, ground_speed = range_end(log), np.hypot(log.velocity_north, log.velocity_east)
    limits = [
        (_slow_words(options), log.impact_pressure <= _slowest(options)),
        *([] if end is None else [("the end of the sensor's range", end.cut_off)]),
        (
            f"below {options.ground_speed_min / KNOT:.0f} kt over the ground",
            ground_speed < options.ground_speed_min,
        ),
    ]
    if options.on_condition:
        if log.on_condition is None:
            raise BadInputError(
                "the log has no on_condition column; leave out --on-condition or add the column"
            )
        limits.append(("off condition", ~log.on_condition))
    if options.mach_max is not None:
        mach = air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)
        limits.append((f"above Mach {options.mach_max:g}", ~(mach <= options.mach_max)))
    return (parts or parts_of(log, options)).less(limits)


def limit_words(log: FlightLog, options: CalibrationOptions) -> str:
    """Return in words the limits of Mach and ground speed that leave out most rows, "" for none."""
    free = replace(options, mach_max=None, ground_speed_min=0.0)
    found = usable_rows(log, free).rows
    share = 1.0 - float(usable_rows(log, options).rows.sum()) / max(int(found.sum()), 1)
    if share <= _MOST:
        return ""
    limits = [
        *([f"Mach {options.mach_max:g} (--mach-max)"] if options.mach_max is not None else []),
        *(
            [f"{options.ground_speed_min / KNOT:.0f} kt over the ground (--ground-speed-min-kt)"]
            if options.ground_speed_min
            else []
        ),
    ]
    return (
        f"; the limit of {' and '.join(limits)} leaves out {percent_text(share)} of the rows: "
        "choose another one"
    )


_GROUNDED = (
    "no level flight above 20 kt in this log (ramp, taxi, take-off roll? An airplane that flies "
    "slower states its slowest airspeed: --slowest 8): "
)


_NOT_LEVEL = (
    f"no level flight of {_BRIEF:.0f} s in this log, which climbs and descends at more than "
    f"{_STEEP / DEGREE:.0f}°: give a longer part of the flight, with legs or turns in level: "
)


def _require_rows(used: Booleans, log: FlightLog, options: CalibrationOptions) -> None:
    if int(used.sum()) < _MINIMUM_SAMPLES:
        end = range_end(log)
        parts = parts_of(log, options)
        flown = parts.rows & (log.impact_pressure > _slowest(options))
        grounded = int(flown.sum()) < _MINIMUM_SAMPLES <= len(log)
        why = _GROUNDED if options.slowest is None else ""
        if parts.reasons == (STEEP,):
            why = _NOT_LEVEL
        raise BadInputError(
            f"{why if grounded else ''}"
            f"only {int(used.sum())} of {len(used)} rows are usable (none {_slow_words(options)}, "
            "pressure below the end of its sensor's range"
            f"{', on condition' if options.on_condition else ''}"
            f"{', below the Mach limit' if options.mach_max is not None else ''}"
            f"{', above the least ground speed' if options.ground_speed_min > 0.0 else ''}"
            ", between GPS fixes that change); "
            f"at least {_MINIMUM_SAMPLES} are needed: choose other rows or fly longer"
            f"{'' if end is None else '; ' + end.words}"
        )


def _between_fixes(
    time: Seconds,
    held: Array,
    fresh: Booleans,
    stretch: NDArray[np.intp],
    latency: float,
) -> tuple[Array, Booleans]:
    """Interpolate held velocities (3, n), and mark the rows between fixes.

    The curves are cubic splines through the fixes, each taken `latency` seconds earlier than
    stamped, one spline per stretch. A held velocity would lag by half a fix interval. Beyond the
    last fix nothing can be interpolated.
    """
    if fresh.mean() > DENSE and latency == 0.0:
        return held, np.ones(len(time), dtype=np.bool_)
    from scipy.interpolate import (
        CubicSpline,
    )  # slow to load; a log with GPS at the rate of the air data needs none

    velocity, between = held.copy(), np.zeros(len(time), dtype=np.bool_)
    for number in np.unique(stretch):
        rows = stretch == number
        fixes = rows & fresh
        if int(fixes.sum()) < FEWEST_FIXES:
            continue
        knots = time[fixes] - latency
        rows &= time >= max(knots[0], knots[0] + latency)
        rows &= time <= min(knots[-1], knots[-1] + latency)
        velocity[:, rows] = CubicSpline(knots, held[:, fixes], axis=1)(time[rows])
        between |= rows
    return velocity, between


_RATE_OVER = 2.0  # s: short against a turn, long against the noise of a velocity


def _acceleration(
    time: Seconds, velocity: Array, stretch: NDArray[np.intp], used: Booleans
) -> Array:
    """Return the change of velocities (2, n) over two seconds around each used row, (k, 2) [m/s²].

    Only the row's own stretch counts; a row alone has 0. The rows must lie between fixes: a
    velocity is held beyond the last, as if a turn ended there.
    """
    edges = np.flatnonzero(np.diff(stretch, prepend=-1, append=stretch[-1] + 1))
    rows = np.diff(edges)  # of each stretch; of a long log each array counts
    ahead = np.minimum(time + 0.5 * _RATE_OVER, np.repeat(time[edges[1:] - 1], rows))
    behind = np.maximum(time - 0.5 * _RATE_OVER, np.repeat(time[edges[:-1]], rows))
    over = np.maximum(ahead - behind, 1e-9)
    change = ((np.interp(ahead, time, v) - np.interp(behind, time, v)) / over for v in velocity)
    return np.stack([each[used] for each in change], axis=1)


def _temperature(log: FlightLog, options: CalibrationOptions) -> tuple[Kelvin, float, bool]:
    if log.total_temperature is not None:
        return log.total_temperature, 0.2 * options.recovery_factor, False
    if log.air_temperature is not None:
        return log.air_temperature, 0.0, False
    return air.standard_temperature(air.pressure_altitude(log.static_pressure)), 0.0, True


_BLOCK = 1.0  # s: short against a gust (8 s at 65 m/s), long against the sensors' sampling
_SHORT = 120.0  # s of data, below which a log has
_SHORT_BLOCK = 0.5  # s: such blocks
LONG = 480.0  # s of data, above which a log has
_LONG_BLOCK = 2.0  # s: such blocks
_LONGEST = 3600.0  # s of data, above which a flight has
_LONGEST_BLOCK = 4.0  # s: such blocks
_MOST_BLOCKS = 5000  # of a flight: of more the bound hardly falls, and the time grows with them


@dataclass(frozen=True, slots=True)
class Blocks:
    """The block of each row, (rows,), the rows per block, (n,), and the blocks' intervals in time.

    Their means keep slow signals, average out fast sensor noise and shorten the sums. `length` is
    that of a block [s].
    """

    index: NDArray[np.intp]
    count: Array
    intervals: Intervals
    length: float

    def middle(self) -> Seconds:
        """The middle of each block [s], (n,), counted from the first row."""
        left = self.intervals.left
        return 0.5 * (self.intervals.edges[left] + self.intervals.edges[left + 1])

    def mean(self, data: Array) -> Array:
        """Block means, (n,) or (n, k), of (rows,) or (rows, k) data."""
        if data.ndim == 1:
            return np.asarray(np.bincount(self.index, data, len(self.count)) / self.count)
        return np.stack([self.mean(column) for column in data.T], axis=1)


def block_length(obs: Observations) -> float:
    """Return the length of a block [s]: 0.5, 1, 2 or 4 s, and more for over 5,000 blocks.

    It is 1 s for data of two minutes or more, 2 s of eight, 4 s of an hour.
    """
    duration = len(obs) * float(np.median(np.diff(obs.time)))
    if duration > _LONGEST:
        return max(_LONGEST_BLOCK, duration / _MOST_BLOCKS)
    return _SHORT_BLOCK if duration < _SHORT else _LONG_BLOCK if duration > LONG else _BLOCK


def divide(obs: Observations, length: float) -> Blocks:
    """Divide the rows into blocks of a length [s]. No block spans a pause."""
    offset = obs.time - obs.time[0]
    cell = np.floor((offset + 0.5 * length) / length).astype(np.intp)
    # A stretch that begins in the cell in which the one before it ended has its blocks one cell
    # later.
    begins = np.flatnonzero(np.diff(obs.stretch)) + 1
    later = np.zeros(len(cell), dtype=np.intp)
    later[begins] = cell[begins] == cell[begins - 1]
    cell, index, count = np.unique(cell + np.cumsum(later), return_inverse=True, return_counts=True)
    return Blocks(index, count.astype(np.float64), intervals_of(cell, length), length)


def intervals_of(cell: NDArray[np.intp], length: float) -> Intervals:
    """Return the edges in time of blocks of a length [s] in cells (n,).

    Neighbors share one; after an empty cell there is a new one.
    """
    joined = np.concatenate([[False], (np.diff(cell) == 1)])
    left = np.cumsum(np.where(joined, 1, 2)) - 2
    edges = np.empty(left[-1] + 2)
    edges[left + 1] = (cell + 0.5) * length
    edges[left] = (cell - 0.5) * length
    return Intervals(edges, left)
