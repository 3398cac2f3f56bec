"""Do test altitude and temperature matter?"""

from collections.abc import Iterator
from functools import partial

import pandas as pd

from pitotbench.evidence.pages.chart_data import Lines
from pitotbench.evidence.study.charting import maneuver_lines
from pitotbench.evidence.study.looks import COVERING, PAPER, Look
from pitotbench.evidence.study.maneuver_names import NAMES
from pitotbench.evidence.study.settings import Sortie, case_of
from pitotbench.evidence.study.study_tables import Spread, StudyTables
from pitotbench.evidence.study.sweeps.sweep import Reply, Sweep
from pitotbench.units import FOOT

FLOWN = ("step_decrease", "rapid_decel")
AIRS = {"smooth": "smooth air", "light": "light turbulence"}
ALTITUDES = (2000.0, 12000.0)  # ft, in addition to the usual 6,000
TEMPERATURES = (-20.0, 20.0)  # K above standard
_USUAL_ALTITUDE = 6000.0
_SMALL = 0.1  # a smaller factor is printed with two significant digits
_LOOKS = (Look("50/50", COVERING), Look("50/50", PAPER))


def sorties(seed: int) -> Iterator[Sortie]:
    """Yield two maneuvers at each altitude in both airs, and at each temperature in light turbulence."""
    for maneuver in FLOWN:
        for feet in ALTITUDES:
            for air in AIRS:
                yield Sortie(air, case_of(air, maneuver, seed, altitude=feet * FOOT), _LOOKS, _at_altitude(feet))
        for kelvin in TEMPERATURES:
            case = case_of("light", maneuver, seed, temperature_offset=kelvin)
            yield Sortie("light", case, _LOOKS, _at_temperature(kelvin))


def _at_altitude(feet: float) -> str:
    return "standard" if feet == _USUAL_ALTITUDE else f"{feet:,.0f} ft"


def _at_temperature(kelvin: float) -> str:
    return "standard" if kelvin == 0.0 else f"{kelvin:+g} K"


def _bound(evidence: StudyTables, air: str, maneuver: str, variant: str) -> pd.Series:
    found = evidence.fit("two_sigma_kt", maneuver, setting=air, method="covering", variant=variant)
    few = evidence.fit("samples", FLOWN[0], setting="light", variant=_at_altitude(ALTITUDES[0])).index
    return found[found.index.isin(few)]


def _high(evidence: StudyTables, air: str, maneuver: str, feet: float) -> pd.Series:
    return _bound(evidence, air, maneuver, _at_altitude(feet))


def _warm(evidence: StudyTables, maneuver: str, kelvin: float) -> pd.Series:
    return _bound(evidence, "light", maneuver, _at_temperature(kelvin))


def _factors(evidence: StudyTables, air: str, one: str, other: str) -> str:
    """Return the least and the largest ratio over the maneuvers of the mean bound of one variant to another."""
    mean = {v: [Spread.of(_bound(evidence, air, m, v)).mean for m in FLOWN] for v in (one, other)}
    found = [a / b for a, b in zip(mean[one], mean[other], strict=True)]
    return " to ".join(f"{f:.2f}" if f > _SMALL else f"{f:.2g}" for f in (min(found), max(found)))


def _charts(evidence: StudyTables) -> Iterator[Lines]:
    ylabel, note = "covering 2σ of the curve [kt]", "50/50 Hz, the same calibrated airspeeds."
    heights = tuple(sorted((*ALTITUDES, _USUAL_ALTITUDE)))
    for air, words in AIRS.items():
        name, title, number = f"sweep-altitude-{air}", f"Test altitude, {words}", partial(_high, evidence, air)
        yield maneuver_lines(name, title, note, "test altitude [ft]", ylabel, heights, number, FLOWN)
    name, title, warmth = "sweep-temperature", "Temperature, light turbulence", (-20.0, 0.0, 20.0)
    number = partial(_warm, evidence)
    yield maneuver_lines(name, title, note, "above standard [K]", ylabel, warmth, number, FLOWN)


def _answer(evidence: StudyTables) -> Reply:
    top, bottom = _at_altitude(ALTITUDES[-1]), _at_altitude(ALTITUDES[0])
    warm, cold = _at_temperature(TEMPERATURES[-1]), _at_temperature(TEMPERATURES[0])
    middle = _at_altitude(_USUAL_ALTITUDE)
    return Reply(
        f"In smooth air the covering 2σ at {top} is {_factors(evidence, 'smooth', top, bottom)} times that at "
        f"{bottom} ({', '.join(NAMES[m] for m in FLOWN)}), in light turbulence "
        f"{_factors(evidence, 'light', middle, bottom)} times at {_USUAL_ALTITUDE:,.0f} ft and "
        f"{_factors(evidence, 'light', top, bottom)} times at {top}, where the light turbulence of MIL-F-8785C has "
        f"died out. From {cold.replace('-', '−')} to {warm} it changes by a factor of "
        f"{_factors(evidence, 'light', warm, cold)}.",
        tuple(_charts(evidence)),
    )


CONDITIONS = Sweep(
    "test altitude and temperature", "Do test altitude and temperature matter?", _answer, sorties=sorties
)
