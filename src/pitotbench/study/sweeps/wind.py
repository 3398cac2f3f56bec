"""How much may the wind change, in time and with altitude?"""

import numpy as np
import pandas as pd

from pitotbench.calibrate import CalibrationOptions
from pitotbench.study.charting import maneuver_lines
from pitotbench.study.evidence import Evidence, Spread
from pitotbench.study.look import COVERING, Look
from pitotbench.study.names import NAMES, PAPER_ORDER, named
from pitotbench.study.sweeps.sweep import Reply, Sweep, rms

RATES = (0.1, 0.3, 1.0)  # kt a minute
SHEARS = (1.0, 3.0, 10.0)  # kt a hundred feet
DRIFTING = CalibrationOptions(wind="drifting")
_TOLERATED = 2.0  # times the rms error of a constant wind


def looks(maneuver: str) -> tuple[Look, ...]:
    """Every rate with a constant and with a drifting wind in the model; every shear."""
    changing = [Look("50/50", o, "wind change", rate) for rate in RATES for o in (COVERING, DRIFTING)]
    return (*changing, *(Look("50/50", COVERING, "shear", size) for size in SHEARS), Look("50/50", DRIFTING))


def _error(evidence: Evidence, maneuver: str, change: str, level: float, wind: str = "constant") -> pd.Series:
    how: dict[str, object] = {"change": change, "level": level} if level else {}
    found = evidence.fit("rms_error_kt", maneuver, setting="light", method="covering", wind=wind, **how)
    few = evidence.fit("rms_error_kt", maneuver, setting="light", method="covering", wind="drifting").index
    return found[found.index.isin(few)]


def _tolerated(evidence: Evidence, maneuver: str, change: str, levels: tuple[float, ...]) -> float:
    """The level at which the rms error over seeds is twice that of a constant wind; inf where none is."""
    still = rms(_error(evidence, maneuver, change, 0.0))
    errors = np.array([rms(_error(evidence, maneuver, change, level)) / still for level in levels])
    beyond = np.flatnonzero(errors > _TOLERATED)
    if not len(beyond):
        return float("inf")
    i = int(beyond[0])
    before, level_before = (1.0, 0.0) if i == 0 else (errors[i - 1], levels[i - 1])
    return float(level_before + (levels[i] - level_before) * (_TOLERATED - before) / (errors[i] - before))


def _above(value: float, largest: float) -> str:
    return f"> {largest:g}" if np.isinf(value) else f"{value:.2f}"


def _refused(evidence: Evidence, maneuver: str) -> int:
    found = evidence.fit("coverage", maneuver, setting="light", method="covering", wind="drifting",
                         change="wind change", level=RATES[-1])  # fmt: skip
    return int(found.isna().sum())


def _answer(evidence: Evidence) -> Reply:
    limit = {m: _tolerated(evidence, m, "wind change", RATES) for m in PAPER_ORDER}
    shear = {m: _tolerated(evidence, m, "shear", SHEARS) for m in PAPER_ORDER}
    rows: dict[str, dict[str, object]] = {}
    for m in PAPER_ORDER:
        worst = (
            _error(evidence, m, "wind change", RATES[-1]),
            _error(evidence, m, "wind change", RATES[-1], "drifting"),
        )
        covered = [
            Spread.of(
                evidence.fit("coverage", m, setting="light", method="covering", wind=wind, change="wind change",
                             level=RATES[-1])
            )
            for wind in ("constant", "drifting")
        ]  # fmt: skip
        rows[m] = {
            "tolerated change [kt/min]": _above(limit[m], RATES[-1]),
            "tolerated shear [kt/100 ft]": _above(shear[m], SHEARS[-1]),
            f"rms error at {RATES[-1]:g} kt/min, wind constant [kt]": f"{rms(worst[0]):.2f}",
            "the same, wind drifting in the model [kt]": f"{rms(worst[1]):.2f}",
            "curve inside 2σ, constant [%]": f"{100.0 * covered[0].mean:.0f}",
            "curve inside 2σ, drifting [%]": f"{100.0 * covered[1].mean:.0f}",
            "drifting: no answer given": f"{_refused(evidence, m)} flights",
        }
    least, most = min(limit, key=lambda m: limit[m]), max(limit, key=lambda m: limit[m])
    charts = tuple(
        maneuver_lines(
            f"sweep-{change.replace(' ', '-')}{'-drifting' if wind == 'drifting' else ''}", title, note, xlabel,
            "rms error of the curve [kt]", (0.0, *levels),
            lambda m, level, change=change, wind=wind: _error(evidence, m, change, level, wind),
        )
        for change, wind, levels, title, note, xlabel in (
            ("wind change", "constant", RATES, "A wind that changes", "Fitted with a constant wind, 50/50 Hz.", "change of the wind [kt/min]"),
            ("wind change", "drifting", RATES, "The same, the model's wind may drift", "Fitted with wind='drifting'.", "change of the wind [kt/min]"),
            ("shear", "constant", SHEARS, "A wind that changes with altitude", "The good pilot's altitude wanders by some 8 ft rms.", "shear [kt/100 ft]"),
        )
    )  # fmt: skip
    return Reply(
        f"The error of the curve doubles at {_above(limit[least], RATES[-1])} kt/min of steady change for {NAMES[least]} "
        f"and at {_above(limit[most], RATES[-1])} kt/min for {NAMES[most]}; a drifting wind in the model says so in its "
        "bound. Shear hardly matters to a maneuver flown at one altitude: "
        + ("no maneuver reaches that limit" if all(np.isinf(v) for v in shear.values()) else "the first reaches that "
           f"limit at {min(shear.values()):.1f} kt/100 ft") + f" up to {SHEARS[-1]:g} kt/100 ft.",
        charts,
        (named(rows),),
    )  # fmt: skip


WIND = Sweep("variable wind", "How much may the wind change, in time and with altitude?", _answer, looks)
