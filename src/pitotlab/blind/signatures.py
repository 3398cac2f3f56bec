"""What each hidden effect does to the residual channels in each setting: by flying it, and flying
without it.

Flights are in still air, without a pilot's drift, noise, rounding or error curve. The difference of
the residuals of two such flights, matched segment by segment, is the signature; its strength is its
length over the noise of null flights, with wind, error curve and sensor biases taken out.
`signatures/<setting>.npz` holds the strengths. In a wind the residuals would swing with the heading by some
meters a second, and two flights of a turn whose instants differ by half a second would differ by
much more than the effect makes.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from time import process_time
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from pitotbench.campaigns.fleet import require_all, run_tasks
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.effects.effect import Effect, SensorEffect
from pitotbench.effects.overlay import Overlay
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.equations import equations_from, inner_products, noise_residuals
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.noise import NoiseModel, learned
from pitotbench.reconciliation.replay import Replay, answer, motion_of, replay_rows
from pitotbench.reconciliation.residuals import Frame, channel_residuals
from pitotbench.reconciliation.track import grid_of, track_of
from pitotbench.records.case import Case, EffectSpec, PressureErrorSpec, Wind
from pitotbench.records.log import FlightLog
from pitotbench.units import Array
from pitotlab.blind.flown import SETTINGS, Setting, flown, has_wind, known_effects, recorded
from pitotlab.blind.outsiders import HIDDEN_EFFECTS
from pitotlab.experiment import OUT

Text = NDArray[np.str_]
PLACE = OUT / "blind" / "signatures"
NULL_SEED = 49_000
NULLS = 3
STEP = 0.2  # s between the states in which the model is asked
GUSTS = ("turbulence_level", "turbulence_scale")
EVENTS = {"at_s": 80.0, "from_s": 60.0}
NO_EFFECTS: Catalog[Effect] = Catalog("effect", {"belly_pod": EFFECTS["belly_pod"]})
ON_DAY = AnalysisSetting(day_known=True)


@dataclass(frozen=True, slots=True)
class SettingSignatures:
    """What the signatures of a setting tell, at typical sizes: `strengths` (e,) over the flight."""

    names: tuple[str, ...]
    time: Array
    strengths: Array
    unit: Array  # strength of each instant alone, (e, n), for parts of a flight


def all_effects() -> dict[str, Effect]:
    """Every effect that has a signature: of the table, the generator's forms, the outsiders."""
    table: dict[str, Effect] = {**EFFECTS, **HIDDEN_EFFECTS}
    after = [n for n, e in table.items() if isinstance(e, SensorEffect) and e.after_noise]
    return {n: e for n, e in table.items() if n not in GUSTS and n not in after}


def typical(effect: Effect) -> dict[str, float]:
    """Typical sizes, an event early in the flight."""
    return {name: EVENTS.get(name, value) for name, value in effect.typical().items()}


def layout_of(log: FlightLog) -> Layout:
    """Lay out a log against the baseline airplane."""
    return lay_out(log, aircraft_model("navajo"), ON_DAY, NO_EFFECTS)


def quiet(setting: Setting) -> Case:
    """The case of a setting without all that is random."""
    return replace(
        setting.flown,
        wind=Wind(0.0, 0.0),
        turbulence="none",
        pilot="none",
        pressure_error=PressureErrorSpec(parameters=(0.0, 0.0, 0.0)),
    )


def noiseless(case: Case, **what: Any) -> FlightLog:
    """Fly and record without noise and rounding."""
    return _unrounded(lambda: recorded(flown(case, **what), **what))


def _unrounded(work: Callable[[], FlightLog]) -> FlightLog:
    with (
        patch("pitotbench.sensing.recorder.add_noise", lambda values, deviation, stream: values),
        patch("pitotbench.sensing.recorder.quantize", lambda values, resolution: values),
    ):
        return work()


def null_noise(setting: Setting) -> NoiseModel:
    """The noise of a setting, learned on null flights of it."""
    layouts = []
    for seed in range(NULL_SEED, NULL_SEED + NULLS):
        case = replace(setting.flown, truth_seed=seed, sensor_seed=seed)
        layouts.append(layout_of(recorded(flown(case))))
    logs = [(noise_residuals(each), each.grid, each.residuals.slack) for each in layouts]
    return learned(layouts[0].residuals.names, logs)


@dataclass(frozen=True, slots=True)
class Residuals:
    """The residual channels of a log alone, (n, c), with the segment of each instant, (n,)."""

    names: tuple[str, ...]
    values: Array
    segments: Text


def residuals_of(log: FlightLog) -> Residuals:
    """The residual channels of a noiseless log, without free parameters and hypotheses."""
    track, model = track_of(log), aircraft_model("navajo")
    assert model is not None
    rows = replay_rows(track, STEP)
    motion = motion_of(track, rows)
    reacted = answer(lambda each: model.react(each, Overlay(), True), motion)
    replay = Replay(rows, motion, reacted, {})
    grid = grid_of(track)
    found = channel_residuals(track, grid, Frame.of(track, grid), replay)
    return Residuals(found.names, found.values, segments_at(log, track.time[grid.rows]))


