"""The claims about vertical velocity and about turns."""

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
import pandas as pd

from pitotbench.sensing.sampling import SYSTEMS
from pitotbench.units import FOOT, KNOT
from pitotlab.study.questions import Claim, Finding
from pitotlab.study.reductions import (
    MINUTE,
    NAMES,
    PAPER_ORDER,
    SPECIFICATION,
    STEEP,
    STEEPER,
    named,
)
from pitotlab.study.rules import RULES, SAME
from pitotlab.study.tables import (
    Spread,
    StudyTables,
    mean,
    percent_above,
    signed,
    text,
)

_PUBLISHED = 25.0  # %
_SHOWN = ("four_leg", "step_decrease")  # of Fig 7
_SLOWEST_FIRST = ("20/1", "50/50", "100/100")
_AXES = ("north", "east", "down")
# %: fall of a pooled 2σ where a third output has no residual
_THIRD_OUTPUT = 100.0 * (1.0 - (2.0 / 3.0) ** 0.5)
_FLOWN = "step_decrease"  # the maneuver of Fig 8
TwoSigma = Callable[..., pd.Series]  # evidence, maneuver, settings → by seed


def pooled_two_sigma(
    evidence: StudyTables,
    maneuver: str,
    column: str = "pooled_two_sigma_kt",
    alone: bool = True,
    **how: object,
) -> pd.Series:
    """Return 2σ pooled over the outputs [kt of true airspeed] by seed, noise on the impact pressure
    alone.

    `column` names another number of the same fits. With `alone=False` every sensor has its noise.
    """
    return evidence.fit(column, maneuver, form="vector", alone=alone, given_down=alone, **how)


KINDS: Mapping[str, TwoSigma] = {"airspeed": StudyTables.residual, "pooled": pooled_two_sigma}


