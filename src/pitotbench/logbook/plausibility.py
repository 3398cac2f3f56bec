"""What cannot be true together in a log: a mistake that fits is named with the column to write."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.airdata import LIMITS as REGRESSION
from pitotbench.airdata import NEEDED, Part, follow, part_of
from pitotbench.broken import BROKEN
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.plausible_air import (
    LIMITS,
    at_ceiling,
    check_height,
    check_temperature,
    other_units,
    some,
    temperature_ratio,
)
from pitotbench.records import BadInputError
from pitotbench.records.log import FORMAT, Caution
from pitotbench.timeline import fresh_fixes
from pitotbench.units import DEGREE, STANDARD_GRAVITY, SUFFIXES, Array, percent_text

SPEED_FACTOR = "speed factor"  # code of the warning, which the factor of a calibration replaces
_FLYING = 5.0  # m/s over ground
_SLOW = 0.2  # share of the largest impact pressures below which the airplane taxies
_ROWS = 600  # that the fit looks at: more rows add nothing to a factor
_FEWEST = 20  # rows in flight, below which no factor is fitted
_ZERO_LEADS = 2.0  # times what the scale contributes, for a zero offset to be named
_NEAR = 1.5  # times the airspeed: a unit that leaves the ground speed farther off is not tried
_GAINS = {  # on the impact pressure
    2.0: "half the impact pressure",
    0.5: "twice the impact pressure",
    4.0: "half of the airspeed",
}
_NO_SHARE = 1e-3  # of the pressure that the speed makes: a reading of less follows nothing
_SMALL_ZERO = 30.0  # Pa: a smaller one is not what makes the speeds differ


@dataclass(frozen=True, slots=True)
class FlownRows:
    """The rows in flight with a new fix, (n,) each, from which the factor is found.

    `rows` counts in the draft.
    """

    rows: NDArray[np.intp]
    time: Array
    impact: Array
    static: Array
    temperature: Array
    north: Array
    east: Array

    def part(self) -> Part:
        """The same as rows of the regression."""
        measured = (self.time, self.impact, self.static, self.north, self.east)
        return part_of(dict(zip(NEEDED, measured, strict=True)), self.temperature)


@dataclass(frozen=True, slots=True)
class Factor:
    """What the ground speed says of the impact pressure q_c: true ≈ `scale` · q_c + `zero`.

    `excess` is true over measured, less one, at low, usual and high q_c, with standard errors
    `spread`; `wind` (2, n) [m/s] toward north and east on each row; `misfit` the rms of ground
    speed less wind against airspeed, over airspeed. `change` is that of the factor from the first
    to the second half of the log, with its standard error.
    """

    scale: float
    zero: float
    excess: Array
    spread: Array
    wind: Array
    misfit: float
    change: float
    change_spread: float


def flown_rows(draft: Draft) -> FlownRows | None:
    """Return the rows to compare, None where too few fly below the end of the sensor's range."""
    c = draft.channels
    north, east, impact = c["velocity_north"], c["velocity_east"], c["impact_pressure"]
    flying = np.hypot(north, east) > _FLYING
    flying &= impact > max(0.0, _SLOW * float(np.quantile(impact, 0.95)))
    flying &= ~at_ceiling(impact)
    flying &= fresh_fixes(c.get("gps_fresh"), north, east)
    rows = np.flatnonzero(flying)
    if len(rows) < _FEWEST:
        return None
    rows = rows[:: max(1, len(rows) // _ROWS)]
    static = c["static_pressure"][rows]
    warm = air.standard_temperature(air.pressure_altitude(static)) * temperature_ratio(
        draft, some(draft, "static_pressure")
    )
    return FlownRows(rows, c["time"][rows], impact[rows], static, warm, north[rows], east[rows])


def find_factor(flown: FlownRows) -> Factor:
    """Return the factor by which the reading follows the speed, with zero, change and wind.

    The change is one at half time.

    Over all headings a wind cannot look like a factor. On one heading it can: then the standard
    error of the factor, with the wind's usual size as knowledge, is large, and nothing is said.
    """
    late = np.where(flown.time > np.median(flown.time), 0.5, -0.5)
    # A reading in another unit is first brought to the size that the ground speed asks for, as the
    # gusts are those of the speed.
    part = flown.part()
    size = float(np.median(part.square) / np.median(flown.impact))
    read = size * flown.impact
    fit = follow(part, read, late * read, zero=REGRESSION.zero)
    share, change, zero = max(float(fit.values[0]), _NO_SHARE), *fit.values[1:3]
    impact = np.quantile(flown.impact, [0.1, 0.5, 0.9])
    needed = (size * impact - zero) / (share * impact)
    by_unknown = np.stack([-needed / share, -1.0 / (share * impact)])
    of_both = fit.covariance[np.ix_([0, 2], [0, 2])]
    through_air = np.hypot(flown.north - fit.wind[0], flown.east - fit.wind[1])
    # What no wind explains becomes a speed by the share of the speed in the reading. Rows at one
    # speed hardly tell that: the one nearest 1 that they allow is taken.
    margin = LIMITS.sigmas * float(fit.errors[0])
    likely = float(np.clip(1.0, share - margin, share + margin))
    left = fit.left / (2.0 * likely * part.density * np.maximum(through_air, 1.0))
    misfit = float(np.sqrt(np.mean(left**2)))
    return Factor(
        scale=size / share,
        zero=float(-zero / share),
        excess=needed - 1.0,
        spread=np.sqrt(np.einsum("ik,ij,jk->k", by_unknown, of_both, by_unknown)),
        wind=fit.wind,
        misfit=misfit / max(float(np.median(through_air)), 1.0),
        change=float(-change),
        change_spread=float(fit.errors[1]),
    )


def _columns(draft: Draft) -> str:
    return f"columns {draft.columns['impact_pressure']!r} and {draft.columns['velocity_north']!r}"


def _check_axes(draft: Draft, flown: FlownRows, factor: Factor) -> None:
    """Refuse a velocity of which one component is in another unit than the other."""
    if factor.misfit <= LIMITS.axes_misfit:
        return
    for axis in ("north", "east"):
        name = f"velocity_{axis}"
        for suffix, times in other_units(draft, name):
            other = replace(flown, **{axis: getattr(flown, axis) * times})
            if find_factor(other).misfit < LIMITS.axes_better * factor.misfit:
                raise BadInputError(
                    f"column {draft.columns[name]!r}: this component alone looks like "
                    f"{SUFFIXES[suffix].words}: name the column {name}_{suffix}"
                )


def _check_misfit(draft: Draft, factor: Factor) -> None:
    if factor.misfit <= LIMITS.misfit_doubted:
        return
    draft.doubt(
        f"{_columns(draft)}: no steady wind brings ground speed and airspeed together (they differ "
        f"by {percent_text(factor.misfit)} rms): check that {draft.columns['velocity_north']!r} "
        f"and {draft.columns['velocity_east']!r} are north and east in one unit, on the clock of "
        "the air data",
        factor.misfit > LIMITS.misfit_refused,
    )


def _check_change(draft: Draft, factor: Factor) -> None:
    doubted = abs(factor.change) - LIMITS.sigmas * factor.change_spread
    if doubted <= 0.0 or abs(factor.change) <= LIMITS.change_doubted:
        return
    draft.doubt(
        f"{_columns(draft)}: the impact pressure that the ground speed asks for changes by "
        f"{percent_text(factor.change, '+')} from the first to the second half of the log, against "
        "the measured one: did a unit, a gain or a source change in flight?",
        doubted > LIMITS.change_refused,
    )


def _check_size(draft: Draft, flown: FlownRows, factor: Factor) -> None:
    size = np.abs(factor.excess) - LIMITS.sigmas * factor.spread
    if not np.any(size > LIMITS.curve_doubted):
        return
    airspeed = float(np.median(air.true_airspeed(flown.impact, flown.static, flown.temperature)))
    ground = float(np.median(np.hypot(flown.north - factor.wind[0], flown.east - factor.wind[1])))
    impact = np.quantile(flown.impact, [0.1, 0.5, 0.9])
    fits, gains = _fits(draft, flown, factor, (airspeed, ground)), _gains(draft, factor)
    others = [] if fits else _other_guesses(draft, factor, impact, bool(gains))
    words = (
        f"{_columns(draft)}: the air data say about {airspeed:.0f} m/s, the GPS {ground:.0f} m/s "
        f"with the wind taken off: {', or '.join([*fits, *gains, *others])}"
    )
    absurd = size - LIMITS.zero_allowed / impact > LIMITS.curve_refused
    # A unit that fits explains more than a zero does, where the difference is more than that of a
    # zero.
    named = bool(fits) and size[1] > max(LIMITS.curve_refused, LIMITS.zero_allowed / impact[1])
    # A factor that a gauge or a setting may have is an answer of the calibration.
    needed = np.sqrt(max(1.0 + float(factor.excess[1]), 1e-6))
    forbidden = not 1.0 / LIMITS.scale_refused < needed < LIMITS.scale_refused
    # Nor does a pitot of subsonic flow show a supersonic speed.
    forbidden |= ground > float(np.median(air.sound_speed(flown.temperature))) > airspeed
    refused = forbidden and (named or bool(np.all(absurd)))
    draft.doubt(words, refused, draft.columns["impact_pressure"], SPEED_FACTOR)


def _fits(draft: Draft, flown: FlownRows, factor: Factor, speeds: tuple[float, float]) -> list[str]:
    """Return the mistakes of unit that fit, with the columns to write.

    None where a recorder's format prescribes the units. One of the velocity is tried with a new fit
    of the wind where it brings the ground speed near the airspeed, `speeds` [m/s] of air data and
    GPS; one of the impact pressure leaves the wind as it is.
    """
    if draft.units_by["velocity"] == FORMAT:
        return []
    fits, (airspeed, ground) = list[str](), speeds
    needed = 1.0 + float(factor.excess[1])
    for suffix, times in other_units(draft, "velocity_north"):
        if not airspeed / _NEAR < ground * times < airspeed * _NEAR:
            continue
        other = replace(flown, north=flown.north * times, east=flown.east * times)
        if abs(float(find_factor(other).excess[1])) < LIMITS.unit_fits:
            columns = f"velocity_north_{suffix} and velocity_east_{suffix}"
            fits.append(f"these look like {SUFFIXES[suffix].words}: name the columns {columns}")
    column = draft.columns["impact_pressure"]
    if not column.startswith("impact_pressure"):
        return fits  # formed from a total pressure: another unit of it would have been refused
    return fits + [
        f"{column!r} looks like {SUFFIXES[suffix].words}: name the column impact_pressure_{suffix}"
        for suffix, times in other_units(draft, "impact_pressure")
        if abs(needed / times - 1.0) < LIMITS.unit_fits
    ]


def _gains(draft: Draft, factor: Factor) -> list[str]:
    """The gains that fit and are no unit."""
    needed = max(1.0 + float(factor.excess[1]), 1e-6)
    return [
        f"{draft.columns['impact_pressure']!r} looks like {words}: check its gain"
        for times, words in _GAINS.items()
        if abs(np.log(needed / times)) < LIMITS.unit_fits
    ]


def _other_guesses(draft: Draft, factor: Factor, impact_pressure: Array, gained: bool) -> list[str]:
    """What may be wrong where no unit fits."""
    north, impact = draft.columns["velocity_north"], draft.columns["impact_pressure"]
    offset = _offset(factor, impact_pressure)
    if abs(offset) > _SMALL_ZERO:
        return [f"{impact!r} looks as if it had a zero offset of {offset:+.0f} Pa: check its zero"]
    needed = np.sqrt(max(1.0 + float(factor.excess[1]), 1e-6))
    words = f"multiply the airspeed by {needed:.2f}, or check units and zero of {impact!r}"
    return [] if gained else [f"{words} and {north!r}"]


def _offset(factor: Factor, impact_pressure: Array) -> float:
    """Return the zero offset [Pa] that would explain the difference, 0 where none does.

    The `impact_pressure`, (3,), is that of `excess`. No gauge has a very large zero, and none is
    told where a factor explains the difference and a zero does not.
    """
    usual = float(impact_pressure[1])
    if abs(factor.zero) > _ZERO_LEADS * abs(factor.scale - 1.0) * usual:
        return -factor.zero
    offset = -float(factor.excess[1]) * usual
    # What a zero adds falls as the impact pressure grows, what a factor adds does not.
    left = np.abs(factor.excess + offset / impact_pressure)
    fits = bool(np.all(left < LIMITS.sigmas * factor.spread))
    return offset if fits and abs(offset) <= LIMITS.zero_allowed else 0.0


_MIRRORED = {  # degrees of the angle of a, to the nearest quarter of a turn
    0: "the east velocity has the wrong sign",
    90: "the north and east velocities are exchanged",
    180: "the north velocity has the wrong sign",
    -90: "the north and east velocities are exchanged, with the wrong sign",
}


@dataclass(frozen=True, slots=True)
class Alignment:
    """The angle from heading to velocity, its standard error [deg], and the rms misfit [-].

    The misfit is over the airspeed.
    """

    angle: float
    spread: float
    misfit: float


def check_heading(draft: Draft, flown: FlownRows, factor: Factor) -> None:
    """Warn where velocity does not follow heading; leave out a heading that stands in turns."""
    heading = draft.channels.get("heading")
    if heading is None:
        return
    psi = heading[flown.rows]
    track = np.arctan2(flown.east, flown.north)
    if _turning(psi) < LIMITS.headings_spread:
        if (
            _turning(track) > LIMITS.headings_spread
            and _turning(psi) < 0.1 * LIMITS.headings_spread
        ):
            draft.leave_out("heading", "it does not turn while the GPS track does; check its unit")
        return
    found = _disagreement(flown, factor, psi, track)
    if found:
        columns = f"columns {draft.columns['heading']!r} and {draft.columns['velocity_north']!r}"
        text = f"{columns}: {found}; the wind, and all that uses the heading, would be wrong"
        draft.warnings.append(Caution(text, found.code, draft.columns["heading"], found.size))


def align(flown: FlownRows, psi: Array, mirrored: bool) -> Alignment:
    """The least-squares a and winds of the velocity against the heading `psi` [rad], (n,).

    With z = north + i·east, the velocity over ground is a·V·e^(iψ) + wind, and a is near 1. A
    velocity with exchanged axes or with one wrong sign is the mirror image, a·V·e^(−iψ) + wind; the
    angle of a says which.
    """
    airspeed = air.true_airspeed(flown.impact, flown.static, flown.temperature)
    pointer = airspeed * np.exp(-1j * psi if mirrored else 1j * psi)
    velocity = flown.north + 1j * flown.east
    part = flown.part()
    winds = part.shapes()
    matrix = np.column_stack([pointer, winds])
    solution = np.linalg.lstsq(matrix, velocity, rcond=None)[0]
    residuals = velocity - matrix @ solution
    misfit = float(np.sqrt(np.mean(np.abs(residuals) ** 2)))
    alone = pointer - winds @ np.linalg.lstsq(winds, pointer)[0]
    scatter = float(np.sqrt(np.mean(np.abs(alone) ** 2)))
    spread = misfit / (abs(solution[0]) * scatter * np.sqrt(len(psi) / part.shared))
    usual = abs(solution[0]) * float(np.median(airspeed))
    return Alignment(float(np.angle(solution[0])) / DEGREE, float(spread) / DEGREE, misfit / usual)


def _turning(angle: Array) -> float:
    """0 on one heading, 1 over full turns or out and back."""
    return 1.0 - float(np.abs(np.mean(np.exp(1j * angle))))


def _disagreement(flown: FlownRows, factor: Factor, psi: Array, track: Array) -> Caution:
    direct, mirror = align(flown, psi, False), align(flown, psi, True)
    least = min(direct.misfit, mirror.misfit)
    if least > LIMITS.misfit_refused:
        return Caution(
            "the velocity does not follow the heading; check signs and units of both",
            "heading",
            size=least,
        )
    if mirror.misfit < LIMITS.mirror_better * direct.misfit:
        quarter = round(mirror.angle / 90.0) * 90
        return Caution(
            f"{_MIRRORED[180 if abs(quarter) == 180 else quarter]}, or the heading is counted "
            "the wrong way",
            "mirrored",
            size=mirror.angle,
        )
    if least > LIMITS.misfit_doubted:
        return Caution(
            "the velocity does not follow the heading (they differ by "
            f"{percent_text(direct.misfit)} rms): does one of its components lack its sign?",
            "heading",
            size=direct.misfit,
        )
    # Where the latency is known, `calibrate` withdraws this (reduction), and `reconcile` where a
    # part explains it.
    if abs(direct.angle) - LIMITS.sigmas * direct.spread > LIMITS.angle_doubted:
        return Caution(
            "both velocities have the wrong sign, or the heading is that of the tail"
            if abs(direct.angle) > 150.0
            else f"the axes are turned by {direct.angle:+.0f}° against each other: is one of them "
            "magnetic, the heading not the airplane's, a sign wrong, or one of them late in the "
            "turns?",
            "axes turned",
            size=direct.angle,
        )
    if _is_reckoned(flown, factor):
        return Caution(
            "the velocity repeats the noise of the airspeed: it is made of the air data", "reckoned"
        )
    return Caution(
        "the heading is the track over ground" if _is_track(flown, factor, psi, track) else "",
        "track",
    )


def _is_reckoned(flown: FlownRows, factor: Factor) -> bool:
    """Return whether the velocity is made of airspeed and heading.

    A receiver does not know the noise of the air data.
    """
    airspeed = air.true_airspeed(flown.impact, flown.static, flown.temperature)
    through = np.hypot(flown.north - factor.wind[0], flown.east - factor.wind[1])
    wiggles = np.diff([airspeed, through], 2, axis=1)
    size, difference = (
        float(np.median(np.abs(each))) for each in (wiggles[0], wiggles[1] - wiggles[0])
    )
    return difference < LIMITS.wiggle_difference * size


def _is_track(flown: FlownRows, factor: Factor, psi: Array, track: Array) -> bool:
    """Whether the heading is the track itself, though the wind sets the airplane off."""
    difference = np.angle(np.exp(1j * (psi - track)))
    if float(np.sqrt(np.mean(difference**2))) > LIMITS.track_equal * DEGREE:
        return False
    wind = float(np.median(np.hypot(*factor.wind))) / float(
        np.median(np.hypot(flown.north, flown.east))
    )
    return wind >= 4.0 * LIMITS.track_equal * DEGREE


# s, over which an acceleration is taken: longer than a fix of 1 Hz, shorter than a turn
_SPAN = 4.0


def check_attitude(draft: Draft, flown: FlownRows, factor: Factor) -> None:
    """Leave out a roll or pitch in a wrong unit, and warn of one with a wrong sign."""
    forward, right = _accelerations(flown, factor.wind)
    if "roll" in draft.channels:
        _compare(
            draft,
            "roll",
            np.arctan(right / STANDARD_GRAVITY),
            draft.channels["roll"][flown.rows],
            False,
        )
    if "pitch" in draft.channels and "specific_force_x" in draft.channels:
        force = draft.channels["specific_force_x"][flown.rows] - forward
        # In a turn of bank φ the force along the airplane is that of the angle of attack times the
        # load factor, 1/cos φ, and the pitch is cos φ of the angle of attack.
        in_level_flight = force / (1.0 + (right / STANDARD_GRAVITY) ** 2)
        expected = np.arcsin(np.clip(in_level_flight / STANDARD_GRAVITY, -0.9, 0.9))
        _compare(draft, "pitch", expected, draft.channels["pitch"][flown.rows], True)


def _accelerations(flown: FlownRows, wind: Array) -> tuple[Array, Array]:
    """Along and to the right of the path through the air [m/s²], (n,), over `_SPAN`."""
    north, east = (_rate(flown.time, v) for v in (flown.north, flown.east))
    through = flown.north - wind[0], flown.east - wind[1]
    speed = np.maximum(np.hypot(*through), 1.0)
    forward = (north * through[0] + east * through[1]) / speed
    right = (east * through[0] - north * through[1]) / speed
    return forward, right


def _rate(time: Array, values: Array) -> Array:
    before, after = (
        np.maximum(time - _SPAN / 2.0, time[0]),
        np.minimum(time + _SPAN / 2.0, time[-1]),
    )
    change = np.interp(after, time, values) - np.interp(before, time, values)
    return np.asarray(change / np.maximum(after - before, 1e-3))


def _compare(draft: Draft, name: str, expected: Array, measured: Array, about_mean: bool) -> None:
    """Name the unit or the sign with which the measured angle would be the expected one."""
    if about_mean:
        expected, measured = expected - np.mean(expected), measured - np.mean(measured)
    power = float(np.mean(expected**2))
    needed = LIMITS.pitch_needed if about_mean else LIMITS.bank_needed
    size = float(np.sqrt(np.mean(measured**2)))
    if np.sqrt(power) < needed or size == 0.0:
        return
    slope = float(np.mean(expected * measured)) / power
    if abs(slope) * np.sqrt(power) / size < LIMITS.agrees:
        return
    column = draft.columns[name]
    if not LIMITS.slope_low < abs(slope) < LIMITS.slope_high:
        fits = [
            f"{name}_{suffix}"
            for suffix, times in other_units(draft, name)
            if LIMITS.slope_low < abs(slope) * times < LIMITS.slope_high
        ]
        way_out = (
            f"; it would fit {' or '.join(fits)}: name the column so"
            if fits
            else "; check its unit"
        )
        draft.leave_out(
            name, f"the motion asks for {1.0 / abs(slope):.2g} times the angle{way_out}"
        )
    elif slope < 0.0:
        draft.warnings.append(
            f"column {column!r}: the angle has the wrong sign against the motion of the airplane"
        )


def check_plausibility(draft: Draft) -> None:
    """Warn of what is hardly possible; raise BadInputError for what is not.

    Each check trusts what those before it have looked at: static pressure and temperature give the
    density with which airspeeds are formed.
    """
    check_height(draft)
    check_temperature(draft)
    flown = flown_rows(draft)
    if flown is None or draft.cautions(BROKEN):
        return  # what is broken explains what does not fit
    factor = find_factor(flown)
    # Refuse speeds that no pressure error and no wind can bring together; warn of those that hardly
    # one can.
    _check_axes(draft, flown, factor)
    _check_misfit(draft, factor)
    _check_change(draft, factor)
    _check_size(draft, flown, factor)
    check_heading(draft, flown, factor)
    check_attitude(draft, flown, factor)
