"""C5 and C6: the structure of the model."""

import numpy as np
import pandas as pd

from pitotbench import air, bench
from pitotbench.evidence.pages.chart_data import Bars, Lines, LineSeries
from pitotbench.evidence.study.charting import maneuver_bars
from pitotbench.evidence.study.claims.claim import Claim, Finding, verdict
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER, named
from pitotbench.evidence.study.settings import BOTH_WAYS
from pitotbench.evidence.study.study_tables import Spread, StudyTables, percent_above
from pitotbench.pressure_error import MODELS, PAPER_MODELS, REFERENCE_PRESSURE
from pitotbench.records.case import PressureErrorSpec
from pitotbench.units import KNOT

STRUCTURES = ("bias", "linear", "quadratic", "inverse", "inverse+")  # of Fig 4
_DOUBLE = (1.5, 2.5)
_IDENTICAL = 3.0  # %


def _ratios(evidence: StudyTables, maneuver: str) -> pd.Series:
    """Return 2σ of the Bias model over the mean 2σ of the other models, by seed."""
    others = pd.concat([evidence.residual(maneuver, model=model) for model in PAPER_MODELS[:-1]], axis=1)
    return evidence.residual(maneuver, model="bias") / others.mean(axis=1)


def _over_others(evidence: StudyTables, maneuver: str) -> Spread:
    return Spread.of(_ratios(evidence, maneuver))


def _average(evidence: StudyTables) -> Spread:
    """Return the ratio averaged over the maneuvers, with its spread over seeds."""
    found = [_ratios(evidence, m) for m in PAPER_ORDER]
    return Spread.of(pd.concat(found, axis=1).mean(axis=1, skipna=False))


def _wind_error(evidence: StudyTables, maneuver: str) -> pd.Series:
    return evidence.fit("wind_north_error_kt", maneuver, model="bias")


def _bias(evidence: StudyTables) -> Finding:
    ratios = {m: _over_others(evidence, m) for m in PAPER_ORDER}
    average = _average(evidence)
    missed = [NAMES[m] for m, r in ratios.items() if not _DOUBLE[0] <= r.mean <= _DOUBLE[1]]
    wrong = {m: Spread.of(_wind_error(evidence, m).abs()).mean for m in ("step_decrease", BOTH_WAYS)}
    both = _over_others(evidence, BOTH_WAYS)
    each = ", ".join(f"{NAMES[m]} {r.text(2)}" for m, r in ratios.items())
    return Finding(
        verdict(_DOUBLE[0] <= average.mean <= _DOUBLE[1], not missed),
        f"{average.text(2)} times the mean of the others, averaged over the maneuvers ({each})",
        "The ratio is the size of the injected error over the noise, and the default error was chosen with this "
        f"claim in view. {'Outside: ' + ', '.join(missed) + '. ' if missed else ''}Step Decrease flies fast on one "
        "heading and slow on the other, so that a wrong wind can stand in for the missing slope of the curve. The "
        "experiment: with the same pilot, air and power steps, but every speed on both headings, the ratio is "
        f"{both.text(2)} instead of {ratios['step_decrease'].text(2)}, and the wind along the track that the Bias "
        f"model finds is {wrong[BOTH_WAYS]:.2f} kt wrong instead of {wrong['step_decrease']:.2f} kt. What the wind "
        "takes up, the residual does not show.",
        (model_shapes(), _bars(evidence)),
        (_table(evidence, ratios),),
    )


def _table(evidence: StudyTables, ratios: dict[str, Spread]) -> pd.DataFrame:
    rows: dict[str, dict[str, object]] = {}
    for m in (*PAPER_ORDER, BOTH_WAYS):
        row: dict[str, object] = {
            f"{k} [kt]": Spread.of(evidence.residual(m, model=k)).text(2) for k in PAPER_MODELS
        }
        row["Bias / mean of the others [-]"] = (ratios.get(m) or _over_others(evidence, m)).text(2)
        row["wind north, error with Bias [kt]"] = Spread.of(_wind_error(evidence, m)).text(2)
        rows[m] = row
    return named(rows)


def _bars(evidence: StudyTables) -> Bars:
    title, note = "Fig 9: 2σ of the residual by maneuver and model", "50/50 Hz, smooth air, a good pilot."
    kinds = [(model, model) for model in PAPER_MODELS]

    def number(maneuver: str, model: str) -> pd.Series:
        return evidence.residual(maneuver, model=model)

    return maneuver_bars("fig9-models", title, note, "2σ of the residual [kt]", kinds, number)


def model_shapes() -> Lines:
    """Draw the structures of Fig 4, each fitted to the default pressure error over 80 to 170 kt."""
    truth = PressureErrorSpec()
    x = np.linspace(0.6, 3.0, 121)
    speed = 100.0 * np.sqrt(x)  # incompressible: accurate enough for a picture
    wanted = MODELS[truth.model].basis(x) @ np.array(truth.parameters)
    series = []
    for name in STRUCTURES:
        model = MODELS[name]
        k = np.linalg.lstsq(model.basis(x), wanted, rcond=None)[0]
        series.append(LineSeries(name, speed.tolist(), (model.basis(x) @ k).tolist()))
    note = "Least-squares fits of each structure to the default error; Inverse+ is the truth itself."
    return Lines("Fig 4: model structures", note, "indicated airspeed [kt]", "Δp/q_c [-]", series, "fig4-models")


def _same(evidence: StudyTables) -> Finding:
    change = {
        m: percent_above(evidence.residual(m, model="quadratic"), evidence.residual(m, model="inverse+"))
        for m in PAPER_ORDER
    }
    worst = max(change, key=lambda m: abs(change[m].mean))
    return Finding(
        verdict(all(abs(s.mean) < _IDENTICAL for s in change.values())),
        f"Quadratic is {change[worst].text(1)} % above Inverse+ at most ({NAMES[worst]})",
        "Three free terms of either kind draw nearly the same curve at the speeds flown: fitted to one another "
        f"over 100 to 160 kt they part by {_apart(100.0, 160.0):.2f} kt there, and by {_apart(80.0, 200.0):.1f} kt "
        "between 80 and 200 kt.",
    )


def _apart(slowest: float, fastest: float) -> float:
    """Return the largest distance [kt] of the fitted Quadratic from the default error between two speeds [kt]."""
    truth = PressureErrorSpec()
    flown = air.impact_pressure(np.linspace(100.0, 160.0, 61) * KNOT) / REFERENCE_PRESSURE
    wanted = MODELS[truth.model].basis(flown) @ np.array(truth.parameters)
    nearest = np.linalg.lstsq(MODELS["quadratic"].basis(flown), wanted, rcond=None)[0]
    other = PressureErrorSpec(model="quadratic", parameters=tuple(nearest.tolist()))
    speed = np.linspace(slowest, fastest, 121) * KNOT
    gap = bench.true_correction(truth, speed) - bench.true_correction(other, speed)
    return float(np.max(np.abs(gap))) / KNOT


BIAS = Claim(
    "C5",
    "The Bias model doubles the 2σ of the other three",
    "Fig 9",
    f"{_DOUBLE[0]:g} to {_DOUBLE[1]:g} times for every maneuver (in part: on average)",
    _bias,
)
SAME = Claim(
    "C6",
    "Quadratic and Inverse+ are almost identical for all five maneuvers",
    "Fig 9",
    f"less than {_IDENTICAL:g} % for every maneuver",
    _same,
)
