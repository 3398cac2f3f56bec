"""A plan for the terminal, for programs and as a page."""

from typing import Any

from rich.box import SIMPLE_HEAVY
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.markup import render
from pitotbench.show.plan_panels import plan_panels
from pitotbench.show.terminal import outside
from pitotbench.units import DEGREE, KNOT, NAUTICAL_MILE

_COMPARED = 6.0  # min
_TABLE_WIDTH = 140


def headings(plan: Plan) -> list[str]:
    """The columns of the table of forecasts."""
    wanted = [] if plan.want is None else [f"flights for\n±{plan.want / KNOT:g} kt", "their\n[min]"]
    return [
        "maneuver",
        "recorded\n[min]",
        "in the air\n[min]",
        "predicted 2σ\n[kt]",
        "1σ of it\n[kt]",
        f"2σ in {plan.minutes or _COMPARED:g} min\n[kt]",
        *wanted,
        "ground\n[nmi]",
        "bank\n[°]",
        "remark",
    ]


def row(plan: Plan, each: Forecast) -> list[str]:
    """A forecast in the units of the table."""
    times = 0 if plan.want is None else each.times_for(plan.want)
    north, east = (side / NAUTICAL_MILE for side in each.extent)
    minutes = plan.minutes
    return [
        each.maneuver,
        f"{each.minutes:.1f}",
        f"{each.elapsed_minutes:.1f}",
        f"{each.mean / KNOT:.3f}",
        f"{each.spread / KNOT:.3f}",
        f"{(each.mean_in(_COMPARED) if minutes is None else each.within(minutes)) / KNOT:.3f}",
        *([] if plan.want is None else [f"{times}", f"{times * each.minutes:.0f}"]),
        f"{north:.1f} × {east:.1f}",
        f"{each.steepest_bank / DEGREE:.0f}",
        remark(plan, each),
    ]


def remark(plan: Plan, each: Forecast) -> str:
    """Why a maneuver is chosen or cannot be."""
    if not each.fits(plan.box):
        return "leaves the box"
    if plan.minutes is not None and each.minutes > plan.minutes:
        return "takes longer"
    if each is plan.best:
        return "best"
    return "best, no steep turn" if each is plan.gentle else ""


def print_plan(plan: Plan, console: Console) -> None:
    """Print the table, the recommendation and the improved card."""
    table = Table(header_style="bold", pad_edge=False, box=SIMPLE_HEAVY)
    for place, heading in enumerate(headings(plan)):
        table.add_column(escape(heading), justify="left" if place == 0 else "right", no_wrap=True)
    for each in plan.forecasts:
        table.add_row(*row(plan, each))
    console.width = max(console.width, _TABLE_WIDTH)
    console.print(outside(plan.conditions))
    console.print(table)
    for line in plan_advice(plan):
        console.print(outside(line))
    for maneuver, reason in plan.refused.items():
        console.print(outside(f"cannot be flown: {maneuver}: {reason}", "yellow"))


def plan_advice(plan: Plan) -> list[str]:
    """The recommendation in sentences."""
    if plan.best is None:
        return ["No maneuver fits into the minutes and the box: allow more of either."]
    lines = [f"Fly {_named(plan.best)}."]
    if plan.want is not None:
        times = plan.best.times_for(plan.want)
        lines.append(
            f"For ±{plan.want / KNOT:g} kt (2σ) fly it {times} time{'s' if times > 1 else ''}: "
            f"{times * plan.best.minutes:.1f} min."
        )
    if plan.gentle is not None and plan.gentle is not plan.best:
        lines.append(
            "Steep turns take for granted that the pressure error does not depend on the load factor. "
            f"Without them, fly {_named(plan.gentle)}."
        )
    if plan.improved is not None:
        lines.append(f"Its card improved: {_named(plan.improved)}, with {', '.join(card_lines(plan.improved))}.")
    elif plan.flights_searched:
        lines.append(f"{plan.flights_searched} other cards of it were tried; none is better by more than 1 %.")
    return lines


def _named(each: Forecast) -> str:
    name = each.maneuver.replace("_", " ")
    return f"{name}: 2σ of {each.mean / KNOT:.3f} kt in {each.minutes:.1f} min"


def card_lines(each: Forecast) -> list[str]:
    """The changed numbers of a card, as a case file has them."""
    return [f"{key} = {_rounded(value)}" for key, value in each.card.items()]


def _rounded(value: Any) -> str:
    return f"[{', '.join(f'{v:.4g}' for v in value)}]" if isinstance(value, list) else f"{value:.4g}"


def plan_json(plan: Plan) -> dict[str, Any]:
    """The plan for programs: units in every name."""
    return {
        "conditions": plan.conditions,
        "minutes": plan.minutes,
        "want_kt": None if plan.want is None else plan.want / KNOT,
        "box_nm": None if plan.box is None else plan.box / NAUTICAL_MILE,
        "forecasts": [_json(plan, each) for each in plan.forecasts],
        "refused": dict(plan.refused),
        "best": plan.best.maneuver if plan.best else None,
        "best_without_steep_turns": plan.gentle.maneuver if plan.gentle else None,
        "improved": None if plan.improved is None else _json(plan, plan.improved),
        "advice": plan_advice(plan),
    }


def _json(plan: Plan, each: Forecast) -> dict[str, Any]:
    wanted = None if plan.want is None else each.times_for(plan.want)
    return {
        "maneuver": each.maneuver,
        "card": dict(each.card),
        "minutes": each.minutes,
        "elapsed_minutes": each.elapsed_minutes,
        "two_sigma_kt": each.mean / KNOT,
        "two_sigma_spread_kt": each.spread / KNOT,
        "known_noise_two_sigma_kt": each.mean / each.widening / KNOT,
        "flights_for_want": wanted,
        "minutes_for_want": None if wanted is None else wanted * each.minutes,
        "ground_north_nm": each.extent[0] / NAUTICAL_MILE,
        "ground_east_nm": each.extent[1] / NAUTICAL_MILE,
        "steepest_bank_deg": each.steepest_bank / DEGREE,
        "curve": [
            {"indicated_airspeed_kt": speed / KNOT, "two_sigma_kt": bound / KNOT}
            for speed, bound in zip(each.airspeeds, each.two_sigma, strict=True)
        ],
        "remark": remark(plan, each),
    }


def plan_page(plan: Plan) -> str:
    """The recommendation as one self-contained page."""
    return render(
        "plan.html",
        title="What to fly",
        subtitle=plan.conditions,
        advice=plan_advice(plan),
        panels=plan_panels(plan),
        headings=[text.split("\n") for text in headings(plan)],
        rows=[row(plan, each) for each in plan.forecasts],
        refused=plan.refused,
        card=[] if plan.improved is None else card_lines(plan.improved),
    )
