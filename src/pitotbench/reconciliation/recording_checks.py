"""Check the recording of a log, without a model: repeats, gaps, clock, quantization, ceilings.

A recording fault that is found here is named here and does not enter the comparison: repeated
samples are not new ones, and rows at the ceiling hold no measurement.
"""

from dataclasses import dataclass

import numpy as np

from pitotbench.channels import numbers_from
from pitotbench.logbook.plausible_air import at_ceiling
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Candidate, Check
from pitotbench.timeline import gaps, in_outage, interval
from pitotbench.units import Array, Booleans

AIR_DATA = numbers_from("air")
PRESSURES = ("impact_pressure", "static_pressure")
SLOW_BUS = 2.0  # rows between new pressures, from which a slower bus is reported
LISTED = 3  # outages of the GPS whose times are reported


@dataclass(frozen=True, slots=True)
class CheckedLog:
    """The result of the checks.

    `effects` are the recording faults that were counted. `fresh` marks the rows with new air data.
    """

    checks: tuple[Check, ...]
    effects: tuple[Candidate, ...]
    fresh: Booleans


def check_log(log: FlightLog) -> CheckedLog:
    """Check a log for faults of its recording."""
    repeated = _repeats(log)
    hold, repeats = _hold(log, repeated)
    step, stepped = _steps(log, repeated)
    ceiling, capped = _ceiling(log)
    return CheckedLog(
        (_clock(log), _gaps(log), hold, step, ceiling, _gps(log)),
        (*repeats, *stepped, *capped),
        ~repeated,
    )


def _counted(effect: str, size: Estimate) -> Candidate:
    return Candidate(effect, (size,), THRESHOLDS.counted_score)


def _repeats(log: FlightLog) -> Booleans:
    """Return the rows on which all air data repeat their values, if more than by chance.

    The two pressures count as one: a slow bus, or a static pressure that both are made with,
    repeats them together. A temperature that comes in coarse steps repeats at its own times, and a
    constant one says nothing.
    """
    present = {name: values for name in AIR_DATA if (values := getattr(log, name)) is not None}
    each = {name: np.diff(values) == 0.0 for name, values in present.items()}
    pressures = [each.pop(name) for name in PRESSURES]
    varying = [same for same in each.values() if not same.all()]
    sources = [np.all(pressures, axis=0), *varying] if varying else pressures
    same = np.all([*pressures, *each.values()], axis=0)
    rates = np.mean(sources, axis=1)
    by_chance = float(np.prod(rates)) * len(same)
    # A source that is held over k rows, k = 1/(1 - rate), gives as many independent rows less.
    spread = np.sqrt(by_chance * (1.0 - float(np.min(rates))))
    repeated: Booleans = np.concatenate([[False], same])
    surplus = THRESHOLDS.repeats_fewest + THRESHOLDS.repeats_beyond_chance * spread
    return repeated if repeated.sum() - by_chance > surplus else np.zeros_like(repeated)


def _hold(log: FlightLog, repeated: Booleans) -> tuple[Check, tuple[Candidate, ...]]:
    if not repeated.any():
        return _slow_bus(log), ()
    period = interval(log.time)
    out = in_outage(log.time, ~repeated)
    where = f"; {_outages(log, out)}" if out.any() else ""
    lengths = np.diff(np.flatnonzero(~repeated & ~out))
    typical = float(np.median(lengths))
    if typical > 1 and np.mean(np.abs(lengths - typical) <= 1) > THRESHOLDS.repeats_regular:
        hold_time = float(np.mean(lengths)) * period
        why = f"air data are renewed every {hold_time:.3g} s and held between"
        return Check("repeated samples", "failed", why), (
            _counted("sample_and_hold", Estimate("period_s", hold_time, period)),
        )
    lost = repeated & ~out
    if not lost.any():
        return Check("repeated samples", "failed", f"air data{where[1:]}"), ()
    lengths = np.diff(np.flatnonzero(~repeated))
    share = float(np.mean(lost))
    spread = 2.0 * float(
        np.sqrt(share * max(1.0, float(lengths[lengths > 1].mean()) - 1.0) / len(log))
    )
    why = (
        f"{100.0 * share:.1f} % of the rows repeat the air data of the row before: lost "
        f"samples, filled in{where}"
    )
    return Check("repeated samples", "failed", why), (
        _counted("dropped_samples", Estimate("fraction", share, spread)),
    )


