"""Plan a card to be flown by hand for a wanted bound.

The card's own model, before a leg is flown. The bound of a curve depends on speeds, tracks and
reading steps alone, and on how much the wind wanders: as much as on a usual day.
"""

from itertools import product

import numpy as np

from pitotbench.calibration.card_model import CardModel
from pitotbench.calibration.options import USUAL, Accuracies
from pitotbench.records.legs import USUAL_STEPS, CardLeg, HandPlan
from pitotbench.units import FOOT

LEG_MINUTES = 1.5  # 30 s on the leg, and the turn to the next
POINT_MINUTES = 1.5  # to set up another airspeed
_LEGS = (3, 4)  # a point
_POINTS = (3, 4, 5, 6, 8)
_TIMES = (1, 2, 3, 4)  # that the card is flown
_SPEEDS = 7
_TEMPERATURE = 278.15  # K; the bound hardly depends on it


def plans_by_hand(
    low: float, high: float, wind: tuple[float, float] = (0.0, 0.0), stated: Accuracies = USUAL
) -> list[HandPlan]:
    """Return cards for a curve between two indicated airspeeds [m/s], the shortest first.

    Each has a smaller bound than all shorter ones. `wind` [m/s] is toward north and east.
    """
    plans = [
        _plan(legs, points, times, low, high, wind, stated)
        for legs, points, times in product(_LEGS, _POINTS, _TIMES)
    ]
    better: list[HandPlan] = []
    for plan in sorted(plans, key=lambda each: (each.minutes, each.two_sigma)):
        if not better or plan.two_sigma < better[-1].two_sigma:
            better.append(plan)
    return better


def _plan(
    legs: int,
    points: int,
    times: int,
    low: float,
    high: float,
    wind: tuple[float, float],
    stated: Accuracies,
) -> HandPlan:
    speeds = np.linspace(low, high, points)
    order = np.concatenate([speeds if turn % 2 == 0 else speeds[::-1] for turn in range(times)])
    card = [
        _leg(number * legs + leg, number, float(speed), 2.0 * np.pi * leg / legs, wind)
        for number, speed in enumerate(order)
        for leg in range(legs)
    ]
    model = CardModel(card, USUAL_STEPS, stated)
    variance = model.expected_variance(np.linspace(low, high, _SPEEDS))
    minutes = len(card) * LEG_MINUTES + len(order) * POINT_MINUTES
    return HandPlan(legs, tuple(map(float, speeds)), times, minutes, 2.0 * float(np.sqrt(variance)))


def _leg(row: int, number: int, speed: float, track: float, wind: tuple[float, float]) -> CardLeg:
    """Return a leg at 5,000 ft along a track, with about the ground speed that it would have."""
    along = np.array([np.cos(track), np.sin(track)])
    ground = max(1.08 * speed + float(along @ np.array(wind)), 1.0)
    return CardLeg(
        row=row + 1,
        point=str(number),
        configuration="",
        indicated_airspeed=speed,
        pressure_altitude=5000.0 * FOOT,
        air_temperature=_TEMPERATURE,
        ground_speed=ground,
        track=track,
    )
