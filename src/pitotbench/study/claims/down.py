"""C7 and C8: vertical GPS velocity, and turn data."""

import numpy as np
import pandas as pd

from pitotbench.show.chart import Lines
from pitotbench.study.charting import maneuver_bars, maneuver_lines
from pitotbench.study.claims.claim import Claim, Finding, verdict
from pitotbench.study.evidence import Evidence, Spread, percent
from pitotbench.study.flights import STEEPER, SYSTEMS
from pitotbench.study.names import PAPER_ORDER, named

_SEEN = 1.0  # %: a fall below it is none
_SAME = 2.0  # %
_UP_TO = (10.0, 40.0)  # %: "as much as 25 %"


def _fall(evidence: Evidence, maneuver: str, **how: object) -> Spread:
    """By how many percent the 2σ falls with V_down; positive is a fall."""
    found = percent(evidence.residual(maneuver, **how), evidence.residual(maneuver, **{**how, "down": False}))
    return Spread(-found.mean, found.deviation, found.count)


def _steeper(evidence: Evidence) -> Lines:
    levels = (1.0, *STEEPER)

    def fall(maneuver: str, times: float) -> pd.Series:
        how = {"change": "vertical speed", "level": times} if times > 1.0 else {}
        with_down = evidence.residual(maneuver, **how)
        return -100.0 * (with_down / evidence.residual(maneuver, **{**how, "down": False}) - 1.0)

    return maneuver_lines(
        "c7-vertical-speed",
        "How much vertical speed it takes",
        "The same smooth-air flights with their vertical speed multiplied and the airspeed kept; 50/50 Hz.",
        "vertical speed, times what the good pilot flew [-]",
        "fall of the 2σ with V_down [%]",
        levels,
        fall,
    )


def _needed(evidence: Evidence, wanted: float) -> tuple[float, float]:
    """Multiple of 4-Leg's vertical speed at which the fall reaches `wanted` percent, and the flown rms [ft/min]."""
    falls = [_fall(evidence, "four_leg", change="vertical speed", level=times).mean for times in STEEPER]
    times = float(np.interp(wanted, falls, STEEPER)) if max(falls) >= wanted else float("inf")
    return times, Spread.of(evidence.flight("vertical_speed_fpm", "four_leg")).mean


def _with_down(evidence: Evidence) -> Finding:
    fall = {m: _fall(evidence, m) for m in PAPER_ORDER}
    most = max(fall, key=lambda m: fall[m].mean)
    falls = fall["four_leg"].mean > _SEEN and fall["step_decrease"].mean > _SEEN
    busy = _fall(evidence, "four_leg", setting="busy")
    times, flown = _needed(evidence, 25.0)
    vector = _fall(evidence, "four_leg", form="vector")
    kinds = [
        (f"{das} {down}", f"{das} Hz {'with' if down else 'without'} V_down")
        for das in SYSTEMS
        for down in (False, True)
    ]

    def number(maneuver: str, kind: str) -> pd.Series:
        das, down = kind.split(" ")
        return evidence.residual(maneuver, das=das, down=down == "True")

    chart = maneuver_bars(
        "fig7-down", "Fig 7: with and without V_down", "Smooth air, a good pilot. A 20/1 Hz system has no V_down.",
        "2σ of the residual [kt]", kinds, number, ("four_leg", "step_decrease"),
    )  # fmt: skip
    return Finding(
        verdict(falls, falls and most == "four_leg"),
        f"falls by {fall['four_leg'].text(2)} % (4-Leg), {fall['step_decrease'].text(2)} % (Step Decrease); "
        f"{busy.text(2)} % for 4-Leg with a busy pilot",
        "Vertical speed enters the airspeed as its square over twice the airspeed. The good pilot's "
        f"{flown:.0f} ft/min rms (the busy one's "
        f"{Spread.of(evidence.flight('vertical_speed_fpm', 'four_leg', 'busy')).mean:.0f}) is worth less than "
        "0.01 kt and drowns in the noise. Multiplying the vertical speed of the same flights, a fall of 25 % in "
        f"4-Leg needs {_words(times, flown)}; within ±50 ft that is a climb and a dive every few seconds. With three "
        f"outputs instead of one the fall is {vector.text(2)} %. What moved the paper's simulator up and down so fast, "
        "its text does not say.",
        (chart, _steeper(evidence)),
        (_wander(evidence),),
    )


def _words(times: float, flown: float) -> str:
    if np.isinf(times):
        return f"more than {STEEPER[-1]:g} times that ({STEEPER[-1] * flown:.0f} ft/min rms)"
    return f"{times:.1f} times that ({times * flown:.0f} ft/min rms)"


def _wander(evidence: Evidence) -> pd.DataFrame:
    rows: dict[str, dict[str, object]] = {}
    for maneuver in PAPER_ORDER:
        row: dict[str, object] = {}
        for setting in ("autopilot", "smooth", "busy", "light"):
            speed = Spread.of(evidence.flight("vertical_speed_fpm", maneuver, setting))
            row[f"{setting}: vertical speed rms [ft/min]"] = speed.text(0)
            row[f"{setting}: fall with V_down [%]"] = _fall(evidence, maneuver, setting=setting).text(2)
        rows[maneuver] = row
    return named(rows)


def _turns(evidence: Evidence) -> Finding:
    def residual(**how: object) -> pd.Series:
        return evidence.residual("step_decrease", **how)

    without = percent(residual(down=False, on_condition=True), residual(down=False))
    along = percent(residual(on_condition=True), residual())
    fall = _fall(evidence, "step_decrease")
    kinds = [("full no", "full data, no V_down"), ("on no", "on condition, no V_down"),
             ("full down", "full data, V_down"), ("on down", "on condition, V_down")]  # fmt: skip

    def number(maneuver: str, kind: str) -> pd.Series:
        data, down = kind.split(" ")
        return evidence.residual(maneuver, on_condition=data == "on", down=down == "down")

    chart = maneuver_bars(
        "fig8-turns", "Fig 8: turn data, with and without V_down", "50/50 Hz, smooth air, a good pilot.",
        "2σ of the residual [kt]", kinds, number,
    )  # fmt: skip
    same = abs(without.mean) < _SAME and abs(along.mean) < _SAME
    decel = percent(evidence.residual("rapid_decel", on_condition=True), evidence.residual("rapid_decel"))
    return Finding(
        verdict(same, _UP_TO[0] <= fall.mean <= _UP_TO[1]),
        f"on-condition against full data {without.text(1)} % without and {along.text(1)} % with V_down; V_down itself "
        f"{-fall.mean:+.2f} %",
        "Turns in or out make no difference to Step Decrease, as published: the model needs only the size of the "
        f"velocity through the air. They do for Rapid Decel ({decel.mean:+.0f} %), whose turn is flown slowly, where "
        "a pascal of noise is worth more knots. That V_down does nothing is explained under C7.",
        (chart,),
    )


DOWN = Claim(
    "C7",
    "With V_down the 2σ falls; most for 4-Leg, least at the lowest rates",
    "Fig 7",
    f"falls by more than {_SEEN:g} % for 4-Leg and Step Decrease, most for 4-Leg",
    _with_down,
)
TURNS = Claim(
    "C8",
    "Full and on-condition data give the same; with V_down both are up to 25 % smaller and again the same",
    "Fig 8",
    f"within {_SAME:g} % of each other, and a fall of {_UP_TO[0]:g} to {_UP_TO[1]:g} % (in part: one of the two)",
    _turns,
)
