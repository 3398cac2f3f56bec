"""A model made for FlightGear is taken, and what is wrong with a model is told."""

import shutil
from pathlib import Path
from xml.etree.ElementTree import fromstring

import pytest

from pitotbench import BadInputError
from pitotbench.simulation.aircraft_files import library, library_aircraft, load_fdm, parse_xml
from pitotbench.simulation.aircraft_import import import_aircraft, left_tables, set_to_zero
from pitotbench.simulation.autopilot.attach import engines_of, make_flyable
from pitotbench.simulation.autopilot.envelope import trim
from pitotbench.simulation.autopilot.frozen_aircraft import FrozenAircraft, State
from pitotbench.simulation.autopilot.linear_model import WRONG, linearize, wrong_slopes
from pitotbench.units import DEGREE, FOOT, KNOT

FLAPS = '<channel name="Flaps">'
READ = (
    FLAPS + '<fcs_function name="fcs/lit"><function><sum><property>{}</property>'
    "<property>-systems/foo</property></sum></function></fcs_function>"
)
CM_ALPHA = "<property>aero/alpha-rad</property>\n                    <value>-1.8</value>"


def taken(tmp_path: Path, old: str = "", new: str = "") -> Path:
    """The folder of a c172x, taken in from a copy with one edit."""
    source = library_aircraft()["c172x"]
    text = source.read_text(encoding="utf-8")
    assert old in text
    home, folder = tmp_path / "hangar" / "mine", tmp_path / "taken" / "mine"
    home.mkdir(parents=True, exist_ok=True)
    folder.mkdir(parents=True)
    (home / "mine.xml").write_text(text.replace(old, new, 1), encoding="utf-8")
    shutil.copy(source.with_name("c172ap.xml"), home)
    import_aircraft(home / "mine.xml", folder)
    return folder


def held(folder: Path) -> FrozenAircraft:
    root = parse_xml(folder / f"{folder.name}.xml").getroot()
    return FrozenAircraft(folder.name, folder, 6000.0 * FOOT, engines_of(folder, root))


def test_what_only_flightgear_writes_is_0(tmp_path):
    read = READ.format("/systems/electrical/outputs/flaps")
    folder = taken(tmp_path, FLAPS, read.replace("-systems", "systems"))
    assert set_to_zero(folder) == ("/systems/electrical/outputs/flaps", "systems/foo")
    fdm, _ = load_fdm("mine", folder, 100.0)
    assert fdm.run_ic()
    assert fdm.run()
    assert fdm["fcs/lit"] == 0.0
    again = tmp_path / "again" / "mine"
    again.mkdir(parents=True)
    import_aircraft(folder, again)
    assert set_to_zero(again) == set_to_zero(folder)


def test_what_the_file_or_jsbsim_creates_stays(tmp_path):
    folder = taken(tmp_path, FLAPS, FLAPS.replace("Flaps", "All flaps"))
    assert set_to_zero(folder) == ()
    assert "set-to-zero" not in (folder / "mine.xml").read_text(encoding="utf-8")


def test_a_misspelled_state_of_flight_is_refused(tmp_path):
    read = READ.format("aero/alpha-rads").replace("-systems/foo", "aero/alpha-rad")
    folder = taken(tmp_path, FLAPS, read)
    assert set_to_zero(folder) == ()
    with pytest.raises(BadInputError, match="aero/alpha-rads does not exist"):
        make_flyable(folder)


def test_a_table_that_does_not_ascend_is_named(tmp_path):
    folder = taken(tmp_path, "<tableData>", "<tableData>\n 0.9 1\n 0.8 2\n")
    with pytest.raises(BadInputError, match=r"not monotonically.*systems/mixture-cmd-norm"):
        make_flyable(folder)


