"""C7 and C8: vertical GPS velocity, and turn data."""

import numpy as np
import pandas as pd

from pitotbench.show.chart import Bars, Lines
from pitotbench.study.charting import maneuver_bars, maneuver_lines
from pitotbench.study.claims.claim import Claim, Finding, verdict
from pitotbench.study.evidence import Evidence, Spread, percent
from pitotbench.study.flights import STEEPER, SYSTEMS
from pitotbench.study.names import PAPER_ORDER, named

_RESIDUAL = "2σ of the residual [kt]"
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
    busy, vector = _fall(evidence, "four_leg", setting="busy"), _fall(evidence, "four_leg", form="vector")
    hurried = Spread.of(evidence.flight("vertical_speed_fpm", "four_leg", "busy")).mean
    times, flown = _needed(evidence, 25.0)
    return Finding(
        verdict(falls, falls and most == "four_leg"),
        f"falls by {fall['four_leg'].text(2)} % (4-Leg), {fall['step_decrease'].text(2)} % (Step Decrease); "
        f"{busy.text(2)} % for 4-Leg with a busy pilot",
        f"Vertical speed enters the airspeed as its square over twice the airspeed. The good pilot's {flown:.0f} "
        f"ft/min rms (the busy one's {hurried:.0f}) is worth less than 0.01 kt and drowns in the noise. "
        "Multiplying the vertical speed of the same flights, a fall of 25 % in 4-Leg needs "
        f"{_words(times, flown)}; within ±50 ft that is a climb and a dive every few seconds. Nor is it the form "
        f"of the fit: with ground velocity as three outputs the fall is {vector.text(2)} %. What moved the "
        "paper's simulator up and down so fast, its text does not say.",
        (_down_bars(evidence), _steeper(evidence)),
        (_wander(evidence),),
    )


def _down_bars(evidence: Evidence) -> Bars:
    sides = (False, True)
    kinds = [(f"{das} {on}", f"{das} Hz {'with' if on else 'without'} V_down") for das in SYSTEMS for on in sides]

    def number(maneuver: str, kind: str) -> pd.Series:
        das, down = kind.split(" ")
        return evidence.residual(maneuver, das=das, down=down == "True")

    title, note = "Fig 7: with and without V_down", "Smooth air, a good pilot. A 20/1 Hz system has no V_down."
    return maneuver_bars("fig7-down", title, note, _RESIDUAL, kinds, number, ("four_leg", "step_decrease"))


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
    def change(maneuver: str, down: bool) -> Spread:
        one = evidence.residual(maneuver, down=down, on_condition=True)
        return percent(one, evidence.residual(maneuver, down=down))

    without, along = change("step_decrease", False), change("step_decrease", True)
    fall, decel = _fall(evidence, "step_decrease"), change("rapid_decel", True)
    same = abs(without.mean) < _SAME and abs(along.mean) < _SAME
    return Finding(
        verdict(same, _UP_TO[0] <= fall.mean <= _UP_TO[1]),
        f"on-condition against full data {without.text(1)} % without and {along.text(1)} % with V_down; V_down "
        f"itself {Spread(-fall.mean, fall.deviation, fall.count).text(2)} %",
        "Turns in or out make no difference to Step Decrease, as published: the model needs only the size of "
        f"the velocity through the air. They do for Rapid Decel ({decel.text(0)} %), whose turn is flown slowly, "
        "where a pascal of noise is worth more knots. That V_down does nothing is explained under C7.",
        (_turn_bars(evidence),),
    )


def _turn_bars(evidence: Evidence) -> Bars:
    kinds = [
        ("full no", "full data, no V_down"),
        ("on no", "on condition, no V_down"),
        ("full down", "full data, V_down"),
        ("on down", "on condition, V_down"),
    ]

    def number(maneuver: str, kind: str) -> pd.Series:
        data, down = kind.split(" ")
        return evidence.residual(maneuver, on_condition=data == "on", down=down == "down")

    title = "Fig 8: turn data, with and without V_down"
    return maneuver_bars("fig8-turns", title, "50/50 Hz, smooth air, a good pilot.", _RESIDUAL, kinds, number)


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
