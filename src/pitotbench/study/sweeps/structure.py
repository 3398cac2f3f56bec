"""Can statistics choose the structure of the model?"""

from dataclasses import replace

import numpy as np
import pandas as pd

from pitotbench.show.chart import Bars, BarSeries
from pitotbench.study.evidence import USUAL, Evidence
from pitotbench.study.look import PAPER, Look
from pitotbench.study.names import NAMES, PAPER_ORDER
from pitotbench.study.sweeps.sweep import Reply, Sweep

MODELS = ("bias", "linear", "quadratic", "inverse+")
TRUTHS = {
    "constant truth": "bias",
    "linear truth": "linear",
    "quadratic truth": "quadratic",
    "none": "inverse+",
    "knee truth": "none of the table (a knee)",
}
_GOOD = 1.1  # times the smallest true error of any model
CRITERIA = {"white_criterion": "all samples, as if white", "block_criterion": "means of 5 s"}


def looks(maneuver: str) -> tuple[Look, ...]:
    """Every truth fitted with every model."""
    return tuple(
        Look("50/50", replace(PAPER, model=model), truth) for truth in TRUTHS for model in MODELS if truth != "none"
    )


def _table(evidence: Evidence) -> pd.DataFrame:
    """One row a flight and truth: the model each criterion chooses, and the true error of each model."""
    fits = evidence.fits
    usual = {**USUAL, "setting": "light"}
    for name in (
        "setting",
        "variant",
        "das",
        "method",
        "form",
        "wind",
        "down",
        "on_condition",
        "noise",
        "gps_noise",
    ):
        fits = fits[fits[name] == usual[name]]
    fits = fits[fits["change"].isin(TRUTHS) & (fits["failed"] == "")]
    few = fits[fits["change"] == "knee truth"]["seed"].unique()
    fits = fits[fits["seed"].isin(few)]
    rows = []
    for (truth, maneuver, seed), group in fits.groupby(["change", "maneuver", "seed"], sort=False):
        group = group.set_index("model").reindex(list(MODELS))
        row: dict[str, object] = {"truth": truth, "maneuver": maneuver, "seed": seed}
        row |= {f"rms {model}": group.loc[model, "rms_error_kt"] for model in MODELS}
        row |= {name: str(group[name].astype(float).idxmin()) for name in CRITERIA}
        rows.append(row)
    return pd.DataFrame(rows)


def _answer(evidence: Evidence) -> Reply:
    table = _table(evidence)
    errors = table[[f"rms {model}" for model in MODELS]].astype(float).to_numpy()
    best = errors.min(axis=1)
    share, cost = {}, {}
    lines = []
    for name, label in CRITERIA.items():
        chosen = errors[np.arange(len(table)), [MODELS.index(m) for m in table[name]]]
        right = table[name].to_numpy() == table["truth"].map(TRUTHS).to_numpy()
        known = (table["truth"] != "knee truth").to_numpy()
        share[name], cost[name] = 100.0 * right[known].mean(), float(np.sqrt(np.mean(chosen**2)))
        for truth, what in TRUTHS.items():
            of = (table["truth"] == truth).to_numpy()
            counts = table[of][name].value_counts()
            lines.append({"criterion": label, "truth": what,
                          **{f"{m} chosen [%]": f"{100.0 * counts.get(m, 0) / of.sum():.0f}" for m in MODELS},
                          "rms error, chosen [kt]": f"{np.sqrt(np.mean(chosen[of] ** 2)):.2f}",
                          "rms error, best model [kt]": f"{np.sqrt(np.mean(best[of] ** 2)):.2f}"})  # fmt: skip
    full = {m: float(np.sqrt(np.mean(errors[:, MODELS.index(m)] ** 2))) for m in MODELS}
    series = [
        BarSeries(model, [_rms(table, m, model) for m in PAPER_ORDER], [float("nan")] * len(PAPER_ORDER))
        for model in MODELS
    ]
    chart = Bars("True error by model, over all truths", "Light turbulence, 50/50 Hz, rms over seeds and five truths.",
                 "rms error of the curve [kt]", [NAMES[m] for m in PAPER_ORDER], series, "sweep-structure")  # fmt: skip
    return Reply(
        f"Schwarz's criterion names the true structure in {share['white_criterion']:.0f} % of flights when every sample "
        f"counts as independent and in {share['block_criterion']:.0f} % when means over 5 s do, with an rms error of "
        f"{cost['white_criterion']:.2f} and {cost['block_criterion']:.2f} kt over all truths. Always fitting Quadratic gives "
        f"{full['quadratic']:.2f} kt, Inverse+ {full['inverse+']:.2f} kt and Linear {full['linear']:.2f} kt: between the "
        "three-term models there is nothing to choose, and a model too many costs less than one too few.",
        (chart,),
        (pd.DataFrame(lines),),
    )


def _rms(table: pd.DataFrame, maneuver: str, model: str) -> float:
    values = table[table["maneuver"] == maneuver][f"rms {model}"].astype(float)
    return float(np.sqrt(np.mean(values**2)))


STRUCTURE = Sweep("model structure", "Can statistics choose the structure of the model?", _answer, looks)
