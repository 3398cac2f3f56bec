"""The claims about data rates and data density."""

import numpy as np
import pandas as pd

from pitotbench.sensing.sampling import SYSTEMS
from pitotlab.study.parts import Bars, Lines, LineSeries
from pitotlab.study.questions import Claim, Finding, verdict
from pitotlab.study.reductions import ALIKE, NAMES, PAPER_ORDER, named
from pitotlab.study.tables import (
    Spread,
    StudyTables,
    airspeed_noise,
    bar_series,
    maneuver_bars,
    percent_above,
    ratio,
    signed,
)

_TOP = 0.8  # kt: cut of Fig 10, for Rapid Decel at 20/1 Hz
_SAME = 2.0  # %: a smaller difference is not significant
_TEN = (5.0, 15.0)  # %: our reading of "about ten percent"


def _change(
    evidence: StudyTables, maneuver: str, das: str, smooth: bool = False, **how: object
) -> pd.Series:
    """Return the 2σ relative to that at 50/50 Hz, minus one [%], by seed; `smooth` interpolates the
    fixes.
    """
    column, method = (
        ("smooth_two_sigma_kt", "covering") if smooth else ("residual_two_sigma_kt", "paper")
    )
    one = evidence.fit(column, maneuver, das=das, method=method, **how)
    other = evidence.fit(column, maneuver, method=method, **{**how, "gps_noise": 1.0})
    return 100.0 * (one / other - 1.0)


def _average(evidence: StudyTables, label: str, without: str = "") -> Spread:
    """Return the change averaged over the maneuvers, with its spread over seeds."""
    smooth, how = ASKED[label]
    changes = [_change(evidence, m, "20/1", smooth, **how) for m in PAPER_ORDER if m != without]
    return Spread.of(pd.concat(changes, axis=1).mean(axis=1, skipna=False))


def _fast(evidence: StudyTables) -> Finding:
    change = {m: Spread.of(_change(evidence, m, "100/100")) for m in PAPER_ORDER}
    worst = max(change, key=lambda m: abs(change[m].mean))
    chart = maneuver_bars(
        "fig10-rates",
        "Fig 10: 2σ of the residual by maneuver and data rate",
        "Smooth air, a good pilot, Inverse+.",
        "2σ of the residual [kt]",
        [(das, f"{das} Hz") for das in SYSTEMS],
        lambda m, das: evidence.residual(m, das=das),
        dots=True,
        top=_TOP,
    )
    return Finding(
        verdict(all(abs(s.mean) < _SAME for s in change.values())),
        f"100/100 differs from 50/50 by {change[worst].text(1)} % at most ({NAMES[worst]})",
        "Sense the same flights at 50/50 and at 100/100 Hz, and fit both.",
        "The residual is the scatter of one sample. It is white noise here and does not depend on "
        "the number of "
        "samples. The covering 2σ of the curve does: at 100/100 Hz it is "
        f"{_bound_change(evidence)} times that at "
        "50/50 Hz.",
        (chart,),
    )


def _bound_change(evidence: StudyTables) -> str:
    """Return the least and largest ratio over the maneuvers of the covering 2σ at 100/100 to that
    at 50/50 Hz.
    """
    bound = {das: [Spread.of(evidence.fit("two_sigma_kt", m, das=das, method="covering")).mean for m in PAPER_ORDER]
             for das in ("100/100", "50/50")}  # fmt: skip
    found = [fast / usual for fast, usual in zip(*bound.values(), strict=True)]
    return f"{min(found):.2f} to {max(found):.2f}"


# The reductions of 20/1 Hz: fixes interpolated or held, with other changes.
ASKED: dict[str, tuple[bool, dict[str, object]]] = {
    "held, smooth air [%]": (False, {}),
    "held, light turbulence [%]": (False, {"setting": "light"}),
    "held, moderate turbulence [%]": (False, {"setting": "moderate"}),
    "held, velocity noise as at 50/50 [%]": (False, {"gps_noise": ALIKE}),
    "interpolated [%]": (True, {}),
    "interpolated, velocity noise as at 50/50 [%]": (True, {"gps_noise": ALIKE}),
}


