"""The ablation: a step off and on again leaves nothing behind, a replay equals a judgment, and the
table counts.
"""

from dataclasses import asdict
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotlab.blind.ablation import (
    COMPLETE,
    FIRST_LOOK,
    PROPER,
    STEPS,
    counts,
    judged,
    table,
    thresholds,
)
from pitotlab.blind.analyze import judge
from pitotlab.blind.case import JudgedCase
from pitotlab.blind.flown_again import flown_log
from pitotlab.blind.sealed import KEPT, opened

TRUTH = {
    "name": "a",
    "kind": "above 7",
    "settings": ["K"],
    "effects": [{"name": "pitot_lag", "strengths": [20.0]}],
}


def answer(step: str, name: str = "a", **probabilities: float) -> dict[str, object]:
    named = [cause for cause, p in probabilities.items() if p > 0.9]
    effects = {"effects": named, "alternatives": [[] for _ in named]}
    kind = "named" if named else "no_gap"
    asked = {"name": name, "aircraft": "none", "step": step, "beside": COMPLETE}
    return asked | {"kind": kind, "probabilities": probabilities} | effects


def test_every_step_changes_something_that_exists():
    for step in STEPS.values():
        for path in step.functions:
            *modules, name = path.split(".")
            try:
                owner = import_module(".".join(modules))
            except ModuleNotFoundError:
                owner = getattr(import_module(".".join(modules[:-1])), modules[-1])
            assert hasattr(owner, name), path
    assert all(
        STEPS[name].functions or STEPS[name].thresholds or STEPS[name].of_null
        for name in STEPS
        if name != COMPLETE
    )


@pytest.mark.parametrize("name", STEPS)
def test_thresholds_are_as_before_after_a_step(name):
    before = asdict(THRESHOLDS)
    with thresholds(STEPS[name].thresholds):
        assert all(
            getattr(THRESHOLDS, key) == value for key, value in STEPS[name].thresholds.items()
        )
    assert asdict(THRESHOLDS) == before


def test_a_replay_equals_a_judgment_of_its_own(tmp_path: Path):
    case = next(c for c in opened(KEPT / "eleventh.tar.xz")["cases"] if c["name"] == "log-0342")
    path = tmp_path / "log-0342.parquet"
    log, steps = (
        flown_log(path, case),
        ("temper", "sensor effects taken out", "all doubt", FIRST_LOOK),
    )
    replayed = {each["step"]: each for each in judged("log-0342", log, steps, aircraft="none")}
    for step in (COMPLETE, *steps):
        with thresholds(STEPS[step].thresholds):
            alone = judge([path], "none")
        assert replayed[step]["kind"] == alone["kind"]
        assert replayed[step]["probabilities"] == pytest.approx(alone["probabilities"])
        assert replayed[step]["sizes"] == alone["sizes"]
    assert replayed["all doubt"]["probabilities"] != pytest.approx(
        replayed[COMPLETE]["probabilities"]
    )


def test_the_table_holds_paired_differences():
    truth = {
        "a": TRUTH,
        "b": {**TRUTH, "name": "b"},
        "n": {**TRUTH, "name": "n", "kind": "none", "effects": []},
    }
    whole = [answer(COMPLETE, n, pitot_lag=p) for n, p in (("a", 0.95), ("b", 0.8))] + [
        answer(COMPLETE, "n")
    ]
    off = [answer("all doubt", "a", pitot_lag=0.8), answer("all doubt", "n", mass=0.95)]
    complete, temper = table(truth, [*whole, *off])
    assert (complete["logs"], complete["named_right"], complete["false_alarms"]) == (3, 1, 0)
    assert float(complete["log_causes"]) == pytest.approx(-0.5 * np.log(0.95 * 0.8), abs=1e-4)
    assert [temper[n] for n in ("logs", "named_right", "false_alarms", "answers_changed")] == [
        2,
        -1,
        1,
        2,
    ]
    assert float(temper["log_causes"]) == pytest.approx(np.log(0.95 / 0.8), abs=1e-4)


def test_a_log_with_nothing_hidden_has_no_proper_score():
    nothing = JudgedCase({**TRUTH, "kind": "none", "effects": []}, answer(COMPLETE))
    assert counts([nothing]).proper.shape == (0, len(PROPER))
