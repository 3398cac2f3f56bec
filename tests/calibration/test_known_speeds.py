"""Points of a tunnel, a car or a pacer give factor, scale and zero."""

import json

import numpy as np
import pytest
from scipy.stats import binom
from tests.shared_data import shared_case

from pitotbench import BadInputError, air, fixed_speed
from pitotbench.calibration.known_speed import reduce_known_speeds
from pitotbench.cli.app import main
from pitotbench.records.legs import KnownSpeed

STEPS = {"known_airspeed": 0.1, "indicated_airspeed": 0.1}


def points_of(known, indicated):
    return [
        KnownSpeed(row=i, point=str(i), configuration="", known_airspeed=a, indicated_airspeed=b)
        for i, (a, b) in enumerate(zip(known, indicated, strict=True))
    ]


def flown(seed, scale, zero, noise=0.1):
    """Points of a sensor with a scale and a zero [Pa], read with noise [m/s]."""
    rng = np.random.default_rng(seed)
    known = np.linspace(8.0, 30.0, 12)
    shown = air.calibrated_airspeed((air.impact_pressure(known) - zero) / scale)
    return points_of(known, shown + noise * rng.standard_normal(len(known)))


def test_a_scale_and_a_zero_are_found_again_inside_their_bounds():
    """The 2σ hold in 95.45 % of 400 sets of points, but for chance (3σ)."""
    least, most = binom(400, 0.9545).interval(0.9973)
    found = [reduce_known_speeds(flown(seed, 1.2, 6.0), STEPS) for seed in range(400)]
    for name, truth in (("scale", 1.2), ("zero", 6.0)):
        inside = sum(
            abs(getattr(each, name) - truth) <= getattr(each, f"{name}_two_sigma") for each in found
        )
        assert least <= inside <= most, name


def test_the_factor_of_a_tunnel_is_that_of_its_table(capsys):
    path = shared_case("26-tunnel-points.csv")
    found = fixed_speed(path)
    factors = [point.factor for point in found.points]
    assert np.mean(factors[:4]) == pytest.approx(1.11, abs=0.01)
    assert np.mean(factors[-4:]) == pytest.approx(1.035, abs=0.005)
    assert main(["fixed-speed", str(path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["scale"]["value"] == pytest.approx(found.scale)
    assert document["points"][0]["factor"] == pytest.approx(found.points[0].factor)
    assert main(["calibrate", str(path)]) == 2
    assert f"pitotbench fixed-speed {path}" in capsys.readouterr().err


def test_an_impact_pressure_counts_as_the_airspeed_that_it_shows(tmp_path):
    known = np.array([10.0, 20.0, 30.0, 40.0])
    path = tmp_path / "points.csv"
    rows = zip(known, air.impact_pressure(known) / 1.1, strict=True)
    path.write_text(
        "reference_airspeed_mps,impact_pressure_pa\n" + "\n".join(f"{a},{b:.3f}" for a, b in rows)
    )
    assert fixed_speed(path).scale == pytest.approx(1.1, abs=1e-3)


@pytest.mark.parametrize(
    ("known", "shown", "words"),
    [
        ([10.0, 20.0], [9.0, 19.0], "at least 3 rows"),
        ([10.0, 20.0, 0.0], [9.0, 19.0, 1.0], "above zero"),
        ([10.0, 10.1, 10.2], [9.0, 9.0, 9.0], "one airspeed"),
    ],
)
def test_points_that_tell_nothing_are_refused(known, shown, words):
    with pytest.raises(BadInputError, match=words):
        reduce_known_speeds(points_of(known, shown), STEPS)
