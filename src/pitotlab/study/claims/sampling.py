"""The claims about data rates and data density."""

from functools import partial

import pandas as pd

from pitotbench.sensing.sampling import SYSTEMS
from pitotlab.study.questions import Claim, Finding
from pitotlab.study.reductions import ALIKE, NAMES, PAPER_ORDER, named
from pitotlab.study.rules import RULES
from pitotlab.study.tables import (
    Spread,
    StudyTables,
    airspeed_noise,
    mean,
    percent_above,
    ratio,
    signed,
    span,
    text,
)

# The reductions of 20/1 Hz: fixes interpolated or held, with other changes.
ASKED: dict[str, tuple[bool, dict[str, object]]] = {
    "held, smooth air [%]": (False, {}),
    "held, light turbulence [%]": (False, {"setting": "light"}),
    "held, moderate turbulence [%]": (False, {"setting": "moderate"}),
    "held, velocity noise as at 50/50 [%]": (False, {"gps_noise": ALIKE}),
    "interpolated [%]": (True, {}),
    "interpolated, velocity noise as at 50/50 [%]": (True, {"gps_noise": ALIKE}),
}
CARDS = (
    ("four_leg", "standard", "4-Leg, four speeds"),
    ("four_leg", "six speeds", "4-Leg, six speeds"),
    ("step_decrease", "standard", "Step Decrease, 10 s steps"),
    ("step_decrease", "long steps", "Step Decrease, 20 s steps"),
)
_USUAL = (0, 2)  # the usual cards in the table; each is followed by the one with more data
_SCATTER = "The residual is the scatter of one sample."


def _change(
    evidence: StudyTables, maneuver: str, das: str, smooth: bool = False, **how: object
) -> pd.Series:
    """Return the 2σ over that at 50/50 Hz, minus one [%]; `smooth` interpolates the fixes."""
    column, method = (
        ("smooth_two_sigma_kt", "covering") if smooth else ("residual_two_sigma_kt", "paper")
    )
    one = evidence.fit(column, maneuver, das=das, method=method, **how)
    other = evidence.fit(column, maneuver, method=method, **{**how, "gps_noise": 1.0})
    return 100.0 * (one / other - 1.0)


@partial(Claim, RULES["C3"])
def fast(evidence: StudyTables) -> Finding:
    change = {m: Spread.of(_change(evidence, m, "100/100")) for m in PAPER_ORDER}
    worst = max(change, key=lambda m: abs(change[m].mean))
    bound = {d: [mean(evidence.bound(m, das=d)) for m in PAPER_ORDER] for d in SYSTEMS}
    more = [a / b for a, b in zip(bound["100/100"], bound["50/50"], strict=True)]
    return Finding(
        RULES["C3"].judge([s.mean for s in change.values()]),
        f"100/100 differs from 50/50 by {change[worst].text(1)} % at most ({NAMES[worst]})",
        "Sense the same flights at 50/50 and at 100/100 Hz, and fit both.",
        f"{_SCATTER} It is white noise here and does not depend on the number of samples. The "
        f"covering 2σ of the curve does: at 100/100 Hz it is {span(more)} times that at 50/50 Hz.",
    )


def _average(evidence: StudyTables, label: str) -> Spread:
    """Return the change averaged over the maneuvers, with its spread over seeds."""
    smooth, how = ASKED[label]
    changes = [_change(evidence, m, "20/1", smooth, **how) for m in PAPER_ORDER]
    return Spread.of(pd.concat(changes, axis=1).mean(axis=1, skipna=False))


