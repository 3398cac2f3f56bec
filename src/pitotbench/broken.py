"""Tell a broken pitot by what its reading follows.

The regression of `airdata` says by how much a reading follows the speed (a), the ambient pressure
(b) and the clock. Physics names the fault: a closed total line reads an altimeter (a = 0, b = −1),
a closed static port adds one (a = 1, b = 1), exchanged lines change the sign (a = −1), a stuck
sensor follows nothing. Where the reading is an airspeed of the receiver, it repeats the receiver's
noise.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.airdata import LIMITS as REGRESSION
from pitotbench.airdata import TAXI, Fit, Part, Rest, follow, parts_of, regress, rests_of
from pitotbench.timeline import fresh_fixes, minutes_text
from pitotbench.units import DEGREE, KNOT, STANDARD_GRAVITY, percent_text

BROKEN = "broken pitot"  # code of the warning


@dataclass(frozen=True, slots=True)
class BrokenLimits:
    """What each kind of broken pitot must show to be reported; SI, ratios without unit.

    The limits lie between simulated logs, broken and good, of the laboratory (`pitotlab broken`);
    no measured log of a sound system passes one.
    """

    sigmas: float = 3.0  # standard errors by which a limit must be passed
    excited: float = 1.5  # m/s rms of the speed through the air that no steady wind explains, and
    excited_share: float = 0.04  # of the speed
    dead: float = 0.15  # a, below which a reading does not follow the speed; a sound one has 1
    quiet: float = 0.15  # of the expected change, that a dead reading may have besides
    reversed: float = -0.3  # a, below which lines are exchanged
    better: float = 0.5  # of the misfit of a sound system, that an altimeter leaves of the reading
    altimeter: float = 0.5  # b, from which a reading follows the ambient pressure: 0 or 1 in size
    climbed: float = 300.0  # Pa, range of the ambient pressure that tells b: 25 m at sea level
    before: float = 60.0  # s that a system has worked before it fails
    after: float = 30.0  # s that it has failed
    looks: int = 40  # for the moment of a failure, and then one by one
    # of the impact pressure, the misfit of a reading that is none of the speed
    strange: float = 0.1
    fails: float = 6.0  # times the usual misfit by which a reading leaves what it followed
    far: float = 0.2  # of the expected impact pressure, the same
    gone: float = 0.1  # of the usual impact pressure, the median that is left of one that died
    rarely: float = 0.3  # the same, above which it is in a tenth of the time
    shared: float = 0.8  # of the receiver's noise, in which a copy differs from it; a sensor has 1
    noisy: float = -0.25  # correlation of second differences: −2/3 for white noise, 0.9 for motion
    together: float = 0.3  # m/s rms between airspeed and ground speed: a breath of wind has more
    dense: float = 0.02  # by which true and indicated airspeed must differ for a copy to show
    same: float = 0.1  # degrees rms, in which a track is made of the heading: a compass has 0.2
    crab: float = 2.0  # m/s of crosswind, rms, that headings show: a compass errs by 2° at 60 m/s
    turned: float = 0.3  # 1 − |mean of e^iψ|: 0 on one heading, 1 over full turns
    levels: float = 0.5  # of the misfit, that two levels leave; 0.6 of noise, 0.43 of a sine wave
    rounds: int = 20  # of finding the level of each block, at most
    copies: int = 60_000  # rows in motion: 20 minutes at 50 Hz show a copy of the ground speed
    settle: float = 8.0  # s that a level lasts on average: gusts of an airplane pass sooner
    step: float = 0.08  # of the usual impact pressure, the least step that water makes
    steps: int = 3  # a front of the wind is one, its way back in a turn a second
    drift: float = 0.08  # of the least impact pressures, by which a zero moves to be reported
    shortest: float = 150.0  # s: in less, a drift or steps may be one change of gain
    warms: tuple[float, ...] = (150.0, 400.0)  # s, in which a sensor takes its temperature
    level: float = 0.04  # of the ambient pressure, its most change for one wind to hold: 350 m
    breeze: float = 40.0  # Pa that a wind of 8 m/s on the ground makes
    drift_sigmas: float = 4.0  # standard errors, the same


LIMITS = BrokenLimits()


@dataclass(frozen=True, slots=True)
class Broken:
    """A broken pitot: the sentence with its evidence and what to do.

    `refused` states that the air data hold no answer.
    """

    words: str
    refused: bool = True


def _excitation(part: Part) -> float:
    """The change of the airspeed [m/s rms] that the ground velocity shows and no wind explains."""
    wind, sizes = part.wind()
    columns = np.column_stack([np.ones_like(part.square), wind])
    fit = regress(part.square, columns, part.shared, np.append(np.inf, sizes))
    return float(np.sqrt(np.mean((fit.left / part.slope) ** 2)))


def _response(part: Part) -> Fit:
    """What the reading follows: the speed first, then the ambient pressure, and the clock."""
    around, t = part.ambient - np.mean(part.ambient), part.clock
    return follow(part, part.impact, around, t, t**2)


def _around(fit: Fit, place: int = 0) -> tuple[float, float]:
    """The least and greatest value of a coefficient within its standard errors."""
    margin = LIMITS.sigmas * fit.errors[place]
    return float(fit.values[place] - margin), float(fit.values[place] + margin)


def _dead(part: Part, leaks: bool = True) -> Fit:
    """A reading that does not follow the speed: the static pressure first, and a slow leak."""
    t = part.clock
    columns = [part.static - np.mean(part.static), np.ones_like(t), *([t, t**2] if leaks else [])]
    return regress(part.impact, np.stack(columns, axis=1), part.shared)


def _exchanged(part: Part) -> Broken | None:
    follows = _response(part)
    zero = float(np.mean(part.impact <= 0.0))
    if zero > 0.5:  # the recorder shows nothing below zero: the static line tells
        around = [part.ambient - np.mean(part.ambient)] if part.by_height else []
        follows = follow(part, -part.static, *around)
        what = f"the airspeed reads 0 in {percent_text(zero)} of the flight and the static pressure"
    else:
        what = "the impact pressure"
    if not _around(follows)[1] < LIMITS.reversed:
        return None
    slope = abs(follows.values[0])
    way = "rises" if zero > 0.5 else "falls"
    return Broken(
        f"the lines are exchanged: {what} {way} as the airplane flies faster, by {slope:.2f} of "
        "the dynamic pressure that the GPS velocity asks for; swap the total and the static line "
        "(or the sign of the sensor: ARSPD_TUBE_ORDR of an autopilot) and fly again"
    )


def _excited(part: Part) -> bool:
    least = max(LIMITS.excited, LIMITS.excited_share * float(np.median(part.speed)))
    return _excitation(part) > least


def _follows_nothing(part: Part) -> bool:
    """Whether the speed changes and the reading has no part in it; one in a wrong unit has."""
    low, high = _around(_response(part))
    return _excited(part) and low <= REGRESSION.nothing and high < LIMITS.dead


def _reads_altimeter(dead: Fit) -> bool:
    low, high = _around(dead)
    return high < -LIMITS.altimeter and low > -2.0 + LIMITS.altimeter


def _stopped(part: Part) -> Broken | None:
    """Stuck or blocked throughout."""
    dead, sound = _dead(part), follow(part, part.impact)
    swing = _excitation(part)
    expected = swing * float(np.median(part.slope))
    blocked = _reads_altimeter(dead) and dead.rms < LIMITS.better * sound.rms
    stuck = _follows_nothing(part) and _dead(part, leaks=False).rms < LIMITS.quiet * expected
    if not (blocked or stuck):
        return None
    follows = _response(part)
    known = (
        f"the GPS velocity asks for an airspeed that changes by {swing / KNOT:.0f} kt (rms), and "
        f"the reading follows it by {follows.values[0]:+.2f} ± {2.0 * follows.errors[0]:.2f} "
        "(1 is right)"
    )
    return Broken(_closed_words(part, dead) + f": {known}; {_CLEAN}")


_CLEAN = "look for a cover, ice, insects or water in the tube and its line, and fly again"


def _closed_words(part: Part, dead: Fit) -> str:
    """Whether the reading is that of an altimeter, or of nothing."""
    if _reads_altimeter(dead):
        return (
            "the total line is blocked: the impact pressure reads an altimeter (it changes by "
            f"{dead.values[0]:.2f} ± {2.0 * dead.errors[0]:.2f} of the static pressure; −1 is a "
            "closed line)"
        )
    return (
        f"the sensor is stuck: the impact pressure stands still at {np.median(part.impact):.0f} Pa"
    )


def _failed(part: Part) -> Broken | None:
    """A system that works and fails for the rest of the part."""
    since, left = part.time - part.time[0], part.time[-1] - part.time
    rows = np.flatnonzero((since > LIMITS.before) & (left > LIMITS.after))
    coarse = max(len(rows) // LIMITS.looks, 1)
    for place in range(0, len(rows), coarse):
        if _fails_at(part, rows[place]):
            finer = rows[max(place - coarse + 1, 0) : place + 1]
            return _failure(part, next(row for row in finer if _fails_at(part, row)))
    return None


def _fails_at(part: Part, row: int) -> bool:
    return _died(part, row) or (_frozen(part, row) and not _stopped(part.rows(slice(0, row))))


def _died(part: Part, row: int) -> bool:
    late = np.quantile(np.abs(part.impact[row:]), [0.5, 0.9]) / float(np.median(part.impact[:row]))
    return bool(0.0 <= late[0] < LIMITS.gone and 0.0 <= late[1] < LIMITS.rarely)


def _frozen(part: Part, row: int) -> bool:
    """Whether the reading from a row on follows the speed neither by itself nor by an old wind.

    The old wind is that found before the row.
    """
    early, late = part.rows(slice(0, row)), part.rows(slice(row, None))
    dead, swing = _dead(late, leaks=False), _excitation(late) * float(np.median(late.slope))
    sound = follow(part, part.impact, until=row)
    # Where the reading before is none of this speed in its unit, it is not the tube that fails.
    strange = sound.rms > LIMITS.strange * abs(float(np.median(early.impact)))
    if strange or not _around(sound)[1] > LIMITS.dead:
        return False
    if dead.rms < LIMITS.quiet * swing and _follows_nothing(late):
        return True
    asked, unsure = sound.asked[row:], sound.unsure[row:]
    difference = np.abs(late.impact - asked)
    leaves = difference > np.maximum(
        LIMITS.fails * (unsure + sound.rms), LIMITS.far * np.abs(asked)
    )
    return bool(np.mean(leaves) > 0.5 and dead.rms < LIMITS.quiet * np.std(asked))


def _failure(part: Part, row: int) -> Broken:
    died = _died(part, row)
    smooth = np.convolve(part.impact, np.full(5, 0.2), "same")
    while died and row > 5 and smooth[row - 5] > 1.15 * abs(smooth[row]):
        row -= 1  # back to where the reading began to fall
    moment = minutes_text(float(part.time[row - 1]))
    shown = air.calibrated_airspeed(np.maximum(part.impact, 0.0)) / KNOT
    if died:
        what = "the airspeed dies: the tube is closed by ice or dirt, and its drain is open"
    elif _reads_altimeter(_dead(part.rows(slice(row, None)), leaks=False)):
        what = (
            "the airspeed freezes and reads an altimeter: tube and drain are closed by ice or dirt"
        )
    else:
        what = "the airspeed freezes: the sensor is stuck"
    return Broken(
        f"from {moment} on {what}; it reads {np.median(shown[row:]):.0f} kt and before "
        f"{np.median(shown[:row]):.0f} kt, while the ground speed goes from "
        f"{np.median(part.speed[:row]) / KNOT:.0f} to {np.median(part.speed[row:]) / KNOT:.0f} kt "
        f"(medians). Use what is before: --to {moment}"
    )


def _taped(part: Part) -> Broken | None:
    climbed = float(np.ptp(np.quantile(part.ambient, [0.02, 0.98])))
    if not part.by_height or climbed < LIMITS.climbed:
        return None
    around = part.ambient - np.mean(part.ambient)
    columns = np.stack([around, np.ones_like(around), part.clock], axis=1)
    static = regress(part.static, columns, part.shared)
    reading = _response(part)
    follows_nothing = _around(static)[1] < LIMITS.altimeter
    adds = reading.values[1] > LIMITS.altimeter and _around(reading, 1)[0] > 0.0
    if not (follows_nothing and adds):
        return None
    return Broken(
        f"the static port is closed (tape, ice or water): the static pressure changes by "
        f"{static.values[0]:.2f} of what the heights ask for, a range of {climbed / 100.0:.0f} hPa"
        f", and the impact pressure by {reading.values[1]:+.2f} of it (0 is right): open the port "
        "and fly again"
    )


def _climbs(part: Part) -> bool:
    """Whether the heights differ by so much that their winds do."""
    return float(np.ptp(part.ambient)) > LIMITS.level * float(np.median(part.ambient))


def _water(part: Part) -> Broken | None:
    """A reading that jumps between two levels: each block belongs to one, found with the fit."""
    if _climbs(part) or np.ptp(part.time) < LIMITS.shortest:
        return None
    left = follow(part, part.impact).left
    usual, high = float(np.sqrt(np.mean(left**2))), left > np.mean(np.quantile(left, [0.1, 0.9]))
    for _ in range(LIMITS.rounds):
        fit = follow(part, part.impact, high.astype(np.float64))
        size = float(fit.values[1])
        before, high = high, fit.left + size * high > 0.5 * size
        if np.array_equal(before, high) or high.all() or not high.any():
            break
    steps = int(np.count_nonzero(np.diff(high)))
    dwell = len(high) * REGRESSION.block / (steps + 1)
    if fit.rms > LIMITS.levels * usual or steps < LIMITS.steps or dwell < LIMITS.settle:
        return None
    if size < LIMITS.step * float(np.median(part.impact)):
        return None
    return Broken(
        f"water is in a line, or a loose contact: the impact pressure jumps {steps} times to and "
        f"fro by some {size:.0f} Pa ({size / STANDARD_GRAVITY:.0f} mm of water), and neither the "
        "GPS velocity nor a wind explains it; drain the lines and fly again",
        refused=False,
    )


_WARMS = (
    "as a sensor does that warms up or cools down; no one curve holds. Let it take its "
    "temperature, set its zero anew before the flight, or use a short part (--from, --to)"
)


_STATED = 1.0  # Pa, within which no flight keeps its height: it is stated


def _drifting(part: Part) -> Broken | None:
    """A zero that moves in flight, alike on all headings and at all speeds.

    Where the height is stated and not logged, a climb moves the impact pressure as well.
    """
    if _climbs(part) or np.ptp(part.time) < LIMITS.shortest or np.ptp(part.ambient) < _STATED:
        return None
    since = part.time - part.time[0]
    shapes = [since / since[-1], *(1.0 - np.exp(-since / warm) for warm in LIMITS.warms)]
    fits = [follow(part, part.impact, shape / shape[-1]) for shape in shapes]
    found = min(fits, key=lambda fit: fit.rms)
    moved, error = float(found.values[1]), float(found.errors[1])
    low = float(np.quantile(part.impact, 0.1))
    if abs(moved) < max(LIMITS.drift_sigmas * error, LIMITS.drift * low):
        return None
    return Broken(
        "the zero drifts: on all headings and at all speeds the impact pressure moves by "
        f"{moved:+.0f} ± {2.0 * error:.0f} Pa in {np.ptp(part.time) / 60.0:.0f} min, {_WARMS}",
        refused=False,
    )


def zero_moved(channels: Mapping[str, Any], rests: Sequence[Rest]) -> Broken | None:
    """Return a zero that differs at rest before and after the flight, by what `rests` show."""
    if len(rests) < 2:
        return None
    before, after = (each.reading_pa for each in rests)
    scatter = max(each.scatter_pa for each in rests)
    speed = np.hypot(channels["velocity_north"], channels["velocity_east"])
    fast = speed > REGRESSION.flying * float(np.quantile(speed, 0.95))
    low = float(np.quantile(channels["impact_pressure"][fast], 0.1))
    moved = after - before
    if abs(moved) < max(LIMITS.breeze, LIMITS.drift * low, REGRESSION.steady * scatter):
        return None
    return Broken(
        f"the zero drifts: at rest the impact pressure reads {before:.0f} Pa before the flight and "
        f"{after:.0f} Pa after it, {percent_text(abs(moved) / low)} of what it reads in slow "
        f"flight, {_WARMS}",
        refused=False,
    )


def _copied(channels: Mapping[str, Any]) -> Broken | None:
    """An airspeed that is the receiver's own speed."""
    moving = np.hypot(channels["velocity_north"], channels["velocity_east"]) > 0.5 * TAXI
    first = int(np.argmax(moving))
    channels = {name: values[first : first + LIMITS.copies] for name, values in channels.items()}
    north, east = channels["velocity_north"], channels["velocity_east"]
    fresh = fresh_fixes(channels.get("gps_fresh"), north, east)
    # A copy is held from fix to fix, where the file's reader may interpolate the velocity.
    renewed = np.diff(channels["impact_pressure"], prepend=np.nan) != 0.0
    rows = np.flatnonzero(fresh & renewed & moving[first : first + LIMITS.copies])
    if len(rows) < REGRESSION.fewest:
        return None
    ground, track = np.hypot(north, east)[rows], np.arctan2(east, north)[rows]
    if 1.0 - abs(np.mean(np.exp(1j * track))) < LIMITS.turned:
        return None
    impact, static = (channels[n][rows] for n in ("impact_pressure", "static_pressure"))
    shown = air.calibrated_airspeed(np.maximum(impact, 0.0))
    fit = np.stack([ground, np.ones_like(ground)], axis=1)
    slope, level = np.linalg.lstsq(fit, shown, rcond=None)[0]
    left = shown - slope * ground - level
    difference = float(np.sqrt(np.mean(left**2)))
    if difference > LIMITS.together or not slope > LIMITS.altimeter:
        return None
    noise, own = np.diff(ground, 2), np.diff(left, 2)
    white = float(np.corrcoef(noise[1:], noise[:-1])[0, 1]) if np.ptp(noise) > 0.0 else 0.0
    repeats = white < LIMITS.noisy and np.std(own) < LIMITS.shared * np.std(noise)
    dense = air.standard_temperature(air.pressure_altitude(np.clip(static, 1e3, None)))
    true = air.true_airspeed(np.maximum(impact, 0.0), np.clip(static, 1e3, None), dense)
    equal = float(np.sqrt(np.mean((shown - ground) ** 2))) < LIMITS.together
    impossible = equal and float(np.median(true / np.maximum(shown, 0.1))) - 1.0 > LIMITS.dense
    evidence = (
        f"it differs from the ground speed by {difference / KNOT:.2f} kt (rms) on all headings"
    )
    if repeats:
        evidence += ", and repeats the noise of the receiver"
    if (heading := channels.get("heading")) is not None:
        off = np.angle(np.exp(1j * (heading[rows] - track)))
        crab = float(np.sqrt(np.mean((off - np.mean(off)) ** 2) * np.mean(ground) ** 2))
        if float(np.std(off)) < LIMITS.same * DEGREE:
            return None  # the velocity may as well be made of airspeed and heading
        if crab > LIMITS.crab:
            impossible = True
            evidence += (
                f", while headings and tracks, {np.std(off) / DEGREE:.0f}° apart (rms), show a wind"
            )
    if not (repeats or impossible):
        return None
    return Broken(
        f"the airspeed is a copy of the GPS speed, no pitot's: {evidence}; record the airspeed of "
        "the sensor (on an autopilot ARSPD_TYPE and ARSPD_USE; a virtual pitot is no sensor)"
    )


