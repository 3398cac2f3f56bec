"""Causes outside the table: what is told of them, and how much of a held-out flight the formula
closes.

python -m tests.lab.outsiders [--only NAME] [--alone] With --alone the formula is looked for at
once, without the table and without null flights: ten times as fast. Every cause is flown twice on
different days: one log is explained, the other is held out. Null flights follow.
"""

import argparse
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from tests.reconciliation.outside_table import AREA, BETA, Outsider, flown, times
from tests.reconciliation.outside_table import OUTSIDERS as FIRST

from pitotbench.bench.workflow import FullReconciliation, NamedLog, formula_of, reconcile_fully
from pitotbench.catalog import Catalog
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.regression import Fitted
from pitotbench.reconciliation.verdict import Judged, hold_out, judge
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Closure
from pitotbench.show.gap_words import formula_sentences

INCH = 3386.39  # Pa
SPAN, CHORD = "aero/qbar-area-span", "aero/qbar-area-chord"
POWER = "propulsion/engine[0]/power-hp"


def _static(log: FlightLog, share: np.ndarray) -> FlightLog:
    """The static pressure too high by a share of the impact pressure."""
    error = share * log.impact_pressure
    return replace(
        log,
        static_pressure=log.static_pressure + error,
        impact_pressure=log.impact_pressure - error,
    )


def _horsepower(log: FlightLog) -> np.ndarray:
    """Manifold pressure times speed over that of the rating, about the share of the rated power."""
    return 0.5 * sum(
        log.channels()[f"manifold_pressure_{s}"]
        / (40.0 * INCH)
        * log.channels()[f"propeller_speed_{s}"]
        / 269.7
        for s in ("left", "right")
    )


def _mach(log: FlightLog) -> np.ndarray:
    return np.sqrt(
        5.0
        * ((np.maximum(log.impact_pressure, 0.0) / log.static_pressure + 1.0) ** (2.0 / 7.0) - 1.0)
    )


def _plus(name: str, error: Callable[[FlightLog], np.ndarray]) -> Callable[[FlightLog], FlightLog]:
    """An error of one channel that the log itself determines."""
    return lambda log: replace(log, **{name: getattr(log, name) + error(log)})


def _fuel(log: FlightLog) -> FlightLog:
    """Two fuel-flow transducers that read less at a high flow."""
    left, right = log.fuel_flow_left, log.fuel_flow_right
    return replace(log, fuel_flow_left=left - 5.0 * left**2, fuel_flow_right=right - 5.0 * right**2)


OUTSIDERS: Mapping[str, Outsider] = {
    **FIRST,
    "gear door that flutters": Outsider(
        "drag", {"DRAG": times(AREA, "aero/qbar-psf", "aero/qbar-psf", 1.5e-6)}
    ),
    "cowl flaps with power": Outsider("drag", {"DRAG": times(AREA, POWER, 3e-5)}),
    "wing shaded in sideslip": Outsider("lift", {"LIFT": times(AREA, BETA, BETA, -8.0)}),
    "thrust line": Outsider("pitch moment", {"PITCH": times(CHORD, POWER, 8e-5)}),
    "slipstream on the fin": Outsider("yaw moment", {"YAW": times(SPAN, POWER, 1.2e-5)}),
    "yaw by aileron": Outsider(
        "yaw moment", {"YAW": times(SPAN, "fcs/left-aileron-pos-rad", 0.03)}
    ),
    "static port behind the elevator": Outsider(
        "static pressure", sensor=lambda g: _static(g, 0.8 * (g.elevator - 0.02))
    ),
    "static port low in the bank": Outsider(
        "static pressure", sensor=lambda g: _static(g, 0.12 * np.sin(g.roll) ** 2)
    ),
    "receiver shaded on two sides": Outsider(
        "velocity north", sensor=_plus("velocity_north", lambda g: 0.5 * np.cos(2.0 * g.heading))
    ),
    "probe heated in slow air": Outsider(
        "temperature", sensor=_plus("total_temperature", lambda g: 25.0 * (0.25 - _mach(g)))
    ),
    "vane in the slipstream": Outsider(
        "sideslip", sensor=_plus("sideslip", lambda g: 0.04 * _horsepower(g))
    ),
    "gyro tilted in turns": Outsider(
        "pitch", sensor=_plus("pitch", lambda g: 0.06 * np.sin(g.roll) ** 2)
    ),
    "accelerometer tilted by side force": Outsider(
        "longitudinal acceleration",
        sensor=_plus("specific_force_x", lambda g: 0.12 * g.specific_force_y),
    ),
    "fuel flow low at high power": Outsider("fuel flow", sensor=_fuel),
    "gyro that feels the sideslip": Outsider(
        "pitch rate", sensor=_plus("pitch_rate", lambda g: 0.1 * g.sideslip)
    ),
}

