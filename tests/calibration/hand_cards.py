"""Cards as a pilot writes them, made from formulas of their own: nothing here comes from the
package but the record.

The wind of a leg is a linear trend over the flight, a step from point to point and a gust that
lasts a leg; the curve is a bent line with a bump; the thermometer is wrong by one constant.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.records.legs import CardLeg, ReadingSteps

KT, FT, DEG = 1852.0 / 3600.0, 0.3048, np.pi / 180.0
STEPS = ReadingSteps(KT, 10.0 * FT, 1.0, KT, DEG)
Correction = Callable[[float], float]


@dataclass(frozen=True)
class Card:
    legs: tuple[CardLeg, ...]
    speeds_kt: tuple[float, ...]
    correction_kt: Correction


def _pressure(height_m: float) -> float:
    return 101325.0 * (1.0 - 0.0065 * height_m / 288.15) ** 5.255880


def _impact(calibrated_kt: float) -> float:
    return 101325.0 * ((1.0 + 0.2 * (calibrated_kt / 661.4786) ** 2) ** 3.5 - 1.0)


def true_airspeed_kt(
    indicated_kt: float, correction_kt: float, height_ft: float, temperature_k: float
) -> float:
    """The static source errs: what it reads too high lowers the impact pressure by as much."""
    impact = _impact(indicated_kt + correction_kt)
    static = _pressure(height_ft * FT) + _impact(indicated_kt) - impact
    mach = np.sqrt(5.0 * ((impact / static + 1.0) ** (2.0 / 7.0) - 1.0))
    return float(mach * np.sqrt(1.4 * 287.053 * temperature_k) / KT)


def _curve(rng: np.random.Generator) -> Correction:
    offset, tilt, bump, place = (
        rng.normal(0, 2.5),
        rng.normal(0, 2.0),
        rng.normal(0, 0.8),
        rng.uniform(85, 135),
    )

    def correction(indicated_kt: float) -> float:
        x = (indicated_kt - 110.0) / 40.0
        return float(offset + tilt * x + bump * np.exp(-0.5 * ((indicated_kt - place) / 18.0) ** 2))

    return correction


def _ground(airspeed: float, track: float, wind: np.ndarray) -> float:
    """Ground speed along a track [kt]: the pilot holds the track, and the nose corrects for the
    wind.
    """
    along = wind @ np.array([np.cos(track), np.sin(track)])
    across = wind @ np.array([-np.sin(track), np.cos(track)])
    return float(along + np.sqrt(airspeed**2 - across**2))


def make_card(seed: int, legs: int = 4, points: int = 5, loose: float = 0.0) -> Card:
    """A card of one configuration. With `loose`, that share of the legs is flown some 25° off the
    usual tracks, and each point has an order of its own.
    """
    rng = np.random.default_rng(seed)
    correction = _curve(rng)
    speeds = np.linspace(75.0, 145.0, points) + rng.uniform(-3, 3, points)
    rng.shuffle(speeds)
    rows = _flown(
        rng,
        [("clean", str(i + 1), v) for i, v in enumerate(speeds)],
        legs,
        {"clean": correction},
        loose,
    )
    return Card(rows, tuple(speeds), correction)


def make_mixed_card(seed: int) -> tuple[tuple[CardLeg, ...], dict[str, Correction]]:
    """A card of 81 rows: five points of four legs in each of four configurations, and one leg more,
    the points in any order.
    """
    rng = np.random.default_rng(seed)
    curves = {name: _curve(rng) for name in ("clean", "gear", "half flaps", "full flaps")}
    points = [
        (name, f"{name} {i + 1}", float(speed + rng.uniform(-3, 3)))
        for name in curves
        for i, speed in enumerate(np.linspace(75.0, 145.0, 5))
    ]
    points = [points[i] for i in rng.permutation(len(points))]
    rows = _flown(rng, [*points, points[0]], 4, curves)
    return rows[:81], curves


def _flown(
    rng: np.random.Generator,
    points: Sequence[tuple[str, str, float]],
    legs: int,
    curves: Mapping[str, Correction],
    loose: float = 0.0,
) -> tuple[CardLeg, ...]:
    """The legs of points, each with its configuration, its name and its airspeed [kt]."""
    height, day = rng.uniform(2000, 9000), rng.normal(0, 8)
    wrong_probe = rng.normal(0, 0.75)
    wind = rng.uniform(3, 25) * np.array([np.cos(a := rng.uniform(0, 2 * np.pi)), np.sin(a)])
    trend, jump, gust = rng.normal(0, 0.25, 2), rng.uniform(0.5, 3.0), rng.uniform(0.1, 1.2)
    first = rng.uniform(0, 360)
    rows: list[CardLeg] = []
    for configuration, point, speed in points:
        for leg in rng.permutation(legs) if loose else range(legs):
            local = wind + rng.normal(0, gust, 2)
            wind = wind + trend
            held = speed + rng.uniform(-2, 2)
            altitude = height + rng.normal(0, 40)
            temperature = 288.15 - 0.0065 * altitude * FT + day
            airspeed = true_airspeed_kt(held, curves[configuration](held), altitude, temperature)
            track = (first + 360.0 / legs * leg + rng.normal(0, 4)) % 360.0
            if loose and rng.random() < loose:
                track = (track + rng.normal(0, 25)) % 360.0
            ground = _ground(airspeed, track * DEG, local)
            rows.append(
                CardLeg(
                    row=len(rows) + 1,
                    point=point,
                    configuration=configuration,
                    indicated_airspeed=round(held) * KT,
                    pressure_altitude=round(altitude / 10) * 10 * FT,
                    air_temperature=round(temperature - 273.15 + wrong_probe) + 273.15,
                    ground_speed=round(ground) * KT,
                    track=round(track) % 360 * DEG,
                )
            )
        wind = wind + rng.normal(0, jump, 2)
    return tuple(rows)


def spoil(card: Card, row: int, **changed: float) -> Card:
    """Write one number of a leg wrong: `track` and `temperature` in degrees, speeds in knots."""
    units = {"track": DEG, "ground_speed": KT, "indicated_airspeed": KT}
    values = {name: value * units[name] for name, value in changed.items()}
    legs = tuple(replace(leg, **values) if leg.row == row else leg for leg in card.legs)
    return replace(card, legs=legs)


def with_slips(
    legs: tuple[CardLeg, ...], seed: int, count: int
) -> tuple[tuple[CardLeg, ...], set[int]]:
    """Write numbers of some legs wrong, as a hand does; return the legs, and the rows."""
    rng = np.random.default_rng([seed, 1])
    wrong = list(legs)
    rows = rng.choice(len(legs), count, replace=False)
    for place in rows:
        leg = legs[place]
        field, si = [("track", DEG), ("ground_speed", KT), ("indicated_airspeed", KT)][
            rng.integers(3)
        ]
        number = round(getattr(leg, field) / si)
        choices = [_exchanged(number), number + 10 * int(rng.choice([-2, -1, 1, 2]))]
        choices.append((number + 180) % 360 if field == "track" else number * 10)
        least = 20 if field == "track" else 8
        far = [c for c in choices if c > 0 and abs(c - number) >= least]
        wrong[place] = replace(leg, **{field: float(rng.choice(far)) * si})
    return tuple(wrong), {int(place) + 1 for place in rows}


def _exchanged(number: int) -> int:
    text = f"{number:02d}"
    return int(text[:-2] + text[-1] + text[-2])
