"""Files of an aircraft from outside: taken in whole, or refused in one line."""

import jsbsim
import pytest

from pitotbench.records import BadInputError
from pitotbench.simulation.aircraft_files import SimulationError, library_aircraft, load_fdm
from pitotbench.simulation.aircraft_import import (
    DEEPEST,
    LARGEST_FILE,
    aircraft_name,
    import_aircraft,
)

BARE = '<?xml version="1.0"?><fdm_config name="x" version="2.0">{}</fdm_config>'


def aircraft(folder, inside="", name="kite"):
    folder.mkdir(exist_ok=True)
    (folder / f"{name}.xml").write_text(BARE.format(inside))
    return folder / f"{name}.xml"


def taken(tmp_path, file):
    folder = tmp_path / "taken" / "kite"
    folder.mkdir(parents=True)
    return import_aircraft(file, folder)


@pytest.mark.parametrize("name", ["c172x", "T38", "p51d"])
def test_a_library_aircraft_loads_from_its_copy_alone(tmp_path, name):
    folder = tmp_path / name
    folder.mkdir()
    import_aircraft(library_aircraft()[name], folder)
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm = jsbsim.FGFDMExec(None)
    assert fdm.load_model_with_paths(
        name, str(tmp_path), str(folder / "Engines"), str(folder / "Systems")
    )


@pytest.mark.parametrize(
    "name",
    [
        "../../etc/passwd",
        "/etc/passwd",
        "a/../../b",
        "..",
        "http://example.org/x",
        "a\nb",
        "-rf",
        "",
    ],
)
def test_a_part_cannot_lead_out_of_the_folder(tmp_path, name):
    (tmp_path / "b.xml").write_text("<system/>")
    text = name.replace("\n", "&#10;")
    with pytest.raises(BadInputError, match="plain file name"):
        taken(tmp_path, aircraft(tmp_path / "mine", f'<system file="{text}"/>'))


def test_neither_a_link_out_of_the_folder_nor_a_part_that_names_itself_is_taken(tmp_path):
    file = aircraft(tmp_path / "mine", '<system file="part"/>')
    (tmp_path / "secret.xml").write_text("<system/>")
    part = tmp_path / "mine" / "part.xml"
    part.symlink_to(tmp_path / "secret.xml")
    with pytest.raises(BadInputError, match="neither in its folder"):
        taken(tmp_path, file)
    part.unlink()
    part.write_text('<system name="l"><system file="part"/></system>')
    with pytest.raises(BadInputError, match="names itself"):
        taken(tmp_path / "again", file)


@pytest.mark.parametrize(
    "entity", ['e SYSTEM "file:///etc/passwd"', 'e SYSTEM "http://example.org/"', 'e "&f;&f;"']
)
def test_entities_are_refused(tmp_path, entity):
    file = tmp_path / "kite.xml"
    file.write_text(
        f'<!DOCTYPE a [<!ENTITY f "xxxxxxxxxx"><!ENTITY {entity}>]><fdm_config>&e;</fdm_config>'
    )
    with pytest.raises(BadInputError, match=r"kite\.xml: a DOCTYPE is not allowed"):
        taken(tmp_path, file)


def test_what_writes_files_or_opens_sockets_is_left_out(tmp_path):
    inside = (
        '<output name="x.csv" type="CSV"/><input type="SOCKET" port="1137"/><output '
        'type="SOCKET" port="1"/>'
    )
    copy = taken(tmp_path, aircraft(tmp_path / "mine", inside))
    assert "output" not in copy.read_text()
    assert "SOCKET" not in copy.read_text()


def test_a_second_airplane_is_not_loaded_unread(tmp_path):
    """JSBSim reads <child name="..."/> from any place, with what it writes and opens."""
    folder = tmp_path / "mine"
    system = '<child name="../evil/evil"><location/></child><system file="mine"/>'
    file = aircraft(folder, system)
    (folder / "mine.xml").write_text('<system name="a"><output name="x.csv"/><child/></system>')
    copy = taken(tmp_path, file)
    assert "child" not in copy.read_text()
    part = (copy.parent / "Systems" / "mine.xml").read_text()
    assert "child" not in part
    assert "output" not in part