def fall(kind: str, evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall of a kind of 2σ with V_down [%], positive where it falls."""
    without, found = (KINDS[kind](evidence, maneuver, **how | {"down": d}) for d in (False, True))
    change = percent_above(found, without)
    return Spread(-change.mean, change.deviation, change.count)


@partial(Claim, RULES["C7"])
def down(evidence: StudyTables) -> Finding:
    ordered = (*_SHOWN, *(m for m in PAPER_ORDER if m not in _SHOWN))
    falls = {
        das: [fall("airspeed", evidence, m, das=das).mean for m in ordered]
        for das in _SLOWEST_FIRST
    }
    both = {}
    for kind in KINDS:
        leg, step = (fall(kind, evidence, m).text(1) for m in _SHOWN)
        both[kind] = f"{leg} % (4-Leg) and {step} % (Step Decrease)"
    slow = {m: fall("pooled", evidence, m, das="20/1").text(1) for m in _SHOWN}
    return Finding(
        RULES["C7"].judge(falls),
        f"2σ of the airspeed, which is judged: falls by {both['airspeed']}. 2σ pooled over the outputs: "
        f"falls by {both['pooled']}; at 20/1 Hz by {slow['four_leg']} % and {slow['step_decrease']} %",
        "Fit ground velocity as two outputs (north, east) and as three (with down), with noise on "
        "the impact pressure alone, as in the paper, and pool the 2σ over the outputs. Repeat with "
        "noise on every sensor. Compare with the 2σ of the airspeed, as flown, with a tenth of the "
        "noise, and with the vertical speed of the same flights multiplied.",
        f"{_pooled_words(evidence)} {_worth(evidence)} {_how_much(evidence)} {_at_rates(evidence)}",
        (_outputs(evidence), _wander(evidence)),
    )


def _output(evidence: StudyTables, maneuver: str, axis: str) -> pd.Series:
    return pooled_two_sigma(evidence, maneuver, f"two_sigma_{axis}_kt")


def _pooled_words(evidence: StudyTables) -> str:
    """Explain the fall of the pooled 2σ, and what it leaves unexplained."""
    every = [fall("pooled", evidence, m).mean for m in PAPER_ORDER]
    each = {axis: mean(_output(evidence, "step_decrease", axis)) for axis in _AXES}
    noisy = [fall("pooled", evidence, m, alone=False).mean for m in PAPER_ORDER]
    moved = "rises" if max(noisy) < 0.0 else "changes"
    return (
        "The pooled 2σ falls because of how it is computed. No noise reaches the third output: in "
        f"Step Decrease the 2σ of the residual is {each['north']:.2f} kt north, {each['east']:.2f} "
        f"kt east and {each['down']:.3f} kt down. An output without residual lowers the mean over "
        f"three outputs by {_THIRD_OUTPUT:.1f} %, and the curve is known no better. The fall is "
        f"{min(every):.1f} to {max(every):.1f} % in all five maneuvers, so it does not explain why "
        "the paper has most for 4-Leg and least at 20/1 Hz. With noise on every sensor the pooled "
        f"2σ {moved} instead, by {-max(noisy):.0f} to {-min(noisy):.0f} %, because attitude and "
        "vanes put noise on the third output."
    )


def _worth(evidence: StudyTables) -> str:
    """Explain how large the effect on airspeed can be at the vertical speeds of pilots."""
    pilots = ("smooth", "busy")
    good, hurried = (mean(evidence.flight("vertical_speed_fpm", "four_leg", p)) for p in pilots)
    worth = 0.5 * (hurried * FOOT / MINUTE) ** 2 / (100.0 * KNOT) / KNOT
    quiet = {"noise": SPECIFICATION, "gps_noise": SPECIFICATION}
    found = [fall("airspeed", evidence, "four_leg", setting=p, **quiet).mean for p in pilots]
    return (
        "The 2σ of the airspeed hardly changes, because vertical speed enters the airspeed as its "
        f"square over twice the airspeed. In 4-Leg the good pilot makes {good:.0f} ft/min rms and "
        f"the busy one {hurried:.0f}. That is {worth:.4f} kt at 100 kt, and the residual has "
        f"{mean(evidence.residual('four_leg')):.2f} kt. With a tenth of the noise of pressure and "
        f"velocity the fall is {found[0]:.1f} % (good) and {found[1]:.1f} % (busy)."
    )


def _how_much(evidence: StudyTables) -> str:
    """Explain how steep a path must be for the published fall of the airspeed's 2σ."""
    steep = partial(fall, "airspeed", evidence, "four_leg", change="vertical speed")
    falls = [steep(level=times).mean for times in STEEPER]
    if max(falls) < _PUBLISHED:
        return (
            "With the vertical speed of the same flights multiplied, 4-Leg does not reach a fall "
            f"of {_PUBLISHED:g} % at {STEEPER[-1]:g} times that."
        )
    times = float(np.interp(_PUBLISHED, falls, STEEPER))
    flown = times * mean(evidence.flight("vertical_speed_fpm", "four_leg"))
    # A sine of ±50 ft whose rms vertical speed is v has the period 2π · 50 ft / (√2 v).
    period = 2.0 * np.pi * 50.0 / (2.0**0.5 * flown) * MINUTE
    return (
        f"With the vertical speed of the same flights multiplied, a fall of {_PUBLISHED:g} % in "
        f"4-Leg needs {times:.1f} times that, {flown:.0f} ft/min rms. Within ±50 ft this is a climb "
        f"and a dive every {period:.0f} s throughout."
    )


def _at_rates(evidence: StudyTables) -> str:
    """Return the order of maneuvers and rates where the fall is large enough."""
    steep = partial(fall, "airspeed", evidence, change="vertical speed", level=STEEP)
    fast = {m: steep(m).mean for m in PAPER_ORDER}
    less = sum(steep(m, das="20/1", given_down=True).mean < fast[m] for m in PAPER_ORDER)
    most = max(fast, key=lambda m: fast[m])
    return (
        f"At {STEEP:g} times the vertical speed the fall is {fast['four_leg']:.0f} % in 4-Leg and "
        f"{fast['step_decrease']:.0f} % in Step Decrease, and largest in {NAMES[most]} "
        f"({fast[most]:.0f} %). At 20/1 Hz, given a V_down for the purpose, it is smaller than at "
        f"50/50 Hz in {less} of {len(fast)} maneuvers."
    )


def _outputs(evidence: StudyTables) -> pd.DataFrame:
    """Return the 2σ of each output and pooled, 50/50 Hz, and the falls with V_down."""

    def row(m: str) -> dict[str, object]:
        falls = partial(fall, "pooled", evidence, m)
        return {
            **{f"2σ {axis} [kt]": text(_output(evidence, m, axis), 3) for axis in _AXES},
            "pooled, two outputs [kt]": text(pooled_two_sigma(evidence, m, down=False), 3),
            "pooled, three outputs [kt]": text(pooled_two_sigma(evidence, m), 3),
            **{f"fall at {das} Hz [%]": falls(das=das).text(1) for das in SYSTEMS},
            "fall at 50/50 Hz, noise on every sensor [%]": falls(alone=False).text(1),
        }

    return named(row)


def _wander(evidence: StudyTables) -> pd.DataFrame:
    def row(m: str) -> dict[str, object]:
        cells: dict[str, object] = {}
        for air in ("autopilot", "smooth", "busy", "light", "moderate"):
            speed = evidence.flight("vertical_speed_fpm", m, air)
            cells[f"{air}: vertical speed rms [ft/min]"] = text(speed, 0)
            falls = fall("airspeed", evidence, m, setting=air)
            cells[f"{air}: fall of the airspeed's 2σ [%]"] = falls.text(2)
        return cells

    return named(row)


def _change(
    kind: str, evidence: StudyTables, maneuver: str, down: bool, das: str = "50/50"
) -> Spread:
    """Return the 2σ of on-condition data relative to that of all data, minus one [%]."""
    two_sigma = partial(KINDS[kind], evidence, maneuver, down=down, das=das)
    return percent_above(two_sigma(on_condition=True), two_sigma())


@partial(Claim, RULES["C8"])
def turns(evidence: StudyTables) -> Finding:
    change = {kind: [_change(kind, evidence, _FLOWN, d) for d in (False, True)] for kind in KINDS}
    every = [
        _change("airspeed", evidence, _FLOWN, d, das=das).mean
        for das in SYSTEMS
        for d in (False, True)
    ]
    most = [
        fall("airspeed", evidence, _FLOWN, das=das, on_condition=on).mean
        for das in SYSTEMS
        for on in (False, True)
    ]
    falls = {kind: fall(kind, evidence, _FLOWN) for kind in KINDS}
    same = {kind: all(abs(s.mean) < SAME for s in both) for kind, both in change.items()}
    straight = fall("pooled", evidence, _FLOWN, on_condition=True)
    others = [_change("airspeed", evidence, m, True).mean for m in PAPER_ORDER]
    alike = {
        kind: f"{both[0].text(1)} % without and {both[1].text(1)} % with V_down"
        for kind, both in change.items()
    }
    return Finding(
        RULES["C8"].judge(every, most),
        f"on-condition against full data, 2σ of the airspeed {alike['airspeed']} at 50/50 Hz, "
        f"{max(map(abs, every)):.1f} % at most at any data rate; largest fall with V_down "
        f"{max(most):.1f} %. Pooled over the outputs {alike['pooled']}. V_down lowers the first by "
        f"{falls['airspeed'].text(1)} % and the second by {falls['pooled'].text(1)} % (full data) "
        f"and {straight.text(1)} % (on condition)",
        "Fit all data and on-condition data of Step Decrease, with and without V_down. Compute the "
        "2σ of the airspeed, and pooled over the outputs as for C7.",
        f"{_words(same)} A fit of airspeed uses the size of the velocity through the air, and its "
        "direction may turn. The fall with V_down is that of C7: an output without residual lowers "
        "the mean over the outputs in turns and on straight legs alike. It cannot reach the "
        "published 25 %. On-condition data alone change the 2σ of the airspeed by "
        f"{signed(min(others), 0)} to {signed(max(others), 0)} % over the five maneuvers. Rapid "
        f"Decel changes by {signed(others[PAPER_ORDER.index('rapid_decel')], 0)} %: its turn is "
        "flown slowly, where a pascal of noise is more knots.",
        (_table(evidence),),
    )


def _words(same: Mapping[str, bool]) -> str:
    if all(same.values()):
        return f"Turns in or out change either 2σ by less than {SAME:g} %."
    if not any(same.values()):
        return f"Turns in or out change both by {SAME:g} % or more."
    changed, unchanged = sorted(KINDS, key=lambda kind: same[kind])
    return f"Turns in or out change the {changed} 2σ by {SAME:g} % or more, the {unchanged} 2σ by less."


def _table(evidence: StudyTables) -> pd.DataFrame:
    columns = [(kind, down) for kind in KINDS for down in (False, True)]

    def row(m: str) -> dict[str, object]:
        return {
            f"{kind}: on-condition against full data, {'V_down' if down else 'no V_down'} [%]": (
                _change(kind, evidence, m, down).text(1)
            )
            for kind, down in columns
        }

    return named(row)
