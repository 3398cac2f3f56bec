"""Formulas: effects whose sizes are coefficients of terms, for causes that the table does not hold."""

from pitotbench.catalog import Catalog
from pitotbench.effects.effect import Effect
from pitotbench.effects.formula.force_formulas import FORCE_FORMULAS
from pitotbench.effects.formula.sensor_formulas import SENSOR_FORMULAS

FORMULAS: Catalog[Effect] = Catalog("formula", {**FORCE_FORMULAS, **SENSOR_FORMULAS})
