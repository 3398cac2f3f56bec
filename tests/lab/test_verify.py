"""A campaign cut short goes on: rows scored before are not scored again."""

import pandas as pd

from pitotlab import coverage as module
from pitotlab.coverage import SCORINGS
from pitotlab.experiment import FIRST_SCORED_SEED, Budget


def rows_of(trial, asked):
    shares = ("coverage", "band_coverage", "wind_coverage", "white_coverage")
    sizes = ("two_sigma", "mean_error", "rms_error", "paper_rms_error", "residual_two_sigma")
    figures = dict.fromkeys(shares, 1.0)
    figures |= {f"{name}_kt": 0.1 * (trial.seed % 3) for name in sizes}
    row = trial.cell | {"failed": ""} | figures
    return [row | {"scoring": s, "das": d} for s in asked for d in SCORINGS[s].systems]


def test_only_what_is_missing_is_scored(tmp_path, monkeypatch):
    seen = []

    def score(trial, asked):
        seen.append((trial.seed, tuple(asked)))
        return rows_of(trial, asked)

    monkeypatch.setattr(module, "score_trial", score)
    budget = Budget(jobs=1, rows=tmp_path / "rows.parquet")
    module.verify(2, tmp_path, budget, ["constant wind"])
    assert {seed for seed, _ in seen} == {FIRST_SCORED_SEED, FIRST_SCORED_SEED + 1}
    seen.clear()
    whole = module.verify(4, tmp_path, budget, ["constant wind", "slow wind"])
    assert {(s, a) for s, a in seen} == {
        (FIRST_SCORED_SEED, ("slow wind",)),
        (FIRST_SCORED_SEED + 1, ("slow wind",)),
        (FIRST_SCORED_SEED + 2, ("constant wind", "slow wind")),
        (FIRST_SCORED_SEED + 3, ("constant wind", "slow wind")),
    }
    assert whole.groupby(["scoring", "maneuver", "turbulence"]).seed.nunique().eq(4).all()
    assert pd.read_csv(tmp_path / "coverage.csv").flights.eq(4).all()
