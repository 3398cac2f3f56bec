"""The claims about vertical velocity and about turns."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from pitotbench.sensing.sampling import SYSTEMS
from pitotbench.units import FOOT, KNOT
from pitotlab.study.parts import Bars, BarSeries, Lines
from pitotlab.study.questions import (
    LIMIT,
    Claim,
    Finding,
    TwoSigma,
    Verdict,
    airspeed_fall,
    airspeed_two_sigma,
    pooled_fall,
    pooled_two_sigma,
    verdict,
)
from pitotlab.study.reductions import (
    MINUTE,
    NAMES,
    PAPER_ORDER,
    SPECIFICATION,
    STEEP,
    STEEPER,
    named,
)
from pitotlab.study.tables import (
    CUT,
    Spread,
    StudyTables,
    bar_series,
    maneuver_lines,
    percent_above,
    signed,
)

_SEEN = 1.0  # %: a smaller fall, or a smaller difference of two falls, counts as none
_PUBLISHED = 25.0  # %
_SHOWN = ("four_leg", "step_decrease")  # of Fig 7
_AXES = ("north", "east", "down")
Fall = Callable[..., Spread]


def _held(evidence: StudyTables, found: Fall) -> tuple[bool, bool, bool]:
    """Return the parts of the claim: the 2σ falls, most for 4-Leg, least at 20/1 Hz."""
    fast, slow = (
        {m: found(evidence, m, das=das).mean for m in PAPER_ORDER} for das in ("50/50", "20/1")
    )
    falls = all(fast[m] > _SEEN for m in _SHOWN)
    rest = max(fast[m] for m in PAPER_ORDER if m != "four_leg")
    return (
        falls,
        falls and fast["four_leg"] > rest + _SEEN,
        falls and all(slow[m] < fast[m] - _SEEN for m in _SHOWN),
    )


def _with_down(evidence: StudyTables) -> Finding:
    air, pooled = airspeed_fall, pooled_fall
    parts = max(_held(evidence, air), _held(evidence, pooled), key=sum)
    slow = {m: pooled(evidence, m, das="20/1") for m in _SHOWN}
    return Finding(
        verdict(*parts),
        f"2σ of the airspeed: falls by {_both(evidence, air)}. 2σ pooled over the outputs: falls "
        "by "
        f"{_both(evidence, pooled)}; at 20/1 Hz by {slow['four_leg'].text(1)} % and "
        f"{slow['step_decrease'].text(1)} %",
        "Fit ground velocity as two outputs (north, east) and as three (with down), with noise on "
        "the impact "
        "pressure alone, as in the paper, and pool the 2σ over the outputs. Repeat with noise on "
        "every sensor. "
        "Compare with the 2σ of the airspeed, as flown, with a tenth of the noise, and with the "
        "vertical speed of "
        "the same flights multiplied.",
        f"{_pooled_words(evidence)} {_worth(evidence)} {_how_much(evidence)} {_at_rates(evidence)}",
        (_ratios(evidence), _steeper(evidence)),
        (_outputs(evidence), _wander(evidence)),
    )


def _both(evidence: StudyTables, found: Fall) -> str:
    leg, step = (found(evidence, m) for m in _SHOWN)
    return f"{leg.text(1)} % (4-Leg) and {step.text(1)} % (Step Decrease)"


def _pooled_words(evidence: StudyTables) -> str:
    """Explain the fall of the pooled 2σ, and what it leaves unexplained."""
    every = [pooled_fall(evidence, m).mean for m in PAPER_ORDER]
    each = {axis: Spread.of(_output(evidence, "step_decrease", axis)).mean for axis in _AXES}
    noisy = [pooled_fall(evidence, m, alone=False).mean for m in PAPER_ORDER]
    moved = "rises" if max(noisy) < 0.0 else "changes"
    return (
        "The pooled 2σ falls because of how it is computed. No noise reaches the third output: in "
        "Step Decrease "
        f"the 2σ of the residual is {each['north']:.2f} kt north, {each['east']:.2f} kt east and "
        f"{each['down']:.3f} kt down. An output without residual lowers the mean over three "
        "outputs by "
        f"{LIMIT:.1f} %, and the curve is known no better. The fall is {min(every):.1f} to "
        f"{max(every):.1f} % in "
        "all five maneuvers, so it does not explain why the paper has most for 4-Leg and least at "
        "20/1 Hz. With "
        f"noise on every sensor the pooled 2σ {moved} instead, by {-max(noisy):.0f} to "
        f"{-min(noisy):.0f} %, "
        "because attitude and vanes put noise on the third output."
    )


def _worth(evidence: StudyTables) -> str:
    """Explain how large the effect on airspeed can be at the vertical speeds of pilots."""
    good, hurried = (
        Spread.of(evidence.flight("vertical_speed_fpm", "four_leg", setting)).mean
        for setting in ("smooth", "busy")
    )
    worth = 0.5 * (hurried * FOOT / MINUTE) ** 2 / (100.0 * KNOT) / KNOT
    quiet = {"noise": SPECIFICATION, "gps_noise": SPECIFICATION}
    found = [
        airspeed_fall(evidence, "four_leg", setting=setting, **quiet).mean
        for setting in ("smooth", "busy")
    ]
    return (
        "The 2σ of the airspeed hardly changes, because vertical speed enters the airspeed as its "
        "square over "
        f"twice the airspeed. In 4-Leg the good pilot makes {good:.0f} ft/min rms and the busy one "
        f"{hurried:.0f}. "
        f"That is {worth:.4f} kt at 100 kt, and the residual has "
        f"{Spread.of(evidence.residual('four_leg')).mean:.2f} kt. With a tenth of the noise of "
        "pressure and "
        f"velocity the fall is {found[0]:.1f} % (good) and {found[1]:.1f} % (busy)."
    )


def _how_much(evidence: StudyTables) -> str:
    """Explain how steep a path must be for the published fall of the airspeed's 2σ."""
    falls = [
        airspeed_fall(evidence, "four_leg", change="vertical speed", level=times).mean
        for times in STEEPER
    ]
    if max(falls) < _PUBLISHED:
        return (
            "With the vertical speed of the same flights multiplied, 4-Leg does not reach a fall "
            "of "
            f"{_PUBLISHED:g} % at {STEEPER[-1]:g} times that."
        )
    times = float(np.interp(_PUBLISHED, falls, STEEPER))
    flown = Spread.of(evidence.flight("vertical_speed_fpm", "four_leg")).mean
    # A sine of ±50 ft whose rms vertical speed is v has the period 2π · 50 ft / (√2 v).
    period = 2.0 * np.pi * 50.0 / (2.0**0.5 * times * flown) * MINUTE
    return (
        f"With the vertical speed of the same flights multiplied, a fall of {_PUBLISHED:g} % in "
        "4-Leg needs "
        f"{times:.1f} times that, {times * flown:.0f} ft/min rms. Within ±50 ft this is a climb "
        "and a dive every "
        f"{period:.0f} s throughout."
    )


