"""C3 and C4: the data rates."""

import pandas as pd

from pitotbench.evidence.study.charting import maneuver_bars
from pitotbench.evidence.study.claims.claim import Claim, Finding, verdict
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER, named
from pitotbench.evidence.study.settings import ALIKE
from pitotbench.evidence.study.study_tables import Spread, StudyTables, signed
from pitotbench.sense import SYSTEMS

_TOP = 0.8  # kt: cut of Fig 10, for Rapid Decel at 20/1 Hz
_SAME = 2.0  # %: a smaller difference is not significant
_TEN = (5.0, 15.0)  # %: our reading of "about ten percent"


def _change(evidence: StudyTables, maneuver: str, das: str, smooth: bool = False, **how: object) -> pd.Series:
    """Return the 2σ relative to that at 50/50 Hz, minus one [%], by seed; `smooth` interpolates the fixes."""
    column, method = ("smooth_two_sigma_kt", "covering") if smooth else ("residual_two_sigma_kt", "paper")
    one = evidence.fit(column, maneuver, das=das, method=method, **how)
    other = evidence.fit(column, maneuver, method=method, **{**how, "gps_noise": 1.0})
    return 100.0 * (one / other - 1.0)


def _average(evidence: StudyTables, label: str, without: str = "") -> Spread:
    """Return the change averaged over the maneuvers, with its spread over seeds."""
    smooth, how = ASKED[label]
    changes = [_change(evidence, m, "20/1", smooth, **how) for m in PAPER_ORDER if m != without]
    return Spread.of(pd.concat(changes, axis=1).mean(axis=1, skipna=False))


def _fast(evidence: StudyTables) -> Finding:
    change = {m: Spread.of(_change(evidence, m, "100/100")) for m in PAPER_ORDER}
    worst = max(change, key=lambda m: abs(change[m].mean))
    chart = maneuver_bars(
        "fig10-rates",
        "Fig 10: 2σ of the residual by maneuver and data rate",
        "Smooth air, a good pilot, Inverse+.",
        "2σ of the residual [kt]",
        [(das, f"{das} Hz") for das in SYSTEMS],
        lambda m, das: evidence.residual(m, das=das),
        dots=True,
        top=_TOP,
    )
    return Finding(
        verdict(all(abs(s.mean) < _SAME for s in change.values())),
        f"100/100 differs from 50/50 by {change[worst].text(1)} % at most ({NAMES[worst]})",
        "Sense the same flights at 50/50 and at 100/100 Hz, and fit both.",
        "The residual is the scatter of one sample. It is white noise here and does not depend on the number of "
        f"samples. The covering 2σ of the curve does: at 100/100 Hz it is {_bound_change(evidence)} times that at "
        "50/50 Hz.",
        (chart,),
    )


def _bound_change(evidence: StudyTables) -> str:
    """Return the least and largest ratio over the maneuvers of the covering 2σ at 100/100 to that at 50/50 Hz."""
    bound = {das: [Spread.of(evidence.fit("two_sigma_kt", m, das=das, method="covering")).mean for m in PAPER_ORDER]
             for das in ("100/100", "50/50")}  # fmt: skip
    found = [fast / usual for fast, usual in zip(*bound.values(), strict=True)]
    return f"{min(found):.2f} to {max(found):.2f}"


# The looks at 20/1 Hz: fixes interpolated or held, with other changes.
ASKED: dict[str, tuple[bool, dict[str, object]]] = {
    "held, smooth air [%]": (False, {}),
    "held, light turbulence [%]": (False, {"setting": "light"}),
    "held, moderate turbulence [%]": (False, {"setting": "moderate"}),
    "held, velocity noise as at 50/50 [%]": (False, {"gps_noise": ALIKE}),
    "interpolated [%]": (True, {}),
    "interpolated, velocity noise as at 50/50 [%]": (True, {"gps_noise": ALIKE}),
}


def _slow(evidence: StudyTables) -> Finding:
    held, light, moderate, alike, spline, neither = (_average(evidence, label) for label in ASKED)
    still, gusty = (_average(evidence, label, "rapid_decel") for label in list(ASKED)[:2])
    decel = Spread.of(_change(evidence, "rapid_decel", "20/1"))
    return Finding(
        verdict(_about_ten(held), _about_ten(still) or _about_ten(gusty)),
        f"20/1 is {held.text(0)} % above 50/50 on average, {light.text(0)} % in light turbulence; without Rapid "
        f"Decel {still.text(0)} % and {gusty.text(0)} %",
        "Sense the same flights at 20/1 Hz with each of two causes taken away. Cause one: a velocity that is held "
        "for a second is old; interpolate the fixes instead. Cause two: a receiver alone is noisier than one "
        "joined with inertial sensors (0.1 and 0.05 m/s here); give both the same noise.",
        f"Averaged over the maneuvers the hold alone makes {signed(alike.mean)} %, the noise alone "
        f"{signed(spline.mean)} %, and neither {signed(neither.mean)} %. Rapid Decel makes {decel.text(0)} %, "
        "because its speed changes most in a second. Turbulence hides both causes: the mean over the maneuvers is "
        f"{held.mean:.0f} % in smooth air, {light.mean:.0f} % in light and {moderate.mean:.0f} % in moderate "
        "turbulence.",
        tables=(_parts(evidence),),
    )


def _parts(evidence: StudyTables) -> pd.DataFrame:
    rows: dict[str, dict[str, object]] = {m: {} for m in PAPER_ORDER}
    for label, (smooth, how) in ASKED.items():
        for m in PAPER_ORDER:
            rows[m][label] = Spread.of(_change(evidence, m, "20/1", smooth, **how)).text(1)
    return named(rows)


def _about_ten(percents: Spread) -> bool:
    return _TEN[0] <= percents.mean <= _TEN[1]


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
