"""The open questions about data rates and the choice of the model."""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from pitotbench.campaigns.flights import rms
from pitotlab.study.questions import Reply, Sweep
from pitotlab.study.reductions import (
    BOTH_METHODS,
    NAMES,
    PAPER,
    PAPER_ORDER,
    Reduction,
    reductions,
)
from pitotlab.study.tables import DEFAULT_FIT, StudyTables, mean, span

FLOWN = ("step_decrease", "circle", "rapid_decel")
RATES = (0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 50.0, 200.0)  # Hz
FASTEST = "200/200"
SIDES = ("both", "air", "gps")  # that has the rate
KINDS = {  # column and method
    "bound": ("two_sigma_kt", "covering"),
    "residual": ("residual_two_sigma_kt", "paper"),
}


def system(side: str, rate: float) -> str:
    """Return the data system with a rate on one side. Its GPS is never faster than its air data."""
    return {
        "both": f"{rate:g}/{rate:g}",
        "air": f"{rate:g}/{min(rate, 1.0):g}",
        "gps": f"200/{rate:g}",
    }[side]


def rate_reductions(maneuver: str) -> tuple[Reduction, ...]:
    """Return reductions of every rate of both sides, once. The claims already have the usual systems."""
    if maneuver not in FLOWN:
        return ()
    systems = dict.fromkeys(system(side, rate) for side in SIDES for rate in RATES)
    return reductions(BOTH_METHODS, [das for das in systems if das not in ("20/1", "50/50")])


def _rate_column(evidence: StudyTables, kind: str, maneuver: str, das: str) -> pd.Series:
    column, method = KINDS[kind]
    fitted = partial(evidence.fit, column, maneuver, setting="light", method=method)
    found = fitted(das=das)
    return found[found.index.isin(fitted(das=FASTEST).index)]


@partial(
    Sweep,
    "sampling rates",
    "Which rates are enough, 0.2 to 200 Hz on both sides?",
    reductions=rate_reductions,
)
def rates(evidence: StudyTables) -> Reply:
    def average(kind: str, maneuver: str, das: str) -> float:
        return mean(_rate_column(evidence, kind, maneuver, das))

    def change(das: str) -> str:
        found = [average("bound", m, das) / average("bound", m, FASTEST) for m in FLOWN]
        return f"{das} Hz {span(found)}"

    held, fast = (average("residual", "rapid_decel", das) for das in ("200/0.2", FASTEST))
    return Reply(
        f"Against {FASTEST} Hz the covering 2σ in light turbulence is larger by a factor of "
        + ", at ".join(change(das) for das in ("0.2/0.2", "1/1", "5/5", "20/1"))
        + f" ({', '.join(NAMES[m] for m in FLOWN)}). The residual of the published method is "
        f"another matter: in Rapid Decel it goes from {fast:.2f} kt to {held:.2f} kt at 200/0.2 "
        "Hz, where each fix is held for five seconds.",
    )


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


def structure_reductions(maneuver: str) -> Iterator[Reduction]:
    """Yield reductions of every true curve but the usual one with every model."""
    options = [replace(PAPER, model=model) for model in MODELS]
    for truth in TRUTHS:
        if truth != "none":
            yield from reductions(options, change=truth)


def choices(evidence: StudyTables) -> pd.DataFrame:
    """Return a row a flight and true curve: each criterion's model, every model's rms error."""
    fits = evidence.fits
    wanted = {**DEFAULT_FIT, "setting": "light", "failed": ""}
    for name in wanted.keys() - {"model", "change", "level"}:
        fits = fits[fits[name] == wanted[name]]
    fits = fits[fits["change"].isin(TRUTHS) & fits["maneuver"].isin(PAPER_ORDER)]
    fits = fits[fits["seed"].isin(fits[fits["change"] == KNEE]["seed"].unique())]
    rows = []
    for (truth, maneuver, seed), group in fits.groupby(["change", "maneuver", "seed"], sort=False):
        models = group.set_index("model").reindex(list(MODELS))
        row: dict[str, object] = {"truth": truth, "maneuver": maneuver, "seed": seed}
        row |= dict(zip(MODELS, models["rms_error_kt"].astype(float), strict=True))
        row |= {name: str(models[name].astype(float).idxmin()) for name in CRITERIA}
        rows.append(row)
    return pd.DataFrame(rows)


def _chosen(table: pd.DataFrame, criterion: str) -> float:
    """Return the rms of the true errors of the chosen models [kt]."""
    places = [MODELS.index(model) for model in table[criterion]]
    return rms(table[list(MODELS)].to_numpy()[np.arange(len(table)), places])


def _line(table: pd.DataFrame, criterion: str, truth: str) -> dict[str, object]:
    of = table[table["truth"] == truth]
    counts = of[criterion].value_counts()
    return {
        "criterion": CRITERIA[criterion],
        "truth": TRUTHS[truth],
        **{f"{m} chosen [%]": f"{100.0 * counts.get(m, 0) / len(of):.0f}" for m in MODELS},
        "rms error, chosen [kt]": f"{_chosen(of, criterion):.2f}",
        "rms error, best of the four [kt]": f"{rms(of[list(MODELS)].min(axis=1)):.2f}",
    }


@partial(
    Sweep,
    "model structure",
    "Can statistics choose the structure of the model?",
    reductions=structure_reductions,
)
def structure(evidence: StudyTables) -> Reply:
    table = choices(evidence)
    known = table[table["truth"] != KNEE]
    right = {c: 100.0 * float((known[c] == known["truth"].map(TRUTHS)).mean()) for c in CRITERIA}
    cost = {c: _chosen(table, c) for c in CRITERIA}
    many = rms(table[table["truth"].isin(("constant truth", "linear truth"))]["quadratic"])
    few = rms(known[known["truth"] == "none"]["linear"])
    always = {model: rms(table[model]) for model in MODELS}
    return Reply(
        f"Schwarz's criterion names the true structure in {right['white_criterion']:.0f} % of "
        f"flights when every sample counts as independent and in {right['block_criterion']:.0f} % "
        f"when means over 5 s do, with rms errors of {cost['white_criterion']:.2f} and "
        f"{cost['block_criterion']:.2f} kt over all truths. Always fitting Quadratic gives "
        f"{always['quadratic']:.2f} kt, Inverse+ {always['inverse+']:.2f}, Linear "
        f"{always['linear']:.2f} and Bias {always['bias']:.2f} kt. A term too many (Quadratic on a "
        f"constant or linear truth) costs {many:.2f} kt, one too few (Linear on Inverse+) "
        f"{few:.2f} kt.",
        (pd.DataFrame([_line(table, c, truth) for c in CRITERIA for truth in TRUTHS]),),
    )
