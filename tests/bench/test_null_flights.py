"""The cache of null flights: whatever stands in it, a log is judged by flights of its card and this
code.
"""

import json
import operator
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from functools import reduce
from pathlib import Path

import numpy as np
import pytest

from pitotbench import BadInputError, Case, FlightLog
from pitotbench.bench import null_cache, null_flights, null_tables, workflow
from pitotbench.bench.null_cache import MOST_KEPT
from pitotbench.bench.null_flights import announce_flights, null_distribution_of
from pitotbench.bench.workflow import NamedLog, judge_logs
from pitotbench.campaigns import digests
from pitotbench.campaigns.digests import NOT_DECIDING
from pitotbench.campaigns.fleet import open_fleet
from pitotbench.cli.app import main
from pitotbench.logbook import reading
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import (
    Measure,
    NullDistribution,
    ScoreScale,
    read_distribution,
    text_of,
)
from pitotbench.records.case import EffectSpec
from pitotbench.simulation.aircraft import PACKAGE
from pitotbench.simulation.modified import install_variant

TEN = np.arange(1.0, 11.0)
NOISE = NoiseModel(
    ("one", "two"), np.array([[0.5, 0.1], [0.3, 1 / 3]]), np.array([1.0, 0.1]), np.eye(2)
)
SCORES = ScoreScale({"pod": 0.3}, {"pod": 1.1}, {"one||time": -0.2}, {"one||time": 1.0})
NULL = NullDistribution(
    *(NOISE, SCORES, 3.9, 4.4, 8),
    *(Measure(-1.0, 0.1), {"one": Measure(0.0, 0.2)}, {"two": Measure(1.0, 0.3)}),
)
CARD = Case(maneuver="circle")
LOG = FlightLog(
    **dict.fromkeys(
        ("time", "impact_pressure", "static_pressure", "velocity_north", "velocity_east"), TEN
    )
)


@pytest.fixture
def flown(monkeypatch, tmp_path) -> list[AnalysisSetting]:
    """An empty cache, and flights that cost nothing: the setting in which each was laid out."""
    found: list[AnalysisSetting] = []
    monkeypatch.setenv("PITOTBENCH_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(null_tables, "FOLDER", tmp_path / "no tables")
    monkeypatch.setattr(null_flights, "open_fleet", lambda tasks: open_fleet(jobs=1, tasks=tasks))
    monkeypatch.setattr(
        null_flights, "_null_layout", lambda card, setting, number: found.append(setting)
    )
    monkeypatch.setattr(
        null_flights,
        "learn_null_distribution",
        lambda layouts, perform: replace(NULL, flights=len(layouts)),
    )
    return found


def entries(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "cache").glob("*")) if (tmp_path / "cache").is_dir() else []


def same(one: NullDistribution, other: NullDistribution) -> bool:
    return text_of(one) == text_of(other)


def test_a_null_distribution_reads_back_bit_for_bit():
    back = read_distribution(text_of(NULL))
    assert same(back, NULL)
    assert back.noise.names == NULL.noise.names
    assert np.array_equal(back.noise.coefficients, NOISE.coefficients)
    assert back.gust_level == NULL.gust_level


def test_a_card_is_flown_once(flown, tmp_path):
    first, second = null_distribution_of(CARD), null_distribution_of(CARD)
    assert len(flown) == 8
    assert same(first, second)
    assert [file.suffix for file in entries(tmp_path)] == [".json"]


GOOD = json.loads(text_of(NULL))


def changed(*path: str, to: object) -> bytes:
    """The document with another value at a path of keys."""
    document = json.loads(text_of(NULL))
    place = reduce(operator.getitem, path[:-1], document)
    place[path[-1]] = to
    return json.dumps(document).encode()


SPOILED = {
    "empty": b"",
    "cut": text_of(NULL).encode()[:-40],
    "binary": bytes(range(256)),
    "another document": b"[1, 2]",
    "a key less": json.dumps({k: v for k, v in GOOD.items() if k != "spectral_lines"}).encode(),
    "a threshold that is no number": changed("threshold", to=float("nan")),
    "an infinite threshold": changed("cell_threshold", to=float("inf")),
    "a threshold of zero": changed("threshold", to=0.0),
    "a threshold of text": changed("threshold", to="x"),
    "a number as text": changed("threshold", to="3.9"),
    "a spread of zero": changed("scores", "effect_spread", to={"pod": 0.0}),
    "a deviation of zero": changed("spectral_lines", to={"one": {"mean": 0.0, "deviation": 0.0}}),
    "a mean that is no number": changed("scores", "cell_mean", to={"one||time": float("nan")}),
    "noise of another size": changed("noise", "deviations", to=[1.0]),
    "a lasting score that is no number": changed("scores", "lasting", to={"pod": float("nan")}),
    "a lasting score without products": changed("scores", "lasting", to={"pod": 1.0}),
    "ragged noise": changed("noise", "coefficients", to=[[0.1], [0.1, 0.2]]),
    "other flights": changed("flights", to=4),
    "a folder": None,
}