def _at_rates(evidence: StudyTables) -> str:
    """Return the order of maneuvers and rates where the fall is large enough."""
    how: dict[str, object] = {"change": "vertical speed", "level": STEEP}
    fast = {m: airspeed_fall(evidence, m, **how).mean for m in PAPER_ORDER}
    slow = {
        m: airspeed_fall(evidence, m, das="20/1", given_down=True, **how).mean for m in PAPER_ORDER
    }
    less = sum(slow[m] < fast[m] for m in PAPER_ORDER)
    most = max(fast, key=lambda m: fast[m])
    return (
        f"At {STEEP:g} times the vertical speed the fall is {fast['four_leg']:.0f} % in 4-Leg and "
        f"{fast['step_decrease']:.0f} % in Step Decrease, and largest in {NAMES[most]} "
        f"({fast[most]:.0f} %). At "
        f"20/1 Hz, given a V_down for the purpose, it is smaller than at 50/50 Hz in {less} of "
        f"{len(fast)} "
        "maneuvers."
    )


def _ratios(evidence: StudyTables) -> Bars:
    """Draw Fig 7 as ratios: one dot for each maneuver, data system and kind of 2σ."""

    def series(maneuver: str, two_sigma: TwoSigma, label: str) -> BarSeries:
        with_down, without = (
            [two_sigma(evidence, maneuver, das=das, down=down) for das in SYSTEMS]
            for down in (True, False)
        )
        return bar_series(
            f"{NAMES[maneuver]}, {label}", [a / b for a, b in zip(with_down, without, strict=True)]
        )

    return Bars(
        "Fig 7: the 2σ with V_down over that without",
        "Smooth air, a good pilot. 1 is no change. A 20/1 Hz system has no V_down of its own. "
        f"{CUT}",
        "2σ with / without V_down [-]",
        [f"{das}\nHz" for das in SYSTEMS],
        [
            series(m, two_sigma, label)
            for two_sigma, label in ((airspeed_two_sigma, "airspeed"), (pooled_two_sigma, "pooled"))
            for m in _SHOWN
        ],
        "fig7-down",
        dots=True,
    )


