"""What terms of a model's file are along a motion: coefficients with units, and as measured."""

from collections.abc import Iterable, Sequence

import numpy as np

from pitotbench import air
from pitotbench.effects import effect_of
from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.own_terms import AXIS_CHANNEL, NAMES, Term, terms_of
from pitotbench.effects.stability import CHANGE
from pitotbench.records.calibration import Estimate
from pitotbench.records.gap import Coefficient
from pitotbench.records.maneuver import CHANNELS
from pitotbench.records.motion import ModelForces, Motion
from pitotbench.records.verdict import Gap
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.unit_forces import measure_forces
from pitotbench.units import FOOT, POUND, STANDARD_GRAVITY, Array

UNITS = {
    **dict.fromkeys(("alpha", "sideslip", "elevator", "aileron", "rudder"), "per rad"),
    "p": "per p b/2V",
    "q": "per q c/2V",
    "r": "per r b/2V",
    "alpha_rate": "per α̇ c/2V",
}
FIELDS = {"p": "roll_rate", "q": "pitch_rate", "r": "yaw_rate", "alpha": "angle_of_attack"}
RATE = 25.0  # Hz, of the force meter: forces of the air alone are read


def coefficient(term: Term, forces: ModelForces, motion: Motion) -> tuple[float | None, str]:
    """Return the coefficient of a term over a motion, a slope or else the mean, with its unit.

    None where the model lacks it.
    """
    values, unit = values_of(term, forces, motion), UNITS.get(term.function.variable, "")
    if values is None:
        return None, ""
    if not unit:
        return float(np.mean(values)), ""
    regressor = _regressor(term.function.variable, motion, forces.wing)
    return float(np.polyfit(regressor, values, 1)[0]), unit


def values_of(term: Term, forces: ModelForces, motion: Motion) -> Array | None:
    """Return a term's coefficient along a motion: force or moment over pressure, area and length.

    None where the model lacks the term.
    """
    values = forces.values.get(term.function.name)
    if values is None or not term.function.axis:
        return values
    return np.asarray(values / coefficient_units(forces, motion)[AXIS_CHANNEL[term.axis]])


def coefficient_units(forces: ModelForces, motion: Motion) -> dict[str, Array]:
    """Return by channel the force or moment of a unit coefficient along a motion.

    It is pressure times area and length.
    """
    area, span, chord = forces.wing
    pressure = 0.7 * motion.static_pressure * motion.mach**2 / (POUND * STANDARD_GRAVITY) * FOOT**2
    arms = zip(CHANNELS, (1.0, 1.0, 1.0, span, chord, span), strict=True)
    return {name: pressure * area * arm for name, arm in arms}


def _regressor(variable: str, motion: Motion, wing: Sequence[float]) -> Array:
    """Return what a coefficient multiplies.

    An angle [rad], or a rate times half a length over the speed; `wing` is area [ft²], span and
    chord [ft].
    """
    rate = np.gradient(np.unwrap(motion.angle_of_attack), motion.time)
    value = rate if variable == "alpha_rate" else getattr(motion, FIELDS.get(variable, variable))
    if variable not in ("p", "q", "r", "alpha_rate"):
        return np.asarray(value)
    temperature = air.standard_temperature(air.pressure_altitude(motion.static_pressure))
    speed = motion.mach * air.sound_speed(temperature + motion.temperature_offset)
    length = wing[1] if variable in ("p", "r") else wing[2]
    return np.asarray(value * length * FOOT / (2.0 * speed))


def measured_coefficients(
    aircraft: str,
    motion: Motion,
    gaps: Iterable[Gap],
    agreeing: Iterable[tuple[str, Estimate]] = (),
) -> tuple[Coefficient, ...]:
    """Return the coefficients of a model along a motion, and the measured ones.

    First those of the first cause of each gap, then of effects that show no gap by their sizes; ()
    where none changes terms of the model's file.
    """
    firsts = [gap.causes[0] for gap in gaps if gap.causes]
    changes = [(c.name, s, True) for c in firsts for s in c.sizes if s.name.endswith(CHANGE)]
    changes += [(name, size, False) for name, size in agreeing]
    if not changes:
        return ()
    baseline = read_baseline(find_aircraft(aircraft))
    plant = Plant.load(aircraft, RATE, at_once=True)
    forces = measure_forces(plant, motion, [f.name for f in baseline.functions if f.name])
    found = list[Coefficient]()
    for name, size, has_gap in changes:
        effect = effect_of(name)
        if not isinstance(effect, AircraftEffect):
            continue
        changed = effect.overlay({size.name: 1.0}, baseline).functions_changed()
        terms = [term for term in terms_of(baseline) if term.function.name in changed]
        # A surface has forces as well: what it is called by is its moment.
        own = [t for t in terms if (t.axis, t.function.variable) in NAMES] or terms
        if each := [coefficient(term, forces, motion) for term in own]:
            value, unit = sum(value or 0.0 for value, _ in each), each[0][1]
            measured = Estimate(unit, value * (1.0 + size.value), abs(value) * size.two_sigma)
            found.append(Coefficient(name, size.name, value, measured, has_gap))
    return tuple(found)
