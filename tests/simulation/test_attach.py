"""Aircraft that the bench did not write: attached, flown, and refused with the reason."""

import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from pitotbench import BadInputError, Case, UnknownNameError, fly
from pitotbench.simulation.aircraft import find_aircraft, known_aircraft
from pitotbench.simulation.aircraft_files import library_aircraft, read_record
from pitotbench.simulation.autopilot.autopilot_file import open_all_tanks
from pitotbench.simulation.sortie import card_of, card_speeds, scaled_card, scaled_case
from pitotbench.units import FOOT, KNOT


@pytest.fixture(autouse=True, scope="module")
def cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PITOTBENCH_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


def test_a_cessna_flies_a_maneuver_on_condition():
    flight = fly(Case(aircraft="c172x", maneuver="rapid_decel", turbulence="light"))
    decel = np.char.startswith(flight.segment, "decel")
    assert flight.on_condition[decel].mean() > 0.95
    assert np.abs(flight["altitude"] - 6000.0 * FOOT).max() < 50.0 * FOOT
    assert np.degrees(np.abs(flight["sideslip"])).mean() < 1.0
    # One engine: what the right one would record is left out.
    assert "throttle_right" not in flight.channels
    assert flight["propeller_speed_left"].min() > 0.0


def test_what_was_found_of_an_airplane_is_that_airplane():
    found = read_record(find_aircraft("c172x"))
    # Clean stall and maximum speed of a 172 by its handbook, 51 and 123 KCAS at 2,300 lb and sea
    # level: the model is no handbook, so the band is wide.
    assert 36.0 < found.stall_kt < 56.0
    assert 100.0 < found.fastest_kt < 135.0
    assert (found.engines, found.engine_kind) == (1, "piston")
    assert list(found.speed_kt) == sorted(found.speed_kt)
    assert list(found.alpha_deg) == sorted(found.alpha_deg, reverse=True)
    found = read_record(find_aircraft("aerosonde"))
    assert found.engine_kind == "electric"  # without fuel
    # Level flight at the largest lift of table E.2, without wash or trim: V = sqrt(2 m g / (rho S
    # C_L)).
    assert found.stall_kt == pytest.approx(
        np.sqrt(2 * 13.5 * 9.81 / (1.225 * 0.55 * 1.65)) / KNOT, rel=0.12
    )


def test_a_turboprop_has_its_power_in_held_flight():
    """JSBSim puts its gas generator to idle with every initial condition; a Twin Otter needs its
    400 hp a side.
    """
    found = read_record(find_aircraft("DHC6"))
    assert (found.engines, found.engine_kind) == (2, "turboprop")
    flight = fly(Case(aircraft="DHC6", maneuver="rapid_decel"))
    decel = np.char.startswith(flight.segment, "decel")
    assert flight.on_condition[decel].mean() == 1.0
    # The fastest speed found is one that the flight holds: the card begins at 76 % of the way to
    # it.
    assert (
        flight["calibrated_airspeed"].max()
        > (found.stall_kt + 0.7 * (found.fastest_kt - found.stall_kt)) * KNOT
    )


def test_an_engine_at_idle_does_not_stop():
    """The engine of a J3 stops below 560 rpm, where its propeller drags it at closed throttle."""
    flight = fly(Case(aircraft="J3Cub", maneuver="rapid_decel", turbulence="light"))
    assert flight["propeller_speed_left"].min() > 600.0 * 2.0 * np.pi / 60.0


def test_engines_draw_from_every_tank():
    """A PC-7 feeds its engine from one of two tanks: 17 minutes. Tanks that an engine names stay as
    they are.
    """
    root = ET.fromstring(
        "<fdm_config><propulsion><engine file='a'><feed>0</feed></engine><engine file='a'><feed> 1 "
        "</feed></engine>"
        "<tank type='FUEL'/><tank type='FUEL'/><tank type='FUEL'/><tank "
        "type='OXIDIZER'/></propulsion></fdm_config>"
    )
    open_all_tanks(root)
    assert [[f.text.strip() for f in engine.findall("feed")] for engine in root.iter("engine")] == [
        ["0", "2"],
        ["1", "2"],
    ]
    folder = find_aircraft("pc7")
    feeds = ET.parse(folder / "pc7.xml").getroot().findall("propulsion/engine/feed")
    assert {feed.text.strip() for feed in feeds} == {"0", "1"}


def test_the_slowest_speed_of_the_cards_leaves_room_where_the_loops_do_not_hold():
    """At 1.12 times its stall speed the model of the PC-7 drops a wing: the cards begin above the
    next point.
    """
    found = read_record(find_aircraft("pc7"))
    assert found.speed_kt[0] > 1.2 * found.stall_kt
    assert card_speeds(found)[0] >= 1.16 * found.speed_kt[0]


def test_cards_keep_to_the_speeds_of_the_aircraft():
    found = read_record(find_aircraft("c172x"))
    speeds = np.array(scaled_card("c172x", "four_leg").speeds) / KNOT
    assert speeds.min() >= 1.3 * found.stall_kt - 0.5
    assert speeds.max() < found.fastest_kt
    assert (
        card_of(Case(aircraft="c172x", card={"speeds_kt": [90.0, 80.0]})).speeds[0] == 90.0 * KNOT
    )
    assert scaled_card("navajo", "four_leg").speeds[0] == 160.0 * KNOT
    assert scaled_case(Case()) == Case()
    assert scaled_case(Case(aircraft="c172x")).pressure_error.reference_pressure < 1000.0


def test_a_path_is_the_same_aircraft_and_is_made_once(tmp_path):
    shutil.copytree(library_aircraft()["c172x"].parent, tmp_path / "c172x")
    folder = find_aircraft(str(tmp_path / "c172x"))
    assert folder == find_aircraft("c172x")
    assert find_aircraft(str(tmp_path / "c172x" / "c172x.xml")) == folder
    with pytest.raises(UnknownNameError, match=r"Did you mean 'navajo'.*JSBSim's library"):
        find_aircraft("navaho")
    with pytest.raises(BadInputError, match="no such aircraft"):
        find_aircraft(str(tmp_path / "none.xml"))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("sgs126", "no engine that holds a level speed"),
        ("p51d", "the throttle does nothing"),
        ("x24b", "no engine that holds a level speed .* it has rocket_engine"),
    ],
)
def test_what_cannot_be_flown_says_why(name, words):
    with pytest.raises(BadInputError, match=words):
        find_aircraft(name)


def shelf(root: Path, *names: str) -> Path:
    for name in names:
        (root / name).mkdir(parents=True)
        (root / name / f"{name}.xml").touch()
    return root


def test_the_first_shelf_wins_and_both_are_known(tmp_path):
    wheel, checkout = (
        shelf(tmp_path / "wheel", "navajo"),
        shelf(tmp_path / "checkout", "navajo", "other"),
    )
    (checkout / "empty").mkdir()
    assert find_aircraft("navajo", (wheel, checkout)) == wheel / "navajo"
    assert find_aircraft("other", (wheel, checkout)) == checkout / "other"
    assert set(known_aircraft((wheel, checkout))) == {"navajo", "other"}
