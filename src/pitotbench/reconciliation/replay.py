"""Move the aircraft model along a track: its answer, and how that changes with the state."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.effects import EFFECTS, additional_terms
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.overlay import ADDING, Baseline, Overlay, evaluate, properties_in
from pitotbench.reconciliation.flight_path import flow_angles
from pitotbench.reconciliation.track import Track, mach_number, outside_temperature
from pitotbench.records.motion import CONTROLS, STATES, Motion, Reaction, UnitForces
from pitotbench.units import Array

React = Callable[[Motion], Reaction]

# The states that a wrong sensor shifts, with the step for the difference quotient: small compared
# with a maneuver.
RATES = ("roll_rate", "pitch_rate", "yaw_rate")
VARIED: Mapping[str, float] = {
    "temperature_offset": 2.0,
    "mach": 0.002,
    "static_pressure": 300.0,
    "angle_of_attack": 0.005,
    "sideslip": 0.005,
    **dict.fromkeys(RATES, 0.02),
}
FINE = 0.1  # s between states, for the answer
REACTION_NAMES = tuple(Reaction.__dataclass_fields__)


@dataclass(frozen=True, slots=True)
class Replay:
    """The answer of a model along a track.

    `rows` of the track, (m,), ten a second; `values` (m, 12) in the order of the fields of a
    Reaction; `slopes` are the changes of the values by one unit of each state in `VARIED`, (m, 12)
    each. `split` is the left less the right throttle with the levers together.
    """

    rows: NDArray[np.intp]
    motion: Motion
    values: Array
    slopes: Mapping[str, Array]
    split: float = 0.0

    def shifted(self, track: Track) -> Array:
        """Return the answer in another track's states in the same rows, to first order, (m, 12)."""
        values, states = self.values.copy(), varied_states(track, self.rows)
        for name, slope in self.slopes.items():
            moved = np.broadcast_to(states[name] - getattr(self.motion, name), len(values))
            values += slope * moved[:, None]
        return values


def lacking(track: Track, controls: Iterable[str]) -> tuple[str, ...]:
    """Return the channels that the force meter needs and a track lacks.

    `controls` are those of the aircraft.
    """
    return tuple(name for name in (*STATES, *controls) if name not in track)


def replay_rows(track: Track, step: float) -> NDArray[np.intp]:
    """Return the rows at which the model is evaluated: every `step` [s], and ends of stretches."""
    every = max(1, round(step / track.row_period))
    parts = [
        np.append(np.arange(a, b - 1, every), b - 1)
        for a, b in zip(track.start[:-1], track.start[1:], strict=True)
    ]
    return np.concatenate(parts)


def coarse_rows(track: Track) -> NDArray[np.intp]:
    """Return the rows at which the changes of the model's answer are measured."""
    return replay_rows(track, track.coarse)


def motion_of(track: Track, rows: NDArray[np.intp]) -> Motion:
    """Return the measured motion at rows of a track.

    States are means over a step around each row. Throttles are means over the step that follows, in
    which the engines answer to them. Controls that the track lacks are NaN: the aircraft does not
    have them.
    """
    around, after = _windows(track, rows)
    states = varied_states(track, rows)
    for name in Motion.__dataclass_fields__:
        if name in track and name not in states:
            states[name] = (after if name.startswith("throttle") else around)(track[name])
        elif name in CONTROLS:
            states[name] = np.full(len(rows), np.nan)
    return Motion(time=track.time[rows], **states)


def varied_states(track: Track, rows: NDArray[np.intp]) -> dict[str, Any]:
    """Return the states of `VARIED` at rows of a track, as `motion_of` does."""
    around, _ = _windows(track, rows)
    mach = mach_number(track)
    standard = air.standard_temperature(air.pressure_altitude(track["static_pressure"]))
    # In warmer air this pressure lies higher, H_p (1 + ΔT/T₀), where a standard day with the offset
    # ΔT is cooler.
    warm = (outside_temperature(track, mach) - standard) * air.SEA_LEVEL_TEMPERATURE / standard
    alpha, beta = flow_angles(track)
    return {
        "static_pressure": around(track["static_pressure"]),
        "mach": around(mach),
        "angle_of_attack": around(alpha),
        "sideslip": around(beta),
        "temperature_offset": float(np.mean(warm)),
        **{name: around(track[name]) for name in RATES if name in track},
    }


