"""The experiment engine: every reduction of every flight once, kept rows not measured again."""

from functools import partial

import pandas as pd
import pytest

from pitotlab.experiment import Budget, Experiment, made_with, run_experiment

SEEN = []


def measure(trial, reductions, factor=1.0, breaks_at=None):
    SEEN.append((trial.maneuver, trial.seed, reductions))
    if trial.seed == breaks_at:
        raise ZeroDivisionError("a defect")
    cell = {"maneuver": trial.maneuver, "turbulence": trial.turbulence, "seed": trial.seed}
    return [
        cell | {"das": reduction, "part": part, "value": factor * trial.seed}
        for reduction in reductions
        for part in (1, 2)
    ]


def experiment(reductions=("20/1",), **how):
    work = partial(measure, **how)
    return Experiment(work, ("circle", "four_leg"), ("light",), reductions, "das")


@pytest.fixture(autouse=True)
def _nothing_measured():
    SEEN.clear()


def test_every_look_at_every_flight_is_one_row_or_more_seed_by_seed():
    table = run_experiment(experiment(("20/1", "50/50")), [5, 3], Budget(jobs=1))
    assert [(m, s) for m, s, _ in SEEN] == [
        (maneuver, seed) for seed in (5, 3) for maneuver in ("circle", "four_leg")
    ]
    assert len(table) == 2 * 2 * 2 * 2
    assert table["seed"].tolist() == [5] * 8 + [3] * 8


def test_kept_rows_are_not_measured_again(tmp_path):
    budget = Budget(jobs=1, rows=tmp_path / "new" / "rows.parquet")
    run_experiment(experiment(), [1], budget)
    SEEN.clear()
    table = run_experiment(experiment(("20/1", "50/50")), [1, 2], budget)
    seen = {(seed, reductions) for _, seed, reductions in SEEN}
    assert seen == {(1, ("50/50",)), (2, ("20/1", "50/50"))}
    assert table.groupby(["maneuver", "seed", "das"]).size().eq(2).all()
    assert len(table) == 2 * 2 * 2 * 2


def test_rows_of_other_experiments_in_the_file_are_kept_and_not_returned(tmp_path):
    budget = Budget(jobs=1, rows=tmp_path / "rows.parquet")
    run_experiment(experiment(("20/1", "50/50")), [1, 2], budget)
    SEEN.clear()
    table = run_experiment(experiment(("50/50",)), [2], budget)
    assert not SEEN
    assert set(table["seed"]) == {2}
    assert set(table["das"]) == {"50/50"}
    assert len(pd.read_parquet(budget.rows)) == 16


def test_an_error_ends_the_experiment_and_the_rounds_before_it_are_kept(tmp_path):
    budget = Budget(jobs=1, rows=tmp_path / "rows.parquet")
    with pytest.raises(RuntimeError, match="ZeroDivisionError: a defect"):
        run_experiment(experiment(breaks_at=3), [1, 2, 3], budget)
    assert set(pd.read_parquet(budget.rows)["seed"]) == {1, 2}
    assert [path.name for path in tmp_path.iterdir()] == ["rows.parquet"]


def test_no_minutes_end_it_after_the_first_round():
    table = run_experiment(experiment(), range(1, 9), Budget(jobs=1, minutes=0.0))
    assert set(table["seed"]) == {1, 2}


def test_processes_change_nothing():
    measured = partial(run_experiment, experiment(factor=0.1), range(1, 5))
    alone, shared = (measured(Budget(jobs=jobs)) for jobs in (1, 2))
    pd.testing.assert_frame_equal(alone, shared, check_exact=True)


def test_provenance_names_versions_and_date():
    assert all(word in made_with() for word in ("pitotbench ", "JSBSim ", "20"))
