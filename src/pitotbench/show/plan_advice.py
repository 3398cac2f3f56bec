"""The recommendation of a plan in sentences, and the improved card as words and as a case file has it."""

from typing import Any

from pitotbench.records.forecast import Forecast, Plan
from pitotbench.show.quantity_words import entry_words, words
from pitotbench.units import KNOT


def plan_advice(plan: Plan) -> list[str]:
    """The recommendation: what to fly, how often, what to fly without steep turns, and the improved card."""
    if plan.best is None:
        return ["No maneuver fits into the minutes and the box: allow more of either."]
    lines = [f"Fly the {_forecast_words(plan.best)}."]
    if plan.want is not None:
        times = plan.best.times_for(plan.want)
        lines.append(
            f"For ±{plan.want / KNOT:g} kt (2σ) fly it {times} time{'s' if times > 1 else ''}: "
            f"{times * plan.best.minutes:.1f} min."
        )
    if plan.gentle is not None and plan.gentle is not plan.best:
        lines.append(
            "The forecast for steep turns assumes that the pressure error does not depend on the load factor. "
            f"Without steep turns, fly the {_forecast_words(plan.gentle)}."
        )
    if plan.improved is not None:
        lines.append(f"Improved card: fly the {_forecast_words(plan.improved)}, with {card_words(plan.improved)}.")
    elif plan.flights_searched:
        lines.append(f"The search flew {plan.flights_searched} other cards of it; none is better by more than 1 %.")
    return lines


def card_words(each: Forecast) -> str:
    """The changed numbers of a card as a pilot reads them, with units."""
    return "; ".join(entry_words(key, value) for key, value in each.card.items())


def card_lines(each: Forecast) -> list[str]:
    """The changed numbers of a card, as a case file has them."""
    return [f"{key} = {_rounded(value)}" for key, value in each.card.items()]


def _forecast_words(each: Forecast) -> str:
    return f"{words(each.maneuver)}: ±{each.mean / KNOT:.3f} kt (2σ, mean over the curve) in {each.minutes:.1f} min"


def _rounded(value: Any) -> str:
    return f"[{', '.join(f'{v:.4g}' for v in value)}]" if isinstance(value, list) else f"{value:.4g}"
