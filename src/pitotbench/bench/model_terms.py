"""Hold the aerodynamic terms of a model against measured maneuvers, correct them, and fly the
maneuvers again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pitotbench.bench.identification import (
    align_vane,
    is_identification,
    maneuvers_of,
    read_identification,
)
from pitotbench.effects.airframe import coefficient_function
from pitotbench.effects.overlay import (
    AxisFunction,
    Baseline,
    Expression,
    FunctionScaling,
    Overlay,
    difference,
    product,
    size,
    total,
)
from pitotbench.reconciliation.term_regression import Regression, Term, regression_of, terms_of
from pitotbench.reconciliation.terms import judge_terms
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.records.terms import Maneuver, ManeuverGap, OpenLoopFlight, TermsAccount
from pitotbench.simulation.aircraft import find_aircraft, read_baseline
from pitotbench.simulation.force_meter import UNIT_AXES, measure_terms, unit_overlay
from pitotbench.simulation.open_loop import fly_open_loop
from pitotbench.simulation.plant import Plant

RATE = 100.0  # Hz, of the force meter
STEP = 0.05  # relative change of a function outside the axes, by which its own change of the forces is measured
ROOT = "model_terms"  # of the sizes in the overlay


@dataclass(frozen=True, slots=True)
class CorrectedModel:
    """What maneuvers say of a model's terms, and the overlay that corrects them; empty where none
    is off.
    """

    account: TermsAccount
    overlay: Overlay


def maneuvers_in(path: Path, read: Callable[[], FlightLog]) -> list[Maneuver]:
    """Return the maneuvers of a file: an array of system identification, else a flight log, which
    `read` reads.
    """
    return (
        [read_identification(path)] if is_identification(path) else maneuvers_of(read(), path.stem)
    )


def parted(maneuvers: Sequence[Maneuver]) -> tuple[list[Maneuver], list[Maneuver]]:
    """Return the maneuvers to fit, and every second one to hold out where there are at least two."""
    return list(maneuvers[::2]), list(maneuvers[1::2])


def correct_terms(
    aircraft: str, fitted: Sequence[Maneuver], held_out: Sequence[Maneuver]
) -> CorrectedModel:
    """Return which terms of an aircraft's file are off by how much, and what this closes on
    maneuvers held out.

    Raises BadInputError where the file has no term, UnknownNameError for an unknown aircraft.
    """
    baseline = read_baseline(find_aircraft(aircraft))
    terms = terms_of(baseline)
    if not terms:
        raise BadInputError(
            f"{aircraft}: its file has no aerodynamic function in an axis; nothing can be corrected"
        )
    some, lag = align_vane([*fitted, *held_out])
    regressions = [_regression(aircraft, terms, each) for each in some]
    remarks = _remarks(some, lag)
    account = judge_terms(
        aircraft, terms, regressions[: len(fitted)], regressions[len(fitted) :], remarks
    )
    overlay = _overlay(account, baseline)
    flown = [
        _flown(aircraft, overlay, maneuver, gap)
        for maneuver, gap in zip(some, account.maneuvers, strict=True)
        if maneuver.thrust is not None
    ]
    return CorrectedModel(replace(account, flown=tuple(flown)), overlay)


def _remarks(maneuvers: Sequence[Maneuver], lag: float) -> tuple[str, ...]:
    """What was corrected, and what was assumed because the logs lack it."""
    told = [f"The angle-of-attack vane lags by {lag:.2f} s; it was taken earlier."] if lag else []
    if any(each.thrust is None for each in maneuvers):
        told.append(
            "Thrust was not measured: in each maneuver a constant and a steady change of it are "
            "free, "
            "so the drag says less."
        )
    if any(each.mass is None for each in maneuvers):
        told.append(
            "Mass was not measured: it is the model's, and its error is one of every force."
        )
    if any("side force" not in each.channels for each in maneuvers):
        told.append("Sideslip was not measured: side force, roll and yaw are left out.")
    return tuple(told)


def _regression(aircraft: str, terms: Sequence[Term], maneuver: Maneuver) -> Regression:
    """A maneuver as a regression: one pass of the force meter, and one for each function outside
    the axes.
    """
    units = unit_overlay(UNIT_AXES)
    model = measure_terms(
        _plant(aircraft, units), maneuver.motion, [term.function.name for term in terms]
    )
    differences = {}
    for name in (term.function.name for term in terms if not term.function.axis):
        mean = float(np.mean(model.values[name]))  # it turns about its mean, as every slope does
        scaling = FunctionScaling(name, product(1.0 + STEP, 1.0), product(-STEP * mean, 1.0))
        moved = measure_terms(
            _plant(aircraft, units + Overlay(scalings=(scaling,))), maneuver.motion, []
        )
        differences[name] = (moved.total - model.total) / STEP
    return regression_of(maneuver, model, terms, differences)


def _plant(aircraft: str, overlay: Overlay) -> Plant:
    return Plant.load(aircraft, RATE, overlay, at_once=True)


def _overlay(account: TermsAccount, baseline: Baseline) -> Overlay:
    """The overlay that scales each function, and adds the constants about which the slopes turn."""
    sizes, functions, scalings = [], [], []
    axes = {function.name: function.axis for function in baseline.functions}
    for term in account.terms:
        own = term.function.rsplit("/", 1)[-1]
        change, zero, axis = size(ROOT, own), size(ROOT, f"{own}_zero"), axes[term.function]
        added: Expression = difference(1.0, 1.0)
        sizes.append((change, round(term.change.value, 4)))
        if term.function in account.zeros:
            sizes.append((zero, round(account.zeros[term.function], 5)))
            added = coefficient_function(axis, zero).value if axis else product(zero, 1.0)
        if axis:
            scaled = product(change, term.function)
            turned = term.function in account.zeros
            functions.append(AxisFunction(axis, total(scaled, added) if turned else scaled))
        else:
            scalings.append(FunctionScaling(term.function, total(1.0, change), added))
    return Overlay(sizes=tuple(sizes), functions=tuple(functions), scalings=tuple(scalings))


def _flown(aircraft: str, overlay: Overlay, maneuver: Maneuver, gap: ManeuverGap) -> OpenLoopFlight:
    """A maneuver flown with the measured controls by the model as it is, and by the corrected one."""
    measured, before = fly_open_loop(_plant(aircraft, Overlay()), maneuver, gap.constants[0])
    _, after = fly_open_loop(_plant(aircraft, overlay), maneuver, gap.constants[1])
    return OpenLoopFlight(
        maneuver.name, gap.held_out, maneuver.motion.time, measured, before, after
    )
