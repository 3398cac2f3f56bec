"""Which sampling rates are enough, from 0.2 to 200 Hz on both sides?"""

import pandas as pd

from pitotbench.study.charting import maneuver_lines
from pitotbench.study.evidence import Evidence, Spread
from pitotbench.study.look import COVERING, PAPER, Look
from pitotbench.study.names import NAMES
from pitotbench.study.sweeps.sweep import Reply, Sweep

FLOWN = ("step_decrease", "circle", "rapid_decel")
RATES = (0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 50.0, 200.0)  # Hz
SIDES = {
    "both": ("both at the same rate", "air data and GPS [Hz]"),
    "air": ("air data, with the GPS at 1 Hz at most", "air data [Hz]"),
    "gps": ("GPS, with the air data at 50 Hz", "GPS [Hz]"),
}


def _das(side: str, rate: float) -> str:
    """The data system of a side and rate; a GPS is never faster than the air data."""
    if rate == RATES[-1]:
        return "200/200"
    return {"both": f"{rate:g}/{rate:g}", "air": f"{rate:g}/{min(rate, 1.0):g}", "gps": f"50/{min(rate, 50.0):g}"}[
        side
    ]


def looks(maneuver: str) -> tuple[Look, ...]:
    """Every rate of every side, once; the usual data systems are looked at anyway."""
    if maneuver not in FLOWN:
        return ()
    systems = dict.fromkeys(_das(side, rate) for side in SIDES for rate in RATES)
    return tuple(Look(das, o) for das in systems for o in (COVERING, PAPER) if das not in ("20/1", "50/50"))


def _answer(evidence: Evidence) -> Reply:
    def column(name: str, maneuver: str, das: str, method: str) -> pd.Series:
        found = evidence.fit(name, maneuver, setting="light", method=method, das=das)
        few = evidence.fit(name, maneuver, setting="light", method=method, das="200/200").index
        return found[found.index.isin(few)]

    charts = tuple(
        maneuver_lines(
            f"sweep-rates-{side}-{kind}", f"{title}: {words}", "Light turbulence, the same flights.", xlabel, ylabel, RATES,
            lambda m, rate, side=side, name=name, method=method: column(name, m, _das(side, rate), method),
            FLOWN, log_x=True,
        )
        for kind, name, method, title, ylabel in (
            ("bound", "two_sigma_kt", "covering", "Knowledge", "covering 2σ of the curve [kt]"),
            ("residual", "residual_two_sigma_kt", "paper", "Residual", "2σ of the residual [kt]"),
        )
        for side, (words, xlabel) in SIDES.items()
    )  # fmt: skip

    def bound(maneuver: str, das: str) -> float:
        return Spread.of(column("two_sigma_kt", maneuver, das, "covering")).mean

    change = {
        das: [bound(m, das) / bound(m, "200/200") for m in FLOWN] for das in ("0.2/0.2", "1/1", "5/5", "20/1")
    }
    held = Spread.of(column("residual_two_sigma_kt", "rapid_decel", "50/0.2", "paper")).mean
    fast = Spread.of(column("residual_two_sigma_kt", "rapid_decel", "200/200", "paper")).mean
    return Reply(
        "The covering 2σ at 0.2/0.2, 1/1, 5/5 and 20/1 Hz is "
        + ", ".join(f"{min(c):.2f} to {max(c):.2f}" for c in change.values())
        + f" times that of 200/200 Hz ({', '.join(NAMES[m] for m in FLOWN)}): in light turbulence gusts set the bound, and "
        f"they last longer than a sample. The residual is another matter: in Rapid Decel it goes from {fast:.2f} kt to "
        f"{held:.2f} kt when each fix is held for five seconds, which interpolation undoes.",
        charts,
    )


RATES_SWEEP = Sweep("sampling rates", "Which rates are enough, 0.2 to 200 Hz on both sides?", _answer, looks)