def _windows(
    track: Track, rows: NDArray[np.intp]
) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """Means over a step around each row, and over the step that follows it."""
    every = int(np.median(np.diff(rows)))
    around, after = (_means(rows, every, len(track.time), back) for back in (0.5, 0.0))
    return around, after


def _means(
    rows: NDArray[np.intp], every: int, length: int, back: float
) -> Callable[[Array], Array]:
    """Return trapezoidal means over `every` row steps, a share `back` of them before each row."""
    first = -round(back * every)
    weights = np.ones(every + 1)
    weights[[0, -1]] = 0.5
    if every % 2 and back:  # centered between rows: half a weight more at either end
        weights = np.ones(every)
        first = -(every // 2)
    around = np.clip(rows[:, None] + first + np.arange(len(weights)), 0, length - 1)
    return lambda values: np.asarray(values[around] @ weights / weights.sum())


def replay_motion(track: Track, react: React, split: float = 0.0) -> Replay:
    """Move the model along a track: once for its answer, and once for each slope in coarse steps.

    `split` is that of its throttles.
    """
    rows = replay_rows(track, FINE)
    motion = motion_of(track, rows)
    return Replay(rows, motion, answer(react, motion), _slopes(track, rows, react), split)


def _slopes(track: Track, rows: NDArray[np.intp], react: React) -> dict[str, Array]:
    coarse = coarse_rows(track)
    motion = motion_of(track, coarse)
    before = answer(react, motion)
    slopes = {}
    for name, step in VARIED.items():
        varied = replace(motion, **{name: getattr(motion, name) + step})
        slopes[name] = spread(rows, coarse, (answer(react, varied) - before) / step)
    return slopes


def spread(rows: NDArray[np.intp], coarse: NDArray[np.intp], values: Array) -> Array:
    """Interpolate values at coarse rows, (k, 12), linearly to all rows, (m, 12)."""
    return np.stack([np.interp(rows, coarse, column) for column in values.T], axis=1)


def answer(react: React, motion: Motion) -> Array:
    """Return the answer of a model as one array, (m, 12)."""
    reaction = react(motion)
    return np.stack([getattr(reaction, name) for name in REACTION_NAMES], axis=1)


def adds_forces(overlay: Overlay) -> bool:
    """Whether an overlay holds nothing but functions of force that add to those of the aircraft."""
    only = not (
        overlay.settings or overlay.masses or overlay.forces or overlay.winds or overlay.filters
    )
    return (
        only
        and bool(overlay.functions)
        and all(function.axis in ADDING for function in overlay.functions)
    )


def properties_of_forces(baseline: Baseline) -> frozenset[str]:
    """Return the paths of the aircraft's properties that the functions of all effects read."""
    acting = [e for e in EFFECTS.values() if isinstance(e, AircraftEffect)]
    acting += additional_terms(baseline)
    overlays = [overlay for effect in acting for overlay in effect.fitting(baseline)]
    read = (
        properties_in(function.value) - dict(overlay.sizes).keys()
        for overlay in overlays
        for function in overlay.functions
        if function.axis in ADDING
    )
    return frozenset().union(*read)


def added_forces(overlay: Overlay, units: UnitForces) -> Array:
    """Return the change of the reaction by an overlay of functions, (m, 12).

    The change comes from unit forces, so that no force meter is needed. The engines do not answer
    to it.
    """
    properties: dict[str, Array | float] = {**units.properties, **dict(overlay.sizes)}
    changes = [
        units.changes[function.axis] * np.reshape(evaluate(function.value, properties), (-1, 1))
        for function in overlay.functions
    ]
    change = np.sum(changes, axis=0)
    engines = np.zeros((len(change), len(REACTION_NAMES) - change.shape[1]))
    return np.concatenate([change, engines], axis=1)
