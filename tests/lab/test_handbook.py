"""The performance of the navajo's file against the handbook of the airplane that it stands for."""

import pytest

from pitotbench.models.handbook import COLUMNS
from pitotbench.models.performance import find_performance
from pitotbench.units import POUND
from pitotlab.reference_figures import published_figures


def test_the_handbook_of_the_navajo_is_met_within_its_tolerances(tmp_path):
    names = {"level speed": "cruise", "climb": "climb", "stall": "stall", "ceiling": "ceiling"}
    columns = ("true_airspeed_kt", "climb_rate_fpm", "calibrated_airspeed_kt", "ceiling_ft")
    value_in = dict(zip(names, columns, strict=True))
    published = [figure for figure in published_figures("navajo") if figure.maneuver in names]
    lines = [",".join(COLUMNS)]
    for figure in published:
        row = dict.fromkeys(COLUMNS, "")
        row |= {"figure": names[figure.maneuver], "weight_lb": f"{figure.weight_lb}"}
        row[value_in[figure.maneuver]] = f"{figure.value}"
        if figure.maneuver != "ceiling":
            row["altitude_ft"] = f"{figure.altitude_ft}"
        if figure.maneuver == "stall":
            row["flaps_percent"] = f"{100.0 * figure.flap}"
        if figure.maneuver == "level speed" and figure.power < 1.0:
            row["power_hp"] = f"{figure.power * 620.0}"
        lines.append(",".join(row[name] for name in COLUMNS))
    table = tmp_path / "handbook.csv"
    table.write_text("\n".join(lines), encoding="utf-8")
    found = find_performance("navajo", table)
    for figure, row in zip(published, found.figures, strict=False):
        unit = figure.value / 100.0 if figure.tolerance_unit == "%" else 1.0
        allowed = figure.tolerance * unit
        assert row.published == figure.value
        assert abs(row.difference) <= allowed, (figure.name, row)
    # A heavier airplane of the handbook does not change the figures at the weight of the file.
    assert found.mass / POUND == pytest.approx(5990.0, abs=1.0)
