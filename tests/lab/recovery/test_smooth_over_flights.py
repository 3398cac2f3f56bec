"""The smooth curve, over many flights."""

import numpy as np
from tests.calibration import trajectories as fixture
from tests.calibration.test_smooth import SMOOTH, inside

from pitotbench import CalibrationOptions, air
from pitotbench.calibration import calibrate
from pitotbench.pressure_error.models import TableCurve
from pitotbench.units import KNOT

SEEDS = range(540, 547)


def bumped(seed):
    """The usual truth with a bump of a random size and sign at a random speed."""
    rng = np.random.default_rng(seed)
    speed = np.arange(70.0, 200.0, 2.5)
    bump = rng.choice([-1.0, 1.0]) * rng.uniform(0.008, 0.015)
    shape = np.exp(-0.5 * ((speed - rng.uniform(110.0, 150.0)) / 12.0) ** 2)
    values = fixture.TRUTH.normalized(air.impact_pressure(speed * KNOT)) + bump * shape
    return TableCurve(tuple(speed * KNOT), tuple(values))


def logs_of(truths, gust=0.15):
    path, light = fixture.step_decrease(10), fixture.Air(gust=gust)
    return [
        fixture.fly(path, 10, 10, light, seed, truth)
        for seed, truth in zip(SEEDS, truths, strict=True)
    ]


def test_covers_curves_outside_the_table():
    truths = [bumped(seed) for seed in SEEDS]
    logs = logs_of(truths, gust=0.08)  # in rougher air a law's bound is wide enough for most bumps
    pairs = [*zip(logs, truths, strict=True)]
    smooth = np.mean([inside(calibrate(log, SMOOTH), t).mean() for log, t in pairs])
    law = np.mean([inside(calibrate(log), t).mean() for log, t in pairs])
    assert smooth >= 0.85
    assert law < smooth - 0.05


def test_costs_little_where_a_law_holds():
    logs = logs_of([fixture.TRUTH] * len(SEEDS))
    smooth, named = ([calibrate(log, o) for log in logs] for o in (SMOOTH, CalibrationOptions()))
    assert np.mean([inside(r, fixture.TRUTH).mean() for r in smooth]) >= 0.88
    bounds = [np.mean([r.curve.two_sigma.mean() for r in results]) for results in (smooth, named)]
    assert bounds[0] < 1.5 * bounds[1]
