"""Forecast all maneuvers of a request, rank them, and improve the card of the best one."""

from collections.abc import Callable

from pitotbench.bench.plan.card_search import best_card, free_numbers
from pitotbench.bench.plan.forecasting import forecast
from pitotbench.bench.plan.plan_request import PlanRequest
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.forecast import Forecast, Plan
from pitotbench.simulate import SimulationError
from pitotbench.units import DEGREE, FOOT, KNOT

COMPARED_MINUTES = 6.0  # without minutes in the request, maneuvers are compared for this flight time
GENTLE_BANK = 35.0 * DEGREE  # a maneuver of 30° bank stays below it, overshoot included
_LEAST_GAIN = 0.99  # an improved card must have at most this share of the given one's bound,
_MOST_MINUTES = 1.02  # in at most this share of its minutes


def make_plan(request: PlanRequest, search_flights: int = 0, step: Callable[[], None] = lambda: None) -> Plan:
    """Forecast every maneuver of the request, choose the best one, and improve its card.

    The search for a better card uses `search_flights` simulated flights, none where it is 0. `step` is called after
    each maneuver and each flight of the search. Raises NoAnswerError where no maneuver can be flown.
    """
    found, refused = _forecasts(request, step)
    ranked = sorted(found, key=lambda each: plan_merit(request, each))
    allowed = [each for each in ranked if is_allowed(request, each)]
    gentle = [each for each in allowed if each.steepest_bank <= GENTLE_BANK]
    best = allowed[0] if allowed else None
    improved, flights = _improved(request, best, search_flights, step)
    return Plan(
        conditions=conditions_of(request),
        forecasts=tuple(ranked),
        refused=refused,
        best=best,
        gentle=gentle[0] if gentle else None,
        improved=improved,
        flights_searched=flights,
        minutes=request.minutes,
        want=request.want,
        box=request.box,
    )


def _forecasts(request: PlanRequest, step: Callable[[], None]) -> tuple[list[Forecast], dict[str, str]]:
    """Return the forecasts, and the reason for each maneuver without one."""
    found: list[Forecast] = []
    refused: dict[str, str] = {}
    for maneuver in request.maneuvers:
        try:
            found.append(forecast(request, maneuver))
        except (SimulationError, NoAnswerError, BadInputError) as error:
            refused[maneuver] = str(error)
        step()
    if not found:
        raise NoAnswerError("no maneuver can be flown or determines the curve: " + "; ".join(refused.values()))
    return found, refused


def conditions_of(request: PlanRequest) -> str:
    """Return the expected conditions in words."""
    base, (low, high) = request.base, request.speeds
    return (
        f"{base.aircraft}, {base.altitude / FOOT:,.0f} ft, {request.das.label} Hz, turbulence {base.turbulence}, "
        f"wind {base.wind.speed / KNOT:.0f} kt from {base.wind.from_direction / DEGREE:03.0f}°, "
        f"{low / KNOT:.0f} to {high / KNOT:.0f} KIAS"
    )


def is_allowed(request: PlanRequest, each: Forecast) -> bool:
    """Return whether a maneuver fits into the box and, flown once, into the minutes."""
    return each.fits(request.box) and (request.minutes is None or each.minutes <= request.minutes)


def plan_merit(request: PlanRequest, each: Forecast) -> float:
    """Return the number that ranks a maneuver; the smallest is the best.

    It is the minutes to the wanted 2σ; else 2σ [m/s] after as many whole flights as fit into the minutes; else 2σ
    [m/s] for equal minutes.
    """
    if request.want is not None:
        return each.times_for(request.want) * each.minutes
    if request.minutes is not None:
        return each.within(request.minutes)
    return each.mean_in(COMPARED_MINUTES)


def _improved(
    request: PlanRequest, best: Forecast | None, flights: int, step: Callable[[], None]
) -> tuple[Forecast | None, int]:
    """Return the forecast of the best maneuver's improved card, or None, and the number of flights spent.

    The limit of the search is the minutes of the request, flown once, or else the minutes that the card takes now.
    """
    if best is None or flights <= 0 or not free_numbers(best.maneuver):
        return None, 0
    minutes = best.minutes if request.want is not None or request.minutes is None else request.minutes
    search = best_card(request, best.maneuver, minutes, flights, step)
    found = forecast(request, best.maneuver, search.card)
    better = found.mean < _LEAST_GAIN * best.within(minutes) and found.minutes < _MOST_MINUTES * minutes
    return (found if better else None), search.flights
