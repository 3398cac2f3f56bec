"""Search the best card of a maneuver.

Search the best card: change the free numbers of a maneuver until the bound of the curve is
smallest. The search minimizes the bound for known noise (the inverse information matrix) on the
flight of the card in smooth air, within the minutes given. Headings are not free: the simulated
turbulence has an axis, and no known axis exists in real air, so the best headings would be those of
the simulator.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np

from pitotbench.bench.forecasts import (
    CardChanges,
    PlanRequest,
    known_noise_two_sigma,
    smooth_flight,
    written,
)
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.card import override
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.units import DEGREE, INCH_OF_MERCURY, Array

# Entry of a card: least and largest value [SI]. A list has as many free numbers as entries.
_FREE = {
    "dwell": (2.0, 240.0),
    "dwells": (2.0, 240.0),
    "turns": (0.25, 4.0),
    "circles": (0.25, 4.0),
    "step": (0.4 * INCH_OF_MERCURY, 3.0 * INCH_OF_MERCURY),
    "step_time": (3.0, 20.0),
    "bank": (15.0 * DEGREE, 45.0 * DEGREE),  # 45° is the steep turn that pilots train
}
# times ln(minutes over the limit): twice the gain of flying longer, since 2σ falls as 1/√t
_OVERTIME = 1.0
# of a number's logarithm; up and down in turn, so that the first cards take similar times
_FIRST_STEP = 0.35
_UNFLYABLE = 50.0  # cost, above that of every card that can be flown


@dataclass(frozen=True, slots=True)
class FreeNumber:
    """One number of a card that may change.

    `place` is its index in the list of the entry, None for a plain number. `suffix` is the unit
    suffix of the written key, "" for a count. `low` and `high` are its bounds [SI].
    """

    entry: str
    place: int | None
    suffix: str
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Search:
    """The result of a search: the card's changed numbers, keys with units, and flights flown."""

    maneuver: str
    card: CardChanges
    flights: int


def free_numbers(maneuver: str) -> tuple[FreeNumber, ...]:
    """Return the free numbers of a maneuver's card.

    The speeds between the first and the last are among them.
    """
    card = MANEUVERS[maneuver].card
    found = []
    for entry in (f for f in fields(card) if f.name in _FREE):
        value = getattr(card, entry.name)
        places = range(len(value)) if isinstance(value, tuple) else (None,)
        suffix = str(entry.metadata.get("suffix", ""))
        found += [FreeNumber(entry.name, place, suffix, *_FREE[entry.name]) for place in places]
    between = range(1, len(card.speeds) - 1)
    ends = min(card.speeds), max(card.speeds)
    return (*found, *(FreeNumber("speeds", place, "kt", *ends) for place in between))


def best_card(
    request: PlanRequest,
    maneuver: str,
    minutes: float,
    flights: int = 60,
    step: Callable[[], None] = lambda: None,
) -> Search:
    """Search the card of a maneuver with the smallest bound in at most so many `minutes`.

    The search flies so many `flights`, by the simplex of Nelder and Mead (1965) on the logarithms
    of the free numbers. A card that cannot be flown, does not determine the answer or leaves the
    box gets the cost `_UNFLYABLE`. A card that takes longer than `minutes` pays for the overtime.
    `step` is called after each flight. Raises BadInputError where the maneuver has no free number.
    """
    from scipy.optimize import minimize

    free = free_numbers(maneuver)
    if not free:
        raise BadInputError(f"the card of {maneuver} has no free numbers: choose another maneuver")
    card = override(MANEUVERS[maneuver].card, request.case(maneuver).card)
    values = [(getattr(card, number.entry), number.place) for number in free]
    start = np.log([value if place is None else value[place] for value, place in values])
    simplex = np.vstack([start, start + _FIRST_STEP * np.diag((-1.0) ** np.arange(len(free)))])
    simplex = np.clip(simplex, np.log([n.low for n in free]), np.log([n.high for n in free]))

    def changes_of(x: Array) -> CardChanges:
        """Return the changes of the card that set the free numbers to exp(x)."""
        numbers, lists = dict[str, float](), dict[str, list[float]]()
        for number, value in zip(free, np.exp(x), strict=True):
            key = f"{number.entry}_{number.suffix}" if number.suffix else number.entry
            if number.place is None:
                numbers[key] = written(value, number.suffix)
            else:
                present = [written(v, number.suffix) for v in getattr(card, number.entry)]
                lists.setdefault(key, present)[number.place] = written(value, number.suffix)
        return {**numbers, **lists}

    def cost(x: Array) -> float:
        """Return ln 2σ plus a penalty for overtime."""
        try:
            flight = smooth_flight(request, maneuver, changes_of(x))
            bound = float(np.mean(known_noise_two_sigma(request, flight)))
        except (SimulationError, NoAnswerError, BadInputError):
            return _UNFLYABLE
        finally:
            step()
        side = max(float(np.ptp(flight[f"position_{axis}"])) for axis in ("north", "east"))
        if request.box is not None and side > request.box:
            return _UNFLYABLE
        return float(np.log(bound) + _OVERTIME * max(0.0, np.log(flight.duration / 60.0 / minutes)))

    found = minimize(
        cost,
        start,
        method="Nelder-Mead",
        bounds=[(np.log(n.low), np.log(n.high)) for n in free],
        options={"maxfev": flights, "initial_simplex": simplex, "xatol": 0.02, "fatol": 0.003},
    )
    return Search(maneuver, changes_of(found.x), int(found.nfev))
