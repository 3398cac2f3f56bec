"""The blind test itself: nothing leaks, the seal holds, bands and forms are as stated, and the
score counts.
"""

import ast
import json
import shutil
from dataclasses import asdict, replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest

import pitotbench
import pitotlab.blind
from pitotbench import calibration, estimation, reconciliation
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import SensorEffect
from pitotbench.effects.response import Signals
from pitotbench.logbook.reading import read_log
from pitotbench.records.case import EffectSpec
from pitotbench.simulation.aircraft_files import SimulationError
from pitotlab.__main__ import main
from pitotlab.blind import drawn as generator
from pitotlab.blind.analyze import analyze, flights_of
from pitotlab.blind.case import JudgedCase
from pitotlab.blind.flown import (
    LEAST,
    MOST,
    SETTINGS,
    Environment,
    flown,
    gust_field,
    lateral,
    longitudinal,
    recorded,
)
from pitotlab.blind.forms import OWN_FORMS
from pitotlab.blind.outsiders import OUTSIDERS, Part
from pitotlab.blind.score import table, tenths
from pitotlab.blind.sealed import judged_in, kept_sets, pack
from pitotlab.blind.signatures import SettingSignatures, all_effects, matched, quiet
from pitotlab.derivatives.files import AIRPLANES
from pitotlab.derivatives.generate import draw_cases, flown_log
from pitotlab.sealing import opened, seal, write_logs

SEED = 31_007
GENERATOR = Path(pitotlab.blind.__file__).parent
ANALYSIS = tuple(each.__name__ for each in (calibration, estimation, reconciliation))


def signatures(strength: float = 60.0) -> SettingSignatures:
    """Signatures in which every effect has one strength at its typical size."""
    names, time = tuple(all_effects()), np.arange(0.0, 140.0, 0.5)
    unit = np.full((len(names), len(time)), strength**2 / len(time))
    return SettingSignatures(names, time, np.full(len(names), strength), unit)


def written(folder: Path, cases, held) -> dict[str, str]:
    """Seal and write a set; return why some flights cannot be flown."""
    made = generator.seeded(SEED, cases, held)
    seal(folder / "seal", SEED, generator.told_of(made))
    return write_logs(folder, made, generator.SeededCase.flights)


def test_a_flight_that_its_effect_ends_is_told_and_has_no_log(tmp_path, monkeypatch):
    flown = []

    def departs(*given):
        flown.append(given)
        raise SimulationError("the aircraft departed")

    monkeypatch.setattr("pitotlab.blind.drawn.log_of", departs)
    nothing = generator.HiddenCase("none", ("C",), (), Environment())
    for _ in range(2):  # it is not flown again
        assert written(tmp_path, [nothing], [False]) == {"log-0000": "the aircraft departed"}
    assert len(flown) == 1
    assert not list((tmp_path / "logs").iterdir())


# The draws of two sets, to six digits, and the means of a log of each: impact and static pressure,
# velocity north, temperature. They are those with which the committed sets were flown.
DRAWN = {"blind": "c7a56ef58c07cf6d", "derivatives": "9ae19810fdcbcdc9"}
FLOWN = {
    "blind": (2883.12294, 81205.6247, -0.753069973, 279.006424),
    "derivatives": (1292.12012, 80463.3954, 35.7946424, 277.057905),
}


def in_six_digits(told):
    if isinstance(told, float):
        return float(f"{told:.6g}")
    if isinstance(told, dict):
        return {key: in_six_digits(value) for key, value in told.items()}
    return [*map(in_six_digits, told)] if isinstance(told, list | tuple) else told


def test_a_set_of_a_seed_is_drawn_and_flown_to_equal_digits():
    cases, held = drawn(77)
    edited = draw_cases(60_000, [*AIRPLANES], 2, 8)
    told = {"blind": [*map(asdict, cases), held], "derivatives": [*map(asdict, edited)]}
    digests = {
        k: sha256(json.dumps(in_six_digits(v)).encode()).hexdigest()[:16] for k, v in told.items()
    }
    assert digests == DRAWN
    one = generator.seeded(77, cases, held)["log-0024"]
    light = next(case for case in edited if case.airplane == "c172x")
    (_, log), *_ = replace(one, held=False).flights()
    for name, each in (("blind", log), ("derivatives", flown_log(light))):
        columns = (
            each.impact_pressure,
            each.static_pressure,
            each.velocity_north,
            each.total_temperature,
        )
        np.testing.assert_allclose([*map(np.mean, columns)], FLOWN[name], rtol=1e-7)


