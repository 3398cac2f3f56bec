"""The numbers of the priors: each can be stated, is checked, and moves the answer."""

import json
from dataclasses import asdict, fields, replace

import numpy as np
import pytest
from tests.calibration import static_flights as fixture
from tests.calibration import trajectories
from tests.calibration.test_fixed_speed_points import RATE, circle_path

from pitotbench import BadInputError, CalibrationOptions, write_log
from pitotbench.airdata import Rest
from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import fixed_speed_points
from pitotbench.calibration.options import PRIORS, Priors, parse_priors
from pitotbench.cli.app import main
from pitotbench.records.log import AT_REST
from pitotbench.show.calibration_tree import calibration_tree
from pitotbench.show.tree import SOURCES, Sentence, nodes_in
from pitotbench.units import KNOT

SMOOTH = CalibrationOptions(model="smooth", error_location="static")
USED_WITH = {  # what a log or an answer must have for a prior to matter
    "high_length_factor": "high",
    "height_white_m": "no vertical velocity",
    "slow_wind_mps": "drifting",
    "slow_wind_s": "drifting",
    "wind_change_mps": "linear",
    "curve_level": "one heading",
    "height_form": "air-data computer",
    "zero_drift_pa": "at rest",
}


@pytest.fixture(scope="module")
def logs():
    """A low log with height, one above 10,000 ft, one without a vertical velocity, and two
    on one heading, of pressures and of an air-data computer.
    """
    flown = replace(fixture.fly("circle", 3), header={"accuracy": fixture.EXACT})
    high = replace(flown, static_pressure=np.full(len(flown), 60_000.0))
    high = fixture.without_height(high)
    straight = fixture.one_heading(fixture.fly("step_decrease", 3))
    straight = replace(straight, header=flown.header)
    return {
        "": flown,
        "high": high,
        "no vertical velocity": replace(flown, velocity_down=None),
        "one heading": straight,
        "air-data computer": replace(
            straight, header={**flown.header, "units_by": {"air_data": "speed"}}
        ),
        "at rest": replace(
            flown, header={**flown.header, AT_REST: [asdict(Rest(0.0, 2.0, 0.2, 0.1))]}
        ),
    }


def options_for(name, **stated):
    wind = USED_WITH.get(name) if USED_WITH.get(name) in ("drifting", "linear") else "constant"
    latency = "checked" if name.endswith("latency_s") else "given"
    return replace(SMOOTH, wind=wind, latency=latency, priors=stated)


@pytest.fixture(scope="module")
def usual_curve(logs):
    """The log of a prior and its curve with all priors as usual: one fit of each log and wind."""
    fitted = {}

    def curve_of(name):
        log = logs.get(USED_WITH.get(name, ""), logs[""])
        options = options_for(name)
        key = (id(log), options.wind, options.latency)
        if key not in fitted:
            fitted[key] = calibrate(log, options).curve
        return log, fitted[key]

    return curve_of


@pytest.mark.parametrize("field", fields(Priors), ids=lambda each: each.name)
def test_a_prior_over_its_usual_range_moves_the_answer_by_less_than_its_bound(field, usual_curve):
    log, usual = usual_curve(field.name)
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
    curves, told_priors = [], []
    for flag in ([], ["--set", "gust_length_m=300, curve_slope=0.03"]):
        assert main(["calibrate", str(path), *flag, "--json"]) == 0
        document = json.loads(capsys.readouterr().out)
        curves.append(document["curve"])
        told_priors.append(document["priors"])
    stated = {"gust_length_m": 300.0, "curve_slope": 0.03}
    assert told_priors == [{}, stated]
    options = CalibrationOptions(model="smooth", wind="checked", latency="checked", priors=stated)
    answer = calibrate(logs[""], options)
    said = nodes_in([calibration_tree("log", {answer.model: answer})], SOURCES)
    told = "Priors that were stated: gust_length_m 300, curve_slope 0.03."
    assert told in [node.text for node in said if isinstance(node, Sentence)]
    bound = answer.curve.two_sigma / KNOT
    told = [point["two_sigma_kt"] for point in curves[1]]
    np.testing.assert_allclose(told, bound, rtol=1e-3)
    assert told != [point["two_sigma_kt"] for point in curves[0]]
    assert main(["calibrate", str(path), "--set", "gust_lenght_m=300"]) == 2
    assert "gust_length_m" in capsys.readouterr().err


def test_a_card_of_legs_takes_the_priors_of_its_curve(tmp_path, capsys):
    """With next to no slope and no departure before the flight, the curve of a card is flat."""
    path = tmp_path / "card.csv"
    rows = [
        f"{point},{speed},3000,10,{speed * 1.06 + step * off:.1f},{track}"
        for point, (speed, off) in enumerate(((80, -4.0), (100, 0.0), (120, 4.0)), start=1)
        for track, step in ((0, 1.0), (120, 1.0), (240, 1.0))
    ]
    header = "point,indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,ground_speed_kt"
    path.write_text("\n".join([f"{header},track_deg", *rows]), encoding="utf-8")
    spans, told = [], []
    flat = ["--set", "curve_slope=1e-5,curve_lift=1e-5,curve_departure=1e-5"]
    for flags in ([], flat):
        assert main(["fixed-speed", str(path), *flags, "--json"]) == 0
        document = json.loads(capsys.readouterr().out)
        told.append(document["priors"])
        (found,) = document["curves"].values()
        shares = [point["normalized_pressure_error"] for point in found["curve"]]
        spans.append(max(shares) - min(shares))
    assert spans[1] < 0.2 * spans[0]
    assert told == [{}, {"curve_slope": 1e-5, "curve_lift": 1e-5, "curve_departure": 1e-5}]
    assert main(["fixed-speed", str(path), *flat]) == 0
    assert "Priors that were stated: curve_slope 1e-05, curve_lift" in capsys.readouterr().out
    assert main(["fixed-speed", str(path), "--set", "gust_mps=1"]) == 2
    assert "curve_slope" in capsys.readouterr().err


def test_the_legs_of_a_log_take_the_priors_of_gusts():
    """Gusts that are known to be tiny leave white noise, whose mean over a leg is small."""
    log = trajectories.fly(circle_path(), RATE, RATE, trajectories.Air())
    bounds = []
    for priors in ({}, {"gust_mps": 1e-3}):
        points = fixed_speed_points(log, replace(SMOOTH, priors=priors))
        bounds.append(np.array([point.true_airspeed_two_sigma for point in points]))
    assert np.all(bounds[1] < 0.9 * bounds[0])


def test_legs_typed_have_no_prior(capsys):
    legs = ["--ground-speed-kt=178,185,188", "--track-deg=10,130,250"]
    assert main(["fixed-speed", *legs, "--set", "gust_mps=1"]) == 2
    assert "points tables have a prior" in capsys.readouterr().err