def _slow(evidence: StudyTables) -> Finding:
    held, light, moderate, alike, spline, neither = (_average(evidence, label) for label in ASKED)
    still, gusty = (_average(evidence, label, "rapid_decel") for label in list(ASKED)[:2])
    decel = Spread.of(_change(evidence, "rapid_decel", "20/1"))
    return Finding(
        verdict(_about_ten(held), _about_ten(still) or _about_ten(gusty)),
        f"20/1 is {held.text(0)} % above 50/50 on average, {light.text(0)} % in light turbulence; "
        "without Rapid "
        f"Decel {still.text(0)} % and {gusty.text(0)} %",
        "Sense the same flights at 20/1 Hz with each of two causes taken away. Cause one: a "
        "velocity that is held "
        "for a second is old; interpolate the fixes instead. Cause two: a receiver alone is "
        "noisier than one "
        "joined with inertial sensors (0.1 and 0.05 m/s here); give both the same noise.",
        f"Averaged over the maneuvers the hold alone makes {signed(alike.mean)} %, the noise alone "
        f"{signed(spline.mean)} %, and neither {signed(neither.mean)} %. Rapid Decel makes "
        f"{decel.text(0)} %, "
        "because its speed changes most in a second. Turbulence hides both causes: the mean over "
        "the maneuvers is "
        f"{held.mean:.0f} % in smooth air, {light.mean:.0f} % in light and {moderate.mean:.0f} % "
        "in moderate "
        "turbulence.",
        tables=(_parts(evidence),),
    )


def _parts(evidence: StudyTables) -> pd.DataFrame:
    def text(m: str, smooth: bool, how: dict[str, object]) -> str:
        return Spread.of(_change(evidence, m, "20/1", smooth, **how)).text(1)

    return named(lambda m: {label: text(m, *asked) for label, asked in ASKED.items()})


def _about_ten(percents: Spread) -> bool:
    return _TEN[0] <= percents.mean <= _TEN[1]


FAST = Claim(
    "C3",
    "50/50 and 100/100 Hz: no significant difference of the 2σ",
    "Fig 10",
    f"less than {_SAME:g} % for every maneuver",
    _fast,
)
SLOW = Claim(
    "C4",
    "20/1 Hz increases the 2σ by about 10 % on average",
    "Fig 10",
    f"a mean of {_TEN[0]:g} to {_TEN[1]:g} % (in part: without Rapid Decel, in smooth air or light "
    "turbulence)",
    _slow,
)


CARDS = (
    ("four_leg", "standard", "4-Leg, four speeds"),
    ("four_leg", "six speeds", "4-Leg, six speeds"),
    ("step_decrease", "standard", "Step Decrease, 10 s steps"),
    ("step_decrease", "long steps", "Step Decrease, 20 s steps"),
)
_THIRD = (0.25, 0.42)


def _seconds(evidence: StudyTables, maneuver: str, variant: str) -> pd.DataFrame:
    """Return the seconds at each airspeed in smooth air."""
    table = evidence.density
    return table[
        (table.maneuver == maneuver) & (table.variant == variant) & (table.setting == "smooth")
    ]


def _density(evidence: StudyTables) -> Lines:
    series = []
    for maneuver, variant, label in CARDS:
        rows = _seconds(evidence, maneuver, variant)
        series.append(
            LineSeries(label, rows.airspeed_kt.tolist(), rows.seconds.tolist(), style="steps")
        )
    note = f"Seed {evidence.seeds[0]}; turns included. Times 50 Hz gives samples."
    return Lines(
        "Fig 5: data density",
        note,
        "calibrated airspeed [kt]",
        "time in each 2.5 kt [s]",
        series,
        "fig5-density",
    )


def _bars(evidence: StudyTables) -> Bars:
    series = [
        bar_series(f"{das} Hz", [evidence.residual(m, variant=v, das=das) for m, v, _ in CARDS])
        for das in SYSTEMS
    ]
    labels = [label.replace(", ", "\n") for _, _, label in CARDS]
    return Bars("Fig 6: effect of data "
                "density", "Smooth air, a good pilot, Inverse+.", "2σ of the residual [kt]",
                labels, series, "fig6-density")  # fmt: skip


def _denser(evidence: StudyTables) -> Finding:
    six = percent_above(
        evidence.residual("four_leg", variant="six speeds"), evidence.residual("four_leg")
    )
    steps = percent_above(
        evidence.residual("step_decrease", variant="long steps"), evidence.residual("step_decrease")
    )
    return Finding(
        verdict(_rises(-six.mean, six.error), _rises(steps.mean, steps.error)),
        f"six speeds {_with_error(six)}, longer steps {_with_error(steps)}",
        "Fly 4-Leg at six speeds instead of four, and Step Decrease with 20 s a power step instead "
        "of 10 s. "
        "Compute also, without any fit, what the injected pressure noise is in knots at the speeds "
        "flown.",
        "The residual is the scatter of one sample. It does not depend on the number of samples, "
        "but on the "
        "speeds: the same noise in pascals is more knots at low speed. That alone predicts changes "
        "of "
        f"{_predicted(evidence, 0)} % and {_predicted(evidence, 2)} %. More samples do narrow the "
        "bound on the "
        f"curve: {_bounds(evidence, 0)}, {_bounds(evidence, 2)}.",
        (_density(evidence), _bars(evidence)),
        (pd.DataFrame([_row(evidence, *card) for card in CARDS]),),
    )


