"""C5 and C6: the structure of the model."""

import numpy as np

from pitotbench.pressure_error import MODELS
from pitotbench.records.case import PressureErrorSpec
from pitotbench.show.chart import Lines, LineSeries
from pitotbench.study.charting import maneuver_bars
from pitotbench.study.claims.claim import Claim, Finding, verdict
from pitotbench.study.evidence import Evidence, Spread, percent, ratio
from pitotbench.study.flights import PAPER_MODELS
from pitotbench.study.names import NAMES, PAPER_ORDER, named

_DOUBLE = (1.5, 2.5)
_IDENTICAL = 3.0  # %


def _bias(evidence: Evidence) -> Finding:
    others = PAPER_MODELS[:-1]
    ratios = {}
    for maneuver in PAPER_ORDER:
        mean = sum(evidence.residual(maneuver, model=model) for model in others) / len(others)
        ratios[maneuver] = ratio(evidence.residual(maneuver, model="bias"), mean)
    average = float(np.mean([r.mean for r in ratios.values()]))
    inside = {m: _DOUBLE[0] <= r.mean <= _DOUBLE[1] for m, r in ratios.items()}
    tilt = Spread.of(evidence.fit("wind_north_error_kt", "step_decrease", model="bias").abs())
    rest = Spread.of(evidence.fit("wind_north_error_kt", "four_leg", model="bias").abs())
    rows: dict[str, dict[str, object]] = {
        m: {
            **{f"{model} [kt]": Spread.of(evidence.residual(m, model=model)).text(2) for model in PAPER_MODELS},
            "Bias / mean of the others": ratios[m].text(2),
            "wind north, error with Bias [kt]": Spread.of(
                evidence.fit("wind_north_error_kt", m, model="bias")
            ).text(2),
        }
        for m in PAPER_ORDER
    }
    chart = maneuver_bars(
        "fig9-models", "Fig 9: 2σ of the residual by maneuver and model", "50/50 Hz, smooth air, a good pilot.",
        "2σ of the residual [kt]", [(m, m) for m in PAPER_MODELS], lambda m, model: evidence.residual(m, model=model),
    )  # fmt: skip
    missed = [NAMES[m] for m in PAPER_ORDER if not inside[m]]
    return Finding(
        verdict(_DOUBLE[0] <= average <= _DOUBLE[1], not missed),
        f"{average:.2f} times the mean of the others, averaged over the maneuvers ("
        + ", ".join(f"{NAMES[m]} {ratios[m].text(2)}" for m in PAPER_ORDER)
        + ")",
        "The ratio is the size of the injected error over the noise, and the default error was chosen with this "
        "claim in view. "
        + (f"Outside: {', '.join(missed)}. " if missed else "")
        + "Step Decrease flies fast on one heading and slow on the other, so a wrong wind stands in for the missing "
        f"slope of the curve: with Bias its wind is {tilt.mean:.1f} kt wrong along the track, that of 4-Leg "
        f"{rest.mean:.1f} kt, and the residual shows little of it.",
        (model_shapes(), chart),
        (named(rows),),
    )


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
