"""Lay out maneuvers, in which an airplane answers to its controls, and learn their floor."""

from collections.abc import Sequence
from dataclasses import fields
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import detrend

from pitotbench import air
from pitotbench.catalog import Catalog
from pitotbench.effects.effect import AircraftEffect, AirEffect, Effect
from pitotbench.effects.overlay import Overlay
from pitotbench.effects.own_terms import SURFACES
from pitotbench.estimation.information import Information
from pitotbench.reconciliation.cells import cells
from pitotbench.reconciliation.equations import (
    NormalEquations,
    folds_of,
    whitened_equations,
)
from pitotbench.reconciliation.evidence import widest
from pitotbench.reconciliation.free_parameters import AnalysisSetting, FreeParameters
from pitotbench.reconciliation.layout import Layout, hypotheses, of_patch
from pitotbench.reconciliation.noise import UNUSABLE, NoiseModel, learned
from pitotbench.reconciliation.null_distribution import NullDistribution, ScoreScale, size_label
from pitotbench.reconciliation.recording_checks import CheckedLog
from pitotbench.reconciliation.replay import Replay, answer, motion_of, properties_of_forces
from pitotbench.reconciliation.residuals import (
    MOMENTS,
    AircraftModel,
    ForceModel,
    Frame,
    ReferenceState,
    channel_residuals,
)
from pitotbench.reconciliation.signatures import FITTED, Signature, signatures_of
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.track import FORCES, Grid, Track
from pitotbench.records.maneuver import CHANNELS, Maneuver
from pitotbench.records.motion import Motion
from pitotbench.units import DEGREE, Array

INSTANT = 0.1  # s
PAUSE = 60.0  # s between two maneuvers, which may be of different days
CONSTANT = {**dict.fromkeys(FORCES, 3.0), **dict.fromkeys(MOMENTS, 0.5)}  # m/s², rad/s²
SHOWN_BY = dict(
    zip((*FORCES, *MOMENTS), ("drag", "side force", "lift", *CHANNELS[3:]), strict=True)
)
# Deviation of a variable, about a straight line, from which a maneuver says something of a term in
# it: twice the usual error of its sensor. Below it the errors of the sensor, which move no force,
# make every term seem too small.
LEAST_MOVE = {
    **dict.fromkeys(("alpha", "alpha_rate", "sideslip"), 0.2 * DEGREE),
    **dict.fromkeys(("p", "q", "r"), 0.5 * DEGREE),
    **dict.fromkeys(SURFACES, 0.1 * DEGREE),
}
CHANNEL = {  # of a track, by the variable of a term
    **dict(zip("pqr", ("roll_rate", "pitch_rate", "yaw_rate"), strict=True)),
    **dict.fromkeys(("alpha", "alpha_rate"), "angle_of_attack"),
}
# variables whose errors stand in columns
VARYING = (*dict.fromkeys(CHANNEL.values()), "sideslip", *SURFACES)
PARTS = ("drag", "lift, stability and damping", "controls and trim")  # that the air alone shows


def lay_out_maneuvers(
    maneuvers: Sequence[Maneuver],
    aircraft: AircraftModel,
    setting: AnalysisSetting,
    effects: Catalog[Effect] | None = None,
) -> Layout:
    """Lay out maneuvers of one airplane one after the other, as one log.

    A maneuver is laid out as a log is, in instants five times as close, for a short period takes a
    second or two. Its channels are forces and moments, its model the air alone (equation error:
    Klein and Morelli 2006, Aircraft System Identification, ch. 5). What is free in each maneuver is
    a constant of each channel: trim, loading and the zeros of the accelerometers. Where thrust was
    not measured, the drag is left out. Nothing is known of flights without a gap, so that the floor
    is what the model with all its terms leaves on parts of the maneuvers left out.

    `aircraft` answers with the forces of the air alone. `effects` are the hypotheses, by default
    all that the air shows. Raises ValueError without a maneuver.
    """
    parts = [_at_instants(each) for each in maneuvers]
    counts = [len(each["time"]) for each in parts]
    start = (0, *np.cumsum(counts).tolist())
    names = [name for name in parts[0] if name != "time"]
    channels = {name: np.concatenate([each[name] for each in parts]) for name in names}
    begins = np.cumsum([0.0, *(float(each["time"][-1]) + PAUSE for each in parts[:-1])])
    time = np.concatenate([each["time"] + t for each, t in zip(parts, begins, strict=True)])
    rows = np.arange(len(time))
    track = Track(time, channels, start, rows, INSTANT, INSTANT, coarse=INSTANT)
    grid = Grid(rows, np.isin(rows, start), INSTANT, np.ones(1), True)
    motion = motion_of(track, rows)
    values = answer(lambda states: aircraft.react(states, Overlay(), False), motion)
    units = aircraft.unit_forces(motion, properties_of_forces(aircraft.baseline))
    model = ForceModel(Replay(rows, motion, values, {}), aircraft, motion, units)
    frame = Frame.of(track, grid)
    base = channel_residuals(track, grid, frame, model.replay)
    number = np.repeat(np.arange(len(parts)), counts)
    for i, name in enumerate(base.names):
        lacks = np.array([not _shows(each, name) for each in maneuvers])
        base.slack[lacks[number], i] = UNUSABLE
    reference = ReferenceState(track, grid, frame, base, model)
    places, shapes = cells(track, grid, base)
    signatures = _moved(
        reference, signatures_of(reference, effects or _of_the_air(aircraft, setting))
    )
    free = _free(maneuvers, number, base.names)
    return Layout(
        CheckedLog((), (), np.ones(len(rows), dtype=bool)),
        track,
        np.ones(len(rows), dtype=bool),
        reference,
        base,
        free.with_columns(of_patch(aircraft, signatures, shapes)),
        signatures,
        places,
        shapes,
        setting,
    )


