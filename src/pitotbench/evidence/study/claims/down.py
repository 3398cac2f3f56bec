"""C7 and C8: vertical GPS velocity, and turn data."""

import numpy as np
import pandas as pd

from pitotbench.evidence.pages.chart_data import Bars, Lines
from pitotbench.evidence.study.changes import MINUTE
from pitotbench.evidence.study.charting import maneuver_bars, maneuver_lines
from pitotbench.evidence.study.claims.claim import Claim, Finding, verdict
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER, named
from pitotbench.evidence.study.settings import SPECIFICATION, STEEP, STEEPER
from pitotbench.evidence.study.study_tables import Spread, StudyTables, percent_above, signed
from pitotbench.sense import SYSTEMS
from pitotbench.units import FOOT, KNOT

_RESIDUAL = "2σ of the residual [kt]"
_SEEN = 1.0  # %: a smaller fall counts as none
_SAME = 2.0  # %
_PUBLISHED = 25.0  # %
_UP_TO = (10.0, 40.0)  # %: our reading of "as much as 25 %"


def _fall(evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall of the 2σ with V_down [%], positive where it falls."""
    found = percent_above(evidence.residual(maneuver, **how), evidence.residual(maneuver, **{**how, "down": False}))
    return Spread(-found.mean, found.deviation, found.count)


def _needed(evidence: StudyTables, wanted: float) -> float:
    """Return the multiple of 4-Leg's vertical speed at which the fall reaches `wanted` percent; inf for none."""
    falls = [_fall(evidence, "four_leg", change="vertical speed", level=times).mean for times in STEEPER]
    return float(np.interp(wanted, falls, STEEPER)) if max(falls) >= wanted else float("inf")


def _steeper(evidence: StudyTables) -> Lines:
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


def _with_down(evidence: StudyTables) -> Finding:
    fall = {m: _fall(evidence, m) for m in PAPER_ORDER}
    most = max(fall, key=lambda m: fall[m].mean)
    falls = fall["four_leg"].mean > _SEEN and fall["step_decrease"].mean > _SEEN
    busy = _fall(evidence, "four_leg", setting="busy")
    return Finding(
        verdict(falls, falls and most == "four_leg"),
        f"falls by {fall['four_leg'].text(2)} % (4-Leg), {fall['step_decrease'].text(2)} % (Step Decrease); "
        f"{busy.text(2)} % for 4-Leg with a busy pilot",
        f"{_worth(evidence)} {_how_much(evidence)} {_at_rates(evidence)}",
        (_down_bars(evidence), _steeper(evidence)),
        (_wander(evidence),),
    )


def _worth(evidence: StudyTables) -> str:
    """Explain how large the effect can be at the vertical speeds of pilots, and how it shows with less noise."""
    good, hurried = (
        Spread.of(evidence.flight("vertical_speed_fpm", "four_leg", setting)).mean for setting in ("smooth", "busy")
    )
    worth = 0.5 * (hurried * FOOT / MINUTE) ** 2 / (100.0 * KNOT) / KNOT
    quiet = {"noise": SPECIFICATION, "gps_noise": SPECIFICATION}
    found = [_fall(evidence, "four_leg", setting=setting, **quiet).mean for setting in ("smooth", "busy")]
    vector = _fall(evidence, "four_leg", form="vector")
    form = ", so that it is not the form of the fit" if abs(vector.mean) < _SEEN else ""
    return (
        "Vertical speed enters the airspeed as its square over twice the airspeed. In 4-Leg the good pilot makes "
        f"{good:.0f} ft/min rms and the busy one {hurried:.0f}, worth {worth:.4f} kt at 100 kt against a residual "
        f"of {Spread.of(evidence.residual('four_leg')).mean:.2f} kt. Three experiments. With a tenth of the noise "
        f"of pressure and velocity the fall is {found[0]:.1f} % (good) and {found[1]:.1f} % (busy); with ground "
        f"velocity as three outputs it is {vector.text(2)} %{form}."
    )


def _how_much(evidence: StudyTables) -> str:
    """Explain how steep a path must be for the published fall."""
    times = _needed(evidence, _PUBLISHED)
    flown = Spread.of(evidence.flight("vertical_speed_fpm", "four_leg")).mean
    if np.isinf(times):
        return (
            "With the vertical speed of the same flights multiplied, 4-Leg does not reach a fall of "
            f"{_PUBLISHED:g} % at {STEEPER[-1]:g} times that."
        )
    # A sine of ±50 ft whose rms vertical speed is v has the period 2π · 50 ft / (√2 v).
    period = 2.0 * np.pi * 50.0 / (2.0**0.5 * times * flown) * MINUTE
    return (
        f"With the vertical speed of the same flights multiplied, a fall of {_PUBLISHED:g} % in 4-Leg needs "
        f"{times:.1f} times that, {times * flown:.0f} ft/min rms, which within ±50 ft is a climb and a dive every "
        f"{period:.0f} s throughout."
    )


def _at_rates(evidence: StudyTables) -> str:
    """Return the order of maneuvers and rates where the fall is large enough."""
    how: dict[str, object] = {"change": "vertical speed", "level": STEEP}
    fast = {m: _fall(evidence, m, **how).mean for m in PAPER_ORDER}
    slow = {m: _fall(evidence, m, das="20/1", given_down=True, **how).mean for m in PAPER_ORDER}
    less = sum(slow[m] < fast[m] for m in PAPER_ORDER)
    most = max(fast, key=lambda m: fast[m])
    return (
        f"At {STEEP:g} times the fall is {fast['four_leg']:.0f} % in 4-Leg, {fast['step_decrease']:.0f} % in Step "
        f"Decrease and largest in {NAMES[most]} ({fast[most]:.0f} %), and at 20/1 Hz (given a V_down for the "
        f"purpose) smaller than at 50/50 Hz in {less} of {len(fast)} maneuvers: 4-Leg {slow['four_leg']:.0f} %, "
        f"Step Decrease {slow['step_decrease']:.0f} %. What moved the paper's simulator up and down so fast, its "
        "text does not say."
    )


def _down_bars(evidence: StudyTables) -> Bars:
    sides = (False, True)
    kinds = [(f"{das} {on}", f"{das} Hz {'with' if on else 'without'} V_down") for das in SYSTEMS for on in sides]

    def number(maneuver: str, kind: str) -> pd.Series:
        das, down = kind.split(" ")
        return evidence.residual(maneuver, das=das, down=down == "True")

    title, note = "Fig 7: with and without V_down", "Smooth air, a good pilot. A 20/1 Hz system has no V_down."
    return maneuver_bars("fig7-down", title, note, _RESIDUAL, kinds, number, ("four_leg", "step_decrease"))


def _wander(evidence: StudyTables) -> pd.DataFrame:
    rows: dict[str, dict[str, object]] = {}
    for maneuver in PAPER_ORDER:
        row: dict[str, object] = {}
        for setting in ("autopilot", "smooth", "busy", "light", "moderate"):
            speed = Spread.of(evidence.flight("vertical_speed_fpm", maneuver, setting))
            row[f"{setting}: vertical speed rms [ft/min]"] = speed.text(0)
            row[f"{setting}: fall with V_down [%]"] = _fall(evidence, maneuver, setting=setting).text(2)
        rows[maneuver] = row
    return named(rows)


def _turns(evidence: StudyTables) -> Finding:
    def change(maneuver: str, down: bool) -> Spread:
        one = evidence.residual(maneuver, down=down, on_condition=True)
        return percent_above(one, evidence.residual(maneuver, down=down))

    without, along = change("step_decrease", False), change("step_decrease", True)
    fall, others = _fall(evidence, "step_decrease"), [change(m, True).mean for m in PAPER_ORDER]
    decel = others[PAPER_ORDER.index("rapid_decel")]
    steep = _fall(evidence, "step_decrease", change="vertical speed", level=STEEP)
    same = abs(without.mean) < _SAME and abs(along.mean) < _SAME
    return Finding(
        verdict(same, _UP_TO[0] <= fall.mean <= _UP_TO[1]),
        f"on-condition against full data {without.text(1)} % without and {along.text(1)} % with V_down; V_down "
        f"itself {Spread(-fall.mean, fall.deviation, fall.count).text(2)} %",
        f"{_same_words(same)} The scalar fit needs only the size of the velocity through the air, whose direction "
        f"may turn. On-condition data alone change the 2σ of the five maneuvers by {signed(min(others), 0)} to "
        f"{signed(max(others), 0)} %, that of Rapid Decel by {signed(decel, 0)} %: its turn is "
        "flown slowly, where a pascal of noise is worth more knots. What it takes for V_down to matter is measured "
        f"under C7: at {STEEP:g} times the vertical speed it lowers the 2σ of Step Decrease by {steep.text(0)} %.",
        (_turn_bars(evidence),),
    )


def _same_words(same: bool) -> str:
    return f"For Step Decrease turns in or out make {'no' if same else 'a'} difference of {_SAME:g} % or more."


def _turn_bars(evidence: StudyTables) -> Bars:
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