FIRST_DAY, FIRST_NULL = 3000, 3900
NULLS = 6
ENOUGH = 0.8  # of the gap of the held-out flight


def explained(outsider: Outsider | None, number: int, folder: Path) -> FullReconciliation:
    """The reconciliation of a flight with a hidden cause, with another flight of it held out."""
    fit, held = (flown(outsider, number + i, folder) for i in (0, 1))
    logs = NamedLog("fit", fit), NamedLog("held out", held)
    return reconcile_fully(logs[0], "navajo", logs[1], refly=False, refly_holdout=False)


def alone(outsider: Outsider | None, number: int, folder: Path) -> Judged:
    """A flight by formulas alone, in the noise that its log shows, with another flight held out."""
    model, setting = aircraft_model("navajo"), AnalysisSetting(day_known=True)
    fit, held = (flown(outsider, number + i, folder) for i in (0, 1))
    layout = lay_out(fit, model, setting, Catalog("effect", {}))
    null = theoretical_distribution(layout)

    def close(fitted: Fitted) -> Closure | None:
        return hold_out(partial(lay_out, held, model, setting), null, fitted)

    return judge(["fit"], [layout], [null], held_out=close)


def main() -> None:
    """Print a line for each cause and each null flight, and the shares of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="causes whose name contains this")
    parser.add_argument("--alone", action="store_true", help="the formula alone, without the table")
    options = parser.parse_args()
    only = options.only
    causes: dict[str, tuple[Outsider | None, int]] = {
        name: (outsider, FIRST_DAY + 2 * i) for i, (name, outsider) in enumerate(OUTSIDERS.items())
    }
    causes |= {f"null {i}": (None, FIRST_NULL + 2 * i) for i in range(NULLS)}
    closed, right, wrong, told = [], 0, 0, 0
    print(
        "| hidden | verdict | named | formula | quantity | G fitted | G held out | CPU s |\n|"
        + "---|" * 8
    )
    with TemporaryDirectory() as folder:
        for name, (outsider, number) in causes.items():
            if only not in name:
                continue
            before = time.process_time()
            flight = outsider, number, Path(folder)
            judged = alone(*flight) if options.alone else explained(*flight).judged
            verdict, formula = judged.verdict, formula_of(judged)
            named = [e.name for e in verdict.effects]
            spent = time.process_time() - before
            quantities = {t.quantity for t in formula.terms} if formula else set()
            held = verdict.closure_holdout.share if formula and verdict.closure_holdout else 0.0
            if outsider is None:
                told += bool(formula or named)
            else:
                closed.append(held)
                wrong += bool(named)
                right += outsider.where in quantities
            text = formula_sentences(formula, "held out")[0] if formula else ""
            mark = (
                ""
                if outsider is None or formula is None
                else "right"
                if outsider.where in quantities
                else "other"
            )
            shares = f"{verdict.closure.share:.2f} | {held:.2f}" if formula else "| "
            cells = [name, verdict.kind, ", ".join(named), text, mark, shares, f"{spent:.0f}"]
            print(f"| {' | '.join(cells)} |", flush=True)
    if closed:
        enough = sum(g >= ENOUGH for g in closed)
        print(f"\nof {len(closed)}: closed {enough}, right quantity {right}, named {wrong}")
    print(f"nulls with a name or a formula: {told}")


if __name__ == "__main__":
    main()
