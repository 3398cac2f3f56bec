"""Formulas of forces and moments: what a coefficient of the airplane lacks, as a sum of terms."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from pitotbench.effects.effect import AircraftEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.expression import product, size, total
from pitotbench.effects.formula.coefficients import parameters_of
from pitotbench.effects.formula.terms import TERMS
from pitotbench.effects.overlay import AxisFunction, Baseline, Overlay

SOURCE = "Klein and Morelli 2006, Aircraft System Identification, ch. 5: coefficients as sums of regressors"
STATES = ("alpha", "alpha_squared", "sideslip", "sideslip_squared", "roll_rate", "pitch_rate", "yaw_rate")
CONTROLS = ("elevator", "aileron", "rudder")
AROUND = ("pressure", "pressure_squared", "power", "power_squared", "bank", "bank_squared", "height")
PRODUCTS = ("pressure_alpha", "power_alpha", "power_sideslip")
FORCE_TERMS = ("constant", *STATES, *CONTROLS, *AROUND, *PRODUCTS)


@dataclass(frozen=True, slots=True)
class Axis:
    """An aerodynamic axis: the symbol of its coefficient, a typical change, and its reference length, if any."""

    quantity: str
    symbol: str
    typical: float
    length: str = ""


AXES: Mapping[str, Axis] = {
    "DRAG": Axis("drag", "ΔC_D", 0.005),
    "SIDE": Axis("side force", "ΔC_Y", 0.01),
    "LIFT": Axis("lift", "ΔC_L", 0.02),
    "ROLL": Axis("roll moment", "ΔC_l", 0.002, "metrics/bw-ft"),
    "PITCH": Axis("pitch moment", "ΔC_m", 0.01, "metrics/cbarw-ft"),
    "YAW": Axis("yaw moment", "ΔC_n", 0.002, "metrics/bw-ft"),
}


def _build(name: str, axis: str, sizes: Mapping[str, float], baseline: Baseline) -> Overlay:
    used = {term: value for term, value in sizes.items() if value}
    parts = [product(size(name, term), TERMS[term].value) for term in used]
    coefficient = total(*parts) if len(parts) > 1 else parts[0]
    lengths = [AXES[axis].length] if AXES[axis].length else []
    force = product("aero/qbar-psf", "metrics/Sw-sqft", *lengths, coefficient)
    return Overlay(
        sizes=tuple((size(name, term), value) for term, value in used.items()),
        functions=(AxisFunction(axis, force),),
    )


def force_name(axis: str) -> str:
    """Return the name of the formula of an axis."""
    return f"{AXES[axis].quantity.replace(' ', '_')}_formula"


FORCE_AXES: Mapping[str, str] = {force_name(axis): axis for axis in AXES}
FORCE_FORMULAS: Mapping[str, AircraftEffect] = {
    name: AircraftEffect(
        name=name,
        family="airframe",
        acts_on="aircraft",
        parameters=parameters_of(FORCE_TERMS, "", AXES[axis].typical, AXES[axis].symbol),
        source=SOURCE,
        what=f"The airplane has a further {AXES[axis].quantity} that follows a formula.",
        shows_in=RANGE_OF_AIRSPEED,
        build=partial(_build, name, axis),
    )
    for name, axis in FORCE_AXES.items()
}
