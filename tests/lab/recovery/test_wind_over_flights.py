"""Changes of the wind that are named by chance, over many flights."""

from tests.calibration.test_wind_check import CHECKED, flown, named

from pitotbench.calibration import calibrate


def test_a_constant_wind_and_gusts_that_hide_every_change_are_named_in_few_flights():
    """Without heading, in gusts of 1.5 m/s, the factor is near 1: few are more than chance."""
    for maneuver in ("step_decrease", "rapid_decel", "circle"):
        assert (
            sum(bool(named(calibrate(flown(maneuver, seed), CHECKED))) for seed in range(20, 23))
            <= 1
        )
    found = [
        calibrate(flown("step_decrease", seed, None, False, 1.5), CHECKED) for seed in range(20, 26)
    ]
    assert sum(each.diagnostics.wind_change.bayes_factor > 1.0 / 3.0 for each in found) >= 3
    assert sum(bool(named(each)) for each in found) <= 1
