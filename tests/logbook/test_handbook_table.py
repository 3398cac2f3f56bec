"""A handbook's table of airspeeds: read as people type it, refused with its reason."""

import numpy as np
import pytest
from tests.shared_data import shared_case

from pitotbench import BadInputError
from pitotbench.logbook.handbook_table import read_published
from pitotbench.units import KNOT

MPH_IN_KNOTS = 1609.344 / 1852.0


def written(tmp_path, text):
    path = tmp_path / "poh.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_table_in_knots_is_read_in_any_order(tmp_path):
    (curve,) = read_published(written(tmp_path, "KIAS,KCAS\n60,62\n40,49\n110,107\n"))
    np.testing.assert_allclose(curve.indicated_airspeed / KNOT, [40.0, 60.0, 110.0])
    np.testing.assert_allclose(curve.correction / KNOT, [9.0, 2.0, -3.0], atol=1e-9)
    assert (curve.source, curve.configuration) == ("poh.csv", "")


@pytest.mark.parametrize(
    "text",
    [
        "configuration,KIAS,KCAS\nflaps up,60,62\nflaps up,90,88\nflaps 30,50,54\nflaps 30,80,79\n",
        "KIAS;KCAS flaps up;KCAS flaps 30\n50;;54\n60;62;\n80;;79\n90;88;\n",
    ],
)
def test_configurations_stand_in_rows_or_in_columns(tmp_path, text):
    curves = {each.configuration: each for each in read_published(written(tmp_path, text))}
    assert [*curves] == ["flaps up", "flaps 30"]
    np.testing.assert_allclose(curves["flaps 30"].correction / KNOT, [4.0, -1.0], atol=1e-9)


@pytest.mark.parametrize("names", ["IAS [mph],CAS [mph]", "IAS mph,CAS mph", "ias_mph,cas_mph"])
def test_the_unit_of_a_heading_counts(tmp_path, names):
    (curve,) = read_published(written(tmp_path, f"{names}\n60,64\n100,101\n"))
    np.testing.assert_allclose(
        curve.indicated_airspeed / KNOT, [60 * MPH_IN_KNOTS, 100 * MPH_IN_KNOTS]
    )
    np.testing.assert_allclose(curve.correction / KNOT, [4 * MPH_IN_KNOTS, MPH_IN_KNOTS])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("IAS,CAS\n60,62\n90,89\n", "does not say its unit"),
        ("figure,calibrated_airspeed_kt\nstall,48\n", "aircraft performance"),
        ("time_s,velocity_north_mps\n0,1\n1,1\n", "no handbook's table"),
        ("KIAS,KCAS\n60,62\n", "1 rows"),
        ("KIAS,KCAS\n60,62\n60,63\n", "given twice"),
        ("KIAS,KCAS\n60,62\n70,61\n", "does not grow"),
        ("KIAS,KCAS\n60,162\n70,171\n", "more than half"),
        ("KIAS,KCAS\n60,fast\n70,71\n", "row 1: 'fast' is not a number; correct"),
        ("KIAS,KCAS\n-60,-62\n70,71\n", "more than half"),
        ("", "the file is empty"),
    ],
)
def test_another_table_is_refused_with_what_is_wrong(tmp_path, text, says):
    with pytest.raises(BadInputError, match=says):
        read_published(written(tmp_path, text))


def test_the_table_of_the_field_is_read():
    (curve,) = read_published(shared_case("17-handbook-kias-kcas.csv"))
    assert len(curve.correction) == 9
    np.testing.assert_allclose(curve.correction[[0, -1]] / KNOT, [9.0, -3.0], atol=1e-9)