def _steeper(evidence: StudyTables) -> Lines:
    levels = (1.0, *STEEPER)

    def fall(maneuver: str, times: float) -> pd.Series:
        how = {"change": "vertical speed", "level": times} if times > 1.0 else {}
        with_down = evidence.residual(maneuver, **how)
        return -100.0 * (with_down / evidence.residual(maneuver, **{**how, "down": False}) - 1.0)

    return maneuver_lines(
        "c7-vertical-speed",
        "How much vertical speed it takes",
        "The same smooth-air flights with their vertical speed multiplied and the airspeed kept; "
        "50/50 Hz.",
        "vertical speed, times what the good pilot flew [-]",
        "fall of the airspeed's 2σ [%]",
        levels,
        fall,
    )


def _output(evidence: StudyTables, maneuver: str, axis: str) -> pd.Series:
    return pooled_two_sigma(evidence, maneuver, column=f"two_sigma_{axis}_kt")


def _outputs(evidence: StudyTables) -> pd.DataFrame:
    """Return the 2σ of each output and pooled, 50/50 Hz, and the falls with V_down."""

    def row_of(m: str) -> dict[str, object]:
        row: dict[str, object] = {
            f"2σ {a} [kt]": Spread.of(_output(evidence, m, a)).text(3) for a in _AXES
        }
        for down, label in ((False, "two outputs"), (True, "three outputs")):
            pooled = Spread.of(pooled_two_sigma(evidence, m, down=down))
            row[f"pooled, {label} [kt]"] = pooled.text(3)
        row |= {
            f"fall at {das} Hz [%]": pooled_fall(evidence, m, das=das).text(1) for das in SYSTEMS
        }
        return row | {
            "fall at 50/50 Hz, noise on every sensor [%]": pooled_fall(
                evidence, m, alone=False
            ).text(1)
        }

    return named(row_of)


def _wander(evidence: StudyTables) -> pd.DataFrame:
    def row_of(m: str) -> dict[str, object]:
        row: dict[str, object] = {}
        for air in ("autopilot", "smooth", "busy", "light", "moderate"):
            speed = Spread.of(evidence.flight("vertical_speed_fpm", m, air))
            row[f"{air}: vertical speed rms [ft/min]"] = speed.text(0)
            row[f"{air}: fall of the airspeed's 2σ [%]"] = airspeed_fall(
                evidence, m, setting=air
            ).text(2)
        return row

    return named(row_of)


DOWN = Claim(
    "C7",
    "With V_down the 2σ falls; most for 4-Leg, least at the lowest rates",
    "Fig 7",
    f"the 2σ of the airspeed, or pooled over the outputs, falls by more than {_SEEN:g} % for 4-Leg "
    "and Step "
    f"Decrease, by {_SEEN:g} point more for 4-Leg than for the others, and by {_SEEN:g} point less "
    "at 20/1 Hz (in "
    "part: it falls)",
    _with_down,
)


_SAME = 2.0  # %
_UP_TO = (10.0, 40.0)  # %: our reading of "as much as 25 %"
_FLOWN = "step_decrease"  # the maneuver of Fig 8
_KINDS: dict[str, TwoSigma] = {"airspeed": airspeed_two_sigma, "pooled": pooled_two_sigma}


def _change(two_sigma: TwoSigma, evidence: StudyTables, maneuver: str, down: bool) -> Spread:
    """Return the 2σ of on-condition data relative to that of all data, minus one [%]."""
    one = two_sigma(evidence, maneuver, down=down, on_condition=True)
    return percent_above(one, two_sigma(evidence, maneuver, down=down))


def _verdict(same: dict[str, bool], falls: dict[str, bool]) -> Verdict:
    """Both parts in the 2σ of airspeed reproduce the claim; one of them, or both in the pooled 2σ,
    do in part.
    """
    if same["airspeed"] and falls["airspeed"]:
        return "reproduced"
    some = same["airspeed"] or falls["airspeed"] or (same["pooled"] and falls["pooled"])
    return "in part" if some else "not reproduced"


