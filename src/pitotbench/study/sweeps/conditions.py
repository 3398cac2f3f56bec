"""Do test altitude and temperature matter?"""

from collections.abc import Iterator

import pandas as pd

from pitotbench.study.charting import maneuver_lines
from pitotbench.study.evidence import Evidence, Spread
from pitotbench.study.flights import Sortie, case_of
from pitotbench.study.look import COVERING, PAPER, Look
from pitotbench.study.names import NAMES
from pitotbench.study.sweeps.sweep import Reply, Sweep
from pitotbench.units import FOOT

FLOWN = ("step_decrease", "rapid_decel")
AIRS = {"smooth": "smooth air", "light": "light turbulence"}
ALTITUDES = (2000.0, 12000.0, 18000.0)  # ft, beside the usual 6,000
TEMPERATURES = (-20.0, 20.0)  # K above standard
_USUAL_ALTITUDE = 6000.0
_LOOKS = (Look("50/50", COVERING), Look("50/50", PAPER))


def sorties(seed: int) -> Iterator[Sortie]:
    """Two maneuvers at each altitude in either air, and at each temperature in light turbulence."""
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


def _answer(evidence: Evidence) -> Reply:
    few = evidence.fit("samples", FLOWN[0], setting="light", variant=_at_altitude(ALTITUDES[0])).index

    def bound(maneuver: str, variant: str, air: str) -> pd.Series:
        found = evidence.fit("two_sigma_kt", maneuver, setting=air, method="covering", variant=variant)
        return found[found.index.isin(few)]

    def ratios(one: str, other: str, air: str) -> str:
        found = [Spread.of(bound(m, one, air)).mean / Spread.of(bound(m, other, air)).mean for m in FLOWN]
        return f"{min(found):.2f} to {max(found):.2f}"

    heights = tuple(sorted((*ALTITUDES, _USUAL_ALTITUDE)))
    warmth = (TEMPERATURES[0], 0.0, TEMPERATURES[1])
    ylabel = "covering 2σ of the curve [kt]"
    charts = [
        maneuver_lines(
            f"sweep-altitude-{air}", f"Test altitude, {words}", "50/50 Hz, the same calibrated airspeeds.",
            "test altitude [ft]", ylabel, heights, lambda m, feet, air=air: bound(m, _at_altitude(feet), air), FLOWN,
        )
        for air, words in AIRS.items()
    ]  # fmt: skip
    charts.append(
        maneuver_lines(
            "sweep-temperature", "Temperature, light turbulence", "50/50 Hz, 6,000 ft.", "above standard [K]", ylabel,
            warmth, lambda m, kelvin: bound(m, _at_temperature(kelvin), "light"), FLOWN,
        )
    )  # fmt: skip
    top, bottom = _at_altitude(heights[-1]), _at_altitude(heights[0])
    return Reply(
        f"In smooth air the covering 2σ at {heights[-1]:,.0f} ft is {ratios(top, bottom, 'smooth')} times that at "
        f"{heights[0]:,.0f} ft ({', '.join(NAMES[m] for m in FLOWN)}); in light turbulence {ratios(top, bottom, 'light')} "
        "times, because the gusts of MIL-F-8785C die out with altitude: fly high for the air, not for the method. From "
        f"{warmth[0]:+g} to {warmth[-1]:+g} K it changes by a factor of "
        f"{ratios(_at_temperature(warmth[-1]), _at_temperature(warmth[0]), 'light')}; what matters about temperature is to "
        "measure it, since an error of it does not show in the residual.",
        tuple(charts),
    )


CONDITIONS = Sweep(
    "test altitude and temperature", "Do test altitude and temperature matter?", _answer, sorties=sorties
)