@pytest.mark.parametrize("content", SPOILED.values(), ids=SPOILED.keys())
def test_a_spoiled_entry_is_flown_again_and_replaced(
    flown, tmp_path, content: bytes | None
) -> None:
    null_distribution_of(CARD)
    (place,) = entries(tmp_path)
    place.unlink()
    if content is None:
        place.mkdir()
    else:
        place.write_bytes(content)
    said: list[str] = []
    assert same(null_distribution_of(CARD, progress=said.append), NULL)
    assert len(flown) == 16
    if content is not None:
        assert "flown again" in said[0]
        assert same(read_distribution(place.read_bytes()), NULL)


def test_a_cache_that_cannot_be_written_costs_no_answer(flown, tmp_path):
    (tmp_path / "cache").write_text("a file where the folder should be")
    said: list[str] = []
    assert same(null_distribution_of(CARD, progress=said.append), NULL)
    assert "not kept" in said[-1]


def test_a_number_that_is_not_finite_is_never_written(flown, tmp_path, monkeypatch):
    monkeypatch.setattr(
        null_flights,
        "learn_null_distribution",
        lambda layouts, perform: replace(NULL, threshold=float("nan")),
    )
    null_distribution_of(CARD)
    assert entries(tmp_path) == []


def test_without_keeping_nothing_is_read_and_nothing_written(flown, tmp_path):
    null_distribution_of(CARD, keep=False)
    assert entries(tmp_path) == []
    null_distribution_of(CARD)
    null_distribution_of(CARD, keep=False)
    assert len(flown) == 24


def test_null_flights_are_laid_out_in_the_setting_of_the_log_and_kept_apart_by_it(flown, tmp_path):
    settings = [
        AnalysisSetting(day_known=True, **more)
        for more in ({}, {"static_error": True}, {"mach_max": 0.2})
    ]
    for setting in settings:
        null_distribution_of(CARD, setting=setting)
    assert flown[::8] == settings
    assert len(entries(tmp_path)) == 3


def test_the_key_holds_card_loading_flights_and_versions(flown, tmp_path, monkeypatch):
    for card in (
        CARD,
        replace(CARD, fuel=0.4),
        replace(CARD, ballast=50.0),
        replace(CARD, turbulence="none"),
    ):
        null_distribution_of(card)
    null_distribution_of(CARD, flights=6)
    for name in ("jsbsim", "numpy", "scipy"):
        monkeypatch.setattr(null_cache, "version", lambda asked, name=name: f"{asked == name}")
        null_distribution_of(CARD)
    assert len(entries(tmp_path)) == 8


def test_the_key_holds_the_files_of_the_aircraft(flown, tmp_path, monkeypatch):
    folder = tmp_path / "plane"
    (folder / "Engines").mkdir(parents=True)
    monkeypatch.setattr(digests, "find_aircraft", lambda name: folder)
    for text in ("<a/>", "<b/>"):
        (folder / "Engines" / "engine.xml").write_text(text)
        null_distribution_of(CARD)
    assert len(entries(tmp_path)) == 2


def test_no_module_that_the_conductor_loads_is_left_out_of_the_key():
    code = (
        "import sys, types\n"
        "package = types.ModuleType('pitotbench'); package.__path__ = [sys.argv[1]]\n"
        "sys.modules['pitotbench'] = package\n"  # without the public page, which names everything
        "import pitotbench.bench.workflow\n"
        "print(*{m.split('.')[1] for m in sys.modules if m.startswith('pitotbench.')})"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(PACKAGE)], capture_output=True, text=True, check=True
    )
    assert not set(done.stdout.split()) & set(NOT_DECIDING)


def test_a_change_of_code_that_judges_flies_again_and_one_of_a_page_does_not(
    flown, tmp_path, monkeypatch
):
    copy = tmp_path / "copy"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__", "aircraft"))
    monkeypatch.setattr(digests, "PACKAGE", copy)
    null_distribution_of(CARD)
    modules = {*copy.glob("*.py"), *copy.glob("*/__init__.py")}
    changed = sorted(file for file in modules if file.parent.name not in NOT_DECIDING)
    for count, file in enumerate(changed, start=2):
        file.write_text(file.read_text() + "\nADDED = 1\n")
        null_distribution_of(CARD)
        assert len(entries(tmp_path)) == count, file
    (copy / "show" / "style.py").write_text("")
    null_distribution_of(CARD)
    assert len(entries(tmp_path)) == len(changed) + 1


def test_two_runs_at_a_time_both_get_an_answer_and_one_entry_is_left(flown, tmp_path, monkeypatch):
    once = null_flights._null_layout

    def while_another_run_writes(card: Case, setting: AnalysisSetting, number: int) -> None:
        monkeypatch.setattr(null_flights, "_null_layout", once)
        if number == 3:
            assert same(null_distribution_of(card, setting=setting), NULL)

    monkeypatch.setattr(null_flights, "_null_layout", while_another_run_writes)
    assert same(null_distribution_of(CARD), NULL)
    assert len(entries(tmp_path)) == 1


