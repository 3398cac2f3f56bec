"""The open questions about the air and the airplane in it: a changing wind, sideslip, the day."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns.flights import rms
from pitotbench.units import FOOT
from pitotlab.study.parts import Lines
from pitotlab.study.questions import Reply, Sweep
from pitotlab.study.reductions import (
    COVERING,
    NAMES,
    PAPER,
    PAPER_ORDER,
    SIDESLIP_ERROR,
    Reduction,
    Sortie,
    case_of,
    named,
)
from pitotlab.study.tables import Spread, StudyTables, maneuver_lines, percent_above, signed

RATES = (0.1, 0.3, 1.0, 3.0)  # kt a minute
SHEARS = (3.0, 10.0)  # kt a hundred feet
DRIFTING = CalibrationOptions(wind="drifting")
_NAMED = RATES[2]  # the change for which the answer and the table give numbers
_TOLERATED = 2.0  # times the rms error of a constant wind


@dataclass(frozen=True, slots=True)
class Trouble:
    """A kind of change, the wind of the fitted model, and the name of its picture."""

    change: str
    wind: str
    levels: tuple[float, ...]
    title: str
    note: str
    xlabel: str

    @property
    def name(self) -> str:
        """The name of its picture."""
        return f"sweep-{self.change}-{self.wind}".replace(" ", "-")


_CONSTANT, _RATE = "Fitted with a constant wind, 50/50 Hz.", "change of the wind [kt/min]"
_DRIFTS = "Fitted with wind='drifting'; no mark where no flight got an answer."
CHANGING = Trouble("wind change", "constant", RATES, "A wind that changes", _CONSTANT, _RATE)
FOLLOWED = Trouble(
    "wind change", "drifting", RATES, "The same, and the model's wind may drift", _DRIFTS, _RATE
)
SHEARED = Trouble(
    "shear", "constant", SHEARS, "A wind that changes with altitude", _CONSTANT, "shear [kt/100 ft]"
)


def wind_reductions(maneuver: str) -> tuple[Reduction, ...]:
    """Return reductions of every rate with a constant and with a drifting wind in the model, and at
    every shear.
    """
    changing = [
        Reduction("50/50", o, "wind change", rate) for rate in RATES for o in (COVERING, DRIFTING)
    ]
    return (
        *changing,
        *(Reduction("50/50", COVERING, "shear", size) for size in SHEARS),
        Reduction("50/50", DRIFTING),
    )


def _wind_column(
    evidence: StudyTables, column: str, trouble: Trouble, maneuver: str, level: float
) -> pd.Series:
    how: dict[str, object] = {"change": trouble.change, "level": level} if level else {}
    found = evidence.fit(
        column, maneuver, setting="light", method="covering", wind=trouble.wind, **how
    )
    few = evidence.fit(column, maneuver, setting="light", method="covering", wind="drifting").index
    return found[found.index.isin(few)]


def _error(evidence: StudyTables, trouble: Trouble, maneuver: str, level: float) -> pd.Series:
    return _wind_column(evidence, "rms_error_kt", trouble, maneuver, level)


def tolerated(evidence: StudyTables, trouble: Trouble, maneuver: str) -> float:
    """Return the level at which the rms error over seeds is twice that of a constant wind; inf
    where none is.
    """
    still = rms(_error(evidence, trouble, maneuver, 0.0))
    errors = [rms(_error(evidence, trouble, maneuver, level)) / still for level in trouble.levels]
    for i, (level, error) in enumerate(zip(trouble.levels, errors, strict=True)):
        if error > _TOLERATED:
            before, below = (errors[i - 1], trouble.levels[i - 1]) if i else (1.0, 0.0)
            return below + (level - below) * (_TOLERATED - before) / (error - before)
    return float("inf")


def _said(value: float, trouble: Trouble) -> str:
    return f"more than {trouble.levels[-1]:g}" if np.isinf(value) else f"{value:.2f}"


def _row(evidence: StudyTables, maneuver: str) -> dict[str, object]:
    most = _NAMED
    inside = [_wind_column(evidence, "coverage", t, maneuver, most) for t in (CHANGING, FOLLOWED)]
    errors = [f"{rms(_error(evidence, t, maneuver, most)):.2f}" for t in (CHANGING, FOLLOWED)]
    return {
        "tolerated change [kt/min]": _said(tolerated(evidence, CHANGING, maneuver), CHANGING),
        "tolerated shear [kt/100 ft]": _said(tolerated(evidence, SHEARED, maneuver), SHEARED),
        f"rms error at {most:g} kt/min, wind constant [kt]": errors[0],
        f"rms error at {most:g} kt/min, wind drifting [kt]": errors[1],
        "curve inside 2σ, constant [%]": f"{100.0 * Spread.of(inside[0]).mean:.0f}",
        "curve inside 2σ, drifting [%]": f"{100.0 * Spread.of(inside[1]).mean:.0f}",
        "drifting, answer refused": f"{int(inside[1].isna().sum())} of {len(inside[1])}",
    }


def _wind_chart(evidence: StudyTables, trouble: Trouble) -> Lines:
    error = partial(_error, evidence, trouble)
    levels = (0.0, *trouble.levels)
    ylabel = "rms error of the curve [kt]"
    return maneuver_lines(
        trouble.name, trouble.title, trouble.note, trouble.xlabel, ylabel, levels, error
    )


def _wind_answer(evidence: StudyTables) -> Reply:
    limit = {m: tolerated(evidence, CHANGING, m) for m in PAPER_ORDER}
    shear = {m: tolerated(evidence, SHEARED, m) for m in PAPER_ORDER}
    least, most = min(limit, key=lambda m: limit[m]), max(limit, key=lambda m: limit[m])
    first = min(shear, key=lambda m: shear[m])
    wander = Spread.of(evidence.flight("altitude_ft", first, "light")).mean
    inside = [
        np.mean(
            [Spread.of(_wind_column(evidence, "coverage", t, m, _NAMED)).mean for m in PAPER_ORDER]
        )
        for t in (CHANGING, FOLLOWED)
    ]
    return Reply(
        f"The error of the curve doubles at {_said(limit[least], CHANGING)} kt/min of steady "
        "change for "
        f"{NAMES[least]} and at {_said(limit[most], CHANGING)} kt/min for {NAMES[most]}; at "
        f"{_NAMED:g} kt/min a "
        f"constant wind in the model leaves {100.0 * inside[0]:.0f} % of the curve inside its 2σ "
        "over the five "
        f"maneuvers, a drifting one {100.0 * inside[1]:.0f} %. Of shear, at an altitude that "
        "wanders by "
        f"{wander:.0f} ft rms, the first to double is {NAMES[first]}, at "
        f"{_said(shear[first], SHEARED)} kt/100 ft.",
        tuple(_wind_chart(evidence, trouble) for trouble in (CHANGING, FOLLOWED, SHEARED)),
        (named(partial(_row, evidence)),),
    )


WIND = Sweep(
    "variable wind",
    "How much may the wind change, in time and with altitude?",
    _wind_answer,
    wind_reductions,
)


ANGLES = (2.0, 4.0, 8.0)  # degrees
KINDS = {"steady sideslip": "held throughout", "sideslip in turns": "in turns only"}
_SAID = ANGLES[1]  # the angle for which the answer gives numbers


def sideslip_reductions(maneuver: str) -> tuple[Reduction, ...]:
    """Return reductions of every angle, in the whole flight and in turns only."""
    return tuple(
        Reduction("50/50", o, kind, angle)
        for kind in KINDS
        for angle in ANGLES
        for o in (COVERING, PAPER)
    )


def _sideslip_column(
    evidence: StudyTables,
    kind: str,
    maneuver: str,
    angle: float,
    column: str = "rms_error_kt",
    method: str = "covering",
) -> pd.Series:
    how: dict[str, object] = {"change": kind, "level": angle} if angle else {}
    found = evidence.fit(column, maneuver, setting="light", method=method, **how)
    few = evidence.fit(
        column, maneuver, setting="light", method=method, change=kind, level=ANGLES[0]
    ).index
    return found[found.index.isin(few)]


def _sideslip_chart(evidence: StudyTables, kind: str) -> Lines:
    note = (
        f"A probe that loses {100.0 * SIDESLIP_ERROR:g} % of q_c a degree squared (our "
        "estimate); light turbulence."
    )
    name, title = f"sweep-{kind.replace(' ', '-')}", f"Sideslip {KINDS[kind]}"
    error = partial(_sideslip_column, evidence, kind)
    return maneuver_lines(
        name, title, note, "sideslip [°]", "rms error of the curve [kt]", (0.0, *ANGLES), error
    )


def _residual_change(evidence: StudyTables, maneuver: str) -> float:
    """Return the change of the residual by a steady sideslip [%]."""
    column = partial(
        _sideslip_column,
        evidence,
        "steady sideslip",
        maneuver,
        column="residual_two_sigma_kt",
        method="paper",
    )
    return percent_above(column(_SAID), column(0.0)).mean


def _sideslip_answer(evidence: StudyTables) -> Reply:
    steady = [rms(_sideslip_column(evidence, "steady sideslip", m, _SAID)) for m in PAPER_ORDER]
    residual = max((_residual_change(evidence, m) for m in PAPER_ORDER), key=abs)
    turning = {
        m: rms(_sideslip_column(evidence, "sideslip in turns", m, _SAID)) for m in PAPER_ORDER
    }
    worst = max(turning, key=lambda m: turning[m])
    least = min(turning, key=lambda m: turning[m])
    share = {
        m: Spread.of(evidence.flight("turning_percent", m, "light")).mean for m in (worst, least)
    }
    return Reply(
        f"A steady {_SAID:g}° is a different pressure error, not a disturbance: the curve is "
        f"{min(steady):.1f} "
        f"to {max(steady):.1f} kt wrong over the five maneuvers while the residual changes by "
        f"{signed(residual)} % at most. In turns only, it is worst in {NAMES[worst]} "
        f"({turning[worst]:.2f} kt; "
        f"{share[worst]:.0f} % of the data are turns) and least in {NAMES[least]} "
        f"({turning[least]:.2f} kt; "
        f"{share[least]:.0f} %).",
        tuple(_sideslip_chart(evidence, kind) for kind in KINDS),
    )


SIDESLIP = Sweep(
    "sideslip",
    "What does sideslip do, held throughout and in turns only?",
    _sideslip_answer,
    sideslip_reductions,
)


FLOWN = ("step_decrease", "rapid_decel")
AIRS = {"smooth": "smooth air", "light": "light turbulence"}
ALTITUDES = (2000.0, 12000.0)  # ft, in addition to the usual 6,000
TEMPERATURES = (-20.0, 20.0)  # K above standard
_USUAL_ALTITUDE = 6000.0
_SMALL = 0.1  # a smaller factor is printed with two significant digits
_REDUCTIONS = (Reduction("50/50", COVERING), Reduction("50/50", PAPER))


def sorties(seed: int) -> Iterator[Sortie]:
    """Yield two maneuvers at each altitude in both airs, and at each temperature in light
    turbulence.
    """
    for maneuver in FLOWN:
        for feet in ALTITUDES:
            for air in AIRS:
                yield Sortie(
                    air,
                    case_of(air, maneuver, seed, altitude=feet * FOOT),
                    _REDUCTIONS,
                    _at_altitude(feet),
                )
        for kelvin in TEMPERATURES:
            case = case_of("light", maneuver, seed, temperature_offset=kelvin)
            yield Sortie("light", case, _REDUCTIONS, _at_temperature(kelvin))


def _at_altitude(feet: float) -> str:
    return "standard" if feet == _USUAL_ALTITUDE else f"{feet:,.0f} ft"


def _at_temperature(kelvin: float) -> str:
    return "standard" if kelvin == 0.0 else f"{kelvin:+g} K"


def _bound(evidence: StudyTables, air: str, maneuver: str, variant: str) -> pd.Series:
    found = evidence.fit("two_sigma_kt", maneuver, setting=air, method="covering", variant=variant)
    few = evidence.fit(
        "samples", FLOWN[0], setting="light", variant=_at_altitude(ALTITUDES[0])
    ).index
    return found[found.index.isin(few)]


def _high(evidence: StudyTables, air: str, maneuver: str, feet: float) -> pd.Series:
    return _bound(evidence, air, maneuver, _at_altitude(feet))


def _factors(evidence: StudyTables, air: str, one: str, other: str) -> str:
    """Return the least and the largest ratio over the maneuvers of the mean bound of one variant to
    another.
    """
    mean = {v: [Spread.of(_bound(evidence, air, m, v)).mean for m in FLOWN] for v in (one, other)}
    found = [a / b for a, b in zip(mean[one], mean[other], strict=True)]
    return " to ".join(f"{f:.2f}" if f > _SMALL else f"{f:.2g}" for f in (min(found), max(found)))


def _charts(evidence: StudyTables) -> Iterator[Lines]:
    ylabel, note = "covering 2σ of the curve [kt]", "50/50 Hz, the same calibrated airspeeds."
    heights = tuple(sorted((*ALTITUDES, _USUAL_ALTITUDE)))
    for air, words in AIRS.items():
        name, title, number = (
            f"sweep-altitude-{air}",
            f"Test altitude, {words}",
            partial(_high, evidence, air),
        )
        yield maneuver_lines(
            name, title, note, "test altitude [ft]", ylabel, heights, number, FLOWN
        )
    name, title, warming = "sweep-temperature", "Temperature, light turbulence", (-20.0, 0.0, 20.0)

    def warm(maneuver: str, kelvin: float) -> pd.Series:
        return _bound(evidence, "light", maneuver, _at_temperature(kelvin))

    yield maneuver_lines(name, title, note, "above standard [K]", ylabel, warming, warm, FLOWN)


def _conditions_answer(evidence: StudyTables) -> Reply:
    top, bottom = _at_altitude(ALTITUDES[-1]), _at_altitude(ALTITUDES[0])
    warm, cold = _at_temperature(TEMPERATURES[-1]), _at_temperature(TEMPERATURES[0])
    middle = _at_altitude(_USUAL_ALTITUDE)
    return Reply(
        f"In smooth air the covering 2σ at {top} is {_factors(evidence, 'smooth', top, bottom)} "
        "times that at "
        f"{bottom} ({', '.join(NAMES[m] for m in FLOWN)}), in light turbulence "
        f"{_factors(evidence, 'light', middle, bottom)} times at {_USUAL_ALTITUDE:,.0f} ft and "
        f"{_factors(evidence, 'light', top, bottom)} times at {top}, where the light turbulence of "
        "MIL-F-8785C has "
        f"died out. From {cold.replace('-', '−')} to {warm} it changes by a factor of "
        f"{_factors(evidence, 'light', warm, cold)}.",
        tuple(_charts(evidence)),
    )


CONDITIONS = Sweep(
    "test altitude and temperature",
    "Do test altitude and temperature matter?",
    _conditions_answer,
    sorties=sorties,
)
