"""The plan of a card flown by hand: for the terminal and as plain data."""

from collections.abc import Sequence
from typing import Any

from rich.console import Console

from pitotbench.records.hand_card import HandPlan
from pitotbench.show.columns import Column, json_rows, print_table
from pitotbench.show.quantity_words import listed
from pitotbench.show.terminal import outside
from pitotbench.units import DEGREE, KNOT

PLAN_COLUMNS: tuple[Column[HandPlan], ...] = (
    Column("legs a point", lambda p: p.legs, "", "d", "legs"),
    Column("airspeeds", lambda p: len(p.airspeeds), "", "d", "points"),
    Column("times", lambda p: p.times, "", "d", "times"),
    Column("time in the air", lambda p: p.minutes, "min", ".0f", "minutes"),
    Column("±2σ of the curve", lambda p: p.two_sigma / KNOT, "kt", ".2f", "two_sigma_kt"),
)


def chosen_plan(plans: Sequence[HandPlan], want: float | None, minutes: float | None) -> HandPlan | None:
    """The shortest card with the wanted bound [m/s], else the best within the minutes, else the best of all."""
    fitting = [plan for plan in plans if minutes is None or plan.minutes <= minutes]
    if want is not None:
        return next((plan for plan in fitting if plan.two_sigma <= want), None)
    return min(fitting, key=lambda plan: plan.two_sigma, default=None)


def plan_words(plan: HandPlan | None, want: float | None) -> list[str]:
    """The card in the words of a pilot."""
    if plan is None:
        wanted = "" if want is None else f" with ±{want / KNOT:g} kt (2σ)"
        return [f"No card by hand{wanted} fits into the minutes: record a log instead, or allow more of either."]
    speeds = listed([f"{speed / KNOT:.0f}" for speed in plan.airspeeds])
    tracks = listed([f"{track / DEGREE:03.0f}°" for track in plan.tracks])
    again = "" if plan.times == 1 else f" Fly all of it {plan.times} times, every other time from the fast end."
    return [
        f"Fly {speeds} KIAS, at each {plan.legs} legs on true tracks {tracks}; "
        "all turned together by any angle will do.",
        f"Hold each leg for 30 s and read whole knots and degrees.{again} "
        f"It takes {plan.minutes:.0f} min and gives a curve with a 2σ of {plan.two_sigma / KNOT:.2f} kt.",
    ]


def print_hand_plan(
    plans: Sequence[HandPlan], chosen: HandPlan | None, want: float | None, console: Console
) -> None:
    """Print the card to fly, and the others from which it is chosen."""
    for line in plan_words(chosen, want):
        console.print(outside(line))
    console.print()
    print_table(PLAN_COLUMNS, plans, console, "cards by hand, each better than all shorter ones")


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
