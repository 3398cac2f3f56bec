"""How strongly each effect shows on each card: signal-to-noise of its typical size, after what is not known.

`python -m tests.blind.signals` measures it on one flight of a development seed a card and writes `signals.json`.
The signal is the effect's signature (for a fault outside the table, the difference of a log with and without it),
whitened, with wind, error curve and sensor biases taken out.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from tests.blind.cards import CARDS
from tests.blind.forms import KNOWN_AND_HIDDEN
from tests.blind.outside import FAULTS

from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.null_learning import null_distribution_of
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS, Effect, SensorEffect
from pitotbench.reconcile.decide.normal_equations import equations_from, inner_products
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import Layout, lay_out
from pitotbench.reconcile.residuals.layout_noise import scaled_to
from pitotbench.reconcile.residuals.track import track_of
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.signatures import residual_change
from pitotbench.records.case import Case
from pitotbench.sense import record
from pitotbench.simulate import fly
from pitotbench.units import Array

PLACE = Path(__file__).with_name("signals.json")
SEED = 4001
GUSTS = ("turbulence_level", "turbulence_scale")
EVENTS = {"at_s": 150.0, "from_s": 110.0}
NO_EFFECTS: Catalog[Effect] = Catalog("effect", {"belly_pod": EFFECTS["belly_pod"]})


def typical(effect: Effect) -> dict[str, float]:
    """Typical sizes, an event in the midst of the flight."""
    return {name: EVENTS.get(name, value) for name, value in effect.typical().items()}


def strength(layout: Layout, noise: NoiseModel, moved: Array) -> float:
    """Signal-to-noise ratio of a change of the residuals."""

    def white(values: Array) -> Array:
        return noise.whiten(values, layout.grid, layout.residuals.slack)

    dense = white(layout.free.columns)
    products = inner_products(dense, white(moved), blocks=1)
    equations = equations_from(products, dense.shape[2], layout.free.deviations)
    return float(np.sqrt(max(0.0, equations.inner[-1, -1])))


def measured(card: Case) -> dict[str, float]:
    """The strength of every effect at its typical size on one card; 0 where nothing shows."""
    model, setting = aircraft_model(card.aircraft), AnalysisSetting(day_known=True)
    log = record(fly(replace(card, truth_seed=SEED, sensor_seed=SEED)), card.das, SEED)
    layout = lay_out(log, model, setting, NO_EFFECTS)
    noise = scaled_to(null_distribution_of(card).noise, layout)
    found = {}
    for effect in KNOWN_AND_HIDDEN.values():
        if effect.name in GUSTS or (isinstance(effect, SensorEffect) and effect.after_noise):
            continue
        moved = residual_change(effect, layout.scene, typical(effect))
        found[effect.name] = 0.0 if moved is None else strength(layout, noise, moved)
    for name, fault in FAULTS.items():
        other = layout.scene.residuals_of(track_of(fault(log, 1.0)))
        found[name] = strength(layout, noise, other.values - layout.residuals.values)
    return found


if __name__ == "__main__":
    table = {name: {k: round(v, 3) for k, v in measured(card).items()} for name, card in CARDS.items()}
    PLACE.write_text(json.dumps(table, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    print(f"written: {PLACE}")
