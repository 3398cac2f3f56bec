"""Compare a measured log with the same card flown again by the simulator, segment by segment.

The autopilot flies the simulator to the same targets. A missing effect therefore shows in the power
and the pitch that hold them, and in quantities that are not held (deceleration, times). Both sides
are logs of the same data system, and both pass through the same functions. The tolerances are 40 %
of those that a flight simulator must meet against flight (14 CFR Part 60, Appendix A, Attachment 2:
3 kt, 1.5° pitch, 2° bank, 3° heading). This share is required of one simulator against another.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

import numpy as np

from pitotbench import air
from pitotbench.records.gap import Feature, FlownAgain, History, Tolerance
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, INCH_OF_MERCURY, KNOT, STANDARD_GRAVITY, Array, Seconds

SHARE = 0.4  # of the tolerances against flight
# Tolerances of a simulator against flight.
LIMITS = {"indicated airspeed": 3.0, "pitch": 1.5, "bank": 2.0, "heading": 3.0}  # kt, °
QUIET = 2.0 * DEGREE  # bank below which a segment is not a turn
SMOOTHED = 1.0  # s over which gusts and sensor noise are averaged on both sides
BEGINNING = 20.0  # s at the start of a segment over which its change of airspeed is taken
SHORTEST = 5.0  # s of a segment that is summed up

HAND = ("bank", "pitch", "heading")  # what a pilot's hand moves to and fro
STILL = 0.01  # ° or m/s²; less than this is the noise of a sensor
# degree of the polynomial that is taken out of a segment: it is the maneuver, not the hand
CURVED = 3

Parts = Mapping[str, FlightLog]  # the segments of a log by their labels


def _airspeed(log: FlightLog) -> Array:
    return air.calibrated_airspeed(log.impact_pressure) / KNOT


QUANTITIES: dict[str, tuple[str, Callable[[FlightLog], Array | None]]] = {
    "indicated airspeed": ("kt", _airspeed),
    "pitch": ("°", lambda log: None if log.pitch is None else log.pitch / DEGREE),
    "bank": ("°", lambda log: None if log.roll is None else log.roll / DEGREE),
    "heading": ("°", lambda log: None if log.heading is None else np.unwrap(log.heading) / DEGREE),
    "manifold pressure": (
        "inHg",
        lambda log: (
            None
            if log.manifold_pressure_left is None
            else log.manifold_pressure_left / INCH_OF_MERCURY
        ),
    ),
}


def compare_cards(
    measured: FlightLog, simulated: Sequence[FlightLog], patched: Sequence[FlightLog]
) -> FlownAgain:
    """Return features, tolerances and histories of a measured log and of flights of the simulator.

    `simulated` are flights without and `patched` with the patch: at least two of each, which differ
    by gusts and noise alone. Where the logs have no segments in common, only the reason is
    returned.
    """
    flights = (*simulated, *patched)
    labels = _common(measured, flights)
    if not labels:
        return FlownAgain(
            skipped="the log names no segments that the simulator's flight of the card has as well"
        )
    flown = _parts(measured, labels)
    before, after = ([_parts(log, labels) for log in group] for group in (simulated, patched))
    features = [f for label in labels for f in _features(label, flown, before, after)]
    begin = float(measured.time[0])
    histories = [
        h for label in labels for h in _histories(label, begin, flown, before[0], after[0])
    ]
    limits = [_tolerance(name, labels, flown, before, after) for name in LIMITS]
    return FlownAgain(tuple(features), tuple(t for t in limits if t is not None), tuple(histories))


def control_activity_difference(measured: FlightLog, flights: Sequence[FlightLog]) -> float:
    """Return how far the hand that flew a log is from that of some flights of its card [-].

    The root mean square, over bank, pitch and heading, of the logarithm of how much more they move
    to and fro within the segments. Two flights by one hand are some 0.15 apart, the autopilot alone
    and a good pilot 0.6, a good pilot and a busy one 0.4 (three flights each of three cards). 0
    where the logs have no segments in common.
    """
    labels = _common(measured, flights)
    own, others = _to_and_fro(measured, labels), [_to_and_fro(log, labels) for log in flights]
    common = [name for name in own if all(name in each for each in others)]
    ratios = [np.mean([np.log(each[name] / own[name]) for each in others]) for name in common]
    return float(np.sqrt(np.mean(np.square(ratios)))) if ratios else 0.0


def gust_difference(measured: FlightLog, flights: Sequence[FlightLog]) -> float:
    """Return how much more a log's load factor shakes than that of its card, as |ln|.

    Gusts shake the load factor within a second, and no hand does. The logarithm is 0.35 between
    smooth air and light turbulence, and 1.0 between light and moderate turbulence (circles of 20
    Hz). Infinite where a log has no load factor.
    """
    own, others = _shaking(measured), [_shaking(log) for log in flights]
    if own is None or any(each is None for each in others):
        return np.inf
    return float(abs(np.log(own) - np.mean([np.log(each) for each in others if each is not None])))


def _shaking(log: FlightLog) -> float | None:
    if log.specific_force_z is None:
        return None
    values = log.specific_force_z
    return max(STILL, float(np.std(values - _smooth(log.time, values))))


def _to_and_fro(log: FlightLog, labels: Sequence[str]) -> dict[str, float]:
    """The root mean square of each quantity of a hand around a smooth course of each segment."""
    found: dict[str, float] = {}
    for name in HAND:
        squares = []
        for part in _parts(log, labels).values():
            values, time = QUANTITIES[name][1](part), part.time - part.time[0]
            if values is not None and time[-1] >= SHORTEST:
                smooth = _smooth(time, values)
                squares.append((smooth - np.polyval(np.polyfit(time, smooth, CURVED), time)) ** 2)
        if squares:
            found[name] = max(STILL, float(np.sqrt(np.mean(np.concatenate(squares)))))
    return found


def _common(measured: FlightLog, flights: Sequence[FlightLog]) -> list[str]:
    """Segments of the measured log, in order, that every flight has."""
    flown = [set(_runs(log)) for log in flights]
    return [label for label in _runs(measured) if all(label in each for each in flown)]


def _runs(log: FlightLog) -> dict[str, slice]:
    """The rows of every segment by its label; a repeated label gets a number."""
    if log.segment is None:
        return {}
    edges = np.flatnonzero(log.segment[1:] != log.segment[:-1]) + 1
    bounds = [0, *edges.tolist(), len(log)]
    rows: dict[str, slice] = {}
    for begin, end in pairwise(bounds):
        label, number = str(log.segment[begin]), 2
        name = label
        while name in rows:
            name, number = f"{label} ({number})", number + 1
        if end - begin > 1:
            rows[name] = slice(begin, end)
    return rows


def _parts(log: FlightLog, labels: Sequence[str]) -> Parts:
    runs, rows = _runs(log), np.arange(len(log))
    return {label: log.select(rows[runs[label]]) for label in labels}


def _features(
    label: str, measured: Parts, simulated: Sequence[Parts], patched: Sequence[Parts]
) -> list[Feature]:
    """Return the features of a segment, with the deviation of flights of one airplane."""
    in_flight = features_of(measured[label])
    before = [features_of(parts[label]) for parts in simulated]
    after = [features_of(parts[label]) for parts in patched]
    features = []
    for (name, unit), value in in_flight.items():
        sides = [
            np.array([each[name, unit] for each in group if (name, unit) in each])
            for group in (before, after)
        ]
        if all(len(side) > 1 for side in sides):
            freedom = sum(len(side) - 1 for side in sides)
            chance = np.sqrt(
                sum(float(np.sum((side - side.mean()) ** 2)) for side in sides) / freedom
            )
            spread = float(chance * np.sqrt(1.0 + 1.0 / len(sides[0])))
            features.append(
                Feature(
                    label,
                    name,
                    unit,
                    value,
                    float(sides[0].mean()),
                    float(sides[1].mean()),
                    spread,
                    freedom,
                )
            )
    return features


def features_of(part: FlightLog) -> dict[tuple[str, str], float]:
    """Return the numbers that sum up one segment of a card: (name, unit) to value."""
    time = part.time - part.time[0]
    if time[-1] < SHORTEST:
        return {}
    speed = _airspeed(part)
    features = {("duration", "s"): float(time[-1])}
    features["airspeed", "kt"] = float(speed.mean())
    early = time < BEGINNING
    features["change of airspeed", "kt/s"] = float(np.polyfit(time[early], speed[early], 1)[0])
    for name in ("pitch", "manifold pressure"):
        values = QUANTITIES[name][1](part)
        if values is not None:
            features[name, QUANTITIES[name][0]] = float(values.mean())
    return features | _turn(part, time)


def _turn(part: FlightLog, time: Seconds) -> dict[tuple[str, str], float]:
    """Bank, turn rate, and bank beyond that of a coordinated turn of this rate."""
    if part.roll is None or part.heading is None or abs(float(np.mean(part.roll))) < QUIET:
        return {}
    rate = float(np.polyfit(time, np.unwrap(part.heading), 1)[0])
    bank = float(np.mean(part.roll))
    ground = float(np.mean(np.hypot(part.velocity_north, part.velocity_east)))
    needed = float(np.arctan(rate * ground / STANDARD_GRAVITY))
    return {
        ("bank", "°"): bank / DEGREE,
        ("turn rate", "°/s"): rate / DEGREE,
        ("bank beyond that of the turn rate", "°"): (bank - needed) / DEGREE,
    }


def _tolerance(
    name: str,
    labels: Sequence[str],
    measured: Parts,
    simulated: Sequence[Parts],
    patched: Sequence[Parts],
) -> Tolerance | None:
    unit, half = QUANTITIES[name][0], SHARE * LIMITS[name]
    shares = [
        [_within(name, half, labels, measured, parts) for parts in simulated],
        [_within(name, half, labels, measured, parts) for parts in patched],
        [_within(name, half, labels, patched[0], parts) for parts in patched[1:]],
    ]
    if any(share is None for group in shares for share in group):
        return None
    before, after, chance = (
        float(np.mean([s for s in group if s is not None])) for group in shares
    )
    return Tolerance(name, unit, half, before, after, chance)


def _within(
    name: str, half: float, labels: Sequence[str], one: Parts, other: Parts
) -> float | None:
    """Share of the common time of all segments in which two logs differ by at most a half width."""
    inside, total = 0, 0
    for label in labels:
        pair = _pair(name, one[label], other[label])
        if pair is None:
            return None
        difference = pair[1] - pair[2]
        difference = (difference + 180.0) % 360.0 - 180.0 if name == "heading" else difference
        inside, total = inside + int(np.sum(np.abs(difference) <= half)), total + len(difference)
    return inside / total


def _pair(name: str, one: FlightLog, other: FlightLog) -> tuple[Seconds, Array, Array] | None:
    """Time, and a quantity of two logs of a segment over their common time, smoothed alike."""
    first, second = QUANTITIES[name][1](one), QUANTITIES[name][1](other)
    if first is None or second is None:
        return None
    since, then = one.time - one.time[0], other.time - other.time[0]
    inside = since <= then[-1]
    return (
        since[inside],
        _smooth(since, first)[inside],
        np.interp(since[inside], then, _smooth(then, second)),
    )


def _smooth(time: Seconds, values: Array) -> Array:
    count = max(1, round(SMOOTHED / float(np.median(np.diff(time))))) if len(time) > 1 else 1
    weights = np.ones(count)
    total: Array = np.convolve(np.ones(len(values)), weights, "same")
    return np.asarray(np.convolve(values, weights, "same")[: len(values)] / total[: len(values)])


def _histories(
    label: str, begin: float, measured: Parts, simulated: Parts, patched: Parts
) -> list[History]:
    """Return measured, simulated and patched quantities over a segment from a time [s] on."""
    parts = [flight[label] for flight in (measured, simulated, patched)]
    histories = []
    for name, (unit, _) in QUANTITIES.items():
        before, after = _pair(name, parts[0], parts[1]), _pair(name, parts[0], parts[2])
        if before is not None and after is not None:
            count = min(len(before[0]), len(after[0]))
            offset = parts[0].time[0] - begin
            sides = (before[1][:count], before[2][:count], after[2][:count])
            if name == "heading":
                sides = (
                    sides[0],
                    *(s + 360.0 * np.round((sides[0][0] - s[0]) / 360.0) for s in sides[1:]),
                )
            histories.append(History(name, unit, before[0][:count] + offset, *sides))
    return histories