def drawn(seed: int, share: float = 1.0, letters: str = "ABCDEFGHIJKLMNO"):
    kinds = {kind: max(1, round(share * number)) for kind, number in generator.KINDS.items()}
    return generator.draw_set(
        np.random.default_rng(seed), kinds, list(letters), dict.fromkeys(letters, signatures())
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four cases of one setting, sealed and written, the last one of two flights with one held out."""
    made = tmp_path_factory.mktemp("blind")
    cases, _ = drawn(SEED, 0.01, "CK")
    chosen = [next(c for c in cases if c.kind == kind) for kind in ("none", "outside", "above 7")]
    chosen = [replace(c, settings=("C",), effects=tuple(replace(e, strengths=e.strengths[:1]) for e in c.effects))
              for c in chosen]  # fmt: skip
    chosen.append(replace(chosen[0], settings=("C", "K")))
    held = [False, False, True, False]
    assert not written(made, chosen, held)
    return made


def test_logs_tell_nothing_of_the_truth_nor_of_day_pilot_and_loading(folder: Path) -> None:
    paths = sorted((folder / "logs").glob("*.parquet"))
    assert {p.stem[4:] for p in paths} == {"0000", "0001", "0002", "0002-held", "0003", "0003-b"}
    hidden = {"effects", "wind", "pressure_error", "truth_seed", *generator.NOT_TOLD}
    assert hidden > {"pilot", "fuel", "ballast_kg", "temperature_offset_k"}
    for path in paths:
        header = read_log(path).header
        assert set(header) <= {"format", "case"}
        assert not hidden & set(header["case"])
    flights = flights_of(folder / "logs" / "log-0003.parquet")
    assert [path.stem for path in flights] == ["log-0003", "log-0003-b"]


def test_a_broken_seal_is_noticed(folder: Path, tmp_path: Path) -> None:
    assert len(opened(folder / "seal")["cases"]) == 4
    shutil.copytree(folder / "seal", tmp_path, dirs_exist_ok=True)
    truth = tmp_path / "truth.json"
    changed = truth.read_text("utf-8").replace(f'"seed": {SEED}', '"seed": 1', 1)
    truth.write_text(changed, encoding="utf-8")
    with pytest.raises(ValueError, match="seal"):
        opened(tmp_path)


def test_a_packed_set_holds_what_its_folder_held_and_a_change_is_noticed(
    folder: Path, tmp_path: Path
) -> None:
    answers = [{"name": f"log-000{i}", "kind": "no_gap"} for i in range(3)]
    lines = "".join(json.dumps(each) + "\n" for each in answers)
    (tmp_path / "results.jsonl").write_text(lines, encoding="utf-8")
    (tmp_path / "seal").symlink_to(folder / "seal")
    packed = [pack("first", tmp_path, tmp_path / place) for place in ("kept", "again")]
    assert packed[0].read_bytes() == packed[1].read_bytes()
    cases = judged_in(packed[0])
    assert [c.answer["name"] for c in cases] == ["log-0000", "log-0001", "log-0002"]
    assert cases == judged_in(tmp_path)
    packed[0].write_bytes(packed[0].read_bytes() + b"0")
    with pytest.raises(ValueError, match="SHA-256"):
        judged_in(packed[0])


def test_the_sets_that_are_kept_are_those_that_were_sealed() -> None:
    assert kept_sets()
    assert all(judged_in(place) for place in kept_sets())


def test_two_seals_of_one_truth_differ_by_their_salt(tmp_path: Path) -> None:
    cases, held = drawn(SEED, 0.01)
    told = generator.told_of(generator.seeded(SEED, cases, held))
    one, other = (seal(tmp_path / name, SEED, told) for name in "ab")
    assert one != other
    assert seal(tmp_path / "a", SEED, told) == one
    with pytest.raises(ValueError, match="another truth"):
        seal(tmp_path / "a", SEED, told[:-1])


def test_a_set_is_judged_again_where_it_was_stopped_and_scored(folder: Path, capsys) -> None:
    results = folder / "results.jsonl"
    analyze(folder / "logs", results, 1, "none")
    lines = results.read_text("utf-8").splitlines()
    assert sorted(json.loads(x)["name"] for x in lines) == [f"log-000{i}" for i in range(4)]
    results.write_text("\n".join(lines[:3]) + "\n", encoding="utf-8")
    analyze(folder / "logs", results, 1, "none")
    assert len(results.read_text("utf-8").splitlines()) == 4
    rows = {r.what: r for r in table(judged_in(folder))}
    assert rows["crash, refusal or no answer"].cases == 4
    assert rows["nothing hidden: an effect reported"].hits == 0
    assert main(["blind", "pooled", str(folder)]) == 0
    assert "\n4 cases\n" in capsys.readouterr().out


def test_seeds_of_development_and_scored_seeds_never_meet(tmp_path: Path) -> None:
    for seed in (29_999, 40_000, 700_000):
        with pytest.raises(ValueError, match="scored"):
            generator.generate(seed, 1, tmp_path)


def test_strengths_lie_in_their_bands_and_half_of_the_cases_have_a_form_of_their_own() -> None:
    cases, held = drawn(77)
    assert len(cases) >= 450
    assert sum(held) == generator.HELD_OUT
    assert {kind: sum(c.kind == kind for c in cases) for kind in generator.KINDS} == generator.KINDS
    for case in cases:
        for effect in case.effects:
            strength = float(np.sqrt(np.sum(np.square(effect.strengths))))
            if case.kind in ("4 to 7", "2 to 4"):
                low, high = generator.BANDS[case.kind]
                assert low - 0.02 <= strength <= high + 0.02
            elif case.kind != "counted":
                assert generator.LEAST_STRONG - 0.02 <= strength <= generator.STRONGEST + 0.02
            known = {**EFFECTS, **generator.HIDDEN_EFFECTS}[effect.name]
            assert all(known.parameter(k).low <= v <= known.parameter(k).high or known.parameter(k).shape
                       for k, v in effect.sizes.items())  # fmt: skip
    assert sum(c.formed for c in cases) >= 0.45 * len(cases)
    assert 0.75 <= sum(len(c.settings) == 1 for c in cases) / len(cases) <= 0.87
    assert any(e.part for c in cases for e in c.effects)


def test_most_settings_are_not_those_that_a_header_tells() -> None:
    assert len(SETTINGS) == 15
    assert sum(s.flown != s.told for s in SETTINGS.values()) >= 12
    assert all("pilot" not in generator.told_header(s)["case"] for s in SETTINGS.values())


def test_the_product_does_not_know_the_forms_and_the_forms_do_not_know_the_reconciler() -> None:
    files = Path(pitotbench.__file__).parent.rglob("*.py")
    product = "\n".join(file.read_text("utf-8") for file in files)
    assert [name for name in (*OWN_FORMS, *OUTSIDERS) if f'"{name}"' in product] == []
    for module in ("forms", "outsiders", "flown"):
        tree = ast.parse((GENERATOR / f"{module}.py").read_text("utf-8"))
        read = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
        assert [m for m in read if m.startswith(ANALYSIS)] == []


def flight_signals() -> Signals:
    """A flight in a turn that slows down and climbs, at 20 Hz."""
    time = np.arange(0.0, 200.0, 0.05)
    slow = 0.5 * (1.0 + np.cos(2.0 * np.pi * time / 160.0))
    draw = np.random.default_rng(5)
    wobble = np.cumsum(draw.standard_normal((6, len(time))), axis=1) * 0.001
    return Signals(
        time,
        {
            "impact_pressure": 1600.0 + 2400.0 * slow,
            "static_pressure": 81_000.0 - 900.0 * np.sin(2.0 * np.pi * time / 90.0),
            "total_temperature": 280.0 + 3.0 * slow + np.sin(time / 30.0),
            "velocity_north": 65.0 * np.cos(time / 20.0),
            "velocity_east": 65.0 * np.sin(time / 20.0),
            "velocity_down": np.sin(time / 15.0),
            "altitude": 1800.0 + 80.0 * np.sin(2.0 * np.pi * time / 90.0),
            "roll": 0.5 + wobble[0],
            "pitch": 0.08 - 0.06 * slow + wobble[1],
            "heading": np.mod(time / 20.0, 2.0 * np.pi),
            "roll_rate": wobble[2],
            "pitch_rate": wobble[3],
            "yaw_rate": 0.05 + wobble[4],
            "specific_force_x": 0.3 * np.sin(time / 25.0),
            "specific_force_y": wobble[5],
            "specific_force_z": -9.8 * (1.1 + 0.1 * np.sin(time / 12.0)),
            "angle_of_attack": 0.09 - 0.06 * slow,
            "sideslip": 0.01 * np.sin(time / 11.0),
            "throttle_left": 0.3 + 0.4 * slow,
            "throttle_right": 0.3 + 0.4 * slow,
            "elevator": 0.02 * slow,
            "rudder": 0.01 * np.sin(time / 11.0),
            "manifold_pressure_left": 6e4 + 3e4 * slow,
            "manifold_pressure_right": 6e4 + 3e4 * slow,
            "propeller_speed_left": 230.0 + 10.0 * slow,
            "propeller_speed_right": 230.0 + 10.0 * slow,
            "fuel_flow_left": 0.01 + 0.01 * slow,
            "fuel_flow_right": 0.01 + 0.01 * slow,
        },
    )


def change(effect: SensorEffect, signals: Signals) -> np.ndarray:
    moved = effect.apply(signals, effect.typical())
    parts = []
    for name in signals:
        scale = float(np.std(signals[name]))
        turn = np.pi if name == "heading" else np.inf
        difference = moved[name] - signals[name]
        parts.append(np.where(np.abs(difference) > turn, 0.0, difference) / scale)
    return np.concatenate(parts)


SENSED = [name for name, e in generator.HIDDEN_EFFECTS.items() if isinstance(e, SensorEffect)]


@pytest.mark.parametrize("name", SENSED)
def test_a_form_of_the_generator_is_no_form_of_the_table(name: str) -> None:
    """Its change of the signals is not that of any effect of the table times a number."""
    signals = flight_signals()
    own = change(generator.HIDDEN_EFFECTS[name], signals)
    assert np.linalg.norm(own) > 0.0
    for effect in EFFECTS.values():
        if not isinstance(effect, SensorEffect) or effect.after_noise:
            continue
        other = change(effect, signals)
        length = np.linalg.norm(own) * np.linalg.norm(other)
        if length > 0.0:
            assert abs(own @ other) < 0.9999 * length, effect.name


def test_a_part_of_the_flight_is_as_before_outside_it_and_gusts_and_steps_are_those_asked_for() -> (
    None
):
    case = replace(quiet(SETTINGS["C"]), effects=(EffectSpec("temperature_bias", {"bias_k": 2.0}),))
    flight = flown(replace(case, turbulence="light"), Environment(rate=60.0, own_gusts=True))
    assert np.median(np.diff(flight["time"])) == pytest.approx(1.0 / 60.0)
    assert 0.08 < np.std(flight["wind_down"]) < 0.4
    part = {"temperature_bias": Part(40.0, 90.0)}
    bare = replace(flight, case=replace(case, effects=()))
    with_it, without = (recorded(each, None, part) for each in (flight, bare))
    time = with_it.time - with_it.time[0]
    warmer = with_it.total_temperature - without.total_temperature
    assert np.all(warmer[(time < 40.0) | (time > 90.0)] == 0.0)
    assert warmer[(time > 44.0) & (time < 86.0)] == pytest.approx(2.0, abs=0.02)


def test_own_gusts_have_the_deviation_and_the_spectrum_of_von_karman() -> None:
    number = np.geomspace(2e-5, 5.0, 40_000)
    assert np.trapezoid(longitudinal(number), number) == pytest.approx(1.0, abs=0.02)
    assert np.trapezoid(lateral(number), number) == pytest.approx(1.0, abs=0.04)
    # Kolmogorov's law for short waves, and 4/3 as much energy across the flight as along it.
    one, two = longitudinal(np.array([1.0, 2.0]))
    assert two / one == pytest.approx(2.0 ** (-5.0 / 3.0), rel=1e-3)
    assert lateral(np.array(1.0)) / one == pytest.approx(4.0 / 3.0, rel=1e-3)
    fields = [gust_field(0.5, seed, 6_000.0).values for seed in range(16)]
    assert np.std(np.concatenate(fields), axis=0) == pytest.approx(0.5, rel=0.25)
    inside = np.geomspace(LEAST, MOST, 40_000)
    for spectrum, column in ((longitudinal, 0), (lateral, 1)):
        for apart in (5, 20, 80):
            waves = spectrum(inside) * (1.0 - np.cos(apart * inside))
            wanted = 2.0 * 0.25 * float(np.trapezoid(waves, inside))
            steps = [f[apart:, column] - f[:-apart, column] for f in fields]
            assert np.mean(np.square(steps)) == pytest.approx(wanted, rel=0.15)


def test_flights_are_matched_by_their_place_in_each_segment() -> None:
    segments, wanted = np.array(["a"] * 5 + ["b"] * 3), np.array(["a"] * 9 + ["b"] * 2)
    values = np.concatenate([np.linspace(0.0, 1.0, 5), [5.0, 6.0, 7.0]])
    assert matched(values, segments, wanted) == pytest.approx([*np.linspace(0.0, 1.0, 9), 5.0, 7.0])


def answer(kind: str, *groups: list[str], **more: object) -> dict[str, object]:
    told = {
        "kind": kind,
        "effects": [g[0] for g in groups],
        "alternatives": [g[1:] for g in groups],
    }
    usual = {"sizes": {}, "probabilities": {}, "warm": True, "name": "log-0001"}
    return {**told, **usual, "wall_s": 1.0, "processor_s": 1.0, **more}


def hidden(kind: str, *names: str, strength: float = 30.0) -> dict[str, object]:
    effects = [
        {"name": n, "sizes": {"lag_s": 0.4}, "strengths": [strength], "part": None} for n in names
    ]
    return {"kind": kind, "effects": effects, "settings": ["A"], "formed": False, "environment": {}}


def test_answers_are_counted_as_they_are() -> None:
    truth = hidden("above 7", "second_order_line")
    both, set_of = {"pitot_lag": 0.95, "wind_drift": 0.92}, {"static_lag": 0.5, "pitot_lag": 0.45}
    answers = [
        answer("named", ["pitot_lag"], probabilities={"pitot_lag": 0.95}, held_out=0.9),
        answer("named", ["pitot_lag"], ["wind_drift"], probabilities=both),
        answer("one_of", ["static_lag", "pitot_lag"], probabilities=set_of),
        answer("named", ["belly_pod"], probabilities={"belly_pod": 0.99}),
        answer("unknown"),
        {"kind": "crash", "name": "log-0001", "why": "", "processor_s": 1.0},
    ]
    cases = [JudgedCase(truth, a) for a in answers]
    rows = {r.what: r for r in table(cases)}
    named = rows["above 7, one flight: named cleanly"]
    assert (named.hits, named.cases) == (1, 6)
    assert rows["above 7, one flight: truth named or in the set"].hits == 3
    assert rows["wrong name, any band"].hits == 2
    assert rows["a second effect that was not hidden, of single effects named"].hits == 1
    assert rows["crash, refusal or no answer"].hits == 1
    sure = rows["probabilities above 0.9 that are right, the cause being in the table"]
    assert (sure.hits, sure.cases) == (2, 4)
    assert sum(n for _, n, _, _ in tenths(cases)) == 6
    assert rows["closure of the flight held out at least 0.8, of names that are right"].hits == 1


def test_pairs_outsiders_and_nothing_are_counted_as_they_are() -> None:
    two, outside = hidden("two", "pitot_lag", "gear_not_up"), hidden("outside", "loose_tube")
    cases = [
        JudgedCase(two, answer("named", ["belly_pod"], ["pitot_lag"])),
        JudgedCase(two, answer("one_of", ["belly_pod"], ["wind_drift", "static_lag"])),
        JudgedCase(outside, answer("named", ["pitot_lag"], formula={"closure": 0.9})),
        JudgedCase(outside, answer("unknown", formula=None)),
        JudgedCase(hidden("none"), answer("no_gap")),
        JudgedCase(hidden("none"), answer("unknown")),
    ]
    rows = {r.what: r for r in table(cases)}
    assert rows["two at once: both in the answer"].hits == 1
    assert rows["two at once: at least one"].hits == 2
    assert rows["outside the table: wrongly named"].hits == 1
    assert rows["outside the table: a formula closes at least 0.8"].hits == 1
    assert rows["nothing hidden: an answer other than no gap"].hits == 1


def test_a_variant_counts_as_its_cause_and_a_fault_outside_the_table_as_itself() -> None:
    assert generator.cause_of("speed_lag") == generator.cause_of("second_order_line") == "pitot_lag"
    assert all(generator.cause_of(name) == name and name not in EFFECTS for name in OUTSIDERS)
    assert len(OUTSIDERS) >= 45


@pytest.mark.parametrize(
    ("own", "named", "verdict"), [(True, True, "named"), (False, False, "named")]
)
def test_gusts_of_the_generator_are_no_cause_too_many(own: bool, named: bool, verdict: str) -> None:
    truth = {**hidden("above 7", "pitot_lag", strength=9.0), "environment": {"own_gusts": own}}
    told = answer("named", ["pitot_lag"], ["turbulence_level", "turbulence_scale"])
    judged = JudgedCase(truth, told)
    assert (judged.named, judged.verdict) == (named, verdict)
    nothing = JudgedCase({**truth, "kind": "none", "effects": []}, {**told, **NOTHING_BUT_GUSTS})
    assert nothing.verdict == ("no_gap" if own else "one_of")


NOTHING_BUT_GUSTS = answer("one_of", ["turbulence_level", "turbulence_scale"])
