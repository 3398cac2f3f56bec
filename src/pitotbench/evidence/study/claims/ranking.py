"""C2: the order of the maneuvers by the 2σ of the residual."""

import numpy as np
import pandas as pd

from pitotbench.evidence.study.claims.claim import Claim, Finding, verdict
from pitotbench.evidence.study.claims.data_density import expected_noise
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER
from pitotbench.evidence.study.settings import SETTINGS, SPECIFICATION
from pitotbench.evidence.study.study_tables import Spread, StudyTables, rank_agreement, signed
from pitotbench.sense import SYSTEMS

_TAU = "Kendall's τ with the paper"


def _means(evidence: StudyTables, **how: object) -> list[float]:
    return [Spread.of(evidence.residual(m, **how)).mean for m in PAPER_ORDER]


def _order(values: list[float]) -> str:
    return " < ".join(NAMES[PAPER_ORDER[i]] for i in np.argsort(values))


def _agreement(values: list[float]) -> float:
    return rank_agreement(np.array(values), np.arange(len(values), dtype=np.float64))


def _asked() -> list[tuple[str, dict[str, object]]]:
    """Return the looks for the order: every air, pilot, data system, part of the data and noise."""
    asked: list[tuple[str, dict[str, object]]] = []
    for setting, air in SETTINGS.items():
        if set(air.flown) == set(PAPER_ORDER):
            asked += [(f"{air.what}, {das}", {"setting": setting, "das": das}) for das in SYSTEMS]
    for setting in ("smooth", "light"):
        label = f"{SETTINGS[setting].what}, 50/50, on-condition"
        asked.append((label, {"setting": setting, "on_condition": True}))
    asked += [(f"smooth air, {das}, a tenth of the noise", {"das": das, "noise": SPECIFICATION}) for das in SYSTEMS]
    return asked


def _experiments(evidence: StudyTables) -> pd.DataFrame:
    """Return the 2σ of each maneuver, their order and its agreement with the paper's, a row for each look."""
    rows = []
    for label, how in _asked():
        values = _means(evidence, **how)
        if np.all(np.isfinite(values)):
            numbers = dict(zip([NAMES[m] for m in PAPER_ORDER], [f"{v:.3f}" for v in values], strict=True))
            row = {"flown and sensed": label, **numbers, "order": _order(values)}
            rows.append({**row, _TAU: signed(_agreement(values))})
    return pd.DataFrame(rows)


def _ranking(evidence: StudyTables) -> Finding:
    smooth = {das: _means(evidence, das=das) for das in SYSTEMS}
    first = {das: PAPER_ORDER[int(np.argmin(values))] for das, values in smooth.items()}
    usual, table = smooth["50/50"], _experiments(evidence)
    held = bool(np.all(np.diff(usual) > 0.0))
    return Finding(
        verdict(held, first["50/50"] == "step_decrease"),
        f"50/50 Hz: {_order(usual)} ({_values(evidence)} kt); "
        f"Kendall's τ with the paper {signed(_agreement(usual))}",
        f"Fit all five maneuvers in {len(table)} combinations of air, pilot, data rate, noise, and turns in or "
        "out. Compute also, without any fit, what the injected pressure noise is in knots at the speeds flown.",
        f"Step Decrease has the smallest residual at {sum(m == 'step_decrease' for m in first.values())} of "
        f"{len(SYSTEMS)} data rates. {_because(evidence, usual, table)}",
        tables=(table,),
    )


def _values(evidence: StudyTables) -> str:
    """Return the 2σ at 50/50 Hz in words, the smallest first."""
    found = sorted((Spread.of(evidence.residual(m)) for m in PAPER_ORDER), key=lambda s: s.mean)
    return ", ".join(spread.text(3) for spread in found)


def _because(evidence: StudyTables, usual: list[float], table: pd.DataFrame) -> str:
    taus = table[_TAU].str.replace("−", "-").astype(float)
    noise = [expected_noise(evidence, m, "standard") for m in PAPER_ORDER]
    quiet = _means(evidence, noise=SPECIFICATION)
    held, quick = (Spread.of(evidence.residual("rapid_decel", das=das)).mean for das in ("20/1", "50/50"))
    spline = Spread.of(evidence.fit("smooth_two_sigma_kt", "rapid_decel", das="20/1", method="covering")).mean
    slowing = Spread.of(evidence.flight("slowing_kt_a_second", "rapid_decel")).mean
    return (
        f"Over the combinations τ with the paper's order runs from {signed(taus.min())} to {signed(taus.max())}. "
        "The injected noise makes the order: it is the same in pascals for all, and so more knots where a maneuver "
        f"flies slowly. Without any fit it gives {_order(noise)} "
        f"({', '.join(f'{v:.2f}' for v in sorted(noise))} kt), which agrees with the order found at 50/50 Hz at τ "
        f"{signed(rank_agreement(np.array(noise), np.array(usual)))}. With a tenth of the noise all five lie "
        f"between {min(quiet):.3f} and {max(quiet):.3f} kt. Rapid Decel has {quick:.2f} kt at 50/50 Hz and "
        f"{held:.2f} kt at 20/1 Hz. There a velocity is held for a second while it falls by up to {slowing:.1f} "
        f"kt/s; with the fixes interpolated it has {spline:.2f} kt."
    )


RANKING = Claim(
    "C2",
    "2σ of the residual: Step Decrease < Circle < Rapid Decel < Race Track < 4-Leg",
    "Figs 9, 10",
    "the same order at 50/50 Hz (in part: Step Decrease first)",
    _ranking,
)