def _with_error(change: Spread) -> str:
    """Return a change [%] with the standard error of its mean, which decides."""
    error = "" if np.isnan(change.error) else f" (standard error of the mean {change.error:.2f} %)"
    return f"{change.text(1)} %{error}"


def _row(evidence: StudyTables, maneuver: str, variant: str, label: str) -> dict[str, object]:
    bound = evidence.fit("two_sigma_kt", maneuver, variant=variant, method="covering")
    return {
        "card": label,
        "minutes": Spread.of(evidence.flight("minutes", maneuver, variant=variant)).text(1),
        "samples": f"{Spread.of(evidence.fit('samples', maneuver, variant=variant)).mean:,.0f}",
        "residual 2σ [kt]": Spread.of(evidence.residual(maneuver, variant=variant)).text(3),
        "of the pressure noise alone [kt]": f"{expected_noise(evidence, maneuver, variant):.3f}",
        "covering 2σ of the curve [kt]": Spread.of(bound).text(4),
    }


def _predicted(evidence: StudyTables, usual: int) -> str:
    """Return the change [%] from one card of the table to the next, predicted from the injected
    noise alone.
    """
    before, after = (expected_noise(evidence, *card[:2]) for card in CARDS[usual : usual + 2])
    return signed(100.0 * (after / before - 1.0))


def _bounds(evidence: StudyTables, usual: int) -> str:
    """Return the covering 2σ [kt] of a card and of the next one in the table."""
    found = [
        Spread.of(evidence.fit("two_sigma_kt", maneuver, variant=variant, method="covering")).mean
        for maneuver, variant, _ in CARDS[usual : usual + 2]
    ]
    return f"{CARDS[usual][2].split(',')[0]} from {found[0]:.4f} to {found[1]:.4f} kt"


def _rises(mean: float, error: float) -> bool:
    """Return whether a change is above zero, by two standard errors where these are known."""
    return mean > 0.0 and (np.isnan(error) or mean - 2.0 * error > 0.0)


def expected_noise(evidence: StudyTables, maneuver: str, variant: str) -> float:
    """Return 2σ [kt] of white pressure noise at the airspeeds of the density table, which is from
    one seed.
    """
    rows = _seconds(evidence, maneuver, variant)
    return airspeed_noise(rows.airspeed_kt.to_numpy(), rows.seconds.to_numpy())


def _fewer(evidence: StudyTables) -> Finding:
    share = ratio(evidence.fit("samples", "step_decrease"), evidence.fit("samples", "four_leg"))
    on = ratio(
        evidence.fit("samples", "step_decrease", on_condition=True),
        evidence.fit("samples", "four_leg", on_condition=True),
    )
    change = percent_above(evidence.residual("step_decrease"), evidence.residual("four_leg"))
    bound = ratio(
        evidence.fit("two_sigma_kt", "step_decrease", method="covering"),
        evidence.fit("two_sigma_kt", "four_leg", method="covering"),
    )
    return Finding(
        verdict(_THIRD[0] <= share.mean <= _THIRD[1], change.mean < 0.0),
        f"{share.text(2)} of the samples of 4-Leg ({on.text(1)} times as many on condition), 2σ "
        f"{change.text(1)} %",
        "Count the samples of the two maneuvers at 50/50 Hz and compare their residuals, flight by "
        "flight.",
        "The claim is about the residual, the scatter of one sample. The covering 2σ of the curve "
        "does depend on "
        f"the number of samples and on where they lie. That of Step Decrease is {bound.text(1)} "
        "times that of "
        "4-Leg in smooth air.",
    )


DENSER = Claim(
    "C9",
    "4-Leg with six speeds: 2σ modestly smaller; Step Decrease with longer power steps: slightly "
    "larger",
    "Figs 5, 6",
    "the sign of each change, by more than two standard errors (in part: one of the two)",
    _denser,
)
FEWER = Claim(
    "C10",
    "Step Decrease has about a third of the samples of 4-Leg and still the smaller 2σ",
    "Fig 6",
    f"a ratio of {_THIRD[0]:g} to {_THIRD[1]:g}, and the smaller 2σ (in part: one of the two)",
    _fewer,
)
