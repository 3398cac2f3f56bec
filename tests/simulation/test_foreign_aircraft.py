"""Every aircraft of another author goes through one door, found by path or by name."""

import os
import shutil
from pathlib import Path

import pytest
from tests.simulation.plant_record import digest

from pitotbench import BadInputError, Case, fly
from pitotbench.records.case import EffectSpec
from pitotbench.simulation.aircraft import SHIPPED, find_aircraft
from pitotbench.simulation.aircraft_files import FILE, read_record
from pitotbench.simulation.autopilot import attach
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.modified import install_variant
from pitotbench.simulation.plant import Plant

OPENINGS = (
    '<output name="{}" type="CSV" rate="10"><property>velocities/vc-kts</property></output>'
    '<output type="SOCKET" name="127.0.0.1" port="5998"/><input port="5997"/>'
)
POD = EffectSpec("belly_pod", {"drag_area_m2": 0.1})
SHORT = {
    "maneuver": "rapid_decel",
    "turbulence": "none",
    "card": {"repeats": 1, "dwell_s": 5.0, "settle_s": 5.0},
    "integration_rate": 50.0,
}


@pytest.fixture(autouse=True, scope="module")
def cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PITOTBENCH_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    """The working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def copy_of_the_navajo(here: Path, name: str, added: str = "", before: str = "") -> Path:
    folder = Path(shutil.copytree(find_aircraft("navajo"), here / "aircraft" / name))
    text = (folder / "navajo.xml").read_text(encoding="utf-8")
    (folder / "navajo.xml").unlink()
    head, root, rest = text.partition("<fdm_config")
    text = head + before + root + rest.replace("</fdm_config>", f"{added}</fdm_config>")
    (folder / f"{name}.xml").write_text(text, encoding="utf-8")
    return folder


def test_an_aircraft_found_by_name_is_cleaned_as_one_by_path(here):
    folder = copy_of_the_navajo(here, "evil", OPENINGS.format(here / "written.csv"))
    by_name = find_aircraft("evil")
    assert by_name == find_aircraft(str(folder))
    assert "port" not in (by_name / "evil.xml").read_text(encoding="utf-8")
    Plant.load("evil").start(1800.0, 70.0)
    assert not (here / "written.csv").exists()


def test_a_doctype_is_refused_by_name_too(here):
    copy_of_the_navajo(here, "bomb", before='<!DOCTYPE a [<!ENTITY e "x">]>')
    with pytest.raises(BadInputError, match=r"bomb\.xml: a DOCTYPE is not allowed"):
        find_aircraft("bomb")


def test_a_pipe_in_the_place_of_an_aircraft_is_no_file(here):
    (here / "aircraft" / "pipe").mkdir(parents=True)
    os.mkfifo(here / "aircraft" / "pipe" / "pipe.xml")
    with pytest.raises(BadInputError, match="no such file"):
        find_aircraft("pipe")


def test_only_what_the_package_ships_reaches_jsbsim_as_it_is(here):
    assert find_aircraft("navajo").parent in SHIPPED
    install_variant("navajo", "pod", [POD])
    assert here not in find_aircraft("navajo+pod").parents


@pytest.mark.parametrize("aircraft", ["navajo", "c172x"])
def test_a_variant_keeps_its_name_its_record_and_its_flight(aircraft):
    install_variant(aircraft, "a.b-pod", [POD])
    found = find_aircraft(f"{aircraft}+a.b-pod")
    assert found.name == f"{aircraft}+a.b-pod"
    assert read_record(found) == read_record(find_aircraft(aircraft))
    flown = (
        fly(Case(aircraft=f"{aircraft}+a.b-pod", **SHORT)),
        fly(Case(aircraft=aircraft, effects=(POD,), **SHORT)),
    )
    assert digest(flown[0]) == digest(flown[1])


@pytest.mark.parametrize(
    "content", [b"\xff", b"speed_kt", b"stall_kt = 40.0", b'stall_kt = "a"', b"speed_kt = []"]
)
def test_a_record_that_is_none_is_refused_in_one_line(content):
    folder = install_variant("c172x", "pod", [POD])
    kept = (folder / FILE).read_bytes() if content.endswith((b'"', b"]")) else b""
    key = content.split()[0]
    lines = [line for line in kept.splitlines() if key and not line.startswith(key)]
    (folder / FILE).write_bytes(b"\n".join([*lines, content]))
    with pytest.raises(BadInputError, match="not the record of an attached autopilot"):
        find_aircraft("c172x+pod")


def test_an_aircraft_deleted_from_the_cache_is_made_again_in_the_same_process():
    folder = find_aircraft("c172x")
    files = {file: file.read_bytes() for file in folder.rglob("*.*")}
    shutil.rmtree(folder.parent)
    assert find_aircraft("c172x") == folder
    (folder / attach.AUTOPILOT).unlink()  # of half a folder no flight is made either
    assert find_aircraft("c172x") == folder
    assert {file: file.read_bytes() for file in folder.rglob("*.*")} == files


def test_the_cache_spares_what_is_in_use(monkeypatch):
    monkeypatch.setattr(attach, "MOST_KEPT", 1)
    for number, name in enumerate(("one", "two", "three")):
        install_variant("navajo", name, [EffectSpec("mass", {"mass_kg": 10.0 + number})])
    folders = [find_aircraft(f"navajo+{name}") for name in ("one", "two")]
    assert all(folder.is_dir() for folder in folders)
    for folder in folders:
        os.utime(folder.parent, (0.0, 0.0))  # used long ago
    find_aircraft("navajo+one")  # each use counts, not the first of a process alone
    find_aircraft("navajo+three")
    assert [folder.is_dir() for folder in folders] == [True, False]


def test_a_dimension_in_a_unit_that_nobody_knows_is_not_told(tmp_path):
    """A number without a unit is one of the simulator's own: pounds, square feet, feet."""
    folder = tmp_path / "plain"
    folder.mkdir()
    (folder / "plain.xml").write_text(
        "<fdm_config><metrics><wingarea> 100 </wingarea><chord unit='FURLONG'> 1 </chord></metrics>"
        "<mass_balance><emptywt> 1000 </emptywt></mass_balance></fdm_config>"
    )
    told = read_baseline(folder).dimensions
    assert told == pytest.approx({"wing area": 9.290304, "empty mass": 453.59237})