@pytest.mark.parametrize("name", ["../Engines/own", "Engines/own.xml", "../Systems/eng_io320"])
def test_an_engine_is_found_by_a_path(tmp_path, name):
    place = tmp_path / "hangar" / ("Engines" if name.startswith("..") else "mine/Engines")
    place.mkdir(parents=True)
    own = (library() / "engine" / "eng_io320.xml").read_text(encoding="utf-8")
    (place / "own.xml").write_text(own.replace("160.0", "123.0"), encoding="utf-8")
    folder = taken(tmp_path, '"eng_io320"', f'"{name}"')
    (engine,) = (f for f in (folder / "Engines").glob("*.xml") if "prop" not in f.name)
    power = parse_xml(engine).getroot().findtext("maxhp") or ""
    assert power.strip() == ("123.0" if "own" in name else "160.0")
    assert held(folder).engines == 1


def test_a_folder_beside_the_aircraft_that_is_none_of_parts_is_refused(tmp_path):
    (tmp_path / "hangar" / "Secrets").mkdir(parents=True)
    (tmp_path / "hangar" / "Secrets" / "own.xml").write_text("<piston_engine/>")
    with pytest.raises(BadInputError, match="plain file name is allowed, or one in a folder"):
        taken(tmp_path, '"eng_io320"', '"../Secrets/own"')


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("", "", []),
        (CM_ALPHA, CM_ALPHA.replace("-1.8", "0.3"), [WRONG[0]]),
        ("-0.349  0.0311", "-0.349 -0.0933", [WRONG[2]]),
    ],
)
def test_a_slope_of_the_wrong_sign_is_told(tmp_path, old, new, words):
    aircraft = held(taken(tmp_path, old, new))
    model = linearize(aircraft, trim(aircraft, 100.0 * KNOT))
    found = wrong_slopes(aircraft, [model])
    assert found == [f"{w} at {model.trim.calibrated / KNOT:.0f} KCAS" for w in words]


def test_slopes_are_those_of_moments(tmp_path):
    """A Texan's product of inertia is a fifth of its I_xx: roll and yaw accelerations differ from
    the moments, which JSBSim gives too.
    """
    folder = tmp_path / "t6texan2"
    folder.mkdir()
    import_aircraft(library_aircraft()["t6texan2"], folder)
    aircraft = held(folder)
    point = trim(aircraft, 160.0 * KNOT)
    assert wrong_slopes(aircraft, [linearize(aircraft, point)]) == []
    sides = []
    for beta in (-DEGREE, DEGREE):
        aircraft.accelerations(State(point.speed, point.alpha, beta, elevator=point.elevator))
        sides.append([aircraft.read(f"moments/{axis}-total-lbsft") for axis in "ln"])
    (roll, yaw), (roll_right, yaw_right) = sides
    assert roll_right < roll
    assert yaw_right > yaw


TABLE = """<fdm_config><aerodynamics><axis name="LIFT"><function name="CL"><product>
<property>{}</property><table><independentVar lookup="{}">aero/alpha-deg</independentVar>
<independentVar lookup="{}">velocities/mach</independentVar><tableData>{}</tableData>
</table></product></function></axis></aerodynamics></fdm_config>"""
BY_ROW, BY_COLUMN = " 0.1 0.5\n -4 0 0\n 0 0.2 0.2\n 8 0.9 0.8\n", "-4 0 8\n 0.1 0 0.2 0.9\n"


@pytest.mark.parametrize(
    ("axes", "data"), [(("row", "column"), BY_ROW), (("column", "row"), BY_COLUMN)]
)
def test_a_table_that_level_flight_leaves_is_told(axes, data):
    root = fromstring(TABLE.format("aero/qbar-area", *axes, data))
    (told,) = left_tables(root, [3.0 * DEGREE, 11.0 * DEGREE])
    assert told.startswith("level flight reaches 11.0°")
    assert told.endswith("CL has no row: it ends at 8.0°")
    # Within 1° of the end, and below an end where the table is 0.
    assert left_tables(root, [-9.0 * DEGREE, 8.9 * DEGREE]) == []
    damping = fromstring(TABLE.format("velocities/q-aero-rad_sec", *axes, data))
    assert left_tables(damping, [3.0 * DEGREE, 11.0 * DEGREE]) == []
