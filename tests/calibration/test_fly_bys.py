"""Tower fly-bys: the altimeter beside the tower's barometer gives the position error, with a bound
that covers.
"""

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pandas as pd
import pytest

from pitotbench import BadInputError, air
from pitotbench.calibration.fly_by import _of_readings, reduce_fly_bys
from pitotbench.calibration.options import Accuracies
from pitotbench.cli.app import main
from pitotbench.logbook.points_table import is_points_table, read_fly_bys
from pitotbench.records.legs import FlyBy
from pitotbench.units import FOOT, INCH_OF_MERCURY, KNOT


def fly_by_card(seed: int, altimeter_error: float) -> tuple[str, np.ndarray]:
    """Return a card of five passes as CSV, read in whole steps, and the true altitude corrections
    [ft], (5,).

    The air between tower and airplane is integrated meter by meter. The pilot reads the airspeed to
    1 kt and the altimeter to 10 ft; the tower reads the grid to 5 ft, the barometer to 0.01 inHg
    and the thermometer to 1 °C. `altimeter_error` [Pa] is the standard deviation of the altimeter
    against the barometer, one draw a card.
    """
    rng = np.random.default_rng([seed, 35])
    lines = [
        "indicated_airspeed_kt,pressure_altitude_ft,grid_height_ft,tower_pressure_inhg,tower_temperature_degc"
    ]
    tower = float(air.standard_pressure(rng.uniform(0.0, 1500.0))) * rng.uniform(0.98, 1.02)
    temperature, shape = rng.uniform(263.0, 308.0), rng.uniform(-0.05, 0.05)
    off, truth = altimeter_error * rng.standard_normal(), []
    for knots in np.linspace(80.0, 160.0, 5) + rng.uniform(-5.0, 5.0, 5):
        tower += rng.uniform(-30.0, 30.0)
        height, pressure = rng.uniform(40.0, 400.0) * FOOT, tower
        for step in np.arange(0.5, 200.0, 1.0) / 200.0:
            here = temperature - 0.0065 * step * height
            pressure -= pressure * 9.80665 / (287.053 * here) * height / 200.0
        impact = float(air.impact_pressure(knots * KNOT))  # indicated
        error = impact * shape / (1.0 - shape)
        indicated = float(air.pressure_altitude(pressure + error + off)) / FOOT
        truth.append(
            float(air.pressure_altitude(pressure) - air.pressure_altitude(pressure + error)) / FOOT
        )
        lines.append(
            f"{knots:.0f},{10.0 * round(indicated / 10.0):.0f},{5.0 * round(height / FOOT / 5.0):.0f},"
            f"{tower / INCH_OF_MERCURY:.2f},{temperature - 273.15:.0f}"
        )
    return "\n".join(lines) + "\n", np.array(truth)


def fly_by_rows(seeds: range, altimeter_two_sigma: float) -> pd.DataFrame:
    """Return the error and the bound [ft] of every pass of a card a seed, with an altimeter of a 2σ
    [Pa].
    """
    stated = Accuracies(static_pressure_pa=altimeter_two_sigma, temperature_k=0.0)
    rows: list[dict[str, float]] = []
    with TemporaryDirectory() as folder:
        for seed in seeds:
            card, truth = fly_by_card(seed, 0.5 * altimeter_two_sigma)
            path = Path(folder) / "card.csv"
            path.write_text(card, encoding="utf-8")
            for point, true in zip(reduce_fly_bys(*read_fly_bys(path), stated), truth, strict=True):
                error = point.altitude_correction / FOOT - true
                rows.append(
                    {
                        "seed": seed,
                        "error_ft": error,
                        "two_sigma_ft": point.altitude_two_sigma / FOOT,
                    }
                )
    return pd.DataFrame(rows)


EXACT = dict.fromkeys(
    (
        "indicated_airspeed",
        "pressure_altitude",
        "grid_height",
        "tower_pressure",
        "tower_temperature",
    ),
    0.0,
)


def standard_pass(**changes):
    """A pass 200 ft above a tower that stands 1,000 ft high on a standard day, by an airplane
    without an error.
    """
    found = {
        "row": 1, "point": "1", "configuration": "", "indicated_airspeed": 100.0 * KNOT,
        "pressure_altitude": 1200.0 * FOOT, "grid_height": 200.0 * FOOT,
        "tower_pressure": float(air.standard_pressure(1000.0 * FOOT)),
        "tower_temperature": float(air.standard_temperature(1000.0 * FOOT)),
    }  # fmt: skip
    return FlyBy(**{**found, **changes})


