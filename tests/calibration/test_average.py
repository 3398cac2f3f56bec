"""`--model auto`: it covers curves that no law draws, costs little where a law holds, and says what
it weighed.
"""

import json

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, CalibrationOptions, UnknownNameError, write_log
from pitotbench.calibration import calibrate
from pitotbench.cli.app import main
from pitotbench.pressure_error import MODELS
from pitotbench.units import KNOT

AUTO = CalibrationOptions(model="auto")


def inside(result, truth):
    curve = result.curve
    error = curve.correction - fixture.true_correction(curve.indicated_airspeed, truth)
    return np.abs(error) <= curve.two_sigma


@pytest.fixture(scope="module")
def calm():
    return fixture.fly(
        fixture.step_decrease(10), 10, 10, fixture.Air(gust=0.02, gps=0.02, pressure=2.0)
    )


def test_says_what_it_weighed(calm):
    result = calibrate(calm, AUTO)
    rows = {row.model: row for row in result.diagnostics.models}
    assert list(rows) == list(MODELS)
    assert sum(row.weight for row in rows.values()) == pytest.approx(1.0, abs=1e-6)
    assert sum(result.diagnostics.departures.values()) == pytest.approx(1.0, abs=1e-6)
    chosen = next(name for name, row in rows.items() if row.chosen)
    assert result.model == f"auto ({chosen})"
    assert len(result.parameters) == rows[chosen].criteria.parameters


def test_a_drifting_wind_is_reported_by_its_mean():
    """As by a named model: the level around which it would drift for ever is known ten times worse."""
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air(gust=0.15))
    named, auto = (
        calibrate(log, CalibrationOptions(model=m, wind="drifting")) for m in ("inverse+", "auto")
    )
    for axis in ("north", "east"):
        one, other = getattr(named.wind, axis), getattr(auto.wind, axis)
        assert other.two_sigma < 2.0 * one.two_sigma
        assert abs(other.value - one.value) < one.two_sigma


def test_quiet_data_rule_out_what_is_wrong(calm):
    """The truth is Inverse+; in quiet air neither a constant nor a straight line passes for it."""
    rows = {row.model: row for row in calibrate(calm, AUTO).diagnostics.models}
    for wrong in ("bias", "linear"):
        assert rows[wrong].criteria.bic > rows["inverse+"].criteria.bic + 10.0
        assert rows[wrong].criteria.held_out < rows["inverse+"].criteria.held_out - 5.0
        assert not rows[wrong].chosen


def test_one_speed_leaves_the_constant():
    speed, heading = fixture.step_decrease(10)
    log = fixture.fly(
        (np.full_like(speed, 120.0 * KNOT), heading), 10, 10, fixture.Air(pressure=1.0, gust=0.1)
    )
    result = calibrate(log, AUTO)
    assert result.model == "auto (bias)"
    assert inside(result, fixture.TRUTH).all()
    assert result.curve.two_sigma.max() < 2.0 * KNOT


def test_auto_goes_with_no_other_method_and_is_offered_for_its_misspelling():
    with pytest.raises(BadInputError, match="'covering'"):
        CalibrationOptions(model="auto", method="paper")
    with pytest.raises(UnknownNameError, match="Did you mean 'auto'"):
        CalibrationOptions(model="atuo")


def test_spline_gets_its_knots_from_the_log(calm):
    result = calibrate(calm, CalibrationOptions(model="spline"))
    assert inside(result, fixture.TRUTH).mean() > 0.7
    low, high = result.parameters[0], result.parameters[-1]
    ends = fixture.TRUTH.normalized(np.quantile(calm.impact_pressure, [0.001, 0.999]))
    assert abs(low.value - ends[0]) <= 2.0 * low.two_sigma
    assert abs(high.value - ends[1]) <= 2.0 * high.two_sigma


def test_command_line(calm, tmp_path, capsys):
    path = tmp_path / "log.parquet"
    write_log(calm, path)
    assert main(["calibrate", str(path), "--model", "auto", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["model"].startswith("auto (")
    assert {row["model"] for row in found["model_choice"]} == set(MODELS)
    assert main(["calibrate", str(path), "--model", "auto", "-v"]) == 0
    assert "models weighed" in capsys.readouterr().out
