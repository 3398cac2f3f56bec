"""A broken pitot and a factor in the files of autopilots, and none of them in measured logs."""

from dataclasses import replace

import numpy as np
import pytest
from tests.shared_data import real_log

from pitotbench import air, read_log
from pitotbench.broken import find_broken
from pitotlab.broken.breaks import KINDS, LIGHT, broken_columns
from pitotlab.broken.dataflash import write_dataflash
from pitotlab.broken.measure import answer_of, outcome_of, scaled
from pitotlab.broken.ulog import write_ulog
from pitotlab.outside.generator import generate, write_csv

SEED = 301  # of development


@pytest.mark.parametrize("name", ["iced", "exchanged", "copied"])
def test_a_broken_pitot_is_named_in_the_log_of_an_autopilot(name, tmp_path):
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    kind = KINDS[name]
    path = tmp_path / "log.bin"
    write_dataflash(broken_columns(kind, SEED + 1, 0), path)
    found, says = answer_of(path)
    assert outcome_of(kind, found, says) == "named", says


@pytest.mark.parametrize(
    "name", ["garmin/c172s-g1000-2011.csv.gz", "perlan/flight50-rear.igc.gz", "jmoss/CLASS55.csv"]
)
def test_a_measured_log_of_a_sound_system_is_called_broken_by_nothing(name):
    mapping = "jmoss" if "jmoss" in name else None
    assert find_broken(read_log(real_log(*name.split("/")), mapping).channels()) is None


@pytest.mark.parametrize("factor", [0.7, 1.25, 1.5])
def test_a_factor_is_an_answer_and_the_same_in_each_container(factor, tmp_path):
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    flight = generate(replace(LIGHT, temperature="air"), "circle", SEED)
    right = air.calibrated_airspeed(flight.state.impact)
    true = factor * float(np.mean(right / air.calibrated_airspeed(flight.state.indicated_impact)))
    found = []
    for suffix, write in ((".csv", write_csv), (".bin", write_dataflash), (".ulg", write_ulog)):
        write(scaled(flight, factor), tmp_path / f"log{suffix}")
        answer, says = answer_of(tmp_path / f"log{suffix}")
        assert answer.usable
        assert f"multiply the airspeed by {answer.scale.factor:.3f}" in says
        found.append(answer.scale)
    assert abs(found[0].factor - true) < 1.5 * found[0].two_sigma
    for other in found[1:]:
        assert abs(found[0].factor - other.factor) < 0.5 * found[0].two_sigma
    assert found[0].units == ()
