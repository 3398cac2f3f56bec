"""Where warnings stand: below the sentences of the answer, above its first table, in every command."""

import json
from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.cli.app import main
from pitotbench.logbook.formats import write_log
from pitotbench.units import DEGREE, KNOT

RATE = 10
TABLE = "───"


@pytest.fixture
def log(tmp_path):
    """Turns of which the fastest stands at the end of the sensor's range; the static pressure never changes."""
    at = np.array([0.0, 90.0, 150.0, 240.0, 300.0, 390.0])
    time = np.arange(390 * RATE) / RATE
    speed = np.interp(time, at, [100.0, 100.0, 130.0, 130.0, 160.0, 160.0]) * KNOT
    heading = np.interp(time, at, [0.0, 400.0, 400.0, 800.0, 800.0, 1200.0]) * DEGREE
    flown = fixture.fly((speed, heading), RATE, RATE, fixture.Air())
    ended = replace(flown, impact_pressure=np.minimum(flown.impact_pressure, 3500.0))
    return write_log(ended, tmp_path / "flight.csv")


@pytest.mark.parametrize(
    ("command", "sentence", "warned"),
    [
        ("calibrate", "Add ", ("never changes", "end of the sensor's range")),
        ("inspect", "Indicated airspeeds", ("never changes", "end of the sensor's range")),
        ("fixed-speed", "flight.csv", ("never changes", "end of the sensor's range")),
    ],
)
def test_warnings_stand_between_the_answer_and_its_table(log, capsys, command, sentence, warned):
    assert main([command, str(log)]) == 0
    lines = capsys.readouterr().out.splitlines()
    answer = next(i for i, line in enumerate(lines) if sentence in line)
    table = next(i for i, line in enumerate(lines) if TABLE in line)
    for words in warned:
        places = [i for i, line in enumerate(lines) if line.startswith("warning: ") and words in line]
        assert len(places) == 1, lines
        assert answer < places[0] < table


def test_fixed_speed_warns_in_json(log, capsys):
    assert main(["fixed-speed", str(log), "--json"]) == 0
    warnings = json.loads(capsys.readouterr().out)["warnings"]
    assert [text for text in warnings if "never changes" in text]
    assert [text for text in warnings if "end of the sensor's range" in text]
