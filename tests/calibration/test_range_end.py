"""A reading at the end of the sensor's range is no measurement: it is left out and named, and harms
no curve.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture
from tests.calibration.test_fixed_speed_points import RATE as LEG_RATE
from tests.calibration.test_fixed_speed_points import legs_path

from pitotbench import BadInputError, NoAnswerError, read_log, write_log
from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import fixed_speed_points
from pitotbench.units import KNOT

RATE = 20
GUSTS = fixture.Air(gust=0.5)


def _clipped(path, ceiling_kt, seed=1):
    """A flight in gusts with a sensor that ends at an airspeed."""
    return _cut(fixture.fly(path(RATE), RATE, RATE, GUSTS, seed), ceiling_kt)


def _cut(log, ceiling_kt):
    """The log of a sensor that ends at an airspeed, by the compressible formula at sea level
    written out here.
    """
    mach = ceiling_kt * 0.514444 / 340.294
    ceiling = 101325.0 * ((1.0 + 0.2 * mach**2) ** 3.5 - 1.0)
    return replace(log, impact_pressure=np.minimum(log.impact_pressure, ceiling))


def _errors(curve):
    """Error of a curve's correction over its σ, where the fixture's truth says the correction."""
    ratio = curve.indicated_airspeed / 340.294
    indicated = 101325.0 * ((1.0 + 0.2 * ratio**2) ** 3.5 - 1.0)
    x = indicated / 1630.28
    k1, k2, k3 = fixture.TRUTH.parameters
    pressure = indicated / (1.0 - (k1 + k2 * x + k3 / x))
    calibrated = 340.294 * np.sqrt(5.0 * ((pressure / 101325.0 + 1.0) ** (2.0 / 7.0) - 1.0))
    return (curve.correction - (calibrated - curve.indicated_airspeed)) / (0.5 * curve.two_sigma)


# At 160 KCAS the sensor indicates 164.0 kt. Ceilings cut the fastest of four turns whole, or half
# of its gusts.
@pytest.mark.parametrize("ceiling_kt", [158.0, 162.0, 164.0])
def test_a_leg_at_the_end_of_the_range_is_as_if_it_had_not_been_flown(ceiling_kt):
    for seed in range(1, 5):
        clipped = _clipped(fixture.circles, ceiling_kt, seed)
        without = calibrate(clipped.select(clipped.time < 300.0)).curve  # the first three turns
        found = calibrate(clipped).curve
        np.testing.assert_allclose(found.indicated_airspeed, without.indicated_airspeed)
        assert np.max(np.abs(found.correction - without.correction) / without.two_sigma) < 0.3


@pytest.mark.parametrize("ceiling_kt", [150.0, 158.0])
def test_a_sweep_through_the_end_of_the_range_keeps_its_bound_and_names_the_range_once(ceiling_kt):
    for seed in range(1, 5):
        found = calibrate(_clipped(fixture.step_decrease, ceiling_kt, seed))
        assert np.max(np.abs(_errors(found.curve))) < 3.0
        assert found.curve.indicated_airspeed[-1] < (ceiling_kt + 0.5) * KNOT
        assert len(_about_the_range(found, f", {ceiling_kt:.0f} kt")) == 1


def _about_the_range(found, ends=""):
    return [text for text in found.warnings if f"end of the sensor's range{ends}" in text]


def test_no_healthy_log_has_an_end_of_range():
    for seed in range(1, 4):
        for path in (fixture.circles, fixture.step_decrease):
            assert (
                _about_the_range(calibrate(fixture.fly(path(RATE), RATE, RATE, GUSTS, seed))) == []
            )


def _in_steps(impact):
    """The greatest value of a display stands for minutes at a steady speed, and the sensor does not
    end there.
    """
    return np.round(impact / 50.0) * 50.0


def _held(impact):
    """Air data at 2 Hz in rows at 20 Hz: each value stands on ten rows, the greatest as well."""
    return np.repeat(impact[::10], 10)[: len(impact)]


@pytest.mark.parametrize(
    ("path", "gusts", "shown", "at_the_top"),
    [
        (fixture.circles, fixture.Air(gust=0.05), _in_steps, 101),
        (fixture.step_decrease, GUSTS, _held, 10),
    ],
)
def test_a_reading_that_stands_at_the_top_is_no_end_of_range(path, gusts, shown, at_the_top):
    log = fixture.fly(path(RATE), RATE, RATE, gusts)
    impact = shown(log.impact_pressure)
    assert np.count_nonzero(impact == impact.max()) >= at_the_top
    assert _about_the_range(calibrate(replace(log, impact_pressure=impact))) == []


def test_legs_at_the_end_of_the_range_give_no_point():
    log = fixture.fly(legs_path(0, 90, 180, 270), LEG_RATE, LEG_RATE, GUSTS)
    ends = [point.indicated_airspeed / KNOT for point in fixed_speed_points(log)]
    assert ends == pytest.approx([110.6, 142.8], abs=1.0)
    points = fixed_speed_points(_cut(log, 142.0))
    assert [point.indicated_airspeed for point in points] == pytest.approx(
        [ends[0] * KNOT], abs=0.01
    )


def test_a_file_keeps_the_rows_at_the_end_of_the_range_and_names_the_range(tmp_path):
    """A sensor stands still there for minutes, and is not stuck."""
    found = calibrate(_read_back(_clipped(fixture.circles, 158.0), tmp_path))
    assert [text for text in found.warnings if "stuck" in text and "impact" in text] == []
    assert _about_the_range(found, ", 158 kt")


def _read_back(log, folder):
    write_log(log, folder / "flight.csv")
    return read_log(folder / "flight.csv")


# 57 % of the rows stand at the end of the range: the fastest four of seven turns, flown last or
# first.
@pytest.mark.parametrize(
    "speeds_kt", [(85, 97, 109, 140, 146, 152, 160), (160, 152, 146, 140, 109, 97, 85)]
)
def test_a_file_mostly_at_the_end_of_the_range_gives_the_answer_of_the_rest(tmp_path, speeds_kt):
    clipped = _clipped(lambda rate: fixture.circles(rate, speeds_kt), 124.0)
    turn = np.repeat(np.arange(7), len(clipped) // 7)
    clipped = replace(
        clipped, time=clipped.time + 60.0 * turn
    )  # the way from speed to speed was not recorded
    top = clipped.impact_pressure == clipped.impact_pressure.max()
    assert 0.56 < top.mean() < 0.58
    log = _read_back(clipped, tmp_path)
    assert len(log) == len(clipped)
    # Neither stuck, nor with a gain or a zero that the ground speed would ask for.
    assert [
        text for text in log.header["warnings"] if "impact" in text or "the air data say" in text
    ] == []
    found, without = calibrate(log), calibrate(clipped.select(~top)).curve
    assert _about_the_range(found, ", 124 kt")
    np.testing.assert_allclose(found.curve.indicated_airspeed, without.indicated_airspeed)
    assert np.max(np.abs(found.curve.correction - without.correction) / without.two_sigma) < 0.3


@pytest.mark.parametrize("ceiling_kt", [104.0, 110.0, 128.0])
def test_a_log_with_too_little_below_the_range_is_refused_with_the_range(tmp_path, ceiling_kt):
    with pytest.raises(NoAnswerError, match="end of the sensor's range, 101 kt"):
        calibrate(_clipped(fixture.circles, 101.0))
    log = _read_back(_clipped(fixture.step_decrease, ceiling_kt), tmp_path)
    with pytest.raises(
        (BadInputError, NoAnswerError), match=r"end of the sensor's range.*with more range"
    ):
        calibrate(log)


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_a_sensor_that_hung_at_its_greatest_value_is_stuck_and_no_range_ends(tmp_path, share):
    """It jumps when it comes free: the airplane has slowed down meanwhile."""
    log = fixture.fly(fixture.step_decrease(RATE), RATE, RATE, GUSTS)
    hung = np.arange(len(log)) < share * len(log)
    log = replace(
        log, impact_pressure=np.where(hung, log.impact_pressure.max(), log.impact_pressure)
    )
    if share > 0.5:
        with pytest.raises(BadInputError, match="seems stuck"):
            _read_back(log, tmp_path)
    else:
        read = _read_back(log, tmp_path)
        assert len(read) == np.count_nonzero(~hung)
        assert [text for text in read.header["warnings"] if "seems stuck" in text]
