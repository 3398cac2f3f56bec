"""C3 and C4: the data rates."""

import pandas as pd

from pitotbench.study.charting import maneuver_bars
from pitotbench.study.claims.claim import Claim, Finding, verdict
from pitotbench.study.evidence import Evidence, Spread, percent
from pitotbench.study.flights import ALIKE, SYSTEMS
from pitotbench.study.names import NAMES, PAPER_ORDER, named

_SAME = 2.0  # %: less is no significant difference
_TEN = (5.0, 15.0)  # %: about ten


def _change(evidence: Evidence, maneuver: str, das: str, smooth: bool = False, **how: object) -> Spread:
    """By how many percent the 2σ of a data system is above that of 50/50 Hz; `smooth` interpolates the fixes."""
    column, method = ("smooth_two_sigma_kt", "covering") if smooth else ("residual_two_sigma_kt", "paper")
    one = evidence.fit(column, maneuver, das=das, method=method, **how)
    other = evidence.fit(column, maneuver, method=method, **{**how, "gps_noise": 1.0})
    return percent(one, other)


def _mean(changes: dict[str, Spread], without: str = "") -> float:
    return float(pd.Series([s.mean for m, s in changes.items() if m != without]).mean())


def _fast(evidence: Evidence) -> Finding:
    change = {m: _change(evidence, m, "100/100") for m in PAPER_ORDER}
    worst = max(change, key=lambda m: abs(change[m].mean))
    chart = maneuver_bars(
        "fig10-rates",
        "Fig 10: 2σ of the residual by maneuver and data rate",
        "Smooth air, a good pilot, Inverse+; bars ± standard deviation over seeds.",
        "2σ of the residual [kt]",
        [(das, f"{das} Hz") for das in SYSTEMS],
        lambda m, das: evidence.residual(m, das=das),
    )
    return Finding(
        verdict(all(abs(s.mean) < _SAME for s in change.values())),
        f"100/100 differs from 50/50 by {change[worst].text(1)} % at most ({NAMES[worst]})",
        "White noise a sample sets the residual at either rate, and twice as many samples of it scatter as much.",
        (chart,),
    )


# How 20/1 Hz is looked at: fixes interpolated or held, and what else is changed.
ASKED: dict[str, tuple[bool, dict[str, object]]] = {
    "held, smooth air [%]": (False, {}),
    "held, light turbulence [%]": (False, {"setting": "light"}),
    "held, velocity noise as at 50/50 [%]": (False, {"gps_noise": ALIKE}),
    "interpolated [%]": (True, {}),
    "interpolated, velocity noise as at 50/50 [%]": (True, {"gps_noise": ALIKE}),
}


def _slow(evidence: Evidence) -> Finding:
    change = {
        name: {m: _change(evidence, m, "20/1", smooth, **how) for m in PAPER_ORDER}
        for name, (smooth, how) in ASKED.items()
    }
    held, light, alike, spline, neither = (_mean(found) for found in change.values())
    still, gusty = (_mean(change[f"held, {air} [%]"], "rapid_decel") for air in ("smooth air", "light turbulence"))
    rows: dict[str, dict[str, object]] = {
        m: {name: c[m].text(1) for name, c in change.items()} for m in PAPER_ORDER
    }
    return Finding(
        verdict(_about_ten(held), _about_ten(still) or _about_ten(gusty)),
        f"20/1 is {held:.0f} % above 50/50 on average, {light:.0f} % in light turbulence; without Rapid Decel "
        f"{still:.0f} % and {gusty:.0f} %",
        "Two causes, taken apart on the same flights: a velocity held for a second is half a second old, which "
        "costs what the ground speed changes in that time (in turns, and most of all in Rapid Decel), and a "
        f"receiver alone is noisier than one joined with inertial sensors. The hold alone makes {alike:+.0f} %, "
        f"the noise alone {spline:+.0f} %, neither {neither:+.1f} %. The more turbulence, the smaller the share "
        "of both: ten percent is a mixture of maneuvers, noise and air, not a property of 20/1 Hz.",
        tables=(named(rows),),
    )


def _about_ten(percents: float) -> bool:
    return _TEN[0] <= percents <= _TEN[1]


FAST = Claim(
    "C3",
    "50/50 and 100/100 Hz: no significant difference of the 2σ",
    "Fig 10",
    f"less than {_SAME:g} % for every maneuver",
    _fast,
)
SLOW = Claim(
    "C4",
    "20/1 Hz increases the 2σ by about 10 % on average",
    "Fig 10",
    f"a mean of {_TEN[0]:g} to {_TEN[1]:g} % (in part: without Rapid Decel, in smooth air or light turbulence)",
    _slow,
)