def _slow_bus(log: FlightLog) -> Check:
    """Check whether the pressures alone are held between samples, by a slower bus.

    The comparison does not rest on that.
    """
    new = np.flatnonzero(np.any([np.diff(getattr(log, name)) != 0.0 for name in PRESSURES], axis=0))
    hold_time = float(np.median(np.diff(new))) * interval(log.time) if len(new) > 1 else 0.0
    if hold_time < SLOW_BUS * interval(log.time):
        return Check("repeated samples", "passed", "air data are new on every row")
    why = f"the pressures are renewed every {hold_time:.3g} s and held between; no row is lost"
    return Check("repeated samples", "remark", why)


def _steps(log: FlightLog, repeated: Booleans) -> tuple[Check, tuple[Candidate, ...]]:
    """The smallest step of the pressures against their noise, which second differences show."""
    steps = [_step(getattr(log, name)[~repeated]) for name in PRESSURES]
    noise = [_noise(getattr(log, name)[~repeated]) for name in PRESSURES]
    coarse = [
        step > max(THRESHOLDS.quantization_smallest, THRESHOLDS.quantization_noise * level)
        for step, level in zip(steps, noise, strict=True)
    ]
    listed = " and ".join(f"{step:.3g}" for step in steps)
    if not any(coarse):
        return Check(
            "quantization", "passed", f"pressures come in steps of {listed} Pa, below their noise"
        ), ()
    worst = max(steps)
    why = (
        f"pressures come in steps of {listed} Pa, above their noise of {noise[0]:.2g} and "
        f"{noise[1]:.2g} Pa"
    )
    return Check("quantization", "failed", why), (
        _counted("quantization", Estimate("step_pa", worst, 0.02 * worst)),
    )


def _step(values: Array) -> float:
    levels = np.unique(values)
    return float(np.median(np.diff(levels))) if len(levels) > 2 else 0.0


def _noise(values: Array) -> float:
    """Standard deviation of the noise without the rounding, from second differences."""
    second = values[2:] - 2.0 * values[1:-1] + values[:-2]
    return float(np.sqrt(max(0.0, float(np.mean(second**2)) / 6.0 - _step(values) ** 2 / 12.0)))


def _ceiling(log: FlightLog) -> tuple[Check, tuple[Candidate, ...]]:
    capped = at_ceiling(log.impact_pressure)
    if not capped.any():
        return Check("saturation", "passed", "impact pressure does not stand at a ceiling"), ()
    top = float(log.impact_pressure.max())
    why = f"impact pressure stands at {top:.1f} Pa on {int(capped.sum())} rows"
    return Check("saturation", "failed", why), (
        _counted("saturation", Estimate("ceiling_pa", top, 1.0)),
    )


def _clock(log: FlightLog) -> Check:
    step = np.diff(log.time)
    typical = float(np.median(step))
    odd = float(np.mean(np.abs(step - typical) > THRESHOLDS.clock_odd_step * typical))
    if odd > THRESHOLDS.clock_odd_share:
        return Check(
            "clock",
            "failed",
            f"{100.0 * odd:.1f} % of the time steps differ from the median of {typical:.4g} s",
        )
    return Check("clock", "passed", f"rows every {typical:.4g} s")


def _gaps(log: FlightLog) -> Check:
    after = gaps(log.time)
    if len(after):
        lasted = float(np.sum(log.time[after] - log.time[after - 1]))
        return Check("gaps", "passed", f"{len(after)} gaps in the recording, {lasted:.1f} s in all")
    return Check("gaps", "passed", "no gap in the recording")


def _gps(log: FlightLog) -> Check:
    fresh = log.fresh_fixes()
    if fresh.all():
        return Check("GPS", "passed", "velocity is new on every row")
    outages = in_outage(log.time, log.renewed_fixes())
    if outages.any():
        return Check("GPS", "failed", f"fixes {_outages(log, outages)}")
    period = interval(log.time[fresh])
    return Check(
        "GPS", "passed", f"velocity is renewed every {period:.3g} s and interpolated between"
    )


def _outages(log: FlightLog, outages: Booleans) -> str:
    """How long a sensor was silent in all, and when the first times began, in words."""
    begins = np.flatnonzero(np.diff(outages.astype(np.int8), prepend=0) == 1)
    lasted = float(np.sum(outages)) * interval(log.time)
    places = ", ".join(f"{log.time[row] - log.time[0]:.0f}" for row in begins[:LISTED])
    more = ", …" if len(begins) > LISTED else ""
    return f"stand still for {lasted:.1f} s in all, from {places}{more} s after the start: not used"
