"""The check of an aircraft tells what was set to 0, and warns of what is wrong with its model."""

import shutil

from pitotbench.bench.aircraft_check import check_aircraft
from pitotbench.show.inspection import check_sentences
from pitotbench.simulation.aircraft_files import library_aircraft

ADDED = (
    '<system name="lamp"><channel name="lamp"><pure_gain name="lamp/light">'
    "<input>/systems/electrical/outputs/flaps</input><gain>1</gain></pure_gain></channel></system>"
)


def test_the_check_tells_what_was_set_to_0_and_a_dihedral_of_the_wrong_sign(tmp_path, monkeypatch):
    monkeypatch.setenv("PITOTBENCH_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "mine"
    shutil.copytree(library_aircraft()["c172x"].parent, folder)
    text = (folder / "c172x.xml").read_text(encoding="utf-8")
    text = text.replace("</fdm_config>", f"{ADDED}</fdm_config>")
    # The left half of the table of the rolling moment by sideslip, with three times its size.
    (folder / "mine.xml").write_text(text.replace("-0.349  0.0311", "-0.349 -0.0933"))
    check = check_aircraft(str(folder), ())
    sentences = check_sentences(check)
    assert check.set_to_zero == ("/systems/electrical/outputs/flaps",)
    assert any(s.startswith("Set to 0,") and s.endswith("outputs/flaps.") for s in sentences)
    (warning,) = (s for s in sentences if s.startswith("Warning"))
    assert warning.startswith("Warning: the rolling moment rises with sideslip at ")
    assert warning.endswith("KCAS.")
