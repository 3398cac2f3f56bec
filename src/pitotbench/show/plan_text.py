"""A plan for the terminal."""

from rich.console import Console

from pitotbench.records.forecast import Plan
from pitotbench.show.columns import print_table
from pitotbench.show.plan_advice import plan_advice
from pitotbench.show.plan_table import plan_columns
from pitotbench.show.terminal import outside


def print_plan(plan: Plan, console: Console) -> None:
    """Print the recommendation, the conditions, the table, and the maneuvers that cannot be flown."""
    for line in plan_advice(plan):
        console.print(outside(line), soft_wrap=True)
    console.print()
    print_table(plan_columns(plan), plan.forecasts, console, plan.conditions)
    for maneuver, reason in plan.refused.items():
        console.print(outside(f"cannot be flown: {maneuver}: {reason}", "yellow"), soft_wrap=True)
