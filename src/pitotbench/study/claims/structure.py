"""C5 and C6: the structure of the model."""

import numpy as np
import pandas as pd

from pitotbench.pressure_error import MODELS
from pitotbench.records.case import PressureErrorSpec
from pitotbench.show.chart import Bars, Lines, LineSeries
from pitotbench.study.charting import maneuver_bars
from pitotbench.study.claims.claim import Claim, Finding, verdict
from pitotbench.study.evidence import Evidence, Spread, percent, ratio
from pitotbench.study.flights import PAPER_MODELS
from pitotbench.study.names import NAMES, PAPER_ORDER, named

_DOUBLE = (1.5, 2.5)
_IDENTICAL = 3.0  # %


def _over_others(evidence: Evidence, maneuver: str) -> Spread:
    """2σ of the Bias model over the mean of the other models'."""
    others = pd.concat([evidence.residual(maneuver, model=model) for model in PAPER_MODELS[:-1]], axis=1)
    return ratio(evidence.residual(maneuver, model="bias"), others.mean(axis=1))


def _wind_error(evidence: Evidence, maneuver: str) -> pd.Series:
    return evidence.fit("wind_north_error_kt", maneuver, model="bias")


def _bias(evidence: Evidence) -> Finding:
    ratios = {m: _over_others(evidence, m) for m in PAPER_ORDER}
    average = float(np.mean([r.mean for r in ratios.values()]))
    missed = [NAMES[m] for m, r in ratios.items() if not _DOUBLE[0] <= r.mean <= _DOUBLE[1]]
    wrong = {m: Spread.of(_wind_error(evidence, m).abs()).mean for m in ("step_decrease", "four_leg")}
    each = ", ".join(f"{NAMES[m]} {r.text(2)}" for m, r in ratios.items())
    return Finding(
        verdict(_DOUBLE[0] <= average <= _DOUBLE[1], not missed),
        f"{average:.2f} times the mean of the others, averaged over the maneuvers ({each})",
        "The ratio is the size of the injected error over the noise, and the default error was chosen with this "
        f"claim in view. {'Outside: ' + ', '.join(missed) + '. ' if missed else ''}Step Decrease flies fast on "
        "one heading and slow on the other, so a wrong wind stands in for the missing slope of the curve: with "
        f"Bias its wind is {wrong['step_decrease']:.2f} kt wrong along the track, one way for the fast half and "
        f"the other for the slow, that of 4-Leg {wrong['four_leg']:.2f} kt; what the wind takes up, the residual "
        "does not show.",
        (model_shapes(), _bars(evidence)),
        (_table(evidence, ratios),),
    )


def _table(evidence: Evidence, ratios: dict[str, Spread]) -> pd.DataFrame:
    rows: dict[str, dict[str, object]] = {}
    for m in PAPER_ORDER:
        row: dict[str, object] = {
            f"{k} [kt]": Spread.of(evidence.residual(m, model=k)).text(2) for k in PAPER_MODELS
        }
        row["Bias / mean of the others [-]"] = ratios[m].text(2)
        row["wind north, error with Bias [kt]"] = Spread.of(_wind_error(evidence, m)).text(2)
        rows[m] = row
    return named(rows)


def _bars(evidence: Evidence) -> Bars:
    title, note = "Fig 9: 2σ of the residual by maneuver and model", "50/50 Hz, smooth air, a good pilot."
    kinds = [(model, model) for model in PAPER_MODELS]

    def number(maneuver: str, model: str) -> pd.Series:
        return evidence.residual(maneuver, model=model)

    return maneuver_bars("fig9-models", title, note, "2σ of the residual [kt]", kinds, number)


def model_shapes() -> Lines:
    """The structures of Fig 4, each as near to the default pressure error as it comes over 80 to 170 kt."""
    truth = PressureErrorSpec()
    x = np.linspace(0.6, 3.0, 121)
    speed = 100.0 * np.sqrt(x)  # incompressible: for the picture only
    wanted = MODELS[truth.model].basis(x) @ np.array(truth.parameters)
    series = []
    for name, model in MODELS.items():
        k = np.linalg.lstsq(model.basis(x), wanted, rcond=None)[0]
        series.append(LineSeries(name, speed.tolist(), (model.basis(x) @ k).tolist()))
    note = "Least-squares fits of each structure to the default error; Inverse+ is the truth itself."
    return Lines("Fig 4: model structures", note, "indicated airspeed [kt]", "Δp/q_c [-]", series, "fig4-models")


def _same(evidence: Evidence) -> Finding:
    change = {
        m: percent(evidence.residual(m, model="quadratic"), evidence.residual(m, model="inverse+"))
        for m in PAPER_ORDER
    }
    worst = max(change, key=lambda m: abs(change[m].mean))
    return Finding(
        verdict(all(abs(s.mean) < _IDENTICAL for s in change.values())),
        f"Quadratic is {change[worst].text(1)} % above Inverse+ at most ({NAMES[worst]})",
        "Over 100 to 160 kt three free terms of either kind draw nearly the same curve; outside the flown speeds "
        "they part.",
    )


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
