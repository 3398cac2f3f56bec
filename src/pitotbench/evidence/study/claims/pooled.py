"""The fall of the 2σ with V_down, read in two ways: of the airspeed, and pooled over the outputs of the fit.

The paper's 2σ may be pooled: its fit has the components of ground velocity as outputs, and V_down is one more. The
pooled 2σ is the root of the mean square over the outputs.
"""

from collections.abc import Callable

import pandas as pd

from pitotbench.evidence.study.study_tables import Spread, StudyTables, percent_above

LIMIT = 100.0 * (1.0 - (2.0 / 3.0) ** 0.5)  # %: fall of a pooled 2σ where a third output has no residual
TwoSigma = Callable[..., pd.Series]  # evidence, maneuver, settings → by seed


def airspeed_two_sigma(evidence: StudyTables, maneuver: str, **how: object) -> pd.Series:
    """Return 2σ of the residual of airspeed [kt] by seed."""
    return evidence.residual(maneuver, **how)


def pooled_two_sigma(
    evidence: StudyTables, maneuver: str, column: str = "pooled_two_sigma_kt", **how: object
) -> pd.Series:
    """Return 2σ pooled over the outputs [kt of true airspeed] by seed, noise on the impact pressure alone.

    `column` names another number of the same fits. With `alone=False` every sensor has its noise.
    """
    alone = bool(how.pop("alone", True))
    return evidence.fit(column, maneuver, form="vector", alone=alone, given_down=alone, **how)


def fall(two_sigma: TwoSigma, evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall of a 2σ with V_down [%], positive where it falls."""
    without = two_sigma(evidence, maneuver, **{**how, "down": False})
    found = percent_above(two_sigma(evidence, maneuver, **how), without)
    return Spread(-found.mean, found.deviation, found.count)


def airspeed_fall(evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall with V_down of the 2σ of airspeed [%]."""
    return fall(airspeed_two_sigma, evidence, maneuver, **how)


def pooled_fall(evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall with V_down of the 2σ pooled over the outputs [%]."""
    return fall(pooled_two_sigma, evidence, maneuver, **how)
