"""`pitotbench inspect`: what a log holds, what it lacks, and a bound to expect that the calibration
then gives.
"""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import CalibrationOptions, Case, NoAnswerError, write_log
from pitotbench.bench.gusts import gust_deviation
from pitotbench.bench.inspection import inspect_log
from pitotbench.calibration import calibrate
from pitotbench.cli.app import main
from pitotbench.units import KNOT


def circles():
    """A flight in gusts of the level of light turbulence, with fine sensors."""
    light = gust_deviation(Case(turbulence="light"))
    return fixture.fly(
        fixture.circles(2), 2, 2, fixture.Air(gust=light, gps=0.02, pressure=2.0), seed=7
    )


def test_the_account_is_that_of_the_flight():
    log = circles()
    found = inspect_log(log)
    assert found.rate == pytest.approx(2.0)
    assert found.headings == 12
    assert [speed / KNOT for speed in found.airspeeds] == pytest.approx([102, 132, 162], abs=8)
    assert np.hypot(found.wind[0] - fixture.WIND[0], found.wind[1] - fixture.WIND[1]) < 1.0
    answered = {question.name: question.answered for question in found.questions}
    assert answered["error curve and wind"]
    assert answered["calibration with attitude and flow angles"]
    assert not answered["altitude (position) error"]
    assert not answered["reconciliation with a model"]
    # Pauses and flights are counted.
    time = log.time + np.where(log.time > 150.0, 1800.0, 0.0) + np.where(log.time > 60.0, 30.0, 0.0)
    found = inspect_log(replace(log, time=time))
    assert len(found.flights) == 2
    assert [round(length) for _, length in found.pauses] == [30]
    # A flight on one heading says why there is no curve.
    found = inspect_log(fixture.fly(fixture.straight(2), 2, 2, fixture.Air(), seed=3))
    assert found.expected is None
    assert "heading" in found.refusal
    assert not found.questions[0].answered


@pytest.mark.parametrize(
    "options", [{}, {"model": "bias", "accuracies": {"impact_pressure_zero_pa": 400.0}}]
)
def test_the_bound_to_expect_is_about_that_of_the_calibration(options):
    """For known noise it is the smaller one; the calibration has to estimate the noise. A zero that
    is to be estimated and the curve are nearly one unknown: the bound of their sum is small, as the
    card's is."""
    log, stated = circles(), CalibrationOptions(**options)
    speeds, expected = inspect_log(log, stated).expected
    curve = calibrate(log, stated).curve
    given = np.interp(speeds, curve.indicated_airspeed, curve.two_sigma)
    assert 0.4 < float(np.mean(expected)) / float(np.mean(given)) < 1.5


def test_the_command_prints_and_draws(tmp_path, capsys):
    log, page = tmp_path / "flight.csv", tmp_path / "flight.html"
    write_log(circles(), log)
    assert main(["inspect", str(log), "--report", str(page), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["track_sectors"] == 12
    assert len(answer["expected"]) == 7
    text = page.read_text(encoding="utf-8")
    assert text.count("<svg") == 4
    units = set(re.findall(r"<td>[−-]?[\d,.]+ ([^<]+)</td>", text))
    assert {"s", "inHg", "°C", "kt"} <= units
    assert not units & {"pa", "k", "mps", "radps", "mps2", "kgps", "Pa", "K", "m/s", "rad"}
    assert main(["inspect", str(log)]) == 0
    assert "In light turbulence, expect" in capsys.readouterr().out
    assert main(["inspect", str(log), "--report", str(log)]) == 2
    assert log.read_text(encoding="utf-8").startswith("#")


def test_a_limit_that_leaves_one_heading_is_named_by_calibrate_and_inspect():
    """All turns were flown above the limit: neither may promise a curve, and the advice is another
    limit.
    """
    parts = zip(fixture.circles(2, (150, 160)), fixture.straight(2, 100.0, 115.0), strict=True)
    path = tuple(np.append(turns, slow) for turns, slow in parts)
    log = fixture.fly(path, 2, 2, fixture.Air(gps=0.02, pressure=2.0), seed=7)
    options = CalibrationOptions(mach_max=0.2)
    says = (
        r"all headings lie within .*; the limit of Mach 0.2 \(--mach-max\) leaves out \d\d % of "
        r"the rows"
    )
    with pytest.raises(NoAnswerError, match=says):
        calibrate(log, options)
    found = inspect_log(log, options)
    assert found.expected is None
    assert re.search(says, found.refusal)
    assert found.airspeeds[2] / KNOT < 120.0
    assert inspect_log(log).expected is not None
