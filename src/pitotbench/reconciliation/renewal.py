"""Renew signatures at the sizes and times that a log shows, and lay out logs anew.

A log is also laid out here with effects in the model.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import CHANNELS
from pitotbench.effects import effect_of
from pitotbench.effects.effect import FROM, TO, Effect, SensorEffect
from pitotbench.effects.response import Signals
from pitotbench.reconciliation.clean_track import clean_track
from pitotbench.reconciliation.equations import equations_from, inner_products
from pitotbench.reconciliation.evidence import merit, widest
from pitotbench.reconciliation.free_parameters import (
    VANE_PARAMETERS,
    free_parameters_of,
    with_vane_angles,
)
from pitotbench.reconciliation.layout import Layout, mean_wind_of, without_error_curve
from pitotbench.reconciliation.noise import ORDER, NoiseModel
from pitotbench.reconciliation.replay import motion_of
from pitotbench.reconciliation.residuals import ReferenceState
from pitotbench.reconciliation.signatures import (
    FITTED,
    Signature,
    columns_of,
    happens_once,
    parameter_of,
    reads_gusts,
    residual_change,
    searched_shapes,
)
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.track import Track
from pitotbench.units import Array, Seconds

EVENT_TRIALS = 14  # times over the log at which an event is tried first: one every 10 to 30 s
# times the typical value of a shape that is not a time
TRIAL_FACTORS = np.array([0.6, 0.8, 1.2, 1.4])
HALVINGS = 3  # of the steps around the best shape
# change of a size, as a share, without a new signature
LINEAR_WITHIN = {"sensors": 0.1, "air": 0.1, "aircraft": 0.6}
# of the typical size; signatures of smaller sizes would be differences of rounded numbers
SMALLEST = 0.05

# rounds of taking effects out of a track: what they add depends on the track without them
UNDOINGS = 2

Shapes = dict[str, float]
Entries = Mapping[str, Mapping[str, float]]  # effects with their sizes and shapes


def at_sizes(
    layout: Layout, sizes: Mapping[tuple[str, str], float], shapes: Entries | None = None
) -> Layout:
    """Return the layout with signatures renewed at fitted sizes, keyed by effect and parameter.

    Sizes outside the plausible range are taken at its end. `shapes` holds the shapes by effect,
    where they are not those of the signatures.
    """
    signatures = list(layout.signatures)
    for i, old in enumerate(signatures):
        if (old.effect, old.parameter) in sizes:
            own = (shapes or {}).get(old.effect, old.shapes)
            signatures[i] = _renewed(layout.reference, old, sizes[old.effect, old.parameter], own)
    if all(new is old for new, old in zip(signatures, layout.signatures, strict=True)):
        return layout
    return replace(layout, signatures=tuple(signatures))


def without_sensor_effects(original: Layout, entries: Entries) -> Layout:
    """Return the layout around the log without some effects on the sensors, at fitted sizes.

    Subtract the fitted sensor effects from the channels, fit the error curve again, and run the
    force model along the corrected track. Signatures, free parameters and residuals are those of
    the corrected log. Add the change by the effects to the residuals again, so that the sizes to be
    fitted stay whole sizes. A slope would not do: it does not tell that a propeller meets its stop
    a second later. `original` is the layout before any effect was subtracted, but with those that
    are in the model. Effects that are not on the sensors change nothing.
    """
    corrected = with_corrected_track(original, entries)
    if corrected is original:
        return original
    values = corrected.residuals.values + sensor_change(corrected.reference, entries)
    track = _with_measured_vanes(original, entries).track
    return replace(corrected, track=track, residuals=replace(corrected.residuals, values=values))


def with_corrected_track(original: Layout, entries: Entries) -> Layout:
    """Return the layout of the log from whose channels some effects on the sensors were taken out.

    Effects that are not on the sensors change nothing.
    """
    if not any(
        isinstance(effect_of(name), SensorEffect) and sizes for name, sizes in entries.items()
    ):
        return original
    original = _with_measured_vanes(original, entries)
    old = original.reference
    track, clean, curves = original.track, old.clean, original.curves
    for _ in range(UNDOINGS):
        shift = _shift(clean, entries)
        undone = {name: original.track[name] - moved for name, moved in shift.items()}
        bare = original.track.replaced(undone)
        track, further = without_error_curve(bare, original.measured, original.setting)
        curves = (*original.curves, *further)
        clean = clean_track(track, mean_wind_of(track, original.measured))
    model = old.force_model
    reference = old.moved(
        clean, None if model is None else model.along(motion_of(track, model.replay.rows))
    )
    values = reference.residuals_of(track).values
    free = free_parameters_of(reference, original.setting, original.shapes)
    corrected = replace(
        original,
        track=track,
        reference=reference,
        residuals=replace(original.residuals, values=values),
        free=free.with_columns(original.free.beyond(free.names)),
        signatures=tuple(_from_reference(reference, s) for s in original.signatures),
        curves=curves,
    )
    return corrected.with_angles(original.angles)


def _with_measured_vanes(layout: Layout, entries: Entries) -> Layout:
    """Return a layout with the vanes that some effects change as the log has them.

    They replace those of its track. Its residuals stay those of the track before.
    """
    changed = {
        channel for name in entries if reads_gusts(name) for channel in effect_of(name).changes
    }
    back = {
        name: size for name, size in layout.angles.items() if VANE_PARAMETERS[name][0] in changed
    }
    kept = {name: size for name, size in layout.angles.items() if name not in back}
    return replace(layout, track=with_vane_angles(layout.track, back), angles=kept)


def sensor_change(reference: ReferenceState, entries: Entries) -> Array:
    """Return the change of the residuals by the effects on sensors together, (n, c)."""
    clean = reference.clean
    return reference.change_by(
        clean.replaced({n: clean[n] + moved for n, moved in _shift(clean, entries).items()})
    )


def _shift(clean: Track, entries: Entries) -> dict[str, Array]:
    """What effects on the sensors, one after the other, add to the channels that they change.

    Effects that need a channel which the track lacks do not act.
    """
    signals = Signals(clean.time, clean.channels)
    for name, sizes in entries.items():
        effect = effect_of(name)
        if isinstance(effect, SensorEffect) and all(
            n in signals for n in (*effect.needs, *effect.changes)
        ):
            signals = effect.apply(signals, sizes)
    changed = [name for name in signals if signals[name] is not clean[name]]
    turns = 2.0 * np.pi  # an angle that starts again at a full turn has not moved by one
    return {
        n: np.mod(signals[n] - clean[n] + np.pi, turns) - np.pi
        if CHANNELS[n].wraps
        else signals[n] - clean[n]
        for n in changed
    }


def _from_reference(reference: ReferenceState, old: Signature) -> Signature:
    """The signature from another clean track, which changes effects on the sensors only."""
    effect = FITTED[old.effect]
    if not isinstance(effect, SensorEffect):
        return old
    moved = residual_change(
        effect, reference, effect.complete({**old.shapes, old.parameter: old.size})
    )
    return old if moved is None else replace(old, column=moved / old.size)


def _renewed(
    reference: ReferenceState, old: Signature, size: float, shapes: Mapping[str, float]
) -> Signature:
    effect = FITTED[old.effect]
    parameter = parameter_of(reference, (old.effect, old.parameter))
    least = SMALLEST * abs(parameter.typical)
    size = parameter.within(size)
    size = float(np.copysign(max(abs(size), least), size))
    near = abs(size - old.size) < max(least, LINEAR_WITHIN[effect.acts_on] * abs(old.size))
    if near and shapes == old.shapes:
        return old
    moved = residual_change(effect, reference, effect.complete({**shapes, old.parameter: size}))
    if moved is None or not np.any(moved):
        return (
            old
            if shapes == old.shapes
            else replace(old, column=np.zeros_like(old.column), shapes=dict(shapes))
        )
    return replace(old, size=size, column=moved / size, shapes=dict(shapes))


def placed_in_time(layout: Layout, noise: NoiseModel) -> Layout:
    """Return the layout with each effect that has shapes at those that fit best.

    A shape is a time, a damping and the like.
    """
    signatures, trials = list(layout.signatures), Trials(layout, noise)
    for effect in FITTED.values():
        columns = [i for i, s in enumerate(signatures) if s.effect == effect.name]
        if columns and searched_shapes(effect):
            best = _search(trials, effect, [signatures[i] for i in columns])
            for i, renewed in zip(columns, best, strict=True):
                signatures[i] = renewed
    return replace(layout, signatures=tuple(signatures))


@dataclass(frozen=True, slots=True)
class Trial:
    """An effect at some shapes: its signatures and their merit."""

    shapes: Shapes
    signatures: list[Signature]
    merit: float


def _search(trials: "Trials", effect: Effect, start: Sequence[Signature]) -> list[Signature]:
    """Search coarsely in the first shape, then in halved steps in all.

    A first shape that is a time is tried over the whole log.
    """
    shapes = searched_shapes(effect)
    first = shapes[0]
    best = trials.at(effect, start, {p.name: p.typical for p in shapes})
    steps = {p.name: p.typical for p in shapes}
    ladder = (
        np.linspace(trials.time[0], trials.time[-1], EVENT_TRIALS + 2)[1:-1]
        if first.name.endswith("_s")
        else np.clip(first.typical * TRIAL_FACTORS, first.low, first.high)
    )
    steps[first.name] = float(ladder[1] - ladder[0])
    candidates = [{**best.shapes, first.name: float(t)} for t in ladder]
    for _ in range(HALVINGS + 1):
        for candidate in candidates:
            trial = trials.at(effect, start, candidate)
            best = trial if trial.merit > best.merit else best
        steps = {name: 0.5 * step for name, step in steps.items()}
        candidates = [
            {**best.shapes, p.name: p.within(best.shapes[p.name] + sign * steps[p.name])}
            for p in shapes
            for sign in (-1.0, 1.0)
        ]
    return best.signatures


def _with_shapes(
    reference: ReferenceState, effect: Effect, old: Signature, shapes: Shapes
) -> Signature:
    moved = residual_change(effect, reference, effect.complete({**shapes, old.parameter: old.size}))
    column = np.zeros_like(old.column) if moved is None else moved / old.size
    return replace(old, column=column, shapes=dict(shapes))


class Trials:
    """The merit of signatures that are not in the layout, which is whitened and fitted once."""

    def __init__(self, layout: Layout, noise: NoiseModel) -> None:
        self._layout = layout
        self._whiten = noise.whitener(layout.grid, layout.residuals.slack)
        residual = self._whiten(layout.residuals.values)
        self._known = np.concatenate(
            [self._whiten(layout.free.columns), residual[:, :, None]], axis=2
        )
        self._products = inner_products(self._known, residual)[0, :-1, :-1]

    @property
    def time(self) -> Seconds:
        """Time of the instants from the start of the log [s], (n,)."""
        return np.asarray(
            self._layout.track.time[self._layout.grid.rows] - self._layout.track.time[0]
        )

    def at(self, effect: Effect, start: Sequence[Signature], shapes: Shapes) -> Trial:
        """Return an effect at some shapes."""
        signatures = [_with_shapes(self._layout.reference, effect, s, shapes) for s in start]
        return Trial(shapes, signatures, self._merit(effect, signatures))

    def _merit(self, effect: Effect, signatures: Sequence[Signature]) -> float:
        """The merit, −∞ where a size would be far beyond its range.

        Of a band of airspeeds that was not flown the rounding is left, and chance would decide.
        """
        free, k = self._layout.free, len(signatures)
        new = self._whiten(np.stack([s.column for s in signatures], axis=2)).reshape(-1, k)
        across = self._known.reshape(len(new), -1).T @ new
        # of the new columns, which stand between the free parameters and the residual
        first = len(free.names)
        order = [*range(first), *range(first + 1, first + 1 + k), first]
        products = np.block([[self._products, across], [across.T, new.T @ new]])[
            np.ix_(order, order)
        ]
        fit = equations_from(products[None], first, free.deviations).fit(range(k))
        reference = self._layout.reference
        own = [parameter_of(reference, (effect.name, s.parameter)) for s in signatures]
        ranges = [IMPOSSIBLE * max(-p.low, p.high) for p in own]
        return merit(fit) if np.all(np.abs(fit.sizes) < ranges) else -np.inf


# times the range of a size: a size beyond its range is told, one beyond this is none
IMPOSSIBLE = 10.0
TIME_SPACING = 10.0  # s between the times that are tried; the whitening looks back by 6 s
MOST_TIMES = 30  # of them: pairs grow with the square
PROMISING = 3  # effects that become hypotheses
# fall of the SS; the wander of null flights gives the best of all times up to 60
LEAST_GAIN = 100.0

Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class _Stretch:
    """The best part of the flight for one form of an effect, and the fall of the sum of squares."""

    form: Effect
    shapes: Shapes
    gain: float


def with_parts_of_flight(layout: Layout, noise: NoiseModel) -> Layout:
    """Return the layout with the signatures of promising effects that act for a part of the flight.

    Every effect is fitted from each of some times on and between each two of them. Only an effect
    that so explains more than every effect does over the whole flight becomes a hypothesis; its
    times are then refined.
    """
    timed = layout.signatures and not layout.setting.maneuvers
    found = _promising(layout, noise) if timed else []
    if not found:
        return layout
    trials, added = Trials(layout, noise), list[Signature]()
    for each in found:
        start = [
            replace(s, effect=each.form.name)
            for s in layout.signatures
            if s.effect == each.form.part_of
        ]
        added += _refined(trials, each, start)
    return replace(layout, signatures=(*layout.signatures, *added))


def _refined(trials: Trials, found: _Stretch, start: Sequence[Signature]) -> list[Signature]:
    """The signatures of a form at its best times, in halved steps around those found."""
    best, step = trials.at(found.form, start, found.shapes), 0.5 * TIME_SPACING
    for _ in range(HALVINGS):
        for name in found.shapes:
            for moved in (best.shapes[name] - step, best.shapes[name] + step):
                shapes = {**best.shapes, name: max(0.0, moved)}
                if shapes.get(TO.name, np.inf) > shapes[FROM.name] + step:
                    trial = trials.at(found.form, start, shapes)
                    best = trial if trial.merit > best.merit else best
        step *= 0.5
    return best.signatures


def _promising(layout: Layout, noise: NoiseModel) -> list[_Stretch]:
    """The best forms for a part of the flight, of the effects that explain most."""
    scan = _Scan(layout, noise)
    columns = columns_of(layout.signatures)
    whole = {name: scan.whole(own) for name, own in columns.items()}
    least = max(
        LEAST_GAIN,
        max(
            gain - THRESHOLDS.free_size_penalty * (len(columns[n]) - 1) for n, gain in whole.items()
        ),
    )
    found = [
        each
        for name in columns
        if _may_be_timed(name)
        for each in scan.stretches(name, columns[name], whole[name])
    ]
    best = sorted((s for s in found if s.gain > least), key=lambda s: -s.gain)
    effects = list(dict.fromkeys(s.form.part_of for s in best))[:PROMISING]
    return [s for s in best if s.form.part_of in effects]


def _may_be_timed(name: str) -> bool:
    """Return whether an effect is looked for in parts of the flight: a plain form without times."""
    effect = FITTED[name]
    plain = not (effect.variant_of or effect.one_model_with or effect.for_whole_flight)
    return plain and not happens_once(name) and f"{name}_for_a_time" in FITTED


class _Scan:
    """Inner products of signatures from some times on, free parameters eliminated.

    A signature that begins at an instant is whitened like any other: from `ORDER` instants later on
    it is that of the whole flight.
    """

    def __init__(self, layout: Layout, noise: NoiseModel) -> None:
        grid, slack, free = layout.grid, layout.residuals.slack, layout.free
        values = np.stack([s.column for s in layout.signatures], axis=2)
        whiten = noise.whitener(grid, slack)
        known = np.concatenate(
            [whiten(free.columns), whiten(layout.residuals.values)[:, :, None]], axis=2
        )
        columns = whiten(values)
        time = layout.track.time[grid.rows] - layout.track.time[0]
        # with a fix a second the whitening looks back by 12 s
        spacing = max(TIME_SPACING, (ORDER + 2) * grid.step)
        count = int(np.clip((time[-1] - time[0]) / spacing, 2, MOST_TIMES))
        starts = np.searchsorted(time, time[0] + (time[-1] - time[0]) * np.arange(1, count) / count)
        self.starts: Indices = starts[np.diff(starts, append=len(time)) > ORDER]
        self.times: Seconds = time[self.starts]
        every = np.concatenate([known, columns], axis=2)
        k, s = known.shape[2] - 1, columns.shape[2]
        across, own = (
            np.zeros((len(self.starts) + 1, s, k + 1 + s)),
            np.zeros((len(self.starts) + 1, s, s)),
        )
        later, end = np.zeros((s, k + 1 + s)), len(time)
        for i in range(len(self.starts) - 1, -1, -1):
            begin = int(self.starts[i])
            near = slice(max(0, begin - ORDER - 1), min(len(time), begin + ORDER))
            part = values[near].copy()
            part[: begin - near.start] = 0.0
            there = replace(grid, rows=grid.rows[near], first=grid.first[near], _kept=[])
            first = noise.whiten(part, there, slack[near])[begin - near.start :]
            later = later + _product(columns[near.stop : end], every[near.stop : end])
            end = near.stop
            across[i + 1] = later + _product(first, every[begin : near.stop])
            own[i + 1] = later[:, k + 1 :] + _product(first, first)
        across[0] = _product(columns, every)
        own[0] = across[0][:, k + 1 :]
        free_products = _product(known, known)
        normal = free_products[:k, :k] + np.diag(free.deviations**-2.0)
        scale = 1.0 / np.sqrt(np.diag(normal))
        inverse = np.linalg.pinv(
            normal * np.outer(scale, scale), rcond=1e-12, hermitian=True
        ) * np.outer(scale, scale)
        self._with_free, self._with_residual = (
            across[:, :, :k],
            across[:, :, k] - across[:, :, :k] @ (inverse @ free_products[:k, k]),
        )
        self._with_whole, self._own, self._inverse = across[:, :, k + 1 :], own, inverse
        self._widest = np.array([widest(each) for each in layout.parameters])

    def whole(self, columns: Sequence[int]) -> float:
        """The fall of the sum of squares by an effect over the whole flight."""
        return float(self._gains(columns, np.zeros(1, dtype=np.intp), None)[0])

    def stretches(self, name: str, columns: Sequence[int], whole: float) -> Iterator[_Stretch]:
        """Yield an effect's best form from a time on, and between two times, where worth it.

        What the flight shows without the effect has to contradict it as another flight would have
        to.
        """
        if not len(self.starts):
            return
        least = whole + THRESHOLDS.contradicted_from**2
        starts = np.arange(1, len(self.starts) + 1)
        on = self._gains(columns, starts, None)
        best = int(np.argmax(on))
        if on[best] > least:
            yield _Stretch(
                FITTED[f"{name}_from_a_time"], {FROM.name: float(self.times[best])}, float(on[best])
            )
        begins, ends = np.triu_indices(len(self.starts) + 1, 1)
        between = self._gains(columns, begins, ends)
        last = int(np.argmax(between))
        if between[last] > max(least, on[best] + THRESHOLDS.free_size_penalty):
            times = np.concatenate([[0.0], self.times])
            shapes = {FROM.name: float(times[begins[last]]), TO.name: float(times[ends[last]])}
            yield _Stretch(FITTED[f"{name}_for_a_time"], shapes, float(between[last]))

    def _gains(self, columns: Sequence[int], begins: Indices, ends: Indices | None) -> Array:
        """The falls of the sum of squares by columns from some starts on, or up to ends, (w,)."""
        own = list(columns)
        # The columns first: a few of some hundred, where pairs of times are many.
        with_free, with_residual = self._with_free[:, own], self._with_residual[:, own]
        inner_own = self._own[:, own][:, :, own]
        free, right, inner = with_free[begins], with_residual[begins], inner_own[begins]
        if ends is not None:
            free, right = free - with_free[ends], right - with_residual[ends]
            shared = self._with_whole[:, own][:, :, own][ends]
            inner = inner + inner_own[ends] - shared - shared.transpose(0, 2, 1)
        reproduced = (free.reshape(-1, free.shape[2]) @ self._inverse).reshape(free.shape)
        normal = inner - reproduced @ free.transpose(0, 2, 1)
        normal = normal + np.diag(self._widest[own] ** -2.0)
        return np.asarray(
            np.sum(right * np.linalg.solve(normal, right[:, :, None])[:, :, 0], axis=1)
        )


def _product(one: Array, other: Array) -> Array:
    """Inner products of columns, (n, c, i) and (n, c, j) to (i, j), over instants and channels."""
    return np.asarray(one.reshape(-1, one.shape[2]).T @ other.reshape(-1, other.shape[2]))
