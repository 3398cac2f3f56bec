"""Recording faults are counted, not fitted."""

from dataclasses import replace

import pytest

from pitotbench.reconciliation.layout import check_log

FAULTS = {"sample_and_hold": "period_s", "dropped_samples": "fraction", "quantization": "step_pa"}
TYPICAL = {"sample_and_hold": 0.25, "dropped_samples": 0.05, "quantization": 40.0, "saturation": 3500.0}


@pytest.mark.parametrize("das", ["20/1", "50/50"])
def test_a_sound_log_passes(sensed, das: str) -> None:
    found = check_log(sensed(das=das))
    assert found.effects == ()
    assert {c.status for c in found.checks} == {"passed"}


def test_a_held_velocity_is_reported_where_no_column_marks_the_fixes(sensed) -> None:
    found = check_log(replace(sensed(das="20/1"), gps_fresh=None))
    assert [c.why for c in found.checks if c.name == "GPS"] == [
        "velocity is renewed every 1 s and interpolated between"
    ]


@pytest.mark.parametrize("name", [*FAULTS, "saturation"])
def test_a_fault_is_named_with_its_size(sensed, name: str) -> None:
    found = check_log(sensed(name, das="50/50"))
    assert [effect.name for effect in found.effects] == [name]
    size = found.effects[0].sizes[0]
    assert size.value == pytest.approx(TYPICAL[name], rel=0.15)
    assert any(c.status == "failed" for c in found.checks)