def _of_the_air(aircraft: AircraftModel, setting: AnalysisSetting) -> Catalog[Effect]:
    every = hypotheses(aircraft, setting)
    return Catalog(
        "effect",
        {n: e for n, e in every.items() if e.part in PARTS and not isinstance(e, AirEffect)},
    )


def _moved(reference: ReferenceState, signatures: Sequence[Signature]) -> tuple[Signature, ...]:
    """The signatures of the effects whose terms some maneuver moves; all of those without terms."""
    track, model = reference.clean, reference.force_model
    assert model is not None
    baseline = model.aircraft.baseline
    variables = {f.name: f.variable for f in baseline.functions}

    def moves(variable: str) -> bool:
        values = track.channels.get(CHANNEL.get(variable, variable))
        if values is None or variable not in LEAST_MOVE:
            return True
        rows = (slice(*each) for each in pairwise(track.start))
        return any(np.std(detrend(values[each])) > LEAST_MOVE[variable] for each in rows)

    def shown(each: Signature) -> bool:
        effect = FITTED[each.effect]
        assert isinstance(effect, AircraftEffect)
        changed = effect.overlay({each.parameter: each.size}, baseline).functions_changed()
        own = {variables[name] for name in changed if name in variables}
        return not own or any(moves(variable) for variable in own)

    return tuple(each for each in signatures if shown(each))


def _at_instants(each: Maneuver) -> dict[str, Array]:
    """The channels of a maneuver as means about each instant, and their time from its begin [s]."""
    motion = each.motion
    every = max(1, round(INSTANT / float(np.median(np.diff(motion.time)))))
    count = len(motion.time) // every

    def mean(values: Array) -> Array:
        return np.asarray(values[: count * every].reshape(count, every).mean(axis=1))

    force = each.specific_force
    thrust = np.zeros(len(motion.time)) if each.thrust is None else each.thrust
    standard = air.standard_temperature(air.pressure_altitude(motion.static_pressure))
    warm = 1.0 + motion.temperature_offset / air.SEA_LEVEL_TEMPERATURE
    known: dict[str, Array] = {f.name: getattr(motion, f.name) for f in fields(Motion)}
    del known["temperature_offset"], known["mach"], known["time"]
    impact = air.impact_pressure_from_mach(motion.mach, motion.static_pressure)
    known |= {
        "impact_pressure": np.asarray(impact, dtype=np.float64),
        "air_temperature": standard * warm,
        "specific_force_x": force[:, 0] - thrust / motion.mass,
        "specific_force_y": force[:, 1],
        "specific_force_z": force[:, 2],
        **dict(zip(MOMENTS, each.angular_acceleration.T, strict=True)),
    }
    time = np.asarray(INSTANT * np.arange(count), dtype=np.float64)
    return {"time": time, **{n: mean(v) for n, v in known.items()}}


def _shows(each: Maneuver, name: str) -> bool:
    """Whether a maneuver shows a channel."""
    return SHOWN_BY[name] in each.channels and (name != FORCES[0] or each.thrust is not None)