# In the order in which they are asked: what is wrong with a sign or a channel comes before what is
# wrong in size.
KINDS: dict[str, Callable[[Part], Broken | None]] = {
    "exchanged lines": _exchanged,
    "static port closed": _taped,
    "stuck or blocked": _stopped,
    "fails in flight": _failed,
}
# What a mistake of the velocities looks like as well: asked where these are sound.
LATE_KINDS: dict[str, Callable[[Part], Broken | None]] = {
    "water": _water,
    "drifting zero": _drifting,
}


def find_broken(channels: Mapping[str, Any]) -> Broken | None:
    """Return the first kind of broken pitot that the channels of a log show, None where none does.

    Parameters: channels [SI] by name, (n,) each: `time`, `impact_pressure`, `static_pressure`,
    `velocity_north`, `velocity_east`; `altitude`, `heading` and `gps_fresh` where the log has them.
    """
    return find_early(channels) or zero_moved(channels, rests_of(channels)) or find_late(channels)


def find_early(channels: Mapping[str, Any]) -> Broken | None:
    """Return a kind of broken pitot that no mistake of the velocities looks like."""
    return _copied(channels) or _first(channels, KINDS)


def find_late(channels: Mapping[str, Any]) -> Broken | None:
    """Return a kind that a mistake of the velocities looks like as well."""
    return _first(channels, LATE_KINDS)


def _first(
    channels: Mapping[str, Any], kinds: Mapping[str, Callable[[Part], Broken | None]]
) -> Broken | None:
    known = (kind(part) for part in parts_of(channels) for kind in kinds.values())
    return next((found for found in known if found is not None), None)
