"""Two flights in one log with a short stop between them, in another wind."""

from dataclasses import fields, replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import FlightLog
from pitotbench.bench.calibrations import options_of
from pitotbench.calibration import calibrate_flights
from pitotbench.calibration.flights import _parts as parts_of
from pitotbench.calibration.flights import of_one_log
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Calibration, OneSided
from pitotbench.show.calibration_json import flight_json

WIND = np.array([6.0, -5.0])  # m/s by which the second flight meets more


def joined(first: FlightLog, second: FlightLog) -> FlightLog:
    return FlightLog(
        **{
            name: np.concatenate([v, second.channels()[name]])
            for name, v in first.channels().items()
        },
        header=first.header,
    )


def later(log: FlightLog, before: FlightLog, pause: float) -> FlightLog:
    return replace(log, time=log.time - log.time[0] + before.time[-1] + pause)


def flown(seed: int, wind: np.ndarray) -> FlightLog:
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(), seed=seed)
    north, east = wind
    return replace(
        log, velocity_north=log.velocity_north + north, velocity_east=log.velocity_east + east
    )


def at_rest(log: FlightLog, seconds: float) -> FlightLog:
    """The rows of a taxi back to the runway: the recorder goes on."""
    rows = log.select(np.arange(round(seconds * 10)))
    still = dict.fromkeys(("velocity_north", "velocity_east"), np.full(len(rows), 2.0))
    return replace(rows, **still, impact_pressure=np.full(len(rows), 1.0))


@pytest.mark.parametrize("between", ["pause of 30 s", "pause of 200 s", "taxi back"])
def test_two_flights_a_short_stop_apart_have_a_wind_each(between):
    first, second = flown(1, np.zeros(2)), flown(51, WIND)
    if between == "taxi back":
        rest = later(at_rest(first, 120.0), first, 0.1)
        log = joined(joined(first, rest), later(second, rest, 0.1))
    else:
        log = joined(first, later(second, first, float(between.split()[2])))
    found = calibrate_flights([log], options_of())
    assert [(each.number, each.count) for each in found] == [(1, 2), (2, 2)]
    assert flight_json(found[1])["flight"]["number"] == 2
    assert flight_json(replace(found[0], count=1, joined=1)) == {}  # the only flight of its log
    winds = [each.calibration.known_wind for each in found]
    more = [winds[1].north.value - winds[0].north.value, winds[1].east.value - winds[0].east.value]
    np.testing.assert_allclose(more, WIND, atol=1.0)


def test_a_log_whose_fit_does_not_converge_is_cut_at_its_stops_as_well():
    first = flown(1, WIND)
    whole = joined(first, later(first, first, 30.0))

    def rows(log: FlightLog) -> int:
        if len(log) == len(whole):
            raise NoAnswerError("the fit does not converge")
        return len(log)

    assert [part.found for part in parts_of(whole, 0, rows)] == [len(first), len(first)]


# What the flights of one log share, or what their first one stands for. A new field of the answer is
# joined in `of_one_log`, or stands here.
OF_THE_FIRST = [
    "model",
    "method",
    "parameters",
    "reference_pressure",
    "curve",
    "reason",
    "condition_number",
    "diagnostics",
    "shares",
    "error_location",
    "assumptions",
    "priors",
    "impact_pressure_zero",
    "place_assumed",
    "day",
    "log_start",
    "autopilot",
    "scale",
    "provenance",
]
JOINED = [
    *("wind", "residual_two_sigma", "samples", "converged", "residuals", "warnings", "winds"),
    *("parts", "left_out", "disagreements", "points", "mach", "one_sided"),
]


def test_every_field_of_an_answer_is_joined_or_that_of_the_first_flight():
    first, second = flown(1, np.zeros(2)), flown(51, WIND)
    log = joined(first, later(second, first, 200.0))
    slow = OneSided(50.0, 55.0, 0.0, 90.0)
    one, two = calibrate_flights([log], options_of())
    one = replace(one, calibration=replace(one.calibration, converged=False, one_sided=(slow,)))
    two = replace(two, calibration=replace(two.calibration, mach=0.9))
    whole = of_one_log(log, [one, two])
    parts = [each.calibration for each in (one, two)]
    names = {each.name for each in fields(Calibration)}
    assert names == {*OF_THE_FIRST, *JOINED}
    assert all(getattr(whole, name) is getattr(parts[0], name) for name in OF_THE_FIRST)
    assert (whole.samples, whole.mach) == (sum(each.samples for each in parts), 0.9)
    assert not whole.converged
    # Of a Step Decrease in two straight lines: the slow and the fast third, as the whole log has it.
    assert len(whole.one_sided) == 2
    assert slow not in whole.one_sided