@pytest.mark.parametrize(
    "name",
    [
        "simulation/write-state-file",
        "/simulation[0]/reset",
        "simulation/do_simple_trim",
        "simulation/jsbsim-debug",
        # JSBSim takes these too; of the first it wrote a file a step, of the second it crashed.
        "<x/>simulation/write-state-file",
        "<x/>simulation/reset",
        "simulation/write-state-file\nfcs/gain",
    ],
)
def test_a_property_that_commands_the_simulator_is_refused(tmp_path, name):
    inside = f'<system name="a"><channel name="c"><pure_gain name="g"><output>{name}</output></pure_gain></channel></system>'
    with pytest.raises(BadInputError, match="commands the simulator"):
        taken(tmp_path, aircraft(tmp_path / "mine", inside))


@pytest.mark.parametrize("text", ["1e12", "-5", "nan", "fcs/delay", ""])
def test_a_delay_that_ends_the_program_is_refused(tmp_path, text):
    actuator = f'<actuator name="fcs/a"><input>fcs/b</input><delay>{text}</delay></actuator>'
    inside = f'<system name="a"><channel name="c">{actuator}</channel></system>'
    with pytest.raises(BadInputError, match=r"kite\.xml: a delay of"):
        taken(tmp_path, aircraft(tmp_path / "mine", inside))


def test_a_name_that_jsbsim_cannot_read_is_refused_in_its_words(tmp_path):
    system = '<system name="a"><property value="1">a/b[-1]</property></system>'
    text = library_aircraft()["ball"].read_text().replace("</fdm_config>", f"{system}</fdm_config>")
    file = aircraft(tmp_path / "mine")
    file.write_text(text)
    copy = taken(tmp_path, file)
    with pytest.raises(SimulationError, match=r"cannot load aircraft 'kite'.*a/b\[-1\]"):
        load_fdm("kite", copy.parent, 120.0)


READS = "<function name='{}'><sum><property>{}</property><v>1</v></sum></function>"
CIRCLES = {
    "itself": READS.format("ap/f", "ap/f"),
    "each other": READS.format("ap/f", "ap/g") + READS.format("ap/g", "ap/f"),
}


@pytest.mark.parametrize("functions", CIRCLES.values(), ids=CIRCLES)
def test_functions_that_read_one_another_end_a_child_and_not_this_process(tmp_path, functions):
    text = library_aircraft()["ball"].read_text()
    system = f'<system name="a">{functions}<channel name="c"/></system>'
    file = aircraft(tmp_path / "mine")
    file.write_text(text.replace("</fdm_config>", f"{system}</fdm_config>"))
    with pytest.raises(BadInputError, match=r"kite\.xml: JSBSim breaks down.*reads itself"):
        taken(tmp_path, file)


def test_an_airplane_of_the_library_is_loaded_without_a_child(tmp_path, monkeypatch):
    monkeypatch.setattr("subprocess.run", None)
    folder = tmp_path / "ball"
    folder.mkdir()
    assert import_aircraft(library_aircraft()["ball"], folder).is_file()


def test_sizes_and_depths_are_limited(tmp_path):
    with pytest.raises(BadInputError, match=r"more than 20,000 elements"):
        taken(tmp_path / "many", aircraft(tmp_path / "mine", "<a/>" * 20_001))
    with pytest.raises(BadInputError, match="larger than 4 MB"):
        taken(tmp_path, aircraft(tmp_path / "big", " " * LARGEST_FILE))
    deep = "<a>" * DEEPEST + "</a>" * DEEPEST
    with pytest.raises(BadInputError, match="nested more than"):
        import_aircraft(aircraft(tmp_path / "deep", deep), tmp_path / "taken" / "kite")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<fdm_config>", "not valid XML"),
        ("<html></html>", "not an aircraft of JSBSim: its root is <html>"),
        ("\x00\x01", "not valid XML"),
        (
            BARE.format('<engine file="none-such"/>'),
            "neither in its folder nor among JSBSim's parts",
        ),
    ],
)
def test_what_is_no_aircraft_is_named_in_one_line(tmp_path, text, words):
    file = tmp_path / "kite.xml"
    file.write_text(text)
    with pytest.raises(BadInputError, match=words) as caught:
        taken(tmp_path, file)
    assert "\n" not in str(caught.value)


def test_names_become_plain(tmp_path):
    assert aircraft_name(tmp_path / "my plane (2).xml") == "my_plane_2"
    assert aircraft_name(tmp_path / "c172x") == "c172x"
