"""Where the injected error sits, and the slow part of the receiver's height error."""

from dataclasses import replace

import numpy as np
import pytest
from tests.sensing import synthetic_flight as fixture

from pitotbench.records import BadInputError
from pitotbench.records.case import Case, PressureErrorSpec
from pitotbench.records.case_file import read_case, write_case
from pitotbench.sensing.recorder import record, slow_error


def _recorded(location: str):
    flight = fixture.flight(case=Case(pressure_error=PressureErrorSpec(location=location)))
    return flight, record(flight, fixture.PERFECT, 1)


def test_an_error_of_the_static_source_moves_both_pressures_and_leaves_the_total_right():
    flight, log = _recorded("static")
    error = log.static_pressure - flight["static_pressure"]
    assert np.max(np.abs(error)) > 5.0
    np.testing.assert_allclose(log.static_pressure + log.impact_pressure, flight["total_pressure"], rtol=1e-12)


@pytest.mark.parametrize("location", ["total", "impact"])
def test_any_other_error_leaves_the_static_pressure_right(location):
    flight, log = _recorded(location)
    np.testing.assert_allclose(log.static_pressure, flight["static_pressure"], rtol=1e-12)
    np.testing.assert_array_equal(log.impact_pressure, _recorded("static")[1].impact_pressure)


def test_a_case_names_a_place_that_there_is():
    case = Case(pressure_error=PressureErrorSpec(location="static"))
    assert read_case(write_case(case)) == case
    with pytest.raises(BadInputError, match=r"pressure_error\.location"):
        read_case('[pressure_error]\nlocation = "pitot"\n')


def test_the_slow_height_error_has_its_level_and_its_memory():
    time = np.arange(0.0, 40000.0, 2.0)
    error = slow_error(time, 2.0, 90.0, np.random.default_rng(4))
    assert np.std(error) == pytest.approx(2.0, rel=0.1)
    assert np.mean(error[45:] * error[:-45]) / np.var(error) == pytest.approx(np.exp(-1.0), abs=0.1)


def test_the_slow_height_error_goes_on_while_nobody_records():
    time = np.arange(0.0, 40000.0, 2.0)
    gaps = time + 10000.0 * (np.arange(len(time)) // 50)
    error = slow_error(gaps, 2.0, 90.0, np.random.default_rng(4))
    before, after = error[49:-1:50], error[50::50]
    assert abs(np.corrcoef(before, after)[0, 1]) < 0.2
    short = time + 20.0 * (np.arange(len(time)) // 50)
    error = slow_error(short, 2.0, 90.0, np.random.default_rng(4))
    assert np.corrcoef(error[49:-1:50], error[50::50])[0, 1] > 0.6


def test_a_receiver_without_a_slow_error_records_what_it_did_before():
    flight, das = fixture.flight(), replace(fixture.PERFECT, altitude_noise=1.5)
    log, drifting = record(flight, das, 3), record(flight, replace(das, altitude_drift=2.0), 3)
    assert log.altitude is not None
    assert drifting.altitude is not None
    apart = drifting.altitude - log.altitude
    assert np.max(np.abs(apart)) > 0.2
    assert np.max(np.abs(np.diff(apart))) < 0.3  # the white noise is the same draw
    np.testing.assert_array_equal(drifting.static_pressure, log.static_pressure)
