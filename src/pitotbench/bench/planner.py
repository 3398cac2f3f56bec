"""Plan a flight: forecast all maneuvers of a request, rank them, and improve the best card."""

from collections.abc import Callable

from pitotbench.bench.card_search import best_card, free_numbers
from pitotbench.bench.forecasts import (
    PlanRequest,
    forecast,
)
from pitotbench.records import SEARCH_FLIGHTS, BadInputError, NoAnswerError
from pitotbench.records.case import Case
from pitotbench.records.forecast import COMPARED_MINUTES, Forecast, Plan
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.units import DEGREE, FOOT, KNOT

GENTLE_BANK = 35.0 * DEGREE  # a maneuver of 30° bank stays below it, overshoot included
_LEAST_GAIN = 0.99  # an improved card must have at most this share of the given one's bound,
_MOST_MINUTES = 1.02  # in at most this share of its minutes


def plan(
    request: PlanRequest | Case,
    search_flights: int = SEARCH_FLIGHTS,
    step: Callable[[], None] = lambda: None,
) -> Plan:
    """Predict the 2σ bound of a request's maneuvers, choose what to fly, and improve its card.

    A case stands for the request of what it expects, with its own data system. The search for a
    better card uses `search_flights` simulated flights, none where it is 0. `step` is called after
    each maneuver and each flight of the search. Raises NoAnswerError where no maneuver of the
    request can be flown.
    """
    if isinstance(request, Case):
        request = PlanRequest(request, request.das)
    found: list[Forecast] = []
    refused: dict[str, str] = {}
    for maneuver in request.maneuvers:
        try:
            found.append(forecast(request, maneuver))
        except (SimulationError, NoAnswerError, BadInputError) as error:
            refused[maneuver] = str(error)
        step()
    if not found:
        raise NoAnswerError(
            "no maneuver can be flown or determines the curve: " + "; ".join(refused.values())
        )
    # What leaves the box or takes longer than the minutes comes last: the first is the best.
    ranked = sorted(
        found,
        key=lambda each: (
            not each.fits(request.box),
            not each.ends_in(request.minutes),
            plan_merit(request, each),
        ),
    )
    allowed = [each for each in ranked if each.fits(request.box) and each.ends_in(request.minutes)]
    gentle = [each for each in allowed if each.steepest_bank <= GENTLE_BANK]
    best, improved, flights = allowed[0] if allowed else None, None, 0
    if best is not None and search_flights > 0 and free_numbers(best.maneuver):
        # The limit of the search is the minutes of the request, flown once, or those that the card
        # takes now.
        minutes = (
            best.minutes if request.want is not None or request.minutes is None else request.minutes
        )
        search = best_card(request, best.maneuver, minutes, search_flights, step)
        flights, tried = search.flights, forecast(request, best.maneuver, search.card)
        if (
            tried.mean < _LEAST_GAIN * best.within(minutes)
            and tried.minutes < _MOST_MINUTES * minutes
        ):
            improved = tried
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


def conditions_of(request: PlanRequest) -> str:
    """Return the expected conditions in words."""
    base, (low, high) = request.base, request.range
    return (
        f"{base.aircraft}, {base.altitude / FOOT:,.0f} ft, {request.das.label} Hz, turbulence "
        f"{base.turbulence}, wind {base.wind.speed / KNOT:.0f} kt from "
        f"{base.wind.from_direction / DEGREE:03.0f}°, {low / KNOT:.0f} to {high / KNOT:.0f} KIAS"
    )


def plan_merit(request: PlanRequest, each: Forecast) -> float:
    """Return the number that ranks a maneuver; the smallest is the best.

    The minutes to the wanted 2σ; else 2σ [m/s] after as many whole flights as fit into the minutes;
    else 2σ [m/s] for equal minutes.
    """
    if request.want is not None:
        return each.times_for(request.want) * each.minutes
    if request.minutes is not None:
        return each.within(request.minutes)
    return each.mean_in(COMPARED_MINUTES)
