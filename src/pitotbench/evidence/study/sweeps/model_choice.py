"""Can statistics choose the structure of the model?"""

from dataclasses import replace

import numpy as np
import pandas as pd

from pitotbench.bench.truth_comparison import rms
from pitotbench.evidence.pages.chart_data import Bars, BarSeries
from pitotbench.evidence.study.looks import PAPER, Look
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER
from pitotbench.evidence.study.study_tables import USUAL, StudyTables
from pitotbench.evidence.study.sweeps.sweep import Reply, Sweep

MODELS = ("bias", "linear", "quadratic", "inverse+")
KNEE = "knee truth"
TRUTHS = {
    "constant truth": "bias",
    "linear truth": "linear",
    "quadratic truth": "quadratic",
    "none": "inverse+",
    KNEE: "a knee, in no model of the table",
}
CRITERIA = {"white_criterion": "all samples, as if white", "block_criterion": "means over 5 s"}


def looks(maneuver: str) -> tuple[Look, ...]:
    """Return looks at every true curve with every model. The usual one is already among the looks of the claims."""
    options = [replace(PAPER, model=model) for model in MODELS]
    return tuple(Look("50/50", one, truth) for truth in TRUTHS for one in options if truth != "none")


def choices(evidence: StudyTables) -> pd.DataFrame:
    """Return a row a flight and true curve: the model that each criterion chooses, and every model's rms error."""
    fits = evidence.fits
    for name, value in {**USUAL, "setting": "light"}.items():
        if name not in ("model", "change", "level"):
            fits = fits[fits[name] == value]
    fits = fits[fits["change"].isin(TRUTHS) & (fits["failed"] == "") & fits["maneuver"].isin(PAPER_ORDER)]
    fits = fits[fits["seed"].isin(fits[fits["change"] == KNEE]["seed"].unique())]
    rows = []
    for (truth, maneuver, seed), group in fits.groupby(["change", "maneuver", "seed"], sort=False):
        models = group.set_index("model").reindex(list(MODELS))
        row: dict[str, object] = {"truth": truth, "maneuver": maneuver, "seed": seed}
        row |= {model: float(models["rms_error_kt"].astype(float)[model]) for model in MODELS}
        row |= {name: str(models[name].astype(float).idxmin()) for name in CRITERIA}
        rows.append(row)
    return pd.DataFrame(rows)


def _chosen(table: pd.DataFrame, criterion: str) -> pd.Series:
    """Return the true rms error of the chosen model [kt], flight by flight."""
    errors = table[list(MODELS)].to_numpy()
    picked = table[criterion].map({m: i for i, m in enumerate(MODELS)}).to_numpy()
    return pd.Series(errors[np.arange(len(table)), picked], index=table.index)


def _line(table: pd.DataFrame, criterion: str, truth: str) -> dict[str, object]:
    of = table[table["truth"] == truth]
    counts = of[criterion].value_counts()
    return {
        "criterion": CRITERIA[criterion],
        "truth": TRUTHS[truth],
        **{f"{m} chosen [%]": f"{100.0 * counts.get(m, 0) / len(of):.0f}" for m in MODELS},
        "rms error, chosen [kt]": f"{rms(_chosen(of, criterion)):.2f}",
        "rms error, best of the four [kt]": f"{rms(of[list(MODELS)].min(axis=1)):.2f}",
    }


def _chart(table: pd.DataFrame) -> Bars:
    unknown = [float("nan")] * len(PAPER_ORDER)
    by = {m: table[table["maneuver"] == m] for m in PAPER_ORDER}
    series = [BarSeries(model, [rms(by[m][model]) for m in PAPER_ORDER], unknown) for model in MODELS]
    title, note = "True error by model", "Light turbulence, 50/50 Hz; rms over seeds and the five truths."
    groups = [NAMES[m] for m in PAPER_ORDER]
    return Bars(title, note, "rms error of the curve [kt]", groups, series, "sweep-structure")


def _answer(evidence: StudyTables) -> Reply:
    table = choices(evidence)
    known = table[table["truth"] != KNEE]
    right = {c: 100.0 * float((known[c] == known["truth"].map(TRUTHS)).mean()) for c in CRITERIA}
    cost = {c: rms(_chosen(table, c)) for c in CRITERIA}
    unneeded = [table[(table["truth"] == t)] for t in ("constant truth", "linear truth")]
    many, few = (
        rms(pd.concat([of["quadratic"] for of in unneeded])),
        rms(known.loc[known["truth"] == "none", "linear"]),
    )
    always = {model: rms(table[model]) for model in MODELS}
    return Reply(
        f"Schwarz's criterion names the true structure in {right['white_criterion']:.0f} % of flights when every "
        f"sample counts as independent and in {right['block_criterion']:.0f} % when means over 5 s do, with rms "
        f"errors of {cost['white_criterion']:.2f} and {cost['block_criterion']:.2f} kt over all truths. Always "
        f"fitting Quadratic gives {always['quadratic']:.2f} kt, Inverse+ {always['inverse+']:.2f}, Linear "
        f"{always['linear']:.2f} and Bias {always['bias']:.2f} kt. A term too many (Quadratic on a constant or "
        f"linear truth) costs {many:.2f} kt, one too few (Linear on Inverse+) {few:.2f} kt.",
        (_chart(table),),
        (pd.DataFrame([_line(table, c, truth) for c in CRITERIA for truth in TRUTHS]),),
    )


STRUCTURE = Sweep("model structure", "Can statistics choose the structure of the model?", _answer, looks)
