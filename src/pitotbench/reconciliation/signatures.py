"""Turn every effect of the table into a hypothesis with its signature, a change of residuals."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import singledispatch

import numpy as np

from pitotbench import air
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS, FORMS, effect_of
from pitotbench.effects.effect import (
    FROM,
    NOWHERE,
    TO,
    AircraftEffect,
    AirEffect,
    Effect,
    Parameter,
    SensorEffect,
    share_of_size,
)
from pitotbench.effects.overlay import Overlay
from pitotbench.effects.own_terms import term_named
from pitotbench.effects.response import Signals
from pitotbench.reconciliation.flight_path import VANES, is_without_vanes
from pitotbench.reconciliation.free_parameters import residuals_of_wind
from pitotbench.reconciliation.replay import (
    added_forces,
    adds_forces,
    coarse_rows,
    motion_of,
    spread,
)
from pitotbench.reconciliation.residuals import ReferenceState, change_by_answer
from pitotbench.reconciliation.track import Track, mach_number
from pitotbench.units import Array

OF_THE_AIR = ("fcs/flap", "fcs/gear", "gear/")  # settings of these paths do not change an engine
THROTTLES = frozenset(("throttle_left", "throttle_right"))
THROTTLE_BIAS = {"ap/throttle-bias-left-norm": 1.0, "ap/throttle-bias-right-norm": -1.0}
Key = tuple[str, str]  # a size: the effect and its parameter


@dataclass(frozen=True, slots=True)
class Signature:
    """The change of the residuals by one unit of a parameter, `column` (n, c).

    The residuals with the effect less those without it, computed by the effect's code itself. An
    effect on the sensors acts on the clean track, an effect in the air adds its wind, and an effect
    on the aircraft changes the reaction of the force meter.

    The change is that by `size` units, divided by `size`, because effects are not quite linear.
    `shapes` holds the shapes of the effect that are not typical.
    """

    effect: str
    parameter: str
    size: float
    column: Array
    shapes: Mapping[str, float] = field(default_factory=dict)


def parameter_of(reference: ReferenceState, key: Key) -> Parameter:
    """Return the parameter of a size, for the airplane of the log."""
    parameter, model = effect_of(key[0]).parameter(key[1]), reference.force_model
    return parameter if model is None else parameter.of_airplane(model.aircraft.baseline)


def times_of(signature: Signature) -> tuple[tuple[str, float], ...]:
    """Return the fitted begin and end [s], by name, of an effect for a part of the flight.

    Empty for any other effect.
    """
    return tuple(
        (p.name, signature.shapes[p.name])
        for p in (FROM, TO)
        if FORMS[signature.effect].part_of and p.name in signature.shapes
    )


def signatures_of(reference: ReferenceState, effects: Catalog[Effect]) -> tuple[Signature, ...]:
    """Return a signature for each size parameter of each effect that this log can show."""
    return tuple(s for effect in effects.values() for s in _of_effect(reference, effect))


def columns_of(signatures: Sequence[Signature]) -> Mapping[str, tuple[int, ...]]:
    """Return the columns of the normal equations that belong to each effect."""
    columns: dict[str, tuple[int, ...]] = {}
    for index, signature in enumerate(signatures):
        columns[signature.effect] = (*columns.get(signature.effect, ()), index)
    return columns


def _of_effect(reference: ReferenceState, effect: Effect) -> Iterator[Signature]:
    for parameter in effect.parameters:
        if not parameter.shape:
            typical = parameter_of(reference, (effect.name, parameter.name)).typical
            signature = signature_of(reference, effect, parameter.name, typical)
            if signature is not None:
                yield signature


def signature_of(
    reference: ReferenceState, effect: Effect, parameter: str, size: float
) -> Signature | None:
    """Return the signature of one parameter at a size, other sizes zero and shapes typical.

    None where this log cannot show it: a channel that it changes is missing, vanes that it takes
    are, or no residual changes.
    """
    if effect.by_vanes and is_without_vanes(reference.clean):  # the flow is that of the path
        return None
    moved = residual_change(effect, reference, effect.complete({parameter: size}))
    if moved is None or not np.any(np.abs(moved) > 0.0):
        return None
    return Signature(effect.name, parameter, size, moved / size)


@singledispatch
def residual_change(
    effect: Effect, reference: ReferenceState, sizes: Mapping[str, float]
) -> Array | None:
    """Return the change of the residuals by an effect of these sizes, (n, c).

    None where the log cannot show it, or the aircraft lacks the part that it changes. Each class of
    effects registers how it acts on a reference state.
    """
    return None


@residual_change.register
def _sensor_change(
    effect: SensorEffect, reference: ReferenceState, sizes: Mapping[str, float]
) -> Array | None:
    """The change by an effect on the sensors, which acts on the clean track."""
    clean = reference.clean
    if not all(name in clean for name in (*effect.needs, *effect.changes)):
        return None
    applied = effect.apply(Signals(clean.time, clean.channels), sizes)
    changed = {
        name: applied[name] for name in applied if applied[name] is not clean.channels.get(name)
    }
    moved = reference.change_by(clean.replaced(changed))
    return (
        moved + _by_throttles(reference, clean.replaced(changed))
        if THROTTLES & changed.keys()
        else moved
    )


def _by_throttles(reference: ReferenceState, track: Track) -> Array:
    """The change by other recorded throttles, on which the engines of the force meter run."""
    model = reference.force_model
    if model is None:
        return reference.blank()
    rows = coarse_rows(reference.clean)
    added = spread(model.replay.rows, rows, model.moved_by(motion_of(track, rows)))
    return change_by_answer(
        reference.base.names, reference.clean, reference.grid, model.replay.rows, added
    )


@residual_change.register
def _air_change(
    effect: AirEffect, reference: ReferenceState, sizes: Mapping[str, float]
) -> Array | None:
    """The change by an effect in the air: its wind, or its temperature."""
    if effect.wind is not None:
        wind = effect.wind(Signals(reference.clean.time, reference.clean.channels), sizes)
        at_instants = np.stack([reference.grid.smooth(np.asarray(part)) for part in wind], axis=1)
        return residuals_of_wind(at_instants, reference)
    baseline = NOWHERE if reference.force_model is None else reference.force_model.aircraft.baseline
    warmer = effect.overlay(sizes, baseline).temperature_offset
    return _warmed(reference, warmer) if warmer else None


@residual_change.register
def _aircraft_change(
    effect: AircraftEffect, reference: ReferenceState, sizes: Mapping[str, float]
) -> Array | None:
    """The change by an effect on the aircraft: its reaction less that without it, in one motion."""
    model = reference.force_model
    if model is None:
        return None
    if effect.part_of:  # the force meter knows states, no time
        whole, time = residual_change(FORMS[effect.part_of], reference, sizes), reference.clean.time
        share = share_of_size(effect, time[reference.grid.rows] - time[0], sizes)
        return whole if whole is None else whole * share[:, None]
    if not effect.fits(sizes, model.aircraft.baseline):
        return None
    overlay = effect.overlay(sizes, model.aircraft.baseline)
    split = _throttle_split(overlay)
    if split is not None:
        return _in_split(reference, split)
    if adds_forces(overlay):
        lost = -added_forces(overlay, model.units)
    else:
        missing = model.missing(overlay, not _spares_engines(overlay))
        lost = spread(model.replay.rows, coarse_rows(reference.clean), missing)
    return change_by_answer(
        reference.base.names, reference.clean, reference.grid, model.replay.rows, lost
    )


def _warmed(reference: ReferenceState, warmer: float) -> Array | None:
    """The change by a warmer column of air from standard pressure at sea level up.

    The pressure height is H_p = h T₀/(T₀ + ΔT).
    """
    height, temperature = reference.channel("pressure_height"), reference.channel("temperature")
    if height is None or temperature is None:
        return None
    lower = (
        reference.grid.smooth(reference.clean["altitude"])
        * warmer
        / (air.SEA_LEVEL_TEMPERATURE + warmer)
    )
    moved = reference.blank()
    moved[:, height] = -lower
    # the rise of temperature at the probe grows with Mach
    mach = reference.grid.smooth(mach_number(reference.clean))
    moved[:, temperature] = air.total_temperature(warmer - air.LAPSE_RATE * lower, mach)
    return moved


def _spares_engines(overlay: Overlay) -> bool:
    """Return whether an overlay only adds forces and moments of the air.

    Thrust then cancels in the difference.
    """
    elsewhere = [s for s in overlay.settings if not s.path.startswith(OF_THE_AIR)]
    return not (elsewhere or overlay.masses or overlay.forces or overlay.filters)


def moves_levers(overlay: Overlay) -> bool:
    """Whether an overlay sets nothing but the offset of the throttle plates from the levers."""
    return bool(overlay.settings) and all(
        setting.path in THROTTLE_BIAS for setting in overlay.settings
    )


def _throttle_split(overlay: Overlay) -> float | None:
    """Return the left less the right throttle plate's offset, None where nothing sets them.

    The log holds the positions of the plates, so that only their difference shows the offset.
    """
    if not moves_levers(overlay):
        return None
    paths = dict.fromkeys(setting.path for setting in overlay.settings)
    values = dict(overlay.sizes).values()
    return sum(THROTTLE_BIAS[path] * value for path, value in zip(paths, values, strict=False))


def _in_split(reference: ReferenceState, split: float) -> Array | None:
    column = reference.channel("throttle_split")
    if column is None:
        return None
    moved = reference.blank()
    moved[:, column] = split
    return moved


# Effects on recorded samples (repeats, steps, ceilings) are counted in the log checks and not
# fitted.
COUNTED = tuple(
    name
    for name, effect in EFFECTS.items()
    if isinstance(effect, SensorEffect) and effect.after_noise
)
# Every effect in all its forms; those for a part of the flight are looked at where the log makes
# them promising.
FITTED: Catalog[Effect] = Catalog(
    "effect",
    {name: form for name, form in FORMS.items() if (form.part_of or name) not in COUNTED},
    term_named,
)
WHOLE_FLIGHT: Catalog[Effect] = Catalog(
    "effect", {n: form for n, form in FITTED.items() if not form.part_of}
)

# Found by the level of the gusts, in addition to the effects that are fitted.
GUSTS = ("turbulence_level", "turbulence_scale")

EVENTS = ("at_s", FROM.name)  # the shapes of an effect that is an event: its time in the flight


def searched_shapes(effect: Effect) -> tuple[Parameter, ...]:
    """Return the shapes of an effect that are searched for: times, and all of another form.

    Another form is one of a cause. Of an effect for a part of the flight only its begin and end are
    searched for.
    """
    if effect.part_of:
        return tuple(p for p in effect.parameters if p in (FROM, TO))
    shapes = (p for p in effect.parameters if p.shape)
    return tuple(p for p in shapes if effect.variant_of or p.name.endswith("_s"))


def cause_of(name: str) -> str:
    """Return the effect of which this one is a form, else its name.

    A second-order line and a lag have one cause.
    """
    return FITTED[name].cause


def lasts(name: str) -> bool:
    """Return whether an effect acts over the whole flight, so that other flights have it too."""
    return not FITTED[name].part_of


def happens_once(name: str) -> bool:
    """Whether an effect is an event, with a time at which it happens."""
    return any(p.shape and p.name.endswith("_s") for p in FITTED[name].parameters)


def returns(name: str) -> bool:
    """Return whether an effect is to be seen in another flight: it lasts, and is no event."""
    return lasts(name) and not any(p.shape and p.name in EVENTS for p in FITTED[name].parameters)


def reads_gusts(name: str) -> bool:
    """Whether an effect is one of the flow vanes alone."""
    effect = FITTED[name]
    return isinstance(effect, SensorEffect) and set(effect.changes) <= set(VANES)
