"""The loop closes: what is found is patched, judged again, and what a patch is unsure of is no gap."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from pitotbench import BadInputError, Case, fly, reconcile, sense
from pitotbench.bench import closing, workflow
from pitotbench.cli import reconcile as command
from pitotbench.cli.app import main
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.models.coefficients import measured_coefficients
from pitotbench.reconciliation.equations import whitened_equations
from pitotbench.reconciliation.layout import lay_out, of_patch
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.patches import is_settled, require_choice, with_choice
from pitotbench.records.calibration import Estimate
from pitotbench.records.case import EffectSpec
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import PatchErrors
from pitotbench.records.verdict import Candidate, Gap
from pitotbench.sensing.recorder import with_listed_mass
from pitotbench.show.gap_words import closing_sentences, sentences
from pitotbench.show.verdict import account_json
from pitotbench.simulation import variant
from pitotbench.simulation.modified import (
    FORM,
    install_variant,
    loaded_mass,
    patch_errors,
    patched_mass,
)

KEY = ("belly_pod", "drag_area_m2")
HIDDEN = (
    EffectSpec("belly_pod", {"drag_area_m2": 0.3}),
    EffectSpec("temperature_bias", {"bias_k": 4.0}),
)


@pytest.fixture(scope="module")
def log() -> FlightLog:
    """A foreign log, without a card, of an airplane with a pod and a bad thermometer."""
    case = Case(maneuver="rapid_decel", turbulence="none", truth_seed=21, effects=HIDDEN)
    return replace(sense(fly(case), "20/5"), header={})


@pytest.fixture(scope="module")
def closed(log, tmp_path_factory):
    """The answer for the log with its loop closed, the folder, and the log laid out for every effect
    of the navajo, as the answer's first round does.
    """
    folder, layouts = tmp_path_factory.mktemp("closed"), []

    def kept(*question):
        layouts.append(lay_out(*question))
        return layouts[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(workflow, "lay_out", kept)
        return reconcile(log, close="found", refly=False), folder, layouts[0]


@pytest.fixture(scope="module")
def layout(closed):
    return closed[2]


def gap(name: str, *sizes: Estimate, closes: float = 0.4) -> Gap:
    return Gap("drag", 0.9, (Candidate(name, sizes, 30.0),), True, True, closes, closes)


def install(shelf: Path, area: float, bound: float) -> Path:
    pod = EffectSpec("belly_pod", {"drag_area_m2": area})
    told = {"two_sigma": {"belly_pod": {"drag_area_m2": bound}}}
    return install_variant("navajo", "pod", [pod], told, shelf, anew=True)


def test_the_airplane_gets_what_is_its_own_and_the_loop_ends(closed, monkeypatch):
    found, folder, _ = closed
    done = found.account.closing
    variant_file = folder / "aircraft" / "navajo+found" / "variant.toml"
    table = tomllib.loads(variant_file.read_text(encoding="utf-8"))
    patched = {each["name"]: each["parameters"] for each in table["effects"]}
    assert patched.keys() == {"belly_pod"}  # a thermometer is no airplane's
    bounds = table["provenance"]["two_sigma"]
    assert abs(patched["belly_pod"]["drag_area_m2"] - 0.3) < bounds["belly_pod"]["drag_area_m2"]
    assert [each.causes[0].name for each in done.reported] == ["temperature_bias"]
    assert done.closed == (pytest.approx(done.patched[0].closes_held_out),)
    assert done.verdict.closure.before < 0.5 * found.verdict.closure.before
    assert done.verdict.closure.share > 0.95  # what is left is the thermometer's
    assert {name for name, _ in found.account.entries} >= patched.keys()
    monkeypatch.chdir(folder)
    with pytest.raises(BadInputError, match="choose another name"):
        reconcile(Path("nowhere.csv"), close="found")  # before the log is read


def test_a_round_that_is_killed_leaves_the_airplane_of_the_round_before(tmp_path, monkeypatch):
    folder = install(tmp_path, 0.1, 0.01)
    before = (folder / "navajo+pod.xml").read_bytes()

    class Killed(BaseException):
        """Nothing catches it."""

    def kill(root, overlay):
        raise Killed

    monkeypatch.setattr(variant, "_insert", kill)
    with pytest.raises(Killed):
        install(tmp_path, 0.2, 0.01)
    monkeypatch.undo()
    assert (folder / "navajo+pod.xml").read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == ["navajo+pod"]
    install(tmp_path, 0.2, 0.01)
    assert (folder / "navajo+pod.xml").read_bytes() != before


def test_a_patched_mass_is_an_error_of_the_weight_sheet(tmp_path, monkeypatch):
    """The sheet, the fuel that is burnt to a logged mass, and the mass column of a flight lack it;
    the airplane has it.
    """
    monkeypatch.chdir(tmp_path)
    sheet = loaded_mass("navajo")
    for size in (50.0, 150.0):
        load = EffectSpec("mass", {"mass_kg": size})
        install_variant("navajo", "load", [load], anew=True)
        assert patched_mass("navajo+load") == size
        assert loaded_mass("navajo+load") == pytest.approx(sheet, abs=0.5)
    flown = fly(
        Case(aircraft="navajo+load", maneuver="rapid_decel", turbulence="none"), channels=()
    )
    assert flown["mass"][0] - with_listed_mass(flown)["mass"][0] == pytest.approx(150.0)


def test_the_errors_of_patches_add_up_along_the_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    install(Path("aircraft"), 0.1, 0.02)
    load = EffectSpec("mass", {"mass_kg": 50.0})
    told = {"two_sigma": {"mass": {"mass_kg": 8.0}, "pitot_lag": {"lag_s": 0.1}}}
    install_variant("navajo+pod", "load", [load], told)
    mass = ("mass", "mass_kg")
    assert patch_errors("navajo") == PatchErrors()
    assert patch_errors("navajo+pod") == PatchErrors({KEY: 0.1}, {(KEY, KEY): 1e-4}, {KEY: FORM})
    both = patch_errors("navajo+pod+load")
    assert both.sizes == {KEY: 0.1, mass: 50.0}
    assert both.covariance == {(KEY, KEY): 1e-4, (mass, mass): 16.0}


def test_what_two_patches_change_alike_adds_up_with_its_covariance(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    install(Path("aircraft"), 0.1, 0.02)
    sizes = {"belly_pod": {"drag_area_m2": 0.05}, "mass": {"mass_kg": 20.0}}
    told = {
        "two_sigma": {"belly_pod": {"drag_area_m2": 0.02}, "mass": {"mass_kg": 4.0}},
        "covariance": {"belly_pod drag_area_m2, mass mass_kg": -0.01},
        "form": {"belly_pod": 0.3},
    }
    install_variant("navajo+pod", "more", [EffectSpec(*each) for each in sizes.items()], told)
    found = patch_errors("navajo+pod+more")
    assert found.sizes[KEY] == pytest.approx(0.15)
    assert found.covariance[KEY, KEY] == pytest.approx(2e-4)
    assert found.covariance[KEY, ("mass", "mass_kg")] == -0.01
    assert found.forms == {KEY: 0.3, ("mass", "mass_kg"): FORM}


def test_what_a_patch_is_unsure_of_is_no_evidence_and_more_is(layout):
    model = aircraft_model("navajo")
    null = theoretical_distribution(layout)

    def power(deviation: float, size: float = 0.0, form: float = 0.0) -> float:
        errors = PatchErrors({KEY: size}, {(KEY, KEY): deviation**2}, {KEY: form})
        more = of_patch(replace(model, errors=errors), layout.signatures, layout.shapes)
        kept = {name: each for name, each in more.items() if each[1] > 0.0}
        there = replace(layout, free=layout.free.with_columns(kept))
        column = layout.signatures.index(next(s for s in layout.signatures if s.effect == KEY[0]))
        return float(whitened_equations(there, null.noise).inner[column, column])

    plain = power(0.0)
    # Columns of power A with a size of deviation d: what is left of it is A / (1 + A d²).
    assert power(0.01) == pytest.approx(plain / (1.0 + plain * 1e-4), rel=1e-6)
    # A form that may be off takes more of a column than its size alone, and not all of it.
    assert 0.01 * power(0.01) < power(0.01, 0.3, 0.2) < 0.9 * power(0.01)


def test_a_term_of_the_file_is_told_as_its_coefficient(layout):
    gaps = [gap("lift_slope", Estimate("change", -0.2, 0.04)), gap("belly_pod")]
    (told,) = measured_coefficients("navajo", layout.reference.force_model.coarse, gaps)
    assert (told.effect, told.parameter) == ("lift_slope", "change")
    model = told.model
    assert model == pytest.approx(5.0, rel=0.01)  # C_L by angle of attack, in its file
    assert told.measured == Estimate(
        "per rad", pytest.approx(0.8 * model), pytest.approx(0.04 * model)
    )


def with_gap(found, gap):
    """A reconciliation whose only gap is this one."""
    judged = replace(found.judged, verdict=replace(found.judged.verdict, gaps=(gap,)))
    return replace(found, judged=judged)


POD = Candidate("belly_pod", (Estimate("drag_area_m2", 0.3, 0.02),), 30.0, 0.4)
TURN = Candidate("turn_drag", (Estimate("coefficient_at_30deg", 0.01, 0.001),), 30.0, 0.5)
EITHER = Gap("drag", 0.9, (TURN, POD), False, True, 0.9, 0.9)


def test_a_size_beyond_its_range_is_told_and_not_patched(closed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    large = gap("belly_pod", Estimate("drag_area_m2", 9.0, 0.2))
    done = closing.close_loop(with_gap(closed[0], large), "large", refly=False).account.closing
    (line,) = done.cut
    assert "not patched: drag_area_m2 comes out at 9 ± 0.2, and its range ends at 0.8" in line
    assert not done.patched
    assert not Path("aircraft").exists()


def test_of_a_set_nothing_is_patched_and_the_maneuver_that_tells_is_named(
    closed, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    found = closing.close_loop(with_gap(closed[0], EITHER), "either", refly=False)
    assert "turn_drag, belly_pod" in found.account.closing.not_told
    assert "fly" in found.account.closing.not_told
    assert not Path("aircraft").exists()
    monkeypatch.setattr(command, "_outcome", lambda options: found)
    assert main(["reconcile", "a.csv", "--close", "either"]) == 3
    said = capsys.readouterr()
    assert "to tell turn_drag, belly_pod apart" in said.err
    assert "The loop closed" not in said.out


def test_the_user_chooses_a_cause_of_the_set_alone():
    assert [c.name for c in with_choice(EITHER, "belly_pod").causes] == ["belly_pod", "turn_drag"]
    assert is_settled(with_choice(EITHER, "belly_pod"), "belly_pod")
    assert not is_settled(EITHER, "belly_pod")
    require_choice([EITHER], "belly_pod")
    for other in ("pitot_lag", "wing"):
        with pytest.raises(BadInputError, match="choose one of turn_drag, belly_pod"):
            require_choice([EITHER], other)
    with pytest.raises(BadInputError, match="no set"):
        require_choice([gap("belly_pod", *POD.sizes)], "belly_pod")


def test_a_chosen_cause_is_patched_and_the_answer_says_who_chose(closed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = with_gap(closed[0], EITHER)
    found = replace(found, account=replace(found.account, chosen="belly_pod", closing=None))
    monkeypatch.setattr(closing, "_judged_again", lambda logs, *rest: (logs, quiet(closed[0])))
    done = closing.close_loop(found, "chosen", refly=False)
    text = Path("aircraft/navajo+chosen/variant.toml").read_text(encoding="utf-8")
    table = tomllib.loads(text)
    assert [each["name"] for each in table["effects"]] == ["belly_pod"]
    assert table["provenance"]["chosen"] == "belly_pod"
    assert "belly pod was chosen by the user" in " ".join(sentences(done.account))
    assert account_json(done.account)["chosen"] == "belly_pod"
    (line,) = [each for each in closing_sentences(done.account.closing) if "no significant" in each]
    assert "does not prove the names" in line


def quiet(found):
    """The judgment of a reconciliation without its gaps."""
    verdict = replace(found.judged.verdict, kind="no_gap", gaps=())
    return replace(found.judged, verdict=verdict)


def test_the_form_of_one_of_a_set_is_as_open_as_the_set():
    pod, drag = (Candidate(name, (), 9.0, 0.4) for name in ("belly_pod", "turn_drag"))
    assert closing._form(Gap("drag", 0.9, (pod,), True, True, 0.5, 0.5)) == FORM
    both = Gap("drag", 0.9, (drag, pod), False, True, 0.5, 0.5)
    assert closing._form(both) == pytest.approx(0.5, abs=0.01)


def test_a_later_round_adds_to_the_sizes_of_an_earlier_one():
    first = gap("belly_pod", Estimate("drag_area_m2", 0.2, 0.02))
    later = gap("belly_pod", Estimate("drag_area_m2", -0.05, 0.01), closes=0.1)
    other = gap("drag_formula", Estimate("bank", 0.1, 0.01))
    more = gap("drag_formula", Estimate("mach", 0.3, 0.02))
    joined = closing._joined([first, other, more, later])
    assert joined["belly_pod"].causes[0].sizes == (
        Estimate("drag_area_m2", pytest.approx(0.15), 0.01),
    )
    assert joined["belly_pod"].closes_held_out == pytest.approx(0.5)
    assert [size.name for size in joined["drag_formula"].causes[0].sizes] == ["bank", "mach"]


def test_the_loop_of_no_airplane_is_refused():
    with pytest.raises(BadInputError, match="name the aircraft"):
        reconcile("nowhere.csv", aircraft="none", close="found")


@pytest.mark.parametrize(
    ("name", "lasts"),
    [
        ("belly_pod", True),
        ("power_deficit", True),
        ("turbulence_level", False),  # the air's
        ("pitot_lag", False),  # a sensor's
    ],
)
def test_only_what_the_airplane_keeps_is_patched_into_it(name: str, lasts: bool) -> None:
    """Gusts that differ from the card's beside a pod ended the loop with a refusal."""
    assert closing._is_lasting(name) is lasts