@partial(Claim, RULES["C4"])
def slow(evidence: StudyTables) -> Finding:
    held, light, moderate, alike, spline, neither = (_average(evidence, label) for label in ASKED)
    rises = {m: mean(_change(evidence, m, "20/1")) for m in PAPER_ORDER}
    decel = text(_change(evidence, "rapid_decel", "20/1"), 0)
    table = named(
        lambda m: {
            label: text(_change(evidence, m, "20/1", smooth, **how), 1)
            for label, (smooth, how) in ASKED.items()
        }
    )
    return Finding(
        RULES["C4"].judge([*rises.values()]),
        f"fixes held: 20/1 is {held.text(0)} % above 50/50 on average ("
        + ", ".join(f"{NAMES[m]} {signed(rise, 0)}" for m, rise in rises.items())
        + f"). Interpolated, which the paper does not say: {spline.text(0)} %"
        + (f". In light turbulence, held: {light.text(0)} %" if light.count else ""),
        "Sense the same flights at 20/1 Hz with each of two causes taken away. Cause one: a "
        "velocity that is held for a second is old; interpolate the fixes instead. Cause two: a "
        "receiver alone is noisier than one joined with inertial sensors (0.1 and 0.05 m/s here); "
        "give both the same noise.",
        f"Averaged over the maneuvers the hold alone makes {signed(alike.mean)} %, the noise alone "
        f"{signed(spline.mean)} %, and neither {signed(neither.mean)} %. Rapid Decel makes {decel} %, "
        "because its speed changes most in a second. Turbulence hides both causes: the mean over "
        f"the maneuvers is {held.mean:.0f} % in smooth air, {light.mean:.0f} % in light and "
        f"{moderate.mean:.0f} % in moderate turbulence.",
        tables=(table,),
    )


def expected_noise(evidence: StudyTables, maneuver: str, variant: str = "standard") -> float:
    """Return 2σ [kt] of white pressure noise at the airspeeds of the density table."""
    rows = evidence.seconds(maneuver, variant)
    return airspeed_noise(rows.airspeed_kt.to_numpy(), rows.seconds.to_numpy())


def _card(evidence: StudyTables, maneuver: str, variant: str, label: str) -> dict[str, object]:
    return {
        "card": label,
        "minutes": text(evidence.flight("minutes", maneuver, variant=variant), 1),
        "samples": f"{mean(evidence.fit('samples', maneuver, variant=variant)):,.0f}",
        "residual 2σ [kt]": text(evidence.residual(maneuver, variant=variant), 3),
        "of the pressure noise alone [kt]": f"{expected_noise(evidence, maneuver, variant):.3f}",
        "covering 2σ of the curve [kt]": text(evidence.bound(maneuver, variant=variant), 4),
    }


@partial(Claim, RULES["C9"])
def denser(evidence: StudyTables) -> Finding:
    residual = [evidence.residual(m, variant=v) for m, v, _ in CARDS]
    six, steps = (percent_above(residual[i + 1], residual[i]) for i in _USUAL)
    noise = [expected_noise(evidence, m, v) for m, v, _ in CARDS]
    predicted = [signed(100.0 * (noise[i + 1] / noise[i] - 1.0)) for i in _USUAL]
    bound = [mean(evidence.bound(m, variant=v)) for m, v, _ in CARDS]
    bounds = [f"from {bound[i]:.4f} to {bound[i + 1]:.4f} kt" for i in _USUAL]
    return Finding(
        RULES["C9"].judge(six, steps),
        f"six speeds {six.with_margin()} %, longer steps {steps.with_margin()} %",
        "Fly 4-Leg at six speeds instead of four, and Step Decrease with 20 s a power step instead "
        "of 10 s. Compute also, without any fit, what the injected pressure noise is in knots at "
        "the speeds flown.",
        f"{_SCATTER} It does not depend on the number of samples, but on the speeds: the same noise "
        f"in pascals is more knots at low speed. That alone predicts changes of {predicted[0]} % "
        f"and {predicted[1]} %. More samples do narrow the bound on the curve: 4-Leg {bounds[0]}, "
        f"Step Decrease {bounds[1]}.",
        (pd.DataFrame([_card(evidence, *card) for card in CARDS]),),
    )


@partial(Claim, RULES["C10"])
def fewer(evidence: StudyTables) -> Finding:
    pair = ("step_decrease", "four_leg")
    share = ratio(*(evidence.fit("samples", m) for m in pair))
    on = ratio(*(evidence.fit("samples", m, on_condition=True) for m in pair))
    change = percent_above(*map(evidence.residual, pair))
    bound = ratio(*map(evidence.bound, pair))
    return Finding(
        RULES["C10"].judge(change),
        f"2σ {change.with_margin()} % with {share.text(2)} of the samples of 4-Leg, which is set by the "
        f"cards ({on.text(1)} times as many on condition)",
        "Count the samples of the two maneuvers at 50/50 Hz and compare their residuals, flight by "
        "flight.",
        "The claim is about the residual, the scatter of one sample. The covering 2σ of the curve "
        "does depend on the number of samples and on where they lie. That of Step Decrease is "
        f"{bound.text(1)} times that of 4-Leg in smooth air.",
    )
