"""What a log may show of the air: ends of ranges, pressure and temperature against height."""

from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.logbook.columns import QUANTITIES
from pitotbench.logbook.draft import Draft
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution
from pitotbench.units import SUFFIXES, Array, Booleans, Pascal, from_si, to_si


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a log is doubted (a warning) and where it is refused; SI, ratios without unit."""

    # Height. Sea-level pressure lies between 970 and 1050 hPa nearly always: 350 m of pressure
    # altitude.
    height_doubted: float = 350.0  # m
    # of the height: the air below is not as warm as the probe at height says
    height_share: float = 0.03
    # Pa about 1013.25 hPa in which a pressure reduced to sea level lies
    sea_level_band: float = 5000.0
    # m, above which no such pressure is that of the height: 7 % less
    sea_level_height: float = 600.0
    # dp_s/dq_c: midway between a static source (below 0.1 in size) and a total tube (1)
    total_slope: float = 0.5

    # Temperature. Between a polar winter and a desert in summer the standard day is 60 K off at
    # most.
    temperature_doubted: float = 30.0  # K
    temperature_refused: float = 60.0  # K
    # of the adiabatic rise: a total-temperature probe recovers 0.9 of it or more
    rise_low: float = 0.7
    rise_high: float = 1.4
    rise_of_air: float = 0.4  # an air temperature should not rise with speed at all
    rise_known: float = 0.1  # standard error of the rise above which nothing is said

    # Speed. q_c is what the ground speed asks for, over what was measured, less one: minus the
    # error of the system.
    curve_doubted: float = 0.1  # 5 kt at 100 kt: the largest error that FAR 23.1323 accepts
    curve_refused: float = 0.2  # no source errs by a fifth of the impact pressure
    scale_refused: float = 3.0  # of the airspeed: no gauge's gain is, a unit of pressure is
    # Pa: a cheap differential gauge may have this zero, and it may be taken off later
    zero_allowed: float = 150.0
    change_doubted: float = 0.13  # of q_c, from one part of the log to the next
    change_refused: float = 0.5
    misfit_doubted: float = 0.15  # rms of ground speed less wind against airspeed, over airspeed
    misfit_refused: float = 0.3  # gusts of 3 m/s about an airplane of 10 m/s
    axes_misfit: float = 0.1  # above which a unit of one component alone is tried
    # share of the misfit that must remain with it: gusts and the curve remain
    axes_better: float = 0.4
    # of q_c, that may remain after a unit is corrected: the error of the system itself
    unit_fits: float = 0.15
    sigmas: float = 3.0  # standard errors by which a limit must be passed

    # Direction.
    # degrees between heading and velocity less wind: above an attitude system's error
    angle_doubted: float = 5.0
    # 1 − |mean of e^iψ|: 0 on one heading, 1 over full turns or out and back
    headings_spread: float = 0.3
    # share of the misfit that a mirrored velocity may have to be believed
    mirror_better: float = 0.5
    # of the airspeed's second differences: two sensors have 0.37 or more in real logs
    wiggle_difference: float = 0.2
    track_equal: float = 1.0  # degrees rms: a heading so near the track in a wind is the track

    # Attitude.
    slope_low: float = 0.4  # measured angle over the angle that the motion asks for
    slope_high: float = 2.5
    agrees: float = 0.8  # correlation below which nothing is said
    bank_needed: float = 0.1  # rad rms of bank
    pitch_needed: float = 0.02  # rad rms about the mean


LIMITS = Limits()
# Codes of findings that the calibration measures by what they move.
NO_AIR, NO_TOTAL, HEIGHT = "no air temperature", "no total temperature", "height and pressure"
_ROWS = 20_000  # that medians and slopes are taken over: more would only take time


def some(draft: Draft, name: str) -> Array:
    """Return at most some `_ROWS` values of a channel, (k,), evenly spaced, in common rows."""
    return draft.channels[name][:: max(1, len(draft.rows) // _ROWS)]


def other_units(draft: Draft, name: str) -> list[tuple[str, float]]:
    """The other units of a quantity: the suffix, and that unit over the one written."""
    written = SUFFIXES[draft.suffixes[name]].factor
    return [
        (s, SUFFIXES[s].factor / written)
        for s in QUANTITIES[name].suffixes
        if s != draft.suffixes[name]
    ]


# s, over which values are averaged: longer than the probe, the gauge and the receiver lag
_BLOCK = 5.0
# blocks for which weather and gusts last: as many times fewer blocks count for the error
_LASTING = 4.0


def block_slope(time: Array, design: Array, values: Array) -> tuple[float, float]:
    """Return the coefficient of the second row of `design`, (m, n), and its standard error.

    A least-squares fit to `values`, (n,), over means of blocks of time; the error is infinite where
    the log is too short.
    """
    number = np.unique(np.floor(time / _BLOCK), return_inverse=True)[1]
    count = np.bincount(number)
    columns = np.stack([np.bincount(number, row) / count for row in design])
    answer = np.bincount(number, values) / count
    spare = len(count) - len(columns)
    if spare < 3:
        return 0.0, float("inf")
    scale = np.maximum(np.sqrt(np.mean(columns**2, axis=1)), 1e-12)
    matrix = (columns / scale[:, None]).T
    if np.linalg.matrix_rank(matrix) < len(scale):
        return 0.0, float("inf")
    solution = np.linalg.lstsq(matrix, answer, rcond=None)[0]
    variance = float(np.sum((answer - matrix @ solution) ** 2)) / spare
    covariance = _LASTING * variance * np.linalg.inv(matrix.T @ matrix)
    return float(solution[1] / scale[1]), float(np.sqrt(covariance[1, 1]) / scale[1])


TEMPERATURES = ("total_temperature", "air_temperature")
_SHOULD_MOVE = 0.5  # K, standard deviation: a probe that should move by more cannot stand still


def check_temperature(draft: Draft) -> None:
    """Refuse a temperature that no day has.

    Warn of one far from a standard day, of a probe that never moves, and where it rises with the
    airspeed as that of the other name would.
    """
    for name in TEMPERATURES:
        if name in draft.channels:
            _check_level(draft, name)
            (_check_rise if np.ptp(draft.channels[name]) > 0.0 else _check_still)(draft, name)


def temperature_ratio(draft: Draft, static_pressure: Array) -> float:
    """Return the air's temperature over the standard one at a static pressure [Pa], (k,).

    The pressure is that of `some` rows. 1 without a temperature, or with one that no day has.
    """
    for name in TEMPERATURES:
        if name in draft.channels:
            excess = _excess(draft, name, some(draft, name), static_pressure)
            if abs(excess) < LIMITS.temperature_refused:
                return 1.0 + excess / float(np.median(_standard(static_pressure)))
    return 1.0


def _standard(static_pressure: Array) -> Array:
    return air.standard_temperature(air.pressure_altitude(static_pressure))


def _mach(draft: Draft) -> Array:
    return air.mach_from_impact_pressure(
        some(draft, "impact_pressure"), some(draft, "static_pressure")
    )


def _excess(draft: Draft, name: str, values: Array, static_pressure: Array) -> float:
    """The usual temperature of the air above that of the standard day [K]."""
    cold = air.air_temperature(values, _mach(draft)) if name == "total_temperature" else values
    return float(np.median(cold - _standard(static_pressure)))


def _check_level(draft: Draft, name: str) -> None:
    excess = _excess(draft, name, some(draft, name), some(draft, "static_pressure"))
    if abs(excess) <= LIMITS.temperature_doubted:
        return
    fits = likely_temperatures(draft, name)
    way_out = f"; it would fit {' or '.join(fits)}" if fits else "; check its unit"
    words = (
        f"column {draft.columns[name]!r}: the air is {abs(excess):.0f} K "
        f"{'warmer' if excess > 0 else 'colder'} than on a standard day at this pressure{way_out}"
    )
    draft.doubt(words, abs(excess) > LIMITS.temperature_refused, draft.columns[name])


def likely_temperatures(draft: Draft, name: str) -> list[str]:
    """Return temperature columns whose unit makes a usual day, the nearest to standard first.

    Standard is the standard day.
    """
    written = from_si(some(draft, name), draft.suffixes[name])
    static = np.clip(some(draft, "static_pressure"), QUANTITIES["static_pressure"].low, None)
    found = []
    for suffix in QUANTITIES[name].suffixes:
        values = to_si(written, suffix)
        distance = abs(float(np.median(values - _standard(static))))
        if suffix != draft.suffixes[name] and distance < LIMITS.temperature_doubted:
            found.append((distance, f"{name}_{suffix}"))
    return [column for _, column in sorted(found)]


def _check_still(draft: Draft, name: str) -> None:
    """A constant is a number written by hand, or a dead probe."""
    expected = _standard(some(draft, "static_pressure"))
    if name == "total_temperature":
        expected = air.total_temperature(expected, _mach(draft))
    if float(np.std(expected)) > _SHOULD_MOVE:
        draft.warnings.append(
            Caution(
                f"column {draft.columns[name]!r} never changes, though a probe would: is it stuck, "
                "or a number written by hand? A constant of the air belongs into a column "
                "air_temperature",
                "suspect",
            )
        )


def _check_rise(draft: Draft, name: str) -> None:
    static, time = some(draft, "static_pressure"), some(draft, "time")
    standard = _standard(static)
    rise = air.total_temperature(standard, _mach(draft)) - standard
    slow = [standard - np.mean(standard), time - np.mean(time)]
    design = np.stack([np.ones_like(time), rise, *slow])
    found = next(
        (
            s
            for d in (design, design[[0, 1, 3]])
            if np.isfinite((s := block_slope(time, d, some(draft, name)))[1])
        ),
        None,
    )
    if found is None or found[1] > LIMITS.rise_known:
        return
    slope, error = found
    margin = LIMITS.sigmas * error
    total = name == "total_temperature"
    if total and (slope < LIMITS.rise_low - margin or slope > LIMITS.rise_high + margin):
        likely = (
            "air_temperature"
            if slope < 0.5 * LIMITS.rise_low
            else "total_temperature in another unit"
        )
        words = (
            f"column {draft.columns[name]!r}: a total temperature rises with the airspeed, this "
            f"one {slope:.2f} times as much as it should: it looks like {likely}"
        )
        code = NO_TOTAL if likely == "air_temperature" else "suspect"
        draft.warnings.append(Caution(words, code, draft.columns[name], slope))
    if not total and slope > LIMITS.rise_of_air + margin:
        words = (
            f"column {draft.columns[name]!r}: an air temperature does not rise with the airspeed, "
            f"this one rises {slope:.2f} times as much as a total temperature: name the column "
            f"total_temperature_{draft.suffixes[name]}"
        )
        draft.warnings.append(Caution(words, NO_AIR, draft.columns[name], slope))


def check_height(draft: Draft) -> None:
    """Refuse a static pressure that is in another unit by the height, or reduced to sea level.

    A static pressure that nothing explains is warned of; a height in another unit is not used.
    Raises BadInputError, which names the column to write.
    """
    if "altitude" not in draft.channels:
        return
    static, height = some(draft, "static_pressure"), some(draft, "altitude")
    _refuse_total(draft, static, height)
    if _fits(draft, static, height):
        return
    column, pressure_height = (
        draft.columns["static_pressure"],
        float(np.median(air.pressure_altitude(static))),
    )
    words = (
        f"the static pressure of column {column!r} is that of {pressure_height:.0f} m, column "
        f"{draft.columns['altitude']!r} says {float(np.median(height)):.0f} m"
    )
    other_static = [
        s
        for s, _ in other_units(draft, "static_pressure")
        if _fits(draft, _read_as(draft, "static_pressure", s), height)
    ]
    other_height = [
        s
        for s, _ in other_units(draft, "altitude")
        if _fits(draft, static, _read_as(draft, "altitude", s))
    ]
    if other_static:
        names = " or ".join(f"static_pressure_{s}" for s in other_static)
        raise BadInputError(f"{words}; the pressure would fit {names}: name the column so")
    near = abs(float(np.median(static)) - air.SEA_LEVEL_PRESSURE) < LIMITS.sea_level_band
    if near and float(np.median(height)) > LIMITS.sea_level_height:
        raise BadInputError(
            f"{words}; it looks reduced to sea level (QNH) or constant: record the pressure at the "
            "airplane"
        )
    if other_height:
        names = " or ".join(f"altitude_{s}" for s in other_height)
        draft.leave_out("altitude", f"{words}; the height would fit {names}: name the column so")
        return
    words = f"{words}: no weather explains that; check the unit and the zero of both"
    draft.warnings.append(Caution(words, HEIGHT, draft.columns["altitude"]))


def _fits(draft: Draft, static: Array, height: Array) -> bool:
    # A column of warm air is taller than its pressure altitude says, in the ratio of the
    # temperatures.
    expected = air.pressure_altitude(np.maximum(static, 100.0)) * temperature_ratio(draft, static)
    distance = abs(float(np.median(expected - height)))
    return distance <= LIMITS.height_doubted + LIMITS.height_share * abs(float(np.median(height)))


def _read_as(draft: Draft, name: str, suffix: str) -> Array:
    return to_si(from_si(some(draft, name), draft.suffixes[name]), suffix)


def _refuse_total(draft: Draft, static: Array, height: Array) -> None:
    """A static pressure that rises with the impact pressure at one height is a total pressure."""
    impact, time = some(draft, "impact_pressure"), some(draft, "time")
    excess = static - air.standard_pressure(height)
    design = np.stack([np.ones_like(time), impact, height - np.mean(height)])
    slope, error = block_slope(time, design, excess)
    if slope - LIMITS.sigmas * error > LIMITS.total_slope:
        raise BadInputError(
            f"column {draft.columns['static_pressure']!r}: the pressure rises with the impact "
            f"pressure at one height ({slope:.2f} times as much): it looks like total pressure; "
            f"name the column total_pressure_{draft.suffixes['static_pressure']} and give the "
            "static pressure"
        )


_FEWEST = 10.0  # new samples at the greatest value; sensor noise reaches its greatest value once
# times the samples one step lower; those of a smooth peak are at most 2.4 times as many
_STANDS_OUT = 5.0
_COARSEST = 5.0  # Pa; with coarser steps many rows share the greatest value without a ceiling


def at_ceiling(impact_pressure: Pascal) -> Booleans:
    """Return the rows in which the indicated impact pressure [Pa], (n,), ends its range, (n,).

    The pressure there is the end of the range or more, and nothing is known beyond that. No row is
    returned where the log shows no such end, and for a reading in steps above 5 Pa, in which a
    steady speed looks the same.
    """
    top = float(np.max(impact_pressure))
    rows: Booleans = impact_pressure >= top
    none = np.zeros_like(rows)
    if rows.sum() < _FEWEST or rows.all():
        return none
    step = float(np.median(np.diff(np.unique(impact_pressure))))
    # A recorder repeats the samples of a slower sensor: each run of them is one.
    runs = 1 + np.count_nonzero(np.diff(impact_pressure[~rows]))
    usual = np.count_nonzero(~rows) / runs
    lower = np.count_nonzero((impact_pressure >= top - 1.5 * step) & ~rows)
    found = step <= _COARSEST and rows.sum() >= max(_FEWEST * usual, _STANDS_OUT * lower)
    return rows if found else none
