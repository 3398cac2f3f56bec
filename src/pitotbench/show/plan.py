"""A plan in numbers and sentences: a row a maneuver by merit, the advice, the improved card."""

from collections.abc import Sequence
from typing import Any

from pitotbench.records.forecast import COMPARED_MINUTES, BriefedLeg, Forecast, Plan
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.tree import (
    ANSWER,
    SOURCES,
    Doubt,
    Figure,
    Heading,
    Node,
    Sentence,
    Table,
)
from pitotbench.show.words import name_and_unit, with_unit, words
from pitotbench.units import DEGREE, KNOT, MINUTE, NAUTICAL_MILE


def plan_advice(plan: Plan) -> list[str]:
    """Return the advice: what to fly, how often, what without steep turns, and an improved card."""
    if plan.best is None:
        return ["No maneuver fits into the minutes and the box: allow more of either."]
    lines = [f"Fly the {_forecast_words(plan, plan.best)}."]
    if plan.want is not None:
        times = plan.best.times_for(plan.want)
        lines.append(
            f"For ±{plan.want / KNOT:g} kt (2σ) fly it {times} time{'s' if times > 1 else ''}: "
            f"{times * plan.best.minutes:.1f} min."
        )
        lines += _sooner(plan, plan.best, plan.want)
    if plan.gentle is not None and plan.gentle is not plan.best:
        lines.append(
            "The forecast for steep turns assumes that the pressure error does not depend on the "
            f"load factor. Without steep turns, fly the {_forecast_words(plan, plan.gentle)}."
        )
    if plan.improved is not None:
        changed = ", ".join(map(_entry_words, *zip(*plan.improved.card.items(), strict=True)))
        lines.append(
            f"Better by its card ({changed}): fly the {_forecast_words(plan, plan.improved)}."
        )
    elif plan.flights_searched:
        lines.append(
            f"The search flew {plan.flights_searched} other cards of it; none is better by more "
            "than 1 %."
        )
    return lines


def _sooner(plan: Plan, best: Forecast, want: float) -> list[str]:
    """Return which maneuver would give the wanted bound sooner, were one not over the minutes.

    The minutes are those of the request.
    """
    others = (f for f in plan.forecasts if f.fits(plan.box) and not f.ends_in(plan.minutes))
    first = min(others, key=lambda f: f.times_for(want) * f.minutes, default=best)
    times = first.times_for(want)
    if times * first.minutes >= best.times_for(want) * best.minutes:
        return []
    return [
        f"The {card_name(plan, first)} would take {times * first.minutes:.1f} min for it ({times} "
        f"of {first.minutes:.1f} min each), but one is longer than {plan.minutes:g} min."
    ]


def _entry_words(key: str, value: Any) -> str:
    """An entry of a card: `dwells 3, 3 s`."""
    noun, unit = name_and_unit(key)
    values = value if isinstance(value, list | tuple) else [value]
    return f"{noun} {with_unit(', '.join(f'{each:.3g}' for each in values), unit)}"


def card_name(plan: Plan, each: Forecast) -> str:
    """The name of a card: that of its maneuver, of the one that the search found `…, improved`."""
    return words(each.maneuver) + (", improved" if each is plan.improved else "")


def _forecast_words(plan: Plan, each: Forecast) -> str:
    """What a maneuver gives in the minutes of the request, flown as often as it fits."""
    times = each.times_in(plan.minutes)
    often = f", {times} times" if times > 1 else ""
    return (
        f"{card_name(plan, each)}{often}: ±{each.within(plan.minutes) / KNOT:.3f} kt (2σ, mean over "
        f"the curve) in {times * each.minutes:.1f} min"
    )


_AS_LONG = 1.1  # times the minutes of the best: a maneuver within its spread that takes no longer is as good


