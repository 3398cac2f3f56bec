"""Give an account of a log, and check what can be flown with an aircraft."""

import numpy as np

from pitotbench import air
from pitotbench.airdata import mean_wind
from pitotbench.bench.gusts import MEAN_LENGTH, gust_deviation
from pitotbench.calibration.expected_bound import ExpectedNoise, expected_two_sigma
from pitotbench.calibration.observations import (
    limit_words,
    observe,
    range_end,
    usable_rows,
    wind_drifts,
)
from pitotbench.calibration.options import WITHOUT_TEMPERATURE, CalibrationOptions
from pitotbench.channels import CHANNELS
from pitotbench.logbook.flight_parts import flights_in
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.case import Case
from pitotbench.records.log import Caution, ChannelSummary, FlightLog, LogInspection, Question
from pitotbench.records.motion import CONTROLS, STATES
from pitotbench.timeline import interval, pauses
from pitotbench.units import DEGREE, KNOT, Array

_SECTOR = 30.0 * DEGREE  # of track: twelve of them make the circle
_VISITED = 0.02  # share of the rows that counts as a heading flown
_MOST_ROWS = 3000  # that the expected bound is computed from: geometry needs no more
_SPEEDS = 7  # airspeeds at which the bound is given
_QUANTILES = (0.05, 0.5, 0.95)  # of a channel: its usual low, middle and high
_NEEDS = {  # question: what it needs beyond pressures and ground velocity, and what is assumed or lost without
    "altitude (position) error": (
        ("altitude",),
        "a geometric height; without it the error's place is assumed",
    ),
    "vertical wind": (("velocity_down",), "the vertical GPS velocity"),
    "calibration with attitude and flow angles": (
        ("roll", "pitch", "heading", "angle_of_attack", "sideslip"),
        "attitude and flow angles",
    ),
    "reconciliation with a model": (
        (*STATES, *CONTROLS[:4]),  # an airplane with one engine has no second throttle
        "attitude, body rates, specific force along x, surfaces and throttle",
    ),
}


def inspect_log(log: FlightLog, options: CalibrationOptions | None = None) -> LogInspection:
    """Return the account of a log. `options` are those that a mapping advises to calibrate."""
    chosen = options or CalibrationOptions()
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure))
    flying = speed > 0.5 * float(np.quantile(speed, 0.95))
    end = range_end(log)
    measured = flying & usable_rows(log, chosen).rows  # the same as of the calibration
    shown = measured if measured.any() else flying
    wind = mean_wind(log.select(shown).channels())
    sample, plain = (
        log.select(np.arange(0, len(log), max(1, len(log) // _MOST_ROWS))),
        _of_the_bound(chosen),
    )
    expected, refusal = _expected(sample, plain, wind, speed[measured])
    flights = flights_in(log)
    stopped = [(flight, int(row)) for flight in flights for row in pauses(flight.time)]
    height = np.asarray(air.pressure_altitude(log.static_pressure))
    found = [*log.cautions, *([] if end is None else [Caution(end.words, "range end")])]
    track = np.arctan2(log.velocity_east, log.velocity_north)[shown] % (2.0 * np.pi)
    counts = np.bincount((track / _SECTOR).astype(np.intp) % 12, minlength=12)
    return LogInspection(
        rows=len(log),
        rate=1.0 / interval(log.time),
        channels=tuple(_channel_summary(log, name) for name in log.channels()),
        flights=tuple((float(flight.time[0]), float(flight.time[-1])) for flight in flights),
        pauses=tuple(
            (float(f.time[row - 1]), float(f.time[row] - f.time[row - 1])) for f, row in stopped
        ),
        headings=int(np.count_nonzero(counts > _VISITED * len(track))),
        airspeeds=_quantiles(speed[shown]),
        heights=_quantiles(height[flying]),
        questions=_questions(log, expected is not None, refusal),
        expected=expected,
        refusal=refusal,
        wind=(float(wind[0]), float(wind[1])),
        wind_drifts=expected is not None and wind_drifts(plain, observe(sample, plain)),
        model=plain.model,
        warnings=tuple(found),
    )


def _quantiles(values: Array) -> tuple[float, float, float]:
    low, middle, high = (float(value) for value in np.quantile(values, _QUANTILES))
    return low, middle, high


def _channel_summary(log: FlightLog, name: str) -> ChannelSummary:
    channel, values = CHANNELS[name], log.channels()[name]
    if channel.kind != "number":
        return ChannelSummary(name, "", None, None, None)
    known = values[np.isfinite(values)]
    changes = float(np.count_nonzero(np.diff(values)) / max(log.time[-1] - log.time[0], 1e-9))
    low, _, high = _quantiles(known) if len(known) else (float("nan"),) * 3
    return ChannelSummary(name, channel.unit, low, high, changes)


def _of_the_bound(options: CalibrationOptions) -> CalibrationOptions:
    """The options of a calibration by which the bound is expected: the same rows and unknowns."""
    return CalibrationOptions(
        model=options.model,
        accuracies=options.accuracies,
        wind="checked",
        use_down=False,
        mach_max=options.mach_max,
        ground_speed_min=options.ground_speed_min,
        on_condition=options.on_condition,
    )


def _expected(
    sample: FlightLog, plain: CalibrationOptions, wind: Array, speed: Array
) -> tuple[tuple[Array, Array] | None, str]:
    """Return airspeeds and 2σ to expect in light turbulence, or the reason why there is none."""
    if not len(speed):
        return (
            None,
            "no row in flight is used: all lie beyond the range of the impact-pressure sensor or "
            "the limits",
        )
    low, _, high = _quantiles(speed)
    speeds = (
        np.linspace(low, high, _SPEEDS) if high - low > KNOT else np.array([0.5 * (low + high)])
    )
    noise = ExpectedNoise(
        gust_deviation=gust_deviation(Case(turbulence="light")), gust_length=MEAN_LENGTH
    )
    try:
        bound = expected_two_sigma(sample, plain, wind, noise, speeds)
    except (BadInputError, NoAnswerError) as error:
        return None, f"{error}{limit_words(sample, plain)}"
    if not np.all(np.isfinite(bound)):
        return None, "the flight does not determine the curve"
    return (speeds, bound), ""


def _questions(log: FlightLog, determined: bool, refusal: str) -> tuple[Question, ...]:
    found = [Question("error curve and wind", determined, "" if determined else refusal)]
    if log.total_temperature is None and log.air_temperature is None:
        found.append(
            Question(
                "temperature",
                False,
                f"no temperature: a standard day ±{WITHOUT_TEMPERATURE:.0f} K is assumed",
            )
        )
    for name, (needed, words) in _NEEDS.items():
        missing = [channel for channel in needed if getattr(log, channel) is None]
        found.append(
            Question(
                name,
                not missing,
                f"needs {words}; missing: {', '.join(missing)}" if missing else "",
            )
        )
    return tuple(found)
