"""The blind test itself: nothing leaks, the seal holds, the score counts; and a small set judged by its sensors."""

import json
from pathlib import Path

import numpy as np
import pytest
from tests.blind.analyze import analyze
from tests.blind.draw import KINDS, kinds
from tests.blind.generate import generate, orders
from tests.blind.rows import Judged, table, wilson
from tests.blind.score import opened, score

from pitotbench.logbook import read_log

SEED, CASES = 9101, 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("blind")
    generate(CASES, SEED, 1, made / "logs", made / "seal")
    return made


def test_logs_tell_nothing_of_the_truth(folder: Path) -> None:
    paths = sorted((folder / "logs").glob("*.parquet"))
    assert len([p for p in paths if "held" not in p.stem]) == CASES
    for path in paths:
        assert set(read_log(path).header) <= {"format", "case"}
        assert not {"effects", "wind", "pressure_error", "truth_seed"} & set(read_log(path).header["case"])


def test_a_broken_seal_is_noticed(folder: Path, tmp_path: Path) -> None:
    assert len(opened(folder / "seal")["cases"]) == CASES
    text = (folder / "seal" / "truth.json").read_text("utf-8")
    (tmp_path / "truth.json").write_text(text.replace('"seed": 9101', '"seed": 9102'), encoding="utf-8")
    (tmp_path / "truth.sha256").write_text((folder / "seal" / "truth.sha256").read_text("utf-8"), encoding="utf-8")
    with pytest.raises(ValueError, match="seal"):
        opened(tmp_path)


def test_a_small_set_is_judged_without_a_wrong_name(folder: Path) -> None:
    analyze(folder / "logs", folder / "results.jsonl", 1, "none")
    rows = {r.what: r for r in score(folder / "results.jsonl", folder / "seal", folder / "docs")}
    assert rows["a case within 60 s"].cases == CASES
    assert rows["wrong single name, any band"].hits == 0
    assert rows["false alarm on none"].hits == 0
    assert "SHA-256" in (folder / "docs" / "blind.md").read_text("utf-8")


def test_seeds_of_development_and_scored_seeds_never_meet(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="development"):
        generate(10, 9995, 1, tmp_path / "logs", tmp_path / "seal")


def test_a_third_of_the_logs_hold_a_variant_form_and_every_kind_comes() -> None:
    drawn = orders(300, 77)
    forms = [o for o in drawn if o.environment != "usual" or any(n in json.dumps(VARIANTS) for n, _ in o.effects)]
    assert len(forms) >= 0.3 * len(drawn)
    assert set(kinds(np.random.default_rng(1), 300)) == set(KINDS)


VARIANTS = ["second_order_line", "creep", "polar_bend", "inclined_pod", "gps_smoothing", "friction_loss"]


def test_wilson_is_the_published_interval() -> None:
    low, high = wilson(8, 10)  # Agresti and Coull 1998: 0.49 to 0.94
    assert (low, high) == (pytest.approx(0.490, abs=0.001), pytest.approx(0.943, abs=0.001))


def answer(kind: str, *groups: list[str]) -> dict[str, object]:
    effects, others = [g[0] for g in groups], [g[1:] for g in groups]
    told = {"kind": kind, "effects": effects, "alternatives": others, "sizes": {}, "gains": {}, "gap": 0.0}
    return {**told, "wall_s": 1.0, "name": "log-0001"}


def test_answers_are_counted_as_they_are() -> None:
    hidden = {"kind": "above 7", "effects": [["second_order_line", {"lag_s": 0.4}]]}
    found = {
        "right": answer("named", ["pitot_lag"]),
        "set": answer("one_of", ["static_lag", "pitot_lag"]),
        "wrong": answer("named", ["belly_pod"]),
        "silent": answer("unknown"),
    }
    rows = {r.what: r.hits for r in table([Judged(hidden, a) for a in found.values()])}
    assert rows["right name, SNR above 7"] == 1
    assert rows["truth in the reported set, where effects are reported"] == 2
    assert rows["wrong single name, any band"] == 1
    assert rows["needless abstention (unknown, no gap), SNR above 7"] == 1


def test_the_committed_score_follows_from_the_committed_truth_and_answers(tmp_path: Path) -> None:
    docs = Path(__file__).parents[2] / "docs"
    score(docs / "blind" / "results.jsonl", docs / "blind", tmp_path)
    assert (tmp_path / "blind.csv").read_text("utf-8") == (docs / "blind.csv").read_text("utf-8")
    assert (docs / "blind" / "truth.sha256").read_text("utf-8").strip() in (docs / "blind.md").read_text("utf-8")