def plan_columns(plan: Plan) -> list[Column[Forecast]]:
    """Return the columns of a plan's forecasts, those of a wanted bound where one is asked for."""
    want, minutes = plan.want, plan.minutes

    def times(each: Forecast) -> int | None:
        return None if want is None else each.times_for(want)

    def minutes_for_want(each: Forecast) -> float | None:
        flights = times(each)
        return None if flights is None else flights * each.minutes

    def in_minutes(each: Forecast) -> float | None:
        if minutes is None:
            return each.mean_in(COMPARED_MINUTES) / KNOT
        return each.within(minutes) / KNOT if each.minutes <= minutes else None

    wanted = "" if want is None else f"flights for ±{want / KNOT:g} kt"
    return [
        Column("maneuver", lambda each: words(each.maneuver)),
        Column("", lambda each: each.maneuver, key="maneuver"),
        Column("", lambda each: dict(each.card), key="card"),
        Column("recorded", lambda each: each.minutes, "min", ".1f", "minutes"),
        Column("in the air", lambda each: each.elapsed_minutes, "min", ".1f", "elapsed_minutes"),
        Column("predicted ±2σ", lambda each: each.mean / KNOT, "kt", ".3f", "two_sigma_kt"),
        Column(
            "1σ between flights",
            lambda each: each.spread / KNOT,
            "kt",
            ".3f",
            "two_sigma_spread_kt",
        ),
        Column("", lambda each: each.mean / each.noise_cost / KNOT, key="known_noise_two_sigma_kt"),
        Column(f"±2σ in {minutes or COMPARED_MINUTES:g} min", in_minutes, "kt", ".3f"),
        Column(wanted, times, style="d", key="flights_for_want"),
        Column(wanted and "time for them", minutes_for_want, "min", ".1f", "minutes_for_want"),
        Column(
            "ground N–S",
            lambda each: each.extent[0] / NAUTICAL_MILE,
            "nmi",
            ".1f",
            "ground_north_nm",
        ),
        Column(
            "ground E–W",
            lambda each: each.extent[1] / NAUTICAL_MILE,
            "nmi",
            ".1f",
            "ground_east_nm",
        ),
        Column("bank", lambda each: each.steepest_bank / DEGREE, "°", ".0f", "steepest_bank_deg"),
        Column("", _curve, key="curve"),
        Column("remark", lambda each: remark(plan, each), key="remark"),
    ]


def remark(plan: Plan, each: Forecast) -> str:
    """Why a maneuver is chosen, or why it cannot be."""
    if not each.fits(plan.box):
        return "leaves the box"
    if not each.ends_in(plan.minutes):
        return f"one is longer than {plan.minutes:g} min"
    if each is plan.best:
        return "best"
    if each is plan.gentle:
        return "best, no steep turn"
    best = plan.best
    as_good = (
        best is not None
        and each.mean < best.mean + best.spread
        and each.minutes < _AS_LONG * best.minutes
    )
    return "as good as the best" if as_good else ""


def plan_json(plan: Plan) -> dict[str, Any]:
    """The plan as plain data; the unit is in each key."""
    columns = plan_columns(plan)
    return {
        "conditions": plan.conditions,
        "minutes": plan.minutes,
        "want_kt": None if plan.want is None else plan.want / KNOT,
        "box_nm": None if plan.box is None else plan.box / NAUTICAL_MILE,
        "forecasts": json_rows(columns, plan.forecasts),
        "refused": dict(plan.refused),
        "best": plan.best.maneuver if plan.best else None,
        "best_without_steep_turns": plan.gentle.maneuver if plan.gentle else None,
        "improved": None if plan.improved is None else json_rows(columns, [plan.improved])[0],
        "pilot_card": [row for each in _briefed(plan) for row in json_rows(LEG_COLUMNS, each.legs)],
        "advice": plan_advice(plan),
    }


def _curve(each: Forecast) -> list[dict[str, float]]:
    return [
        {"indicated_airspeed_kt": speed / KNOT, "two_sigma_kt": bound / KNOT}
        for speed, bound in zip(each.airspeeds, each.two_sigma, strict=True)
    ]


