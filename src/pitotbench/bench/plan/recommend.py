"""All maneuvers forecast, ranked for the question that was asked, and the best one's card improved."""

from collections.abc import Callable

from pitotbench.bench.plan.card_search import best_card, free_numbers
from pitotbench.bench.plan.forecasting import forecast
from pitotbench.bench.plan.plan_request import PlanRequest
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.forecast import Forecast, Plan
from pitotbench.simulate import SimulationError
from pitotbench.units import DEGREE, FOOT, KNOT

COMPARED_MINUTES = 6.0  # where no minutes are given, maneuvers are compared as if flown for so long
GENTLE_BANK = 35.0 * DEGREE  # what a bank of 30° reaches at most
_LEAST_GAIN = 0.99  # an improved card must promise at most so much of the given one's bound,
_MOST_MINUTES = 1.02  # in at most so much of its minutes


def make_plan(request: PlanRequest, search_flights: int = 0, step: Callable[[], None] = lambda: None) -> Plan:
    """Forecast every maneuver of the request, choose, and search the best one's card within so many flights.

    `step` is called after each maneuver. Raises NoAnswerError where no maneuver can be flown at all.
    """
    found, refused = _forecasts(request, step)
    ranked = sorted(found, key=lambda each: plan_merit(request, each))
    allowed = [each for each in ranked if is_allowed(request, each)]
    gentle = [each for each in allowed if each.steepest_bank <= GENTLE_BANK]
    best = allowed[0] if allowed else None
    improved, flights = _improved(request, best, search_flights)
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
    """Every maneuver's forecast, and why the others have none."""
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
    """The expected conditions in words."""
    base, (low, high) = request.base, request.speeds
    return (
        f"{base.aircraft}, {base.altitude / FOOT:,.0f} ft, {request.system} Hz, turbulence {base.turbulence}, wind "
        f"{base.wind.speed / KNOT:.0f} kt from {base.wind.from_direction / DEGREE:03.0f}°, "
        f"{low / KNOT:.0f} to {high / KNOT:.0f} KIAS"
    )


def is_allowed(request: PlanRequest, each: Forecast) -> bool:
    """Whether a maneuver fits into the box and, flown once, into the minutes."""
    return each.fits(request.box) and (request.minutes is None or each.minutes <= request.minutes)


def plan_merit(request: PlanRequest, each: Forecast) -> float:
    """What is to be small: minutes to the wanted 2σ, or 2σ after as many whole flights as the minutes hold, or 2σ
    for equal minutes."""
    if request.want is not None:
        return each.times_for(request.want) * each.minutes
    if request.minutes is not None:
        return each.within(request.minutes)
    return each.mean_in(COMPARED_MINUTES)


def _improved(request: PlanRequest, best: Forecast | None, flights: int) -> tuple[Forecast | None, int]:
    """The best maneuver's card improved in its own minutes (or those given, flown once)."""
    if best is None or flights <= 0 or not free_numbers(best.maneuver):
        return None, 0
    minutes = best.minutes if request.want is not None or request.minutes is None else request.minutes
    search = best_card(request, best.maneuver, minutes, flights)
    found = forecast(request, best.maneuver, search.card)
    better = found.mean < _LEAST_GAIN * best.within(minutes) and found.minutes < _MOST_MINUTES * minutes
    return (found if better else None), search.flights
