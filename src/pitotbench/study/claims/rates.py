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


def _slow(evidence: Evidence) -> Finding:
    asked: dict[str, tuple[bool, dict[str, object]]] = {
        "held, smooth air [%]": (False, {}),
        "held, light turbulence [%]": (False, {"setting": "light"}),
        "held, velocity noise as at 50/50 [%]": (False, {"gps_noise": ALIKE}),
        "interpolated [%]": (True, {}),
        "interpolated, velocity noise as at 50/50 [%]": (True, {"gps_noise": ALIKE}),
    }
    change = {
        name: {m: _change(evidence, m, "20/1", smooth, **how) for m in PAPER_ORDER}
        for name, (smooth, how) in asked.items()
    }
    held, light, alike, spline, neither = (_mean(found) for found in change.values())
    steady = _mean(change["held, smooth air [%]"], "rapid_decel")
    rows: dict[str, dict[str, object]] = {
        m: {name: found[m].text(1) for name, found in change.items()} for m in PAPER_ORDER
    }
    without = _mean(change["held, light turbulence [%]"], "rapid_decel")
    return Finding(
        verdict(_TEN[0] <= held <= _TEN[1], _TEN[0] <= steady <= _TEN[1] or _TEN[0] <= without <= _TEN[1]),
        f"20/1 is {held:.0f} % above 50/50 on average, {light:.0f} % in light turbulence; without Rapid Decel "
        f"{steady:.0f} % and {without:.0f} %",
        "Two causes, taken apart on the same flights: a velocity held for a second is half a second old, which costs "
        "what the ground speed changes in that time (in turns, and most of all in Rapid Decel), and a receiver alone "
        f"is noisier than one joined with inertial sensors. The hold alone makes {alike:+.0f} %, the noise alone "
        f"{spline:+.0f} %, neither {neither:+.1f} %. The more turbulence, the smaller the share of both: ten percent "
        "is a mixture of maneuvers, noise and air, not a property of 20/1 Hz.",
        tables=(named(rows),),
    )


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
    f"a mean of {_TEN[0]:g} to {_TEN[1]:g} % (in part: without Rapid Decel)",
    _slow,
)