_ROUND = 5.0  # kt, degrees and seconds: what is read off instruments and a watch
_BRIEFING = (
    "Each line is a leg; heading and airspeed are those at its end. Set up and settle at each new "
    "airspeed and bank before its time begins. KCAS is the calibrated airspeed at which the "
    "simulator flew the leg: where the error of the indicator is not known, fly it as KIAS."
)


def _round(value: float, unit: float = 1.0) -> float:
    return _ROUND * round(value / unit / _ROUND)


def _bank_words(leg: BriefedLeg) -> str:
    """Return a leg's bank and the angle it turns through, as in `45° right, 3 turns and 70°`."""
    bank = _round(leg.bank, DEGREE)
    if not bank:
        return "level"
    turns, degrees = divmod(_round(leg.turned, DEGREE), 360.0)
    whole = f"{turns:.0f} turn{'s' if turns > 1 else ''}" if turns else ""
    turned = filter(None, (whole, f"{degrees:.0f}°" if degrees or not turns else ""))
    return f"{abs(bank):.0f}° {'right' if bank > 0.0 else 'left'}, {' and '.join(turned)}"


def _seconds(leg: BriefedLeg) -> float:
    """The time of a leg [s] as a watch is read: that of a short one in whole seconds."""
    return _round(leg.seconds) if leg.seconds > 4.0 * _ROUND else float(round(leg.seconds))


LEG_COLUMNS: tuple[Column[BriefedLeg], ...] = (
    Column("leg", lambda leg: leg.what, key="leg"),
    Column("heading", lambda leg: _round(leg.heading, DEGREE) % 360.0, "°", "03.0f", "heading_deg"),
    Column("KCAS", lambda leg: _round(leg.airspeed, KNOT), "", ".0f", "calibrated_airspeed_kt"),
    Column("bank", _bank_words),
    Column("", lambda leg: _round(leg.bank, DEGREE), key="bank_deg"),
    Column("", lambda leg: leg.turned / DEGREE, key="turned_deg"),
    Column("time", _seconds, "s", ".0f", "seconds"),
)


def pilot_card(name: str, legs: Sequence[BriefedLeg], depth: int = ANSWER) -> list[Node]:
    """The card of a name for the pilot who flies it by hand, at a depth; nothing without legs."""
    minutes = sum(map(_seconds, legs)) / MINUTE
    lines = (_BRIEFING, f"The legs take {minutes:.1f} min, without the time to settle.")
    title = f"The card for the pilot: {name}"
    if not legs:
        return []
    return [Heading(title, (*map(Sentence, lines), Table(LEG_COLUMNS, legs)), depth)]


def _briefed(plan: Plan) -> list[Forecast]:
    """The forecast whose card the pilot gets."""
    return [each for each in [plan.improved or plan.best] if each is not None]


def plan_tree(plan: Plan) -> list[Node]:
    """The recommendation with its pictures, the card, the table, and what cannot be flown."""
    more = (Figure("pitotbench.show.plan_panels.plan_panels", (plan,)),)
    return [
        *map(Sentence, plan_advice(plan)),
        *([Figure("pitotbench.show.plan_panels.bounds_panels", (plan,))] * bool(plan.forecasts)),
        *(Doubt(f"cannot be flown: {name}: {why}") for name, why in plan.refused.items()),
        *(n for each in _briefed(plan) for n in pilot_card(card_name(plan, each), each.legs)),
        Heading(plan.conditions, (Table(plan_columns(plan), plan.forecasts),)),
        Heading("By airspeed, and the ground covered", more, SOURCES),
        Heading("How to read this", (*map(Sentence, _READING),), SOURCES),
    ]


_READING = (
    "The simulator flies every card once in smooth air. Gusts of the expected level are drawn "
    "along its path, the data system records it, and the calibration, which does not know the gusts, "
    "gives its bound: the mean ±2σ over the wanted airspeeds. The 1σ between flights is its "
    "standard deviation from flight to flight.",
    "The bound does not hold errors that gusts do not show, such as one of the temperature, or a "
    "pressure error that changes with the load factor. Recorded minutes are those of the log; "
    "minutes in the air add the time to set up each speed anew.",
)
