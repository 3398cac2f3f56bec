"""What a bound takes for granted stands beside the answer: in the terminal, on the page and in JSON."""

from dataclasses import replace
from io import StringIO

import pytest
from rich.console import Console
from tests.calibration import trajectories as fixture

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.show.calibration import calibration_json, condition_lines, print_calibration


@pytest.fixture(scope="module")
def log():
    return fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())


def _printed(result):
    text = StringIO()
    print_calibration(result, Console(file=text, width=400))
    return text.getvalue()


def test_the_usual_accuracies_are_printed_with_the_answer_on_the_page_and_in_json(log):
    result = calibrate(replace(log, header={}))
    for text in (_printed(result), " ".join(condition_lines(result))):
        for part in (
            "temperature ±1.5 K (usual)",
            "static pressure ±30 Pa (usual)",
            "GPS velocity ±0.05 m/s (usual)",
        ):
            assert part in text
    document = calibration_json(result)
    assert {"name": "temperature_k", "two_sigma": 1.5, "source": "usual"} in document["assumptions"]
    assert document["impact_pressure_zero_pa"] is None


def test_a_log_that_states_exact_sensors_is_said_to_have_no_constant_error(log):
    said = "no constant error of temperature, recovery factor, static pressure, GPS velocity (stated by the log)"
    assert said in _printed(calibrate(log))


def test_a_zero_offset_in_the_correction_is_said_with_its_bound(log):
    options = CalibrationOptions(model="bias", accuracies={"impact_pressure_zero_pa": 400.0})
    result = calibrate(replace(log, impact_pressure=log.impact_pressure + 80.0), options)
    zero = result.impact_pressure_zero
    assert (
        f"takes out a zero offset of the impact pressure of {zero.value:+.0f} ± {zero.two_sigma:.0f} Pa"
        in _printed(result)
    )
    assert calibration_json(result)["impact_pressure_zero_pa"]["value"] == zero.value