def without_steady_wind(other: Layout, log: FlightLog, noise: NoiseModel) -> Residuals:
    """The residual channels of a log in a wind, less what its own free parameters take of them.

    A steady wind swings with the heading. Two flights of a card do not turn at the same instants,
    so that the free wind of the one does not take the swing of the other out.
    """
    place = other.grid, other.residuals.slack
    free = noise.whiten(other.free.columns, *place)
    products = inner_products(free, noise.whiten(other.residuals.values, *place))
    sizes = equations_from(products, free.shape[2], other.free.deviations).free_sizes()
    taken = other.free.columns @ sizes
    segments = segments_at(log, other.track.time[other.grid.rows])
    return Residuals(other.residuals.names, other.residuals.values - taken, segments)


def matched(values: Array, segments: Text, wanted: Text) -> Array:
    """Values (n, …) of one flight at the instants of another, (m,), by place in each segment."""
    out = np.zeros((len(wanted), *values.shape[1:]))
    runs = _runs(segments)
    names = [name for name, _ in runs]
    used = 0
    for name, rows in _runs(wanted):
        if name not in names[used:]:
            continue
        here = names.index(name, used)
        used = here + 1
        source = runs[here][1]
        place = (len(source) - 1) * np.linspace(0.0, 1.0, len(rows))
        low = np.minimum(place.astype(np.intp), max(0, len(source) - 2))
        share = (place - low).reshape(-1, *[1] * (values.ndim - 1))
        high = np.minimum(low + 1, len(source) - 1)
        out[rows] = (1.0 - share) * values[source[low]] + share * values[source[high]]
    return out


def _runs(segments: Text) -> list[tuple[str, NDArray[np.intp]]]:
    change = np.flatnonzero(segments[1:] != segments[:-1]) + 1
    edges = [0, *change.tolist(), len(segments)]
    return [(str(segments[a]), np.arange(a, b)) for a, b in pairwise(edges)]


def segments_at(log: FlightLog, time: Array) -> Text:
    """The segment of a log at some times."""
    assert log.segment is not None
    row = np.clip(np.searchsorted(log.time, time), 0, len(log.time) - 1)
    return np.asarray(log.segment)[row]


def measure(letter: str) -> float:
    """Measure a setting and write it; returns the processor seconds it took."""
    begun = process_time()
    setting = SETTINGS[letter]
    noise, case = null_noise(setting), quiet(setting)
    flight = flown(case)
    log = _unrounded(lambda: recorded(flight))
    base = layout_of(log)
    segments = segments_at(log, base.track.time[base.grid.rows])
    still, alone = base.reference.residuals_of(track_of(log)).values, residuals_of(log)
    steady = without_steady_wind(base, log, noise)
    values = {}
    for name, effect in all_effects().items():
        spec = replace(case, effects=(EffectSpec(name, typical(effect)),))
        try:
            if isinstance(effect, SensorEffect):
                with known_effects({}):
                    sensed = _unrounded(partial(recorded, replace(flight, case=spec)))
                values[name] = base.reference.residuals_of(track_of(sensed)).values - still
            else:
                made = noiseless(spec)
                if has_wind([name]):
                    other, before = without_steady_wind(layout_of(made), made, noise), steady
                else:
                    other, before = residuals_of(made), alone
                columns = [other.names.index(name) for name in before.names]
                there = matched(other.values[:, columns], other.segments, segments)
                values[name] = there - before.values
        except Exception as error:  # what cannot be flown in a setting has no signature in it
            print(f"{letter} {name}: {error}", flush=True)
    strengths, unit = _strengths(base, noise, values)
    PLACE.mkdir(parents=True, exist_ok=True)
    np.savez_compressed(
        PLACE / f"{letter}.npz",
        names=np.array(list(values)),
        time=base.track.time[base.grid.rows] - base.track.time[0],
        strengths=strengths,
        unit=unit.astype(np.float32),
    )
    return process_time() - begun


def _strengths(base: Layout, noise: NoiseModel, values: Mapping[str, Array]) -> tuple[Array, Array]:
    """Strength of each signature, (e,), and its square by instant, (e, n), less what is free."""
    place = base.grid, base.residuals.slack
    free = noise.whiten(base.free.columns, *place)
    flat = free.reshape(-1, free.shape[2])
    normal = np.linalg.inv(flat.T @ flat + np.diag(1.0 / base.free.deviations**2))
    strengths, unit = [], []
    for each in values.values():
        white = noise.whiten(each, *place)
        products = inner_products(free, white)
        equations = equations_from(products, free.shape[2], base.free.deviations)
        strengths.append(np.sqrt(max(0.0, equations.inner[-1, -1])))
        rest = white.reshape(-1) - flat @ (normal @ (flat.T @ white.reshape(-1)))
        unit.append(np.sum(rest.reshape(white.shape) ** 2, axis=1))
    return np.array(strengths), np.array(unit)


def read(letter: str) -> SettingSignatures:
    """Read the signatures of a setting."""
    with np.load(PLACE / f"{letter}.npz") as kept:
        names, unit = tuple(kept["names"].tolist()), kept["unit"].astype(np.float64)
        return SettingSignatures(names, kept["time"], kept["strengths"], unit)


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Measure the signature and strength of every effect in every setting."""
    parser.add_argument("--jobs", type=int, default=1)
    letters = [x for x in SETTINGS if not (PLACE / f"{x}.npz").is_file()]
    spent = require_all(run_tasks(measure, letters, parser.parse_args(words).jobs))
    print({letter: round(each, 1) for letter, each in zip(letters, spent, strict=True)})
