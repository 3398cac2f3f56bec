"""The limits of what a log may show, each with its reason, and what else two or more checks share."""

from dataclasses import dataclass

from pitotbench.logbook.draft import Draft
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.units import SUFFIXES, Array


@dataclass(frozen=True, slots=True)
class Limits:
    """Where a log is doubted (a warning) and where it is refused; SI, ratios without unit."""

    # Height. Sea-level pressure lies between 970 and 1050 hPa nearly always: 350 m of pressure altitude.
    height_doubted: float = 350.0  # m
    height_share: float = 0.03  # of the height: the air below is not as warm as the probe at height says
    sea_level_band: float = 5000.0  # Pa about 1013.25 hPa in which a pressure reduced to sea level lies
    sea_level_height: float = 600.0  # m, above which no such pressure is that of the height: 7 % less
    total_slope: float = 0.5  # dp_s/dq_c: midway between a static source (below 0.1 in size) and a total tube (1)

    # Temperature. Between a polar winter and a desert in summer the standard day is 60 K off at most.
    temperature_doubted: float = 30.0  # K
    temperature_refused: float = 60.0  # K
    rise_low: float = 0.7  # of the adiabatic rise: a total-temperature probe recovers 0.9 of it or more
    rise_high: float = 1.4
    rise_of_air: float = 0.4  # an air temperature should not rise with speed at all
    rise_known: float = 0.1  # standard error of the rise above which nothing is said

    # Speed. q_c is what the ground speed asks for, over what was measured, less one: minus the error of the system.
    curve_doubted: float = 0.1  # 5 kt at 100 kt: the largest error that FAR 23.1323 accepts
    curve_refused: float = 0.2  # no source errs by a fifth of the impact pressure
    zero_allowed: float = 150.0  # Pa: a cheap differential gauge may have this zero, and it may be taken off later
    zero_spread: float = 100.0  # Pa, 1σ of the zero before the log is looked at
    wind_spread: float = 12.0  # m/s, 1σ of a component of the wind before the log is looked at, low down
    wind_share: float = 0.1  # of the airspeed, added to it: who flies fast flies high, where winds are strong
    change_doubted: float = 0.13  # of q_c, from one part of the log to the next
    change_refused: float = 0.5
    misfit_doubted: float = 0.15  # rms of ground speed less wind against airspeed, over airspeed
    misfit_refused: float = 0.3  # gusts of 3 m/s about an airplane of 10 m/s
    axes_misfit: float = 0.1  # above which a unit of one component alone is tried
    axes_better: float = 0.4  # share of the misfit that must remain with it: gusts and the curve remain
    unit_fits: float = 0.15  # of q_c, that may remain after a unit is corrected: the error of the system itself
    sigmas: float = 3.0  # standard errors by which a limit must be passed

    # Direction.
    angle_doubted: float = 5.0  # degrees between heading and velocity less wind: above an attitude system's error
    headings_spread: float = 0.3  # 1 − |mean of e^iψ|: 0 on one heading, 1 over full turns or out and back
    mirror_better: float = 0.5  # share of the misfit that a mirrored velocity may have to be believed
    track_equal: float = 1.0  # degrees rms: a heading so near the track in a wind is the track

    # Attitude.
    slope_low: float = 0.4  # measured angle over the angle that the motion asks for
    slope_high: float = 2.5
    agrees: float = 0.8  # correlation below which nothing is said
    bank_needed: float = 0.1  # rad rms of bank
    pitch_needed: float = 0.02  # rad rms about the mean


LIMITS = Limits()

UNIT_WORDS = {
    "pa": "pascals",
    "hpa": "hectopascals",
    "psi": "pounds per square inch",
    "psf": "pounds per square foot",
    "inhg": "inches of mercury",
    "mmhg": "millimeters of mercury",
    "inh2o": "inches of water",
    "mps": "meters per second",
    "kt": "knots",
    "fps": "feet per second",
    "mph": "miles per hour",
    "kmh": "kilometers per hour",
    "fpm": "feet per minute",
}


_ROWS = 20_000  # that medians and slopes are taken over: more would only take time


def some(draft: Draft, name: str) -> Array:
    """Evenly spaced values of a channel, (k,), at most about `_ROWS`; of all channels the same rows."""
    return draft.channels[name][:: max(1, len(draft.rows) // _ROWS)]


def other_units(draft: Draft, name: str) -> list[tuple[str, float]]:
    """The other units of a quantity: the suffix, and that unit over the one written."""
    written = SUFFIXES[draft.suffixes[name]].factor
    return [(s, SUFFIXES[s].factor / written) for s in QUANTITIES[name].suffixes if s != draft.suffixes[name]]