@pytest.mark.parametrize("error", [0.0, 0.03])
def test_a_known_error_is_found_in_feet_in_knots_and_as_a_share(error):
    """The static source reads 3 % of the impact pressure too high: the altimeter reads low, the
    airspeed too.
    """
    right, true = air.impact_pressure(100.0 * KNOT), air.standard_pressure(1200.0 * FOOT)
    read = float(air.pressure_altitude(true + error * right))
    indicated = float(air.calibrated_airspeed((1.0 - error) * right))
    flown = standard_pass(pressure_altitude=read, indicated_airspeed=indicated)
    (point,) = reduce_fly_bys([flown], EXACT, Accuracies())
    assert point.normalized_pressure_error == pytest.approx(error, rel=1e-3, abs=1e-5)
    assert point.correction == pytest.approx(100.0 * KNOT - indicated, rel=1e-3, abs=1e-4)
    assert point.altitude_correction == pytest.approx(
        1200.0 * FOOT - read, abs=1e-3 if error == 0.0 else 2e-3
    )


def test_the_bound_of_one_step_alone_is_that_of_a_uniform_error():
    """95.45 % of a uniform error lie within 0.9545 of half its step; of normal ones within two
    deviations.
    """
    assert _of_readings(np.array([10.0, 0.0]), 0.0) == pytest.approx(9.545, rel=0.02)
    assert _of_readings(np.array([0.0, 0.0]), 3.0) == pytest.approx(6.0, rel=1e-3)
    assert _of_readings(np.array([1.0, 1.0, 1.0, 1.0]), 0.0) == pytest.approx(
        2.0 * np.sqrt(4.0 / 3.0), rel=0.05
    )
    (point,) = reduce_fly_bys(
        [standard_pass()], {**EXACT, "pressure_altitude": 20.0 * FOOT}, Accuracies()
    )
    assert point.altitude_two_sigma == pytest.approx(9.545 * FOOT, rel=0.02)


@pytest.mark.parametrize("altimeter", [0.0, 30.0])
def test_the_bound_covers_cards_read_in_whole_steps(altimeter):
    """200 cards, seeds of the test's own: 95 ± 3 % of the passes."""
    rows = fly_by_rows(range(1, 201), altimeter)
    assert 0.92 <= np.mean(rows["error_ft"].abs() <= rows["two_sigma_ft"]) <= 0.98


def test_the_command_reads_a_card_and_prints_feet(tmp_path, capsys):
    card, truth = fly_by_card(3, 0.0)
    path = tmp_path / "card.csv"
    path.write_text(card, encoding="utf-8")
    assert is_points_table(path)
    # The steps are those of the numbers written.
    _, steps = read_fly_bys(path)
    assert steps["grid_height"] == pytest.approx(5.0 * FOOT)
    assert steps["tower_pressure"] == pytest.approx(0.01 * INCH_OF_MERCURY)
    assert main(["fixed-speed", str(path), "--json"]) == 0
    points = json.loads(capsys.readouterr().out)["points"]
    assert {"altitude_correction_ft", "two_sigma_ft", "normalized_pressure_error"} <= set(points[0])
    found, bound = (
        np.array([p[name] for p in points]) for name in ("altitude_correction_ft", "two_sigma_ft")
    )
    assert np.all(np.abs(found - truth) < 2.0 * bound)
    assert main(["fixed-speed", str(path)]) == 0
    assert "altitude" in capsys.readouterr().out


HEAD = "indicated_airspeed_kt,pressure_altitude_ft,grid_height_ft,tower_pressure_inhg,tower_temperature_degc\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            HEAD.replace("pressure_altitude_ft,", "") + "100,200,28.86,13\n",
            "missing column pressure_altitude_ft",
        ),
        (
            HEAD.replace("inhg", "ft") + "100,1200,200,28.86,13\n",
            "'tower_pressure_ft': a pressure; name it",
        ),
        (HEAD + "100,1200,5000,28.86,13\n", "grid height above the tower's barometer"),
        (HEAD + "100,1200,200,29.92,13\n", "not the altimeter setting"),
        (HEAD + "100,1200,200,-1,13\n", "above zero"),
        (HEAD + "100,1200,,28.86,13\n", "a number is missing"),
    ],
)
def test_a_card_that_cannot_be_is_refused_with_the_reason(tmp_path, capsys, text, says):
    path, legs = tmp_path / "card.csv", tmp_path / "legs.csv"
    path.write_text(text, encoding="utf-8")
    legs.write_text("point,configuration\n1,clean\n", encoding="utf-8")
    assert main(["fixed-speed", str(path)]) == 2
    assert says in capsys.readouterr().err
    assert main(["fixed-speed", str(path), str(legs)]) == 2
    assert "fly-by cards" in capsys.readouterr().err
    with pytest.raises(BadInputError, match="no pass"):
        reduce_fly_bys([], EXACT)