def _turns(evidence: StudyTables) -> Finding:
    change = {
        kind: [_change(two_sigma, evidence, _FLOWN, down) for down in (False, True)]
        for kind, two_sigma in _KINDS.items()
    }
    fall = {"airspeed": airspeed_fall(evidence, _FLOWN), "pooled": pooled_fall(evidence, _FLOWN)}
    same = {kind: all(abs(s.mean) < _SAME for s in both) for kind, both in change.items()}
    falls = {kind: _UP_TO[0] <= found.mean <= _UP_TO[1] for kind, found in fall.items()}
    straight = pooled_fall(evidence, _FLOWN, on_condition=True)
    others = [_change(airspeed_two_sigma, evidence, m, True).mean for m in PAPER_ORDER]
    decel = others[PAPER_ORDER.index("rapid_decel")]
    alike = {
        kind: f"{both[0].text(1)} % without and {both[1].text(1)} % with V_down"
        for kind, both in change.items()
    }
    return Finding(
        _verdict(same, falls),
        f"on-condition against full data, 2σ of the airspeed {alike['airspeed']}; pooled over the "
        "outputs "
        f"{alike['pooled']}. V_down lowers the first by {fall['airspeed'].text(1)} % and the "
        "second by "
        f"{fall['pooled'].text(1)} % (full data) and {straight.text(1)} % (on condition)",
        "Fit all data and on-condition data of Step Decrease, with and without V_down. Compute the "
        "2σ of the "
        "airspeed, and pooled over the outputs as for C7.",
        f"{_words(same)} A fit of airspeed uses the size of the velocity through the air, and its "
        "direction may "
        "turn. The fall with V_down is that of C7: an output without residual lowers the mean over "
        "the outputs in "
        "turns and on straight legs alike. It cannot reach the published 25 %. On-condition data "
        "alone change the "
        f"2σ of the airspeed by {signed(min(others), 0)} to {signed(max(others), 0)} % over the "
        "five maneuvers. "
        f"Rapid Decel changes by {signed(decel, 0)} %: its turn is flown slowly, where a pascal of "
        "noise is more "
        "knots.",
        (_dots(evidence),),
        (_table(evidence),),
    )


def _words(same: dict[str, bool]) -> str:
    if all(same.values()):
        return f"Turns in or out change either 2σ by less than {_SAME:g} %."
    if not any(same.values()):
        return f"Turns in or out change both by {_SAME:g} % or more."
    unchanged, changed = ("airspeed", "pooled") if same["airspeed"] else ("pooled", "airspeed")
    return (
        f"Turns in or out change the {changed} 2σ by {_SAME:g} % or more, the {unchanged} 2σ "
        "by less."
    )


def _dots(evidence: StudyTables) -> Bars:
    """Draw Fig 8 for both kinds of 2σ of Step Decrease."""
    series = []
    for on, data in ((False, "full data"), (True, "on condition")):
        for down, label in ((False, "no V_down"), (True, "V_down")):
            found = [two(evidence, _FLOWN, down=down, on_condition=on) for two in _KINDS.values()]
            series.append(bar_series(f"{data}, {label}", found))
    return Bars(
        "Fig 8: turn data, with and without V_down",
        f"Step Decrease, 50/50 Hz, smooth air, a good pilot. {CUT}",
        "2σ of the residual [kt]",
        ["of the\nairspeed", "pooled over\nthe outputs"],
        series,
        "fig8-turns",
        dots=True,
    )


def _table(evidence: StudyTables) -> pd.DataFrame:
    columns = {
        f"{kind}: on-condition against full data, {'V_down' if down else 'no V_down'} [%]": (
            two_sigma,
            down,
        )
        for kind, two_sigma in _KINDS.items()
        for down in (False, True)
    }
    return named(
        lambda m: {
            name: _change(two, evidence, m, down).text(1) for name, (two, down) in columns.items()
        }
    )


TURNS = Claim(
    "C8",
    "Full and on-condition data give the same; with V_down both are up to 25 % smaller and again "
    "the same",
    "Fig 8",
    f"on-condition and full data within {_SAME:g} % of each other, and a fall of {_UP_TO[0]:g} to "
    f"{_UP_TO[1]:g} % "
    "with V_down, in the 2σ of the airspeed (in part: one of the two, or both in the 2σ pooled "
    "over the outputs "
    "alone)",
    _turns,
)
