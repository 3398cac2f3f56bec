"""A plan as a page."""

from pitotbench.records.forecast import Plan
from pitotbench.show.columns import html_table
from pitotbench.show.markup import render
from pitotbench.show.plan_advice import card_lines, plan_advice
from pitotbench.show.plan_panels import plan_panels
from pitotbench.show.plan_table import plan_columns


def plan_page(plan: Plan) -> str:
    """The recommendation as one self-contained page (HTML)."""
    return render(
        "plan.html",
        title="What to fly",
        subtitle=plan.conditions,
        advice=plan_advice(plan),
        panels=plan_panels(plan),
        table=html_table(plan_columns(plan), plan.forecasts),
        refused=plan.refused,
        card=[] if plan.improved is None else card_lines(plan.improved),
    )
