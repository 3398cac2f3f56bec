"""Typed legs, cards written by hand and their plans, in numbers. Loads no drawing library."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

from pitotbench.records.legs import (
    CardPoint,
    FixedSpeedResult,
    FlyByPoint,
    HandCard,
    HandPlan,
    KnownSpeedResult,
    SpeedFactor,
)
from pitotbench.show.calibration import Correction, correction_sentence, doubts_of_curve
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.curve_rows import CurvePoint, curve_points, prior_sentences
from pitotbench.show.markup import render
from pitotbench.show.tree import Doubt, Node, Sentence, Table
from pitotbench.show.words import listed
from pitotbench.units import DEGREE, FOOT, KNOT


def legs_json(found: FixedSpeedResult) -> dict[str, Any]:
    """The answer of legs that were typed by hand as plain data, in knots and degrees."""
    return {
        "true_airspeed_kt": found.true_airspeed / KNOT,
        "spread_kt": _scaled(found.spread, KNOT),
        "wind_speed_kt": found.wind_speed / KNOT,
        "wind_from_deg": found.wind_from / DEGREE,
    }


def legs_tree(answer: dict[str, Any]) -> list[Node]:
    """The plain data of legs that were typed by hand, in words."""
    spread = answer["spread_kt"]
    of_four = (
        "" if spread is None else f"; its answers of three legs each spread by {spread:.1f} kt"
    )
    return [
        Sentence(f"The true airspeed is {answer['true_airspeed_kt']:.1f} kt{of_four}."),
        Sentence(
            f"The wind is {answer['wind_speed_kt']:.1f} kt from {answer['wind_from_deg']:03.0f}°."
        ),
    ]


def _scaled(value: float | None, unit: float) -> float | None:
    return None if value is None else value / unit


CARD_POINT_COLUMNS: tuple[Column[CardPoint], ...] = (
    Column("point", lambda p: p.point, key="point"),
    Column("configuration", lambda p: p.configuration or None, key="configuration", optional=True),
    Column("legs", lambda p: p.legs, "", "d", "legs"),
    Column("KIAS", lambda p: p.indicated_airspeed / KNOT, "kt", ".1f", "indicated_airspeed_kt"),
    Column(
        "KCAS",
        lambda p: _scaled(p.calibrated_airspeed, KNOT),
        "kt",
        ".1f",
        "calibrated_airspeed_kt",
    ),
    Column("correction", lambda p: _scaled(p.correction, KNOT), "kt", "+.2f", "correction_kt"),
    Column("±2σ", lambda p: _scaled(p.two_sigma, KNOT), "kt", ".2f", "two_sigma_kt"),
    Column(
        "altitude correction",
        lambda p: _scaled(p.altitude_correction, FOOT),
        "ft",
        "+.0f",
        "altitude_correction_ft",
    ),
    Column(
        "±2σ", lambda p: _scaled(p.altitude_two_sigma, FOOT), "ft", ".0f", "altitude_two_sigma_ft"
    ),
    Column("KTAS", lambda p: _scaled(p.true_airspeed, KNOT), "kt", ".1f", "true_airspeed_kt"),
    Column("spread", lambda p: _scaled(p.spread, KNOT), "kt", ".2f", "spread_kt"),
    Column("wind", lambda p: _scaled(p.wind_speed, KNOT), "kt", ".1f", "wind_speed_kt"),
    Column("from", lambda p: _scaled(p.wind_from, DEGREE), "°", "03.0f", "wind_from_deg"),
    Column("remark", lambda p: p.remark, key="remark"),
)


CURVE_COLUMNS: tuple[Column[CurvePoint], ...] = (
    Column("KIAS", lambda p: p["indicated_airspeed_kt"], "kt", ".1f", "indicated_airspeed_kt"),
    Column("KCAS", lambda p: p["calibrated_airspeed_kt"], "kt", ".1f", "calibrated_airspeed_kt"),
    Column("correction", lambda p: p["correction_kt"], "kt", "+.2f", "correction_kt"),
    Column("±2σ", lambda p: p["two_sigma_kt"], "kt", ".2f", "two_sigma_kt"),
    Column(
        "altitude correction",
        lambda p: p["altitude_correction_ft"] or 0.0,
        "ft",
        "+.0f",
        "altitude_correction_ft",
    ),
    Column("±2σ", lambda p: p["two_sigma_ft"] or 0.0, "ft", ".0f", "altitude_two_sigma_ft"),
    Column(
        "Δp/q_c", lambda p: p["normalized_pressure_error"], "", "+.4f", "normalized_pressure_error"
    ),
    Column("", lambda p: p["normalized_two_sigma"], key="normalized_two_sigma"),
)


def card_tree(card: HandCard) -> list[Node]:
    """Return the tree of a card written by hand.

    What to add at each point of one configuration, its slips, the points, and the curve of each
    configuration with what is assumed of it. A configuration with one point has that in place of a
    curve.
    """
    counted = Counter(p.configuration for p in card.points)
    found = [
        Correction(*(each / KNOT for each in (p.indicated_airspeed, p.correction, p.two_sigma)))
        for p in card.points
        if p.correction is not None and p.two_sigma is not None and len(card.curves) == 1
    ]
    assumed = [line for curve in card.curves.values() for line in doubts_of_curve(curve)]
    return [
        *([Sentence(correction_sentence(found))] if found else []),
        *map(Doubt, [*card.warnings, *dict.fromkeys(assumed)]),
        *map(Sentence, prior_sentences(card.priors)),
        Table(CARD_POINT_COLUMNS, card.points, "points"),
        *(
            Table(CURVE_COLUMNS, curve_points(curve), ", ".join(filter(None, ("curve", name))))
            for name, curve in card.curves.items()
            if counted[name] > 1
        ),
    ]


def card_json(card: HandCard) -> dict[str, Any]:
    """The card as plain data, in knots, feet and degrees."""
    return {
        "points": json_rows(CARD_POINT_COLUMNS, card.points),
        "curves": {
            n: {"curve": json_rows(CURVE_COLUMNS, curve_points(curve))}
            for n, curve in card.curves.items()
        },
        "slips": [
            {"row": s.row, "point": s.point, "what": s.words, "probably": s.probably or None}
            for s in card.slips
        ],
        "priors": dict(card.priors),
        "warnings": list(card.warnings),
    }


FLY_BY_COLUMNS: tuple[Column[FlyByPoint], ...] = (
    Column("point", lambda p: p.point, key="point"),
    Column("configuration", lambda p: p.configuration or None, key="configuration", optional=True),
    Column("KIAS", lambda p: p.indicated_airspeed / KNOT, "kt", ".1f", "indicated_airspeed_kt"),
    Column(
        "altitude correction",
        lambda p: p.altitude_correction / FOOT,
        "ft",
        "+.0f",
        "altitude_correction_ft",
    ),
    Column("±2σ", lambda p: p.altitude_two_sigma / FOOT, "ft", ".0f", "two_sigma_ft"),
    Column("correction", lambda p: p.correction / KNOT, "kt", "+.2f", "correction_kt"),
    Column("±2σ", lambda p: p.two_sigma / KNOT, "kt", ".2f", "two_sigma_kt"),
    Column(
        "Δp/q_c", lambda p: p.normalized_pressure_error, "", "+.4f", "normalized_pressure_error"
    ),
    Column("±2σ", lambda p: p.normalized_two_sigma, "", ".4f", "normalized_two_sigma"),
)


def fly_bys_tree(points: Sequence[FlyByPoint]) -> list[Node]:
    """The position error of each pass of a tower."""
    return [Table(FLY_BY_COLUMNS, points, "tower fly-bys")]


def fly_bys_json(points: Sequence[FlyByPoint]) -> dict[str, Any]:
    """The position error of each pass as plain data, in knots and feet."""
    return {"points": json_rows(FLY_BY_COLUMNS, points), "warnings": []}


KNOWN_SPEED_COLUMNS: tuple[Column[SpeedFactor], ...] = (
    Column("point", lambda p: p.point, key="point"),
    Column("configuration", lambda p: p.configuration or None, key="configuration", optional=True),
    Column("KIAS", lambda p: p.indicated_airspeed / KNOT, "kt", ".1f", "indicated_airspeed_kt"),
    Column("known", lambda p: p.known_airspeed / KNOT, "kt", ".1f", "known_airspeed_kt"),
    Column("factor", lambda p: p.factor, "", ".3f", "factor"),
    Column("±2σ", lambda p: p.factor_two_sigma, "", ".3f", "factor_two_sigma"),
    Column("correction", lambda p: p.correction / KNOT, "kt", "+.2f", "correction_kt"),
    Column("±2σ", lambda p: p.two_sigma / KNOT, "kt", ".2f", "two_sigma_kt"),
)


def known_speeds_tree(found: KnownSpeedResult) -> list[Node]:
    """Factor by speed, scale and zero of points with a known speed."""
    root, spread = found.scale**0.5, 0.5 * found.scale_two_sigma / found.scale**0.5
    return [
        Sentence(
            f"Multiply the impact pressure by {found.scale:.3f} ± {found.scale_two_sigma:.3f} and "
            f"add {found.zero:+.1f} ± {found.zero_two_sigma:.1f} Pa (± is 2σ); as ARSPD_RATIO the old "
            f"one times {found.scale:.3f}, as ASPD_SCALE times {root:.3f} ± {spread:.3f}."
        ),
        Sentence(
            "The known speed counts as a calibrated airspeed: a true airspeed in other air than "
            "that of a standard day at sea level is to be multiplied by the root of the density ratio "
            f"first. The points scatter by {found.scatter / KNOT:.2f} kt."
        ),
        Table(KNOWN_SPEED_COLUMNS, found.points, "points with a known speed"),
    ]


def known_speeds_json(found: KnownSpeedResult) -> dict[str, Any]:
    """The same as plain data, in knots and pascals."""
    return {
        "points": json_rows(KNOWN_SPEED_COLUMNS, found.points),
        "scale": {"value": found.scale, "two_sigma": found.scale_two_sigma},
        "zero_pa": {"value": found.zero, "two_sigma": found.zero_two_sigma},
        "warnings": [],
    }


PLAN_COLUMNS: tuple[Column[HandPlan], ...] = (
    Column("legs a point", lambda p: p.legs, "", "d", "legs"),
    Column("airspeeds", lambda p: len(p.airspeeds), "", "d", "points"),
    Column("times", lambda p: p.times, "", "d", "times"),
    Column("time in the air", lambda p: p.minutes, "min", ".0f", "minutes"),
    Column("±2σ of the curve", lambda p: p.two_sigma / KNOT, "kt", ".2f", "two_sigma_kt"),
)


def chosen_plan(
    plans: Sequence[HandPlan], want: float | None, minutes: float | None
) -> HandPlan | None:
    """Return the shortest card with the wanted bound [m/s] in the minutes, None without one.

    Without a wanted bound, the best within the minutes; without minutes the best of all.
    """
    fitting = [plan for plan in plans if minutes is None or plan.minutes <= minutes]
    if want is not None:
        return next((plan for plan in fitting if plan.two_sigma <= want), None)
    return min(fitting, key=lambda plan: plan.two_sigma, default=None)


def plan_words(plan: HandPlan | None, want: float | None) -> list[str]:
    """The card in the words of a pilot."""
    if plan is None:
        wanted = "" if want is None else f" with ±{want / KNOT:g} kt (2σ)"
        return [
            f"No card by hand{wanted} fits into the minutes: record a log instead, or allow more "
            "of either."
        ]
    speeds = listed([f"{speed / KNOT:.0f}" for speed in plan.airspeeds])
    tracks = listed([f"{track / DEGREE:03.0f}°" for track in plan.tracks])
    again = (
        ""
        if plan.times == 1
        else f" Fly all of it {plan.times} times, every other time from the fast end."
    )
    return [
        f"Fly {speeds} KIAS, at each {plan.legs} legs on true tracks {tracks}; all turned together "
        "by any angle will do.",
        f"Hold each leg for 30 s and read whole knots and degrees.{again} It takes "
        f"{plan.minutes:.0f} min and gives a curve with a 2σ of {plan.two_sigma / KNOT:.2f} kt.",
    ]


def hand_plan_tree(
    plans: Sequence[HandPlan], chosen: HandPlan | None, want: float | None
) -> list[Node]:
    """The card to fly, and the others from which it is chosen."""
    return [
        *map(Sentence, plan_words(chosen, want)),
        Table(PLAN_COLUMNS, plans, "cards by hand, each better than all shorter ones"),
    ]


def hand_plan_json(plans: Sequence[HandPlan], chosen: HandPlan | None) -> dict[str, Any]:
    """The cards as plain data; `fly` is null where none fits."""
    fly: dict[str, Any] | None = None
    if chosen is not None:
        (fly,) = json_rows(PLAN_COLUMNS, [chosen])
        fly |= {
            "airspeeds_kt": [speed / KNOT for speed in chosen.airspeeds],
            "tracks_deg": [track / DEGREE for track in chosen.tracks],
        }
    return {"fly": fly, "cards": json_rows(PLAN_COLUMNS, plans)}


def card_sheet(plan: HandPlan | None = None) -> str:
    """Return the HTML of a one-page sheet to fill in, empty or with the legs of a plan."""
    legs, asked = 4, [""] * 24
    if plan is not None:
        legs = plan.legs
        asked = [
            f"{v / KNOT:.0f} KIAS, {t / DEGREE:03.0f}°" for v in plan.airspeeds for t in plan.tracks
        ]
    rows = [(place // legs + 1, place % legs == 0, text) for place, text in enumerate(asked)]
    return render(
        "sheet.html", legs=legs, rows=rows, words=[] if plan is None else plan_words(plan, None)
    )
