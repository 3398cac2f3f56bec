"""Temperature against the standard day, and against what a probe does as the airplane speeds up."""

import numpy as np

from pitotbench import air
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.plausibility.limits import LIMITS, some
from pitotbench.logbook.plausibility.slopes import block_slope
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.records.errors import BadInputError
from pitotbench.units import Array, from_si, to_si

TEMPERATURES = ("total_temperature", "air_temperature")
_SHOULD_MOVE = 0.5  # K, standard deviation: a probe that should move by more cannot stand still


def check_temperature(draft: Draft) -> None:
    """Refuse a temperature that no day has; warn of one far from a standard day, or of a probe that never moves."""
    for name in TEMPERATURES:
        if name in draft.channels:
            _check_level(draft, name)
            _check_still(draft, name)


def check_rise(draft: Draft) -> None:
    """Warn where the temperature rises with the airspeed as that of the other name would, or of another unit."""
    for name in TEMPERATURES:
        if name in draft.channels and np.ptp(draft.channels[name]) > 0.0:
            _check_rise(draft, name)


def warmth(draft: Draft, static_pressure: Array) -> float:
    """The air's temperature over that of the standard day, (k,), at a static pressure [Pa] of `some` rows, (k,).

    1 without a temperature, or with one that no day has.
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
    return air.mach_from_impact_pressure(some(draft, "impact_pressure"), some(draft, "static_pressure"))


def _excess(draft: Draft, name: str, values: Array, static_pressure: Array) -> float:
    """The usual temperature of the air above that of the standard day [K]."""
    cold = air.air_temperature(values, _mach(draft)) if name == "total_temperature" else values
    return float(np.median(cold - _standard(static_pressure)))


def _check_level(draft: Draft, name: str) -> None:
    static = some(draft, "static_pressure")
    excess = _excess(draft, name, some(draft, name), static)
    if abs(excess) <= LIMITS.temperature_doubted:
        return
    fits = likely_temperatures(draft, name)
    way_out = f"; it would fit {' or '.join(fits)}" if fits else "; check its unit"
    words = (
        f"column {draft.columns[name]!r}: the air is {abs(excess):.0f} K {'warmer' if excess > 0 else 'colder'} "
        f"than on a standard day at this pressure{way_out}"
    )
    if abs(excess) > LIMITS.temperature_refused:
        raise BadInputError(words)
    draft.warnings.append(words)


def likely_temperatures(draft: Draft, name: str) -> list[str]:
    """Columns of a temperature in whose unit the air would be about that of a standard day, the nearest first."""
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
    static = some(draft, "static_pressure")
    if np.ptp(draft.channels[name]) > 0.0:
        return
    expected = _standard(static)
    if name == "total_temperature":
        expected = air.total_temperature(expected, _mach(draft))
    if float(np.std(expected)) > _SHOULD_MOVE:
        draft.warnings.append(
            f"column {draft.columns[name]!r} never changes, though a probe would: is it stuck, or a number written "
            "by hand? A constant of the air belongs into a column air_temperature"
        )


def _check_rise(draft: Draft, name: str) -> None:
    static, time = some(draft, "static_pressure"), some(draft, "time")
    standard = _standard(static)
    rise = air.total_temperature(standard, _mach(draft)) - standard
    slow = [standard - np.mean(standard), time - np.mean(time)]
    design = np.stack([np.ones_like(time), rise, *slow])
    found = next(
        (s for d in (design, design[[0, 1, 3]]) if np.isfinite((s := _slope(time, d, draft, name))[1])), None
    )
    if found is None or found[1] > LIMITS.rise_known:
        return
    slope, error = found
    margin = LIMITS.sigmas * error
    total = name == "total_temperature"
    if total and (slope < LIMITS.rise_low - margin or slope > LIMITS.rise_high + margin):
        likely = "air_temperature" if slope < 0.5 * LIMITS.rise_low else "total_temperature in another unit"
        draft.warnings.append(
            f"column {draft.columns[name]!r}: a total temperature rises with the airspeed, this one {slope:.2f} "
            f"times as much as it should: it looks like {likely}"
        )
    if not total and slope > LIMITS.rise_of_air + margin:
        draft.warnings.append(
            f"column {draft.columns[name]!r}: an air temperature does not rise with the airspeed, this one rises "
            f"{slope:.2f} times as much as a total temperature: name the column "
            f"total_temperature_{draft.suffixes[name]}"
        )


def _slope(time: Array, design: Array, draft: Draft, name: str) -> tuple[float, float]:
    return block_slope(time, design, some(draft, name))