def _free(
    maneuvers: Sequence[Maneuver], number: NDArray[np.intp], names: Sequence[str]
) -> FreeParameters:
    """The constants of each channel in each maneuver."""
    columns = np.zeros((len(number), len(names), len(maneuvers), len(names)))
    for k in range(len(maneuvers)):
        columns[number == k, :, k] = np.eye(len(names))
    return FreeParameters(
        tuple(f"{name} of {each.name}" for each in maneuvers for name in names),
        columns.reshape(len(number), len(names), -1),
        np.tile([CONSTANT[name] for name in names], len(maneuvers)),
    )


ROUNDS = 3  # of fit and floor in turn
TINY = 1e-12  # of a deviation, so that it can be divided by


def floor_left_out(layout: Layout, maneuvers: Sequence[Maneuver]) -> NullDistribution:
    """Return the floor of maneuvers: the noise that all terms leave, and what errors can seem.

    Both are of the parts left out; the errors are those of the measured variables. The parts are
    fitted as if the noise were white, so that no slow noise takes over what a constant and a term
    share.
    """
    names, grid, slack = layout.residuals.names, layout.grid, layout.residuals.slack
    left = np.where(layout.used, layout.residuals.values, 0.0)
    for _ in range(ROUNDS):
        level = np.maximum(np.std(left, axis=0), TINY)
        white = NoiseModel(names, np.zeros((len(names), 1)), level, np.eye(len(names)))
        left = np.where(layout.used, _left_out(layout, white), 0.0)
    limit = float(np.sqrt(2.0 * THRESHOLDS.gap_of_maneuvers))
    noise = learned(names, [(left, grid, slack)])
    scores = ScoreScale({}, {}, {}, {}, left_over=_attenuated(layout, noise, white, maneuvers))
    return NullDistribution(noise, scores, limit, limit, 0)


def _attenuated(
    layout: Layout, noise: NoiseModel, white: NoiseModel, maneuvers: Sequence[Maneuver]
) -> dict[str, float]:
    """Return by how much errors in the measured variables can move each size, as a score.

    Such errors move no force, so they pull every measured coefficient toward zero, and its change
    toward -1 (Klein and Morelli 2006, ch. 5.1.5; Fuller 1987, Measurement Error Models, eq. 1.2.2).
    """
    track, found = layout.track, list[Array]()
    counted = [*zip(maneuvers, np.diff(track.start).tolist(), strict=True)]
    for name in VARYING:
        moved = np.concatenate([detrend(track[name][slice(*e)]) for e in pairwise(track.start)])
        slopes = [moved @ np.where(layout.used, s.column, 0.0) for s in layout.signatures]
        slope = np.stack(slopes) / max(float(moved @ moved), TINY) / white.deviations
        errors = [n * each.noise.get(name, 0.0) ** 2 for each, n in counted]
        found.append(slope * np.sqrt(sum(errors)))
    products = np.sum([each @ each.T for each in found], axis=0)
    count = len(layout.signatures)
    own = np.diag(whitened_equations(layout, white, with_cells=False).inner)[:count]
    off = products.sum(axis=1) / np.maximum(own, TINY)
    power = np.diag(whitened_equations(layout, noise, with_cells=False).inner)[:count]
    return {
        size_label(s.effect, s.parameter): float(np.sqrt(1.0 + o**2 * p))
        for s, o, p in zip(layout.signatures, off.tolist(), power.tolist(), strict=True)
    }


def _left_out(layout: Layout, noise: NoiseModel) -> Array:
    """Return what free parameters and terms leave in folds that they were not fitted to, (n, c)."""
    equations = whitened_equations(layout, noise, with_cells=False)
    every = np.stack([s.column for s in layout.signatures], axis=2)
    columns = np.concatenate([layout.free.columns, every], axis=2)
    wide = np.array([widest(p) for p in layout.parameters])
    fold, left = folds_of(layout), layout.residuals.values.copy()
    for n, sizes in zip(np.unique(fold), _sizes_left_out(equations, wide), strict=True):
        left[fold == n] -= columns[fold == n] @ sizes
    return left


def _sizes_left_out(equations: NormalEquations, deviations: Array) -> list[Array]:
    """Sizes of the free parameters and of all columns, fitted without each fold."""
    wide = np.concatenate([equations.prior**-0.5, deviations])
    total = equations.products.sum(axis=0)
    others = (total - here for here in equations.products)
    return [Information(each).posterior(range(len(wide)), wide).mean for each in others]
