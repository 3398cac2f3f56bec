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


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """Turns of which the fastest stands at the end of the sensor's range; the static pressure never changes."""
    at = np.array([0.0, 90.0, 150.0, 240.0, 300.0, 390.0])
    time = np.arange(390 * RATE) / RATE
    speed = np.interp(time, at, [100.0, 100.0, 130.0, 130.0, 160.0, 160.0]) * KNOT
    heading = np.interp(time, at, [0.0, 400.0, 400.0, 800.0, 800.0, 1200.0]) * DEGREE
    flown = fixture.fly((speed, heading), RATE, RATE, fixture.Air())
    ended = replace(flown, impact_pressure=np.minimum(flown.impact_pressure, 3500.0))
    return write_log(ended, tmp_path_factory.mktemp("log") / "flight.csv")


SENTENCES = {"calibrate": "Add ", "inspect": "Indicated airspeeds", "fixed-speed": "flight.csv"}


@pytest.mark.parametrize("command", list(SENTENCES))
def test_warnings_stand_between_the_answer_and_its_table(log, capsys, command):
    assert main([command, str(log)]) == 0
    lines = capsys.readouterr().out.splitlines()
    answer = next(i for i, line in enumerate(lines) if SENTENCES[command] in line)
    table = next(i for i, line in enumerate(lines) if TABLE in line)
    assert main([command, str(log), "--json"]) == 0
    document = capsys.readouterr().out
    for words in ("never changes", "end of the sensor's range"):
        places = [i for i, line in enumerate(lines) if line.startswith("warning: ") and words in line]
        assert len(places) == 1, lines
        assert answer < places[0] < table
        assert words in " ".join(json.loads(document)["warnings"])