def test_the_cache_is_bounded_and_the_entries_used_last_stay(flown, tmp_path):
    null_distribution_of(CARD)
    (used,) = entries(tmp_path)
    for i in range(MOST_KEPT + 5):
        old = (
            tmp_path
            / "cache"
            / (f"null-{i:024d}.json" if i % 10 else f".null-{i:024d}.json.0.part")
        )
        old.write_text("{}")
        os.utime(old, (1000.0 + i, 1000.0 + i))
    os.utime(used, (1.0, 1.0))
    null_distribution_of(CARD)  # used again: now it is younger than all the others
    null_distribution_of(replace(CARD, fuel=0.4))
    left = entries(tmp_path)
    assert len(left) == MOST_KEPT
    assert used in left
    assert not any(f.name.endswith((f"{6:024d}.json", f"{0:024d}.json.0.part")) for f in left)


def test_other_files_of_the_folder_are_not_touched(flown, tmp_path):
    """`$PITOTBENCH_CACHE` may be a folder that holds other things as well."""
    (tmp_path / "cache").mkdir()
    for i in range(MOST_KEPT + 5):
        (tmp_path / "cache" / f"flight-{i}.csv").write_text("")
    null_distribution_of(CARD)
    assert len(entries(tmp_path)) == MOST_KEPT + 6


@pytest.mark.parametrize(("flags", "keep"), [((), True), (("--no-cache",), False)])
def test_the_command_can_leave_the_cache_alone(
    monkeypatch, flags: tuple[str, ...], keep: bool
) -> None:
    asked: list[bool] = []

    def reconcile_fully(*_: object, keep: bool, **__: object) -> None:
        asked.append(keep)
        raise BadInputError("far enough")

    monkeypatch.setattr(workflow, "reconcile_fully", reconcile_fully)
    monkeypatch.setattr(reading, "read_log", lambda *_: LOG)
    assert main(["reconcile", "flight.csv", *flags]) == 2
    assert asked == [keep]


def test_a_reconciliation_hands_on_its_card_the_setting_and_keeping(monkeypatch):
    """Up to the null flights: nothing is flown. Without a model of the aircraft the mass of the log
    does not matter: it may be that of any airplane, and the card is flown for the noise of its
    sensors alone."""
    asked: list[tuple[Case, AnalysisSetting, bool]] = []

    def stop(
        card: Case, flights: int, progress: object, setting: AnalysisSetting, keep: bool
    ) -> None:
        asked.append((card, setting, keep))
        raise BadInputError("far enough")

    monkeypatch.setattr(workflow, "null_distribution_of", stop)
    jet = replace(LOG, mass=np.full(len(LOG), 20_000.0))
    for log, aircraft in ((LOG, "navajo"), (jet, "none")):
        named = [NamedLog("log", log, CARD)]
        with pytest.raises(BadInputError, match="far enough"):
            judge_logs(named, aircraft, setting=AnalysisSetting(static_error=True), keep=False)
    setting = AnalysisSetting(day_known=True, instruments_known=True, static_error=True)
    assert asked == [(CARD, setting, False)] * 2


def test_a_patched_airplane_is_judged_by_the_floor_of_the_airplane_before(tmp_path, monkeypatch):
    """Each patch cost the null flights of a card anew. Who edits an airplane by hand states no
    bounds: it is flown itself."""
    monkeypatch.chdir(tmp_path)
    pod = [EffectSpec("belly_pod", {"drag_area_m2": 0.15})]
    bounds = {"two_sigma": {"belly_pod": {"drag_area_m2": 0.02}}}
    install_variant("navajo", "pod", pod, bounds)
    install_variant("navajo+pod", "more", [EffectSpec("mass", {"mass_kg": 90.0})], bounds)
    install_variant("navajo", "edited", pod)
    asked: list[Case] = []

    def stop(card: Case, *_: object) -> None:
        asked.append(card)
        raise BadInputError("far enough")

    monkeypatch.setattr(workflow, "null_distribution_of", stop)
    for aircraft in ("navajo+pod+more", "navajo+edited"):
        card = replace(CARD, aircraft=aircraft)
        with pytest.raises(BadInputError, match="far enough"):
            judge_logs([NamedLog("log", LOG, card)], aircraft)
    assert asked == [CARD, replace(CARD, aircraft="navajo+edited")]


def test_the_time_that_is_left_is_told_while_null_flights_are_flown():
    lines: list[str] = []
    hours = iter((0.0, 30.0, 50.0, 90.0))
    tell = announce_flights(3, lines.append, lambda: next(hours))
    for _ in range(3):
        tell()
    left = (", about 60 s left", ", about 25 s left", "")
    assert lines == [
        f"null flight {number} of 3{said}" for number, said in enumerate(left, start=1)
    ]
