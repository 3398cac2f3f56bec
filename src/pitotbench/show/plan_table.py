"""The table of a plan: one row a maneuver, in order of merit; and the plan as plain data."""

from typing import Any

from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.columns import Column, json_rows
from pitotbench.show.plan_advice import plan_advice
from pitotbench.units import DEGREE, KNOT, NAUTICAL_MILE

_COMPARED = 6.0  # min: maneuvers are compared over equal times where the user names none


def plan_columns(plan: Plan) -> list[Column[Forecast]]:
    """The columns of a plan's forecasts. Those of a wanted bound are shown only where one was asked for."""
    want, minutes = plan.want, plan.minutes

    def times(each: Forecast) -> int | None:
        return None if want is None else each.times_for(want)

    def minutes_for_want(each: Forecast) -> float | None:
        flights = times(each)
        return None if flights is None else flights * each.minutes

    def in_minutes(each: Forecast) -> float:
        return (each.mean_in(_COMPARED) if minutes is None else each.within(minutes)) / KNOT

    wanted = "" if want is None else f"flights for ±{want / KNOT:g} kt"
    return [
        Column("maneuver", lambda each: each.maneuver, key="maneuver"),
        Column("", lambda each: dict(each.card), key="card"),
        Column("recorded", lambda each: each.minutes, "min", ".1f", "minutes"),
        Column("in the air", lambda each: each.elapsed_minutes, "min", ".1f", "elapsed_minutes"),
        Column("predicted ±2σ", lambda each: each.mean / KNOT, "kt", ".3f", "two_sigma_kt"),
        Column("1σ between flights", lambda each: each.spread / KNOT, "kt", ".3f", "two_sigma_spread_kt"),
        Column("", lambda each: each.mean / each.widening / KNOT, key="known_noise_two_sigma_kt"),
        Column(f"±2σ in {minutes or _COMPARED:g} min", in_minutes, "kt", ".3f"),
        Column(wanted, times, style="d", key="flights_for_want"),
        Column(wanted and "time for them", minutes_for_want, "min", ".0f", "minutes_for_want"),
        Column("ground N–S", lambda each: each.extent[0] / NAUTICAL_MILE, "nmi", ".1f", "ground_north_nm"),
        Column("ground E–W", lambda each: each.extent[1] / NAUTICAL_MILE, "nmi", ".1f", "ground_east_nm"),
        Column("bank", lambda each: each.steepest_bank / DEGREE, "°", ".0f", "steepest_bank_deg"),
        Column("", _curve, key="curve"),
        Column("remark", lambda each: remark(plan, each), key="remark"),
    ]


def remark(plan: Plan, each: Forecast) -> str:
    """Why a maneuver is chosen, or why it cannot be."""
    if not each.fits(plan.box):
        return "leaves the box"
    if plan.minutes is not None and each.minutes > plan.minutes:
        return "takes longer"
    if each is plan.best:
        return "best"
    return "best, no steep turn" if each is plan.gentle else ""


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
        "advice": plan_advice(plan),
    }


def _curve(each: Forecast) -> list[dict[str, float]]:
    return [
        {"indicated_airspeed_kt": speed / KNOT, "two_sigma_kt": bound / KNOT}
        for speed, bound in zip(each.airspeeds, each.two_sigma, strict=True)
    ]
