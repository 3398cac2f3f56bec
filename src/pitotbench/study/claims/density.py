"""C9 and C10: how many samples, and how evenly spread."""

import numpy as np
import pandas as pd

from pitotbench.show.chart import Bars, BarSeries, Lines, LineSeries
from pitotbench.study.claims.claim import Claim, Finding, verdict
from pitotbench.study.evidence import Evidence, Spread, percent, ratio
from pitotbench.study.flights import SYSTEMS
from pitotbench.study.noise import airspeed_noise

CARDS = (
    ("four_leg", "standard", "4-Leg, four speeds"),
    ("four_leg", "six speeds", "4-Leg, six speeds"),
    ("step_decrease", "standard", "Step Decrease, 10 s steps"),
    ("step_decrease", "long steps", "Step Decrease, 20 s steps"),
)
_THIRD = (0.25, 0.42)


def _density(evidence: Evidence) -> Lines:
    table = evidence.density
    series = []
    for maneuver, variant, label in CARDS:
        rows = table[(table.maneuver == maneuver) & (table.variant == variant) & (table.setting == "smooth")]
        series.append(LineSeries(label, rows.airspeed_kt.tolist(), rows.seconds.tolist(), style="steps"))
    note = f"Seed {evidence.seeds[0]}; turns included. Times 50 Hz gives samples."
    return Lines(
        "Fig 5: data density", note, "calibrated airspeed [kt]", "time in each 2.5 kt [s]", series, "fig5-density"
    )


def _bars(evidence: Evidence) -> Bars:
    series = []
    for das in SYSTEMS:
        found = [Spread.of(evidence.residual(m, variant=variant, das=das)) for m, variant, _ in CARDS]
        series.append(BarSeries(f"{das} Hz", [s.mean for s in found], [s.deviation for s in found]))
    labels = [label.replace(", ", "\n") for _, _, label in CARDS]
    return Bars("Fig 6: effect of data density", "Smooth air, a good pilot, Inverse+.", "2σ of the residual [kt]",
                labels, series, "fig6-density")  # fmt: skip


def _denser(evidence: Evidence) -> Finding:
    six = percent(evidence.residual("four_leg", variant="six speeds"), evidence.residual("four_leg"))
    steps = percent(evidence.residual("step_decrease", variant="long steps"), evidence.residual("step_decrease"))
    return Finding(
        verdict(_smaller(six), _larger(steps)),
        f"six speeds {six.text(1)} %, longer steps {steps.text(1)} %",
        "The residual does not know how many samples there are: it is the noise of one. What moves it is where "
        "the time is spent, since the same pascals are more knots at low speed; the column of what the injected "
        "noise must give at the flown speeds says as much without any fit (static pressure and GPS add the "
        "rest). What more samples buy is the bound on the curve.",
        (_density(evidence), _bars(evidence)),
        (pd.DataFrame([_row(evidence, *card) for card in CARDS]),),
    )


def _row(evidence: Evidence, maneuver: str, variant: str, label: str) -> dict[str, object]:
    bound = evidence.fit("two_sigma_kt", maneuver, variant=variant, method="covering")
    return {
        "card": label,
        "minutes": Spread.of(evidence.flight("minutes", maneuver, variant=variant)).text(1),
        "samples": f"{Spread.of(evidence.fit('samples', maneuver, variant=variant)).mean:,.0f}",
        "residual 2σ [kt]": Spread.of(evidence.residual(maneuver, variant=variant)).text(3),
        "of the pressure noise alone [kt]": f"{_expected(evidence, maneuver, variant):.3f}",
        "covering 2σ of the curve [kt]": Spread.of(bound).text(4),
    }


def _smaller(change: Spread) -> bool:
    return change.mean < 0.0 and (np.isnan(change.error) or change.mean + 2.0 * change.error < 0.0)


def _larger(change: Spread) -> bool:
    return change.mean > 0.0 and (np.isnan(change.error) or change.mean - 2.0 * change.error > 0.0)


def _expected(evidence: Evidence, maneuver: str, variant: str) -> float:
    """2σ [kt] of white pressure noise at the airspeeds of the density table, which is of one seed."""
    table = evidence.density
    rows = table[(table.maneuver == maneuver) & (table.variant == variant) & (table.setting == "smooth")]
    return airspeed_noise(rows.airspeed_kt.to_numpy(), rows.seconds.to_numpy())


def _fewer(evidence: Evidence) -> Finding:
    share = ratio(evidence.fit("samples", "step_decrease"), evidence.fit("samples", "four_leg"))
    on = ratio(
        evidence.fit("samples", "step_decrease", on_condition=True),
        evidence.fit("samples", "four_leg", on_condition=True),
    )
    change = percent(evidence.residual("step_decrease"), evidence.residual("four_leg"))
    bound = ratio(
        evidence.fit("two_sigma_kt", "step_decrease", method="covering"),
        evidence.fit("two_sigma_kt", "four_leg", method="covering"),
    )
    return Finding(
        verdict(_THIRD[0] <= share.mean <= _THIRD[1], change.mean < 0.0),
        f"{share.text(2)} of the samples of 4-Leg ({on.text(1)} times as many on condition), 2σ {change.text(1)} %",
        "True of the residual, and no merit of it: the covering 2σ of the curve is "
        f"{bound.text(1)} times that of 4-Leg in smooth air.",
    )


DENSER = Claim(
    "C9",
    "4-Leg with six speeds: 2σ modestly smaller; Step Decrease with longer power steps: slightly larger",
    "Figs 5, 6",
    "the sign of each change, by more than two standard errors (in part: one of the two)",
    _denser,
)
FEWER = Claim(
    "C10",
    "Step Decrease has about a third of the samples of 4-Leg and still the smaller 2σ",
    "Fig 6",
    f"a ratio of {_THIRD[0]:g} to {_THIRD[1]:g}, and the smaller 2σ (in part: one of the two)",
    _fewer,
)
