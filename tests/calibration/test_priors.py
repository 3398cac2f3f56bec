"""The numbers of the priors: each can be stated, is checked, and moves the answer."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest
from tests.calibration import static_flights as fixture

from pitotbench import BadInputError, CalibrationOptions, write_log
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import PRIORS, Priors, parse_priors
from pitotbench.cli.app import main
from pitotbench.units import KNOT

SMOOTH = CalibrationOptions(model="smooth", error_location="static")
USED_WITH = {  # what a log or an answer must have for a prior to matter
    "high_length_factor": "high",
    "height_white_m": "no vertical velocity",
    "slow_wind_mps": "drifting",
    "slow_wind_s": "drifting",
    "wind_change_mps": "linear",
}


@pytest.fixture(scope="module")
def logs():
    """A low log with height, one above 10,000 ft, and one without a vertical velocity."""
    flown = fixture.fly("circle", 3)
    high = replace(flown, static_pressure=np.full(len(flown), 60_000.0))
    high = fixture.without_height(high)
    return {"high": high, "no vertical velocity": replace(flown, velocity_down=None), "": flown}


def options_for(name, **stated):
    wind = USED_WITH.get(name) if USED_WITH.get(name) in ("drifting", "linear") else "constant"
    return replace(SMOOTH, wind=wind, priors=stated)


@pytest.mark.parametrize("field", fields(Priors), ids=lambda each: each.name)
def test_a_prior_over_its_usual_range_moves_the_answer_by_less_than_its_bound(field, logs):
    log = logs.get(USED_WITH.get(field.name, ""), logs[""])
    usual = calibrate(log, options_for(field.name)).curve
    ends = [
        calibrate(log, options_for(field.name, **{field.name: end})).curve
        for end in field.metadata["usual"]
    ]
    moved = [np.max(np.abs(end.correction - usual.correction) / usual.two_sigma) for end in ends]
    widened = [np.max(np.abs(end.two_sigma / usual.two_sigma - 1.0)) for end in ends]
    assert max(*moved, *widened) > 1e-6
    assert max(moved) < 1.0


@pytest.mark.parametrize("field", fields(Priors), ids=lambda each: each.name)
def test_a_prior_has_a_unit_a_source_and_lies_in_its_usual_range(field):
    low, high = field.metadata["usual"]
    assert low < getattr(PRIORS, field.name) < high
    assert field.metadata["unit"]
    assert field.metadata["source"]


@pytest.mark.parametrize(
    ("stated", "words"),
    [
        ({"gust_lenght_m": 300.0}, "Did you mean 'gust_length_m'"),
        ({"gust_mps": 0.0}, "more than 0"),
        ({"gust_length_factor": 1.0}, "more than 1"),
        ({"gust_mps": float("nan")}, "more than 0"),
        ({"gust_mps": True}, "not a number"),
        ("gust_mps", "state a table"),
    ],
)
def test_a_prior_that_does_not_exist_or_cannot_be_is_refused(stated, words):
    with pytest.raises(BadInputError, match=words):
        CalibrationOptions(priors=stated)


@pytest.mark.parametrize("text", ["gust_mps", "gust_mps=often", ""])
def test_text_that_states_no_number_is_refused(text):
    with pytest.raises(BadInputError, match="gust_length_m=300"):
        parse_priors(text)


def test_command_and_python_state_the_same_prior(logs, tmp_path, capsys):
    path = tmp_path / "log.parquet"
    write_log(logs[""], path)
    curves = []
    for flag in ([], ["--set", "gust_length_m=300, curve_slope=0.03"]):
        assert main(["calibrate", str(path), *flag, "--json"]) == 0
        curves.append(json.loads(capsys.readouterr().out)["curve"])
    stated = {"gust_length_m": 300.0, "curve_slope": 0.03}
    options = CalibrationOptions(model="smooth", wind="checked", latency="checked", priors=stated)
    bound = calibrate(logs[""], options).curve.two_sigma / KNOT
    told = [point["two_sigma_kt"] for point in curves[1]]
    np.testing.assert_allclose(told, bound, rtol=1e-3)
    assert told != [point["two_sigma_kt"] for point in curves[0]]
    assert main(["calibrate", str(path), "--set", "gust_lenght_m=300"]) == 2
    assert "gust_length_m" in capsys.readouterr().err
